//! What can be hidden: every effect of the catalogue, and shapes beyond it.

use crate::plant::{
    AsymmetricFriction, Backlash, BaseTilt, ContactForce, CoulombFriction, CoupledFriction, Factor,
    FrictionDrift, JointElasticity, JointSpring, JointZeroError, LoadDependentFriction,
    NonlinearViscousFriction, Payload, PerJoint, PlantEffect, PositionDependentFriction,
    PreslidingHysteresis, Product, RotorInertia, SigmoidFriction, StribeckFriction, ThermalFriction,
    TimeDelay, TorqueDrift, TorqueGain, TorqueOffset, TorqueRipple, ViscousFriction,
};
use crate::random::Stream;

/// Number of joints of the robot.
const DOF: usize = 7;

/// What part of a data set an effect changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Scope {
    /// One joint's torque (or sensor).
    Joint,
    /// The whole robot.
    Robot,
    /// The whole robot, in some logs and not in those recorded before.
    TwoLogs,
    /// The whole robot, for a while in one log.
    Event,
}

/// Who could name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// The catalogue has it.
    Catalogue,
    /// The catalogue has it not, but a short formula of joint positions and velocities does.
    Formula,
    /// No shipped library of shapes can write it down.
    Nobody,
}

/// A kind of hidden effect.
#[derive(Debug)]
pub struct Family {
    /// Name; in the catalogue where that has it.
    pub name: &'static str,
    /// Who could name it.
    pub known: Known,
    /// What part of a data set it changes.
    pub scope: Scope,
    /// A usual size, in the unit of the number that scales it.
    pub unit: f64,
    /// The largest size that is physical.
    pub limit: f64,
    make: fn(usize, f64, &mut Stream) -> Vec<Box<dyn PlantEffect>>,
}

impl Family {
    /// The family of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        FAMILIES.iter().find(|family| family.name == name)
    }

    /// The plant's effects at `size` on `joint`, shapes drawn from `stream`.
    pub(super) fn effects(&self, joint: usize, size: f64, stream: &mut Stream) -> Vec<Box<dyn PlantEffect>> {
        (self.make)(joint, size, stream)
    }

    /// Why it cannot be told on this joint of a Panda whatever the motion, or `None` where it can.
    pub(super) fn excluded(&self, joint: usize) -> Option<String> {
        let why = match (self.name, joint) {
            ("rotor_inertia", 0 | 1) => "is the same as a rotational inertia of the link",
            ("joint_zero_error", 0) => "about an upright axis changes no torque",
            ("joint_zero_error", 6) => "of the last joint only turns the last link's parameters",
            ("load_dependent_friction", 0 | 6) => "needs a load, and gravity puts none on this joint",
            _ => return None,
        };
        Some(format!("{} on joint {} {why}", self.name, joint + 1))
    }

    /// What it depends on, as columns of a log.
    pub(super) fn variables(&self, joint: usize) -> Vec<String> {
        let (own, other, third) = (joint + 1, neighbour(joint) + 1, second(joint) + 1);
        match self.name {
            "detent" | "end_stop" => vec![format!("q{own}")],
            "product" | "piecewise" => vec![format!("q{other}"), format!("dq{own}")],
            "three_variables" => vec![format!("dq{own}"), format!("q{other}"), format!("q{third}")],
            "channel_driven" => vec!["pressure1".to_string(), format!("dq{own}")],
            "intermittent" => vec!["t".to_string()],
            _ => Vec::new(),
        }
    }
}

/// Scope of the family of this name.
pub(super) fn scope(name: &str) -> Scope {
    Family::named(name).map_or(Scope::Joint, |family| family.scope)
}

/// A joint beside `joint`: the one before it, for the first the next.
fn neighbour(joint: usize) -> usize {
    joint.checked_sub(1).unwrap_or(1)
}

/// Another one: two before, or three after.
fn second(joint: usize) -> usize {
    joint.checked_sub(2).unwrap_or(joint + 3)
}

/// A number on one joint, zero on the others.
fn only(joint: usize, value: f64) -> PerJoint {
    let mut all = vec![0.0; DOF];
    all[joint] = value;
    PerJoint(all)
}

fn boxed(effect: impl PlantEffect + 'static) -> Vec<Box<dyn PlantEffect>> {
    vec![Box::new(effect)]
}

/// Middle of each joint's range, where shapes of position are placed \[rad\].
const MIDDLE: [f64; DOF] = [0.0, 0.0, 0.0, -1.57, 0.0, 1.87, 0.0];

fn near_middle(joint: usize, stream: &mut Stream) -> f64 {
    MIDDLE[joint] + stream.between(-0.4, 0.4)
}

fn phase(stream: &mut Stream) -> f64 {
    stream.between(0.0, std::f64::consts::TAU)
}

const fn family(
    name: &'static str,
    scope: Scope,
    unit: f64,
    limit: f64,
    make: fn(usize, f64, &mut Stream) -> Vec<Box<dyn PlantEffect>>,
) -> Family {
    Family { name, known: Known::Catalogue, scope, unit, limit, make }
}

const fn beyond(
    name: &'static str,
    known: Known,
    unit: f64,
    make: fn(usize, f64, &mut Stream) -> Vec<Box<dyn PlantEffect>>,
) -> Family {
    Family { name, known, scope: Scope::Joint, unit, limit: f64::INFINITY, make }
}

/// Everything that can be hidden.
pub static FAMILIES: &[Family] = &[
    family("torque_offset", Scope::Joint, 0.3, 20.0, |j, s, _| boxed(TorqueOffset { offsets: only(j, s) })),
    family("viscous_friction", Scope::Joint, 0.5, 50.0, |j, s, _| {
        boxed(ViscousFriction { coefficients: only(j, s) })
    }),
    family("coulomb_friction", Scope::Joint, 0.5, 20.0, |j, s, _| {
        boxed(CoulombFriction { levels: only(j, s), width: 0.005 })
    }),
    family("sigmoid_friction", Scope::Joint, 1.0, 20.0, |j, s, draw| {
        let (phi2, phi3) = (draw.between(4.0, 15.0), draw.between(-0.05, 0.05));
        boxed(SigmoidFriction { phi1: only(j, s), phi2: only(j, phi2), phi3: only(j, phi3) })
    }),
    family("stribeck_friction", Scope::Joint, 0.5, 20.0, |j, s, draw| {
        let velocities = only(j, draw.between(0.06, 0.25));
        boxed(StribeckFriction { levels: only(j, s), velocities, width: 0.005 })
    }),
    family("asymmetric_friction", Scope::Joint, 0.5, 50.0, |j, s, _| {
        let none = PerJoint::default;
        boxed(AsymmetricFriction {
            viscous_forward: only(j, s),
            viscous_backward: none(),
            coulomb_forward: none(),
            coulomb_backward: none(),
            width: 0.005,
        })
    }),
    family("nonlinear_viscous_friction", Scope::Joint, 0.5, 50.0, |j, s, _| {
        boxed(NonlinearViscousFriction { coefficients: only(j, s), exponent: 2.0 })
    }),
    family("load_dependent_friction", Scope::Joint, 0.05, 0.5, |j, s, _| {
        let viscous_ratios = PerJoint::default();
        boxed(LoadDependentFriction { ratios: only(j, s), viscous_ratios, width: 0.005 })
    }),
    family("position_dependent_friction", Scope::Joint, 0.2, 20.0, |j, s, draw| {
        let (harmonics, phases) = (only(j, draw.between(1.5, 7.0)), only(j, phase(draw)));
        let varying = PositionDependentFriction { levels: only(j, s), harmonics, phases, width: 0.005 };
        // As much constant friction keeps the sum from driving the joint.
        vec![Box::new(varying), Box::new(CoulombFriction { levels: only(j, s), width: 0.005 })]
    }),
    family("coupled_friction", Scope::Joint, 0.3, 20.0, |j, s, draw| {
        let viscous = draw.uniform() < 0.5;
        boxed(CoupledFriction {
            joint: j + 1,
            from: neighbour(j) + 1,
            viscous: if viscous { s } else { 0.0 },
            coulomb: if viscous { 0.0 } else { s },
            width: 0.005,
        })
    }),
    family("presliding_hysteresis", Scope::Joint, 0.4, 20.0, |j, s, draw| {
        boxed(PreslidingHysteresis::dahl(only(j, s), only(j, draw.between(40.0, 500.0))))
    }),
    family("backlash", Scope::Joint, 4e-3, 0.05, |j, s, _| {
        boxed(Backlash { gaps: only(j, s), closing_torque: 0.2 })
    }),
    family("rotor_inertia", Scope::Joint, 0.1, 5.0, |j, s, _| boxed(RotorInertia { inertias: only(j, s) })),
    family("joint_spring", Scope::Joint, 1.0, 100.0, |j, s, _| {
        boxed(JointSpring { stiffness: only(j, s), rest: PerJoint::default() })
    }),
    family("torque_ripple", Scope::Joint, 0.2, 20.0, |j, s, draw| {
        let (harmonics, phases) = (only(j, draw.between(3.0, 25.0)), only(j, phase(draw)));
        boxed(TorqueRipple { amplitudes: only(j, s), harmonics, phases })
    }),
    family("joint_elasticity", Scope::Joint, 1e-3, 0.05, |j, s, _| {
        boxed(JointElasticity { compliance: only(j, s) })
    }),
    family("joint_zero_error", Scope::Joint, 0.03, 0.1, |j, s, _| {
        boxed(JointZeroError { errors: only(j, s) })
    }),
    family("torque_gain", Scope::Joint, 0.05, 0.3, |j, s, _| boxed(TorqueGain { gains: only(j, s) })),
    family("time_delay", Scope::Joint, 5e-3, 0.05, |j, s, _| boxed(TimeDelay { delays_s: only(j, s) })),
    family("torque_drift", Scope::Joint, 0.02, 2.0, |j, s, _| boxed(TorqueDrift { rates: only(j, s) })),
    family("friction_drift", Scope::Joint, 0.5, 20.0, |j, s, draw| {
        let (coulomb, time_s) = (only(j, s), Some(draw.between(3.0, 12.0)));
        boxed(FrictionDrift { coulomb, viscous: PerJoint::default(), time_s, width: 0.005 })
    }),
    family("thermal_friction", Scope::Joint, 0.1, 5.0, |j, s, draw| {
        // The log begins cold; friction grows with warmth so that the sum stays friction.
        let (heating, cooling_s) = (PerJoint::all(draw.between(0.2, 0.5)), draw.between(10.0, 40.0));
        boxed(ThermalFriction {
            coulomb: only(j, s),
            viscous: PerJoint::default(),
            heating,
            cooling_s,
            reference: 22.0,
            start: PerJoint::default(),
            width: 0.005,
        })
    }),
    family("base_tilt", Scope::Robot, 0.01, 0.2, |_, s, draw| {
        let (y, x) = libm::sincos(phase(draw));
        boxed(BaseTilt { x: s * x, y: s * y })
    }),
    family("payload", Scope::TwoLogs, 0.3, 20.0, |_, s, draw| {
        let mut within = |range: f64| draw.between(-range, range);
        let com = [within(0.03), within(0.03), 0.1 + within(0.04)];
        let inertia = [2e-3 * s, 0.0, 0.0, 2e-3 * s, 0.0, 1e-3 * s];
        boxed(Payload { mass: s, com, inertia, link: None })
    }),
    family("contact_force", Scope::Event, 2.0, 200.0, |_, s, draw| {
        let direction = [draw.normal(), draw.normal(), draw.normal()];
        let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
        let from_s = draw.between(2.0, 10.0);
        let to_s = from_s + draw.between(1.0, 2.3);
        let (force, point) = (direction.map(|x| s * x / length), [0.0; 3]);
        boxed(ContactForce { force, from_s, to_s, rise_s: 0.02, point, link: None })
    }),
    beyond("detent", Known::Formula, 0.5, |j, s, draw| {
        let (at, width) = (near_middle(j, draw), draw.between(0.06, 0.15));
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Detent { of: j + 1, at, width }] })
    }),
    beyond("end_stop", Known::Formula, 2.0, |j, s, draw| {
        let from = near_middle(j, draw) + 0.3;
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Beyond { of: j + 1, from }] })
    }),
    beyond("product", Known::Formula, 0.5, |j, s, draw| {
        let (k, phase) = (f64::from(1 + (draw.uniform() * 5.0) as u8), phase(draw));
        let wave = Factor::Wave { of: neighbour(j) + 1, k, phase };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Velocity(j + 1), wave] })
    }),
    beyond("piecewise", Known::Nobody, 0.5, |j, s, draw| {
        let of = neighbour(j);
        let a = near_middle(of, draw) - 0.3;
        let points = vec![(a - 0.4, 0.6), (a - 0.05, -1.0), (a + 0.25, 1.0), (a + 0.3, -0.2), (a + 0.9, 0.5)];
        let pieces = Factor::Pieces { of: of + 1, points };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Sign(j + 1), pieces] })
    }),
    beyond("three_variables", Known::Nobody, 0.6, |j, s, draw| {
        let wave = |of: usize, k: f64, phase: f64| Factor::Wave { of: of + 1, k, phase };
        let (one, two) = (wave(neighbour(j), 2.0, phase(draw)), wave(second(j), 3.0, phase(draw)));
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Velocity(j + 1), one, two] })
    }),
    beyond("channel_driven", Known::Nobody, 0.3, |j, s, draw| {
        let (period_s, phase) = (draw.between(5.0, 9.0), phase(draw));
        let channel = Factor::Channel { name: "pressure1".into(), period_s, phase, mean: 0.0 };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Sign(j + 1), channel] })
    }),
    beyond("intermittent", Known::Nobody, 0.3, |j, s, draw| {
        // A loose connector: on and off in time, and nothing in the log says when.
        let switch = Factor::OnOff { period_s: draw.between(1.7, 3.1), phase: draw.uniform() };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![switch] })
    }),
];
