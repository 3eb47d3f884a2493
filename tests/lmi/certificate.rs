//! The bound is never above the optimum, whoever made the multipliers, and nearly at it when they are good.

use lacuna::form::{Affine, Body, Form, General};
use lacuna::retrieval::certificate::{BoundIs, lower_bound, taken};
use lacuna::retrieval::{LmiEngine, Multiplier, RetrievalEngine, audit};
use std::sync::Arc;

use super::small::{Dice, known};
use super::{panda, quiet};

#[test]
fn known_optima_are_found_and_certified() {
    for seed in 0..60 {
        let residuals = 2 + (seed % 6) as usize;
        let known = known(seed, residuals);
        let found = LmiEngine::default().retrieve(&known.problem, &quiet).expect("it solves");
        let audit = audit(&known.problem, &found.z);
        let bound = found.lower_bound.expect("a bound");
        let case = format!("seed {seed}: {} {bound} {}", audit.objective, known.optimum);
        assert!(audit.feasible && audit.objective >= known.optimum * (1.0 - 1e-12), "{case}");
        assert!(audit.objective <= known.optimum * (1.0 + 1e-6), "{case}");
        assert!(bound <= known.optimum && bound >= known.optimum * (1.0 - 1e-6), "{case}");
    }
}

#[test]
fn a_solver_stopped_early_gives_a_weaker_bound_that_still_holds() {
    let mut gained = 0;
    for seed in 0..30 {
        let known = known(seed, 5);
        let forms = taken(&known.problem.forms);
        for iterations in 1..12 {
            let engine = LmiEngine { iterations, ..LmiEngine::default() };
            let solution = engine.solve(&known.problem, &quiet).expect("it runs");
            let certificate = lower_bound(&known.problem, &forms, &solution.multipliers).expect("it fits");
            assert!(certificate.lower_bound <= known.optimum, "seed {seed}, {iterations} iterations");
            // The part of the data that no parameters reach needs no multipliers.
            assert!(certificate.lower_bound >= known.problem.objective.floor);
            gained += usize::from(certificate.lower_bound > 0.5 * known.optimum && iterations == 5);
        }
    }
    assert!(gained > 0, "five iterations are worth something");
}

#[test]
fn the_panda_bound_grows_with_the_iterations() {
    let problem = panda::problem(panda::C5Z_REPOSITORY);
    let forms = taken(&problem.forms);
    let bound = |iterations| {
        let engine = LmiEngine { iterations, ..LmiEngine::default() };
        let solution = engine.solve(&problem, &quiet).expect("it runs");
        lower_bound(&problem, &forms, &solution.multipliers).expect("it fits").lower_bound
    };
    let bounds = [5, 9, 12, 16, 200].map(bound);
    assert!(bounds[0] >= 0.0 && bounds.windows(2).all(|w| w[0] < w[1] || w[1] <= 0.0), "{bounds:?}");
    assert!(bounds[1] > 1e-4 && bounds[4] > 3.7261e-4 && bounds[4] <= 3.72621e-4, "{bounds:?}");
}

#[test]
fn nonsense_multipliers_never_lift_the_bound_over_the_optimum() {
    for seed in 0..200 {
        let known = known(seed, 5);
        let forms = taken(&known.problem.forms);
        let good = LmiEngine::default().solve(&known.problem, &quiet).expect("it solves").multipliers;
        let mut dice = Dice::new(1000 + seed);
        let size = 10.0_f64.powf(2.0 * dice.roll() - 2.0);
        let spoil = |m: &Multiplier, dice: &mut Dice| Multiplier {
            label: m.label.clone(),
            values: m
                .values
                .iter()
                .map(|v| v * (1.0 + size * dice.roll()) + 0.1 * size * dice.roll())
                .collect(),
        };
        let mut bad: Vec<Multiplier> = good.iter().map(|m| spoil(m, &mut dice)).collect();
        bad[0].values[0] = [0.0, f64::NAN, f64::INFINITY, -1.0][(seed % 4) as usize];
        let bound = lower_bound(&known.problem, &forms, &bad).expect("it fits").lower_bound;
        assert!(bound.is_finite() && bound <= known.optimum, "seed {seed}: {bound} {}", known.optimum);
    }
}

#[test]
fn multipliers_of_other_forms_are_refused() {
    let known = known(1, 5);
    let forms = taken(&known.problem.forms);
    let mut some = LmiEngine::default().solve(&known.problem, &quiet).expect("it solves").multipliers;
    some.last_mut().expect("there are forms").values.push(0.0);
    assert!(lower_bound(&known.problem, &forms, &some).is_err());
    assert!(lower_bound(&known.problem, &forms[1..], &some).is_err());
}

/// `0.2 - |z0|`, as if no cone could express it.
#[derive(Debug)]
struct Narrow;

impl General for Narrow {
    fn support(&self) -> Vec<usize> {
        vec![0]
    }

    fn margin(&self, z: &[f64]) -> f64 {
        0.2 - z[0].abs()
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        (self.margin(z), vec![-z[0].signum()])
    }
}

#[test]
fn what_no_cone_expresses_is_refused_with_a_reason_and_the_bound_says_so() {
    let mut known = known(3, 5);
    let far = Affine::constant(5.0).plus(-1.0, &Affine::variable(0));
    let body = Body::General {
        function: Arc::new(Narrow),
        why: "a test".to_string(),
        implied: vec![Form::affine("z0 <= 5", "", 1.0, far)],
    };
    known.problem.forms.push(Form::new("narrow", "", 1.0, body));
    let engine = LmiEngine::default();
    let last = known.problem.forms.last().expect("just pushed");
    assert!(engine.accepts(last).is_err_and(|why| why.contains("a test")));
    let forms = taken(&known.problem.forms);
    assert_eq!(forms.last().expect("there are forms").label, "z0 <= 5", "the implied form is used instead");
    let solution = engine.solve(&known.problem, &quiet).expect("it solves");
    let certificate = lower_bound(&known.problem, &forms, &solution.multipliers).expect("it fits");
    assert_eq!(certificate.bound_is, BoundIs::Relaxation);
    assert!(certificate.lower_bound <= known.optimum);
}
