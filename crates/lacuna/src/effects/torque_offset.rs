use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Torque offset (the last term of Gaz et al. 2019, eq. 24).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TorqueOffset {
    /// Joints it acts on.
    pub joints: Joints,
}

impl TorqueOffset {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "torque_offset",
        title: "constant torque on a joint",
        text: "A constant: zero error of the torque sensor, or the difference between Coulomb friction in the two directions.",
        equation: "tau_j = fo_j",
        parameters: &[Parameter::new("fo", "N m", "offset")],
        cause: "a torque or current sensor whose zero is off",
        confused_with: "asymmetric_friction (the same thing when the joint moves both ways at equal speeds), joint_zero_error",
        separation: Separation::OTHER,
        example: r#"{"torque_offset": (joints: All)}"#,
        drawn_against: Variable::Time,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::First,
        imitated_by: &[],
        special: Special { exports: Exports { c: "as it is", ..Exports::NOWHERE }, ..Special::NONE },
    };

    /// What a diagnosis tries: every joint for itself.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints })
    }
}

#[typetag::serde(name = "torque_offset")]
impl Effect for TorqueOffset {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms(robot, "fo", "N m")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        for (term, joint) in self.joints.indices(at.robot)?.into_iter().enumerate() {
            out.column(term, joint, |slot| slot.fill(1.0));
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
