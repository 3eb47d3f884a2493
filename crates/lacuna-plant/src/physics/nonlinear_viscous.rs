use serde::{Deserialize, Serialize};

use super::PerJoint;
use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::Exponent;

/// Fastest motion for which the steepness is reckoned [rad/s, m/s].
const FAST: f64 = 3.0;

/// Friction that grows with a power of velocity: `coefficient |dq|^(exponent - 1) dq`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct NonlinearViscousFriction {
    /// Load at unit velocity [N m, N].
    pub coefficients: PerJoint,
    /// Power of the velocity.
    #[serde(default = "NonlinearViscousFriction::square", deserialize_with = "Exponent::read")]
    pub exponent: f64,
}

impl NonlinearViscousFriction {
    fn square() -> f64 {
        2.0
    }
}

impl NonlinearViscousFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "nonlinear_viscous_friction",
        example: "(coefficients: [0.3], exponent: 2.5)",
        scope: Scope::Joint,
        unit: 0.5,
        limit: 50.0,
        not_on: &[],
        make: |j, s, _| boxed(NonlinearViscousFriction { coefficients: only(j, s), exponent: 2.0 }),
    };
}

#[typetag::serde(name = "nonlinear_viscous_friction")]
impl PlantEffect for NonlinearViscousFriction {
    fn check(&self, dof: usize) -> Result<()> {
        if !(self.exponent.is_finite() && self.exponent > 1.0) {
            let what = format!("the `exponent` of nonlinear viscous friction is {}", self.exponent);
            return Err(Error::new(what).help("give more than 1, such as 2; 1 is viscous_friction"));
        }
        self.coefficients.check("nonlinear viscous friction", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            let v = now.dq[j];
            *load += self.coefficients.of(j) * libm::pow(v.abs(), self.exponent - 1.0) * v;
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        let steepness = self.exponent * libm::pow(FAST, self.exponent - 1.0);
        slope
            .iter_mut()
            .enumerate()
            .for_each(|(j, slope)| *slope += steepness * self.coefficients.of(j).max(0.0));
    }
}
