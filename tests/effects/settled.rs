//! Effects built from the model's own torque are fitted in turns with it.

use lacuna::effects::{Effect, Joints, RigidBody, TorqueGain, TorqueOffset, ViscousFriction};
use lacuna::excitation::FourierMotion;
use lacuna::identify::{Weighting, fit, refresh_model_torque, settle};
use lacuna::model::Model;
use lacuna::model_file::ModelFile;
use lacuna::plant::{self, PerJoint, Plant};
use lacuna::predict::{predict, prediction_errors};
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Run};

use super::common::robot;

/// A simulated motion with the plant's own accelerations and torques, every tenth sample.
pub fn exact_run(robot: &Robot, seed: u64) -> Run {
    let plant = Plant::new(robot.clone())
        .expect("has inertias")
        .with_effect(plant::ViscousFriction { coefficients: PerJoint::all(0.7) })
        .with_effect(plant::TorqueOffset { offsets: PerJoint::all(0.3) });
    let motion = FourierMotion::random(robot, seed, 5, 6.0, 0.6).expect("limits are known");
    let truth = plant.simulate(&motion, 8.0, 1).expect("simulates").truth;
    let thin = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
        columns.iter().map(|c| c.iter().step_by(10).copied().collect()).collect()
    };
    Run {
        name: "truth".to_string(),
        dt: 10.0 * (truth.t[1] - truth.t[0]),
        q: thin(&truth.q),
        dq: thin(&truth.dq),
        ddq: thin(&truth.ddq),
        tau: thin(&truth.tau),
        ..Run::default()
    }
}

fn with(effect: impl Effect + 'static) -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(TorqueOffset::default()),
        Box::new(effect),
    ]
}

fn one_fold(run: &Run) -> Folds {
    Folds { fold: vec![0; run.rows().count], count: 1, description: String::new() }
}

#[test]
fn a_torque_scale_comes_back_and_the_file_repeats_its_predictions() {
    let robot = robot("panda.ron");
    let mut run = exact_run(&robot, 7);
    run.tau[3].iter_mut().for_each(|t| *t *= 1.08);
    let gain = TorqueGain { joints: Joints::Only(vec!["4".to_string()]) };
    let model = Model::new(&robot, with(gain)).expect("fits the robot");
    let folds = one_fold(&run);
    let mut runs = vec![run];
    let settled = settle(&model, &mut runs, &folds, Weighting::Joint).expect("settles");
    assert!(settled.change < 1e-6, "{}", settled.change);
    let found = fit(&model, &settled.evidence, None, Weighting::Joint).expect("fits");
    let last = found.x[found.x.len() - 1];
    assert!((last - 0.08).abs() < 1e-5, "{last}");

    let plain: Vec<Run> = runs.iter().map(|r| Run { model: None, ..r.clone() }).collect();
    let errors = prediction_errors(&plain, &predict(&model, &plain, &found.x).expect("predicts"));
    assert!(errors.pooled_percent < 1e-3, "{} %", errors.pooled_percent);
    let text =
        lacuna::text::to_ron(&ModelFile::new(&model, &found.x, &[], Default::default(), String::new()))
            .expect("writes");
    let file: ModelFile = lacuna::text::from_ron(&text).expect("reads");
    let (again, x) = file.on(&robot).expect("fits the robot");
    let (ours, theirs) = (predict(&model, &plain, &found.x), predict(&again, &plain, &x));
    assert_eq!(ours.expect("predicts"), theirs.expect("predicts"));
}

#[test]
fn model_torque_is_that_of_the_plant() {
    let robot = robot("panda.ron");
    let mut runs = vec![exact_run(&robot, 3)];
    let plain = with(TorqueGain::default());
    let model = Model::new(&robot, plain[..3].to_vec()).expect("fits the robot");
    let mut x = model
        .base
        .as_ref()
        .expect("rigid body is in")
        .coefficients(&robot.inertial_parameters().expect("has inertias"));
    x.extend([0.7; 7].into_iter().chain([0.3; 7]));
    refresh_model_torque(&model, &x, &mut runs).expect("computes");
    let torque = runs[0].model.as_ref().expect("is there").clone();
    for (joint, tau) in runs[0].tau.iter().enumerate() {
        for (k, measured) in tau.iter().enumerate() {
            let friction = 0.7 * runs[0].dq[joint][k] + 0.3;
            assert!((torque.total[joint][k] - measured).abs() < 1e-7, "joint {joint} sample {k}");
            assert!((torque.rigid[joint][k] + friction - measured).abs() < 1e-7, "joint {joint} sample {k}");
        }
    }
}

#[test]
fn without_rigid_links_the_remedy_is_named() {
    let robot = robot("two_link.ron");
    let mut runs = vec![exact_run(&robot, 3)];
    let folds = one_fold(&runs[0]);
    let model = Model::new(&robot, vec![Box::new(TorqueGain::default())]).expect("fits the robot");
    let error = settle(&model, &mut runs, &folds, Weighting::Joint).expect_err("nothing to scale");
    assert!(error.to_string().contains("rigid_body"), "{error}");
}
