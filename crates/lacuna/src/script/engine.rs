//! The sandbox: an interpreter that can compute and nothing else, for a limited time.

use std::cell::RefCell;
use std::rc::Rc;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use rhai::packages::{ArithmeticPackage, BasicFnPackage, BasicIteratorPackage, BasicStringPackage, Package};
use rhai::{AST, Dynamic, Engine, OptimizationLevel};

use super::budget::Usage;
use super::dialect::Dialect;
use super::tracer::Shared;
use super::{arithmetic, compare, functions, trouble};
use crate::error::{Error, Result};
use crate::stop::Stop;

/// What a script may use up. The defaults are far more than any constraint needs.
#[derive(Debug, Clone)]
pub struct Limits {
    /// Time for everything the script ever does in a study, all threads together \[s\].
    pub seconds: f64,
    /// Operations of one run.
    pub operations: u64,
    /// Runs: one for every way through comparisons of unknowns.
    pub runs: usize,
    /// Set to stop the script from another thread.
    pub cancel: Option<Arc<AtomicBool>>,
    /// The work that it belongs to, which somebody may stop.
    pub stop: Stop,
    /// What it has used up before, to which is added.
    pub used: Usage,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            seconds: 10.0,
            operations: 500_000,
            runs: 4096,
            cancel: None,
            stop: Stop::default(),
            used: Usage::default(),
        }
    }
}

/// Words of rhai that scripts have no use for: files, code made at run time, output, and two constructs
/// that would hide a comparison or an error.
const FORBIDDEN: [&str; 9] =
    ["eval", "import", "export", "print", "debug", "switch", "try", "catch", "private"];

/// Longest list, with the lists in it. Lists nest no deeper, so that the stack holds what walks them.
pub(super) const MOST_ENTRIES: usize = 1000;
/// Longest text \[bytes\].
pub(super) const MOST_LETTERS: usize = 4096;

/// Operations between looks at the clock: one may add up a thousand long sums.
const CLOCK_EVERY: u64 = 8;

/// What stopped a script from outside, as the token of rhai's termination error.
pub(super) const OUT_OF_TIME: &str = "out of time";
/// The same, when somebody asked for it.
pub(super) const CANCELLED: &str = "cancelled";

/// A compiled script with its interpreter.
pub(super) struct Machine {
    pub(super) engine: Engine,
    pub(super) ast: AST,
    pub(super) dialect: Dialect,
    pub(super) shared: Shared,
    start: Instant,
    before: Duration,
    used: Usage,
}

impl Machine {
    /// Compiles `text`, which knows beside computing what `register` makes known; nothing runs yet.
    pub(super) fn new(
        text: &str,
        limits: &Limits,
        register: impl FnOnce(&mut Engine, &Shared),
    ) -> Result<Self> {
        let shared = Shared::default();
        shared.borrow_mut().graph.keep(limits.used.bytes());
        let dialect = Rc::new(RefCell::new(Dialect::default()));
        let start = Instant::now();
        let mut engine = sandbox(limits, start);
        let reader = dialect.clone();
        // "Deprecated" marks it as volatile; the version of rhai is pinned.
        #[allow(deprecated)]
        engine.on_parse_token(move |token, position, _| reader.borrow_mut().read(token, position));
        arithmetic::register(&mut engine, &shared);
        compare::register(&mut engine, &shared).map_err(Error::new)?;
        functions::register(&mut engine, &shared);
        register(&mut engine, &shared);
        let compiled = engine.compile(text);
        let dialect = std::mem::take(&mut *dialect.borrow_mut());
        let ast = compiled.map_err(|e| trouble::parsing(&e, &dialect))?;
        if let Some(stray) = ast.statements().first() {
            return Err(trouble::at(
                Error::new("this statement stands outside of all functions and would never run")
                    .help("put it into the function that needs it"),
                stray.position(),
            ));
        }
        let (used, before) = (limits.used.clone(), limits.used.time());
        Ok(Self { engine, ast, dialect, shared, start, before, used })
    }

    /// Whether there is time left for what is done with the script's results.
    pub(super) fn in_time(&self, limits: &Limits) -> Result<()> {
        if limits.is_cancelled() {
            return Err(trouble::cancelled());
        }
        let late = (self.before + self.start.elapsed()).as_secs_f64() > limits.seconds;
        if late { Err(trouble::out_of_time(limits.seconds)) } else { Ok(()) }
    }
}

impl Limits {
    fn is_cancelled(&self) -> bool {
        self.cancel.as_ref().is_some_and(|c| c.load(Ordering::Relaxed)) || self.stop.asked()
    }
}

impl Drop for Machine {
    fn drop(&mut self) {
        self.used.add_time(self.start.elapsed());
    }
}

fn sandbox(limits: &Limits, start: Instant) -> Engine {
    let mut engine = Engine::new_raw();
    ArithmeticPackage::new().register_into_engine(&mut engine);
    BasicFnPackage::new().register_into_engine(&mut engine);
    BasicIteratorPackage::new().register_into_engine(&mut engine);
    BasicStringPackage::new().register_into_engine(&mut engine);
    engine.set_optimization_level(OptimizationLevel::None);
    engine.set_fast_operators(false);
    engine.set_strict_variables(true);
    engine.set_fail_on_invalid_map_property(true);
    engine.set_max_operations(limits.operations);
    engine.set_max_call_levels(24);
    engine.set_max_expr_depths(64, 48);
    engine.set_max_string_size(MOST_LETTERS);
    engine.set_max_array_size(MOST_ENTRIES);
    engine.set_max_map_size(1000);
    engine.set_max_variables(256);
    engine.set_max_functions(64);
    engine.set_max_modules(0);
    for word in FORBIDDEN {
        engine.disable_symbol(word);
    }
    let budget = Duration::try_from_secs_f64(limits.seconds).unwrap_or_default();
    let (limits, before) = (limits.clone(), limits.used.time());
    engine.on_progress(move |operations| {
        if operations % CLOCK_EVERY != 0 {
            return None;
        }
        if limits.is_cancelled() {
            return Some(Dynamic::from(CANCELLED));
        }
        (before + start.elapsed() > budget).then(|| Dynamic::from(OUT_OF_TIME))
    });
    engine
}
