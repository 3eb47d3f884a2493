//! The published Panda measurements, when `LACUNA_DATA` names the folder that holds them.
//!
//! Reference numbers were computed independently of this library (with numpy and Pinocchio) on the same
//! files; each states its settings.

use super::common;

use common::{data, json_numbers, robot};
use lacuna::effects::{CoulombFriction, Effect, RigidBody, TorqueOffset, ViscousFriction, classic};
use lacuna::identify::{Evidence, StaticFit, Weighting, fit, held_out, parameter_name, relative_deviations};
use lacuna::kernels::{Chain, LagrangianTerms, State, Workspace, inverse_dynamics};
use lacuna::log::{Log, StaticPoses};
use lacuna::model::Model;
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Mode, Run, Settings, VelocityFrom, prepare};

fn panda() -> Robot {
    robot("panda.ron")
}

fn exciting(settings: &Settings) -> Option<Run> {
    let file = data("panda/exciting.csv")?;
    let log = Log::open(file, &panda(), None).expect("the public log reads");
    Some(prepare(&log, settings).expect("the signal step works on it").0)
}

/// Values of Table III, column R-E, with the seven digits of the authors' code (0 for the two they drop).
fn table_iii(symbols: &[String]) -> Vec<Option<f64>> {
    let published = lacuna::scenario::Published::open(std::path::Path::new("scenarios/panda_table3.ron"))
        .expect("shipped file reads");
    symbols
        .iter()
        .map(|s| published.coefficients.iter().find(|(name, _)| name == s).map(|(_, value)| *value))
        .collect()
}

#[test]
fn static_poses_give_table_iii() {
    let Some(file) = data("panda/static_1010.csv") else { return };
    let robot = panda();
    let poses = StaticPoses::open(file, &robot).expect("reads");
    let fit = StaticFit::new(&robot, &poses).expect("determines all coefficients");
    assert_eq!(fit.base.rank(), 43);
    assert_eq!(fit.rows, 34_340, "28 rows of M and 6 of g per pose: the first carries nothing");
    assert_eq!(fit.silent_gravity, [0]);
    assert!((fit.condition_number - 48.906).abs() < 0.005, "{}", fit.condition_number);
    assert!((fit.relative_error_percent() - 0.001076).abs() < 1e-5, "{}", fit.relative_error_percent());
    let symbols: Vec<String> = fit.base.pivots.iter().map(|&p| parameter_name(p)).collect();
    for ((symbol, value), published) in symbols.iter().zip(&fit.coefficients).zip(table_iii(&symbols)) {
        let published = published.unwrap_or_else(|| panic!("{symbol} is not in Table III"));
        assert!((value - published).abs() < 5e-7, "{symbol}: {value} against {published}");
    }
}

#[test]
fn deviations_of_table_iii_follow_from_one_published_number() {
    let Some(file) = data("panda/static_1010.csv") else { return };
    let robot = panda();
    let poses = StaticPoses::open(file, &robot).expect("reads");
    let fit = StaticFit::new(&robot, &poses).expect("determines all coefficients");
    let sigma = fit.deviation_implied_by(0.0315);
    assert!((sigma - 1.764e-3).abs() < 1e-6, "{sigma}");
    let percents = relative_deviations(&fit.coefficients, &fit.standard_deviations(sigma));
    let symbols: Vec<String> = fit.base.pivots.iter().map(|&p| parameter_name(p)).collect();
    let dropped: Vec<&str> =
        symbols.iter().zip(&percents).filter(|(_, p)| **p > 30.0).map(|(s, _)| s.as_str()).collect();
    assert_eq!(dropped, ["Jxy3", "Jxz6"], "coefficients 8 and 24 of the table");
    for (symbol, printed) in TABLE_III_DEVIATIONS {
        let i = symbols.iter().position(|s| s == symbol).expect("a coefficient of the table");
        if *printed > 0.02 {
            assert!(
                (percents[i] / printed - 1.0).abs() < 2e-3,
                "{symbol}: {} against {printed}",
                percents[i]
            );
        }
    }
}

/// Relative standard deviations [%] as printed in Table III, column R-E.
const TABLE_III_DEVIATIONS: &[(&str, f64)] = &[
    ("Jzz1", 0.3735),
    ("Jxx2", 0.0176),
    ("Jxy2", 1.5625),
    ("Jxz2", 0.2698),
    ("Jyz2", 2.3330),
    ("Jzz2", 0.0091),
    ("Jxx3", 1.2664),
    ("Jxy3", 30.3622),
    ("Jxz3", 0.4874),
    ("Jyz3", 1.2379),
    ("Jzz3", 0.0691),
    ("Jxx4", 0.0202),
    ("Jxy4", 0.0274),
    ("Jxz4", 0.9079),
    ("Jyz4", 1.6177),
    ("Jzz4", 0.0103),
    ("Jxx5", 0.2739),
    ("Jxy5", 0.9578),
    ("Jxz5", 0.4932),
    ("Jyz5", 0.4345),
    ("Jzz5", 0.3169),
    ("Jxx6", 1.0591),
    ("Jxy6", 0.5331),
    ("Jxz6", 218.6430),
    ("Jyz6", 3.3084),
    ("Jzz6", 0.1773),
    ("Jxx7", 2.7378),
    ("Jxy7", 2.0320),
    ("Jxz7", 1.2299),
    ("Jyz7", 3.6756),
    ("Jzz7", 2.6129),
    ("mx2", 0.1551),
    ("my2", 0.0003),
    ("mx3", 0.0014),
    ("my3", 0.0353),
    ("mx4", 0.0016),
    ("my4", 0.0005),
    ("mx5", 0.0644),
    ("my5", 0.0074),
    ("mx6", 0.0034),
    ("my6", 0.0083),
    ("mx7", 0.0744),
    ("my7", 0.9490),
];

fn one_fold(run: &Run) -> Folds {
    Folds { fold: vec![0; run.rows().count], count: 1, description: "all rows together".to_string() }
}

fn in_sample(settings: &Settings) -> Option<(f64, f64)> {
    let run = exciting(settings)?;
    let model = Model::new(&panda(), classic()).expect("fits the robot");
    let folds = one_fold(&run);
    let evidence = Evidence::collect(&model, &[run], &folds).expect("collects");
    let fit = fit(&model, &evidence, None, Weighting::Ordinary).expect("fits");
    Some((fit.condition_number, fit.errors.pooled_percent))
}

#[test]
fn classical_identification_of_the_public_log() {
    let inputs = Settings { mode: Mode::Inputs, band_hz: 5.0, trim_s: 0.5, ..Settings::default() };
    let Some((condition, error)) = in_sample(&inputs) else { return };
    assert!((condition - 115.6).abs() < 0.3 && (error - 0.842).abs() < 0.02, "{condition} {error}");
    let parallel = Settings { mode: Mode::Parallel, position_cutoff_hz: 12.0, decimate: Some(1), ..inputs };
    let Some((condition, error)) = in_sample(&parallel) else { return };
    println!("parallel: condition number {condition:.2}, {error:.4} %");
    assert!((condition - 115.9).abs() < 0.3 && (error - 0.735).abs() < 0.01, "{condition} {error}");
}

/// 8 Hz band, parallel, positions at 6 Hz, trim 1 s, joint weights, sign as tanh(dq / 0.02), 8 folds of
/// equal phase of 13.333 s.
fn reference_hold_out(velocity_from: VelocityFrom) -> Option<f64> {
    let settings = Settings {
        mode: Mode::Parallel,
        band_hz: 8.0,
        position_cutoff_hz: 6.0,
        trim_s: 1.0,
        velocity_from,
        ..Settings::default()
    };
    let run = exciting(&settings)?;
    let effects: Vec<Box<dyn Effect>> = vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(CoulombFriction { width: 0.02, ..CoulombFriction::default() }),
        Box::new(TorqueOffset::default()),
    ];
    let model = Model::new(&panda(), effects).expect("fits the robot");
    let folds = Folds::same_phase(&[run.rows()], 13.333, 8).expect("valid folds");
    let evidence = Evidence::collect(&model, &[run], &folds).expect("collects");
    Some(held_out(&model, &evidence, Weighting::Joint).expect("fits").pooled_percent)
}

#[test]
fn held_out_error_of_the_classical_model() {
    let Some(logged) = reference_hold_out(VelocityFrom::Velocity) else { return };
    let Some(differentiated) = reference_hold_out(VelocityFrom::Position) else { return };
    println!("held out: {logged:.3} % with logged velocity, {differentiated:.3} % from position");
    assert!((logged - 1.27).abs() < 0.03, "{logged}");
    assert!((differentiated - 1.41).abs() < 0.03, "{differentiated}");
}

#[test]
#[allow(clippy::approx_constant)] // 0.318 N m is a measurement, not 1 / pi
fn friction_path_on_the_public_log() {
    if data("panda/exciting.csv").is_none() {
        return;
    }
    let mut quiet = |_: &str| {};
    let options = lacuna::study::Options::new(&mut quiet);
    let outcome = lacuna::study::run(std::path::Path::new("scenarios/panda_log.ron"), options).expect("runs");
    let without = [0.318, 0.591, 0.315, 0.591, 0.311, 0.186, 0.278];
    let with = [0.137, 0.312, 0.194, 0.220, 0.080, 0.073, 0.049];
    assert_eq!(outcome.report.friction.len(), 7);
    for (joint, (before, after)) in outcome.report.friction.iter().zip(without.into_iter().zip(with)) {
        for (ours, reference) in joint.rms.into_iter().zip([before, after]) {
            let rounding = 0.0005;
            assert!(
                (ours - reference).abs() < 0.02 * reference + rounding,
                "{}: {ours} against {reference}",
                joint.joint
            );
        }
    }
}

#[test]
fn probe_states_of_the_published_parameters() {
    let Some(file) = data("panda/expected.json") else { return };
    let text = std::fs::read_to_string(file).expect("reads");
    let expected: serde_json::Value = serde_json::from_str(&text).expect("is JSON");
    let robot = panda();
    let chain = Chain::new(&robot);
    let probes = expected["probes"].as_array().expect("a list");
    assert_eq!(probes.len(), 3);
    for probe in probes {
        let (q, dq, ddq) =
            (json_numbers(&probe["q"]), json_numbers(&probe["dq"]), json_numbers(&probe["ddq"]));
        let parameters = robot.inertial_parameters().expect("the file has inertias");
        let mut tau = vec![0.0; 7];
        let state = State::new(&q, &dq, &ddq);
        inverse_dynamics(&chain, &mut Workspace::new(&chain, 0.0), state, &parameters, &mut tau);
        let lagrangian = LagrangianTerms::new(&chain, &q, &dq, &parameters).torque(&ddq);
        let reference = json_numbers(&probe["tau_phat_fixed_c6z"]);
        assert_eq!(reference.len(), 7);
        for j in 0..7 {
            assert!((tau[j] - reference[j]).abs() < 1e-10, "joint {}: {} {}", j + 1, tau[j], reference[j]);
            assert!((lagrangian[j] - reference[j]).abs() < 1e-10);
        }
        let identified = torque_of_table_iii(&robot, state);
        for (ours, reference) in identified.iter().zip(json_numbers(&probe["tau_RE41"])) {
            assert!((ours - reference).abs() < 1e-10, "{ours} {reference}");
        }
    }
}

/// Torque of the 41 coefficients that the authors keep.
fn torque_of_table_iii(robot: &Robot, state: State<'_, f64>) -> Vec<f64> {
    let base = lacuna::identify::BaseParameters::new(robot);
    let symbols: Vec<String> = base.pivots.iter().map(|&p| parameter_name(p)).collect();
    let kept = |s: &str| s != "Jxy3" && s != "Jxz6";
    let values = table_iii(&symbols).into_iter().zip(&symbols);
    let coefficients: Vec<f64> = values.map(|(value, s)| value.filter(|_| kept(s)).unwrap_or(0.0)).collect();
    let (chain, parameters) = (Chain::new(robot), base.lift(&coefficients));
    let mut tau = vec![0.0; robot.dof()];
    inverse_dynamics(&chain, &mut Workspace::new(&chain, 0.0), state, &parameters, &mut tau);
    tau
}
