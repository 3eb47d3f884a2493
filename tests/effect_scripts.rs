//! Effect scripts: what the shipped ones compute, that known truth comes back through them, and what is refused.

use super::common;

#[path = "effect_scripts/budget.rs"]
mod budget;
#[path = "effect_scripts/refused.rs"]
mod refused;

use std::path::{Path, PathBuf};

use common::robot;
use lacuna::effects::{Effect, Joints, RigidBody, ScriptedEffect};
use lacuna::excitation::FourierMotion;
use lacuna::identify::{Evidence, Fit, Weighting, fit, settle};
use lacuna::model::{Model, ModelBlock};
use lacuna::model_file::ModelFile;
use lacuna::plant::{Moment, Plant, PlantEffect, Simulation};
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Run};
use serde::{Deserialize, Serialize};

fn shipped(name: &str) -> ScriptedEffect {
    ScriptedEffect::open(&Path::new("effects").join(name), Joints::All).expect("a shipped script reads")
}

fn scripted(text: &str) -> lacuna::Result<ScriptedEffect> {
    ScriptedEffect::from_text(Path::new("test.rhai"), text.to_string(), Joints::All)
}

/// A script with one parameter `k` and these columns.
fn one(columns: &str) -> String {
    format!(
        "fn about() {{ #{{ title: \"t\", text: \"t\", equation: \"e\", parameters: [#{{ symbol: \"k\", unit: \"N m\", \
         meaning: \"m\" }}] }} }}\nfn columns(joint, now, memory, with) {{\n{columns}\n}}"
    )
}

/// A motion of the two-link robot, nothing but numbers.
fn motion(samples: usize) -> Run {
    let wave = |j: usize, k: usize, shift: f64| (0.013 * (j + 2) as f64 * k as f64 + shift).sin();
    let of = |shift: f64| (0..2).map(|j| (0..samples).map(|k| 2.6 * wave(j, k, shift)).collect()).collect();
    Run {
        name: "made up".into(),
        dt: 0.01,
        q: of(0.1),
        dq: of(1.3),
        ddq: of(2.0),
        tau: of(0.7),
        ..Run::default()
    }
}

/// All columns of one effect, `[joint][column]`, computed in stretches of `length` samples.
fn columns(
    effect: &dyn Effect,
    robot: &Robot,
    run: &Run,
    length: usize,
) -> lacuna::Result<Vec<Vec<Vec<f64>>>> {
    let model = Model::new(robot, vec![effect.boxed()])?;
    let mut all: Vec<Vec<Vec<f64>>> = model.active.iter().map(|a| vec![Vec::new(); a.len()]).collect();
    let mut block = ModelBlock::new(&model, length);
    for first in (0..run.samples()).step_by(length) {
        let range = first..(first + length).min(run.samples());
        model.fill(run, range.clone(), &mut block)?;
        for (joint, columns) in all.iter_mut().enumerate() {
            for (local, column) in columns.iter_mut().enumerate() {
                column.extend_from_slice(block.column(joint, local, range.len()));
            }
        }
    }
    Ok(all)
}

#[track_caller]
fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-12 * (1.0 + b.abs()), "{a} is not {b}");
}

#[test]
fn shipped_scripts_compute_their_equations() {
    let arm = robot("two_link.ron");
    let mut run = motion(700);
    let column = |name: &str, run: &Run| columns(&shipped(name), &arm, run, 128).expect(name);
    let (square, stop) = (column("quadratic_friction.rhai", &run), column("end_stop.rhai", &run));
    let warm = column("warm_friction.rhai", &run);
    for j in 0..2 {
        let mut heat = 0.0;
        for k in 0..700 {
            let (q, v) = (run.q[j][k], run.dq[j][k]);
            near(square[j][0][k], v * v.abs());
            near(stop[j][0][k], (q - 2.0).max(0.0) + (q + 2.0).min(0.0));
            if k > 0 {
                heat += (1.0 - (-0.01_f64 / 60.0).exp()) * (v * v - heat);
            }
            near(warm[j][0][k], heat * v);
        }
    }
    assert!(
        stop[0][0].iter().any(|x| *x > 0.1) && stop[0][0].iter().any(|x| *x < -0.1),
        "both bumpers are met"
    );
    run.channels.insert("temperature2".into(), (0..700).map(|k| 20.0 + 0.02 * f64::from(k)).collect());
    run.channels.insert("temperature".into(), vec![30.0; 700]);
    let channel = column("channel_friction.rhai", &run);
    for k in 0..700 {
        let direction = |j: usize| (run.dq[j][k] / 0.01).tanh();
        near(channel[0][0][k], 5.0 * direction(0));
        near(channel[1][0][k], (0.02 * k as f64 - 5.0) * direction(1));
        // joint1 is the neighbour of both.
        near(channel[0][1][k], run.q[0][k]);
        near(channel[1][1][k], run.q[0][k]);
    }
}

#[test]
fn columns_do_not_depend_on_how_a_run_is_cut() {
    let arm = robot("two_link.ron");
    let run = motion(1000);
    let whole = columns(&shipped("warm_friction.rhai"), &arm, &run, 1000).expect("computes");
    for length in [1, 7, 128, 999] {
        let cut = columns(&shipped("warm_friction.rhai"), &arm, &run, length).expect("computes");
        assert_eq!(bits(&cut), bits(&whole), "{length}");
    }
    // The same effect on another run forgets the first.
    let effect = shipped("warm_friction.rhai");
    columns(&effect, &arm, &run, 100).expect("computes");
    let other = Run { dq: run.ddq.clone(), ..motion(1000) };
    let fresh = columns(&shipped("warm_friction.rhai"), &arm, &other, 100).expect("computes");
    assert_eq!(bits(&columns(&effect, &arm, &other, 100).expect("computes")), bits(&fresh));
    let slower = effect.with_shapes(&[600.0]);
    assert_ne!(bits(&columns(slower.as_ref(), &arm, &run, 100).expect("computes")), bits(&whole));
}

fn bits(all: &[Vec<Vec<f64>>]) -> Vec<u64> {
    all.iter().flatten().flatten().map(|x| x.to_bits()).collect()
}

/// The plant's own air drag, 0.4 and 0.15 N m s²/rad², and a gear that warms up within 0.8 s.
#[derive(Debug, Serialize, Deserialize)]
struct DragAndWarmth;

#[typetag::serde(name = "test_drag_and_warmth")]
impl PlantEffect for DragAndWarmth {
    fn check(&self, _: usize) -> lacuna::Result<()> {
        Ok(())
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, drag) in [0.4, 0.15].into_iter().enumerate() {
            load[j] += drag * now.dq[j].powi(2).copysign(now.dq[j]) + (1.0 - 0.6 * now.own[j]) * now.dq[j];
        }
    }

    fn states(&self, dof: usize) -> usize {
        dof
    }

    fn rates(&self, now: &Moment, rates: &mut [f64]) {
        for (rate, (heat, v)) in rates.iter_mut().zip(now.own.iter().zip(now.dq)) {
            *rate = (v * v - heat) / 0.8;
        }
    }
}

/// The plant's own accelerations and torques, without noise.
fn exact(simulation: &Simulation) -> Run {
    let truth = &simulation.truth;
    let columns = |c: &[Vec<f64>]| c.to_vec();
    Run {
        name: "plant".into(),
        dt: truth.t[1] - truth.t[0],
        q: columns(&truth.q),
        dq: columns(&truth.dq),
        ddq: columns(&truth.ddq),
        tau: columns(&truth.tau),
        ..Run::default()
    }
}

fn warm(warm_up: f64) -> Box<dyn Effect> {
    shipped("warm_friction.rhai").with_shapes(&[warm_up])
}

fn fitted(arm: &Robot, run: &Run, effects: Vec<Box<dyn Effect>>) -> (Model, Fit) {
    let model = Model::new(arm, effects).expect("fits the robot");
    let folds = Folds { fold: vec![0; run.rows().count], count: 1, description: String::new() };
    let evidence = Evidence::collect(&model, std::slice::from_ref(run), &folds).expect("collects");
    let found = fit(&model, &evidence, None, Weighting::Ordinary).expect("fits");
    (model, found)
}

#[test]
fn the_plants_own_drag_and_warmth_come_back() {
    let arm = robot("two_link.ron");
    let motion = FourierMotion::random(&arm, 3, 4, 5.0, 0.6).expect("limits are known");
    let plant = Plant::new(arm.clone()).expect("has inertias").with_effect(DragAndWarmth);
    let run = exact(&plant.simulate(&motion, 6.0, 1).expect("simulates"));
    let effects = |warm_up: f64| -> Vec<Box<dyn Effect>> {
        let drag = shipped("quadratic_friction.rhai").boxed();
        vec![
            Box::new(RigidBody::default()),
            Box::new(lacuna::effects::ViscousFriction::default()),
            drag,
            warm(warm_up),
        ]
    };
    let (model, found) = fitted(&arm, &run, effects(0.8));
    let value = |symbol: &str| {
        let place = model.columns.iter().position(|c| c.about.symbol == symbol).expect(symbol);
        found.x[place]
    };
    for (symbol, truth) in
        [("fq1", 0.4), ("fq2", 0.15), ("fv1", 1.0), ("fv2", 1.0), ("fw1", -0.6), ("fw2", -0.6)]
    {
        println!("{symbol} = {} ({truth})", value(symbol));
        // The script's heat goes in steps of 1 ms.
        assert!((value(symbol) - truth).abs() < 5e-3, "{symbol} = {}", value(symbol));
    }
    // Both signs of the limits: nothing here is implausible, and the opposite is.
    assert_eq!(model.effects[2].implausible(&arm, &[0.4, 0.15]), None);
    let why = model.effects[3].implausible(&arm, &[-0.6, 0.6]).expect("warmth that brakes");
    assert!(why.contains("fw = 0.6"), "{why}");
    // A wrong time constant fits worse: the shape can be found.
    let error = |warm_up: f64| fitted(&arm, &run, effects(warm_up)).1.errors.pooled_percent;
    assert!(error(0.8) < 0.2 * error(3.0).min(error(10.0)), "{} {} {}", error(0.8), error(3.0), error(10.0));
}

#[test]
fn models_carry_their_scripts_along() {
    let arm = robot("two_link.ron");
    let run = motion(800);
    let (model, found) = fitted(&arm, &run, vec![Box::new(RigidBody::default()), warm(5.0)]);
    let file = ModelFile::new(&model, &found.x, &found.classical_sd, Default::default(), "a test".into());
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("model.ron");
    file.write(&path).expect("writes");
    let (again, x) = ModelFile::open(&path).expect("reads").on(&arm).expect("fits the robot");
    assert_eq!(again.columns, model.columns);
    assert!(x.iter().zip(&found.x).all(|(a, b)| (a - b).abs() <= 1e-15 * b.abs()));
    let both = [&model, &again].map(|m| columns(m.effects[1].as_ref(), &arm, &run, 100).expect("computes"));
    assert_eq!(bits(&both[0]), bits(&both[1]));
}

#[test]
fn scenarios_load_scripts_from_their_folder() {
    let mut effect: Box<dyn Effect> = lacuna::text::from_ron(
        r#"{"script": (path: "../effects/end_stop.rhai", joints: Only(["joint2"]), with: {"high": 1.5})}"#,
    )
    .expect("RON");
    let arm = robot("two_link.ron");
    assert!(effect.terms(&arm).expect_err("not loaded").message().contains("not been read"));
    effect.load(Path::new("scenarios")).expect("loads");
    let terms = effect.terms(&arm).expect("fits");
    assert_eq!(terms.len(), 1);
    assert_eq!(
        (terms[0].symbol.as_str(), terms[0].unit, terms[0].joints.as_slice()),
        ("kb2", "N m/rad", &[1][..])
    );
    let run = motion(300);
    let found = columns(effect.as_ref(), &arm, &run, 300).expect("computes");
    assert!(found[0].is_empty());
    for (column, q) in found[1][0].iter().zip(&run.q[1]) {
        near(*column, (q - 1.5).max(0.0) + (q + 2.0).min(0.0));
    }
    let mut out: Box<dyn Effect> =
        lacuna::text::from_ron(r#"{"script": (path: "../../../../etc/passwd")}"#).expect("RON");
    assert!(out.load(Path::new("scenarios")).expect_err("outside").to_string().contains("leaves"));
    let typo = lacuna::text::from_ron::<Box<dyn Effect>>(r#"{"script": (path: "x", joint: All)}"#);
    assert!(typo.expect_err("unknown field").to_string().contains("joint"));
}

#[test]
fn friction_under_load_is_fitted_in_turns_with_the_model() {
    let arm = robot("two_link.ron");
    let effect = scripted(&one("[abs(now.load) * tanh(now.dq_sharp / 0.02)]")).expect("reads");
    let needs_torque = |effect: &dyn Effect| effect.needs_torque();
    assert!(needs_torque(&effect) && !needs_torque(&shipped("end_stop.rhai")));
    let motion = FourierMotion::random(&arm, 3, 4, 5.0, 0.6).expect("limits are known");
    let plant = Plant::new(arm.clone()).expect("has inertias");
    let mut run = exact(&plant.simulate(&motion, 5.0, 1).expect("simulates"));
    // The plant has no friction, so its torque is the load; a tenth of it brakes.
    for (tau, dq) in run.tau.iter_mut().zip(&run.dq) {
        tau.iter_mut().zip(dq).for_each(|(t, v)| *t += 0.1 * t.abs() * (v / 0.02).tanh());
    }
    let model = Model::new(&arm, vec![Box::new(RigidBody::default()), effect.boxed()]).expect("fits");
    let folds = Folds { fold: vec![0; run.rows().count], count: 1, description: String::new() };
    let mut runs = [run];
    let settled = settle(&model, &mut runs, &folds, Weighting::Ordinary).expect("settles");
    let found = fit(&model, &settled.evidence, None, Weighting::Ordinary).expect("fits");
    let value =
        |symbol: &str| found.x[model.columns.iter().position(|c| c.about.symbol == symbol).expect(symbol)];
    println!("k1 = {}, k2 = {}", value("k1"), value("k2"));
    assert!((value("k2") - 0.1).abs() < 1e-4 && (value("k1") - 0.1).abs() < 1e-4);
}

#[test]
fn one_parameter_may_stand_for_all_joints() {
    let text = one("[now.dq]").replace("meaning: \"m\"", "meaning: \"m\", common: true");
    let arm = robot("two_link.ron");
    let effect = scripted(&text).expect("reads");
    let terms = effect.terms(&arm).expect("fits");
    assert_eq!(terms.len(), 1);
    assert_eq!((terms[0].symbol.as_str(), terms[0].joints.as_slice()), ("k", &[0, 1][..]));
    let run = motion(50);
    let found = columns(&effect, &arm, &run, 50).expect("computes");
    assert_eq!(found[0][0], run.dq[0]);
    assert_eq!(found[1][0], run.dq[1]);
}

#[test]
fn check_explains_and_tries_a_script() {
    use lacuna::check::{Kind, Options, file};
    let arm = robot("two_link.ron");
    let motion = FourierMotion::random(&arm, 3, 4, 5.0, 0.6).expect("limits are known");
    let plant = Plant::new(arm).expect("has inertias").with_effect(DragAndWarmth);
    let log = plant.simulate(&motion, 12.0, 1).expect("simulates").log;
    let folder = tempfile::tempdir().expect("a folder");
    let data = folder.path().join("log.csv");
    std::fs::write(&data, csv(&log)).expect("writes");
    let options = |robot: bool, data: Option<PathBuf>| Options {
        robot: robot.then(|| "robots/two_link.ron".into()),
        data,
        ..Options::default()
    };
    let path = Path::new("effects/quadratic_friction.rhai");
    for options in [options(false, None), options(true, None), options(true, Some(data))] {
        let report = file(path, &options);
        println!("{}", report.text());
        assert!(report.is_sound() && report.kind == Some(Kind::EffectScript), "{:?}", report.problems);
        let text = report.text();
        assert!(text.contains("tau_j = fq_j dq_j |dq_j|") && text.contains("at least 0"), "{text}");
        assert_eq!(text.contains("tried on"), options.data.is_some());
        assert_eq!(text.contains("fq1 = "), options.data.is_some(), "{text}");
    }
    let wrong = folder.path().join("wrong.rhai");
    std::fs::write(&wrong, one("[now.dq, 1.0]")).expect("writes");
    let report = file(&wrong, &options(true, None));
    assert_eq!(report.problems[0].line, Some(2), "{:?}", report.problems);
}

fn csv(log: &lacuna::log::Log) -> String {
    let mut text = String::from("t,q1,q2,dq1,dq2,tau1,tau2\n");
    let dq = log.dq.as_ref().expect("velocities are logged");
    for k in 0..log.t.len() {
        let row = [log.t[k], log.q[0][k], log.q[1][k], dq[0][k], dq[1][k], log.tau[0][k], log.tau[1][k]];
        text += &(row.map(|x| x.to_string()).join(",") + "\n");
    }
    text
}
