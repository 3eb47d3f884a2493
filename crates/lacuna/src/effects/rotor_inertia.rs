use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Effect, Joints, Stretch, Term};
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
        parameters: &[Parameter::new("Ia", "kg m^2", "rotor inertia times gear ratio squared")
            .at_least(0.0, "a negative inertia")],
        cause: "a motor that spins many times faster than its joint",
        confused_with: "rigid_body (the inertia of the last links about their own axes), noise of the \
                        acceleration (lower position_cutoff_hz and see whether it stays), time_delay",
        separation: Separation::OTHER,
        example: r#"{"rotor_inertia": (joints: All)}"#,
        drawn_against: Variable::Acceleration,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[Imitation::AccelerationNoise],
        special: Special {
            exports: Exports {
                mujoco: "armature of the joint",
                isaaclab: "armature of the joint",
                drake: "reflected inertia of the actuator",
                c: "as it is",
                ..Exports::NOWHERE
            },
            ..Special::NONE
        },
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
}
