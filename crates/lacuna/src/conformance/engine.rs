//! Promises of an engine.

use std::ops::ControlFlow;
use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use super::must;
use crate::error::{Error, Result};
use crate::form::{Affine, Body, Form, General};
use crate::retrieval::catalogue::{self, EngineAbout};
use crate::retrieval::{Identity, Problem, Quadratic, RetrievalEngine, Retrieved, Step, audit};
use crate::space::{Parameter, Space};
use crate::text;

/// A small problem whose answer is known.
struct Known {
    name: &'static str,
    problem: Problem,
    best: f64,
}

/// Checks an engine as a scenario writes it (`{"penalty": ()}`) on small problems with known answers: that
///
/// - it explains itself and the settings that it has, gives an example of itself, and both the example and `ron`
///   survive being written and read again under the name it gives;
/// - it answers for every form whether it takes it; problems with forms that it refuses are left out;
/// - it ends feasible (audited, violation at most 1e-9) and within `accuracy` of the best objective, as a
///   part of the objective's size at the start;
/// - its lower bound, where it gives one, is none above the best objective;
/// - the same problem gives the same bits again;
/// - when it is asked to stop it does, and still returns a point.
///
/// An engine that this build cannot run ([`RetrievalEngine::available`]) is not run. Returns the names of
/// the problems that it solved.
///
/// # Errors
/// With the first promise that is broken, and the problem.
pub fn engine(ron: &str, accuracy: f64) -> Result<Vec<&'static str>> {
    let first: Box<dyn RetrievalEngine> = text::from_ron(ron)?;
    explains_itself(first.as_ref())?;
    gives_an_example(&first.about())?;
    let second = again(first.as_ref())?;
    must(!first.label().is_empty() && first.label() == second.label(), || {
        "its label is empty or lost".into()
    })?;
    if first.available().is_err() {
        return Ok(Vec::new());
    }
    let mut solved = Vec::new();
    for known in problems() {
        let refused = known.problem.forms.iter().find_map(|form| first.accepts(form).err());
        if let Some(reason) = refused {
            must(!reason.trim().is_empty(), || {
                format!("{}: it refuses a form without a reason", known.name)
            })?;
            continue;
        }
        solves(first.as_ref(), second.as_ref(), &known, accuracy)?;
        solved.push(known.name);
    }
    must(!solved.is_empty(), || "it takes none of the problems, not even one with affine forms only".into())?;
    Ok(solved)
}

fn explains_itself(engine: &dyn RetrievalEngine) -> Result<()> {
    let about = engine.about();
    let name = about.name;
    for (what, said) in [("title", about.title), ("text", about.text), ("word on what it takes", about.takes)]
    {
        must(!said.trim().is_empty(), || format!("{name} has no {what}"))?;
    }
    must(engine.name() == name, || format!("`{}` calls itself `{name}`", engine.name()))?;
    let settings = catalogue::usual_settings(engine)?;
    let absent =
        about.settings.iter().find(|(known, _)| !settings.iter().any(|(setting, _)| setting == known));
    must(absent.is_none(), || {
        format!(
            "{name} explains the setting `{}`, which it has not",
            absent.map_or("", |(setting, _)| setting)
        )
    })
}

/// What it writes of itself, read again under the name that it gives itself.
fn again(engine: &dyn RetrievalEngine) -> Result<Box<dyn RetrievalEngine>> {
    let (name, written) = (engine.name(), text::to_ron(&engine)?);
    must(written.contains(&format!("\"{name}\"")), || {
        format!("its name in RON is not `{name}`, the one it gives itself: {written}")
    })?;
    text::from_ron(&written).map_err(|e| {
        Error::new(format!("what it writes cannot be read again: {}", e.message())).help(written)
    })
}

/// The example is an entry of this very engine.
fn gives_an_example(about: &EngineAbout) -> Result<()> {
    let wrong =
        |what: String| Error::new(format!("the example of {} {what}", about.name)).help(about.example);
    let example: Box<dyn RetrievalEngine> =
        text::from_ron(about.example).map_err(|e| wrong(format!("cannot be read: {}", e.message())))?;
    if example.name() != about.name {
        return Err(wrong(format!("is one of `{}`", example.name())));
    }
    again(example.as_ref()).map(drop).map_err(|e| wrong(e.message().to_string()))
}

fn run(engine: &dyn RetrievalEngine, known: &Known, stop: bool) -> Result<Retrieved> {
    let flow = if stop { ControlFlow::Break(()) } else { ControlFlow::Continue(()) };
    let retrieved = engine.retrieve(&known.problem, &move |_: &Step| flow)?;
    let (name, expected) = (known.name, known.problem.space.len());
    must(retrieved.z.len() == expected && retrieved.z.iter().all(|x| x.is_finite()), || {
        format!("{name}: it returns {:?}, not {expected} finite numbers", retrieved.z)
    })?;
    must(!retrieved.status.is_empty(), || format!("{name}: it does not say how it ended"))?;
    Ok(retrieved)
}

fn solves(
    first: &dyn RetrievalEngine,
    second: &dyn RetrievalEngine,
    known: &Known,
    accuracy: f64,
) -> Result<()> {
    let name = known.name;
    let found = run(first, known, false)?;
    let judged = audit(&known.problem, &found.z);
    must(judged.feasible, || format!("{name}: its answer violates the forms by {:.3e}", judged.violation))?;
    let size = known.problem.objective.value(&vec![0.0; known.problem.space.len()]).max(known.best);
    let excess = judged.objective - known.best;
    must(excess <= accuracy * size, || {
        format!("{name}: objective {:.9e}, the best is {:.9e}", judged.objective, known.best)
    })?;
    must(excess >= -1e-7 * size, || {
        format!("{name}: objective {:.9e} is below the best, {:.9e}", judged.objective, known.best)
    })?;
    if let Some(bound) = found.lower_bound {
        must(bound <= known.best + 1e-9 * size, || {
            format!("{name}: its lower bound {bound:.9e} is above the best objective {:.9e}", known.best)
        })?;
    }
    must(!found.stopped, || format!("{name}: it says that it was stopped, but nobody asked it to"))?;
    let again = run(second, known, false)?;
    let bits = |r: &Retrieved| r.z.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
    must(bits(&found) == bits(&again), || format!("{name}: the same problem gives another answer"))?;
    run(first, known, true).map(|_| ())
}

fn problems() -> Vec<Known> {
    vec![simplex(), ball(), matrix(), ring()]
}

fn problem(n: usize, target: &[f64], forms: Vec<Form>) -> Problem {
    let mut space = Space::default();
    for i in 0..n {
        space.push_group(format!("group{i}"), [Parameter::free(format!("x{i}"), "1").within(-4.0, 4.0)]);
    }
    let (r, d) = (DMatrix::identity(n, n), DVector::from_row_slice(target));
    let objective = Quadratic { r, d, floor: 0.0, unit: "1".into() };
    Problem { space: space.clone(), objective, forms, chart: Box::new(Identity { space }), seed: 7 }
}

/// The point of the simplex `x >= 0, sum x <= 1` nearest to (1, 1, -1, 0.5): thresholding gives
/// (0.5, 0.5, 0, 0), at squared distance 0.25 + 0.25 + 1 + 0.25.
fn simplex() -> Known {
    let mut forms: Vec<Form> =
        (0..4).map(|i| Form::affine(format!("x{i} >= 0"), "1", 1.0, Affine::variable(i))).collect();
    let all = (0..4).fold(Affine::constant(1.0), |sum, i| sum.plus(-1.0, &Affine::variable(i)));
    forms.push(Form::affine("sum <= 1", "1", 1.0, all));
    Known { name: "simplex", problem: problem(4, &[1.0, 1.0, -1.0, 0.5], forms), best: 1.75 }
}

/// The point of the unit ball nearest to (2, 1, 2): at distance 2.
fn ball() -> Known {
    let rows = (0..3).map(Affine::variable).collect();
    let form = Form::new("ball", "1", 1.0, Body::Norm { rows, bound: Affine::constant(1.0) });
    Known { name: "ball", problem: problem(3, &[2.0, 1.0, 2.0], vec![form]), best: 4.0 }
}

/// The positive semidefinite `[[a, b], [b, c]]` nearest to `[[1, 2], [2, 1]]`, off-diagonal counted once:
/// a = c by symmetry and b = a on the border, so (a - 1)² 2 + (a - 2)² is least at a = 4/3, where it is 2/3.
fn matrix() -> Known {
    let lower = (0..3).map(Affine::variable).collect();
    let form = Form::new("psd", "1", 1.0, Body::Psd { size: 2, lower });
    Known { name: "matrix", problem: problem(3, &[1.0, 2.0, 1.0], vec![form]), best: 2.0 / 3.0 }
}

/// The point outside the unit disc and within radius 2 nearest to (0.6, 0): (1, 0).
fn ring() -> Known {
    let rows = (0..2).map(Affine::variable).collect::<Vec<_>>();
    let within = Form::new("within", "1", 2.0, Body::Norm { rows, bound: Affine::constant(2.0) });
    let body = Body::General {
        function: Arc::new(Outside),
        why: "what lies outside a disc is not convex".into(),
        implied: Vec::new(),
    };
    let forms = vec![within, Form::new("outside", "1", 1.0, body)];
    Known { name: "ring", problem: problem(2, &[0.6, 0.0], forms), best: 0.16 }
}

/// `x0² + x1² - 1`.
#[derive(Debug)]
struct Outside;

impl General for Outside {
    fn support(&self) -> Vec<usize> {
        vec![0, 1]
    }

    fn margin(&self, z: &[f64]) -> f64 {
        z[0] * z[0] + z[1] * z[1] - 1.0
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        (self.margin(z), vec![2.0 * z[0], 2.0 * z[1]])
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::retrieval::catalogue;

    #[test]
    fn the_known_answers_are_feasible_and_no_random_point_beats_them() {
        let answers: [&[f64]; 4] =
            [&[0.5, 0.5, 0.0, 0.0], &[2.0 / 3.0, 1.0 / 3.0, 2.0 / 3.0], &[4.0 / 3.0; 3], &[1.0, 0.0]];
        let mut stream = crate::random::Stream::new(3, 0);
        for (known, answer) in problems().iter().zip(answers) {
            let judged = audit(&known.problem, answer);
            assert!(judged.violation < 1e-12, "{}", known.name);
            assert!((judged.objective - known.best).abs() < 1e-12, "{}", known.name);
            for _ in 0..4000 {
                let z: Vec<f64> = answer.iter().map(|x| x + stream.between(-0.5, 0.5)).collect();
                let judged = audit(&known.problem, &z);
                assert!(!judged.feasible || judged.objective >= known.best, "{} at {z:?}", known.name);
            }
        }
    }

    #[test]
    fn every_engine_keeps_its_promises_as_its_example_writes_it() {
        for about in &catalogue::CATALOGUE {
            let solved = engine(about.example, 1e-4).unwrap_or_else(|e| panic!("{}: {e}", about.example));
            let runs = catalogue::engine(about.name).is_ok_and(|engine| engine.available().is_ok());
            assert_eq!(solved.is_empty(), !runs, "{}: {solved:?}", about.name);
        }
    }
}
