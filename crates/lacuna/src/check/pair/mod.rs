//! A log against its robot: is everything read the way it was recorded?
//!
//! Positions, velocities and time stamps must agree with each other; that needs no model. Everything
//! else is decided by refitting the classical model (rigid body, viscous and Coulomb friction, offset)
//! to a few hundred filtered rows under one hypothesis after the other. Torques of different joints share
//! inertial parameters, so a wrong sign, order, unit or mounting leaves an error that no parameters can
//! take away, and the right reading takes it away at once. Only decisive improvements that
//! also hold on rows left out of the fit are called defects.

mod case;
mod extras;
mod reading;
mod search;
mod velocity;
mod words;

use serde::Serialize;

use crate::error::Result;
use crate::log::Log;
use crate::robot::Robot;
use crate::signals::{Folds, Rows, Run, Settings, detect_period, prepare};
use reading::{Change, Reading};
use search::{Found, Ground};
use velocity::Kinematics;

/// Rows of one fit.
const ROWS: usize = 500;
/// Folds that are held out.
const FOLDS: u16 = 4;

/// How bad a finding is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Severity {
    /// The log is not what it says, beyond reasonable doubt.
    Defect,
    /// Worth a look.
    Warning,
}

/// Something that is not as it should be.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Finding {
    /// Short name: `time_unit`, `position_unit`, `velocity_unit`, `velocity_sign`, `velocity_order`,
    /// `velocity_scale`, `velocity_lost`, `position_sign`, `torque_sign`, `joint_sign`, `joint_order`,
    /// `position_order`, `torque_order`, `mounting`, `no_gravity`, `convention`, `torque_unit`,
    /// `torque_scale` or `unexplained`.
    pub kind: &'static str,
    /// How bad it is.
    pub severity: Severity,
    /// Names of the joints it is about; empty for all.
    pub joints: Vec<String>,
    /// What is wrong, in words.
    pub text: String,
    /// Relative error as it is and put right [%], everything else that was found being put right. Friction
    /// that would drive the motion counts as error; where refitting hides the mistake, it is the error of
    /// the robot file's own inertias.
    pub error_percent: Option<[f64; 2]>,
    /// The same, every fold of rows predicted by the fit of the others [%].
    pub held_out_error_percent: Option<[f64; 2]>,
    /// Other mistakes that would explain the data as well.
    pub also_possible: Vec<String>,
    /// What to do.
    pub remedy: String,
}

/// What a log and a robot say about each other.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Findings {
    /// Rows of one fit, for all joints together.
    pub rows: usize,
    /// Which rows were held out together.
    pub folds: String,
    /// Relative error of the classical model as the files are [%]: root of the mean over joints of
    /// (residual / variation of the torque about its mean)².
    pub relative_error_percent: f64,
    /// The same held out [%].
    pub held_out_relative_error_percent: f64,
    /// Relative error of the robot file's own inertias, with only friction and offset fitted [%].
    pub own_inertias_error_percent: Option<f64>,
    /// Relative error after everything found was put right [%].
    pub corrected_relative_error_percent: f64,
    /// What was found, units first.
    pub findings: Vec<Finding>,
    /// Mistakes that these data cannot tell from what is written: the model explains both as well.
    pub not_told_apart: Vec<String>,
    /// The column map (RON) that reads the log right, where one helps.
    pub column_map: Option<String>,
}

impl Findings {
    /// Whether nothing worse than a warning was found.
    pub fn is_sound(&self) -> bool {
        self.findings.iter().all(|f| f.severity != Severity::Defect)
    }
}

/// Tests whether `log` is a log of `robot` in the units, signs, order and mounting that both claim.
///
/// `other_convention` is the same Denavit-Hartenberg table read in the other convention, where the robot
/// comes from such a table.
///
/// # Errors
/// When the log is too short or too slow to be filtered, or holds no changing torque.
pub fn log_against_robot(robot: &Robot, log: &Log, other_convention: Option<&Robot>) -> Result<Findings> {
    let kinematics = velocity::examine(log, robot);
    let (full, _) = prepare(&kinematics.log, &quick_settings(&kinematics.log))?;
    let run = thinned(&full);
    let folds = folds(&full, &run)?;
    let units_known = kinematics.position_degrees || kinematics.velocity_degrees;
    let ground = Ground {
        robot,
        other: other_convention,
        run: &run,
        folds: &folds,
        degrees_open: !units_known,
        memo: Default::default(),
    };
    let mut found = ground.search()?;
    let mut findings = extras::of_kinematics(robot, log, &kinematics, &found);
    findings.extend(of_steps(&ground, &found, &kinematics)?);
    findings.extend(extras::no_gravity(&ground, &found)?);
    findings.extend(extras::common_sign(&ground, &mut found)?);
    findings.extend(extras::torque_scale(&ground, &found)?);
    findings.extend(extras::unexplained(&found));
    findings.sort_by_key(|f| f.severity == Severity::Warning);
    let undecided = ground.undecided(&found.best)?;
    Ok(Findings {
        not_told_apart: undecided.iter().map(|c| words::change(robot, c, &kinematics).1).collect(),
        rows: run.samples() * robot.dof(),
        folds: folds.description.clone(),
        relative_error_percent: 100.0 * found.as_is.error,
        held_out_relative_error_percent: 100.0 * ground.held_out(&found.as_is.reading)?,
        own_inertias_error_percent: found.as_is.given.map(|e| 100.0 * e),
        corrected_relative_error_percent: 100.0 * found.best.error,
        column_map: words::column_map(log, robot, &kinematics, &found.best.reading),
        findings,
    })
}

/// The signal step for a check: the usual band where the log is fast and long enough for it.
pub(super) fn quick_settings(log: &Log) -> Settings {
    let usual = Settings::default();
    let length = log.t.last().zip(log.t.first()).map_or(0.0, |(end, start)| (end - start).abs());
    let rate = log.t.len() as f64 / length.max(1e-9);
    Settings { band_hz: usual.band_hz.min(0.2 * rate), trim_s: usual.trim_s.min(0.05 * length), ..usual }
}

/// At most [`ROWS`] samples, evenly spread.
fn thinned(run: &Run) -> Run {
    let every = run.samples().div_ceil(ROWS).max(1);
    let thin = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> {
        columns.iter().map(|c| c.iter().step_by(every).copied().collect()).collect()
    };
    Run {
        name: run.name.clone(),
        dt: run.dt * every as f64,
        start: run.start,
        q: thin(&run.q),
        dq: thin(&run.dq),
        ddq: thin(&run.ddq),
        tau: thin(&run.tau),
        ..Run::default()
    }
}

fn folds(full: &Run, run: &Run) -> Result<Folds> {
    let rows: Rows = run.rows();
    match detect_period(full) {
        Some(period) => Folds::same_phase(&[rows], period, FOLDS),
        None => {
            let block = run.dt * run.samples() as f64 / f64::from(4 * FOLDS);
            Folds::contiguous(&[rows], libm::round(block * 1e3).max(1.0) / 1e3, FOLDS)
        }
    }
}

/// One finding for every step of the search that stands up to rows it has not seen.
fn of_steps(ground: &Ground, found: &Found, kinematics: &Kinematics) -> Result<Vec<Finding>> {
    if found.steps.is_empty() {
        return Ok(Vec::new());
    }
    let robot = ground.robot;
    let after_out = ground.held_out(&found.best.reading)?;
    let proven = found.best.decisive(&found.as_is);
    let mut findings = Vec::new();
    for step in &found.steps {
        let without = ground.score(ground.after(found.steps.iter().filter(|s| *s != step)), None)?;
        let before_out = ground.held_out(&without.reading)?;
        let (kind, text, joints) = words::change(robot, step, kinematics);
        let others = ground.as_good_as(step, &found.steps, &found.best)?;
        let given =
            |from: &search::Scored| from.given.filter(|_| found.best.physical > 0.72 * without.physical);
        let errors = match given(&without).zip(given(&found.best)) {
            Some((before, after)) => [before, after],
            None => [without.physical, found.best.physical],
        };
        let holds = after_out < 0.8 * before_out || found.best.error > 0.72 * without.error;
        let sure = proven && holds && found.best.decisive(&without);
        let driving =
            if without.physical > 1.3 * without.error { "; as it is, friction would drive it" } else { "" };
        findings.push(Finding {
            kind,
            severity: if sure { Severity::Defect } else { Severity::Warning },
            joints: joints.iter().map(|&j| robot.joints[j].name.clone()).collect(),
            text: text + driving,
            error_percent: Some(errors.map(|e| 100.0 * e)),
            held_out_error_percent: Some([before_out, after_out].map(|e| 100.0 * e)),
            also_possible: others.iter().map(|c| words::change(robot, c, kinematics).1).collect(),
            remedy: words::remedy(step),
        });
    }
    Ok(findings)
}

/// Signs the search cannot see: every torque together.
fn all_torques(reading: &Reading) -> Reading {
    reading.with(&Change::FlipTorques((0..reading.torque.len()).collect()))
}

/// Change of position per logged velocity of every joint, where the two follow each other.
pub(super) fn velocity_slopes(log: &Log, robot: &Robot) -> Vec<Option<f64>> {
    velocity::examine(log, robot).slopes
}
