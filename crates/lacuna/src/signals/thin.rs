//! Very long logs: what lies far above every filter of this step is taken out first, and only as many samples are kept
//! as the rest needs.

use std::collections::BTreeMap;

use rayon::prelude::*;

use super::clean::{self, Cleaned, Segment};
use super::clock::{self, Clock};
use super::filter::{ZeroPhase, keep_every};
use super::resample::Grid;
use super::{ClockReport, Mode, Settings};
use crate::error::{Error, Result};
use crate::log::{Dropped, Log, Thinned};

/// Rows times joints from which on a log is very long.
const VERY_LONG: usize = 2_000_000;
/// Rate that a very long log is thinned to at least \[Hz\]: room for the cut-offs that a diagnosis tries, but for its
/// sharpest of signs.
const USUAL_HZ: f64 = 125.0;
/// Samples that every period of the fastest cut-off keeps at least.
const PER_PERIOD: f64 = 2.5;
/// Cut-off of the low-pass before thinning, as part of the new rate, and its order: what is folded into a band of 5 Hz
/// at 125 Hz comes from above 120 Hz and has 2e-4 of its size left.
const CUTOFF: f64 = 0.4;
const ORDER: usize = 4;
/// Rows per second by the stamps alone that make it worth looking for the clock, as part of the rate that stays.
const ROUGHLY: f64 = 1.5;

/// The log, every so-many-th sample of it where it is so long that more than [`Settings::thin_to_hz`] would only cost
/// time and memory: cleaned, on its uniform clock, low-passed without delay. [`prepare`](super::prepare) does this by
/// itself; whoever reads a long log does it at once and lets go of the rest. Logs that were thinned stay as they are.
///
/// # Errors
/// When settings cannot work, or too little of the log can be used.
pub fn thinned(log: Log, settings: &Settings) -> Result<Log> {
    Ok(match Plan::of(&log, settings)? {
        Some(plan) => plan.carry_out(log),
        None => log,
    })
}

/// The log thinned, where it is to be and was not yet.
pub(super) fn still_to_be(log: &Log, settings: &Settings) -> Result<Option<Log>> {
    Ok(Plan::of(log, settings)?.map(|plan| plan.carry_out(log.clone())))
}

/// Whether a log is so long that memory and time matter more than every sample.
pub(super) fn is_very_long(log: &Log) -> bool {
    log.thinned.as_ref().map_or(log.rows(), |t| t.rows) * log.q.len() > VERY_LONG
}

/// Whether it is worth a closer look: long enough, or thinning is asked for, and fast enough by its stamps.
fn may_be(log: &Log, settings: &Settings) -> Result<bool> {
    let long = settings.thin_to_hz.is_some() || is_very_long(log);
    if log.thinned.is_some() || settings.mode != Mode::Parallel || !long {
        return Ok(false);
    }
    let seconds = log.t.first().zip(log.t.last()).map_or(0.0, |(a, b)| (b - a).abs());
    Ok(log.rows() as f64 > ROUGHLY * wanted_hz(settings)? * seconds)
}

/// How a log is thinned.
struct Plan {
    grid: Grid,
    filter: ZeroPhase,
    start: f64,
    dropped: BTreeMap<String, usize>,
    thinned: Thinned,
}

impl Plan {
    /// `None` where the log stays as it is.
    fn of(log: &Log, settings: &Settings) -> Result<Option<Self>> {
        if !may_be(log, settings)? {
            return Ok(None);
        }
        let (cleaned, clock) = on_clock(log, settings)?;
        let rate = 1.0 / clock.report.period_s;
        let every = (rate / wanted_hz(settings)? + 1e-9) as usize;
        if every < 2 {
            return Ok(None);
        }
        let dt = clock.report.period_s;
        let filter = ZeroPhase::butterworth(ORDER, CUTOFF * rate / every as f64, dt)?;
        let grid = Grid::new(&clock.rows, &clock.at);
        let thinned = Thinned {
            every,
            rows: clock.rows.len(),
            samples: grid.len(),
            samples_filled: grid.filled,
            longest_gap_s: grid.longest * dt,
            period_s: dt,
            clock: clock.report.used,
            velocity_mismatch: [clock.report.velocity_mismatch_stamps, clock.report.velocity_mismatch_used],
            skipped_samples: clock.report.skipped_samples,
            row_keys: log.row_keys(),
        };
        let start = log.t[clock.rows[0]];
        Ok(Some(Self { grid, filter, start, dropped: cleaned.dropped, thinned }))
    }

    fn carry_out(self, mut log: Log) -> Log {
        let columns = log.q.iter_mut().chain(log.dq.iter_mut().flatten()).chain(log.tau.iter_mut());
        let mut columns: Vec<&mut Vec<f64>> = columns.chain(log.channels.values_mut()).collect();
        // Column by column: the whole log twice would be too much.
        columns.par_iter_mut().for_each(|column| **column = self.thin(column));
        // Logged accelerations are not used by anything that comes after.
        log.ddq = None;
        let count = log.q.first().map_or(0, Vec::len);
        let step = self.thinned.every as f64 * self.thinned.period_s;
        log.t = (0..count).map(|k| self.start + k as f64 * step).collect();
        for (reason, rows) in self.dropped {
            log.dropped.entry(reason).or_insert(Dropped { rows, ..Dropped::default() });
        }
        log.thinned = Some(self.thinned);
        log
    }

    fn thin(&self, column: &[f64]) -> Vec<f64> {
        let mut samples = self.grid.apply(column);
        self.filter.apply(&mut samples);
        let all = 0..samples.len();
        keep_every(&mut samples, all, self.thinned.every);
        samples.shrink_to_fit();
        samples
    }
}

/// Least rate after thinning \[Hz\].
fn wanted_hz(settings: &Settings) -> Result<f64> {
    let fastest = settings.position_cutoff_hz.max(settings.friction_cutoff_hz.unwrap_or(0.0));
    let least = PER_PERIOD * fastest.max(settings.band_hz);
    match settings.thin_to_hz {
        Some(hz) if hz < least => Err(Error::new(format!("`thin_to_hz` is {hz:?}"))
            .help(format!("the cut-offs need at least {least:?} Hz; leave it out for what is usual"))),
        Some(hz) => Ok(hz),
        None => Ok(USUAL_HZ.max(least)),
    }
}

/// The rows worth using and their clock; a log that was thinned has both behind it.
pub(super) fn on_clock(log: &Log, settings: &Settings) -> Result<(Cleaned, Clock)> {
    let Some(thinned) = &log.thinned else {
        let mut cleaned = clean::clean(log, settings.max_gap_s, settings.trim_s)?;
        let clock = clock::decide(log, &cleaned.rows, settings.clock)?;
        if clock.torn > 0 {
            *cleaned.dropped.entry("torn".to_owned()).or_default() += clock.torn;
        }
        super::prepare::check_extent(log, &clock)?;
        return Ok((cleaned, clock));
    };
    let rows: Vec<usize> = (0..log.rows()).collect();
    let ends = log.t.first().zip(log.t.last()).map_or((0.0, 0.0), |(a, b)| (*a, *b));
    let segment = Segment { from_s: ends.0, to_s: ends.1, rows: thinned.rows, used: true };
    let dropped = log.dropped.iter().map(|(reason, d)| (reason.clone(), d.rows)).collect();
    let report = ClockReport {
        used: thinned.clock,
        period_s: thinned.every as f64 * thinned.period_s,
        velocity_mismatch_stamps: thinned.velocity_mismatch[0],
        velocity_mismatch_used: thinned.velocity_mismatch[1],
        skipped_samples: thinned.skipped_samples,
    };
    let at = rows.iter().map(|&k| k as f64).collect();
    let cleaned = Cleaned { rows: rows.clone(), dropped, segments: vec![segment] };
    Ok((cleaned, Clock { rows, at, torn: 0, report }))
}
