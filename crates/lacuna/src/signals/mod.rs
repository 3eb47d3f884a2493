//! From a raw [`Log`](crate::log::Log) to uniformly sampled, filtered motion: the one documented
//! signal step.
//!
//! [`prepare`] takes a log through these stages, and its [`SignalReport`] says what each did:
//!
//! 1. *clean*: rows that are not numbers, go back in time or repeat the state of the row before are
//!    left out; where the clock jumps, the longest stretch is kept.
//! 2. *clock*: time stamps, an even clock, or the robot's sample clock rebuilt from the motion where
//!    positions and logged velocities prove that the stamps are wrong.
//! 3. *resample*: linear interpolation onto that clock.
//!    A very long log keeps every so-many-th sample here, after a low-pass ([`thinned`]).
//! 4. *filter*: zero-phase Butterworth low-pass ([`ZeroPhase`]).
//! 5. *differentiate*: central differences.
//! 6. *trim and decimate*, at once ([`Mode::Inputs`]) or after the regressor was built from motion at
//!    the full rate ([`Mode::Parallel`], [`RowFilter`]).
//!
//! [`Folds`] then says which rows are held out together. Logged accelerations are not used: they are
//! differences taken by somebody else.

mod bank;
mod blocks;
mod clean;
mod clock;
mod derivative;
mod filter;
mod left_out;
mod period;
mod prepare;
mod rebuild;
mod report;
mod resample;
mod rows;
mod settings;
mod thin;

pub use blocks::{Folds, USUAL_BLOCK_S, USUAL_FOLDS};
pub use clean::Segment;
pub use clock::ClockReport;
pub use derivative::central_difference;
pub(crate) use derivative::smooth_derivative;
pub use filter::ZeroPhase;
pub(crate) use left_out::at_limit;
pub use period::detect_period;
pub use prepare::prepare;
pub use report::{SignalReport, ThinnedReport};
pub use rows::{RowFilter, Rows};
pub use settings::{ClockChoice, Keep, Mode, Settings, VelocityFrom};
pub use thin::thinned;

use std::borrow::Cow;
use std::sync::Arc;

use crate::stop::Stop;

/// A motion on a uniform clock, ready for regressors. Joint quantities are stored joint by joint:
/// `q[j][k]` is joint `j` at sample `k`.
///
/// Without a `row_filter` the samples are the rows of a fit. With one, torque and regressor columns
/// are computed at every sample first and become rows through [`Run::to_rows`].
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Run {
    /// Name of the log it came from.
    pub name: String,
    /// Sampling time \[s\].
    pub dt: f64,
    /// Time of the first sample \[s\], on the log's own clock.
    pub start: f64,
    /// Positions [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Velocities [rad/s, m/s].
    pub dq: Vec<Vec<f64>>,
    /// Accelerations [rad/s², m/s²].
    pub ddq: Vec<Vec<f64>>,
    /// Torques [N m, N]; empty where the log has none. Not filtered when there is a `row_filter`.
    pub tau: Vec<Vec<f64>>,
    /// Every other column, on the same clock, not filtered.
    pub channels: std::collections::BTreeMap<String, Vec<f64>>,
    /// What turns columns at the full rate into rows ([`Mode::Parallel`]).
    pub row_filter: Option<RowFilter>,
    /// Velocities for columns with a sign or a step at rest, where they were filtered less than `dq`
    /// ([`Settings::friction_cutoff_hz`]) [rad/s, m/s]; empty otherwise.
    pub friction_dq: Vec<Vec<f64>>,
    /// What positions went through before they were differentiated, where that can be told of the samples at hand
    /// ([`Mode::Parallel`]); an effect that displaces what is measured sends the displacement through the same.
    pub motion_filter: Option<ZeroPhase>,
    /// Rows that say nothing about the model of a joint, `unusable[joint][row]`: it stands still, where friction is
    /// whatever holds it, or its torque stays at a limit. Empty for a joint without any ([`Mode::Parallel`]).
    pub unusable: Vec<Vec<bool>>,
    /// Whether fits leave these rows out.
    pub leaves_out: bool,
    /// What the model at hand makes of this run; put here by a fit of effects that depend on it.
    pub model: Option<Arc<ModelTorque>>,
    /// The work that it is prepared for, which somebody may stop.
    pub stop: Stop,
}

/// What a model makes of one run, at every sample (not filtered).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct ModelTorque {
    /// Link parameters that make this torque, ten per link; those that never show in it are zero.
    pub links: Vec<f64>,
    /// Torque of the rigid links: `rigid[joint][sample]` [N m, N].
    pub rigid: Vec<Vec<f64>>,
    /// Torque of all effects together [N m, N], but for those that act on the measurement only.
    pub total: Vec<Vec<f64>>,
}

impl Run {
    /// Number of samples.
    pub fn samples(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }

    /// Velocities of joint `j` for columns with a sign or a step at rest [rad/s, m/s].
    pub fn friction_dq(&self, j: usize) -> &[f64] {
        self.friction_dq.get(j).unwrap_or(&self.dq[j])
    }

    /// Sets rows of joint `j`, the first of which is `first`, to zero where they are left out of fits.
    pub fn leave_out(&self, j: usize, first: usize, rows: &mut [f64]) {
        let Some(unusable) = self.unusable.get(j).filter(|u| self.leaves_out && !u.is_empty()) else {
            return;
        };
        rows.iter_mut().zip(&unusable[first..]).filter(|(_, out)| **out).for_each(|(y, _)| *y = 0.0);
    }

    /// Where the rows of a fit lie in time.
    pub fn rows(&self) -> Rows {
        match &self.row_filter {
            None => Rows { start: self.start, dt: self.dt, count: self.samples() },
            Some(rows) => Rows {
                start: self.start + rows.range.start as f64 * self.dt,
                dt: rows.every as f64 * self.dt,
                count: rows.count(),
            },
        }
    }

    /// A column given at every sample (torque, regressor column), as rows of a fit.
    pub fn to_rows<'a>(&self, column: &'a [f64]) -> Cow<'a, [f64]> {
        match &self.row_filter {
            None => Cow::Borrowed(column),
            Some(rows) => Cow::Owned(rows.apply(column)),
        }
    }
}

/// Median (the upper one of an even number), or `None` of nothing.
fn median(mut values: Vec<f64>) -> Option<f64> {
    let middle = values.len() / 2;
    if values.is_empty() {
        return None;
    }
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Least and largest of a series; infinite the wrong way round of nothing.
pub(crate) fn extremes(x: &[f64]) -> (f64, f64) {
    x.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
}

/// Correlation of two series of equal length, -1 to 1; 0 where one of them does not vary.
pub fn correlation(a: &[f64], b: &[f64]) -> f64 {
    let mean = |x: &[f64]| x.iter().sum::<f64>() / x.len().max(1) as f64;
    let (ma, mb) = (mean(a), mean(b));
    let (mut aa, mut bb, mut ab) = (0.0, 0.0, 0.0);
    for (x, y) in a.iter().zip(b) {
        let (x, y) = (x - ma, y - mb);
        (aa, bb, ab) = (aa + x * x, bb + y * y, ab + x * y);
    }
    if aa > 0.0 && bb > 0.0 { ab / (aa * bb).sqrt() } else { 0.0 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn series_are_compared_as_in_the_textbook() {
        let a = [1.0, 2.0, 3.0, 4.0];
        assert!((correlation(&a, &[2.0, 4.0, 6.0, 8.0]) - 1.0).abs() < 1e-15);
        assert!((correlation(&a, &[8.0, 6.0, 4.0, 2.0]) + 1.0).abs() < 1e-15);
        // Covariance 1.25 of variances 1.25 and 2.1875.
        let r = correlation(&a, &[1.0, 4.0, 2.0, 5.0]);
        assert!((r - 5.0 / (5.0_f64 * 10.0).sqrt()).abs() < 1e-15, "{r}");
        assert!(correlation(&a, &[7.0; 4]).abs() < 1e-15 && correlation(&[], &[]).abs() < 1e-15);
        let (low, high) = extremes(&[3.0, -1.0, 2.0]);
        assert!((low + 1.0).abs() < 1e-15 && (high - 3.0).abs() < 1e-15);
        assert!(extremes(&[]).0 > extremes(&[]).1);
    }
}
