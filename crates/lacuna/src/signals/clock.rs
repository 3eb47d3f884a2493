//! Which clock the samples have: their time stamps, an even one, or one rebuilt from the motion.

use serde::Serialize;

use super::rebuild::{self, Rebuilt};
use super::{ClockChoice, median};
use crate::error::{Error, Result};
use crate::log::Log;

/// Stamps within this share of a sampling time of an even clock differ from it by rounding alone.
const ROUNDING: f64 = 0.05;
/// A rebuilt clock is believed when it makes positions and velocities agree this many times better.
const PROOF: f64 = 2.0;
/// Stamps that are even up to this share have the nominal period next to theirs.
const NOMINAL: f64 = 5e-4;
/// An even clock is refused when it makes them agree this many times worse than the stamps.
const WORSE: f64 = 1.2;

/// The clock that was used and the evidence for it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ClockReport {
    /// `stamps` (uneven, as logged), `even` (stamps that are even up to jitter) or `rebuilt`.
    pub used: &'static str,
    /// Sampling time \[s\].
    pub period_s: f64,
    /// Root mean square of `diff(q) / diff(t) - dq` over all joints with the stamps as they are
    /// [rad/s, m/s]; absent without logged velocities.
    pub velocity_mismatch_stamps: Option<f64>,
    /// The same with the clock that was used.
    pub velocity_mismatch_used: Option<f64>,
    /// Samples of the rebuilt clock that no row shows.
    pub skipped_samples: usize,
}

/// Rows on a clock.
#[derive(Debug)]
pub(super) struct Clock {
    /// The rows it keeps.
    pub rows: Vec<usize>,
    /// Where each of them lies, in sampling times after the first.
    pub at: Vec<f64>,
    /// Rows it left out because their position was older than their velocity.
    pub torn: usize,
    pub report: ClockReport,
}

/// Positions, velocities and stamps of the rows in use.
pub(super) struct Motion<'a> {
    pub t: &'a [f64],
    pub q: &'a [Vec<f64>],
    pub dq: &'a [Vec<f64>],
    pub rows: &'a [usize],
}

impl Motion<'_> {
    /// Root mean square of `diff(q) / diff(t) - dq`, with times `period * at`.
    pub fn mismatch(&self, at: &[f64], period: f64) -> f64 {
        let mut sum = 0.0;
        for (w, x) in self.rows.windows(2).zip(at.windows(2)) {
            let dt = period * (x[1] - x[0]);
            for (q, dq) in self.q.iter().zip(self.dq) {
                let error = (q[w[1]] - q[w[0]]) / dt - 0.5 * (dq[w[0]] + dq[w[1]]);
                sum += error * error;
            }
        }
        libm::sqrt(sum / ((self.rows.len() - 1) * self.q.len()) as f64)
    }
}

/// Decides which clock the `rows` (at least two, increasing in time) have.
pub(super) fn decide(log: &Log, rows: &[usize], choice: ClockChoice) -> Result<Clock> {
    let stamps: Vec<f64> = rows.iter().map(|&k| log.t[k] - log.t[rows[0]]).collect();
    let motion = log.dq.as_ref().map(|dq| Motion { t: &log.t, q: &log.q, dq, rows });
    let raw = motion.as_ref().map(|m| m.mismatch(&stamps, 1.0));
    let (used, period, at) = from_stamps(&stamps, motion.as_ref(), raw);
    let mismatch = motion.as_ref().map(|m| m.mismatch(&at, period));
    let report = ClockReport {
        used,
        period_s: period,
        velocity_mismatch_stamps: raw,
        velocity_mismatch_used: mismatch,
        skipped_samples: 0,
    };
    let by_stamps = Clock { rows: rows.to_vec(), at, torn: 0, report };
    if choice == ClockChoice::Stamps {
        return Ok(by_stamps);
    }
    let rebuilt = motion.and_then(|m| rebuild::rebuild(&m));
    match (rebuilt, choice) {
        (Some(r), ClockChoice::Rebuilt) => Ok(with_rebuilt(r, raw)),
        (Some(r), _) if r.keeps_up && PROOF * r.mismatch < mismatch.unwrap_or(0.0) => {
            Ok(with_rebuilt(r, raw))
        }
        (None, ClockChoice::Rebuilt) => Err(Error::new(
            "the sample clock cannot be rebuilt: that takes logged velocities of a moving robot",
        )
        .in_file(&log.name)
        .help("set `clock: Auto`, or log dq")),
        _ => Ok(by_stamps),
    }
}

fn with_rebuilt(rebuilt: Rebuilt, raw: Option<f64>) -> Clock {
    let last = rebuilt.at.last().copied().unwrap_or(0.0);
    let report = ClockReport {
        used: "rebuilt",
        period_s: rebuilt.period,
        velocity_mismatch_stamps: raw,
        velocity_mismatch_used: Some(rebuilt.mismatch),
        skipped_samples: (last as usize + 1).saturating_sub(rebuilt.at.len()),
    };
    Clock { rows: rebuilt.rows, at: rebuilt.at, torn: rebuilt.torn, report }
}

/// An even clock where the stamps allow one and the velocities do not speak against it; otherwise
/// the stamps themselves, in units of their median step.
fn from_stamps(stamps: &[f64], motion: Option<&Motion>, raw: Option<f64>) -> (&'static str, f64, Vec<f64>) {
    let step = median(stamps.windows(2).map(|w| w[1] - w[0]).collect()).unwrap_or(1.0);
    if let Some((period, at, off)) = even(stamps, step) {
        let allowed = |m: &Motion| m.mismatch(&at, period) <= WORSE * raw.unwrap_or(f64::INFINITY);
        if off < ROUNDING || motion.is_none_or(allowed) {
            return ("even", period, at);
        }
    }
    let period = snap(step, NOMINAL);
    ("stamps", period, stamps.iter().map(|t| t / period).collect())
}

/// The even clock nearest to the stamps: its period, the places of the rows, and the largest
/// deviation in periods; `None` when that reaches half a period.
fn even(stamps: &[f64], step: f64) -> Option<(f64, Vec<f64>, f64)> {
    let mut place = 0.0;
    let steps = stamps.windows(2).map(|w| libm::round((w[1] - w[0]) / step).max(1.0));
    let at: Vec<f64> = std::iter::once(0.0)
        .chain(steps.map(|n| {
            place += n;
            place
        }))
        .collect();
    let n = at.len() as f64;
    let (mean_x, mean_t) = (at.iter().sum::<f64>() / n, stamps.iter().sum::<f64>() / n);
    let cross: f64 = at.iter().zip(stamps).map(|(x, t)| (x - mean_x) * (t - mean_t)).sum();
    let period = cross / at.iter().map(|x| (x - mean_x) * (x - mean_x)).sum::<f64>();
    let deviation = |period: f64| {
        let off = |(x, t): (&f64, &f64)| ((t - mean_t) - period * (x - mean_x)).abs() / period;
        at.iter().zip(stamps).map(off).fold(0.0, f64::max)
    };
    let round = snap(period, NOMINAL);
    let found = [round, period].into_iter().map(|p| (p, deviation(p))).find(|(_, off)| *off < 0.5);
    found.map(|(period, off)| (period, at, off))
}

/// The nearest nominal period up to the relative `tolerance`: a whole number of 0.1 ms or, up to
/// 250 Hz, a whole frequency in Hz. The period itself where there is none.
pub(super) fn snap(period: f64, tolerance: f64) -> f64 {
    let tenths = libm::round(period * 1e4) / 1e4;
    let whole_hz = 1.0 / libm::round(1.0 / period).clamp(1.0, 250.0);
    let off = |nominal: &f64| (nominal - period).abs();
    let nearest = if off(&tenths) <= off(&whole_hz) { tenths } else { whole_hz };
    if off(&nearest) <= tolerance * period { nearest } else { period }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nominal_periods_are_recognised_and_others_left_alone() {
        for (measured, nominal) in
            [(0.001_000_2, 0.001), (0.008_001, 0.008), (0.008_333_5, 1.0 / 120.0), (0.033_333, 1.0 / 30.0)]
        {
            assert!((snap(measured, NOMINAL) - nominal).abs() < 1e-15, "{measured}");
        }
        assert!((snap(0.001_003, NOMINAL) - 0.001_003).abs() < 1e-15);
    }

    #[test]
    fn stamps_rounded_to_milliseconds_give_the_even_clock_behind_them() {
        let stamps: Vec<f64> = (0..500).map(|k| libm::round(k as f64 / 120.0 * 1e3) / 1e3).collect();
        let (used, period, at) = from_stamps(&stamps, None, None);
        assert_eq!(used, "even");
        assert!((period - 1.0 / 120.0).abs() < 1e-15, "{period}");
        assert!(at.iter().enumerate().all(|(k, x)| (x - k as f64).abs() < 1e-12));
    }

    #[test]
    fn wandering_stamps_stay_as_they_are() {
        let stamps: Vec<f64> =
            (0..500).map(|k| 0.01 * k as f64 + 0.02 * libm::sin(0.01 * k as f64)).collect();
        let (used, period, at) = from_stamps(&stamps, None, None);
        assert_eq!(used, "stamps");
        assert!((at[499] * period - stamps[499]).abs() < 1e-12);
    }
}
