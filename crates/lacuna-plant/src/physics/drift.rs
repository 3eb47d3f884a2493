//! Loads that change with time.

use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use super::{PerJoint, check_positive, smooth_sign, usual_width};
use lacuna_base::error::Result;
use lacuna_base::text::bounds::{Positive, Seconds};

/// A load that grows with time, as the zero of a warming torque sensor: `rate t`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueDrift {
    /// Growth [N m/s, N/s].
    pub rates: PerJoint,
}

impl TorqueDrift {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "torque_drift",
        example: "(rates: [0.01])",
        scope: Scope::Joint,
        unit: 0.02,
        limit: 2.0,
        not_on: &[],
        make: |j, s, _| boxed(TorqueDrift { rates: only(j, s) }),
    };
}

#[typetag::serde(name = "torque_drift")]
impl PlantEffect for TorqueDrift {
    fn check(&self, dof: usize) -> Result<()> {
        self.rates.check("the torque drift", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        load.iter_mut().enumerate().for_each(|(j, load)| *load += self.rates.of(j) * now.t);
    }
}

/// Friction that changes while the robot runs in: `(coulomb tanh(dq / width) + viscous dq) c(t)`, where
/// `c = exp(-t / time_s)`, or `c = t` without `time_s`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionDrift {
    /// Change of dry friction [N m, N], or its growth per second without `time_s`.
    #[serde(default)]
    pub coulomb: PerJoint,
    /// Change of viscous friction [N m s/rad, N s/m], or its growth per second without `time_s`.
    #[serde(default)]
    pub viscous: PerJoint,
    /// Time over which the change fades \[s\].
    #[serde(default, deserialize_with = "Seconds::read")]
    pub time_s: Option<f64>,
    /// Velocity at which 76 % of the sign is reached [rad/s, m/s].
    #[serde(default = "usual_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

impl FrictionDrift {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "friction_drift",
        example: "(coulomb: [0.2], viscous: [0.1], time_s: Some(8))",
        scope: Scope::Joint,
        unit: 0.5,
        limit: 20.0,
        not_on: &[],
        make: |j, s, draw| {
            let (coulomb, time_s) = (only(j, s), Some(draw.between(3.0, 12.0)));
            boxed(FrictionDrift { coulomb, viscous: PerJoint::default(), time_s, width: 0.005 })
        },
    };
}

#[typetag::serde(name = "friction_drift")]
impl PlantEffect for FrictionDrift {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the width of a friction drift", self.width)?;
        self.time_s.map_or(Ok(()), |time| check_positive("the time of a friction drift", time))?;
        self.coulomb.check("the drift of dry friction", dof)?;
        self.viscous.check("the drift of viscous friction", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        let course = self.time_s.map_or(now.t, |time| libm::exp(-now.t / time));
        for (j, load) in load.iter_mut().enumerate() {
            let v = now.dq[j];
            *load += course * (self.coulomb.of(j) * smooth_sign(v, self.width) + self.viscous.of(j) * v);
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        // A drift without end is reckoned for half a minute.
        let largest = if self.time_s.is_some() { 1.0 } else { 30.0 };
        for (j, slope) in slope.iter_mut().enumerate() {
            *slope += largest * (self.coulomb.of(j) / self.width + self.viscous.of(j)).max(0.0);
        }
    }
}
