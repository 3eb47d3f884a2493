//! Which column of a file is which quantity of which joint.

use std::collections::BTreeMap;
use std::f64::consts::{PI, TAU};

use super::columns::{
    AngleUnit, ColumnId, ColumnMap, Columns, LengthUnit, Motion, Others, Time, TimeUnit, Torque, TorqueUnit,
};
use super::header::Header;
use super::table::Wanted;
use super::{Needs, table::Table};
use crate::error::{Error, Part, Result};
use crate::robot::{JointKind, Robot};
use crate::text::names::{list, shorten};

/// A column on its way to us: `value = column * factor / divisor + offset`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Feed {
    /// Which of the wanted columns.
    column: usize,
    factor: f64,
    divisor: f64,
    offset: f64,
}

impl Feed {
    /// The converted column, taken out of the table.
    pub(super) fn take(&self, table: &mut Table) -> Vec<f64> {
        let mut values = std::mem::take(&mut table.columns[self.column]);
        self.convert(&mut values);
        values
    }

    /// The converted column; the table keeps its own.
    pub(super) fn copy(&self, table: &Table) -> Vec<f64> {
        let mut values = table.columns[self.column].clone();
        self.convert(&mut values);
        values
    }

    fn convert(&self, values: &mut [f64]) {
        // Untouched where nothing is to be done, so that not even the sign of a zero changes.
        if [self.factor, self.divisor, self.offset].map(f64::to_bits) == [1.0, 1.0, 0.0].map(f64::to_bits) {
            return;
        }
        for value in values {
            *value = *value * self.factor / self.divisor + self.offset;
        }
    }
}

/// Where time comes from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Clock {
    Stamps(Feed),
    Rate(f64),
    None,
}

/// Everything that a log is made of.
#[derive(Debug)]
pub(super) struct Layout {
    pub time: Clock,
    pub q: Vec<Feed>,
    pub dq: Option<Vec<Feed>>,
    pub ddq: Option<Vec<Feed>>,
    pub tau: Option<Vec<Feed>>,
    /// Whether the torques come from currents, which stay as channels.
    pub tau_from_current: bool,
    /// Index among the wanted columns, by channel name.
    pub channels: BTreeMap<String, usize>,
    pub named_joints: bool,
    pub wanted: Vec<Wanted>,
    /// Columns of the file that were passed over, with the reason.
    pub ignored: BTreeMap<String, String>,
}

/// Finds the columns of a log.
pub(super) fn of_log(header: &Header, robot: &Robot, map: &ColumnMap, needs: Needs) -> Result<Layout> {
    let mut finder = Finder::new(header, robot);
    let time = finder.time(map.time.as_ref(), needs.time)?;
    let (q, named_joints) = finder.motion("q", map.position.as_ref(), true)?;
    let (dq, _) = finder.motion("dq", map.velocity.as_ref(), needs.rates)?;
    let (ddq, _) = finder.motion("ddq", map.acceleration.as_ref(), needs.rates)?;
    let (tau, currents) = finder.torque(map.torque.as_ref(), needs.torque)?;
    let mut channels = finder.mapped_channels(&map.channels)?;
    for (j, current) in currents.iter().enumerate() {
        let taken = channels.insert(format!("current{}", j + 1), *current).is_some();
        if taken || header.find(&format!("current{}", j + 1)).is_some_and(|i| !finder.is_used(i)) {
            return Err(header.error(format!("two columns would be the channel `current{}`", j + 1)));
        }
    }
    let mut ignored = BTreeMap::new();
    if map.other_columns == Others::Keep {
        finder.other_channels(&mut channels, &mut ignored);
    }
    let tau_from_current = !currents.is_empty();
    let q = q.unwrap_or_default();
    let wanted = finder.wanted;
    Ok(Layout { time, q, dq, ddq, tau, tau_from_current, channels, named_joints, wanted, ignored })
}

/// Collects the wanted columns of one header.
pub(super) struct Finder<'a> {
    header: &'a Header,
    robot: &'a Robot,
    pub wanted: Vec<Wanted>,
}

impl<'a> Finder<'a> {
    pub(super) fn new(header: &'a Header, robot: &'a Robot) -> Self {
        Self { header, robot, wanted: Vec::new() }
    }

    fn is_used(&self, field: usize) -> bool {
        self.wanted.iter().any(|w| w.field == field)
    }

    /// Wants a column of the file; answers its place among the wanted ones.
    pub(super) fn want(&mut self, field: usize, needed: bool) -> Result<usize> {
        if self.is_used(field) {
            let name = shorten(&self.header.names[field]);
            return Err(Error::new(format!("column `{name}` is used twice"))
                .at(self.header.line, field + 1)
                .help("name every column once in the column map"));
        }
        self.wanted.push(Wanted { field, needed });
        Ok(self.wanted.len() - 1)
    }

    fn time(&mut self, time: Option<&Time>, needed: bool) -> Result<Clock> {
        let (field, divisor) = match time {
            Some(Time::Rate { rate_hz }) => return Ok(Clock::Rate(*rate_hz)),
            Some(Time::Column { column, unit }) => (self.field(column)?, ticks_per_second(*unit)),
            None => match self.header.find("t") {
                Some(field) => (field, 1.0),
                None if needed => return Err(self.header.missing("t")),
                None => return Ok(Clock::None),
            },
        };
        let column = self.want(field, true)?;
        Ok(Clock::Stamps(Feed { column, factor: 1.0, divisor, offset: 0.0 }))
    }

    /// The columns of a joint motion, and whether they name the joints.
    fn motion(
        &mut self,
        prefix: &str,
        map: Option<&Motion>,
        needed: bool,
    ) -> Result<(Option<Vec<Feed>>, bool)> {
        let Some(map) = map else { return self.standard(prefix, needed) };
        let n = self.robot.dof();
        let columns = self.columns(prefix, &map.columns)?;
        let signs = per_joint(self.header, n, prefix, "sign", map.sign.as_deref(), 1.0)?;
        let offsets = per_joint(self.header, n, prefix, "offset", map.offset.as_deref(), 0.0)?;
        check_signs(self.header, prefix, &signs)?;
        let feed = |(j, column): (usize, usize)| {
            let (factor, divisor) = match self.robot.joints[j].kind {
                JointKind::Revolute => radians(map.unit),
                JointKind::Prismatic => meters(map.linear_unit),
            };
            Feed { column, factor: signs[j] * factor, divisor, offset: offsets[j] }
        };
        Ok((Some(columns.into_iter().enumerate().map(feed).collect()), false))
    }

    /// The torque columns, and those of them that are currents.
    fn torque(&mut self, map: Option<&Torque>, needed: bool) -> Result<(Option<Vec<Feed>>, Vec<usize>)> {
        let n = self.robot.dof();
        match map {
            None => Ok((self.standard("tau", needed)?.0, Vec::new())),
            Some(Torque::Measured { columns, unit, sign }) => {
                let columns = self.columns("tau", columns)?;
                let signs = per_joint(self.header, n, "torque", "sign", sign.as_deref(), 1.0)?;
                check_signs(self.header, "torque", &signs)?;
                let divisor = if *unit == TorqueUnit::MillinewtonMeters { 1e3 } else { 1.0 };
                let feed = |(column, factor)| Feed { column, factor, divisor, offset: 0.0 };
                Ok((Some(columns.into_iter().zip(signs).map(feed).collect()), Vec::new()))
            }
            Some(Torque::Current { current, gains }) => {
                let columns = self.columns("current", current)?;
                let gains = per_joint(self.header, n, "torque", "gains", Some(gains), 1.0)?;
                let feed = |(&column, factor)| Feed { column, factor, divisor: 1.0, offset: 0.0 };
                Ok((Some(columns.iter().zip(gains).map(feed).collect()), columns))
            }
        }
    }

    /// Columns under our own names: `q1` or `q_<joint>`. All joints or none.
    pub(super) fn standard(&mut self, prefix: &str, needed: bool) -> Result<(Option<Vec<Feed>>, bool)> {
        let n = self.robot.dof();
        check_numbers(self.header, prefix, self.robot)?;
        let mut found = Vec::with_capacity(n);
        let (mut missing, mut by_name) = (Vec::new(), 0);
        for (j, joint) in self.robot.joints.iter().enumerate() {
            let number = format!("{prefix}{}", j + 1);
            let name = format!("{prefix}_{}", joint.name);
            match (self.header.find(&number), self.header.find(&name)) {
                (Some(field), None) => found.push(field),
                (None, Some(field)) => {
                    by_name += 1;
                    found.push(field);
                }
                (Some(_), Some(_)) => {
                    let what = format!("`{number}` and `{name}` are the same joint");
                    return Err(self.header.error(what).help("keep one of them"));
                }
                (None, None) => missing.push(number),
            }
        }
        if found.is_empty() && !needed {
            return Ok((None, false));
        }
        if let Some(first) = missing.first() {
            let e = self.header.missing(first);
            return Err(match missing.len() {
                1 => e,
                k if k == n => e,
                _ => self
                    .header
                    .error(format!(
                        "there is no column {}; `{prefix}` needs all {n} joints of the robot `{}` or none",
                        list(missing.iter().map(String::as_str)),
                        self.robot.name
                    ))
                    .help("add these columns, or remove the others of their kind"),
            });
        }
        let mut feeds = Vec::with_capacity(n);
        for field in found {
            feeds.push(Feed { column: self.want(field, true)?, factor: 1.0, divisor: 1.0, offset: 0.0 });
        }
        Ok((Some(feeds), n > 0 && by_name == n))
    }

    /// The wanted columns that a map names, one per joint.
    fn columns(&mut self, quantity: &str, columns: &Columns) -> Result<Vec<usize>> {
        let ids = match columns {
            Columns::List(list) => list.clone(),
            Columns::Pattern(pattern) => {
                let n = self.robot.dof();
                (0..n).map(|j| ColumnId::Name(expand(pattern, j, self.robot))).collect()
            }
        };
        if ids.len() != self.robot.dof() {
            let what = format!(
                "the column map gives {} columns for `{quantity}`, the robot `{}` has {} joints",
                ids.len(),
                self.robot.name,
                self.robot.dof()
            );
            return Err(self.header.error(what).help("list one column per joint, in the robot's order"));
        }
        let fields = ids.iter().map(|id| self.field(id)).collect::<Result<Vec<_>>>()?;
        fields.into_iter().map(|field| self.want(field, true)).collect()
    }

    fn field(&self, id: &ColumnId) -> Result<usize> {
        match id {
            ColumnId::Name(name) => self.header.find(name).ok_or_else(|| self.header.missing(name)),
            ColumnId::Number(number) if *number <= self.header.names.len() => Ok(number - 1),
            ColumnId::Number(number) => Err(self.header.missing(&number.to_string())),
        }
    }

    /// Channels that a map renames; patterns go through the joints.
    fn mapped_channels(&mut self, map: &BTreeMap<String, ColumnId>) -> Result<BTreeMap<String, usize>> {
        let mut channels = BTreeMap::new();
        for (ours, theirs) in map {
            let joints = if expand(ours, 0, self.robot) == *ours { 1 } else { self.robot.dof() };
            for j in 0..joints {
                let id = match theirs {
                    ColumnId::Name(name) if joints > 1 => ColumnId::Name(expand(name, j, self.robot)),
                    other => other.clone(),
                };
                let column = self.field(&id).and_then(|field| self.want(field, false))?;
                let name = if joints > 1 { expand(ours, j, self.robot) } else { ours.clone() };
                if channels.insert(name.clone(), column).is_some() {
                    return Err(self.header.error(format!("two columns would be the channel `{name}`")));
                }
            }
        }
        Ok(channels)
    }

    /// Everything else: channels under their own names, but for columns without one.
    fn other_channels(
        &mut self,
        channels: &mut BTreeMap<String, usize>,
        ignored: &mut BTreeMap<String, String>,
    ) {
        let mut used = vec![false; self.header.names.len()];
        self.wanted.iter().for_each(|w| used[w.field] = true);
        for (field, name) in self.header.names.iter().enumerate().filter(|(field, _)| !used[*field]) {
            if name.is_empty() {
                ignored.insert(format!("column {}", field + 1), "it has no name".to_owned());
            } else if channels.contains_key(name) {
                ignored.insert(name.clone(), "the column map gives its name to another column".to_owned());
            } else {
                channels.insert(name.clone(), self.wanted.len());
                self.wanted.push(Wanted { field, needed: false });
            }
        }
    }
}

/// Refuses joint numbers that the robot does not have: the log is of another robot, or counts from zero.
fn check_numbers(header: &Header, prefix: &str, robot: &Robot) -> Result<()> {
    let n = robot.dof();
    let number = |name: &String| -> Option<usize> {
        let digits = name.strip_prefix(prefix)?;
        let plain = digits.bytes().all(|b| b.is_ascii_digit()) && (digits == "0" || !digits.starts_with('0'));
        digits.parse().ok().filter(|_| plain)
    };
    let numbers: Vec<usize> = header.names.iter().filter_map(number).collect();
    let (Some(&least), Some(&most)) = (numbers.iter().min(), numbers.iter().max()) else { return Ok(()) };
    if least == 0 {
        return Err(header.error(format!("`{prefix}0`: joints are numbered from 1")).help(format!(
            "number the columns {prefix}1..{prefix}{n}, or map them with `columns: \"{prefix}{{0}}\"`"
        )));
    }
    // A gap in the numbers, or a quantity with fewer joints than `q`, is a missing column and said elsewhere.
    if most > n || (most < n && numbers.len() == most && prefix == "q") {
        let what = format!(
            "the log has columns {prefix}{least} to {prefix}{most}: {most} joints; the robot `{}` has {n}",
            robot.name
        );
        return Err(header
            .error(what)
            .help("use the log's own robot, or map the columns of its joints with a column map")
            .of_part(Part::Columns));
    }
    Ok(())
}

fn expand(pattern: &str, joint: usize, robot: &Robot) -> String {
    let name = robot.joints.get(joint).map_or("", |j| j.name.as_str());
    let numbered = pattern.replace("{0}", &joint.to_string()).replace("{1}", &(joint + 1).to_string());
    numbered.replace("{name}", name)
}

/// A list of the map with one finite number per joint.
fn per_joint(
    header: &Header,
    joints: usize,
    quantity: &str,
    field: &str,
    given: Option<&[f64]>,
    default: f64,
) -> Result<Vec<f64>> {
    let Some(given) = given else { return Ok(vec![default; joints]) };
    if given.len() == joints && given.iter().all(|x| x.is_finite()) {
        return Ok(given.to_vec());
    }
    let what = format!(
        "the column map gives {} numbers as `{field}` of `{quantity}`; {joints} finite ones are needed",
        given.len()
    );
    Err(header.error(what).help("give one number per joint, in the robot's order"))
}

fn check_signs(header: &Header, quantity: &str, signs: &[f64]) -> Result<()> {
    match signs.iter().find(|s| s.abs().to_bits() != 1.0_f64.to_bits()) {
        None => Ok(()),
        Some(sign) => Err(header
            .error(format!("`{sign}` in the column map is no sign of `{quantity}`"))
            .help("signs are 1 or -1; scale with `unit` or `gains`")),
    }
}

fn ticks_per_second(unit: TimeUnit) -> f64 {
    match unit {
        TimeUnit::Seconds => 1.0,
        TimeUnit::Milliseconds => 1e3,
        TimeUnit::Microseconds => 1e6,
        TimeUnit::Nanoseconds => 1e9,
    }
}

fn radians(unit: AngleUnit) -> (f64, f64) {
    match unit {
        AngleUnit::Radians => (1.0, 1.0),
        AngleUnit::Degrees => (PI, 180.0),
        AngleUnit::Revolutions => (TAU, 1.0),
    }
}

fn meters(unit: LengthUnit) -> (f64, f64) {
    match unit {
        LengthUnit::Meters => (1.0, 1.0),
        LengthUnit::Millimeters => (1.0, 1e3),
    }
}
