//! From a path to a report: recognise, read, say what is wrong.

use std::path::{Path, PathBuf};

use super::report::{Problem, Report, Section};
use super::{
    Findings, Kind, LogFacts, RobotFacts, effect_script, fields, kind, log, log_against_robot, misplaced,
    scenario, script,
};
use crate::constraints::{LinkSpace, forms, open};
use crate::error::{Error, Result};
use crate::identify::BaseParameters;
use crate::log::{ColumnMap, Log, StaticPoses};
use crate::model_file::ModelFile;
use crate::robot::Robot;
use crate::scenario::{Published, PublishedFriction};
use crate::signals::{Mode, Settings, thinned};
use crate::simulate;
use crate::stop::Stop;
use crate::text;

/// What may be given beside the file.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Robot to check a log, poses, a model, coefficients or a script against.
    pub robot: Option<PathBuf>,
    /// Log to check a robot against.
    pub data: Option<PathBuf>,
    /// Column map of the log: a file, or the name of a shipped one.
    pub columns: Option<PathBuf>,
    /// Gravity to use instead of the robot file's [m/s², base frame].
    pub gravity: Option<[f64; 3]>,
    /// When what takes long (a script) ends.
    pub stop: Stop,
}

/// Checks a file. What is wrong with it stands in the report.
pub fn file(path: &Path, options: &Options) -> Report {
    let mut report = Report::new(path);
    if let Err(error) = examine(path, options, &mut report) {
        // What has no place of its own came up when the log was tried, or the file itself where there is none.
        let tried = options.data.as_deref().unwrap_or(path);
        let error = if error.place().is_none() { error.in_file(tried) } else { error };
        report.problems.insert(0, Problem::new(error, true));
    }
    for remark in &mut report.remarks {
        *remark = text::shown::cut_quotes(remark);
    }
    if report.unusable().is_some() {
        report.next = vec!["mend what is marked x, and check again".into()];
    }
    report
}

fn examine(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let kind = kind::recognise(path)?;
    report.kind = Some(kind);
    match kind {
        Kind::Urdf | Kind::DenavitHartenberg => robot(path, options, report),
        Kind::Log => a_log(path, options, report),
        Kind::Scenario => scenario::examine(path, options, report),
        Kind::Poses => poses(path, options, report),
        Kind::ColumnMap => column_map(path, options, report),
        Kind::Model => model(path, options, report),
        Kind::Coefficients => coefficients(path, options, report),
        Kind::Friction => friction(path, options, report),
        Kind::Constraints => constraints(path, options, report),
        Kind::Experiment => experiment(path, report),
        Kind::Script => script::examine(path, options, report),
        Kind::EffectScript => effect_script::examine(path, options, report),
    }
}

/// Opens a robot, and the same table in the other convention where it is one.
pub(super) fn open_robot(path: &Path, gravity: Option<[f64; 3]>) -> Result<(Robot, Option<Robot>)> {
    let under = |robot: Robot| match gravity {
        Some(g) => robot.with_gravity(g.into()),
        None => robot,
    };
    let robot = Robot::open(path).map_err(|e| misplaced(e, path, &[Kind::Urdf, Kind::DenavitHartenberg]))?;
    let robot = under(robot);
    let is_table = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron"));
    let text = if is_table { text::read(path).ok() } else { None };
    let other = text.and_then(|t| fields::other_convention(&t)).and_then(|t| Robot::from_dh(&t).ok());
    Ok((robot, other.map(under)))
}

/// Tests units, signs, order and mounting of a log that is at hand against a robot file, under this gravity where it is
/// given [m/s², base frame].
///
/// # Errors
/// When the robot cannot be read, or the log is too short or too slow to tell.
pub fn log_against_file(robot: &Path, gravity: Option<[f64; 3]>, log: &Log) -> Result<Findings> {
    let (robot, other) = open_robot(robot, gravity)?;
    log_against_robot(&robot, log, other.as_ref())
}

fn robot(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let (robot, other) = open_robot(path, options.gravity)?;
    describe(&robot, report);
    let Some(data) = &options.data else {
        report.next = vec![
            format!("lacuna check {} --data LOG.csv", path.display()),
            "checks a log against this robot".into(),
        ];
        return Ok(());
    };
    let map = options.columns.as_ref().map(ColumnMap::open).transpose()?;
    against(&robot, other.as_ref(), data, map.as_ref(), report)
}

/// Facts and remarks of a robot.
pub(super) fn describe(robot: &Robot, report: &mut Report) {
    let remark = |r: &crate::robot::Remark| {
        let line = r.line.map_or_else(String::new, |l| format!("line {l}: "));
        format!("{line}{}", r.text)
    };
    report.remarks.extend(robot.remarks.iter().map(remark));
    report.robot = Some(RobotFacts::new(robot));
}

fn a_log(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let map = options.columns.as_ref().map(ColumnMap::open).transpose()?;
    let Some(robot) = &options.robot else {
        let (log, robot) = log::open(path, None, map.as_ref())?;
        report.logs.push(LogFacts::new(&log, &robot));
        if log.q.iter().flatten().any(|q| q.abs() > 7.0) {
            report.remarks.push("positions beyond 7 rad: are they in degrees?".into());
        }
        report.next = vec![
            format!("lacuna check {} --robot ROBOT", path.display()),
            "tests units, signs, order of joints and mounting".into(),
        ];
        return Ok(());
    };
    let (robot, other) = open_robot(robot, options.gravity)?;
    against(&robot, other.as_ref(), path, map.as_ref(), report)
}

/// A log against a robot, into the report.
pub(super) fn against(
    robot: &Robot,
    other: Option<&Robot>,
    path: &Path,
    map: Option<&ColumnMap>,
    report: &mut Report,
) -> Result<()> {
    let log = Log::open(path, robot, map).map_err(|e| misplaced(e, path, &[Kind::Log]))?;
    // What is looked for shows in every so-many-th sample of a very long log as well.
    let log = thinned(log, &Settings { mode: Mode::Parallel, ..Settings::default() })?;
    report.logs.push(LogFacts::new(&log, robot));
    let findings = log_against_robot(robot, &log, other)?;
    report.next = if findings.is_sound() {
        vec!["lacuna scenario FILE.ron, with `robot` and `logs: Files(fit: [..])` in it".into()]
    } else {
        vec!["mend what is marked x and check again; what is identified would be wrong".into()]
    };
    report.against_robot.push((log.name.clone(), findings));
    Ok(())
}

fn needed_robot(options: &Options, what: &str, report: &mut Report) -> Result<Option<Robot>> {
    let Some(path) = &options.robot else {
        report.remarks.push(format!("give --robot ROBOT to check {what}"));
        return Ok(None);
    };
    Ok(Some(open_robot(path, options.gravity)?.0))
}

fn poses(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let Some(robot) = needed_robot(options, "the columns and rows of poses", report)? else { return Ok(()) };
    let poses = StaticPoses::open(path, &robot)?;
    let left_out: usize = poses.dropped.values().map(|d| d.rows).sum();
    let lines = vec![
        format!("{} poses of {} joints, {left_out} rows left out", poses.rows(), poses.q.len()),
        format!(
            "{} gravity torques and {} elements of the inertia matrix each",
            poses.g.len(),
            poses.m.len()
        ),
    ];
    report.sections.push(Section::wrapped("poses", lines));
    report.next = vec!["in a scenario: poses: File(\"..\")".into()];
    Ok(())
}

fn column_map(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let map = ColumnMap::open(path)?;
    let mut lines = Vec::new();
    let mut say = |name: &str, there: bool| {
        if there {
            lines.push(format!("maps {name}"));
        }
    };
    say("time", map.time.is_some());
    say("position", map.position.is_some());
    say("velocity", map.velocity.is_some());
    say("acceleration", map.acceleration.is_some());
    say("torque", map.torque.is_some());
    lines.extend(map.channels.keys().map(|ours| format!("maps channel {ours}")));
    report.sections.push(Section::wrapped("column map", lines));
    report.next = vec![format!("lacuna check LOG.csv --robot ROBOT --columns {}", path.display())];
    let (Some(robot), Some(data)) = (&options.robot, &options.data) else { return Ok(()) };
    let (robot, other) = open_robot(robot, options.gravity)?;
    against(&robot, other.as_ref(), data, Some(&map), report)
}

fn model(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let model = ModelFile::open(path)?;
    let effects: Vec<&str> = model.effects.iter().map(|e| e.about().name).collect();
    let lines = vec![
        format!("of robot `{}`, {} parameters, from {}", model.robot, model.parameters.len(), model.origin),
        format!("effects: {}", effects.join(" + ")),
    ];
    report.sections.push(Section::wrapped("model", lines));
    report.next = vec![format!("lacuna compare {} --robot ROBOT --data LOG.csv", path.display())];
    if let Some(robot) = needed_robot(options, "its parameters", report)? {
        model.on(&robot).map_err(|e| e.in_file(path))?;
    }
    Ok(())
}

fn friction(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let published = PublishedFriction::open(path)?;
    let lines = vec![format!("{} joints; source: {}", published.phi1.len(), published.source)];
    report.sections.push(Section::wrapped("sigmoid friction", lines));
    report.next = vec!["in a scenario: friction: (published: \"..\")".into()];
    let Some(robot) = needed_robot(options, "its joints", report)? else { return Ok(()) };
    published.parameters(robot.dof()).map(|_| ()).map_err(|e| e.in_file(path))
}

fn experiment(path: &Path, report: &mut Report) -> Result<()> {
    let (experiment, plant) = simulate::open(path, None)?;
    let seconds: f64 = experiment.logs.iter().map(|log| log.duration_s + 2.0 * log.ramp_s).sum();
    let lines = vec![
        format!("of robot `{}`, with {} effects in all logs", plant.robot.name, plant.effects.len()),
        format!(
            "{} logs, {seconds:.1} s in all, every {} s",
            experiment.logs.len(),
            plant.sensors.sampling_time_s
        ),
    ];
    report.sections.push(Section::wrapped("plant", lines));
    report.next = vec![format!("lacuna simulate {} --out DIR", path.display())];
    Ok(())
}

fn coefficients(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let published = Published::open(path)?;
    let lines = vec![format!("{} coefficients; source: {}", published.coefficients.len(), published.source)];
    report.sections.push(Section::wrapped("coefficients", lines));
    report.next = vec!["in a scenario: friction: (coefficients: \"..\")".into()];
    let Some(robot) = needed_robot(options, "its symbols", report)? else { return Ok(()) };
    let base = BaseParameters::new(&robot);
    published.values(&base).map_err(|e: Error| e.in_file(path))?;
    if published.coefficients.len() < base.rank() {
        let count = base.rank() - published.coefficients.len();
        report.remarks.push(format!("{count} of the robot's base parameters are not published: taken as 0"));
    }
    Ok(())
}

fn constraints(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let all = open(path)?;
    report.next = vec![format!("in a scenario: presets: [\"{}\"]", path.display())];
    let robot = needed_robot(options, "its links and parameters", report)?;
    let mut lines = Vec::new();
    for constraint in all {
        let about = constraint.about();
        let conditions = match &robot {
            None => String::new(),
            Some(robot) => {
                let one = forms(robot, &LinkSpace::new(robot, &[]), std::slice::from_ref(&constraint));
                let one = one.map_err(|e| text::placed(e, path))?;
                let convex = if one.iter().all(|form| form.is_convex()) { "convex" } else { "not convex" };
                format!(" ({} conditions, {convex})", one.len())
            }
        };
        lines.push(format!("{}: {}{conditions}", about.name, about.title));
    }
    report.sections.push(Section::wrapped("constraints", lines));
    Ok(())
}
