use serde::{Deserialize, Serialize};

use super::{About, Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Inertia of motor and gear, seen through the gear ratio.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct RotorInertia {
    /// Joints it acts on.
    pub joints: Joints,
}

impl RotorInertia {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "rotor_inertia",
        title: "inertia of the motor behind the gear",
        text: "A rotor that spins n times faster than its joint resists acceleration with n^2 times its \
               inertia, and moves no link. The residual follows the joint's own acceleration. Torque sensors \
               behind the gear do not see it. On the first joint it cannot be told from the inertia of link 1.",
        equation: "tau_j = Ia_j ddq_j",
        parameters: &[("Ia", "kg m^2", "rotor inertia times gear ratio squared")],
        confused_with: "rigid_body (the inertia of the last links about their own axes), noise of the \
                        acceleration (lower position_cutoff_hz and see whether it stays), time_delay",
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints })
    }
}

#[typetag::serde(name = "rotor_inertia")]
impl Effect for RotorInertia {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms(robot, "Ia", "kg m^2")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 1, |_, joint, slot| slot.copy_from_slice(at.ddq(joint)))
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn implausible(&self, values: &[f64]) -> Option<String> {
        values.iter().any(|inertia| *inertia < 0.0).then(|| "a negative inertia".to_string())
    }
}
