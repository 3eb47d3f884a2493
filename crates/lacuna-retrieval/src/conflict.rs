//! Constraints that contradict each other: a smallest set of them that no parameters satisfy together.

use super::certificate::taken;
use super::cone::{Effort, Ending, Outcome, Program};
use super::lmi::{Place, constrain};
use crate::form::{Affine, Form};
use lacuna_base::error::{Error, Result};

/// Part of the largest multiplier below which a form plays no part in the proof of a contradiction.
const IDLE: f64 = 1e-7;

/// Constraints that cannot hold together, while dropping any one of them leaves the others possible.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Conflict {
    /// Labels of the forms, in the order of the problem.
    pub constraints: Vec<String>,
}

impl Conflict {
    /// As an error, for callers that cannot go on.
    pub fn into_error(self) -> Error {
        let names: Vec<String> = self.constraints.iter().map(|label| format!("`{label}`")).collect();
        Error::new(format!("no parameters satisfy these constraints together: {}", names.join(", ")))
            .help("loosen or remove one of them; dropping any one makes the others possible")
    }
}

/// A smallest conflicting set among `forms`, or `None` when their convex part has a common point (then the
/// others may still contradict each other: nobody can tell in general).
///
/// The solver's proof that there is no common point (Farkas' multipliers) says which forms take part; of
/// those, each that can go goes (Chinneck and Dravnieks 1991, deletion filter).
///
/// # Errors
/// When a number is not finite.
pub fn conflict(unknowns: usize, forms: &[Form]) -> Result<Option<Conflict>> {
    let all: Vec<&Form> = forms.iter().collect();
    let Some((outcome, places)) = common_point(unknowns, &all)? else { return Ok(None) };
    if outcome.ending != Ending::Infeasible {
        return Ok(None);
    }
    let mut core = pressed(&all, &outcome, &places);
    if !impossible(unknowns, &core)? {
        core = all;
    }
    let mut next = 0;
    while next < core.len() {
        let mut fewer = core.clone();
        fewer.remove(next);
        if impossible(unknowns, &fewer)? {
            core = fewer;
        } else {
            next += 1;
        }
    }
    Ok(Some(Conflict { constraints: core.iter().map(|form| form.label.clone()).collect() }))
}

fn impossible(unknowns: usize, forms: &[&Form]) -> Result<bool> {
    let found = common_point(unknowns, forms)?;
    Ok(found.is_some_and(|(outcome, _)| outcome.ending == Ending::Infeasible))
}

/// Looks for a point that satisfies the convex part of all forms; `None` when there is nothing to satisfy.
fn common_point(unknowns: usize, forms: &[&Form]) -> Result<Option<(Outcome, Vec<Place>)>> {
    let convex: Vec<&Form> = forms.iter().flat_map(|form| taken(std::slice::from_ref(*form))).collect();
    if convex.is_empty() {
        return Ok(None);
    }
    let mut program = Program::new(unknowns);
    let places = constrain(&mut program, &convex, &Affine::constant(0.0));
    Ok(Some((program.solve(Effort::default(), None)?, places)))
}

/// The forms whose multipliers are not nothing.
fn pressed<'a>(forms: &[&'a Form], outcome: &Outcome, places: &[Place]) -> Vec<&'a Form> {
    let size = |place: &Place| outcome.duals[place.block].iter().fold(0.0, |m: f64, y| m.max(y.abs()));
    let largest = places.iter().map(size).fold(0.0, f64::max);
    let mut places = places.iter();
    let parts = |form: &Form| taken(std::slice::from_ref(form)).len();
    let mut pressed = Vec::new();
    for form in forms {
        // Every form takes its own places, so the iterator must move on for idle ones too.
        let own = places.by_ref().take(parts(form)).map(size).fold(0.0, f64::max);
        if own > IDLE * largest {
            pressed.push(*form);
        }
    }
    pressed
}
