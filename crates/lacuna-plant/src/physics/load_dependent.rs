use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use super::{PerJoint, check_positive, smooth_sign, usual_width};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{NotNegative, Positive};

/// Torque for which the steepness is reckoned [N m, N].
const HEAVY: f64 = 30.0;

/// Friction in proportion to what the joint transmits, as between the teeth of a gear:
/// `|transmitted| (ratio tanh(dq / width) + viscous_ratio dq)`.
///
/// `transmitted` is what remains of the drive's torque behind all other effects and this one: it moves the
/// links and the rotor.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LoadDependentFriction {
    /// Dry friction per transmitted torque.
    #[serde(default, deserialize_with = "NotNegative::read")]
    pub ratios: PerJoint,
    /// Viscous friction per transmitted torque [s/rad, s/m].
    #[serde(default, deserialize_with = "NotNegative::read")]
    pub viscous_ratios: PerJoint,
    /// Velocity at which 76 % of the sign is reached [rad/s, m/s].
    #[serde(default = "usual_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

/// Why it cannot be told on the first and the last joint of a Panda.
const NO_LOAD: &str = "needs a load, and gravity puts none on this joint";

impl LoadDependentFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "load_dependent_friction",
        example: "(ratios: [0.05], viscous_ratios: [0.02])",
        scope: Scope::Joint,
        unit: 0.05,
        limit: 0.5,
        not_on: &[(0, NO_LOAD), (6, NO_LOAD)],
        make: |j, s, _| {
            let viscous_ratios = PerJoint::default();
            boxed(LoadDependentFriction { ratios: only(j, s), viscous_ratios, width: 0.005 })
        },
    };
}

#[typetag::serde(name = "load_dependent_friction")]
impl PlantEffect for LoadDependentFriction {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the width of load-dependent friction", self.width)?;
        self.ratios.check_not_negative("load-dependent friction", dof)?;
        self.viscous_ratios.check_not_negative("load-dependent friction", dof)?;
        match self.ratios.0.iter().find(|x| **x >= 0.9) {
            Some(x) => Err(Error::new(format!("a joint that loses {x} of its torque to friction locks"))
                .help("give ratios below 0.9")),
            None => Ok(()),
        }
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            let sign = smooth_sign(now.dq[j], self.width);
            let share = (self.ratios.of(j) * sign + self.viscous_ratios.of(j) * now.dq[j]).clamp(-0.9, 0.9);
            // What arrives is transmitted torque plus this friction, so the transmitted part follows from it.
            let arriving = now.tau[j] - *load;
            let transmitted = arriving.abs() / (1.0 + share * arriving.signum());
            *load += transmitted * share;
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        for (j, slope) in slope.iter_mut().enumerate() {
            *slope += HEAVY * (self.ratios.of(j) / self.width + self.viscous_ratios.of(j));
        }
    }

    fn comes_last(&self) -> bool {
        true
    }
}
