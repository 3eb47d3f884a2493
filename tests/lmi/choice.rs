//! Tie-breaks: the chosen point is feasible, as good as asked, and better in its own measure than others.

use lacuna::constraints::LinkSpace;
use lacuna::retrieval::{
    BodyMatrix, Chosen, LmiEngine, Problem, RetrievalEngine, Slack, TieBreak, audit, choose,
};

use super::{panda, quiet};

/// The paper's feasible parameters (Tables VIII and IX; `c6z` corrected, `c1z`, which no torque shows, 0): stand in
/// for values of a drawing.
const DRAWING: [[f64; 10]; 7] = [
    [4.970684, 0.003875, 0.002081, 0.0, 0.70337, -0.000139, 0.006772, 0.70661, 0.019169, 0.009117],
    [0.646926, -0.003141, -0.02872, 0.003495, 0.007962, -0.003925, 0.010254, 0.02811, 0.000704, 0.025995],
    [3.228604, 0.027518, 0.039252, -0.066502, 0.037242, -0.004761, -0.011396, 0.036155, -0.012805, 0.01083],
    [3.587895, -0.05317, 0.104419, 0.027454, 0.025853, 0.007796, -0.001332, 0.019552, 0.008641, 0.028323],
    [1.225946, -0.011953, 0.041065, -0.038437, 0.035549, -0.002117, -0.004037, 0.029474, 0.000229, 0.008627],
    [1.666555, 0.060149, -0.014117, -0.019235, 0.001964, 0.000109, -0.001158, 0.004354, 0.000341, 0.005433],
    [0.735522, 0.010517, -0.004252, 0.061597, 0.012516, -0.000428, -0.001196, 0.010027, -0.000741, 0.004815],
];

struct Case {
    problem: Problem,
    bodies: Vec<BodyMatrix>,
    best: Vec<f64>,
    level: f64,
    prior: Vec<f64>,
}

fn case() -> Case {
    let problem = panda::problem(panda::C5Z_REPOSITORY);
    let space = LinkSpace::new(&panda::robot(), &[]);
    let best = LmiEngine::default().retrieve(&problem, &quiet).expect("it solves").z;
    let level = Slack::default().level(problem.objective.value(&best));
    let prior = problem.chart.unknowns(DRAWING.as_flattened());
    Case { bodies: space.bodies(), problem, best, level, prior }
}

impl Case {
    fn choose(&self, choice: &TieBreak) -> Chosen {
        let chosen =
            choose(&self.problem, &self.bodies, self.level, &self.best, choice).expect("there is room");
        let audit = audit(&self.problem, &chosen.z);
        println!("{choice:.20?} {} {} {}", chosen.score, chosen.steps, audit.objective);
        assert!(audit.feasible && audit.objective <= self.level * (1.0 + 1e-9), "{audit:?}");
        chosen
    }

    fn determinants(&self, z: &[f64]) -> f64 {
        self.bodies.iter().map(|b| lacuna::form::matrix(b.size, &b.lower, z).determinant().ln()).sum()
    }

    /// `tr(P0⁻¹ P) - log det(P0⁻¹ P) - 4`, summed, by the definition.
    fn divergence(&self, z: &[f64]) -> f64 {
        let of = |body: &BodyMatrix| {
            let at = |z: &[f64]| lacuna::form::matrix(body.size, &body.lower, z);
            let quotient = at(&self.prior).try_inverse().expect("a body") * at(z);
            quotient.trace() - quotient.determinant().ln() - 4.0
        };
        self.bodies.iter().map(of).sum()
    }

    fn traces(&self, z: &[f64]) -> f64 {
        self.bodies.iter().map(|b| lacuna::form::matrix(b.size, &b.lower, z).trace()).sum()
    }
}

#[test]
fn each_choice_is_best_in_its_own_measure() {
    let case = case();
    let nearest = case.choose(&TieBreak::Nearest { prior: case.prior.clone() });
    let uniform = case.choose(&TieBreak::Uniform);
    let smallest = case.choose(&TieBreak::Smallest);
    assert!(
        (case.divergence(&nearest.z) / nearest.score - 1.0).abs() < 1e-6,
        "{}",
        case.divergence(&nearest.z)
    );
    let all = [&nearest.z, &uniform.z, &smallest.z, &case.best];
    for other in all {
        assert!(case.divergence(&nearest.z) <= case.divergence(other) + 1e-4);
        assert!(case.determinants(&uniform.z) >= case.determinants(other) - 1e-4);
        assert!(case.traces(&smallest.z) <= case.traces(other) + 1e-6);
        // And along the way to any of them: a minimum, not merely the best of four.
        let near = |z: &[f64]| -> Vec<f64> { z.iter().zip(other).map(|(a, b)| a + 1e-3 * (b - a)).collect() };
        assert!(case.divergence(&nearest.z) <= case.divergence(&near(&nearest.z)) + 1e-6);
        assert!(case.determinants(&uniform.z) >= case.determinants(&near(&uniform.z)) - 1e-6);
    }
}

#[test]
fn a_prior_that_is_itself_feasible_and_good_comes_back() {
    let mut case = case();
    case.level = 2.0 * case.problem.objective.value(&case.prior);
    assert!(audit(&case.problem, &case.prior).feasible);
    let chosen = case.choose(&TieBreak::Nearest { prior: case.prior.clone() });
    assert!(chosen.score.abs() < 1e-5, "{}", chosen.score);
    let far = chosen.z.iter().zip(&case.prior).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    assert!(far < 1e-2, "{far}");
}

#[test]
fn an_impossible_prior_and_an_empty_set_are_errors() {
    let case = case();
    let nothing = TieBreak::Nearest { prior: vec![0.0; case.prior.len()] };
    let error = choose(&case.problem, &case.bodies, case.level, &case.best, &nothing).expect_err("no body");
    assert!(error.to_string().contains("not a body"), "{error}");
    let short = TieBreak::Nearest { prior: vec![1.0] };
    assert!(choose(&case.problem, &case.bodies, case.level, &case.best, &short).is_err());
    for choice in [TieBreak::Uniform, TieBreak::Smallest] {
        let error =
            choose(&case.problem, &case.bodies, 3e-4, &case.best, &choice).expect_err("below the optimum");
        assert!(error.to_string().contains("no room"), "{error}");
    }
}
