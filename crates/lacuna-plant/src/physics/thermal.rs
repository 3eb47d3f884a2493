use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use super::{PerJoint, check_finite, check_positive, smooth_sign, usual_width};
use lacuna_base::error::Result;
use lacuna_base::text::bounds::{NotNegative, Positive, Seconds};

/// Friction that follows a joint's temperature: `(T - reference) (coulomb tanh(dq / width) + viscous dq)`.
///
/// Motion heats the joint and its surroundings cool it: `T' = heating |dq| - (T - reference) / cooling_s`.
/// The log has the temperatures in channels `temperature1`, `temperature2`, ...
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ThermalFriction {
    /// Change of dry friction per kelvin [N m/K, N/K]; negative where oil thins.
    #[serde(default)]
    pub coulomb: PerJoint,
    /// Change of viscous friction per kelvin [N m s/(rad K), N s/(m K)].
    #[serde(default)]
    pub viscous: PerJoint,
    /// Warming per way [K/rad, K/m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub heating: PerJoint,
    /// Time over which a warm joint cools \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    pub cooling_s: f64,
    /// Temperature of the surroundings, at which the other friction is meant \[degrees Celsius\].
    #[serde(default = "room")]
    pub reference: f64,
    /// How much warmer the joints are at the start of a log \[K\].
    #[serde(default)]
    pub start: PerJoint,
    /// Velocity at which 76 % of the sign is reached [rad/s, m/s].
    #[serde(default = "usual_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

fn room() -> f64 {
    22.0
}

impl ThermalFriction {
    /// How much warmer than the surroundings; states start at zero, the log at `start`.
    fn excess(&self, now: &Moment, j: usize) -> f64 {
        now.own[j] + self.start.of(j) * libm::exp(-now.t / self.cooling_s)
    }
}

impl ThermalFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "thermal_friction",
        example: "(coulomb: [-0.004], viscous: [-0.02], heating: [0.2], cooling_s: 30, start: [2])",
        scope: Scope::Joint,
        unit: 0.1,
        limit: 5.0,
        not_on: &[],
        make: |j, s, draw| {
            // The log begins cold; friction grows with warmth so that the sum stays friction.
            let (heating, cooling_s) = (PerJoint::all(draw.between(0.2, 0.5)), draw.between(10.0, 40.0));
            boxed(ThermalFriction {
                coulomb: only(j, s),
                viscous: PerJoint::default(),
                heating,
                cooling_s,
                reference: 22.0,
                start: PerJoint::default(),
                width: 0.005,
            })
        },
    };
}

#[typetag::serde(name = "thermal_friction")]
impl PlantEffect for ThermalFriction {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the width of thermal friction", self.width)?;
        check_positive("the cooling time of thermal friction", self.cooling_s)?;
        check_finite("the reference temperature", &[self.reference])?;
        self.coulomb.check("thermal dry friction", dof)?;
        self.viscous.check("thermal viscous friction", dof)?;
        self.heating.check_not_negative("the heating of joints", dof)?;
        self.start.check("the temperature at the start", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            let v = now.dq[j];
            let per_kelvin = self.coulomb.of(j) * smooth_sign(v, self.width) + self.viscous.of(j) * v;
            *load += self.excess(now, j) * per_kelvin;
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        // Thirty kelvin of warming, if that makes friction steeper.
        for (j, slope) in slope.iter_mut().enumerate() {
            *slope += 30.0 * (self.coulomb.of(j) / self.width + self.viscous.of(j)).max(0.0);
        }
    }

    fn states(&self, dof: usize) -> usize {
        dof
    }

    fn rates(&self, now: &Moment, rates: &mut [f64]) {
        for (j, rate) in rates.iter_mut().enumerate() {
            *rate = self.heating.of(j) * now.dq[j].abs() - now.own[j] / self.cooling_s;
        }
    }

    fn measure(&self, now: &Moment, note: &mut dyn FnMut(&str, f64)) {
        for j in 0..now.q.len() {
            note(&format!("temperature{}", j + 1), self.reference + self.excess(now, j));
        }
    }
}
