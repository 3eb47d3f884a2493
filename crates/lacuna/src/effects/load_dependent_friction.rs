use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{DRIVES_MOTION, FrictionPart, scale_with};
use super::{Columns, Effect, Joints, Stretch, Term};
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

/// What a ratio of a half would be.
const HALF_IS_LOST: &str = "a joint that loses half its torque to friction";

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
            Parameter::new("lc", "1", "Coulomb friction per torque")
                .at_least(0.0, DRIVES_MOTION)
                .at_most(0.5, HALF_IS_LOST),
            Parameter::new("lv", "s/rad", "viscous friction per torque")
                .at_least(0.0, DRIVES_MOTION)
                .at_most(0.5, HALF_IS_LOST),
        ],
        cause: "teeth and bearings that the load presses together",
        confused_with: "coulomb_friction (when the load hardly changes), torque_gain (does not turn with the \
                        motion)",
        separation: Separation::new(
            Asks::Loads,
            "the same speeds in poses with high and with low gravity load, or two payloads",
        ),
        example: r#"{"load_dependent_friction": (joints: Only(["2"]))}"#,
        drawn_against: Variable::Load,
        at_rest: AtRest::Step,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special {
            built_from: BuiltFrom::ModelTorque,
            exports: Exports { c: "from the torque of the rigid links", ..Exports::NOWHERE },
            ..Special::NONE
        },
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

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }
}
