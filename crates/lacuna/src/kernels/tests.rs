//! Identities that any rigid-body model obeys, on random trees of revolute and prismatic joints.

use nalgebra::{DMatrix, Matrix3, Rotation3, Unit, Vector3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use super::*;
use crate::robot::{InertialParameters, Joint, JointKind, Limits, Link, Pose, Robot};

fn vector(rng: &mut Xoshiro256PlusPlus) -> Vector3<f64> {
    Vector3::from_fn(|_, _| rng.random_range(-1.0..1.0))
}

fn pose(rng: &mut Xoshiro256PlusPlus) -> Pose {
    let rotation = *Rotation3::new(vector(rng) * 2.0).matrix();
    Pose { rotation, translation: vector(rng) * 0.4 }
}

/// A random tree with random axes; every third joint slides, every fifth has a far-end link frame.
fn random_robot(n: usize, seed: u64) -> Robot {
    let rng = &mut Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut joints = Vec::new();
    let mut links = Vec::new();
    for i in 0..n {
        let kind = if i % 3 == 2 { JointKind::Prismatic } else { JointKind::Revolute };
        let after = if i % 5 == 1 { pose(rng) } else { Pose::identity() };
        let parent = (i > 0).then(|| if i == 3 { 1 } else { i - 1 });
        joints.push(Joint {
            name: format!("joint{}", i + 1),
            kind,
            parent,
            before: pose(rng),
            axis: *Unit::new_normalize(vector(rng)),
            after,
            limits: Limits::default(),
        });
        let spread = vector(rng);
        let inertia = Matrix3::from_diagonal(&(spread.component_mul(&spread) * 0.1 + Vector3::repeat(0.2)));
        let body =
            InertialParameters::from_barycentric(rng.random_range(0.5..4.0), vector(rng) * 0.2, inertia);
        links.push(Link { name: format!("link{}", i + 1), inertia: Some(body) });
    }
    Robot {
        name: "random".into(),
        gravity: Vector3::new(1.0, -2.0, -9.5),
        joints,
        links,
        order: (0..n).collect(),
        frames: Vec::new(),
        remarks: Vec::new(),
    }
}

fn random_state(n: usize, seed: u64) -> [Vec<f64>; 3] {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
    std::array::from_fn(|_| (0..n).map(|_| rng.random_range(-3.0..3.0)).collect())
}

fn torque(chain: &Chain, state: State<'_, f64>, parameters: &[f64]) -> Vec<f64> {
    let mut tau = vec![0.0; chain.dof()];
    inverse_dynamics(chain, &mut Workspace::new(chain, 0.0), state, parameters, &mut tau);
    tau
}

fn assert_close(a: &[f64], b: &[f64], what: &str) {
    let scale = a.iter().fold(1e-3_f64, |m, x| m.max(x.abs()));
    for (x, y) in a.iter().zip(b) {
        assert!((x - y).abs() <= 1e-12 * scale, "{what}: {x} against {y}");
    }
}

fn for_many_robots(check: impl Fn(&Chain, &[f64], State<'_, f64>)) {
    for n in 1..9 {
        for seed in 0..20 {
            let robot = random_robot(n, seed);
            let parameters = robot.inertial_parameters().expect("all links have inertia");
            let [q, dq, ddq] = random_state(n, seed + 1000);
            check(&Chain::new(&robot), &parameters, State::new(&q, &dq, &ddq));
        }
    }
}

#[test]
fn regressor_times_parameters_is_newton_euler() {
    for_many_robots(|chain, parameters, state| {
        let n = chain.dof();
        let mut product = vec![0.0; n];
        let (mut ws, mut twists) = (Workspace::new(chain, 0.0), Twists::new(chain, 0.0));
        regressor(chain, &mut ws, &mut twists, state, |joint, link, y| {
            product[joint] += y.iter().zip(&parameters[10 * link..]).map(|(y, p)| y * p).sum::<f64>();
        });
        assert_close(&torque(chain, state, parameters), &product, "Y p");
    });
}

#[test]
fn lagrangian_form_is_newton_euler() {
    for_many_robots(|chain, parameters, state| {
        let lagrange = lagrangian_torque(chain, state, parameters);
        assert_close(&torque(chain, state, parameters), &lagrange, "M ddq + c + g");
    });
}

#[test]
fn mass_matrix_is_the_torque_of_unit_accelerations_and_positive() {
    for_many_robots(|chain, parameters, state| {
        let n = chain.dof();
        let mut m = vec![0.0; n * n];
        MassMatrix::new(chain, parameters).at(&mut Workspace::new(chain, 0.0), state.q, &mut m);
        let weightless = chain.with_gravity([0.0; 3]);
        let still = vec![0.0; n];
        for j in 0..n {
            let mut push = still.clone();
            push[j] = 1.0;
            let column = torque(&weightless, State::new(state.q, &still, &push), parameters);
            let expected: Vec<f64> = (0..n).map(|i| m[i * n + j]).collect();
            assert_close(&expected, &column, "M e_j");
            assert!((0..n).all(|i| m[i * n + j].to_bits() == m[j * n + i].to_bits()), "M is symmetric");
        }
        assert!(DMatrix::from_row_slice(n, n, &m).cholesky().is_some(), "M must be positive definite");
    });
}

/// The angles at which frames along the axes are made in another way: parallel, antiparallel, at a right angle, and
/// nearly so.
fn with_axes_at(angle: f64, aside: f64) -> Robot {
    let mut robot = random_robot(4, 11);
    for (i, joint) in robot.joints.iter_mut().enumerate() {
        joint.axis = Vector3::z();
        joint.before = Pose {
            rotation: *Rotation3::new(Vector3::x() * angle).matrix(),
            translation: Vector3::new(aside, 0.3 * aside, 0.2 * i as f64),
        };
        joint.after = Pose::identity();
    }
    robot
}

#[test]
fn mass_matrix_holds_for_axes_that_are_parallel_square_or_nearly_so() {
    use std::f64::consts::{FRAC_PI_2, PI};
    for angle in
        [0.0, PI, FRAC_PI_2, -FRAC_PI_2, 1e-16, 1e-12, 1e-6, 0.04, 0.06, PI - 1e-9, FRAC_PI_2 + 1e-13]
    {
        for aside in [0.0, 1e-13, 0.3] {
            let robot = with_axes_at(angle, aside);
            let (chain, parameters) =
                (Chain::new(&robot), robot.inertial_parameters().expect("has inertias"));
            let [q, ..] = random_state(4, 5);
            let mut m = vec![0.0; 16];
            MassMatrix::new(&chain, &parameters).at(&mut Workspace::new(&chain, 0.0), &q, &mut m);
            for j in 0..4 {
                let mut push = vec![0.0; 4];
                push[j] = 1.0;
                let state = State::new(&q, &[0.0; 4], &push);
                let column = torque(&chain.with_gravity([0.0; 3]), state, &parameters);
                assert_close(&m[4 * j..4 * j + 4], &column, &format!("angle {angle}, {aside} m aside"));
            }
        }
    }
}

#[test]
fn batched_mass_matrices_have_the_bits_of_one_sample() {
    for n in [1, 4, 7] {
        let robot = random_robot(n, 3);
        let chain = Chain::new(&robot);
        let matrix = MassMatrix::new(&chain, &robot.inertial_parameters().expect("all links have inertia"));
        let states: Vec<_> = (0..37).map(|k| random_state(n, k)[0].clone()).collect();
        let q: Vec<Vec<f64>> = (0..n).map(|j| states.iter().map(|q| q[j]).collect()).collect();
        let mut block = MassMatrixBlock::new(n, 40);
        for range in [0..37, 5..16] {
            matrix.fill(&q, range.clone(), &mut block);
            assert_eq!(block.rows(), range.len());
            for (row, k) in range.enumerate() {
                let mut m = vec![0.0; n * n];
                matrix.at(&mut Workspace::new(&chain, 0.0), &states[k], &mut m);
                for (at, one) in m.iter().enumerate() {
                    assert_eq!(one.to_bits(), block.entry(at / n, at % n)[row].to_bits());
                }
            }
        }
    }
}

#[test]
fn lanes_have_the_bits_of_one_sample() {
    let robot = random_robot(7, 3);
    let chain = Chain::new(&robot);
    let parameters = robot.inertial_parameters().expect("all links have inertia");
    let count = 37; // not a multiple of any vector width
    let states: Vec<_> = (0..count).map(|k| random_state(7, k)).collect();
    let column = |which: usize| -> Vec<Vec<f64>> {
        (0..7).map(|j| states.iter().map(|s| s[which][j]).collect()).collect()
    };
    let (q, dq, ddq) = (column(0), column(1), column(2));
    let samples = Samples { q: &q, dq: &dq, ddq: &ddq };
    let tau = inverse_dynamics_batch(&chain, samples, &parameters);
    let mut block = RegressorBlock::new(&chain, 40);
    block.fill(&chain, samples, 0..count as usize);
    for (k, [q, dq, ddq]) in states.iter().enumerate() {
        let state = State::new(q, dq, ddq);
        for (j, one) in torque(&chain, state, &parameters).into_iter().enumerate() {
            assert_eq!(one.to_bits(), tau[j][k].to_bits());
        }
        let (mut ws, mut twists) = (Workspace::new(&chain, 0.0), Twists::new(&chain, 0.0));
        regressor(&chain, &mut ws, &mut twists, state, |joint, link, y| {
            for (i, one) in y.into_iter().enumerate() {
                let many = block.column(joint, 10 * link + i).expect("carried")[k];
                assert_eq!(one.to_bits(), many.to_bits());
            }
        });
    }
}

#[test]
fn velocity_terms_do_no_work() {
    // d/dt(½ dqᵀ M dq) = dqᵀ M ddq + ½ dqᵀ dM/dt dq, and c accounts for exactly the last part.
    for_many_robots(|chain, parameters, state| {
        let n = chain.dof();
        let terms = LagrangianTerms::new(chain, state.q, state.dq, parameters);
        let energy = |h: f64| -> f64 {
            let q: Vec<f64> = state.q.iter().zip(state.dq).map(|(q, v)| q + h * v).collect();
            let mut m = vec![0.0; n * n];
            MassMatrix::new(chain, parameters).at(&mut Workspace::new(chain, 0.0), &q, &mut m);
            let v = state.dq;
            (0..n * n).map(|k| 0.5 * v[k / n] * m[k] * v[k % n]).sum()
        };
        let h = 1e-4;
        let rate = (energy(h) - energy(-h)) / (2.0 * h);
        let power: f64 = terms.coriolis.iter().zip(state.dq).map(|(c, v)| c * v).sum();
        assert!((rate - power).abs() < 1e-5 * (1.0 + energy(0.0)), "{rate} against {power}");
    });
}
