//! Real UR10e logs (torque = motor current times published drive gains), when `LACUNA_DATA` has them.

use super::common;

use common::data;
use lacuna::effects::{Effect, RigidBody, classic};
use lacuna::identify::{Errors, Evidence, Fit, Weighting, fit};
use lacuna::log::Log;
use lacuna::model::Model;
use lacuna::predict::{predict, prediction_errors};
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Mode, Run, Settings, prepare};

fn run(robot: &Robot, file: &str, mode: Mode) -> Option<Run> {
    let log = Log::open(data(file)?, robot, None).expect("the log reads");
    let settings = Settings { mode, band_hz: 5.0, trim_s: 0.5, ..Settings::default() };
    Some(prepare(&log, &settings).expect("the signal step works on it").0)
}

fn fitted(model: &Model, run: &Run) -> Fit {
    let folds = Folds { fold: vec![0; run.rows().count], count: 1, description: String::new() };
    let evidence = Evidence::collect(model, std::slice::from_ref(run), &folds).expect("collects");
    fit(model, &evidence, None, Weighting::Joint).expect("fits")
}

fn predicted(model: &Model, fit: &Fit, run: Run) -> Errors {
    let runs = [run];
    let torque = predict(model, &runs, &fit.x).expect("predicts");
    prediction_errors(&runs, &torque)
}

#[test]
fn one_log_predicts_another() {
    let Some(file) = data("ur10e/robot.urdf") else { return };
    let robot = Robot::open(file).expect("the URDF reads");
    let model = Model::new(&robot, classic()).expect("fits the robot");
    assert_eq!(model.base.as_ref().map(|b| b.rank()), Some(36));
    let Some(a) = run(&robot, "ur10e/unloaded_a.csv", Mode::Parallel) else { return };
    let Some(b) = run(&robot, "ur10e/unloaded_b.csv", Mode::Parallel) else { return };
    let errors = predicted(&model, &fitted(&model, &a), b);
    println!("{:.1?} %, pooled {:.2} %", errors.relative_percent, errors.pooled_percent);
    for (joint, (error, limit)) in
        errors.relative_percent.iter().zip([8.0, 5.0, 7.0, 8.0, 9.0, 12.0]).enumerate()
    {
        assert!(*error <= limit, "joint {}: {error} %", joint + 1);
    }
    assert!(!errors.worse_than_constant.contains(&true));
}

#[test]
fn rigid_body_alone_is_flagged_where_friction_is_all_there_is() {
    let Some(file) = data("ur10e/robot.urdf") else { return };
    let robot = Robot::open(file).expect("the URDF reads");
    let effects: Vec<Box<dyn Effect>> = vec![Box::new(RigidBody::default())];
    let model = Model::new(&robot, effects).expect("fits the robot");
    let Some(a) = run(&robot, "ur10e/unloaded_a.csv", Mode::Inputs) else { return };
    let Some(b) = run(&robot, "ur10e/unloaded_b.csv", Mode::Inputs) else { return };
    let errors = predicted(&model, &fitted(&model, &a), b);
    println!("{:.1?} % {:?}", errors.relative_percent, errors.worse_than_constant);
    // The wrist carries little and turns slowly: what its motors show is friction.
    assert!(errors.worse_than_constant[3] && errors.worse_than_constant[4]);
    assert!(!errors.worse_than_constant[1], "joint 2 lifts the arm: the rigid body explains most of it");
}
