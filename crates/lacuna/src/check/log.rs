//! Facts about a log.

use std::collections::BTreeMap;
use std::path::Path;

use serde::Serialize;

use super::pair::{quick_settings, velocity_slopes};
use super::report::{Section, number};
use crate::error::Result;
use crate::log::{ColumnMap, Columns, Log};
use crate::report::{finite, wrap};
use crate::robot::samples;
use crate::robot::{InertialParameters, JointKind, Pose, Robot};
use crate::signals::{detect_period, prepare};

/// What a log holds.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct LogFacts {
    /// File name.
    pub name: String,
    /// Joints.
    pub joints: Vec<JointRange>,
    /// Rows that were read.
    pub rows: usize,
    /// Rows left out, by reason (those that the signal step would leave out included).
    pub left_out: BTreeMap<String, usize>,
    /// Columns that were not read, with the reason.
    pub ignored: BTreeMap<String, String>,
    /// Joint quantities there are.
    pub quantities: Vec<&'static str>,
    /// Other columns.
    pub channels: Vec<String>,
    /// Last time stamp less the first \[s\].
    pub duration_s: f64,
    /// Sampling rate by the clock that the signal step finds \[Hz\].
    pub rate_hz: Option<f64>,
    /// Period of the motion where it repeats \[s\].
    pub period_s: Option<f64>,
    /// The signal step in words.
    pub signals: Vec<String>,
}

/// Where a joint goes.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointRange {
    /// Name.
    pub name: String,
    /// Smallest and largest position [rad, m].
    pub position: [f64; 2],
    /// The same in degrees, for joints that turn.
    pub degrees: Option<[f64; 2]>,
    /// Largest torque [N m, N].
    pub torque: Option<f64>,
    /// Change of position per logged velocity: 1 where they agree, none where they do not follow each other.
    pub velocity_slope: Option<f64>,
    /// Whether the position leaves the limits of the robot file.
    pub beyond_limits: bool,
}

impl LogFacts {
    pub(super) fn new(log: &Log, robot: &Robot) -> Self {
        let mut left_out: BTreeMap<String, usize> =
            log.dropped.iter().map(|(why, d)| (why.clone(), d.rows)).collect();
        let mut facts = Self {
            name: log.name.clone(),
            joints: ranges(log, robot),
            rows: log.thinned.as_ref().map_or(log.rows(), |t| t.rows),
            left_out: BTreeMap::new(),
            ignored: log.ignored.clone(),
            quantities: quantities(log),
            channels: log.channels.keys().cloned().collect(),
            duration_s: log.t.last().zip(log.t.first()).map_or(0.0, |(end, start)| end - start),
            rate_hz: None,
            period_s: None,
            signals: Vec::new(),
        };
        if let Ok((run, report)) = prepare(log, &quick_settings(log)) {
            left_out = report.rows_dropped.clone();
            facts.rate_hz = finite(1.0 / report.clock.period_s);
            facts.period_s = detect_period(&run);
            facts.signals = report.lines().into_iter().skip(1).filter(|l| !l.contains("mode ")).collect();
        }
        facts.left_out = left_out;
        facts
    }

    pub(super) fn section(&self) -> Section {
        let mut lines = vec![format!("{} rows over {:.3} s", self.rows, self.duration_s)];
        if let Some(rate) = self.rate_hz {
            lines[0] += &format!(" at {} Hz", number(rate, 5));
        }
        let period = self.period_s.map_or("does not repeat".into(), |p| format!("repeats every {p:.3} s"));
        lines.push(format!("holds {}; the motion {period}", self.quantities.join(", ")));
        if !self.channels.is_empty() {
            lines.extend(wrap(&format!("other columns: {}", self.channels.join(", ")), 76));
        }
        for (column, why) in &self.ignored {
            lines.extend(wrap(&format!("not read: {column} ({why})"), 76));
        }
        let left_out: Vec<String> = self.left_out.iter().map(|(why, n)| format!("{n} {why}")).collect();
        if !left_out.is_empty() {
            lines.extend(wrap(&format!("rows left out: {}", left_out.join(", ")), 76));
        }
        lines.extend(
            self.signals
                .iter()
                .filter(|l| l.contains("clock") || l.contains("diff(q)"))
                .map(|l| l.trim().to_string()),
        );
        let width = self.joints.iter().map(|j| j.name.chars().count()).max().unwrap_or(0).clamp(5, 20);
        lines.push(format!(
            "{:<width$} {:>17} {:>15} {:>10}  {}",
            "joint", "q rad (m)", "degrees", "max |tau|", "diff(q)/dq"
        ));
        lines.extend(self.joints.iter().map(|j| j.line(width)));
        Section::table(self.name.clone(), lines)
    }
}

impl JointRange {
    fn line(&self, width: usize) -> String {
        let range = |r: [f64; 2], digits: usize| format!("{:.digits$}..{:.digits$}", r[0], r[1]);
        let name: String = self.name.chars().take(width).collect();
        format!(
            "{name:<width$} {:>17} {:>15} {:>10}  {:<6}{}",
            range(self.position, 3),
            self.degrees.map_or("-".into(), |d| range(d, 0)),
            self.torque.map_or("-".into(), |t| number(t, 4)),
            self.velocity_slope.map_or("-".into(), |s| number(s, 3)),
            if self.beyond_limits { " limits!" } else { "" }
        )
    }
}

fn quantities(log: &Log) -> Vec<&'static str> {
    let there = [
        ("t", !log.t.is_empty()),
        ("q", !log.q.is_empty()),
        ("dq", log.dq.is_some()),
        ("ddq", log.ddq.is_some()),
        ("tau", !log.tau.is_empty()),
    ];
    there.into_iter().filter(|(_, there)| *there).map(|(name, _)| name).collect()
}

fn ranges(log: &Log, robot: &Robot) -> Vec<JointRange> {
    let extent = |c: &Vec<f64>| {
        c.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], x| [low.min(*x), high.max(*x)])
    };
    let slopes = velocity_slopes(log, robot);
    let one = |(j, q): (usize, &Vec<f64>)| {
        let joint = &robot.joints[j];
        let position = extent(q);
        let slack = 0.01 * (position[1] - position[0]).abs();
        let turns = joint.kind == JointKind::Revolute;
        JointRange {
            name: joint.name.clone(),
            position,
            degrees: turns.then(|| position.map(f64::to_degrees)),
            torque: log.tau.get(j).map(|c| c.iter().fold(0.0_f64, |m, x| m.max(x.abs()))),
            velocity_slope: slopes[j],
            beyond_limits: joint.limits.lower.is_some_and(|l| position[0] < l - slack)
                || joint.limits.upper.is_some_and(|u| position[1] > u + slack),
        }
    };
    log.q.iter().enumerate().map(one).collect()
}

/// Reads a log, with a stand-in of as many turning joints as its header names where no robot is known.
pub(super) fn open(path: &Path, robot: Option<&Robot>, map: Option<&ColumnMap>) -> Result<(Log, Robot)> {
    let robot = match robot {
        Some(robot) => robot.clone(),
        None => stand_in(path, map)?,
    };
    Ok((Log::open_without_torque(path, &robot, map)?, robot))
}

fn stand_in(path: &Path, map: Option<&ColumnMap>) -> Result<Robot> {
    let head = super::kind::head(path)?;
    let text = String::from_utf8_lossy(&head);
    let delimiter = map.map_or(',', |m| m.delimiter);
    let fields: Vec<&str> = text.lines().next().unwrap_or_default().split(delimiter).map(str::trim).collect();
    let names = match map.and_then(|m| m.position.as_ref()).map(|p| &p.columns) {
        Some(Columns::List(list)) => (1..=list.len()).map(|j| format!("joint{j}")).collect(),
        Some(Columns::Pattern(pattern)) => numbered(&fields, pattern),
        None => named(&fields),
    };
    Ok(names
        .into_iter()
        .fold(samples::Builder::new("unknown"), |builder, name: String| {
            let (base, axis) = (Pose::identity(), nalgebra::Vector3::z());
            builder.joint(&name, JointKind::Revolute, None, base, axis, InertialParameters::ZERO)
        })
        .build())
}

/// Joints of the columns that follow a pattern.
fn numbered(fields: &[&str], pattern: &str) -> Vec<String> {
    let column = |j: usize| pattern.replace("{0}", &j.to_string()).replace("{1}", &(j + 1).to_string());
    (0..)
        .take_while(|&j| j < 256 && fields.contains(&column(j).as_str()))
        .map(|j| format!("joint{}", j + 1))
        .collect()
}

/// Joints of the columns `q1`, `q2`, .. or `q_shoulder`, ..
fn named(fields: &[&str]) -> Vec<String> {
    let count = (1..=256).take_while(|j| fields.contains(&format!("q{j}").as_str())).count();
    if count > 0 {
        return (1..=count).map(|j| format!("joint{j}")).collect();
    }
    let own = fields.iter().filter_map(|f| f.strip_prefix("q_")).map(str::to_string).collect::<Vec<_>>();
    if own.is_empty() { vec!["joint1".into()] } else { own }
}
