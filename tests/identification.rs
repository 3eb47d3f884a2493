//! Known truth comes back: base parameters, least squares, uncertainty, hold-out.

use super::common;

use common::robot;
use lacuna::effects::{CoulombFriction, Effect, RigidBody, TorqueOffset, ViscousFriction, classic};
use lacuna::excitation::{FourierMotion, panda_table_ii};
use lacuna::identify::{
    BaseParameters, Evidence, Fit, Weighting, fit, fit_huber, held_out, parameter_name, with_robust_sd,
};
use lacuna::model::Model;
use lacuna::plant::{self, PerJoint, Plant, Simulation};
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Run};

/// A simulated motion as a run without noise: the plant's own accelerations and torques.
fn exact_run(simulation: &Simulation, every: usize) -> Run {
    let truth = &simulation.truth;
    let thin = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
        columns.iter().map(|c| c.iter().step_by(every).copied().collect()).collect()
    };
    Run {
        name: "truth".to_string(),
        dt: (truth.t[1] - truth.t[0]) * every as f64,
        q: thin(&truth.q),
        dq: thin(&truth.dq),
        ddq: thin(&truth.ddq),
        tau: thin(&truth.tau),
        ..Run::default()
    }
}

fn simulated(robot: &Robot, viscous: f64) -> Simulation {
    let plant = Plant::new(robot.clone())
        .expect("has inertias")
        .with_effect(plant::ViscousFriction { coefficients: PerJoint::all(viscous) })
        .with_effect(plant::TorqueOffset { offsets: PerJoint::all(0.3) });
    let motion = FourierMotion::random(robot, 7, 5, 6.0, 0.6).expect("limits are known");
    plant.simulate(&motion, 8.0, 1).expect("simulates")
}

fn all_rows(run: &Run) -> Folds {
    Folds { fold: vec![0; run.rows().count], count: 1, description: String::new() }
}

fn fitted(model: &Model, run: &Run, weighting: Weighting) -> Fit {
    let evidence = Evidence::collect(model, std::slice::from_ref(run), &all_rows(run)).expect("collects");
    fit(model, &evidence, None, weighting).expect("fits")
}

fn linear_friction() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(TorqueOffset::default()),
    ]
}

#[test]
fn plant_parameters_come_back_on_every_shipped_robot() {
    for file in ["panda.ron", "two_link.ron", "six_axis.urdf"] {
        let robot = robot(file);
        let run = exact_run(&simulated(&robot, 0.7), 10);
        let model = Model::new(&robot, linear_friction()).expect("fits the robot");
        let found = fitted(&model, &run, Weighting::Ordinary);
        let base = model.base.as_ref().expect("rigid body is in");
        let truth = base.coefficients(&robot.inertial_parameters().expect("has inertias"));
        assert!(found.errors.pooled_percent < 1e-8, "{file}: {} %", found.errors.pooled_percent);
        let scale = truth.iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        for (i, expected) in truth.iter().enumerate() {
            let name = &model.columns[i].expression;
            assert!((found.x[i] - expected).abs() < 1e-7 * scale, "{file} {name}: {} {expected}", found.x[i]);
        }
        for (column, value) in model.columns.iter().zip(&found.x).skip(truth.len()) {
            let expected = if column.about.symbol.starts_with("fv") { 0.7 } else { 0.3 };
            assert!((value - expected).abs() < 1e-6, "{file} {}: {value}", column.about.symbol);
        }
    }
}

#[test]
fn panda_has_the_43_combinations_of_table_iii() {
    let base = BaseParameters::new(&robot("panda.ron"));
    assert_eq!(base.rank(), 43);
    let expressions: Vec<String> = (0..43).map(|i| base.expression(i)).collect();
    // Table III of the supplement to Gaz et al. 2019, entries 1, 2, 13, 33, 39, 43, in this notation.
    for expected in [
        "Jzz1 + Jyy2",
        "Jxx2 - Jyy2 + 0.09986 m3 + 0.632 mz3 + Jyy3 + 0.1067 (m4 + m5 + m6 + m7)",
        "Jxy4 + 0.03168 (m5 + m6 + m7) + 0.0825 mz5",
        "my2 - 0.316 (m3 + m4 + m5 + m6 + m7) - mz3",
        "my5 - mz6",
        "my7",
    ] {
        assert!(expressions.iter().any(|e| e == expected), "{expected} is not among {expressions:#?}");
    }
}

#[test]
fn two_link_arm_has_the_papers_eight_coefficients() {
    let robot = robot("two_link.ron");
    let base = BaseParameters::new(&robot);
    assert_eq!(base.rank(), 8);
    let values = base.coefficients(&robot.inertial_parameters().expect("has inertias"));
    let mut sorted = values.clone();
    sorted.sort_by(f64::total_cmp);
    // Section VI-C of the paper's supplement for p_real: (-1.816, 1.86, 0, 0, 0, -1.85, 2.1, 0).
    for (ours, published) in sorted.iter().zip([-1.85, -1.816, 0.0, 0.0, 0.0, 0.0, 1.86, 2.1]) {
        assert!((ours - published).abs() < 1e-6, "{values:?}");
    }
}

#[test]
fn coefficients_do_not_depend_on_what_torque_cannot_show() {
    let robot = robot("panda.ron");
    let base = BaseParameters::new(&robot);
    let parameters = robot.inertial_parameters().expect("has inertias");
    let lifted = base.lift(&base.coefficients(&parameters));
    let again = base.coefficients(&lifted);
    for (i, (a, b)) in base.coefficients(&parameters).iter().zip(&again).enumerate() {
        assert!((a - b).abs() < 1e-12, "{}", parameter_name(base.pivots[i]));
    }
}

#[test]
fn a_joint_that_rests_is_reported_and_the_rest_still_fitted() {
    let robot = robot("six_axis.urdf");
    let mut run = exact_run(&simulated(&robot, 0.5), 20);
    for column in [&mut run.dq, &mut run.ddq] {
        column[0].fill(0.0);
    }
    let model = Model::new(&robot, classic()).expect("fits the robot");
    let found = fitted(&model, &run, Weighting::Joint);
    let names: Vec<&str> = found.unexcited.iter().map(|&c| model.columns[c].about.symbol.as_str()).collect();
    assert!(names.contains(&"fv1") && names.contains(&"fc1") && !names.contains(&"fv2"), "{names:?}");
    assert!(found.x.iter().all(|x| x.is_finite()));
}

/// Noise that remembers: AR(1) with standard deviation `sigma`.
fn colored(n: usize, seed: u64, memory: f64, sigma: f64) -> Vec<f64> {
    use rand::{RngExt, SeedableRng};
    let mut rng = rand_xoshiro::Xoshiro256PlusPlus::seed_from_u64(seed);
    let mut state = 0.0;
    (0..n)
        .map(|_| {
            let white: f64 = (0..12).map(|_| rng.random_range(-0.5..0.5)).sum();
            state = memory * state + (1.0 - memory * memory).sqrt() * white;
            sigma * state
        })
        .collect()
}

/// Empirical spread of the estimates over noise draws against the two kinds of standard deviation:
/// median over parameters of (predicted / empirical).
fn calibration(memory: f64) -> (f64, f64) {
    let robot = robot("two_link.ron");
    let clean = exact_run(&simulated(&robot, 0.5), 10);
    let model = Model::new(&robot, classic()).expect("fits the robot");
    let mut estimates: Vec<Vec<f64>> = Vec::new();
    let (mut classical, mut robust) = (vec![0.0; model.columns.len()], vec![0.0; model.columns.len()]);
    let draws = 60;
    for draw in 0..draws {
        let mut run = clean.clone();
        for (j, tau) in run.tau.iter_mut().enumerate() {
            let noise = colored(tau.len(), 100 * draw + j as u64, memory, 0.5);
            tau.iter_mut().zip(noise).for_each(|(t, e)| *t += e);
        }
        let runs = [run];
        let evidence = Evidence::collect(&model, &runs, &all_rows(&runs[0])).expect("collects");
        let found = fit(&model, &evidence, None, Weighting::Ordinary).expect("fits");
        let found = with_robust_sd(&model, &runs, &evidence, found).expect("evaluates");
        for i in 0..model.columns.len() {
            classical[i] += found.classical_sd[i] / draws as f64;
            robust[i] += found.robust_sd[i] / draws as f64;
        }
        estimates.push(found.x);
    }
    let ratio = |predicted: &[f64]| -> f64 {
        let mut ratios: Vec<f64> = (0..predicted.len())
            .map(|i| {
                let mean = estimates.iter().map(|e| e[i]).sum::<f64>() / draws as f64;
                let variance =
                    estimates.iter().map(|e| (e[i] - mean).powi(2)).sum::<f64>() / (draws - 1) as f64;
                predicted[i] / variance.sqrt()
            })
            .collect();
        ratios.sort_by(f64::total_cmp);
        ratios[ratios.len() / 2]
    };
    (ratio(&classical), ratio(&robust))
}

#[test]
fn standard_deviations_are_right_for_white_and_for_colored_noise() {
    let (classical, _) = calibration(0.0);
    assert!((classical - 1.0).abs() < 0.15, "white noise: classical / empirical = {classical}");
    let (classical, robust) = calibration(0.9);
    assert!(classical < 0.5, "colored noise fools the classical deviation: {classical}");
    // Bartlett sums are known to be somewhat small where the memory is a good part of the bandwidth.
    assert!((0.6..1.25).contains(&robust), "robust / empirical = {robust}");
}

#[test]
fn robust_fit_shrugs_off_what_ruins_least_squares() {
    let robot = robot("two_link.ron");
    let clean = exact_run(&simulated(&robot, 0.5), 10);
    let model = Model::new(&robot, linear_friction()).expect("fits the robot");
    let truth = fitted(&model, &clean, Weighting::Ordinary).x;
    let mut run = clean.clone();
    for (j, tau) in run.tau.iter_mut().enumerate() {
        let noise = colored(tau.len(), 5 + j as u64, 0.0, 0.05);
        tau.iter_mut().zip(noise).for_each(|(t, e)| *t += e);
        tau.iter_mut().step_by(17).for_each(|t| *t += 40.0);
    }
    let folds = all_rows(&run);
    let plain = fitted(&model, &run, Weighting::Joint);
    let runs = [run];
    let evidence = Evidence::collect(&model, &runs, &folds).expect("collects");
    let huber = fit_huber(&model, &runs, &folds, &evidence).expect("fits");
    let distance = |x: &[f64]| x.iter().zip(&truth).map(|(a, b)| (a - b).powi(2)).sum::<f64>().sqrt();
    assert!(distance(&huber.x) < 0.1 * distance(&plain.x), "{} {}", distance(&huber.x), distance(&plain.x));
}

#[test]
fn held_out_error_sees_what_the_fit_cannot_explain() {
    let robot = robot("two_link.ron");
    let run = exact_run(&simulated(&robot, 0.5), 10);
    let folds = Folds::contiguous(&[run.rows()], 1.0, 4).expect("long enough");
    let with = Model::new(&robot, linear_friction()).expect("fits the robot");
    let evidence = Evidence::collect(&with, std::slice::from_ref(&run), &folds).expect("collects");
    let full = held_out(&with, &evidence, Weighting::Ordinary).expect("fits").pooled_percent;
    assert!(full < 1e-6, "the right model predicts what it has not seen: {full} %");
    let rigid: Vec<Box<dyn Effect>> =
        vec![Box::new(RigidBody::default()), Box::new(CoulombFriction::default())];
    let without = Model::new(&robot, rigid).expect("fits the robot");
    let evidence = Evidence::collect(&without, std::slice::from_ref(&run), &folds).expect("collects");
    let inside = fit(&without, &evidence, None, Weighting::Ordinary).expect("fits").errors.pooled_percent;
    let outside = held_out(&without, &evidence, Weighting::Ordinary).expect("fits").pooled_percent;
    assert!(outside > inside && inside > 0.1, "in sample {inside} %, held out {outside} %");
}

#[test]
fn too_few_rows_are_refused() {
    let robot = robot("panda.ron");
    let mut run = exact_run(&simulated(&robot, 0.5), 10);
    for columns in [&mut run.q, &mut run.dq, &mut run.ddq, &mut run.tau] {
        columns.iter_mut().for_each(|c| c.truncate(5));
    }
    let model = Model::new(&robot, classic()).expect("fits the robot");
    let evidence = Evidence::collect(&model, std::slice::from_ref(&run), &all_rows(&run)).expect("collects");
    let error = fit(&model, &evidence, None, Weighting::Ordinary).expect_err("5 samples cannot do");
    assert!(error.to_string().contains("35 rows for 64 unknowns"), "{error}");
}

#[test]
fn published_motion_excites_all_coefficients() {
    let robot = robot("panda.ron");
    let plant = Plant::new(robot.clone()).expect("has inertias");
    let simulation = plant.simulate(&panda_table_ii(), 13.333, 1).expect("simulates");
    let run = exact_run(&simulation, 10);
    let model = Model::new(&robot, classic()).expect("fits the robot");
    let found = fitted(&model, &run, Weighting::Ordinary);
    assert!(found.unexcited.is_empty());
    assert!((60.0..130.0).contains(&found.condition_number), "{}", found.condition_number);
}

#[test]
fn model_files_come_back_as_they_were_written() {
    use lacuna::model_file::ModelFile;
    let robot = robot("panda.ron");
    let run = exact_run(&simulated(&robot, 0.5), 20);
    let model = Model::new(&robot, classic()).expect("fits the robot");
    let found = fitted(&model, &run, Weighting::Joint);
    let file =
        ModelFile::new(&model, &found.x, &found.classical_sd, Default::default(), "a test".to_string());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("model.ron");
    file.write(&path).expect("writes");
    let (again, x) = ModelFile::open(&path).expect("reads").on(&robot).expect("fits the robot");
    assert_eq!(again.columns, model.columns);
    for (a, b) in x.iter().zip(&found.x) {
        assert!((a - b).abs() <= 1e-15 * b.abs(), "{a} {b}");
    }
}
