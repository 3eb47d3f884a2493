//! What is in a log: its columns, what they are taken for, and what is wrong with it.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;

use super::study::{Column, Seen};
use crate::check;
use crate::error::{Error, Result};
use crate::log::{
    AngleUnit, ColumnId, ColumnMap, Columns, LengthUnit, Log, Motion, Time, TimeUnit, Torque, TorqueUnit,
};
use crate::robot::{JointKind, Robot};
use crate::signals::{Settings, thinned};

/// Bytes of a log that are looked at for its header.
const HEAD: u64 = 1 << 16;
/// Rows that are shown.
const SAMPLE: usize = 3;
/// Columns that are listed at most.
const MOST_COLUMNS: usize = 512;
/// Joints that a log may name where no robot is known.
const MOST_JOINTS: usize = 64;

/// Reads a log as `name`, with what there is to say of it; the error stands in what is said. A very long one comes
/// thinned.
pub(super) fn look(
    path: &Path,
    name: &str,
    robot: Option<&Robot>,
    map: Option<&ColumnMap>,
    settings: &Settings,
) -> (Seen, Option<Log>) {
    let mut seen = Seen::default();
    let header = match top(path, map) {
        Ok(mut rows) => {
            let named = map.is_none_or(|m| m.header);
            let width = rows.first().map_or(0, Vec::len).min(MOST_COLUMNS);
            let header = if named && !rows.is_empty() {
                rows.remove(0)
            } else {
                (1..=width).map(|k| format!("column{k}")).collect()
            };
            seen.sample = rows;
            header
        }
        Err(error) => {
            seen.problem = Some(error);
            return (seen, None);
        }
    };
    let log = robot.map(|robot| Log::open(path, robot, map));
    let log = log.map(|log| log.map(|log| Log { name: name.to_string(), ..log }));
    let log = log.transpose().unwrap_or_else(|error| {
        seen.problem = Some(error);
        None
    });
    seen.columns = columns(&header, robot, map, log.as_ref());
    if robot.is_none() && map.is_none() {
        without_robot(path, &mut seen);
    }
    if let Some(log) = &log {
        describe(log, &mut seen);
    }
    // What cannot be thinned cannot be fitted: the fit says why.
    let log = log.and_then(|log| thinned(log, settings).ok());
    if let Some(thinned) = log.as_ref().and_then(|log| log.thinned.as_ref()) {
        let (from, to) = (1.0 / thinned.period_s, 1.0 / (thinned.period_s * thinned.every as f64));
        seen.remarks
            .push(format!("very long: fitted and searched at {to:.0} Hz of {from:.0} Hz, after a low-pass"));
    }
    (seen, log)
}

/// What a log says by itself.
fn without_robot(path: &Path, seen: &mut Seen) {
    let report = check::file(path, &check::Options::default());
    seen.problem = report.unusable().cloned();
    let Some(facts) = report.logs.first() else { return };
    (seen.rows, seen.seconds, seen.rate_hz) = (facts.rows, facts.duration_s, facts.rate_hz);
    seen.dropped.clone_from(&facts.left_out);
}

fn describe(log: &Log, seen: &mut Seen) {
    seen.rows = log.rows();
    seen.seconds = log.t.last().zip(log.t.first()).map_or(0.0, |(end, start)| end - start);
    seen.rate_hz = (seen.seconds > 0.0).then(|| (seen.rows.max(1) - 1) as f64 / seen.seconds);
    seen.dropped = log.dropped.iter().map(|(why, d)| (why.clone(), d.rows)).collect();
    let line = |(why, d): (&String, &crate::log::Dropped)| {
        format!("{} rows left out: {why} (the first in line {})", d.rows, d.first_line)
    };
    seen.remarks = log.dropped.iter().map(line).collect();
    if log.dq.is_none() {
        seen.remarks.push("no velocities were logged: they are taken from the positions".to_string());
    }
    if log.q.iter().flatten().any(|q| q.abs() > 7.0) {
        seen.remarks.push("positions beyond 7 rad: are they in degrees?".to_string());
    }
}

/// The first rows as fields.
fn top(path: &Path, map: Option<&ColumnMap>) -> Result<Vec<Vec<String>>> {
    let trouble = |e: std::io::Error| Error::new(format!("cannot read the file: {e}"));
    let mut head = Vec::new();
    File::open(path).and_then(|f| f.take(HEAD).read_to_end(&mut head)).map_err(trouble)?;
    if head.starts_with(&[0x1F, 0x8B]) {
        let mut unpacked = Vec::new();
        // A head that is cut off ends in an error; what came before it is all that is wanted.
        let _ = MultiGzDecoder::new(head.as_slice()).take(HEAD).read_to_end(&mut unpacked);
        head = unpacked;
    }
    let delimiter = map.map_or(',', |m| m.delimiter);
    let text = String::from_utf8_lossy(&head);
    let fields = |line: &str| -> Vec<String> {
        let short = |field: &str| field.trim().trim_matches('"').chars().take(80).collect();
        match delimiter {
            ' ' => line.split_whitespace().take(MOST_COLUMNS).map(short).collect(),
            d => line.split(d).take(MOST_COLUMNS).map(short).collect(),
        }
    };
    Ok(text.trim_start_matches('\u{feff}').lines().take(1 + SAMPLE).map(fields).collect())
}

/// A quantity with what the map says of it.
struct Quantity<'a> {
    prefix: &'static str,
    meaning: &'static str,
    columns: Option<&'a Columns>,
    unit: String,
    linear_unit: String,
}

fn columns(
    header: &[String],
    robot: Option<&Robot>,
    map: Option<&ColumnMap>,
    log: Option<&Log>,
) -> Vec<Column> {
    let mut all: Vec<Column> = header
        .iter()
        .take(MOST_COLUMNS)
        .enumerate()
        .map(|(k, name)| Column {
            number: k + 1,
            header: name.clone(),
            meaning: meaning_of_rest(name, robot, log),
            joint: None,
            unit: String::new(),
        })
        .collect();
    for quantity in quantities(map) {
        let names: Vec<String> = match robot {
            Some(robot) => robot.joints.iter().map(|j| j.name.clone()).collect(),
            None => (1..=MOST_JOINTS).map(|k| format!("joint{k}")).collect(),
        };
        for (joint, name) in names.iter().enumerate() {
            let Some(place) = place(header, &quantity, joint, name) else { continue };
            let linear = robot.is_some_and(|r| r.joints[joint].kind == JointKind::Prismatic);
            let unit = if linear { quantity.linear_unit.clone() } else { quantity.unit.clone() };
            let column = &mut all[place];
            (column.meaning, column.joint, column.unit) = (quantity.meaning, Some(name.clone()), unit);
        }
    }
    let (time, unit) = time(map);
    if let Some(place) = time.and_then(|id| find(header, &id)) {
        (all[place].meaning, all[place].unit) = ("time", unit.to_string());
    }
    all
}

/// What a column is that no quantity took.
fn meaning_of_rest(name: &str, robot: Option<&Robot>, log: Option<&Log>) -> &'static str {
    match (log, robot) {
        (Some(log), _) if log.channels.contains_key(name) => "channel",
        (Some(_), _) => "not read",
        (None, Some(_)) => "channel",
        (None, None) => "unknown",
    }
}

fn quantities(map: Option<&ColumnMap>) -> [Quantity<'_>; 4] {
    let motion = |prefix, meaning, per: &str, given: Option<&'_ Motion>| {
        let (unit, linear) =
            given.map_or((Default::default(), Default::default()), |m| (m.unit, m.linear_unit));
        let units = (format!("{}{per}", angle(unit)), format!("{}{per}", length(linear)));
        (prefix, meaning, units)
    };
    let (q, dq, ddq) = match map {
        Some(m) => (m.position.as_ref(), m.velocity.as_ref(), m.acceleration.as_ref()),
        None => (None, None, None),
    };
    let rows = [
        (motion("q", "position", "", q), q.map(|m| &m.columns)),
        (motion("dq", "velocity", "/s", dq), dq.map(|m| &m.columns)),
        (motion("ddq", "acceleration", "/s²", ddq), ddq.map(|m| &m.columns)),
        (("tau", "torque", torque_units(map)), torque_columns(map)),
    ];
    rows.map(|((prefix, meaning, (unit, linear_unit)), columns)| Quantity {
        prefix,
        meaning,
        columns,
        unit,
        linear_unit,
    })
}

fn torque_columns(map: Option<&ColumnMap>) -> Option<&Columns> {
    map.and_then(|m| m.torque.as_ref()).map(|torque| match torque {
        Torque::Measured { columns, .. } => columns,
        Torque::Current { current, .. } => current,
    })
}

fn torque_units(map: Option<&ColumnMap>) -> (String, String) {
    let (unit, linear) = match map.and_then(|m| m.torque.as_ref()) {
        Some(Torque::Current { .. }) => ("A", "A"),
        Some(Torque::Measured { unit: TorqueUnit::MillinewtonMeters, .. }) => ("mN m", "mN"),
        _ => ("N m", "N"),
    };
    (unit.to_string(), linear.to_string())
}

fn angle(unit: AngleUnit) -> &'static str {
    match unit {
        AngleUnit::Radians => "rad",
        AngleUnit::Degrees => "deg",
        AngleUnit::Revolutions => "rev",
    }
}

fn length(unit: LengthUnit) -> &'static str {
    match unit {
        LengthUnit::Meters => "m",
        LengthUnit::Millimeters => "mm",
    }
}

fn time(map: Option<&ColumnMap>) -> (Option<ColumnId>, &'static str) {
    match map.and_then(|m| m.time.as_ref()) {
        Some(Time::Column { column, unit }) => {
            let unit = match unit {
                TimeUnit::Seconds => "s",
                TimeUnit::Milliseconds => "ms",
                TimeUnit::Microseconds => "µs",
                TimeUnit::Nanoseconds => "ns",
            };
            (Some(column.clone()), unit)
        }
        Some(Time::Rate { .. }) => (None, ""),
        None => (Some(ColumnId::Name("t".to_string())), "s"),
    }
}

/// Which column of the header is a quantity of a joint.
fn place(header: &[String], quantity: &Quantity<'_>, joint: usize, name: &str) -> Option<usize> {
    match quantity.columns {
        Some(Columns::List(list)) => find(header, list.get(joint)?),
        Some(Columns::Pattern(pattern)) => {
            let wanted = pattern
                .replace("{0}", &joint.to_string())
                .replace("{1}", &(joint + 1).to_string())
                .replace("{name}", name);
            header.iter().position(|h| *h == wanted)
        }
        None => {
            let (numbered, named) =
                (format!("{}{}", quantity.prefix, joint + 1), format!("{}_{name}", quantity.prefix));
            header.iter().position(|h| *h == numbered || *h == named)
        }
    }
}

fn find(header: &[String], id: &ColumnId) -> Option<usize> {
    match id {
        ColumnId::Name(name) => header.iter().position(|h| h == name),
        ColumnId::Number(number) => number.checked_sub(1).filter(|k| *k < header.len()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn names(text: &str) -> Vec<String> {
        text.split(',').map(str::to_string).collect()
    }

    #[test]
    fn columns_are_told_by_our_names_or_by_the_map() -> Result<()> {
        let robot = Robot::open("robots/two_link.ron")?;
        let seen = columns(&names("t,q1,q2,tau1,tau2,temperature1"), Some(&robot), None, None);
        let told: Vec<(&str, &str)> = seen.iter().map(|c| (c.meaning, c.unit.as_str())).collect();
        let expected = [("time", "s"), ("position", "rad"), ("position", "rad"), ("torque", "N m")];
        assert_eq!(told[..4], expected);
        assert_eq!((seen[2].joint.as_deref(), told[5].0), (Some("joint2"), "channel"));
        let map = ColumnMap::parse(
            r#"(time: (column: "ms", unit: Milliseconds), position: (columns: "a{0}", unit: Degrees),
                torque: (current: [4, "i"], gains: [1.0, 2.0]))"#,
        )?;
        let seen = columns(&names("ms,a0,a1,x,i"), Some(&robot), Some(&map), None);
        let told: Vec<(&str, &str)> = seen.iter().map(|c| (c.meaning, c.unit.as_str())).collect();
        let expected =
            [("time", "ms"), ("position", "deg"), ("position", "deg"), ("torque", "A"), ("torque", "A")];
        assert_eq!(told, expected);
        Ok(())
    }
}
