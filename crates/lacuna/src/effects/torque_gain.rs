use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Wrong scale of a joint's torque measurement.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TorqueGain {
    /// Joints it acts on.
    pub joints: Joints,
}

impl TorqueGain {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "torque_gain",
        title: "torque measured too large or too small by a constant factor",
        text: "A drive gain or a sensor scale that is off on one joint. The residual is a copy of the joint's \
               torque. It only shows because the joints share links: were all joints wrong by the same \
               factor, every mass would be, and nothing would show.",
        equation: "tau_j measured = (1 + gain_j) tau_j",
        parameters: &[Parameter::new("gain", "1", "how much too large the measurement is")
            .within(0.3, "a torque scale that is off by more than 30 %")],
        cause: "a torque constant or a scale of a sensor that is wrong, or magnets that are warm",
        confused_with: "load_dependent_friction (also grows with the load but turns with the motion), payload \
                        and rigid_body (a heavier link acts on several joints)",
        separation: Separation::new(
            Asks::KnownLoad,
            "the same motion with and without a known payload, or poses with only one joint loaded",
        ),
        example: r#"{"torque_gain": (joints: Only(["2"]))}"#,
        drawn_against: Variable::Load,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special { built_from: BuiltFrom::Measurement, ..Special::NONE },
    };
}

#[typetag::serde(name = "torque_gain")]
impl Effect for TorqueGain {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.joints.terms(robot, "gain", "1")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let model = at.model_torque()?;
        self.joints.fill(at, out, 1, |_, joint, slot| {
            slot.copy_from_slice(&model.total[joint][at.range.clone()]);
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
