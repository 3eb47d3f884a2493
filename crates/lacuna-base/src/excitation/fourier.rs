//! Periodic motions as finite Fourier series, the usual exciting trajectories.

use std::f64::consts::{PI, TAU};

use serde::{Deserialize, Serialize};

use super::{Motion, all_finite, position_range, positive_duration};
use crate::error::{Error, Result};
use crate::random::Stream;
use crate::robot::{Joint, Robot};
use crate::text::bounds::{Harmonics, Seconds};

/// Speed limit assumed for a random motion where the robot file has none [rad/s, m/s].
pub const DEFAULT_SPEED: f64 = 2.0;

/// Most harmonics times joints of a random motion, whose extremes take a sample for each and 64 of every harmonic.
const MOST_AMPLITUDES: usize = 100_000;

/// `dq_i(t) = sum_l a_li cos(l w t) + b_li sin(l w t)` with `w = 2 pi / period`, integrated to positions
/// whose mean over a period is `q0_i` (Swevers et al. 1997):
/// `q_i(t) = q0_i + sum_l (a_li sin(l w t) - b_li cos(l w t)) / (l w)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct FourierMotion {
    written: Written,
}

/// As written in a file: one row of `a` and `b` per harmonic, one column per joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    /// Fundamental period \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    period_s: f64,
    /// Cosine amplitudes of the velocity [rad/s, m/s].
    a: Vec<Vec<f64>>,
    /// Sine amplitudes of the velocity [rad/s, m/s].
    b: Vec<Vec<f64>>,
    /// Mean position [rad, m].
    q0: Vec<f64>,
}

impl FourierMotion {
    /// From the period \[s\], velocity amplitudes `a[harmonic][joint]` and `b[harmonic][joint]` [rad/s, m/s],
    /// and mean positions `q0` [rad, m].
    ///
    /// # Errors
    /// When the tables do not fit together, a number is not finite, or the period is not positive.
    pub fn new(period_s: f64, a: Vec<Vec<f64>>, b: Vec<Vec<f64>>, q0: Vec<f64>) -> Result<Self> {
        positive_duration("the period of the Fourier motion", period_s)?;
        let fits = |table: &[Vec<f64>]| table.iter().all(|row| row.len() == q0.len());
        if q0.is_empty() || a.is_empty() || a.len() != b.len() || !fits(&a) || !fits(&b) {
            return Err(Error::new("the tables of the Fourier motion do not fit together")
                .help("give as many rows in `a` as in `b` (one per harmonic), each with one number per entry of `q0`"));
        }
        all_finite("the Fourier motion", a.iter().chain(&b).flatten().chain(&q0))?;
        Ok(Self::from_tables(period_s, a, b, q0))
    }

    /// From tables that are known to fit.
    pub(super) fn from_tables(period_s: f64, a: Vec<Vec<f64>>, b: Vec<Vec<f64>>, q0: Vec<f64>) -> Self {
        Self { written: Written { period_s, a, b, q0 } }
    }

    /// A random motion that uses the fraction `amplitude` (0..1] of what the joint limits of `robot` allow
    /// in position or in speed, whichever binds first, about the middle of each range.
    ///
    /// Where the file gives no speed limit, [`DEFAULT_SPEED`] stands in for it.
    ///
    /// # Errors
    /// When a joint has no [`position_range`], or the numbers make no motion.
    pub fn random(robot: &Robot, seed: u64, harmonics: usize, period_s: f64, amplitude: f64) -> Result<Self> {
        Harmonics::check("harmonics", harmonics)?;
        if !(amplitude > 0.0 && amplitude <= 1.0) {
            return Err(Error::new(format!("an `amplitude` of {amplitude} makes no motion"))
                .help("give the part of each joint's range that is used, above 0 and up to 1"));
        }
        positive_duration("the period of the Fourier motion", period_s)?;
        let n = robot.dof();
        if harmonics * n > MOST_AMPLITUDES {
            return Err(Error::new(format!("`harmonics` is {harmonics} for {n} joints")).help(format!(
                "harmonics times joints are at most {MOST_AMPLITUDES}; 5 harmonics are usual"
            )));
        }
        let mut tables = [vec![vec![0.0; n]; harmonics], vec![vec![0.0; n]; harmonics]];
        let mut q0 = vec![0.0; n];
        for (j, joint) in robot.joints.iter().enumerate() {
            let (lower, upper) = position_range(joint)?;
            q0[j] = 0.5 * (lower + upper);
            let mut stream = Stream::new(seed, j);
            tables.iter_mut().flatten().for_each(|row| row[j] = stream.between(-1.0, 1.0));
        }
        let [a, b] = tables;
        let mut motion = Self::new(period_s, a, b, q0)?;
        motion.scale_to_limits(&robot.joints, amplitude)?;
        Ok(motion)
    }

    fn scale_to_limits(&mut self, joints: &[Joint], amplitude: f64) -> Result<()> {
        let (swing, speed) = self.extremes();
        for (j, joint) in joints.iter().enumerate() {
            let (lower, upper) = position_range(joint)?;
            let fastest = joint.limits.velocity.filter(|v| *v > 0.0).unwrap_or(DEFAULT_SPEED);
            let scale = amplitude * (0.5 * (upper - lower) / swing[j]).min(fastest / speed[j]);
            let Written { a, b, .. } = &mut self.written;
            a.iter_mut().chain(b).for_each(|row| row[j] *= scale);
        }
        Ok(())
    }

    /// Upper bounds of each joint's distance from `q0` and of its speed.
    fn extremes(&self) -> (Vec<f64>, Vec<f64>) {
        const POINTS_PER_HARMONIC: usize = 64;
        let (n, points) = (self.dof(), POINTS_PER_HARMONIC * self.written.a.len());
        let (mut q, mut dq, mut ddq) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        let (mut swing, mut speed) = (vec![0.0_f64; n], vec![0.0_f64; n]);
        for k in 0..points {
            self.at(self.written.period_s * k as f64 / points as f64, &mut q, &mut dq, &mut ddq);
            for j in 0..n {
                swing[j] = swing[j].max((q[j] - self.written.q0[j]).abs());
                speed[j] = speed[j].max(dq[j].abs());
            }
        }
        // Ehlich and Zeller 1964: between N points a trigonometric polynomial of degree L exceeds its
        // largest sample at most by the factor 1 / cos(pi L / N).
        let margin = 1.0 / libm::cos(PI / POINTS_PER_HARMONIC as f64);
        swing.iter_mut().chain(&mut speed).for_each(|x| *x *= margin);
        (swing, speed)
    }

    /// Fundamental period \[s\].
    pub fn period_s(&self) -> f64 {
        self.written.period_s
    }
}

impl TryFrom<Written> for FourierMotion {
    type Error = Error;

    fn try_from(written: Written) -> Result<Self> {
        Self::new(written.period_s, written.a, written.b, written.q0)
    }
}

impl From<FourierMotion> for Written {
    fn from(motion: FourierMotion) -> Self {
        motion.written
    }
}

impl Motion for FourierMotion {
    fn dof(&self) -> usize {
        self.written.q0.len()
    }

    fn at(&self, t: f64, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]) {
        let Written { period_s, a, b, q0 } = &self.written;
        let n = q0.len();
        q[..n].copy_from_slice(q0);
        dq[..n].fill(0.0);
        ddq[..n].fill(0.0);
        let w = TAU / period_s;
        for (l, (a, b)) in a.iter().zip(b).enumerate() {
            let lw = (l + 1) as f64 * w;
            let (sin, cos) = libm::sincos(lw * t);
            for j in 0..n {
                q[j] += (a[j] * sin - b[j] * cos) / lw;
                dq[j] += a[j] * cos + b[j] * sin;
                ddq[j] += (b[j] * cos - a[j] * sin) * lw;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::derivative_error;
    use super::super::panda_table_ii;
    use super::*;
    use crate::robot::samples;

    fn sample(motion: &FourierMotion, t: f64) -> [Vec<f64>; 3] {
        let mut out = [vec![0.0; motion.dof()], vec![0.0; motion.dof()], vec![0.0; motion.dof()]];
        let [q, dq, ddq] = &mut out;
        motion.at(t, q, dq, ddq);
        out
    }

    #[test]
    fn table_ii_closes_its_cycle_and_its_derivatives_agree() {
        let motion = panda_table_ii();
        for t in [0.0, 1.7, 6.0] {
            let (here, next) = (sample(&motion, t), sample(&motion, t + motion.period_s()));
            let apart = here.iter().flatten().zip(next.iter().flatten()).map(|(a, b)| (a - b).abs());
            assert!(apart.fold(0.0, f64::max) < 1e-12);
        }
        let error = derivative_error(&motion, (0..100).map(|k| 0.13 * f64::from(k)), 1e-5);
        assert!(error < 1e-8, "{error:e}");
    }

    #[test]
    fn random_motion_uses_what_it_may_of_the_limits() -> Result<()> {
        let robot = samples::seven_joint();
        let motion = FourierMotion::random(&robot, 5, 5, 10.0, 0.9)?;
        assert_eq!(motion, FourierMotion::random(&robot, 5, 5, 10.0, 0.9)?);
        let mut used = vec![0.0_f64; robot.dof()];
        for k in 0..20_000 {
            let [q, dq, _] = sample(&motion, 5e-4 * f64::from(k));
            for (j, joint) in robot.joints.iter().enumerate() {
                let (lower, upper) = position_range(joint)?;
                let swing = (q[j] - 0.5 * (lower + upper)).abs() / (0.5 * (upper - lower));
                let speed = dq[j].abs() / joint.limits.velocity.unwrap_or(DEFAULT_SPEED);
                used[j] = used[j].max(swing).max(speed);
            }
        }
        assert!(used.iter().all(|u| (0.895..=0.9).contains(u)), "{used:?}");
        Ok(())
    }

    #[test]
    fn written_form_round_trips_and_refuses_what_does_not_fit() -> Result<()> {
        let motion = panda_table_ii();
        let text = ron::to_string(&motion).map_err(|e| Error::new(e.to_string()))?;
        assert_eq!(ron::from_str::<FourierMotion>(&text).ok(), Some(motion));
        for bad in [
            "(period_s: 1.0, a: [[1.0]], b: [[1.0], [2.0]], q0: [0.0])",
            "(period_s: 1.0, a: [[1.0, 2.0]], b: [[1.0]], q0: [0.0])",
            "(period_s: -1.0, a: [[1.0]], b: [[1.0]], q0: [0.0])",
            "(period: 1.0, a: [[1.0]], b: [[1.0]], q0: [0.0])",
        ] {
            assert!(ron::from_str::<FourierMotion>(bad).is_err(), "{bad}");
        }
        Ok(())
    }
}
