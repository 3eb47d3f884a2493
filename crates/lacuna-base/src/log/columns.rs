//! Column maps: how the columns of a foreign log become ours, written in RON.

use std::collections::BTreeMap;
use std::fmt;
use std::path::Path;

use serde::de::{self, Deserializer, SeqAccess, Visitor};
use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::text;
use crate::text::bounds::Hertz;

/// The maps that ship with the program, by name.
const READY: [(&str, &str); 3] = [
    ("libfranka", include_str!("../../../../columns/libfranka.ron")),
    ("ur_rtde", include_str!("../../../../columns/ur_rtde.ron")),
    ("ur_rtde_torque", include_str!("../../../../columns/ur_rtde_torque.ron")),
];

/// How foreign columns become ours. Quantities that the map does not name are looked up under our own
/// names (`t`, `q1`, `tau1`, ...), so a map may be as short as `(delimiter: ';')`.
///
/// ```
/// let map = lacuna_base::log::ColumnMap::parse(
///     r#"(
///         time: (column: "stamp_ms", unit: Milliseconds),
///         position: (columns: "angle_{1}", unit: Degrees, sign: [1, -1]),
///         torque: (current: ["i_shoulder", "i_elbow"], gains: [11.0, 9.5]),
///     )"#,
/// )?;
/// assert_eq!(map.delimiter, ',');
/// # Ok::<(), lacuna_base::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ColumnMap {
    /// Between two fields, an ASCII character; `' '` stands for any run of blanks and tabs.
    #[serde(deserialize_with = "delimiter")]
    pub delimiter: char,
    /// Whether the first line names the columns; without one, columns are called by number from 1.
    pub header: bool,
    /// Whether numbers are written with a decimal comma.
    pub decimal_comma: bool,
    /// Time stamps, or the sampling rate where there are none.
    pub time: Option<Time>,
    /// Joint positions.
    pub position: Option<Motion>,
    /// Joint velocities; units are those of a position, per second.
    pub velocity: Option<Motion>,
    /// Joint accelerations; units are those of a position, per second squared.
    pub acceleration: Option<Motion>,
    /// Joint torques, measured or from motor currents.
    pub torque: Option<Torque>,
    /// Channels under new names: ours to theirs. `{0}`, `{1}` and `{name}` on both sides go through the joints.
    pub channels: BTreeMap<String, ColumnId>,
    /// What becomes of columns that nothing above names.
    pub other_columns: Others,
}

impl Default for ColumnMap {
    fn default() -> Self {
        Self {
            delimiter: ',',
            header: true,
            decimal_comma: false,
            time: None,
            position: None,
            velocity: None,
            acceleration: None,
            torque: None,
            channels: BTreeMap::new(),
            other_columns: Others::Keep,
        }
    }
}

impl ColumnMap {
    /// Reads a map from a file, or takes the ready map of that name (`ur_rtde`, `ur_rtde_torque`, `libfranka`)
    /// where no such file exists.
    ///
    /// # Errors
    /// When the file cannot be read or is not a column map; with file, line and column.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let ready = READY.iter().find(|(name, _)| path.as_os_str() == *name && !path.exists());
        if let Some((_, text)) = ready {
            return Self::parse(text).map_err(|e| e.in_file(path));
        }
        let name = path.display().to_string();
        let ready = format!("name a file, or a ready map; {}", text::suggestion(&name, Self::ready()));
        let text = text::read(path).map_err(|e| if path.exists() { e } else { e.help(ready) })?;
        Self::parse(&text).map_err(|e| e.in_file(path))
    }

    /// Names of the ready maps.
    pub fn ready() -> impl Iterator<Item = &'static str> {
        READY.iter().map(|(name, _)| *name)
    }

    /// Reads a map from RON text.
    ///
    /// # Errors
    /// When the text is not a column map; the error has line and column but no file name.
    pub fn parse(text: &str) -> Result<Self> {
        text::from_ron(text).map_err(|e| {
            e.or_help(
                "a column map may hold delimiter, header, decimal_comma, time, position, velocity, \
                 acceleration, torque, channels, other_columns",
            )
        })
    }
}

/// A column of a foreign file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum ColumnId {
    /// By its header.
    Name(String),
    /// By its number, from 1.
    Number(usize),
}

/// One column for each joint, in the robot's order.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(untagged)]
pub enum Columns {
    /// A header with `{0}` (joint number from zero), `{1}` (from one) or `{name}` (joint name).
    Pattern(String),
    /// Every column by itself.
    List(Vec<ColumnId>),
}

/// Where time comes from.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawTime", untagged)]
pub enum Time {
    /// Stamps in a column.
    Column {
        /// Which.
        column: ColumnId,
        /// Its unit.
        unit: TimeUnit,
    },
    /// No stamps: rows follow each other at a fixed rate, bad rows counted.
    Rate {
        /// Rows per second.
        rate_hz: f64,
    },
}

/// Joint positions, velocities or accelerations: `value = sign * unit * column + offset`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Motion {
    /// Where they stand.
    pub columns: Columns,
    /// Unit of the revolute joints.
    #[serde(default)]
    pub unit: AngleUnit,
    /// Unit of the prismatic joints.
    #[serde(default)]
    pub linear_unit: LengthUnit,
    /// 1 or -1 for each joint. A turned axis needs its sign in position, velocity, acceleration and torque.
    pub sign: Option<Vec<f64>>,
    /// Added to each joint, in SI units.
    pub offset: Option<Vec<f64>>,
}

/// Joint torques.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "RawTorque", untagged)]
pub enum Torque {
    /// Measured or commanded torque: `tau = sign * unit * column`.
    Measured {
        /// Where it stands.
        columns: Columns,
        /// Its unit.
        unit: TorqueUnit,
        /// 1 or -1 for each joint.
        sign: Option<Vec<f64>>,
    },
    /// Motor current: `tau = gain * current`. The currents stay as channels `current1`, `current2`, ...
    /// in amperes.
    Current {
        /// Where the currents stand, in amperes.
        current: Columns,
        /// Torque at the joint per current [N m/A, N/A], signs included.
        gains: Vec<f64>,
    },
}

/// Unit of time stamps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub enum TimeUnit {
    #[default]
    Seconds,
    Milliseconds,
    Microseconds,
    Nanoseconds,
}

/// Unit of revolute joints (per second for velocities, per second squared for accelerations).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub enum AngleUnit {
    #[default]
    Radians,
    Degrees,
    Revolutions,
}

/// Unit of prismatic joints (per second for velocities, per second squared for accelerations).
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub enum LengthUnit {
    #[default]
    Meters,
    Millimeters,
}

/// Unit of torques, and of forces with the length left out.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
#[allow(missing_docs, reason = "the names say it")]
pub enum TorqueUnit {
    #[default]
    NewtonMeters,
    MillinewtonMeters,
}

/// What becomes of columns that a map does not name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Others {
    /// They are channels under their own names.
    #[default]
    Keep,
    /// They are not read.
    Ignore,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Time")]
struct RawTime {
    column: Option<ColumnId>,
    #[serde(default)]
    unit: TimeUnit,
    #[serde(default, deserialize_with = "Hertz::read")]
    rate_hz: Option<f64>,
}

impl TryFrom<RawTime> for Time {
    type Error = &'static str;

    fn try_from(raw: RawTime) -> Result<Self, Self::Error> {
        match (raw.column, raw.rate_hz) {
            (Some(column), None) => Ok(Self::Column { column, unit: raw.unit }),
            (None, Some(rate_hz)) => Ok(Self::Rate { rate_hz }),
            _ => Err("time needs either a column or rate_hz"),
        }
    }
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields, rename = "Torque")]
struct RawTorque {
    columns: Option<Columns>,
    #[serde(default)]
    unit: TorqueUnit,
    sign: Option<Vec<f64>>,
    current: Option<Columns>,
    gains: Option<Vec<f64>>,
}

impl TryFrom<RawTorque> for Torque {
    type Error = &'static str;

    fn try_from(raw: RawTorque) -> Result<Self, Self::Error> {
        match (raw.columns, raw.current, raw.gains) {
            (Some(columns), None, None) => Ok(Self::Measured { columns, unit: raw.unit, sign: raw.sign }),
            (None, Some(_), Some(_)) if raw.sign.is_some() => Err("put the signs into the gains"),
            (None, Some(current), Some(gains)) => Ok(Self::Current { current, gains }),
            _ => Err("torque needs either columns, or current and gains"),
        }
    }
}

fn delimiter<'de, D: Deserializer<'de>>(deserializer: D) -> Result<char, D::Error> {
    let c = char::deserialize(deserializer)?;
    let forbidden = c.is_ascii_alphanumeric() || "+-.\"\n\r_".contains(c);
    if !c.is_ascii() || forbidden || (c.is_ascii_control() && c != '\t') {
        return Err(de::Error::custom(
            "the delimiter must be an ASCII character such as ',' ';' '\\t' ' ' '|'",
        ));
    }
    Ok(c)
}

impl<'de> Deserialize<'de> for ColumnId {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColumnIdVisitor)
    }
}

struct ColumnIdVisitor;

impl Visitor<'_> for ColumnIdVisitor {
    type Value = ColumnId;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a column: its header in quotes, or its number from 1")
    }

    fn visit_str<E: de::Error>(self, name: &str) -> Result<ColumnId, E> {
        Ok(ColumnId::Name(name.to_owned()))
    }

    fn visit_u64<E: de::Error>(self, number: u64) -> Result<ColumnId, E> {
        match usize::try_from(number) {
            Ok(number @ 1..) => Ok(ColumnId::Number(number)),
            _ => Err(E::custom("columns are numbered from 1")),
        }
    }
}

impl<'de> Deserialize<'de> for Columns {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(ColumnsVisitor)
    }
}

struct ColumnsVisitor;

impl<'de> Visitor<'de> for ColumnsVisitor {
    type Value = Columns;

    fn expecting(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str("a list of columns, or a pattern such as \"actual_q_{0}\"")
    }

    fn visit_str<E: de::Error>(self, pattern: &str) -> Result<Columns, E> {
        Ok(Columns::Pattern(pattern.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<Columns, A::Error> {
        let mut columns = Vec::new();
        while let Some(column) = items.next_element()? {
            columns.push(column);
        }
        Ok(Columns::List(columns))
    }
}
