use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Effect, Stretch, Term};
use crate::error::Result;
use crate::kernels::{Samples, inverse_dynamics_batch};
use crate::robot::Robot;

/// A base that does not stand as the robot file says.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseTilt {}

const AXES: [&str; 3] = ["x", "y", "z"];

impl BaseTilt {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "base_tilt",
        title: "gravity from another side than the robot file says",
        text: "A table that is not level, a base plate that is not flat: gravity leans in the base frame. The \
               sign is a torque on the first joint, which gravity should leave alone, as a sine over its \
               position. To first order in the angle, with the identified link parameters; what only a \
               leaning gravity can show (the first moment of link 1 across a vertical first axis) is taken \
               as 0, which adds an error in proportion to the tilt on joint 1.",
        equation: "tau = |g| (tilt_x tau_g(x) + tilt_y tau_g(y)), tau_g(a): gravity torque of unit gravity along a",
        parameters: &[Parameter::new(
            "tilt_x, tilt_y",
            "rad",
            "angle by which gravity leans towards the base's x and y (the two axes most nearly level)",
        )
        .within(0.2, "a base that leans by more than 0.2 rad; check the mounting in the robot file")],
        cause: "a table that is not level, a base plate that is not flat",
        confused_with: "joint_zero_error of the first joints, rigid_body first moments, a wrong mounting in the \
                        robot file (then the angles are large)",
        separation: Separation::FAR,
        example: r#"{"base_tilt": ()}"#,
        drawn_against: Variable::Position,
        at_rest: AtRest::Smooth,
        reach: Reach::Robot,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special {
            built_from: BuiltFrom::ModelTorque,
            leans: true,
            exports: Exports {
                mujoco: "gravity of the world",
                isaaclab: "gravity of the world",
                gazebo: "gravity of the world",
                drake: "gravity of the world",
                c: "gravity of the base",
                ..Exports::NOWHERE
            },
            ..Special::NONE
        },
    };

    pub(super) fn candidates(_robot: &Robot) -> Vec<Box<dyn Effect>> {
        vec![Box::new(Self {})]
    }
}

/// The two base axes along which gravity has the least.
fn level_axes(robot: &Robot) -> [usize; 2] {
    let mut axes = [0, 1, 2];
    axes.sort_by(|&a, &b| robot.gravity[a].abs().total_cmp(&robot.gravity[b].abs()));
    [axes[0].min(axes[1]), axes[0].max(axes[1])]
}

#[typetag::serde(name = "base_tilt")]
impl Effect for BaseTilt {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let term = |axis: usize| Term {
            symbol: format!("tilt_{}", AXES[axis]),
            unit: "rad",
            joints: (0..robot.dof()).collect(),
        };
        Ok(level_axes(robot).map(term).to_vec())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let model = at.model_torque()?;
        let q: Vec<Vec<f64>> = at.run.q.iter().map(|q| q[at.range.clone()].to_vec()).collect();
        let still = vec![vec![0.0; at.range.len()]; q.len()];
        let samples = Samples { q: &q, dq: &still, ddq: &still };
        for (term, axis) in level_axes(at.robot).into_iter().enumerate() {
            let mut gravity = [0.0; 3];
            gravity[axis] = at.robot.gravity.norm();
            let torque = inverse_dynamics_batch(&at.chain.with_gravity(gravity), samples, &model.links);
            for (joint, torque) in torque.iter().enumerate() {
                out.column(term, joint, |slot| slot.copy_from_slice(torque));
            }
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
