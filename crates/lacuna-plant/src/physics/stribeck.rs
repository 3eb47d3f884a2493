use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use super::{PerJoint, check_positive, smooth_sign, usual_width};
use lacuna_base::error::Result;
use lacuna_base::text::bounds::{NotNegative, Positive};

/// Extra dry friction of slow motion: `level tanh(dq / width) exp(-(dq / velocity)²)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StribeckFriction {
    /// How much friction near rest exceeds that of motion [N m, N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub levels: PerJoint,
    /// Velocity over which the excess fades [rad/s, m/s].
    #[serde(deserialize_with = "NotNegative::read")]
    pub velocities: PerJoint,
    /// Velocity at which 76 % of the sign is reached [rad/s, m/s].
    #[serde(default = "usual_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

impl StribeckFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "stribeck_friction",
        example: "(levels: [0.4], velocities: [0.1])",
        scope: Scope::Joint,
        unit: 0.5,
        limit: 20.0,
        not_on: &[],
        make: |j, s, draw| {
            let velocities = only(j, draw.between(0.06, 0.25));
            boxed(StribeckFriction { levels: only(j, s), velocities, width: 0.005 })
        },
    };
}

#[typetag::serde(name = "stribeck_friction")]
impl PlantEffect for StribeckFriction {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the width of Stribeck friction", self.width)?;
        self.levels.check_not_negative("Stribeck friction", dof)?;
        self.velocities.check("the velocities of Stribeck friction", dof)?;
        (0..dof)
            .filter(|&j| self.levels.of(j) > 0.0)
            .try_for_each(|j| check_positive("a velocity of Stribeck friction", self.velocities.of(j)))
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate().filter(|(j, _)| self.levels.of(*j) > 0.0) {
            let ratio = now.dq[j] / self.velocities.of(j);
            *load += self.levels.of(j) * smooth_sign(now.dq[j], self.width) * libm::exp(-ratio * ratio);
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        slope.iter_mut().enumerate().for_each(|(j, slope)| *slope += self.levels.of(j) / self.width);
    }
}
