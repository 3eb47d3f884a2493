//! What cannot be physics is said, and what can be is let through.

use lacuna::effects::{
    Backlash, BaseTilt, CoulombFriction, CoupledFriction, Effect, FrictionPart, JointElasticity, JointSpring,
    JointZeroError, Joints, LoadDependentFriction, NonlinearViscousFriction, Payload, PreslidingHysteresis,
    RotorInertia, StribeckFriction, TimeDelay, TorqueGain, TorqueRipple, ViscousFriction,
};
use nalgebra::DMatrix;

use super::common::robot;
use super::motion::run;

/// An effect, values that can be, and values that cannot.
type Case = (Box<dyn Effect>, &'static [f64], &'static [f64]);

#[test]
fn physical_limits() {
    let robot = robot("panda.ron");
    let all = || Joints::All;
    let cases: Vec<Case> = vec![
        (Box::new(ViscousFriction::default()), &[0.1], &[-0.1]),
        (Box::new(CoulombFriction::default()), &[0.1, 0.0], &[0.1, -0.1]),
        (Box::new(PreslidingHysteresis { joints: all(), s: 100.0, width: 0.0 }), &[0.1], &[-0.1]),
        (Box::new(RotorInertia::default()), &[0.1], &[-0.1]),
        (Box::new(LoadDependentFriction::default()), &[0.4], &[0.6]),
        (Box::new(LoadDependentFriction::default()), &[0.1], &[-0.1]),
        (Box::new(JointElasticity::default()), &[1e-4], &[-1e-4]),
        (Box::new(TorqueGain::default()), &[-0.29], &[0.31]),
        (Box::new(TimeDelay::default()), &[-0.049], &[0.051]),
        (Box::new(JointZeroError::default()), &[-0.09], &[0.11]),
        (Box::new(BaseTilt {}), &[0.19, -0.19], &[0.0, -0.21]),
        (Box::new(Backlash { joints: all(), closing: 0.3 }), &[0.001], &[-0.001]),
        (Box::new(Payload::default()), &[1.0, 0.1, 0.1, 0.3], &[-1.0, 0.1, 0.1, 0.3]),
        (Box::new(Payload::default()), &[1.0, 0.1, 0.1, 0.3], &[0.1, 0.1, 0.1, 0.3]),
        (Box::new(StribeckFriction { joints: all(), vs: 0.1, width: 0.05 }), &[0.2], &[-0.2]),
        (Box::new(StribeckFriction { joints: all(), vs: 0.1, width: 0.05 }), &[0.2], &[0.0]),
    ];
    for (effect, good, bad) in cases {
        assert_eq!(effect.implausible(&robot, good), None, "{effect:?} {good:?}");
        assert!(effect.implausible(&robot, bad).is_some(), "{effect:?} {bad:?}");
        let nan: Vec<f64> = good.iter().map(|_| f64::NAN).collect();
        assert!(effect.implausible(&robot, &nan).is_some(), "{effect:?} takes nonsense for physics");
    }
    let at_once = PreslidingHysteresis { joints: all(), s: 1450.0, width: 0.0 };
    assert!(at_once.implausible(&robot, &[0.1]).is_some_and(|reason| reason.contains("0.69 mrad")));
    let within_the_sign = StribeckFriction { joints: all(), vs: 0.09, width: 0.05 };
    assert!(within_the_sign.implausible(&robot, &[0.2]).is_some_and(|reason| reason.contains("smoothing")));
}

#[test]
fn what_is_odd_is_said_but_not_refused() {
    let robot = robot("panda.ron");
    let spring = JointSpring::default();
    assert!(spring.odd(&robot, &[-1.0]).is_some() && spring.implausible(&robot, &[-1.0]).is_none());
    assert!(spring.odd(&robot, &[1.0]).is_none());
    let thinning = NonlinearViscousFriction::default();
    assert!(thinning.odd(&robot, &[-1.0]).is_some() && thinning.implausible(&robot, &[-1.0]).is_none());
    let ripple = |k| TorqueRipple { joints: Joints::All, k };
    assert!(ripple(1.6).odd(&robot, &[0.1, 0.1]).is_some() && ripple(3.0).odd(&robot, &[0.1, 0.1]).is_none());
    let coupled = CoupledFriction {
        joint: "1".to_string(),
        from: "2".to_string(),
        part: FrictionPart::Both,
        width: 0.0,
    };
    assert!(coupled.odd(&robot, &[0.1, -0.1]).is_some() && coupled.odd(&robot, &[-0.1, -0.1]).is_none());
}

#[test]
fn stribeck_needs_slow_and_fast_motion() {
    let robot = robot("panda.ron");
    let joint = |vs| StribeckFriction { joints: Joints::Only(vec!["2".to_string()]), vs, width: 0.0 };
    let mut run = run(&robot, 0.01, 1000);
    let verdict =
        |vs: f64, run: &lacuna::signals::Run| joint(vs).undecidable(&robot, std::slice::from_ref(run));
    assert_eq!(verdict(0.3, &run), None);
    assert!(verdict(2.0, &run).is_some_and(|why| why.contains("faster")));
    run.dq[1].iter_mut().for_each(|v| *v = v.abs() + 0.5);
    assert!(verdict(0.3, &run).is_some_and(|why| why.contains("slower")));
}

#[test]
fn waves_are_told_as_amplitude_and_phase() {
    let robot = robot("panda.ron");
    let effect = TorqueRipple { joints: Joints::Only(vec!["3".to_string()]), k: 7.0 };
    let covariance = DMatrix::from_row_slice(2, 2, &[4e-4, 1e-4, 1e-4, 2e-4]);
    let told = effect.describe(&robot, &[0.3, -0.4], &covariance).expect("describes");
    let of = |name: &str| told.iter().find(|d| d.name == name).expect("is told").clone();
    let (amplitude, phase) = (of("amplitude3"), of("phase3"));
    for q in [0.0, 0.2, 1.1] {
        let wave = 0.3 * f64::sin(7.0 * q) - 0.4 * f64::cos(7.0 * q);
        assert!((amplitude.value * (7.0 * q + phase.value).sin() - wave).abs() < 1e-12);
    }
    // Gradients of the amplitude and the phase at (0.3, -0.4), worked by hand: (0.6, -0.8), (1.6, 1.2).
    let by_hand =
        |g: [f64; 2]| (g[0] * g[0] * 4e-4 + 2.0 * g[0] * g[1] * 1e-4 + g[1] * g[1] * 2e-4_f64).sqrt();
    assert!((amplitude.standard_error.expect("known") - by_hand([0.6, -0.8])).abs() < 1e-12);
    assert!((phase.standard_error.expect("known") - by_hand([1.6, 1.2])).abs() < 1e-12);
    assert!((of("k").value - 7.0).abs() < 1e-15);
}
