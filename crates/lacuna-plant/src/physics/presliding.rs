use serde::{Deserialize, Serialize};

use super::PerJoint;
use super::check_positive;
use super::effect::{Moment, OwnSlope, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{NotNegative, Positive};

/// Fastest motion for which the steepness is reckoned [rad/s, m/s].
const FAST: f64 = 3.0;

/// Dry friction that first yields like a spring: bristles bend over a short way before the joint slides.
///
/// `load = level (z + damping z')` with `z' = stiffness (dq - |dq| z / g)`: Dahl's model where `damping` is 0
/// and `static_ratio` is 1, otherwise that of Canudas de Wit et al. 1995 with
/// `g = 1 + (static_ratio - 1) exp(-(dq / velocity)²)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PreslidingHysteresis {
    /// Load of a sliding joint [N m, N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub levels: PerJoint,
    /// Reciprocal of the way over which bristles bend [1/rad, 1/m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub stiffness: PerJoint,
    /// Damping of the bristles, as the time by which their rate adds to their state \[s\].
    #[serde(default, deserialize_with = "NotNegative::read")]
    pub damping: f64,
    /// Friction of breaking loose over that of sliding.
    #[serde(default = "one", deserialize_with = "NotNegative::read")]
    pub static_ratio: f64,
    /// Velocity over which the excess fades [rad/s, m/s].
    #[serde(default = "tenth", deserialize_with = "Positive::read")]
    pub velocity: f64,
}

fn one() -> f64 {
    1.0
}

fn tenth() -> f64 {
    0.1
}

impl PreslidingHysteresis {
    /// Dahl's model.
    pub fn dahl(levels: PerJoint, stiffness: PerJoint) -> Self {
        Self { levels, stiffness, damping: 0.0, static_ratio: one(), velocity: tenth() }
    }

    fn rate(&self, j: usize, v: f64, z: f64) -> f64 {
        self.stiffness.of(j) * (v - v.abs() * z / self.plateau(v))
    }

    /// State of the bristles when sliding steadily.
    fn plateau(&self, v: f64) -> f64 {
        if self.static_ratio <= 1.0 {
            return 1.0;
        }
        let ratio = v / self.velocity;
        1.0 + (self.static_ratio - 1.0) * libm::exp(-ratio * ratio)
    }
}

impl PreslidingHysteresis {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "presliding_hysteresis",
        example: "(levels: [0.3], stiffness: [400])",
        scope: Scope::Joint,
        unit: 0.4,
        limit: 20.0,
        not_on: &[],
        make: |j, s, draw| boxed(PreslidingHysteresis::dahl(only(j, s), only(j, draw.between(40.0, 500.0)))),
    };
}

#[typetag::serde(name = "presliding_hysteresis")]
impl PlantEffect for PreslidingHysteresis {
    fn check(&self, dof: usize) -> Result<()> {
        self.levels.check_not_negative("presliding friction", dof)?;
        self.stiffness.check_not_negative("the stiffness of presliding friction", dof)?;
        check_positive("the velocity of presliding friction", self.velocity)?;
        let sound = self.static_ratio >= 1.0 && self.damping >= 0.0;
        if sound && self.static_ratio.is_finite() && self.damping.is_finite() {
            return Ok(());
        }
        let what = format!(
            "presliding friction has `static_ratio` {} and `damping` {}",
            self.static_ratio, self.damping
        );
        Err(Error::new(what)
            .help("breaking loose takes at least as much as sliding (1), damping is 0 or more"))
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            let bent = now.own[j];
            *load += self.levels.of(j) * (bent + self.damping * self.rate(j, now.dq[j], bent));
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        for (j, slope) in slope.iter_mut().enumerate() {
            *slope += self.levels.of(j) * self.stiffness.of(j) * self.damping;
        }
    }

    fn add_stiffness(&self, stiffness: &mut [f64]) {
        for (j, stiffness) in stiffness.iter_mut().enumerate() {
            *stiffness += self.levels.of(j) * self.stiffness.of(j);
        }
    }

    fn fastest_own_rate(&self) -> f64 {
        FAST * self.stiffness.0.iter().copied().fold(0.0, f64::max)
    }

    fn states(&self, dof: usize) -> usize {
        dof
    }

    fn rates(&self, now: &Moment, rates: &mut [f64]) {
        for (j, rate) in rates.iter_mut().enumerate() {
            *rate = self.rate(j, now.dq[j], now.own[j]);
        }
    }

    fn own_slopes(&self, now: &Moment, slopes: &mut [OwnSlope]) {
        for (j, slope) in slopes.iter_mut().enumerate() {
            let (v, s) = (now.dq[j], self.stiffness.of(j));
            slope.joint = j;
            slope.rate_per_own = -s * v.abs() / self.plateau(v);
            slope.rate_per_velocity = s * (1.0 - v.signum() * now.own[j]).max(0.0);
            slope.load_per_own = self.levels.of(j);
        }
    }
}
