//! Effects built from the model's torque in a whole study, and its model file afterwards.

use std::fmt::Write;

use lacuna::log::Log;
use lacuna::model_file::ModelFile;
use lacuna::predict::{predict, prediction_errors};
use lacuna::signals::prepare;
use lacuna::{study, text};

use super::common::robot;
use super::settled::exact_run;

#[test]
fn a_model_file_repeats_the_errors_of_its_study() {
    let robot = robot("two_link.ron");
    let run = exact_run(&robot, 5);
    let mut csv = String::from("t,q1,q2,dq1,dq2,tau1,tau2\n");
    for k in 0..run.samples() {
        let row = [&run.q, &run.dq, &run.tau].map(|list| (list[0][k], list[1][k]));
        let t = run.dt * k as f64;
        let [(q1, q2), (v1, v2), (tau1, tau2)] = row;
        writeln!(csv, "{t},{q1},{q2},{v1},{v2},{tau1},{}", 1.06 * tau2).expect("writes");
    }
    let folder = tempfile::tempdir().expect("a folder");
    let log = folder.path().join("log.csv");
    std::fs::write(&log, csv).expect("writes");
    let robot_file = std::env::current_dir().expect("is there").join("robots/two_link.ron");
    let scenario = format!(
        "(robot: {robot_file:?}, logs: Files(fit: [\"log.csv\"]), effects: [
            {{\"rigid_body\": ()}}, {{\"viscous_friction\": ()}}, {{\"torque_offset\": ()}},
            {{\"torque_gain\": (joints: Only([\"2\"]))}},
        ])"
    );
    let path = folder.path().join("gain.ron");
    std::fs::write(&path, scenario).expect("writes");
    let mut progress = |_: &str| {};
    let options = study::Options::new(&mut progress);
    let outcome = study::run(&path, options).expect("runs");
    assert!(outcome.report.warnings.iter().all(|w| !w.contains("settle")), "{:?}", outcome.report.warnings);

    let report = outcome.report.identification.expect("was identified");
    let gain = report.coefficients.iter().find(|c| c.symbol == "gain2").expect("is there");
    assert!((gain.value.expect("a number") - 0.06).abs() < 0.003, "{:?}", gain.value);

    let written = text::to_ron(&outcome.model.expect("a model")).expect("writes");
    let file: ModelFile = text::from_ron(&written).expect("reads");
    let (model, x) = file.on(&robot).expect("fits the robot");
    let (run, _) = prepare(&Log::open(&log, &robot, None).expect("reads"), &file.signals).expect("prepares");
    let runs = [run];
    let errors = prediction_errors(&runs, &predict(&model, &runs, &x).expect("predicts"));
    for (joint, rms) in report.joints.iter().zip(&errors.rms) {
        assert!((joint.rms - rms).abs() <= 1e-9 * rms, "{}: {} {rms}", joint.name, joint.rms);
    }
}
