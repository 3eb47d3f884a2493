//! Smooth starts and stops, so that a robot at rest can follow a motion that never rests.

use serde::{Deserialize, Serialize};

use super::{Motion, positive_duration};
use crate::error::Result;

/// The first `duration_s` seconds of a motion with a run-up before and a run-out after.
///
/// In the run-up the velocity grows by a cubic from zero velocity and acceleration to those that the motion
/// starts with; the run-out is its mirror image. The motion itself begins at time `ramp_s`; before the
/// run-up and after the run-out the robot rests.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Ramped<M> {
    motion: M,
    duration_s: f64,
    ramp_s: f64,
}

impl<M: Motion> Ramped<M> {
    /// Ramps of `ramp_s` \[s\] around the first `duration_s` \[s\] of `motion`.
    ///
    /// # Errors
    /// When one of the times is not positive.
    pub fn new(motion: M, duration_s: f64, ramp_s: f64) -> Result<Self> {
        positive_duration("the duration of the motion", duration_s)?;
        positive_duration("the ramp", ramp_s)?;
        Ok(Self { motion, duration_s, ramp_s })
    }

    /// Time from rest to rest \[s\].
    pub fn total_s(&self) -> f64 {
        self.duration_s + 2.0 * self.ramp_s
    }
}

/// Run-up at time `s * ramp` (`0 <= s <= 1`) into position `q`, velocity `v`, acceleration `a`.
fn run_up(s: f64, ramp: f64, q: f64, v: f64, a: f64) -> (f64, f64, f64) {
    let (s2, s3) = (s * s, s * s * s);
    let travelled = |s3: f64, s4: f64| ramp * (v * (s3 - 0.5 * s4) + a * ramp * (0.25 * s4 - s3 / 3.0));
    let start = q - travelled(1.0, 1.0);
    let velocity = v * (3.0 * s2 - 2.0 * s3) + a * ramp * (s3 - s2);
    let acceleration = 6.0 * v * (s - s2) / ramp + a * (3.0 * s2 - 2.0 * s);
    (start + travelled(s3, s2 * s2), velocity, acceleration)
}

impl<M: Motion> Motion for Ramped<M> {
    fn dof(&self) -> usize {
        self.motion.dof()
    }

    fn at(&self, t: f64, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]) {
        let inside = t - self.ramp_s;
        self.motion.at(inside.clamp(0.0, self.duration_s), q, dq, ddq);
        // The run-out is a run-up seen in a film that runs backwards: only velocities change sign.
        let (s, direction) = if inside < 0.0 {
            ((t / self.ramp_s).max(0.0), 1.0)
        } else if inside > self.duration_s {
            (((self.total_s() - t) / self.ramp_s).max(0.0), -1.0)
        } else {
            return;
        };
        for j in 0..self.dof() {
            let (x, v, a) = run_up(s, self.ramp_s, q[j], direction * dq[j], ddq[j]);
            (q[j], dq[j], ddq[j]) = (x, direction * v, a);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::derivative_error;
    use super::super::panda_table_ii;
    use super::*;

    #[test]
    fn rests_at_both_ends_and_stays_twice_differentiable() -> Result<()> {
        let motion = Ramped::new(panda_table_ii(), 20.0, 0.5)?;
        let n = motion.dof();
        let (mut q, mut dq, mut ddq) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for t in [-1.0, 0.0, motion.total_s(), 99.0] {
            motion.at(t, &mut q, &mut dq, &mut ddq);
            assert!(dq.iter().chain(&ddq).all(|x| x.abs() < 1e-12), "at {t} s: {dq:?} {ddq:?}");
        }
        // The grid steps over both joints of ramp and motion, where the jerk alone may jump.
        let error = derivative_error(&motion, (0..=2100).map(|k| 0.01 * f64::from(k)), 1e-6);
        assert!(error < 1e-4, "{error:e}");
        Ok(())
    }

    #[test]
    fn the_motion_itself_is_unchanged() -> Result<()> {
        let (plain, ramped) = (panda_table_ii(), Ramped::new(panda_table_ii(), 20.0, 0.5)?);
        let (mut a, mut b, mut rest) = ([0.0; 7], [0.0; 7], [[0.0; 7]; 2]);
        let [x, y] = &mut rest;
        plain.at(3.25, &mut a, x, y);
        ramped.at(3.75, &mut b, x, y);
        assert_eq!(a.map(f64::to_bits), b.map(f64::to_bits));
        Ok(())
    }
}
