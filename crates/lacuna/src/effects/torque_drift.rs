use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Torque that grows with time.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TorqueDrift {
    /// Joints it acts on.
    pub joints: Joints,
}

impl TorqueDrift {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "torque_drift",
        title: "a measured torque that creeps away with time",
        text: "Strain gauges and current sensors drift as they warm. The residual is a straight line over \
               time, whatever the robot does. Time counts from the start of each log.",
        equation: "tau_j = fd_j t",
        parameters: &[Parameter::new("fd", "N m/s", "growth per second")],
        cause: "strain gauges or current sensors that warm up",
        confused_with: "torque_offset (in a short log), friction_drift (turns over with the direction)",
        separation: Separation::LONG,
        example: r#"{"torque_drift": (joints: Only(["2"]))}"#,
        drawn_against: Variable::Time,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[Imitation::CourseOfTime],
        special: Special::NONE,
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints })
    }
}

#[typetag::serde(name = "torque_drift")]
impl Effect for TorqueDrift {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms(robot, "fd", "N m/s")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 1, |_, _, slot| {
            slot.iter_mut().zip(at.elapsed()).for_each(|(y, t)| *y = t);
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
