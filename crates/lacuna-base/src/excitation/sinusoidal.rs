//! Sinusoidal joint velocities, the paper's validation motion.

use std::f64::consts::TAU;

use serde::{Deserialize, Serialize};

use super::{Motion, all_finite, positive_duration};
use crate::error::{Error, Result};
use crate::text::bounds::Seconds;

/// Each joint moves with `dq_i = A_i sin(2 pi t / T_i)` from `q_i(0) = q0_i` (Gaz et al. 2019, eq. 31), so
/// every joint starts at rest and swings to one side of where it started.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct SinusoidalVelocity {
    written: Written,
}

/// As written in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    /// Largest speed of each joint, signed [rad/s, m/s].
    amplitudes: Vec<f64>,
    /// Period of each joint \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    periods_s: Vec<f64>,
    /// Start [rad, m].
    q0: Vec<f64>,
}

impl SinusoidalVelocity {
    /// From velocity amplitudes [rad/s, m/s], periods \[s\] and starting positions [rad, m], one per joint.
    ///
    /// # Errors
    /// When the lists differ in length or are empty, a number is not finite, or a period not positive.
    pub fn new(amplitudes: Vec<f64>, periods_s: Vec<f64>, q0: Vec<f64>) -> Result<Self> {
        let n = q0.len();
        if n == 0 || amplitudes.len() != n || periods_s.len() != n {
            let found = (amplitudes.len(), periods_s.len());
            let what = format!("{} amplitudes and {} periods for {n} starting positions", found.0, found.1);
            return Err(Error::new(what).help("give one of each per joint"));
        }
        all_finite("the sinusoidal motion", amplitudes.iter().chain(&q0))?;
        periods_s
            .iter()
            .try_for_each(|&period| positive_duration("a period of the sinusoidal motion", period))?;
        Ok(Self { written: Written { amplitudes, periods_s, q0 } })
    }
}

impl TryFrom<Written> for SinusoidalVelocity {
    type Error = Error;

    fn try_from(written: Written) -> Result<Self> {
        Self::new(written.amplitudes, written.periods_s, written.q0)
    }
}

impl From<SinusoidalVelocity> for Written {
    fn from(motion: SinusoidalVelocity) -> Self {
        motion.written
    }
}

impl Motion for SinusoidalVelocity {
    fn dof(&self) -> usize {
        self.written.q0.len()
    }

    fn at(&self, t: f64, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]) {
        let Written { amplitudes, periods_s, q0 } = &self.written;
        for j in 0..q0.len() {
            let w = TAU / periods_s[j];
            let (sin, cos) = libm::sincos(w * t);
            q[j] = q0[j] + amplitudes[j] / w * (1.0 - cos);
            dq[j] = amplitudes[j] * sin;
            ddq[j] = amplitudes[j] * w * cos;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::check::derivative_error;
    use super::*;

    #[test]
    fn starts_at_rest_peaks_after_a_quarter_period_and_is_consistent() -> Result<()> {
        let motion = SinusoidalVelocity::new(vec![2.1, -1.5], vec![4.0, 7.0], vec![0.3, -0.2])?;
        let (mut q, mut dq, mut ddq) = ([0.0; 2], [0.0; 2], [0.0; 2]);
        motion.at(0.0, &mut q, &mut dq, &mut ddq);
        assert!((q[0] - 0.3).abs() < 1e-15 && dq[0].abs() < 1e-15);
        motion.at(1.0, &mut q, &mut dq, &mut ddq);
        assert!((dq[0] - 2.1).abs() < 1e-14, "{dq:?}");
        motion.at(2.0, &mut q, &mut dq, &mut ddq);
        assert!((q[0] - (0.3 + 2.1 * 4.0 / std::f64::consts::PI)).abs() < 1e-14, "{q:?}");
        let error = derivative_error(&motion, (0..50).map(|k| 0.17 * f64::from(k)), 1e-5);
        assert!(error < 1e-9, "{error:e}");
        Ok(())
    }

    #[test]
    fn wrong_lengths_and_periods_are_refused() {
        assert!(SinusoidalVelocity::new(vec![1.0], vec![1.0, 2.0], vec![0.0]).is_err());
        assert!(SinusoidalVelocity::new(vec![1.0], vec![0.0], vec![0.0]).is_err());
        assert!(SinusoidalVelocity::new(vec![f64::NAN], vec![1.0], vec![0.0]).is_err());
        let typo = ron::from_str::<SinusoidalVelocity>("(amplitude: [1.0], periods_s: [1.0], q0: [0.0])");
        assert!(typo.is_err());
    }
}
