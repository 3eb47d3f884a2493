use serde::{Deserialize, Serialize};

use super::effect::Moment;
use super::{check_finite, check_positive, joint_index, smooth_sign, usual_width};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{JointNumber, Positive, Seconds};

/// One factor of a [`super::Product`]. Joints are numbered from 1.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Factor {
    /// Position of a joint [rad, m].
    Position(#[serde(deserialize_with = "JointNumber::read")] usize),
    /// Velocity of a joint [rad/s, m/s].
    Velocity(#[serde(deserialize_with = "JointNumber::read")] usize),
    /// Size of a joint's velocity [rad/s, m/s].
    Speed(#[serde(deserialize_with = "JointNumber::read")] usize),
    /// Direction of a joint's motion, smooth at rest.
    Sign(#[serde(deserialize_with = "JointNumber::read")] usize),
    /// `sin(k q + phase)`.
    Wave {
        /// Joint.
        #[serde(deserialize_with = "JointNumber::read")]
        of: usize,
        /// Periods per turn.
        k: f64,
        /// Phase \[rad\].
        phase: f64,
    },
    /// A bump at an angle: `exp(-((q - at) / width)²)`.
    Bump {
        /// Joint.
        #[serde(deserialize_with = "JointNumber::read")]
        of: usize,
        /// Where [rad, m].
        at: f64,
        /// Half-width [rad, m].
        #[serde(deserialize_with = "Positive::read")]
        width: f64,
    },
    /// A detent at an angle, pulling towards it from both sides: `s exp((1 - s²) / 2)` with
    /// `s = (q - at) / width`; its largest value is 1.
    Detent {
        /// Joint.
        #[serde(deserialize_with = "JointNumber::read")]
        of: usize,
        /// Where [rad, m].
        at: f64,
        /// Distance of the strongest pull [rad, m].
        #[serde(deserialize_with = "Positive::read")]
        width: f64,
    },
    /// A spring that is touched only beyond an angle: `max(q - from, 0)`.
    Beyond {
        /// Joint.
        #[serde(deserialize_with = "JointNumber::read")]
        of: usize,
        /// Where it is touched [rad, m].
        from: f64,
    },
    /// A spring that is touched only below an angle: `min(q - to, 0)`.
    Below {
        /// Joint.
        #[serde(deserialize_with = "JointNumber::read")]
        of: usize,
        /// Where it is touched [rad, m].
        to: f64,
    },
    /// Straight pieces between points `(position, value)`, level outside.
    Pieces {
        /// Joint.
        #[serde(deserialize_with = "JointNumber::read")]
        of: usize,
        /// Points in rising order of position.
        points: Vec<(f64, f64)>,
    },
    /// A quantity of its own course, logged as channel `name`: a sum of three sinusoids with periods of
    /// `period_s`, 0.43 and 0.26 of it and a mean of `mean`, between `mean - 1` and `mean + 1`.
    Channel {
        /// Name of the channel.
        name: String,
        /// Longest period \[s\].
        #[serde(deserialize_with = "Seconds::read")]
        period_s: f64,
        /// Phase \[rad\].
        phase: f64,
        /// Mean.
        mean: f64,
    },
    /// On (1) or off (0) in time, in no regular pattern, and no channel says when.
    OnOff {
        /// Time between two chances to switch \[s\].
        #[serde(deserialize_with = "Seconds::read")]
        period_s: f64,
        /// Where the pattern begins, from 0 to 1.
        phase: f64,
    },
}

impl Factor {
    /// Value now.
    pub(super) fn value(&self, now: &Moment) -> f64 {
        match self {
            Self::Position(j) => now.q[j - 1],
            Self::Velocity(j) => now.dq[j - 1],
            Self::Speed(j) => now.dq[j - 1].abs(),
            Self::Sign(j) => smooth_sign(now.dq[j - 1], usual_width()),
            Self::Wave { of, k, phase } => libm::sin(k * now.q[of - 1] + phase),
            Self::Bump { of, at, width } => {
                let s = (now.q[of - 1] - at) / width;
                libm::exp(-s * s)
            }
            Self::Detent { of, at, width } => {
                let s = (now.q[of - 1] - at) / width;
                s * libm::exp(0.5 * (1.0 - s * s))
            }
            Self::Beyond { of, from } => (now.q[of - 1] - from).max(0.0),
            Self::Below { of, to } => (now.q[of - 1] - to).min(0.0),
            Self::Pieces { of, points } => pieces(points, now.q[of - 1]),
            Self::Channel { period_s, phase, mean, .. } => course(now.t / period_s, *phase, *mean),
            Self::OnOff { period_s, phase } => on_off(now.t / period_s, *phase),
        }
    }

    /// Steepest slope over velocity, and over position, of the joint it depends on; `None` for none.
    pub(super) fn slope(&self) -> Option<(usize, f64)> {
        match self {
            Self::Velocity(j) | Self::Speed(j) => Some((j - 1, 1.0)),
            Self::Sign(j) => Some((j - 1, 1.0 / usual_width())),
            _ => None,
        }
    }

    /// Largest value, reckoned with 3 rad and 3 rad/s.
    pub(super) fn largest(&self) -> f64 {
        match self {
            Self::Position(_)
            | Self::Velocity(_)
            | Self::Speed(_)
            | Self::Beyond { .. }
            | Self::Below { .. } => 3.0,
            Self::Pieces { points, .. } => points.iter().map(|p| p.1.abs()).fold(0.0, f64::max),
            Self::Channel { mean, .. } => 1.0 + mean.abs(),
            _ => 1.0,
        }
    }

    /// Refuses what has no meaning on a robot of `dof` joints.
    pub(super) fn check(&self, dof: usize) -> Result<()> {
        let joint = |j: usize| joint_index("a factor of the product", j, dof).map(|_| ());
        match self {
            Self::Position(j) | Self::Velocity(j) | Self::Speed(j) | Self::Sign(j) => joint(*j),
            Self::Wave { of, k, phase } => check_finite("a wave", &[*k, *phase]).and(joint(*of)),
            Self::Bump { of, at, width } | Self::Detent { of, at, width } => {
                check_positive("the width of a bump", *width)?;
                check_finite("a bump", &[*at]).and(joint(*of))
            }
            Self::Beyond { of, from: at } | Self::Below { of, to: at } => {
                check_finite("a stop", &[*at]).and(joint(*of))
            }
            Self::Pieces { of, points } => check_points(points).and(joint(*of)),
            Self::OnOff { period_s, phase } => {
                check_positive("the period of a switch", *period_s)?;
                check_finite("a switch", &[*phase])
            }
            Self::Channel { name, period_s, phase, mean } => {
                check_positive("the period of a channel", *period_s)?;
                check_finite("a channel", &[*phase, *mean])?;
                if name.is_empty() || name.contains([',', '"', '\n', '\r']) {
                    return Err(Error::new(format!("`{name}` is no name for a channel"))
                        .help("give a word such as `pressure1`"));
                }
                Ok(())
            }
        }
    }
}

fn check_points(points: &[(f64, f64)]) -> Result<()> {
    let finite = points.iter().all(|p| p.0.is_finite() && p.1.is_finite());
    if finite && points.len() >= 2 && points.windows(2).all(|w| w[0].0 < w[1].0) {
        return Ok(());
    }
    Err(Error::new("the points of a piecewise factor are not in order")
        .help("give at least two finite points with rising positions"))
}

fn pieces(points: &[(f64, f64)], q: f64) -> f64 {
    let above = points.partition_point(|p| p.0 <= q);
    match (above.checked_sub(1).and_then(|i| points.get(i)), points.get(above)) {
        (Some(&(a, x)), Some(&(b, y))) => x + (y - x) * (q - a) / (b - a),
        (Some(&(_, x)), None) | (None, Some(&(_, x))) => x,
        (None, None) => 0.0,
    }
}

/// Pseudo-random steps between 0 and 1, passed in a twentieth of a period.
fn on_off(periods: f64, phase: f64) -> f64 {
    // The fractional parts of multiples of the golden ratio are spread evenly and never repeat.
    let golden = 0.618_033_988_749_894_9;
    let at = |n: f64| if (n * golden + phase).rem_euclid(1.0) < 0.5 { 1.0 } else { 0.0 };
    let now = periods.floor();
    let s = ((periods - now) / 0.05).min(1.0);
    at(now - 1.0) + (at(now) - at(now - 1.0)) * s
}

/// A course between `mean - 1` and `mean + 1` that hardly repeats.
fn course(periods: f64, phase: f64, mean: f64) -> f64 {
    let wave = |part: f64, shift: f64| libm::sin(std::f64::consts::TAU * periods / part + phase + shift);
    mean + 0.5 * wave(1.0, 0.0) + 0.3 * wave(0.43, 1.3) + 0.2 * wave(0.26, 4.1)
}
