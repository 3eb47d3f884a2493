//! Loads that depend on where a joint stands.

use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, only, phase};
use super::{PerJoint, check_positive, smooth_sign, usual_width};
use crate::CoulombFriction;
use lacuna_base::error::Result;
use lacuna_base::text::bounds::{NotNegative, Positive};

/// A spring across the joint, such as a bundle of cables: `stiffness (q - rest)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointSpring {
    /// Stiffness [N m/rad, N/m].
    pub stiffness: PerJoint,
    /// Where it does not pull [rad, m].
    #[serde(default)]
    pub rest: PerJoint,
}

impl JointSpring {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "joint_spring",
        example: "(stiffness: [2.0], rest: [0.1])",
        scope: Scope::Joint,
        unit: 1.0,
        limit: 100.0,
        not_on: &[],
        make: |j, s, _| boxed(JointSpring { stiffness: only(j, s), rest: PerJoint::default() }),
    };
}

#[typetag::serde(name = "joint_spring")]
impl PlantEffect for JointSpring {
    fn check(&self, dof: usize) -> Result<()> {
        self.stiffness.check("the stiffness of a joint spring", dof)?;
        self.rest.check("the rest position of a joint spring", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            *load += self.stiffness.of(j) * (now.q[j] - self.rest.of(j));
        }
    }
}

/// A load that repeats along the turn of a joint, as cogging and gear errors make it:
/// `amplitude sin(harmonic q + phase)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueRipple {
    /// Amplitude [N m, N].
    pub amplitudes: PerJoint,
    /// Periods per turn.
    #[serde(deserialize_with = "NotNegative::read")]
    pub harmonics: PerJoint,
    /// Phase \[rad\].
    #[serde(default)]
    pub phases: PerJoint,
}

impl TorqueRipple {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "torque_ripple",
        example: "(amplitudes: [0.3], harmonics: [12], phases: [1])",
        scope: Scope::Joint,
        unit: 0.2,
        limit: 20.0,
        not_on: &[],
        make: |j, s, draw| {
            let (harmonics, phases) = (only(j, draw.between(3.0, 25.0)), only(j, phase(draw)));
            boxed(TorqueRipple { amplitudes: only(j, s), harmonics, phases })
        },
    };
}

#[typetag::serde(name = "torque_ripple")]
impl PlantEffect for TorqueRipple {
    fn check(&self, dof: usize) -> Result<()> {
        self.amplitudes.check("the amplitude of a torque ripple", dof)?;
        self.harmonics.check_not_negative("the harmonic of a torque ripple", dof)?;
        self.phases.check("the phase of a torque ripple", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            *load += self.amplitudes.of(j) * libm::sin(self.harmonics.of(j) * now.q[j] + self.phases.of(j));
        }
    }
}

/// Dry friction that varies along the turn of a joint: `level tanh(dq / width) sin(harmonic q + phase)`.
///
/// It belongs beside Coulomb friction of at least the same level; alone it would drive the joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PositionDependentFriction {
    /// Amplitude of the variation [N m, N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub levels: PerJoint,
    /// Periods per turn.
    #[serde(deserialize_with = "NotNegative::read")]
    pub harmonics: PerJoint,
    /// Phase \[rad\].
    #[serde(default)]
    pub phases: PerJoint,
    /// Velocity at which 76 % of the sign is reached [rad/s, m/s].
    #[serde(default = "usual_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

impl PositionDependentFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "position_dependent_friction",
        example: "(levels: [0.2], harmonics: [3], phases: [0.4])",
        scope: Scope::Joint,
        unit: 0.2,
        limit: 20.0,
        not_on: &[],
        make: |j, s, draw| {
            let (harmonics, phases) = (only(j, draw.between(1.5, 7.0)), only(j, phase(draw)));
            let varying = PositionDependentFriction { levels: only(j, s), harmonics, phases, width: 0.005 };
            // As much constant friction keeps the sum from driving the joint.
            vec![Box::new(varying), Box::new(CoulombFriction { levels: only(j, s), width: 0.005 })]
        },
    };
}

#[typetag::serde(name = "position_dependent_friction")]
impl PlantEffect for PositionDependentFriction {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the width of position-dependent friction", self.width)?;
        self.levels.check_not_negative("position-dependent friction", dof)?;
        self.harmonics.check_not_negative("the harmonic of position-dependent friction", dof)?;
        self.phases.check("the phase of position-dependent friction", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            let wave = libm::sin(self.harmonics.of(j) * now.q[j] + self.phases.of(j));
            *load += self.levels.of(j) * smooth_sign(now.dq[j], self.width) * wave;
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        slope.iter_mut().enumerate().for_each(|(j, slope)| *slope += self.levels.of(j) / self.width);
    }
}
