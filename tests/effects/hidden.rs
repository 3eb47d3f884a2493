//! Effects hidden in a plant, which has them in its own words, come back in a fit of everything together.

use lacuna::effects::Effect;
use lacuna::plant::PlantEffect;
use lacuna::text::from_ron;

use super::common::robot;
use super::recovered::{found, plant, truth};

/// Phase of hidden waves \[rad\].
const PHASE: f64 = 0.5;

/// Hides `hidden` in a Panda and fits `effects`; compares the parameters of the last one.
fn check(hidden: &str, effects: &[&str], expected: &[f64], part: f64) {
    let robot = robot("panda.ron");
    let mut with = plant(&robot);
    with.effects.push(from_ron::<Box<dyn PlantEffect>>(hidden).expect("reads"));
    let truth = truth(&with, &robot);
    let read = |text: &&str| from_ron::<Box<dyn Effect>>(text).expect("reads");
    let values = found(&robot, &truth, effects.iter().map(read).collect());
    assert_eq!(values.len(), expected.len());
    for (value, expected) in values.iter().zip(expected) {
        assert!((value - expected).abs() < part * expected.abs(), "{hidden}: {values:?}, not {expected:?}");
    }
}

/// The list of one number per joint that is `value` for joint 4.
fn fourth(value: f64) -> String {
    format!("[0, 0, 0, {value}, 0, 0, 0]")
}

#[test]
fn shapes_over_velocity() {
    let (one, two) = (fourth(1.0), fourth(0.4));
    check(
        &format!("{{\"asymmetric_friction\": (viscous_forward: {one}, viscous_backward: {two})}}"),
        &["{\"asymmetric_friction\": (joints: Only([\"4\"]), width: 0.005)}"],
        &[0.3],
        0.01,
    );
    check(
        &format!("{{\"nonlinear_viscous_friction\": (coefficients: {}, exponent: 2)}}", fourth(0.2)),
        &["{\"nonlinear_viscous_friction\": (joints: Only([\"4\"]))}"],
        &[0.2],
        0.01,
    );
    let (height, steepness, shift) = (fourth(1.0), fourth(8.0), fourth(0.02));
    check(
        &format!("{{\"sigmoid_friction\": (phi1: {height}, phi2: {steepness}, phi3: {shift})}}"),
        &["{\"sigmoid_friction\": (joints: Only([\"4\"]), phi2: [8], phi3: [0.02])}"],
        &[1.0],
        0.01,
    );
    let (level, speed) = (fourth(0.4), "[0.1, 0.1, 0.1, 0.1, 0.1, 0.1, 0.1]");
    check(
        &format!("{{\"stribeck_friction\": (levels: {level}, velocities: {speed}, width: 0.02)}}"),
        &["{\"stribeck_friction\": (joints: Only([\"4\"]), vs: 0.1, width: 0.02)}"],
        &[0.4],
        0.01,
    );
}

#[test]
fn shapes_over_position() {
    let (sine, cosine) = (PHASE.cos(), PHASE.sin());
    let phases = fourth(PHASE);
    check(
        &format!(
            "{{\"torque_ripple\": (amplitudes: {}, harmonics: {}, phases: {phases})}}",
            fourth(0.2),
            fourth(7.0)
        ),
        &["{\"torque_ripple\": (joints: Only([\"4\"]), k: 7)}"],
        &[0.2 * sine, 0.2 * cosine],
        0.01,
    );
    check(
        &format!(
            "{{\"position_dependent_friction\": (levels: {}, harmonics: {}, phases: {phases}, width: 0.02)}}",
            fourth(0.3),
            fourth(3.0)
        ),
        &["{\"position_dependent_friction\": (joints: Only([\"4\"]), k: 3, width: 0.02)}"],
        &[0.3 * sine, 0.3 * cosine],
        0.01,
    );
    check(
        &format!("{{\"joint_spring\": (stiffness: {}, rest: {})}}", fourth(2.0), fourth(0.1)),
        &["{\"joint_spring\": (joints: Only([\"4\"]))}"],
        &[2.0],
        0.01,
    );
}

#[test]
fn shapes_over_time_and_other_joints() {
    check(
        &format!("{{\"torque_drift\": (rates: {})}}", fourth(0.05)),
        &["{\"torque_drift\": (joints: Only([\"4\"]))}"],
        &[0.05],
        0.01,
    );
    check(
        &format!("{{\"friction_drift\": (coulomb: {}, time_s: Some(3), width: 0.02)}}", fourth(0.5)),
        &["{\"friction_drift\": (joints: Only([\"4\"]), course: Settling(time_s: 3), width: 0.02)}"],
        // Half a unit at the start of the simulation, whose first 1.5 s are not in the run.
        &[0.5 * f64::exp(-0.5)],
        0.01,
    );
    check(
        "{\"coupled_friction\": (joint: 4, from: 5, viscous: 0.2, coulomb: 0.3, width: 0.02)}",
        &["{\"coupled_friction\": (joint: \"4\", from: \"5\", width: 0.02)}"],
        &[0.2, 0.3],
        0.01,
    );
}

#[test]
fn hysteresis_and_load() {
    check(
        &format!("{{\"presliding_hysteresis\": (levels: {}, stiffness: {})}}", fourth(0.5), fourth(200.0)),
        &[
            "{\"coulomb_friction\": (joints: Only([\"4\"]), width: 0.01)}",
            "{\"presliding_hysteresis\": (joints: Only([\"4\"]), s: 200, width: 0.01)}",
        ],
        &[0.5],
        0.05,
    );
    check(
        &format!("{{\"load_dependent_friction\": (ratios: {}, width: 0.02)}}", fourth(0.1)),
        &["{\"load_dependent_friction\": (joints: Only([\"4\"]), width: 0.02)}"],
        &[0.1],
        0.03,
    );
}
