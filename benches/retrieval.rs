//! Time of the engines on the Panda's two-step problem (70 unknowns, 65 constraints).
//!
//! `cargo bench --bench retrieval`

#[path = "../tests/common/panda_problem.rs"]
mod panda_problem;

use std::ops::ControlFlow;

use divan::{Bencher, black_box};
use lacuna::retrieval::penalty::{Ground, PenaltyEngine, PenaltyForm, Walk};
use lacuna::retrieval::polish::{Polish, Polisher, Target};
use lacuna::retrieval::{LmiEngine, Problem, RetrievalEngine};
use panda_problem::panda_two_step;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn main() {
    divan::main();
}

/// Random coordinates within the bounds.
fn start(problem: &Problem, seed: u64) -> Vec<f64> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    problem.chart.space().parameters.iter().map(|p| rng.random_range(p.lower..p.upper)).collect()
}

/// One run's result, polished: where a search spends its time.
fn settled(problem: &Problem) -> Vec<f64> {
    let engine = PenaltyEngine { runs: 1, ..PenaltyEngine::default() };
    let found = engine.retrieve(problem, &|_| ControlFlow::Continue(())).expect("runs");
    problem.chart.coordinates(&found.z)
}

/// 1000 proposals about a settled point, some 30 % of them taken: µs here are ns per proposal.
#[divan::bench]
fn proposals_1000(bencher: Bencher<'_, '_>) {
    let problem = panda_two_step(1);
    let ground = Ground::new(&problem);
    let mut walk = Walk::new(&ground, PenaltyForm::Linear, 16.0, settled(&problem));
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    let bounds = &problem.chart.space().parameters;
    let moves: Vec<(usize, f64, f64)> = (0..1000)
        .map(|_| {
            (rng.random_range(0..bounds.len()), rng.random_range(-1e-3..1e-3), rng.random_range(0.0..1e-4))
        })
        .collect();
    bencher.bench_local(|| {
        for &(c, step, worse) in &moves {
            let width = bounds[c].upper - bounds[c].lower;
            let value = (walk.coordinates()[c] + step * width).clamp(bounds[c].lower, bounds[c].upper);
            black_box(walk.try_move(c, value, 4e-4 + worse));
        }
    });
}

/// The interior point from a random start to a gap of 1e-6.
#[divan::bench(args = [1, 2, 3])]
fn polish(bencher: Bencher<'_, '_>, seed: u64) {
    let problem = panda_two_step(1);
    let polisher = Polisher::new(Polish::InteriorPoint, &problem);
    let target = Target { problem: &problem, penalty: PenaltyForm::Linear, weight: f64::INFINITY };
    let p = start(&problem, seed);
    bencher.bench_local(|| polisher.run(&target, black_box(&p), &|| false));
}

/// The whole engine with `Q` runs, on all processors.
#[divan::bench(args = [1, 5, 100], sample_count = 3, sample_size = 1)]
fn engine(bencher: Bencher<'_, '_>, runs: usize) {
    let problem = panda_two_step(1);
    let engine = PenaltyEngine { runs, ..PenaltyEngine::default() };
    bencher
        .bench_local(|| engine.retrieve(black_box(&problem), &|_| ControlFlow::Continue(())).expect("runs"));
}

/// The semidefinite solver, with the repair of what its rounding violates.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn lmi_solver(bencher: Bencher<'_, '_>) {
    let problem = panda_two_step(1);
    let engine = LmiEngine::default();
    bencher
        .bench_local(|| engine.solve(black_box(&problem), &|_| ControlFlow::Continue(())).expect("solves"));
}

/// The same with its certificate and the audit.
#[divan::bench(sample_count = 20, sample_size = 1)]
fn lmi_engine(bencher: Bencher<'_, '_>) {
    let problem = panda_two_step(1);
    let engine = LmiEngine::default();
    bencher.bench_local(|| {
        engine.retrieve(black_box(&problem), &|_| ControlFlow::Continue(())).expect("solves")
    });
}
