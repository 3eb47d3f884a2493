use serde::{Deserialize, Serialize};

use super::about::*;
use super::derivative::{along_position, concerned};
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::{JointKind, Robot};

/// Position sensors whose zero is off.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointZeroError {
    /// Joints with a wrong zero.
    pub joints: Joints,
}

impl JointZeroError {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "joint_zero_error",
        title: "a joint that stands elsewhere than its sensor says",
        text: "An encoder mounted or calibrated with an offset: every joint feels gravity of a slightly other \
               posture. To first order in the offset. A first joint that turns about the vertical has no \
               zero that torque could know; that of the last joint cannot be told from the centre of mass of \
               its link.",
        equation: "tau(q + zero_j e_j) - tau(q), to first order in zero_j",
        parameters: &[Parameter::new("zero", "rad", "true position less measured position")
            .within(0.1, "a zero that is off by more than 0.1 rad")],
        cause: "an encoder mounted or calibrated with an offset",
        confused_with: "rigid_body (first moments of the links behind), torque_offset, base_tilt, joint_spring",
        separation: Separation::OTHER,
        example: r#"{"joint_zero_error": (joints: Only(["2"]))}"#,
        drawn_against: Variable::Position,
        at_rest: AtRest::Smooth,
        reach: Reach::JointFeltByOthers,
        stage: Stage::Usual,
        imitated_by: &[Imitation::AccelerationNoise],
        special: Special { built_from: BuiltFrom::ModelTorque, ..Special::NONE },
    };

    /// Every joint whose position matters for torque.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        let joint = |j: usize| Joints::Only(vec![robot.joints[j].name.clone()]);
        let one = |j: usize| Box::new(Self { joints: joint(j) }) as Box<dyn Effect>;
        (0..robot.dof()).filter(|&j| matters(robot, j)).map(one).collect()
    }
}

/// Whether any torque depends on the position of joint `j`: not for a joint on the base that slides, or
/// that turns about the vertical.
fn matters(robot: &Robot, j: usize) -> bool {
    let joint = &robot.joints[j];
    if joint.parent.is_some() {
        return true;
    }
    let axis = joint.before.rotation * joint.axis;
    joint.kind == JointKind::Revolute && axis.cross(&robot.gravity).norm() > 1e-9 * robot.gravity.norm()
}

#[typetag::serde(name = "joint_zero_error")]
impl Effect for JointZeroError {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let term =
            |j: usize| Term { symbol: format!("zero{}", j + 1), unit: "rad", joints: concerned(robot, j) };
        Ok(self.joints.indices(robot)?.into_iter().map(term).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let model = at.model_torque()?;
        for (term, off) in self.joints.indices(at.robot)?.into_iter().enumerate() {
            let change = along_position(at, model, off);
            for joint in concerned(at.robot, off) {
                out.column(term, joint, |slot| slot.copy_from_slice(&change[joint]));
            }
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn belongs_to(&self, robot: &Robot) -> Result<Option<usize>> {
        self.joints.only_one(robot)
    }
}
