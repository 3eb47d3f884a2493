//! The constraints as scenarios write them: `scenarios/panda_bounds.ron`, whose bounds on inertia are not convex.

use std::path::Path;

use lacuna::constraints::{self, Constraint, LinkSpace, search_space};
use lacuna::retrieval::{Audit, LmiEngine, Problem, RetrievalEngine, audit};

use super::{panda, quiet};

/// With the shipped bounds and `extra` constraints in RON.
fn problem(extra: &[&str]) -> Problem {
    let robot = panda::robot();
    let space = LinkSpace::new(&robot, &[]);
    let mut all = constraints::open(Path::new("scenarios/panda_bounds.ron")).expect("they read");
    let extra = extra.iter().map(|ron| lacuna::text::from_ron::<Box<dyn Constraint>>(ron).expect("it reads"));
    all.extend(extra);
    Problem {
        objective: panda::objective(&robot),
        forms: constraints::forms(&robot, &space, &all).expect("they fit"),
        chart: Box::new(search_space(&robot, &space, &all).expect("it is bounded").chart),
        space: space.space,
        seed: 1,
    }
}

/// Objective, audited, and the lower bound.
fn solved(problem: &Problem) -> (Audit, f64) {
    let found = LmiEngine::default().retrieve(problem, &quiet).expect("it solves");
    (audit(problem, &found.z), found.lower_bound.expect("a bound"))
}

#[test]
fn the_optimum_is_certified_for_the_whole_problem_in_few_iterations() {
    let problem = problem(&[]);
    assert!(problem.forms.iter().any(|form| !form.is_convex()));
    let (audit, bound) = solved(&problem);
    // Feasible for all forms, those included that were left out: then it is the optimum of the whole.
    assert!(audit.feasible, "{}", audit.violation);
    assert!((3.7262e-4..=3.7265e-4).contains(&audit.objective), "{}", audit.objective);
    assert!((3.7261e-4..=3.72621e-4).contains(&bound) && bound <= audit.objective, "{bound}");
    // Each iteration takes some 0.2 ms (`cargo bench --bench retrieval`).
    let iterations = LmiEngine::default().solve(&problem, &quiet).expect("it solves").iterations;
    assert!((5..=40).contains(&iterations), "{iterations} iterations");
}

#[test]
fn a_margin_on_the_pseudo_inertia_costs_what_the_reference_says() {
    for (margin, expected) in [(1e-7, 3.726_309e-4), (1e-6, 3.727_244e-4)] {
        let (audit, _) = solved(&problem(&[&format!("{{\"pseudo_inertia\": (margin: {margin:e})}}")]));
        assert!(audit.feasible && (audit.objective - expected).abs() < 5e-9, "{margin}: {}", audit.objective);
    }
}

#[test]
fn the_printed_bound_of_c5z_costs_what_the_reference_says() {
    let (audit, bound) = solved(&problem(&[r#"{"parameter_bounds": (bounds: {"c5z": (-0.05, 0.05)})}"#]));
    assert!(audit.feasible && (audit.objective - 3.86116e-4).abs() < 5e-9, "{}", audit.objective);
    assert!((bound - 3.86116e-4).abs() < 5e-9, "{bound}");
}

#[test]
fn the_published_parameters_are_feasible_and_not_optimal() {
    let problem = problem(&[]);
    let mut robot = panda::robot();
    let fixed = audit(&problem, &robot.inertial_parameters().expect("it has all"));
    assert!(fixed.feasible && (fixed.objective - 1.23436e-3).abs() < 1e-8, "{}", fixed.objective);
    // As printed, with the z of link 6's centre of mass that contradicts the paper's own Table III.
    let link = robot.links[5].inertia.as_mut().expect("it has one");
    let (mut com, inertia) =
        (link.center_of_mass().expect("mass"), link.inertia_at_center_of_mass().expect("mass"));
    com.z = -0.010517;
    *link = lacuna::robot::InertialParameters::from_barycentric(link.mass(), com, inertia);
    let printed = audit(&problem, &robot.inertial_parameters().expect("it has all"));
    assert!(printed.feasible && (printed.objective - 1.28839e-3).abs() < 1e-8, "{}", printed.objective);
}
