//! Columns of one joint, against their formulas written out by hand.

use lacuna::effects::{
    AsymmetricFriction, CoupledFriction, Course, Effect, FrictionDrift, FrictionPart, JointSpring, Joints,
    LoadDependentFriction, NonlinearViscousFriction, PositionDependentFriction, RotorInertia,
    StribeckFriction, ThermalFriction, TorqueDrift, TorqueRipple, Warmth,
};

use super::common::robot;
use super::motion::{columns, joint_at, run, torque};

fn third() -> Joints {
    Joints::Only(vec!["3".to_string()])
}

/// Checks the columns of an effect that acts on joint 3 alone against formulas of (q, dq, ddq, t).
fn check(effect: &dyn Effect, formulas: &[&dyn Fn([f64; 3], f64) -> f64]) {
    let robot = robot("panda.ron");
    let run = run(&robot, 0.01, 400);
    let found = columns(&robot, &run, effect);
    assert_eq!(found.len(), formulas.len(), "{effect:?}");
    let mut size = 0.0_f64;
    for (column, formula) in found.iter().zip(formulas) {
        for joint in 0..7 {
            for k in 0..400 {
                let t = 0.01 * k as f64;
                let expected = if joint == 2 { formula(joint_at(2, t), t) } else { 0.0 };
                let y = column[joint][k];
                assert!((y - expected).abs() < 1e-12, "{effect:?}: joint {joint} at {t} s: {y} {expected}");
                size = size.max(expected.abs());
            }
        }
    }
    assert!(size > 0.05, "{effect:?} hardly acts: {size}");
}

fn signum(v: f64) -> f64 {
    if v < 0.0 { -1.0 } else { 1.0 }
}

#[test]
fn asymmetric_friction_is_a_v_over_velocity() {
    check(&AsymmetricFriction { joints: third(), width: 0.0 }, &[&|[_, v, _], _| v.abs()]);
    let smooth = |[_, v, _]: [f64; 3], _: f64| v * (v / 0.1).tanh();
    check(&AsymmetricFriction { joints: third(), width: 0.1 }, &[&smooth]);
}

#[test]
fn nonlinear_viscous_friction_has_the_power_it_says() {
    let of = |exponent| NonlinearViscousFriction { joints: third(), exponent, width: 0.0 };
    check(&of(2.0), &[&|[_, v, _], _| v * v.abs()]);
    check(&of(3.0), &[&|[_, v, _], _| v * v * v]);
    check(&of(1.5), &[&|[_, v, _], _| signum(v) * v.abs().powf(1.5)]);
}

#[test]
fn stribeck_friction_fades_with_speed() {
    let effect = StribeckFriction { joints: third(), vs: 0.3, width: 0.0 };
    check(&effect, &[&|[_, v, _], _| signum(v) * (-v * v / 0.09).exp()]);
    let smooth = effect.with_width(0.05);
    check(smooth.as_ref(), &[&|[_, v, _], _| (v / 0.05).tanh() * (-v * v / 0.09).exp()]);
    let other = effect.with_shapes(&[0.6]);
    check(other.as_ref(), &[&|[_, v, _], _| signum(v) * (-v * v / 0.36).exp()]);
}

#[test]
fn waves_over_position() {
    let ripple = TorqueRipple { joints: third(), k: 6.5 };
    check(&ripple, &[&|[q, ..], _| (6.5 * q).sin(), &|[q, ..], _| (6.5 * q).cos()]);
    let friction = PositionDependentFriction { joints: third(), k: 3.0, width: 0.0 };
    check(
        &friction,
        &[&|[q, v, _], _| signum(v) * (3.0 * q).sin(), &|[q, v, _], _| signum(v) * (3.0 * q).cos()],
    );
}

#[test]
fn spring_rotor_and_drifts() {
    check(&JointSpring { joints: third(), reference: 0.2 }, &[&|[q, ..], _| q - 0.2]);
    check(&RotorInertia { joints: third() }, &[&|[_, _, a], _| a]);
    check(&TorqueDrift { joints: third() }, &[&|_, t| t]);
    let course = Course::Settling { time_s: 2.0 };
    let settling = FrictionDrift { joints: third(), part: FrictionPart::Both, course, width: 0.02 };
    check(
        &settling,
        &[&|[_, v, _], t| v * (-t / 2.0).exp(), &|[_, v, _], t| (v / 0.02).tanh() * (-t / 2.0).exp()],
    );
    let linear =
        FrictionDrift { joints: third(), part: FrictionPart::Coulomb, course: Course::Linear, width: 0.0 };
    check(&linear, &[&|[_, v, _], t| signum(v) * t]);
}

#[test]
fn coupled_friction_follows_the_other_joint() {
    let effect = CoupledFriction {
        joint: "joint3".to_string(),
        from: "6".to_string(),
        part: FrictionPart::Both,
        width: 0.0,
    };
    check(&effect, &[&|_, t| joint_at(5, t)[1], &|_, t| signum(joint_at(5, t)[1])]);
}

#[test]
fn load_dependent_friction_follows_the_rigid_torque() {
    let robot = robot("panda.ron");
    let load = |t: f64| torque(&robot, &super::motion::at(&robot, t))[2].abs();
    let of = |part| LoadDependentFriction { joints: third(), part, width: 0.0 };
    check(&of(FrictionPart::Coulomb), &[&|[_, v, _], t| signum(v) * load(t)]);
    check(&of(FrictionPart::Viscous), &[&|[_, v, _], t| v * load(t)]);
}

#[test]
fn thermal_friction_follows_the_channel_or_the_clock() {
    let robot = robot("panda.ron");
    let mut run = run(&robot, 0.01, 400);
    let only = |warmth| ThermalFriction { joints: third(), warmth, reference: 20.0, ..Default::default() };
    let missing = lacuna::model::Model::new(&robot, vec![Box::new(only(Warmth::Channel))])
        .expect("fits the robot")
        .add_torque(&[1.0, 1.0], &run, &mut vec![vec![0.0; 400]; 7], |_| true)
        .expect_err("there is no temperature");
    assert!(missing.to_string().contains("temperature3"), "{missing}");
    assert!(only(Warmth::Channel).undecidable(&robot, std::slice::from_ref(&run)).is_some());
    let elapsed = only(Warmth::Elapsed { time_s: 3.0 });
    check(&elapsed, &[&|[_, v, _], t| v * (-t / 3.0).exp(), &|[_, v, _], t| signum(v) * (-t / 3.0).exp()]);

    run.channels.insert("temperature3".to_string(), (0..400).map(|k| 25.0 + 0.1 * f64::from(k)).collect());
    let found = columns(&robot, &run, &only(Warmth::Channel));
    for k in 0..400 {
        let v = joint_at(2, 0.01 * k as f64)[1];
        let warm = 5.0 + 0.1 * k as f64;
        assert!((found[0][2][k] - warm * v).abs() < 1e-12);
        assert!((found[1][2][k] - warm * signum(v)).abs() < 1e-12);
    }
    assert!(only(Warmth::Channel).undecidable(&robot, std::slice::from_ref(&run)).is_none());
    run.channels.insert("temperature3".to_string(), vec![30.0; 400]);
    let still = only(Warmth::Channel).undecidable(&robot, std::slice::from_ref(&run));
    assert!(still.is_some_and(|reason| reason.contains("1 K")));
}

#[test]
fn columns_with_a_sign_use_the_less_filtered_velocity() {
    let robot = robot("panda.ron");
    let plain = run(&robot, 0.01, 200);
    let mut other = plain.clone();
    other.friction_dq = plain.dq.iter().map(|v| v.iter().map(|v| v + 0.2).collect()).collect();
    let changes = |effect: &dyn Effect| {
        columns(&robot, &plain, effect).concat().concat() != columns(&robot, &other, effect).concat().concat()
    };
    let width = 0.05;
    let signed: Vec<Box<dyn Effect>> = vec![
        Box::new(AsymmetricFriction { joints: third(), width }),
        Box::new(NonlinearViscousFriction { joints: third(), exponent: 2.0, width }),
        Box::new(StribeckFriction { joints: third(), vs: 0.3, width }),
        Box::new(PositionDependentFriction { joints: third(), k: 2.0, width }),
        Box::new(LoadDependentFriction { joints: third(), part: FrictionPart::Coulomb, width }),
        Box::new(lacuna::effects::PreslidingHysteresis { joints: third(), s: 100.0, width }),
        Box::new(lacuna::effects::CoulombFriction { joints: third(), width }),
    ];
    for effect in &signed {
        assert!(changes(effect.as_ref()), "{effect:?}");
    }
    assert!(!changes(&RotorInertia { joints: third() }));
}
