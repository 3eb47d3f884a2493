use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::fill_with;
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// A spring between a link and the one before it.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointSpring {
    /// Joints it acts on.
    pub joints: Joints,
    /// Position at which it pulls neither way \[rad\]; another one is the same spring with a torque_offset.
    pub reference: f64,
}

impl JointSpring {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "joint_spring",
        title: "torque in proportion to the joint position",
        text: "A balancing spring, a hose or a cable bundle that is bent. The residual is a straight line \
               over position. Where the spring rests cannot be told from a torque_offset, so keep one in \
               the model.",
        equation: "tau_j = ks_j (q_j - reference)",
        parameters: &[Parameter::new("ks", "N m/rad", "stiffness")
            .odd_below(0.0, "a spring that pushes away from rest; probably something else")],
        cause: "a balancing spring, a hose or a bundle of cables that is bent",
        confused_with: "gravity torque (over a short way a sine is a line), joint_zero_error, base_tilt",
        separation: Separation::FAR,
        example: r#"{"joint_spring": (joints: Only(["2"]))}"#,
        drawn_against: Variable::Position,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special {
            exports: Exports {
                mujoco: "stiffness of the joint",
                gazebo: "spring_stiffness of the joint",
                c: "as it is",
                ..Exports::NOWHERE
            },
            ..Special::NONE
        },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, reference: 0.0 })
    }
}

#[typetag::serde(name = "joint_spring")]
impl Effect for JointSpring {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms(robot, "ks", "N m/rad")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 1, |_, joint, slot| fill_with(slot, at.q(joint), |q| q - self.reference))
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
