use serde::{Deserialize, Serialize};

use super::about::*;
use super::derivative::{along_shift, concerned};
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Gears that twist under load while positions are measured at the motor.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct JointElasticity {
    /// Joints that twist.
    pub joints: Joints,
}

impl JointElasticity {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "joint_elasticity",
        title: "a joint that twists under the torque it passes on",
        text: "Between the motor, where the position is measured, and the link lies a gear that yields. The \
               link stands behind by compliance times torque, and so every joint feels another posture and \
               another acceleration. Good to first order in the twist and well below the resonance of rotor \
               and link; the torque that twists is that of the rigid links. It is close to noise of the \
               acceleration: if it goes when position_cutoff_hz is halved, it was that.",
        equation: "tau(q - c_j tau_rigid_j e_j) - tau(q), with velocity and acceleration, to first order in c_j",
        parameters: &[Parameter::new("compliance", "rad/(N m)", "twist per torque")
            .at_least(0.0, "a gear that twists against the torque")],
        cause: "a strain-wave gear, a belt or a torque sensor that yields",
        confused_with: "rotor_inertia, time_delay, backlash (a step instead of a slope), joint_zero_error",
        separation: Separation::OTHER,
        example: r#"{"joint_elasticity": (joints: Only(["2"]))}"#,
        drawn_against: Variable::Acceleration,
        at_rest: AtRest::Smooth,
        reach: Reach::JointFeltByOthers,
        stage: Stage::Usual,
        imitated_by: &[Imitation::AccelerationNoise],
        special: Special { built_from: BuiltFrom::ModelTorque, ..Special::NONE },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints })
    }
}

#[typetag::serde(name = "joint_elasticity")]
impl Effect for JointElasticity {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let term = |j: usize| Term {
            symbol: format!("compliance{}", j + 1),
            unit: "rad/(N m)",
            joints: concerned(robot, j),
        };
        Ok(self.joints.indices(robot)?.into_iter().map(term).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let model = at.model_torque()?;
        for (term, twisting) in self.joints.indices(at.robot)?.into_iter().enumerate() {
            let change = along_shift(at, model, twisting, &model.rigid[twisting]);
            for joint in concerned(at.robot, twisting) {
                out.column(term, joint, |slot| {
                    slot.iter_mut().zip(&change[joint]).for_each(|(y, c)| *y = -c);
                });
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
