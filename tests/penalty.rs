//! Retrieval by search: the Panda's two-step problem, other problems, stopping and going on.

#[path = "common/panda_problem.rs"]
mod panda_problem;

use std::ops::ControlFlow;

use lacuna::retrieval::penalty::PenaltyEngine;
use lacuna::retrieval::{RetrievalEngine, audit};
use panda_problem::panda_two_step;

/// Optimum of the problem, certified by a semidefinite solver from both sides.
const OPTIMUM: f64 = 3.726_204_8e-4;

#[test]
fn every_start_reaches_the_optimum_of_the_panda() {
    for seed in std::env::var("SEED").ok().and_then(|s| s.parse::<u64>().ok()).map_or(0..20, |s| s..s + 1) {
        let problem = panda_two_step(seed);
        let engine = PenaltyEngine { runs: 1, ..PenaltyEngine::default() };
        let start = std::time::Instant::now();
        let found = engine.retrieve(&problem, &|_| ControlFlow::Continue(())).expect("runs");
        let audit = audit(&problem, &found.z);
        println!(
            "{seed}: {:.6e} {:.1e} {} evaluations, {:?}",
            audit.objective,
            audit.violation,
            found.evaluations,
            start.elapsed()
        );
        if std::env::var("DBG").is_ok() {
            let p = problem.chart.coordinates(&found.z);
            for (v, a) in p.iter().zip(&problem.chart.space().parameters) {
                let (l, u) = ((v - a.lower) / (a.upper - a.lower), (a.upper - v) / (a.upper - a.lower));
                if l.min(u) < 1e-3 || a.name.starts_with('m') {
                    println!("{} {v:e} {l:e} {u:e}", a.name);
                }
            }
        }
        assert!(audit.feasible, "{seed}: {}", audit.violation);
        assert!(audit.objective < 1.01 * OPTIMUM, "{seed}: {:e}", audit.objective);
        assert!(audit.objective > 0.999_999 * OPTIMUM, "{seed}: {:e}", audit.objective);
    }
}
