//! Known faults come back from simulated runs: the plant has the fault, or its exact motion is written down
//! wrongly.

use lacuna::effects::{
    BaseTilt, Effect, JointElasticity, JointZeroError, Joints, RigidBody, RotorInertia, TimeDelay,
    TorqueOffset, ViscousFriction,
};
use lacuna::excitation::FourierMotion;
use lacuna::identify::{Weighting, fit, settle};
use lacuna::model::Model;
use lacuna::plant::{self, PerJoint, Plant, Truth};
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Run, central_difference};
use nalgebra::Vector3;

use super::common::robot;

const VISCOUS: f64 = 0.7;
const OFFSET: f64 = 0.3;

pub fn plant(robot: &Robot) -> Plant {
    Plant::new(robot.clone())
        .expect("has inertias")
        .with_effect(plant::ViscousFriction { coefficients: PerJoint::all(VISCOUS) })
        .with_effect(plant::TorqueOffset { offsets: PerJoint::all(OFFSET) })
}

pub fn truth(plant: &Plant, robot: &Robot) -> Truth {
    let motion = FourierMotion::random(robot, 11, 5, 6.0, 0.7).expect("limits are known");
    plant.simulate(&motion, 8.0, 1).expect("simulates").truth
}

/// Every fourth sample as a run, from when the controller has settled on.
fn run(truth: &Truth) -> Run {
    let thin = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
        columns.iter().map(|c| c.iter().skip(1500).step_by(4).copied().collect()).collect()
    };
    Run {
        name: "simulated".to_string(),
        dt: 4.0 * (truth.t[1] - truth.t[0]),
        q: thin(&truth.q),
        dq: thin(&truth.dq),
        ddq: thin(&truth.ddq),
        tau: thin(&truth.tau),
        ..Run::default()
    }
}

/// Values of the last effect's parameters in a joint fit with rigid body, viscous friction and offset.
pub fn found(robot: &Robot, truth: &Truth, extra: Vec<Box<dyn Effect>>) -> Vec<f64> {
    let count = extra.last().expect("an effect").terms(robot).expect("fits the robot").len();
    let mut effects: Vec<Box<dyn Effect>> = vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(TorqueOffset::default()),
    ];
    effects.extend(extra);
    let model = Model::new(robot, effects).expect("fits the robot");
    let mut runs = vec![run(truth)];
    let folds = Folds { fold: vec![0; runs[0].rows().count], count: 1, description: String::new() };
    let settled = settle(&model, &mut runs, &folds, Weighting::Ordinary).expect("settles");
    assert!(!settled.wanders(), "{}", settled.change);
    let fitted = fit(&model, &settled.evidence, None, Weighting::Ordinary).expect("fits");
    fitted.x[fitted.x.len() - count..].to_vec()
}

fn near(found: f64, expected: f64, part: f64) {
    assert!((found - expected).abs() < part * expected.abs(), "{found} instead of {expected}");
}

fn joint(number: usize) -> Joints {
    Joints::Only(vec![number.to_string()])
}

#[test]
fn a_wrong_zero() {
    let robot = robot("panda.ron");
    let mut truth = truth(&plant(&robot), &robot);
    // The sensor shows 5 mrad too little.
    truth.q[3].iter_mut().for_each(|q| *q -= 0.005);
    near(found(&robot, &truth, vec![Box::new(JointZeroError { joints: joint(4) })])[0], 0.005, 0.03);
}

#[test]
fn a_leaning_base() {
    let robot = robot("panda.ron");
    let (x, y) = (0.006, -0.003);
    let size = robot.gravity.norm();
    let leaning = robot.clone().with_gravity(robot.gravity + Vector3::new(x, y, 0.0) * size);
    let truth = truth(&plant(&leaning), &robot);
    let values = found(&robot, &truth, vec![Box::new(BaseTilt {})]);
    near(values[0], x, 0.05);
    near(values[1], y, 0.05);
}

#[test]
fn a_late_torque() {
    let robot = robot("panda.ron");
    let mut truth = truth(&plant(&robot), &robot);
    let (dt, late) = (truth.t[1] - truth.t[0], 1);
    for tau in &mut truth.tau {
        tau.rotate_right(late);
        let first = tau[late];
        tau[..late].fill(first);
    }
    near(found(&robot, &truth, vec![Box::new(TimeDelay::default())])[0], late as f64 * dt, 0.05);
}

#[test]
fn a_yielding_gear() {
    let robot = robot("panda.ron");
    let mut truth = truth(&plant(&robot), &robot);
    let (dt, compliance, j) = (truth.t[1] - truth.t[0], 1e-5, 3);
    let samples = truth.t.len();
    // The motor is ahead of the link by what the link's torque twists; its friction is not passed on.
    let ahead: Vec<f64> =
        (0..samples).map(|k| compliance * (truth.tau[j][k] - VISCOUS * truth.dq[j][k] - OFFSET)).collect();
    let rate = central_difference(&ahead, dt);
    let bend = central_difference(&rate, dt);
    for k in 0..samples {
        truth.q[j][k] += ahead[k];
        truth.dq[j][k] += rate[k];
        truth.ddq[j][k] += bend[k];
    }
    near(found(&robot, &truth, vec![Box::new(JointElasticity { joints: joint(4) })])[0], compliance, 0.05);
}

#[test]
fn rotors() {
    let robot = robot("panda.ron");
    let with = plant(&robot)
        .with_effect(plant::RotorInertia { inertias: [0.0, 0.0, 0.0, 0.0, 0.12, 0.0, 0.0].into() });
    let truth = truth(&with, &robot);
    near(found(&robot, &truth, vec![Box::new(RotorInertia { joints: joint(5) })])[0], 0.12, 1e-4);
}
