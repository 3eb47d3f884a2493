use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{DRIVES_MOTION, FrictionPart};
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// Coulomb friction (the second term of Gaz et al. 2019, eq. 24).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CoulombFriction {
    /// Joints it acts on.
    pub joints: Joints,
    /// Width of the smoothed sign `tanh(dq / width)` [rad/s]; 0 is the hard sign.
    pub width: f64,
}

impl CoulombFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "coulomb_friction",
        title: "friction of constant size against the motion",
        text: "Changes sign with the velocity and keeps its size: a step in the residual at every reversal.",
        equation: "tau_j = fc_j sign(dq_j), or fc_j tanh(dq_j / width) with a width",
        parameters: &[Parameter::new("fc", "N m", "Coulomb level").at_least(0.0, DRIVES_MOTION)],
        cause: "surfaces that slide on each other in gears, bearings and seals",
        confused_with: "stribeck_friction (more near zero speed), sigmoid_friction (no jump at zero)",
        separation: Separation::OTHER,
        example: r#"{"coulomb_friction": (joints: All)}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Step,
        reach: Reach::Joint,
        stage: Stage::First,
        imitated_by: &[],
        special: Special {
            exports: Exports {
                mujoco: "frictionloss of the joint",
                isaaclab: "friction of the joint",
                gazebo: "friction of the joint",
                c: "as it is",
                joint: Some(OfJoint::Friction),
                ..Exports::NOWHERE
            },
            ..Special::NONE
        },
    };

    /// What a diagnosis tries: every joint for itself.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, width: 0.0 })
    }
}

#[typetag::serde(name = "coulomb_friction")]
impl Effect for CoulombFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        if !(self.width.is_finite() && self.width >= 0.0) {
            return Err(Error::new(format!("the `width` of `coulomb_friction` is {}", self.width))
                .help("give the speed over which it turns round [rad/s], or 0 for a hard sign"));
        }
        self.joints.terms(robot, "fc", "N m")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 1, |_, joint, slot| FrictionPart::Coulomb.fill(at, joint, self.width, slot))
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }
}
