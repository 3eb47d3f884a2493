//! Time of the rigid-body kernels on the seven joints of the Panda, one core.
//!
//! Every row works through 1000 random states, so **µs here are ns per sample**. In brackets: ns per
//! call of Pinocchio 4.1 in C++ (g++ -O3, one sample at a time) on the machine where this was written;
//! `benches/pinocchio/compare.py` measures both on yours.
//!
//! `cargo bench --bench kernels`

use divan::{Bencher, black_box};
use lacuna::kernels::{
    Chain, Lanes, MassMatrix, MassMatrixBlock, Real, RegressorBlock, Samples, State, Twists, Workspace,
    inverse_dynamics, inverse_dynamics_batch, lagrangian_torque, regressor,
};
use lacuna::robot::Robot;
use pulp::{Arch, Simd, WithSimd};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const SAMPLES: usize = 1000;
/// What the least-squares code fills at once.
const STRETCH: usize = 128;

fn main() {
    println!("1000 samples per row: read µs as ns per sample. [..] is Pinocchio's C++ in ns.");
    divan::main();
}

/// The robot and 1000 states, both sample by sample and joint by joint.
struct Bench {
    chain: Chain,
    parameters: Vec<f64>,
    states: Vec<[Vec<f64>; 3]>,
    columns: [Vec<Vec<f64>>; 3],
}

impl Bench {
    fn new() -> Self {
        let robot = Robot::open("robots/panda.ron").expect("the shipped robot reads");
        let n = robot.dof();
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
        let mut draw = |reach: f64| -> Vec<f64> { (0..n).map(|_| rng.random_range(-reach..reach)).collect() };
        let states: Vec<[Vec<f64>; 3]> = (0..SAMPLES).map(|_| [draw(3.0), draw(2.0), draw(10.0)]).collect();
        let columns = std::array::from_fn(|which| {
            (0..n).map(|j| states.iter().map(|s| s[which][j]).collect()).collect()
        });
        let parameters = robot.inertial_parameters().expect("the shipped robot has inertias");
        Self { chain: Chain::new(&robot), parameters, states, columns }
    }

    fn samples(&self) -> Samples<'_> {
        let [q, dq, ddq] = &self.columns;
        Samples { q, dq, ddq }
    }

    fn each(&self, mut work: impl FnMut(State<'_, f64>)) {
        for [q, dq, ddq] in &self.states {
            work(black_box(State::new(q, dq, ddq)));
        }
    }
}

#[divan::bench(name = "rnea, one by one       [1100]")]
fn rnea(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    let mut ws = Workspace::new(&b.chain, 0.0);
    let mut tau = vec![0.0; b.chain.dof()];
    bencher.bench_local(|| {
        b.each(|state| {
            inverse_dynamics(&b.chain, &mut ws, state, &b.parameters, &mut tau);
            black_box(&tau);
        });
    });
}

#[divan::bench(name = "rnea, batched          [1100]")]
fn rnea_batched(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    bencher.bench_local(|| inverse_dynamics_batch(&b.chain, black_box(b.samples()), &b.parameters));
}

#[divan::bench(name = "regressor, one by one  [2000-2700]")]
fn regressor_scalar(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    let (mut ws, mut twists) = (Workspace::new(&b.chain, 0.0), Twists::new(&b.chain, 0.0));
    let mut y = vec![0.0; 7 * 70];
    bencher.bench_local(|| {
        b.each(|state| {
            regressor(&b.chain, &mut ws, &mut twists, state, |joint, link, columns| {
                let at = 70 * joint + 10 * link;
                y[at..at + 10].copy_from_slice(&columns);
            });
            black_box(&y);
        });
    });
}

#[divan::bench(name = "regressor, batched     [2000-2700]")]
fn regressor_batched(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    let mut block = RegressorBlock::new(&b.chain, STRETCH);
    bencher.bench_local(|| {
        for first in (0..SAMPLES).step_by(STRETCH) {
            block.fill(&b.chain, b.samples(), first..(first + STRETCH).min(SAMPLES));
            black_box(&block);
        }
    });
}

#[divan::bench(name = "mass matrix, one by one [550-630]")]
fn inertia(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    let (matrix, mut ws) = (MassMatrix::new(&b.chain, &b.parameters), Workspace::new(&b.chain, 0.0));
    let mut m = vec![0.0; 49];
    bencher.bench_local(|| {
        b.each(|state| {
            matrix.at(&mut ws, state.q, &mut m);
            black_box(&m);
        });
    });
}

#[divan::bench(name = "mass matrix, batched   [550-630]")]
fn inertia_batched(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    let matrix = MassMatrix::new(&b.chain, &b.parameters);
    let mut block = MassMatrixBlock::new(b.chain.dof(), STRETCH);
    bencher.bench_local(|| {
        for first in (0..SAMPLES).step_by(STRETCH) {
            matrix.fill(black_box(&b.columns[0]), first..(first + STRETCH).min(SAMPLES), &mut block);
            black_box(&block);
        }
    });
}

#[divan::bench(name = "Lagrangian torque      [no counterpart]", sample_count = 10)]
fn lagrange(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    bencher
        .bench_local(|| b.each(|state| drop(black_box(lagrangian_torque(&b.chain, state, &b.parameters)))));
}

#[divan::bench(name = "7 sin_cos, one by one  [no counterpart]")]
fn sin_cos(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    bencher.bench_local(|| {
        b.each(|state| {
            for &q in state.q {
                black_box(Real::sin_cos(q));
            }
        });
    });
}

#[divan::bench(name = "7 sin_cos, batched     [no counterpart]")]
fn sin_cos_batched(bencher: Bencher<'_, '_>) {
    let b = Bench::new();
    bencher.bench_local(|| Arch::new().dispatch(SinCos(black_box(&b.columns[0]))));
}

struct SinCos<'a>(&'a [Vec<f64>]);

impl WithSimd for SinCos<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        for column in self.0 {
            for part in column.chunks(Lanes::<S>::COUNT) {
                black_box(Real::sin_cos(Lanes::load(simd, part)));
            }
        }
    }
}
