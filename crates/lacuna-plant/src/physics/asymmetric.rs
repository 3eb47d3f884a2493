use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use super::{PerJoint, check_positive, smooth_sign, usual_width};
use lacuna_base::error::Result;
use lacuna_base::text::bounds::{NotNegative, Positive};

/// Friction that differs between the two directions of motion:
/// `viscous dq + coulomb` forwards, `viscous dq - coulomb` backwards, each direction with its own numbers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct AsymmetricFriction {
    /// Load per velocity forwards [N m s/rad, N s/m].
    #[serde(default, deserialize_with = "NotNegative::read")]
    pub viscous_forward: PerJoint,
    /// Load per velocity backwards [N m s/rad, N s/m].
    #[serde(default, deserialize_with = "NotNegative::read")]
    pub viscous_backward: PerJoint,
    /// Size of dry friction forwards [N m, N].
    #[serde(default, deserialize_with = "NotNegative::read")]
    pub coulomb_forward: PerJoint,
    /// Size of dry friction backwards [N m, N].
    #[serde(default, deserialize_with = "NotNegative::read")]
    pub coulomb_backward: PerJoint,
    /// Velocity at which one direction has taken over from the other by 76 % [rad/s, m/s].
    #[serde(default = "usual_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

impl AsymmetricFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "asymmetric_friction",
        example: "(viscous_forward: [0.5], viscous_backward: [0.2], coulomb_forward: [0.3])",
        scope: Scope::Joint,
        unit: 0.5,
        limit: 50.0,
        not_on: &[],
        make: |j, s, _| {
            let none = PerJoint::default;
            boxed(AsymmetricFriction {
                viscous_forward: only(j, s),
                viscous_backward: none(),
                coulomb_forward: none(),
                coulomb_backward: none(),
                width: 0.005,
            })
        },
    };
}

#[typetag::serde(name = "asymmetric_friction")]
impl PlantEffect for AsymmetricFriction {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the width of asymmetric friction", self.width)?;
        for numbers in
            [&self.viscous_forward, &self.viscous_backward, &self.coulomb_forward, &self.coulomb_backward]
        {
            numbers.check_not_negative("asymmetric friction", dof)?;
        }
        Ok(())
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            let (v, sign) = (now.dq[j], smooth_sign(now.dq[j], self.width));
            let forward = self.viscous_forward.of(j) * v + self.coulomb_forward.of(j);
            let backward = self.viscous_backward.of(j) * v - self.coulomb_backward.of(j);
            *load += 0.5 * (1.0 + sign) * forward + 0.5 * (1.0 - sign) * backward;
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        for (j, slope) in slope.iter_mut().enumerate() {
            let (forward, backward) = (self.viscous_forward.of(j), self.viscous_backward.of(j));
            let dry = 0.5 * (self.coulomb_forward.of(j) + self.coulomb_backward.of(j)) / self.width;
            // Where the directions change over, their difference is passed within a few widths.
            *slope += dry + forward.max(backward) + 0.25 * (forward - backward).abs();
        }
    }
}
