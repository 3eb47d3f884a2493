use serde::{Deserialize, Serialize};

use super::about::*;
use super::derivative::{along_shift, concerned, jump};
use super::parts::positive;
use super::{Columns, Effect, Joints, Shape, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Below this the torque of a motion counts for the side on which the teeth touch \[Hz\].
const SLOW_HZ: f64 = 3.0;

/// Play between motor, where the position is measured, and link (the hysteresis-free limit of the models in
/// Nordin and Gutman 2002).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Backlash {
    /// Joints with play.
    #[serde(default)]
    pub joints: Joints,
    /// Torque that presses the teeth together [N m]: below it the link is between both sides of the gap.
    pub closing: f64,
}

impl Backlash {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "backlash",
        title: "play in the gear: the link falls from one side to the other as the load turns round",
        text: "Teeth touch on one side while the load pulls one way and on the other while it pulls back, so \
               the link stands half a gap behind the motor or half a gap ahead of it. Shows where the torque \
               of the joint changes sign, not where the motion does: as a step of posture, felt by every \
               joint, with a short jerk. This is the quasi-static picture, linear in the gap. It leaves out \
               the impact and the moment in which the motor carries no load, so on a joint with fast load \
               reversals a remainder will stay.",
        equation: "tau(q - gap_j/2 tanh(tau_rigid_j / closing) e_j) - tau(q), to first order in gap_j",
        parameters: &[
            Parameter::new("gap", "rad", "whole play of the joint")
                .at_least(0.0, "a gap narrower than none")
                .at_most(0.05, "a gap of more than 0.05 rad"),
            Parameter::new("closing", "N m", "torque that presses the teeth together"),
        ],
        cause: "gear teeth that are worn, or set too far apart",
        confused_with: "joint_elasticity (a slope over the torque instead of a step), presliding_hysteresis \
                        (acts where the motion turns round), joint_zero_error",
        separation: Separation::OTHER,
        example: r#"{"backlash": (joints: Only(["2"]), closing: 0.3)}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::JointFeltByOthers,
        stage: Stage::Usual,
        imitated_by: &[Imitation::AccelerationNoise],
        special: Special { built_from: BuiltFrom::ModelTorque, ..Special::NONE },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, closing: 0.3 })
    }
}

#[typetag::serde(name = "backlash")]
impl Effect for Backlash {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        positive("backlash", "closing", self.closing)?;
        let term =
            |j: usize| Term { symbol: format!("gap{}", j + 1), unit: "rad", joints: concerned(robot, j) };
        Ok(self.joints.indices(robot)?.into_iter().map(term).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let model = at.model_torque()?;
        for (term, loose) in self.joints.indices(at.robot)?.into_iter().enumerate() {
            let side = jump(at, &model.rigid[loose], SLOW_HZ, |tau| 0.5 * libm::tanh(tau / self.closing));
            let change = along_shift(at, model, loose, &side);
            for joint in concerned(at.robot, loose) {
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

    fn shapes(&self) -> Vec<Shape> {
        let trials = vec![0.1, 0.3, 1.0, 3.0];
        vec![Shape { symbol: "closing", unit: "N m", value: self.closing, low: 0.02, high: 10.0, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { closing: values.first().copied().unwrap_or(self.closing), ..self.clone() })
    }
}
