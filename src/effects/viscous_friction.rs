use serde::{Deserialize, Serialize};

use super::parts::drives_motion;
use super::{About, Columns, Effect, Joints, Stretch, Term};
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
        parameters: &[("fv", "N m s/rad", "viscous coefficient")],
        confused_with: "a sigmoid with a small steepness on slow joints; motor back-EMF",
    };
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

    fn implausible(&self, values: &[f64]) -> Option<String> {
        drives_motion(values)
    }
}
