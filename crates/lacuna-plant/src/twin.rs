//! The twins of the effects that are fitted: physics of the plant under the same names, as an examination hides them.

use super::effect::PlantEffect;
use super::per_joint::PerJoint;
use super::*;
use lacuna_base::random::Stream;

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

/// What an effect of the plant says about itself.
#[derive(Debug, Clone, Copy)]
pub struct Twin {
    /// Name, that of the effect which is fitted.
    pub name: &'static str,
    /// Settings in RON, for a robot of seven joints.
    pub example: &'static str,
    /// What part of a data set it changes.
    pub scope: Scope,
    /// A usual size, in the unit of the number that scales it.
    pub unit: f64,
    /// The largest size that is physical.
    pub limit: f64,
    /// Joints of a Panda, from 0, on which no motion can tell it, and why.
    pub not_on: &'static [(usize, &'static str)],
    /// The effect on a joint of a Panda, of a size, its shapes drawn from a stream; with what has to stand beside it.
    pub make: fn(usize, f64, &mut Stream) -> Vec<Box<dyn PlantEffect>>,
}

/// All twins, one line each. Examinations draw by place: new ones go to the end.
pub const TWINS: &[Twin] = &[
    TorqueOffset::TWIN,
    ViscousFriction::TWIN,
    CoulombFriction::TWIN,
    SigmoidFriction::TWIN,
    StribeckFriction::TWIN,
    AsymmetricFriction::TWIN,
    NonlinearViscousFriction::TWIN,
    LoadDependentFriction::TWIN,
    PositionDependentFriction::TWIN,
    CoupledFriction::TWIN,
    PreslidingHysteresis::TWIN,
    Backlash::TWIN,
    RotorInertia::TWIN,
    JointSpring::TWIN,
    TorqueRipple::TWIN,
    JointElasticity::TWIN,
    JointZeroError::TWIN,
    TorqueGain::TWIN,
    TimeDelay::TWIN,
    TorqueDrift::TWIN,
    FrictionDrift::TWIN,
    ThermalFriction::TWIN,
    BaseTilt::TWIN,
    Payload::TWIN,
    ContactForce::TWIN,
];

/// Number of joints of the robot that effects are hidden in.
const DOF: usize = 7;

/// A joint beside `joint`: the one before it, for the first the next.
pub fn neighbour(joint: usize) -> usize {
    joint.checked_sub(1).unwrap_or(1)
}

/// A number on one joint, zero on the others.
pub(crate) fn only(joint: usize, value: f64) -> PerJoint {
    let mut all = vec![0.0; DOF];
    all[joint] = value;
    PerJoint(all)
}

/// An effect alone.
pub fn boxed(effect: impl PlantEffect + 'static) -> Vec<Box<dyn PlantEffect>> {
    vec![Box::new(effect)]
}

/// Any phase \[rad\].
pub fn phase(stream: &mut Stream) -> f64 {
    stream.between(0.0, std::f64::consts::TAU)
}
