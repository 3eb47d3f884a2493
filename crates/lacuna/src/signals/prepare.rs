//! The signal step from end to end.

use std::ops::Range;

use rayon::prelude::*;

use super::clean::Cleaned;
use super::clock::Clock;
use super::filter::keep_every;
use super::left_out::unusable;
use super::report::ThinnedReport;
use super::resample::Grid;
use super::thin::{is_very_long, on_clock, still_to_be};
use super::{
    ClockReport, Mode, RowFilter, Run, Settings, SignalReport, VelocityFrom, ZeroPhase, central_difference,
    smooth_derivative,
};
use crate::error::{Error, Result};
use crate::log::Log;

/// Turns a log into a uniformly sampled motion: clean, clock, resample, filter, differentiate, trim.
///
/// # Errors
/// When settings cannot work, when too little of the log can be used, or when the settings ask for
/// velocities or a clock that the log does not have. The message names the log and the remedy.
pub fn prepare(log: &Log, settings: &Settings) -> Result<(Run, SignalReport)> {
    settings.check()?;
    if let Some(thinned) = still_to_be(log, settings)? {
        return prepare(&thinned, settings);
    }
    check_log(log)?;
    let (cleaned, clock) = on_clock(log, settings)?;
    let grid = Grid::new(&clock.rows, &clock.at);
    let logged = logged_velocity(log, settings.velocity_from)?;
    let friction_logged = match settings.friction_velocity_from {
        VelocityFrom::Auto => logged,
        from => logged_velocity(log, from)?,
    };
    let long = is_very_long(log).then_some(grid.len());
    let design =
        Design::new(settings, clock.report.period_s, grid.len(), long).map_err(|e| e.about(&log.name))?;
    let sources = [logged, friction_logged].map(|l| l.is_some());
    let report = report(log, settings, cleaned, &clock, &grid, &design, sources);

    let motion = design.motion.as_ref().unwrap_or(&design.band);
    // The paper's way has central differences.
    let derivative = match settings.mode {
        Mode::Inputs => central_difference,
        Mode::Parallel => smooth_derivative,
    };
    let q = columns(&log.q, |c| filtered(grid.apply(c), motion));
    let dq = match logged {
        Some(dq) => columns(dq, |c| filtered(grid.apply(c), motion)),
        None => columns(&q, |c| derivative(c, design.dt)),
    };
    let friction_dq = match (&design.friction, friction_logged) {
        (None, _) => Vec::new(),
        (Some(friction), Some(dq)) => columns(dq, |c| filtered(grid.apply(c), friction)),
        (Some(friction), None) => {
            columns(&log.q, |c| derivative(&filtered(grid.apply(c), friction), design.dt))
        }
    };
    let ddq = columns(&dq, |c| derivative(c, design.dt));
    let tau = columns(&log.tau, |c| match settings.mode {
        Mode::Inputs => filtered(grid.apply(c), &design.band),
        Mode::Parallel => grid.apply(c),
    });
    let channels = log.channels.iter().map(|(name, c)| (name.clone(), grid.apply(c))).collect();
    let (name, start) = (log.name.clone(), log.t[clock.rows[0]]);
    let run = Run {
        name,
        dt: design.dt,
        start,
        q,
        dq,
        ddq,
        tau,
        channels,
        friction_dq,
        row_filter: None,
        motion_filter: None,
        unusable: Vec::new(),
        leaves_out: false,
        model: None,
        stop: Default::default(),
    };
    check_size(&run)?;
    let dt = design.dt;
    let mut run = design.finish(run, settings.mode);
    if let Some(rows) = &run.row_filter {
        run.unusable = (0..run.q.len())
            .into_par_iter()
            .map(|j| unusable(&grid.apply(&log.q[j]), run.tau.get(j).map_or(&[], Vec::as_slice), dt, rows))
            .collect();
    }
    Ok((run, report))
}

/// Numbers beyond this are no motion of a robot, and their squares and products overflow.
const LARGEST: f64 = 1e12;

/// Refuses numbers of the log that are too large, as they stand there.
fn check_log(log: &Log) -> Result<()> {
    let none = Vec::new();
    for (name, columns) in [("q", &log.q), ("dq", log.dq.as_ref().unwrap_or(&none)), ("tau", &log.tau)] {
        for (j, column) in columns.iter().enumerate() {
            // Rows with what is no number are left out later.
            if let Some(k) = column.iter().position(|x| x.is_finite() && x.abs() > LARGEST) {
                return Err(too_large(&log.name, &format!("{name}{}", j + 1), column[k], log.t[k]));
            }
        }
    }
    Ok(())
}

fn too_large(log: &str, column: &str, x: f64, t: f64) -> Error {
    let what = if x.is_finite() {
        format!("`{column}` is {x:.3e} at {t:.6e} s, too large for a robot")
    } else {
        format!("`{column}` grows beyond all numbers at {t:.6e} s once it is filtered and differentiated")
    };
    Error::new(what).in_file(log).help("check units and columns of the log, and its time stamps")
}

fn check_size(run: &Run) -> Result<()> {
    for (name, columns) in [("q", &run.q), ("dq", &run.dq), ("ddq", &run.ddq), ("tau", &run.tau)] {
        for (j, column) in columns.iter().enumerate() {
            if let Some(k) = column.iter().position(|x| x.is_nan() || x.abs() > LARGEST) {
                let (x, t) = (column[k], run.start + k as f64 * run.dt);
                return Err(too_large(&run.name, &format!("{name}{}", j + 1), x, t));
            }
        }
    }
    Ok(())
}

/// A clock that would need very many more samples than there are rows is none.
pub(super) fn check_extent(log: &Log, clock: &Clock) -> Result<()> {
    let samples = clock.at.last().copied().unwrap_or(0.0);
    if samples <= 100.0 * clock.rows.len() as f64 {
        return Ok(());
    }
    let (rows, step) = (clock.rows.len(), clock.report.period_s);
    let what = format!("the usual time step of {step:e} s would need {samples:.0} samples for {rows} rows");
    Err(Error::new(what).in_file(&log.name).help("the time stamps come in bursts; log evenly, or check `t`"))
}

/// Filters and row selection for one log.
struct Design {
    dt: f64,
    band: ZeroPhase,
    /// For positions and velocities before differentiation, where that is not the band.
    motion: Option<ZeroPhase>,
    /// For the velocities of columns with a sign, where that is neither.
    friction: Option<ZeroPhase>,
    range: Range<usize>,
    every: usize,
}

impl Design {
    fn new(settings: &Settings, dt: f64, samples: usize, very_long: Option<usize>) -> Result<Self> {
        let band =
            ZeroPhase::butterworth(settings.order, settings.band_hz, dt).map_err(|e| e.about("`band_hz`"))?;
        band.check_length(samples)?;
        let motion = match settings.mode {
            Mode::Inputs => None,
            Mode::Parallel => Some(
                ZeroPhase::butterworth(settings.order, settings.position_cutoff_hz, dt)
                    .map_err(|e| e.about("`position_cutoff_hz`"))?,
            ),
        };
        let friction = match (settings.mode, settings.friction_cutoff_hz) {
            (Mode::Parallel, Some(hz)) => Some(
                ZeroPhase::butterworth(settings.order, hz, dt)
                    .map_err(|e| e.about("`friction_cutoff_hz`"))?,
            ),
            _ => None,
        };
        let trim = libm::round(settings.trim_s / dt) as usize;
        let range = trim..samples.saturating_sub(trim);
        if range.len() < 3 {
            let (length, trimmed) = (samples as f64 * dt, settings.trim_s);
            let what =
                format!("nothing is left of {length:.3} s after `trim_s` of {trimmed:?} s at both ends");
            return Err(Error::new(what).help("record a longer motion, or trim less"));
        }
        Ok(Self { dt, band, motion, friction, range, every: settings.decimation(dt, very_long) })
    }

    /// Trims and decimates now, or leaves that to the rows.
    fn finish(self, mut run: Run, mode: Mode) -> Run {
        if mode == Mode::Parallel {
            run.motion_filter = self.motion;
            run.row_filter = Some(RowFilter { filter: self.band, range: self.range, every: self.every });
            return run;
        }
        run.start += self.range.start as f64 * self.dt;
        run.dt = self.dt * self.every as f64;
        let joints = [&mut run.q, &mut run.dq, &mut run.ddq, &mut run.tau].into_iter().flatten();
        for column in joints.chain(run.channels.values_mut()) {
            keep_every(column, self.range.clone(), self.every);
        }
        run
    }
}

fn columns(columns: &[Vec<f64>], work: impl Fn(&[f64]) -> Vec<f64> + Sync) -> Vec<Vec<f64>> {
    columns.par_iter().map(|column| work(column)).collect()
}

fn filtered(mut column: Vec<f64>, filter: &ZeroPhase) -> Vec<f64> {
    filter.apply(&mut column);
    column
}

/// The logged velocities, where they are wanted.
fn logged_velocity(log: &Log, from: VelocityFrom) -> Result<Option<&[Vec<f64>]>> {
    match (from, &log.dq) {
        (VelocityFrom::Position, _) | (VelocityFrom::Auto, None) => Ok(None),
        (_, Some(dq)) => Ok(Some(dq)),
        (VelocityFrom::Velocity, None) => Err(Error::new("the log has no velocities")
            .in_file(&log.name)
            .help("set `velocity_from: Position`, or log dq1..dqn")),
    }
}

fn report(
    log: &Log,
    settings: &Settings,
    cleaned: Cleaned,
    clock: &Clock,
    grid: &Grid,
    design: &Design,
    [logged, friction_logged]: [bool; 2],
) -> SignalReport {
    let source = |logged: bool| if logged { "logged" } else { "position" };
    let thinned = log.thinned.as_ref();
    SignalReport {
        log: log.name.clone(),
        rows_read: thinned.map_or(log.rows(), |t| t.rows)
            + log.dropped.values().map(|d| d.rows).sum::<usize>(),
        rows_dropped: cleaned.dropped,
        segments: cleaned.segments,
        clock: ClockReport {
            period_s: thinned.map_or(clock.report.period_s, |t| t.period_s),
            ..clock.report.clone()
        },
        samples: thinned.map_or(grid.len(), |t| t.samples),
        samples_filled: thinned.map_or(grid.filled, |t| t.samples_filled),
        longest_gap_s: thinned.map_or(grid.longest * design.dt, |t| t.longest_gap_s),
        thinned: (settings.mode == Mode::Parallel && (thinned.is_some() || is_very_long(log)))
            .then(|| ThinnedReport::of(thinned, design.dt, design.every)),
        mode: settings.mode.name(),
        band_hz: settings.band_hz,
        order: settings.order,
        source_of_velocity: source(logged),
        position_cutoff_hz: design.motion.as_ref().map(ZeroPhase::cutoff_hz),
        friction_cutoff_hz: design.friction.as_ref().map(ZeroPhase::cutoff_hz),
        source_of_friction_velocity: design.friction.as_ref().map(|_| source(friction_logged)),
        trim_s: settings.trim_s,
        decimate: design.every,
        rows_used: design.range.len().div_ceil(design.every),
    }
}
