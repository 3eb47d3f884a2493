//! Columns built from the model's torque, against differences of inverse dynamics at displaced motions.

use lacuna::effects::{
    Backlash, BaseTilt, Effect, JointElasticity, JointZeroError, Joints, TimeDelay, TorqueGain,
};
use lacuna::robot::Robot;
use nalgebra::{Rotation3, Vector3};

use super::common::robot;
use super::motion::{at, columns, run, torque};

const DT: f64 = 0.002;
const SAMPLES: usize = 600;

fn joint(number: usize) -> Joints {
    Joints::Only(vec![number.to_string()])
}

/// Derivative of `f` at `t` by five points, and the second one.
fn slopes(f: impl Fn(f64) -> f64, t: f64) -> [f64; 2] {
    const H: f64 = 2e-3;
    let [a, b, c, d, e] = [-2.0, -1.0, 0.0, 1.0, 2.0].map(|k: f64| f(t + k * H));
    [(a - 8.0 * b + 8.0 * d - e) / (12.0 * H), (-a + 16.0 * b - 30.0 * c + 16.0 * d - e) / (12.0 * H * H)]
}

/// Torque of the motion with joint `j` displaced by `size` times `shift`, per unit of `size`, by a
/// symmetric difference.
fn displaced(robot: &Robot, j: usize, t: f64, shift: &dyn Fn(f64) -> f64) -> Vec<f64> {
    let [dq, ddq] = slopes(shift, t);
    let way = [shift(t), dq, ddq];
    let size = 1e-4 / way.iter().fold(1.0_f64, |m, x| m.max(x.abs()));
    let moved = |sign: f64| {
        let mut state = at(robot, t);
        (0..3).for_each(|k| state[k][j] += sign * size * way[k]);
        torque(robot, &state)
    };
    moved(1.0).iter().zip(moved(-1.0)).map(|(a, b)| (a - b) / (2.0 * size)).collect()
}

/// Compares all columns of one term with `expected(t)` per joint, over the samples `range`.
fn compare(
    found: &[Vec<f64>],
    range: std::ops::Range<usize>,
    tolerance: f64,
    expected: impl Fn(f64) -> Vec<f64>,
) {
    let truth: Vec<Vec<f64>> = range.clone().map(|k| expected(k as f64 * DT)).collect();
    let mut largest = 0.0_f64;
    for (joint, column) in found.iter().enumerate() {
        let size = truth.iter().fold(0.01_f64, |m, tau| m.max(tau[joint].abs()));
        for (y, tau) in column[range.clone()].iter().zip(&truth) {
            assert!((y - tau[joint]).abs() < tolerance * size, "joint {}: {y} {}", joint + 1, tau[joint]);
        }
        largest = largest.max(size);
    }
    assert!(largest > 0.1, "nothing was compared");
}

#[test]
fn a_zero_error_is_the_change_of_torque_with_position() {
    for file in ["panda.ron", "two_link.ron", "six_axis.urdf"] {
        let robot = robot(file);
        let run = run(&robot, DT, SAMPLES);
        for j in 1..robot.dof() {
            let found = columns(&robot, &run, &JointZeroError { joints: joint(j + 1) });
            compare(&found[0], 0..SAMPLES, 1e-6, |t| displaced(&robot, j, t, &|_| 1.0));
        }
    }
}

#[test]
fn no_torque_knows_the_zero_of_a_vertical_first_joint() {
    let panda = robot("panda.ron");
    let run = run(&panda, DT, 50);
    let found = columns(&panda, &run, &JointZeroError { joints: joint(1) });
    assert!(found[0].iter().flatten().all(|y| y.abs() < 1e-12));
    let names = |robot: &Robot| -> Vec<String> {
        let entry = lacuna::effects::CATALOGUE.iter().find(|e| e.about.name == "joint_zero_error");
        let tried = (entry.expect("is there").candidates)(robot);
        tried.iter().flat_map(|e| e.terms(robot).expect("fits")).map(|t| t.symbol).collect()
    };
    assert_eq!(names(&panda), ["zero2", "zero3", "zero4", "zero5", "zero6", "zero7"]);
    let on_a_wall = panda.with_gravity(Vector3::new(9.81, 0.0, 0.0));
    assert_eq!(names(&on_a_wall).len(), 7);
}

#[test]
fn an_elastic_joint_lags_behind_its_torque() {
    let robot = robot("panda.ron");
    let run = run(&robot, DT, SAMPLES);
    for j in [0, 1, 3, 5] {
        let found = columns(&robot, &run, &JointElasticity { joints: joint(j + 1) });
        let behind = |t: f64| -torque(&robot, &at(&robot, t))[j];
        compare(&found[0], 4..SAMPLES - 4, 2e-3, |t| displaced(&robot, j, t, &behind));
    }
}

#[test]
fn play_puts_the_link_on_the_side_of_the_load() {
    let robot = robot("panda.ron");
    let run = run(&robot, DT, SAMPLES);
    let effect = Backlash { joints: joint(4), closing: 4.0 };
    let found = columns(&robot, &run, &effect);
    let behind = |t: f64| -0.5 * (torque(&robot, &at(&robot, t))[3] / 4.0).tanh();
    compare(&found[0], 4..SAMPLES - 4, 1e-2, |t| displaced(&robot, 3, t, &behind));
}

#[test]
fn a_tilted_base_turns_gravity() {
    let panda = robot("panda.ron");
    let on_a_wall = panda.clone().with_gravity(Vector3::new(0.0, 9.81, 0.0));
    for (robot, names) in [(&panda, ["tilt_x", "tilt_y"]), (&on_a_wall, ["tilt_x", "tilt_z"])] {
        let run = run(robot, DT, 200);
        let found = columns(robot, &run, &BaseTilt {});
        let terms = BaseTilt {}.terms(robot).expect("fits the robot");
        for (term, name) in names.iter().enumerate() {
            assert_eq!(terms[term].symbol, *name);
            let axis =
                Vector3::from_fn(|i, _| f64::from(u8::from(["tilt_x", "tilt_y", "tilt_z"][i] == *name)));
            let lean = |angle: f64| {
                let about = robot.gravity.cross(&axis).normalize();
                robot.clone().with_gravity(Rotation3::new(about * angle) * robot.gravity)
            };
            let (plus, minus) = (lean(1e-4), lean(-1e-4));
            assert!(plus.gravity.dot(&axis) > 0.0, "it leans towards the axis");
            compare(&found[term], 0..200, 1e-6, |t| {
                let state = at(robot, t);
                let (a, b) = (torque(&plus, &state), torque(&minus, &state));
                a.iter().zip(b).map(|(a, b)| (a - b) / 2e-4).collect()
            });
        }
    }
}

#[test]
fn late_torque_is_torque_of_earlier() {
    let robot = robot("panda.ron");
    let run = run(&robot, DT, SAMPLES);
    let total = |t: f64| -> Vec<f64> {
        let state = at(&robot, t);
        torque(&robot, &state).iter().zip(&state[1]).map(|(tau, v)| tau + 0.5 * v).collect()
    };
    let late = |t: f64| -> Vec<f64> {
        total(t - 1e-4).iter().zip(total(t + 1e-4)).map(|(a, b)| (a - b) / 2e-4).collect()
    };
    let found = columns(&robot, &run, &TimeDelay::default());
    assert_eq!(found.len(), 1, "one delay for all joints");
    compare(&found[0], 1..SAMPLES - 1, 1e-3, late);
    let one = columns(&robot, &run, &TimeDelay { joints: joint(2) });
    compare(&one[0], 1..SAMPLES - 1, 1e-3, |t| {
        late(t).iter().enumerate().map(|(j, y)| if j == 1 { *y } else { 0.0 }).collect()
    });
}

#[test]
fn a_gain_scales_the_whole_torque_of_its_joint() {
    let robot = robot("two_link.ron");
    let run = run(&robot, DT, 100);
    let found = columns(&robot, &run, &TorqueGain { joints: joint(2) });
    assert_eq!(found[0][1], run.tau[1]);
    assert!(found[0][0].iter().all(|y| y.abs() < 1e-15));
}
