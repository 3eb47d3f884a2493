//! Scripts: rules on link parameters ([`Script`]) and effects ([`EffectScript`]) that need no compiler.
//!
//! A script runs on numbers that remember how they were made, once for every way through its comparisons of
//! unknowns. What comes out are [`Form`]s: affine, norm and semidefinite ones where a cone expresses the
//! rule, else a flat program with exact gradient. Nothing is interpreted while an engine searches.

mod alternatives;
mod arithmetic;
mod budget;
mod compare;
mod conic;
mod dialect;
mod dimension;
mod effect;
mod elementary;
mod engine;
mod functions;
mod graph;
mod paths;
mod print;
mod program;
mod rules;
mod settings;
mod subject;
mod tracer;
mod trouble;

pub use budget::Usage;
pub(crate) use budget::{Clock, MOST_BYTES};
pub use effect::{EffectAbout, EffectParameter, EffectScript, EffectShape, Input, JointColumns};
pub use engine::Limits;
pub use functions::FUNCTIONS;
pub use settings::{Setting, Settings};
pub use subject::{Body, PROPERTIES, Subject};

use std::ops::Range;
use std::path::{Path, PathBuf};
use std::rc::Rc;

use rhai::{CallFnOptions, Dynamic, Engine, Map, Scope};

use crate::error::{Error, Result};
use crate::form::Form;
use engine::Machine;
use paths::Entry;
use subject::{LinkView, RobotView, link_list};
use tracer::Shared;

/// Longer scripts are not read [bytes].
const LONGEST: usize = 1 << 18;

/// The functions that a script may define to state rules, with their arguments.
const ENTRIES: [(&str, usize, &str); 3] = [
    ("constrain", 3, "fn constrain(robot, links, with)"),
    ("constrain_link", 3, "fn constrain_link(robot, link, with)"),
    ("settings", 0, "fn settings()"),
];

/// A script as text.
#[derive(Debug, Clone)]
pub struct Script {
    file: PathBuf,
    text: String,
}

/// One rule of a script and its forms.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct LoweredRule {
    /// For people.
    pub label: String,
    /// Line and column where the script states it.
    pub place: (usize, usize),
    /// Its forms in [`Lowered::forms`]; they hold together exactly where the rule does.
    pub forms: Range<usize>,
}

/// What a script means.
#[derive(Debug, Clone)]
pub struct Lowered {
    /// All forms.
    pub forms: Vec<Form>,
    /// The rules, in the order in which they are stated.
    pub rules: Vec<LoweredRule>,
    /// How often the script ran: one for every way through its comparisons of unknowns.
    pub runs: usize,
    /// The settings that were in force.
    pub settings: Settings,
}

impl Script {
    /// Reads a script file.
    ///
    /// # Errors
    /// When it cannot be read.
    pub fn open(path: &Path) -> Result<Self> {
        Ok(Self::new(path, crate::text::read(path)?))
    }

    /// A script from memory; `file` names it in messages and labels.
    pub fn new(file: impl Into<PathBuf>, text: impl Into<String>) -> Self {
        Self { file: file.into(), text: text.into() }
    }

    /// The file's name in messages.
    pub fn file(&self) -> &Path {
        &self.file
    }

    /// What the script means for `subject`, with the settings `with` in place of the script's own.
    ///
    /// # Errors
    /// With file, line and column when the script is not one, does not stop, states no rule, states one and
    /// does not return it, or returns something else; and when a setting is unknown or of the wrong kind.
    pub fn lower(&self, subject: &Subject, with: &Settings, limits: &Limits) -> Result<Lowered> {
        let lower = || {
            let (machine, settings) = self.machine(subject, with, limits)?;
            rules::lower(&machine, &self.calls(&machine, subject, &settings), subject, &self.stem(), limits)
                .map(|lowered| Lowered { settings, ..lowered })
        };
        lower().map_err(|e: Error| e.in_file(&self.file))
    }

    /// The script's own settings: what `with` may change. Its rules are not run.
    ///
    /// # Errors
    /// As [`Script::lower`], for what shows without a robot.
    pub fn settings(&self) -> Result<Settings> {
        let (_, settings) = self
            .machine(&Subject::default(), &Settings::new(), &Limits::default())
            .map_err(|e| e.in_file(&self.file))?;
        Ok(settings)
    }

    /// An interpreter that computes every rule's margin at given points, branches and all: the oracle that
    /// the lowered forms are tested against, and 10 to 100 times slower than they are.
    ///
    /// # Errors
    /// As [`Script::lower`].
    pub fn interpreter(&self, subject: &Subject, with: &Settings, limits: &Limits) -> Result<Interpreter> {
        let (machine, settings) = self.machine(subject, with, limits).map_err(|e| e.in_file(&self.file))?;
        let calls = self.calls(&machine, subject, &settings);
        Ok(Interpreter { machine, calls, seconds: limits.seconds })
    }

    fn stem(&self) -> String {
        self.file.file_stem().unwrap_or_default().to_string_lossy().into_owned()
    }

    fn machine(&self, subject: &Subject, with: &Settings, limits: &Limits) -> Result<(Machine, Settings)> {
        let subject = Rc::new(subject.clone());
        let machine = self.compile(limits, |engine, shared| {
            shared.borrow_mut().names.clone_from(&subject.unknowns);
            subject::register(engine, shared, &subject);
        })?;
        check_entries(&machine)?;
        let settings = machine.settings(with, limits)?;
        Ok((machine, settings))
    }

    fn compile(&self, limits: &Limits, register: impl FnOnce(&mut Engine, &Shared)) -> Result<Machine> {
        if self.text.len() > LONGEST {
            return Err(Error::new(format!("the script is longer than {LONGEST} bytes"))
                .help("no rule needs so much: name the right file"));
        }
        Machine::new(&self.text, limits, register)
    }

    /// The calls that state the rules: once for the whole robot, once for every chosen link.
    fn calls(&self, machine: &Machine, subject: &Subject, settings: &Settings) -> Vec<Entry> {
        let with: Map = settings.iter().map(|(k, v)| (k.as_str().into(), v.value())).collect();
        let mut calls = Vec::new();
        let defines = |name: &str| machine.dialect.functions.contains_key(name);
        if defines("constrain") {
            let links = Dynamic::from_array(link_list(subject.chosen.iter().copied()));
            calls.push(Entry { function: "constrain", link: None, about: links, with: with.clone() });
        }
        if defines("constrain_link") {
            calls.extend(subject.chosen.iter().map(|&link| Entry {
                function: "constrain_link",
                link: Some(link),
                about: Dynamic::from(LinkView(link)),
                with: with.clone(),
            }));
        }
        calls
    }
}

fn check_entries(machine: &Machine) -> Result<()> {
    for (name, arguments, signature) in ENTRIES {
        if let Some(defined) = machine.dialect.functions.get(name)
            && defined.arguments.len() != arguments
        {
            return Err(Error::new(format!("`{name}` takes {arguments} arguments"))
                .at(defined.spot.0, defined.spot.1)
                .help(format!("write `{signature}`")));
        }
    }
    if ENTRIES[..2].iter().all(|(name, ..)| !machine.dialect.functions.contains_key(*name)) {
        let names: Vec<&str> = machine.dialect.functions.keys().map(String::as_str).collect();
        let found =
            if names.is_empty() { "no function".into() } else { format!("only {}", names.join(", ")) };
        return Err(Error::new(format!("the script defines {found}, but no rules")).at(1, 1).help(
            "write `fn constrain(robot, links, with) { [ .. ] }` for the whole robot or \
             `fn constrain_link(robot, link, with) { [ .. ] }` for every link",
        ));
    }
    Ok(())
}

impl Machine {
    /// The script's settings with those of `with` in their place.
    fn settings(&self, with: &Settings, limits: &Limits) -> Result<Settings> {
        let own = match self.dialect.functions.contains_key("settings") {
            true => settings::own(self, self.call("settings", (), limits.seconds)?)?,
            false => Settings::default(),
        };
        settings::merge(own, with)
    }

    /// Calls a function of the script.
    fn call(&self, function: &str, arguments: impl rhai::FuncArgs, seconds: f64) -> Result<Dynamic> {
        let options = CallFnOptions::new().eval_ast(false);
        let mut scope = Scope::new();
        self.engine.call_fn_with_options(options, &mut scope, &self.ast, function, arguments).map_err(|e| {
            let error = trouble::running(&e, &self.dialect, seconds);
            // The interpreter has no place for what only took too long.
            if error.place().is_some() {
                return error;
            }
            let start = self.dialect.functions.get(function).map_or((1, 1), |d| d.spot);
            let (line, column) = if let [only] = self.dialect.repeats.as_slice() { *only } else { start };
            error.at(line, column)
        })
    }

    fn state_rules(&self, entry: &Entry, seconds: f64) -> Result<Dynamic> {
        let arguments = (RobotView, entry.about.clone(), entry.with.clone());
        self.call(entry.function, arguments, seconds)
    }
}

/// A script that is run anew for every point.
pub struct Interpreter {
    machine: Machine,
    calls: Vec<Entry>,
    seconds: f64,
}

impl Interpreter {
    /// Line and column of every rule that applies at the unknowns `z`, and its margin there, in the order in
    /// which the script states them.
    ///
    /// # Errors
    /// When a value is not a number there.
    pub fn margins(&self, z: &[f64]) -> Result<Vec<((usize, usize), f64)>> {
        let mut all = Vec::new();
        for entry in &self.calls {
            self.machine.shared.borrow_mut().restart_at(z);
            let stated = self.machine.state_rules(entry, self.seconds)?;
            for relation in paths::collect(&self.machine, entry, &stated)? {
                all.push((relation.spot, self.machine.shared.borrow_mut().margin_at_point(&relation)?));
            }
        }
        Ok(all)
    }
}
