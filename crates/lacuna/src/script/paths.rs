//! All ways through a script: a comparison of unknowns is answered both ways, in one run each.

use rhai::{Array, Dynamic, Map};

use super::engine::{Limits, Machine};
use super::graph::Id;
use super::tracer::{Relation, kind};
use super::trouble::stated as stated_error;
use crate::error::{Error, Result};

/// More rules than this, over all ways through a script, are refused: memory is limited.
const MOST_RULES: usize = 100_000;
/// How deep lists of rules may be nested.
const DEEPEST: usize = 16;

/// One call that states rules.
#[derive(Debug, Clone)]
pub(super) struct Entry {
    pub(super) function: &'static str,
    /// The link it is about, where it is about one.
    pub(super) link: Option<usize>,
    /// The second argument: a link, or all.
    pub(super) about: Dynamic,
    pub(super) with: Map,
}

/// One way through.
#[derive(Debug)]
pub(super) struct Way {
    pub(super) taken: Taken,
    pub(super) rules: Vec<Relation>,
}

/// Decisions of one way, in order: is the node not negative?
pub(super) type Taken = Vec<(Id, bool)>;

/// Calls `run` once for every way through what it runs; ways stand in order, `true` first.
pub(super) fn ways<T>(
    machine: &Machine,
    (runs, most): (&mut usize, usize),
    too_many: impl Fn() -> Error,
    mut run: impl FnMut() -> Result<T>,
) -> Result<Vec<(Taken, T)>> {
    let mut all: Vec<(Taken, T)> = Vec::new();
    let mut plan: Vec<bool> = Vec::new();
    loop {
        *runs += 1;
        if *runs > most {
            return Err(too_many());
        }
        machine.shared.borrow_mut().restart(plan);
        let result = run()?;
        let taken = std::mem::take(&mut machine.shared.borrow_mut().taken);
        plan = taken.iter().map(|t| t.1).collect();
        all.push((taken, result));
        while plan.last() == Some(&false) {
            plan.pop();
        }
        match plan.last_mut() {
            Some(last) => *last = false,
            None => return Ok(all),
        }
    }
}

/// Runs `entry` once for every way through it.
pub(super) fn explore(
    machine: &Machine,
    entry: &Entry,
    limits: &Limits,
    (runs, rules_seen): (&mut usize, &mut usize),
) -> Result<Vec<Way>> {
    let all = ways(
        machine,
        (runs, limits.runs),
        || too_many(machine, entry, limits),
        || {
            let stated = machine.state_rules(entry, limits.seconds)?;
            let rules = collect(machine, entry, &stated)?;
            let charged = machine.shared.borrow_mut().graph.charge(0);
            charged.map_err(|what| {
                let (line, column) = machine.place(entry.function);
                stated_error(what).at(line, column)
            })?;
            *rules_seen += rules.len();
            if *rules_seen > MOST_RULES {
                let (line, column) = machine.place(entry.function);
                return Err(Error::new(format!(
                    "the script states more than {MOST_RULES} rules, over all its ways"
                ))
                .at(line, column)
                .help("state fewer; `min(list)` and `max(list)` turn many numbers into one"));
            }
            Ok(rules)
        },
    )?;
    Ok(all.into_iter().map(|(taken, rules)| Way { taken, rules }).collect())
}

fn too_many(machine: &Machine, entry: &Entry, limits: &Limits) -> Error {
    let (line, column) = machine.place(entry.function);
    Error::new(format!("`{}` compares unknowns in more than {} combinations", entry.function, limits.runs))
        .at(line, column)
        .help("write `constrain_link`, which is asked link by link, or use `min`, `max`, `any_of`")
}

impl Machine {
    /// Where a function of the script stands.
    pub(super) fn place(&self, function: &str) -> (usize, usize) {
        self.dialect.functions.get(function).map_or((1, 1), |d| d.spot)
    }
}

/// The relations that a call returned; every relation it stated must be among them.
pub(super) fn collect(machine: &Machine, entry: &Entry, stated: &Dynamic) -> Result<Vec<Relation>> {
    let mut rules = Vec::new();
    gather(machine, entry, stated, DEEPEST, &mut rules)?;
    let mut tracer = machine.shared.borrow_mut();
    rules.iter().for_each(|r| tracer.use_up(r));
    if let Some((line, column)) = tracer.unused() {
        return Err(Error::new("this rule is stated but not returned, so it would be lost")
            .at(line, column)
            .help(format!(
                "`{}` returns all rules in one list, as the value of its last line",
                entry.function
            )));
    }
    Ok(rules)
}

fn gather(
    machine: &Machine,
    entry: &Entry,
    value: &Dynamic,
    depth: usize,
    rules: &mut Vec<Relation>,
) -> Result<()> {
    if let Some(relation) = value.read_lock::<Relation>() {
        rules.push(relation.clone());
        return Ok(());
    }
    if let (Some(list), true) = (value.read_lock::<Array>(), depth > 0) {
        return list.iter().try_for_each(|v| gather(machine, entry, v, depth - 1, rules));
    }
    Err(no_rule(machine, entry, value))
}

fn no_rule(machine: &Machine, entry: &Entry, value: &Dynamic) -> Error {
    let (function, place) = (entry.function, machine.place(entry.function));
    let plain = machine.shared.borrow().plain.filter(|_| value.is_bool());
    let (line, column) = plain.unwrap_or(place);
    let (what, help) = if value.is_unit() {
        (
            format!("`{function}` returns nothing"),
            "the value of its last line is what it returns: a list of rules; `[]` where none applies",
        )
    } else if value.is_bool() {
        (
            format!("`{function}` returns true or false in place of a rule"),
            "a comparison without unknowns is decided at once and restricts nothing: compare a link's mass, \
             com, inertia, ..",
        )
    } else {
        (
            format!("`{function}` returns {} in place of a rule", kind(value)),
            "rules are comparisons (`<=`, `>=`), `psd(..)`, `any_of(..)` or `margin(\"label\", x, \"unit\")`",
        )
    };
    Error::new(what).at(line, column).help(help)
}
