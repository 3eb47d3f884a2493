//! The engine `nlopt` on the Panda's two-step problem; only where it is part of the build.

#[path = "common/panda_problem.rs"]
mod panda_problem;

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicUsize, Ordering};

use lacuna::retrieval::nlopt::{NloptAlgorithm, NloptEngine};
use lacuna::retrieval::{Audit, RetrievalEngine, Retrieved, Step, audit};
use panda_problem::panda_two_step;

/// Optimum of the Panda's problem, certified by a semidefinite solver from both sides.
const OPTIMUM: f64 = 3.726_204_8e-4;

fn solve(engine: &NloptEngine, seed: u64) -> (Retrieved, Audit) {
    lacuna_nlopt::install();
    let problem = panda_two_step(seed);
    let start = std::time::Instant::now();
    let found = engine.retrieve(&problem, &|_| ControlFlow::Continue(())).expect("runs");
    let audit = audit(&problem, &found.z);
    println!(
        "{:?} seed {seed}: {:.7e} violation {:.1e}, {} evaluations, {:?}, {}",
        engine.algorithm,
        audit.objective,
        audit.violation,
        found.evaluations,
        start.elapsed(),
        found.status
    );
    (found, audit)
}

#[test]
fn sequential_quadratic_programming_comes_near_the_optimum_of_the_panda() {
    let (_, audit) = solve(&NloptEngine { runs: 4, ..NloptEngine::default() }, 1);
    assert!(audit.feasible, "{}", audit.violation);
    assert!(audit.objective < 1.03 * OPTIMUM && audit.objective > 0.999_999 * OPTIMUM);
}

#[test]
fn the_subspace_simplex_stays_far_behind() {
    let engine = NloptEngine { runs: 2, algorithm: NloptAlgorithm::Sbplx, ..NloptEngine::default() };
    let (_, audit) = solve(&engine, 1);
    assert!(audit.objective > OPTIMUM && audit.objective < 1.0, "{:e}", audit.objective);
}

#[test]
fn it_can_be_stopped() {
    lacuna_nlopt::install();
    let calls = AtomicUsize::new(0);
    let stop = |_: &Step| {
        if calls.fetch_add(1, Ordering::Relaxed) > 2 {
            ControlFlow::Break(())
        } else {
            ControlFlow::Continue(())
        }
    };
    let engine = NloptEngine { runs: 50, ..NloptEngine::default() };
    let found = engine.retrieve(&panda_two_step(1), &stop).expect("stops with its best");
    assert!(found.stopped && found.runs < 50, "{}", found.status);
}
