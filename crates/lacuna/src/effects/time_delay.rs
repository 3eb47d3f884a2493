use serde::{Deserialize, Serialize};

use super::about::*;
use super::derivative::time_derivatives;
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Torque that is written down later than the motion it belongs to.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TimeDelay {
    /// Joints that are late, all by the same time.
    pub joints: Joints,
}

impl TimeDelay {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "time_delay",
        title: "torque logged later than the motion",
        text: "Bus, filter or driver hold the torque back. The residual follows the rate of change of the \
               torque. First suspect the signal step: a causal filter on one side of the equation makes just \
               this, and belongs repaired, not modelled. To first order in the delay, so good for delays \
               well below the time in which torque changes.",
        equation: "tau_j measured(t) = tau_j(t - delay), that is tau_j - delay dtau_j/dt",
        parameters: &[Parameter::new(
            "delay",
            "s",
            "how much later torque is logged; negative where it comes early",
        )
        .within(0.05, "a delay of more than 50 ms")],
        cause: "a causal filter, a bus or a driver on one side of the log",
        confused_with: "joint_elasticity and rotor_inertia (follow the acceleration), a causal filter",
        separation: Separation::new(Asks::Fast, "a faster motion of that joint alone"),
        example: r#"{"time_delay": ()}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::JointOrAll,
        stage: Stage::Usual,
        imitated_by: &[Imitation::AccelerationNoise, Imitation::Clock],
        special: Special { built_from: BuiltFrom::Measurement, ..Special::NONE },
    };

    /// All joints together, and each alone.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        let mut all = super::per_joint(robot, |joints| Self { joints });
        if robot.dof() > 1 {
            all.insert(0, Box::new(Self::default()));
        }
        all
    }
}

#[typetag::serde(name = "time_delay")]
impl Effect for TimeDelay {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let joints = self.joints.indices(robot)?;
        let numbers: Vec<String> = joints.iter().map(|j| (j + 1).to_string()).collect();
        let which = if self.joints == Joints::All { String::new() } else { numbers.join("_") };
        Ok(vec![Term { symbol: format!("delay{which}"), unit: "s", joints }])
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let model = at.model_torque()?;
        for joint in self.joints.indices(at.robot)? {
            out.column(0, joint, |slot| {
                let [rate, _] = time_derivatives(&model.total[joint], at.run.dt, at.range.clone());
                slot.iter_mut().zip(rate).for_each(|(y, r)| *y = -r);
            });
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
