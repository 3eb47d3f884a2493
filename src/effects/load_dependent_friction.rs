use serde::{Deserialize, Serialize};

use super::parts::{FrictionPart, beyond, drives_motion, scale_with};
use super::{About, Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Friction in proportion to the torque that a joint passes on (Hamon, Gautier and Garrec 2010).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LoadDependentFriction {
    /// Joints it acts on.
    pub joints: Joints,
    /// Whether it is of constant size at a given load, or grows with speed.
    pub part: FrictionPart,
    /// Width of the smoothed sign `tanh(dq / width)` [rad/s]; 0 is the hard sign.
    pub width: f64,
}

impl LoadDependentFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "load_dependent_friction",
        title: "friction that grows with the torque in the joint",
        text: "Teeth and bearings that are pressed together rub more: friction follows the size of the \
               torque that the rigid links ask for (from the model, never the measured one, whose noise \
               would fake it). Heavy shoulders and elbows show it: Coulomb friction is larger with the arm \
               stretched out.",
        equation: "tau_j = lc_j |tau_rigid_j| sign(dq_j) + lv_j |tau_rigid_j| dq_j",
        parameters: &[
            ("lc", "1", "Coulomb friction per torque"),
            ("lv", "s/rad", "viscous friction per torque"),
        ],
        confused_with: "coulomb_friction (when the load hardly changes), torque_gain (does not turn with the \
                        motion)",
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        let of = |part| super::per_joint(robot, |joints| Self { joints, part, width: 0.0 });
        of(FrictionPart::Coulomb).into_iter().chain(of(FrictionPart::Viscous)).collect()
    }
}

#[typetag::serde(name = "load_dependent_friction")]
impl Effect for LoadDependentFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms_each(robot, &self.part.named(("lv", "s/rad"), ("lc", "1")))
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let model = at.model_torque()?;
        let parts = self.part.singles();
        self.joints.fill(at, out, parts.len(), |part, joint, slot| {
            parts[part].fill(at, joint, self.width, slot);
            scale_with(slot, &model.rigid[joint][at.range.clone()], f64::abs);
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn needs_torque(&self) -> bool {
        true
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }

    fn implausible(&self, values: &[f64]) -> Option<String> {
        drives_motion(values)
            .or_else(|| beyond(values, 0.5, "a joint that loses half its torque to friction"))
    }
}
