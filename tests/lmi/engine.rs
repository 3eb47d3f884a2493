//! The engine: published optima, feasibility, equalities, contradictions, stopping, repeatability.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use lacuna::form::{Affine, Body, Form};
use lacuna::retrieval::{LmiEngine, RetrievalEngine, Slack, audit, intervals};

use super::small::known;
use super::{panda, quiet};

/// Optimum with the repository's bounds, computed independently with two other solvers.
const REFERENCE: f64 = 3.726_204_8e-4;

#[test]
fn the_panda_optimum_is_reached_feasible_and_certified() {
    let problem = panda::problem(panda::C5Z_REPOSITORY);
    let found = LmiEngine::default().retrieve(&problem, &quiet).expect("it solves");
    let audit = audit(&problem, &found.z);
    let bound = found.lower_bound.expect("a bound");
    assert!(
        audit.feasible && audit.objective >= 3.7262e-4 && audit.objective <= 3.7265e-4,
        "{}",
        audit.objective
    );
    assert!((3.7261e-4..=3.72621e-4).contains(&bound) && bound <= REFERENCE, "{bound}");
    assert!(audit.objective - bound < 1e-5 * audit.objective, "certified to a thousandth of a per cent");
}

#[test]
fn the_printed_bound_costs_what_the_reference_says() {
    let problem = panda::problem(-0.05);
    let found = LmiEngine::default().retrieve(&problem, &quiet).expect("it solves");
    let audit = audit(&problem, &found.z);
    assert!(audit.feasible && (audit.objective - 3.86116e-4).abs() < 5e-9, "{}", audit.objective);
}

#[test]
fn the_same_bits_every_time_and_on_any_number_of_threads() {
    let problem = panda::problem(panda::C5Z_REPOSITORY);
    let space = lacuna::constraints::LinkSpace::new(&panda::robot(), &[]);
    let run = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
        pool.install(|| {
            let found = LmiEngine::default().retrieve(&problem, &quiet).expect("it solves");
            let level = Slack::default().level(problem.objective.value(&found.z));
            let ranges = intervals(&problem, level, &space.quantities()[..10]).expect("it solves");
            let ends = ranges.iter().flat_map(|r| [r.low, r.high]).map(|v| v.map(f64::to_bits));
            (found.z.iter().map(|v| v.to_bits()).collect::<Vec<_>>(), ends.collect::<Vec<_>>())
        })
    };
    assert_eq!(run(1), run(4));
}

#[test]
fn equalities_leave_no_margin_and_still_hold() {
    // Through the optimum, so that it stays one.
    let mut known = known(5, 5);
    let gap = known.z[0] - known.z[1];
    let row = Affine::variable(0).plus(-1.0, &Affine::variable(1)).plus(-gap, &Affine::constant(1.0));
    known.problem.forms.push(Form::affine("z0 - z1 >= gap", "", 1.0, row.clone()));
    known.problem.forms.push(Form::affine("z0 - z1 <= gap", "", 1.0, row.times(-1.0)));
    let found = LmiEngine::default().retrieve(&known.problem, &quiet).expect("it solves");
    let audit = audit(&known.problem, &found.z);
    assert!(audit.feasible, "{}", audit.violation);
    assert!((found.z[0] - found.z[1] - gap).abs() < 1e-9);
    let bound = found.lower_bound.expect("a bound");
    let close = |x: f64| (x / known.optimum - 1.0).abs() < 1e-6;
    assert!(close(audit.objective) && close(bound) && bound <= known.optimum, "{bound} {}", audit.objective);
}

#[test]
fn a_set_without_interior_is_solved_without_margin() {
    // [[z0, z1], [z1, 0]] is semidefinite only for z1 = 0: no margin is possible.
    let mut known = known(6, 5);
    let lower = vec![Affine::variable(0), Affine::variable(1), Affine::constant(0.0)];
    known.problem.forms = vec![Form::new("thin", "", 1.0, Body::Psd { size: 2, lower })];
    let solution = LmiEngine::default().solve(&known.problem, &quiet).expect("it solves");
    assert!(solution.margin.abs() < 1e-300);
    assert!(solution.z[1].abs() < 1e-4, "{:?}", solution.z);
}

#[test]
fn contradictions_are_named_and_nothing_else_is() {
    let mut known = known(7, 5);
    let at_least = |label: &str, sum: Affine| Form::affine(label, "kg", 1.0, sum);
    let (a, b) = (Affine::variable(0), Affine::variable(1));
    known.problem.forms.push(at_least("first", a.clone().plus(-1.0, &Affine::constant(3.0))));
    known.problem.forms.push(at_least("second", b.clone().plus(-1.0, &Affine::constant(3.0))));
    known.problem.forms.push(at_least("both", Affine::constant(5.0).plus(-1.0, &a).plus(-1.0, &b)));
    let error = LmiEngine::default().solve(&known.problem, &quiet).expect_err("impossible").to_string();
    assert!(error.contains("together"), "{error}");
    // None of the problem's other forms is needed for the conflict, so none is named.
    assert!(["first", "second", "both"].iter().all(|l| error.contains(&format!("`{l}`"))), "{error}");
    assert_eq!(error.matches('`').count(), 6, "{error}");
}

#[test]
fn numbers_and_settings_out_of_range_are_errors() {
    let mut known = known(8, 5);
    for engine in [
        LmiEngine { tolerance: 0.0, ..LmiEngine::default() },
        LmiEngine { margin: -1.0, ..LmiEngine::default() },
        LmiEngine { tolerance: f64::NAN, ..LmiEngine::default() },
        LmiEngine { iterations: 0, ..LmiEngine::default() },
    ] {
        assert!(engine.solve(&known.problem, &quiet).is_err(), "{engine:?}");
    }
    known.problem.objective.d[0] = f64::NAN;
    let error = LmiEngine::default().solve(&known.problem, &quiet).expect_err("not a number");
    assert!(error.to_string().contains("finite"), "{error}");
}

#[test]
fn it_stops_when_asked_and_keeps_what_it_has() {
    let problem = panda::problem(panda::C5Z_REPOSITORY);
    let steps = AtomicUsize::new(0);
    let watch = |_: &lacuna::retrieval::Step| {
        if steps.fetch_add(1, Ordering::Relaxed) < 3 {
            ControlFlow::Continue(())
        } else {
            ControlFlow::Break(())
        }
    };
    let found = LmiEngine::default().retrieve(&problem, &watch).expect("what it has");
    assert!(found.z.iter().all(|v| v.is_finite()));
    assert!(found.lower_bound.is_some_and(|b| (0.0..3.72621e-4).contains(&b)));
}

#[test]
fn it_reads_from_a_scenario() {
    let engine: Box<dyn RetrievalEngine> =
        lacuna::text::from_ron(r#"{"lmi": (label: "exact", tolerance: 1e-9)}"#).expect("it reads");
    assert_eq!((engine.name(), engine.label()), ("lmi", "exact"));
    let plain: Box<dyn RetrievalEngine> = lacuna::text::from_ron(r#"{"lmi": ()}"#).expect("it reads");
    assert_eq!(plain.label(), "lmi");
    assert!(lacuna::text::from_ron::<Box<dyn RetrievalEngine>>(r#"{"lmi": (tolerence: 1e-9)}"#).is_err());
}
