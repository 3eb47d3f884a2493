//! Faults of sensors: the motion is right, what is written down of it is not.

use serde::{Deserialize, Serialize};

use super::PerJoint;
use super::effect::{Moment, Observed, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use lacuna_base::error::{Error, Result};

/// Position sensors with a wrong zero: the true position is the logged one plus `error`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointZeroError {
    /// What is missing from the logged position [rad, m].
    pub errors: PerJoint,
}

impl JointZeroError {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "joint_zero_error",
        example: "(errors: [0.02])",
        scope: Scope::Joint,
        unit: 0.03,
        limit: 0.1,
        not_on: &[
            (0, "about an upright axis changes no torque"),
            (6, "of the last joint only turns the last link's parameters"),
        ],
        make: |j, s, _| boxed(JointZeroError { errors: only(j, s) }),
    };
}

#[typetag::serde(name = "joint_zero_error")]
impl PlantEffect for JointZeroError {
    fn check(&self, dof: usize) -> Result<()> {
        self.errors.check("the zero error", dof)
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn observe(&self, seen: &mut Observed) {
        for (j, q) in seen.q.iter_mut().enumerate() {
            q.iter_mut().for_each(|q| *q -= self.errors.of(j));
        }
    }
}

/// Torque sensors (or current gains) that show `1 + gain` times the torque.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueGain {
    /// Relative error of the gain.
    pub gains: PerJoint,
}

impl TorqueGain {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "torque_gain",
        example: "(gains: [0.05])",
        scope: Scope::Joint,
        unit: 0.05,
        limit: 0.3,
        not_on: &[],
        make: |j, s, _| boxed(TorqueGain { gains: only(j, s) }),
    };
}

#[typetag::serde(name = "torque_gain")]
impl PlantEffect for TorqueGain {
    fn check(&self, dof: usize) -> Result<()> {
        self.gains.check("the torque gain", dof)
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn observe(&self, seen: &mut Observed) {
        for (j, tau) in seen.tau.iter_mut().enumerate() {
            tau.iter_mut().for_each(|tau| *tau *= 1.0 + self.gains.of(j));
        }
    }
}

/// Torques that are written down late: the log has at `t` what was so at `t - delay`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TimeDelay {
    /// Delay \[s\]; negative where the torque comes early.
    pub delays_s: PerJoint,
}

impl TimeDelay {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "time_delay",
        example: "(delays_s: [0.0043])",
        scope: Scope::Joint,
        unit: 5e-3,
        limit: 0.05,
        not_on: &[],
        make: |j, s, _| boxed(TimeDelay { delays_s: only(j, s) }),
    };
}

#[typetag::serde(name = "time_delay")]
impl PlantEffect for TimeDelay {
    fn check(&self, dof: usize) -> Result<()> {
        self.delays_s.check("the delay", dof)?;
        match self.delays_s.0.iter().find(|d| d.abs() > 1.0) {
            Some(d) => {
                Err(Error::new(format!("a delay of {d} s")).help("delays are given in seconds, up to 1"))
            }
            None => Ok(()),
        }
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn observe(&self, seen: &mut Observed) {
        let dt = seen.dt;
        for (j, tau) in seen.tau.iter_mut().enumerate() {
            let shift = self.delays_s.of(j) / dt;
            if shift.abs() > 0.0 {
                let exact = tau.clone();
                tau.iter_mut().enumerate().for_each(|(k, tau)| *tau = interpolate(&exact, k as f64 - shift));
            }
        }
    }
}

/// The value of `x` at the fractional index `at`: the cubic through the four samples around it. Beyond the
/// ends the last sample stands.
fn interpolate(x: &[f64], at: f64) -> f64 {
    let last = x.len() - 1;
    let at = at.clamp(0.0, last as f64);
    let below = at.floor();
    let (k, s) = (below as usize, at - below);
    let sample = |i: usize| x[i.clamp(1, last + 1) - 1];
    // Indices are one up so that the sample before the first has one too.
    let (a, b, c, d) = (sample(k), sample(k + 1), sample(k + 2), sample(k + 3));
    let (p, q, r, t) = (s + 1.0, s, s - 1.0, s - 2.0);
    -a * q * r * t / 6.0 + b * p * r * t / 2.0 - c * p * q * t / 2.0 + d * p * q * r / 6.0
}

#[cfg(test)]
mod tests {
    use super::interpolate;

    #[test]
    fn cubics_are_interpolated_exactly_inside() {
        let f = |t: f64| 2.0 - t + 0.5 * t * t - 0.1 * t * t * t;
        let x: Vec<f64> = (0..20).map(|k| f(f64::from(k))).collect();
        for at in [1.0, 4.25, 9.9, 17.5] {
            assert!((interpolate(&x, at) - f(at)).abs() < 1e-11, "{at}");
        }
        assert!(
            (interpolate(&x, -3.0) - x[0]).abs() < 1e-15 && (interpolate(&x, 99.0) - x[19]).abs() < 1e-12
        );
    }
}
