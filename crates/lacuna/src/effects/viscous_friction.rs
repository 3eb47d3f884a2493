use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::DRIVES_MOTION;
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Viscous friction (the first term of Gaz et al. 2019, eq. 24).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ViscousFriction {
    /// Joints it acts on.
    pub joints: Joints,
}

impl ViscousFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "viscous_friction",
        title: "friction proportional to speed",
        text: "Grows with speed: lubricant and back-EMF. In the residual it is a straight line through the origin over the joint velocity.",
        equation: "tau_j = fv_j dq_j",
        parameters: &[Parameter::new("fv", "N m s/rad", "viscous coefficient").at_least(0.0, DRIVES_MOTION)],
        cause: "lubricant that is sheared in gears and bearings; the back-EMF of the motor",
        confused_with: "a sigmoid with a small steepness on slow joints; motor back-EMF",
        separation: Separation::SPEEDS,
        example: r#"{"viscous_friction": (joints: All)}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::First,
        imitated_by: &[],
        special: Special {
            exports: Exports {
                mujoco: "damping of the joint",
                isaaclab: "viscous friction of the joint",
                gazebo: "damping of the joint",
                drake: "damping of the joint",
                c: "as it is",
                joint: Some(OfJoint::Damping),
            },
            ..Special::NONE
        },
    };

    /// What a diagnosis tries: every joint for itself.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints })
    }
}

#[typetag::serde(name = "viscous_friction")]
impl Effect for ViscousFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms(robot, "fv", "N m s/rad")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        for (term, joint) in self.joints.indices(at.robot)?.into_iter().enumerate() {
            out.column(term, joint, |slot| slot.copy_from_slice(at.dq(joint)));
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
