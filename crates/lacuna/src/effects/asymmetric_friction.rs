use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{fill_with, sign};
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Viscous friction that differs between the two directions.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct AsymmetricFriction {
    /// Joints it acts on.
    pub joints: Joints,
    /// Width of the smoothed sign in `|dq| = dq tanh(dq / width)` [rad/s]; 0 is the exact size.
    pub width: f64,
}

impl AsymmetricFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "asymmetric_friction",
        title: "friction that grows faster with speed in one direction",
        text: "Viscous friction with another slope forwards than backwards, as from seals, belts or a brake \
               that rubs. Over velocity the residual is a V. Together with viscous_friction it gives the \
               slope fv + fa forwards and fv - fa backwards. Coulomb friction that differs between the \
               directions is no effect of its own: it is exactly coulomb_friction plus torque_offset, and \
               no data can tell the difference.",
        equation: "tau_j = fa_j |dq_j|",
        parameters: &[Parameter::new(
            "fa",
            "N m s/rad",
            "half the difference of the slopes forwards and backwards",
        )],
        cause: "seals, belts, or a brake that rubs in one direction",
        confused_with: "torque_offset (when the speed hardly varies), nonlinear_viscous_friction (the same \
                        curve when the joint only moves one way)",
        separation: Separation::OTHER,
        example: r#"{"asymmetric_friction": (joints: Only(["2"]))}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special { exports: Exports { c: "as it is", ..Exports::NOWHERE }, ..Special::NONE },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, width: 0.0 })
    }
}

#[typetag::serde(name = "asymmetric_friction")]
impl Effect for AsymmetricFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms(robot, "fa", "N m s/rad")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 1, |_, joint, slot| {
            fill_with(slot, at.friction_dq(joint), |v| v * sign(v, self.width));
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }
}
