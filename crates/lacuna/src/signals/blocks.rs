//! Which rows are held out together.
//!
//! Neighbouring rows are not independent, so single rows must not be held out; and where a motion
//! repeats, all its repetitions must be held out at once, or the training has seen the test.

use super::{Rows, Run, detect_period};
use crate::error::{Error, Result};

/// Folds used when nobody asks for another number.
pub const USUAL_FOLDS: u16 = 8;
/// Length of a contiguous block when nobody asks for another one \[s\].
pub const USUAL_BLOCK_S: f64 = 2.0;

/// A partition of the rows of one or several runs, one after the other, into folds.
#[derive(Debug, Clone, PartialEq)]
pub struct Folds {
    /// Fold of each row.
    pub fold: Vec<u16>,
    /// Number of folds.
    pub count: u16,
    /// The rule in words, for reports.
    pub description: String,
}

impl Folds {
    /// Contiguous blocks of about `block_s` seconds that never span two runs, dealt in turn to
    /// `folds` folds (fewer where there are fewer blocks). A rest shorter than half a block joins the
    /// block before it.
    ///
    /// # Errors
    /// When `block_s` is not positive or fewer than two blocks come out.
    pub fn contiguous(runs: &[Rows], block_s: f64, folds: u16) -> Result<Self> {
        if !(block_s.is_finite() && block_s > 0.0 && folds >= 2) {
            return Err(Error::new(format!("{folds} folds of {block_s} s blocks hold nothing out"))
                .help("use at least 2 folds and blocks of about 2 s"));
        }
        let mut block_of = Vec::new();
        let mut blocks = 0;
        for run in runs {
            let in_run = (libm::round(run.count as f64 * run.dt / block_s) as usize).max(1);
            let place = |row: usize| (libm::floor(row as f64 * run.dt / block_s) as usize).min(in_run - 1);
            block_of.extend((0..run.count).map(|row| blocks + place(row)));
            blocks += if run.count > 0 { in_run } else { 0 };
        }
        if blocks < 2 {
            let what = format!("the data are too short to hold out blocks of {block_s} s");
            return Err(Error::new(what).help("record a longer motion, or use shorter blocks"));
        }
        let count = folds.min(blocks.min(usize::from(u16::MAX)) as u16);
        let fold = block_of.iter().map(|block| (block % usize::from(count)) as u16).collect();
        let description = format!("{count} folds of every {count}th block, {blocks} blocks of {block_s} s");
        Ok(Self { fold, count, description })
    }

    /// The same phase of a periodic motion in all its repetitions: the fold is `floor(folds * phase)`
    /// with `phase = (t mod period) / period` and `t` on the clock of the runs.
    ///
    /// # Errors
    /// When the period is not positive, or with fewer than two folds.
    pub fn same_phase(runs: &[Rows], period_s: f64, folds: u16) -> Result<Self> {
        if !(period_s.is_finite() && period_s > 0.0 && folds >= 2) {
            return Err(Error::new(format!("{folds} folds of a period of {period_s} s hold nothing out"))
                .help("use at least 2 folds and a positive period"));
        }
        let fold_at = |t: f64| {
            let phase = t / period_s - libm::floor(t / period_s);
            ((f64::from(folds) * phase) as u16).min(folds - 1)
        };
        let times = runs.iter().flat_map(|r| (0..r.count).map(move |k| r.start + k as f64 * r.dt));
        let description = format!("{folds} same-phase folds of a period of {period_s:.3} s");
        Ok(Self { fold: times.map(fold_at).collect(), count: folds, description })
    }

    /// The usual choice: same-phase folds where every run repeats with one period, otherwise
    /// contiguous blocks of 2 s; eight folds.
    ///
    /// # Errors
    /// When the runs are too short for two blocks.
    pub fn choose(runs: &[&Run]) -> Result<Self> {
        let rows: Vec<Rows> = runs.iter().map(|run| run.rows()).collect();
        match common_period(runs) {
            Some(period) => Self::same_phase(&rows, period, USUAL_FOLDS),
            None => Self::contiguous(&rows, USUAL_BLOCK_S, USUAL_FOLDS),
        }
    }
}

/// The period that all runs share up to one per cent.
fn common_period(runs: &[&Run]) -> Option<f64> {
    let periods: Vec<f64> = runs.iter().map(|run| detect_period(run)).collect::<Option<_>>()?;
    let first = *periods.first()?;
    let mean = periods.iter().sum::<f64>() / periods.len() as f64;
    periods.iter().all(|p| (p - first).abs() <= 0.01 * first).then_some(mean)
}

#[cfg(test)]
mod tests {
    use super::*;

    const RUNS: [Rows; 2] =
        [Rows { start: 0.5, dt: 0.01, count: 1030 }, Rows { start: 100.0, dt: 0.01, count: 500 }];

    #[test]
    fn blocks_are_contiguous_and_stay_in_their_run() {
        let folds = Folds::contiguous(&RUNS, 2.0, 8).expect("long enough");
        assert_eq!((folds.fold.len(), folds.count), (1530, 8));
        let changes: Vec<usize> = (1..1530).filter(|&k| folds.fold[k] != folds.fold[k - 1]).collect();
        assert_eq!(changes, [200, 400, 600, 800, 1030, 1230, 1430], "0.3 s of rest join their block");
        let few = Folds::contiguous(&RUNS[1..], 2.0, 8).expect("long enough");
        assert_eq!(few.count, 3, "three blocks cannot fill eight folds");
        assert!(Folds::contiguous(&RUNS[1..], 50.0, 8).is_err());
    }

    #[test]
    fn rows_one_period_apart_share_a_fold() {
        let folds = Folds::same_phase(&RUNS, 4.0, 8).expect("valid");
        assert!((0..600).all(|k| folds.fold[k] == folds.fold[k + 400]));
        assert_eq!(folds.fold[0], 1, "0.5 s of 4 s is the phase 1/8");
        let sizes: Vec<usize> = (0..8).map(|f| folds.fold.iter().filter(|&&x| x == f).count()).collect();
        assert!(sizes.iter().all(|&n| n > 0));
        assert_eq!(sizes.iter().sum::<usize>(), 1530);
    }

    #[test]
    fn senseless_folds_are_refused() {
        assert!(Folds::same_phase(&RUNS, 0.0, 8).is_err());
        assert!(Folds::same_phase(&RUNS, 3.0, 1).is_err());
        assert!(Folds::contiguous(&RUNS, f64::NAN, 8).is_err());
    }
}
