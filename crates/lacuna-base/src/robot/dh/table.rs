//! The table as written: which fields there are, and where in the text they stand.

use nalgebra::{Matrix3, Vector3};
use ron::extensions::Extensions;
use ron::value::RawValue;
use serde::Deserialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};
use crate::robot::{JointKind, LARGEST_NUMBER};
use crate::text;

/// The file without its rows, which are read one by one to know their lines.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Table<'a> {
    pub name: Option<String>,
    pub convention: Convention,
    gravity: [Number; 3],
    #[serde(default)]
    pub angles: Angles,
    #[serde(borrow)]
    rows: Vec<&'a RawValue>,
    #[serde(borrow, default)]
    frames: Vec<&'a RawValue>,
}

impl Table<'_> {
    pub fn gravity(&self) -> Vector3<f64> {
        self.gravity.map(|x| x.0).into()
    }
}

#[derive(Deserialize, Clone, Copy)]
pub enum Convention {
    Modified,
    Standard,
}

#[derive(Deserialize, Clone, Copy, Default)]
pub enum Angles {
    #[default]
    Radians,
    Degrees,
}

#[derive(Deserialize, Clone, Copy, Default, PartialEq)]
pub enum Kind {
    #[default]
    Revolute,
    Prismatic,
}

impl From<Kind> for JointKind {
    fn from(kind: Kind) -> Self {
        match kind {
            Kind::Revolute => Self::Revolute,
            Kind::Prismatic => Self::Prismatic,
        }
    }
}

/// A number a robot can have: neither NaN nor infinite nor so large that products overflow.
#[derive(Deserialize, Clone, Copy)]
#[serde(try_from = "f64")]
pub struct Number(f64);

impl TryFrom<f64> for Number {
    type Error = String;

    fn try_from(x: f64) -> Result<Self, String> {
        if x.abs() <= LARGEST_NUMBER {
            Ok(Self(x))
        } else {
            Err(format!("{x} is not a usable number, write a finite one in SI units"))
        }
    }
}

/// One joint and the link that it moves.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Row {
    pub name: Option<String>,
    #[serde(default)]
    pub kind: Kind,
    a: Number,
    alpha: Number,
    d: Number,
    theta: Number,
    pub limits: Option<LimitsRow>,
    pub inertia: Option<InertiaRow>,
}

/// A frame fixed to a link, such as a flange.
#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrameRow {
    pub name: String,
    a: Number,
    alpha: Number,
    d: Number,
    theta: Number,
    pub link: Option<usize>,
}

/// The four numbers of a row, angles in the file's unit.
pub struct Screw {
    pub a: f64,
    pub alpha: f64,
    pub d: f64,
    pub theta: f64,
}

impl Row {
    pub fn screw(&self) -> Screw {
        Screw { a: self.a.0, alpha: self.alpha.0, d: self.d.0, theta: self.theta.0 }
    }
}

impl FrameRow {
    pub fn screw(&self) -> Screw {
        Screw { a: self.a.0, alpha: self.alpha.0, d: self.d.0, theta: self.theta.0 }
    }
}

/// Limits in the file's unit of angle.
#[derive(Deserialize, Clone, Copy, Default)]
#[serde(try_from = "WrittenLimits")]
pub struct LimitsRow {
    pub lower: Option<f64>,
    pub upper: Option<f64>,
    pub velocity: Option<f64>,
    pub effort: Option<f64>,
}

#[derive(Deserialize)]
#[serde(rename = "Limits", deny_unknown_fields)]
struct WrittenLimits {
    lower: Option<Number>,
    upper: Option<Number>,
    velocity: Option<Number>,
    effort: Option<Number>,
}

impl TryFrom<WrittenLimits> for LimitsRow {
    type Error = String;

    fn try_from(w: WrittenLimits) -> Result<Self, String> {
        let [lower, upper, velocity, effort] =
            [w.lower, w.upper, w.velocity, w.effort].map(|x| x.map(|x| x.0));
        if let (Some(lower), Some(upper)) = (lower, upper)
            && lower > upper
        {
            return Err(format!("the lower limit {lower} is above the upper limit {upper}, swap them"));
        }
        Ok(Self { lower, upper, velocity, effort })
    }
}

/// Inertia about the centre of mass, in the link frame.
#[derive(Deserialize, Clone, Copy)]
#[serde(rename = "Inertia", deny_unknown_fields)]
pub struct InertiaRow {
    mass: Number,
    com: [Number; 3],
    tensor: Tensor,
}

#[derive(Deserialize, Clone, Copy)]
#[serde(deny_unknown_fields)]
struct Tensor {
    xx: Number,
    xy: Number,
    xz: Number,
    yy: Number,
    yz: Number,
    zz: Number,
}

impl InertiaRow {
    pub fn mass(&self) -> f64 {
        self.mass.0
    }

    pub fn com(&self) -> Vector3<f64> {
        self.com.map(|x| x.0).into()
    }

    pub fn tensor(&self) -> Matrix3<f64> {
        let Tensor { xx, xy, xz, yy, yz, zz } = self.tensor;
        Matrix3::new(xx.0, xy.0, xz.0, xy.0, yy.0, yz.0, xz.0, yz.0, zz.0)
    }
}

/// A row with the place in the file where it begins.
pub struct Located<T> {
    pub value: T,
    pub line: usize,
    column: usize,
}

impl<T> Located<T> {
    pub fn error(&self, text: String) -> Error {
        Error::new(text).at(self.line, self.column)
    }
}

/// The whole file.
pub struct Parsed<'a> {
    pub table: Table<'a>,
    pub rows: Vec<Located<Row>>,
    pub frames: Vec<Located<FrameRow>>,
}

pub fn parse(text: &str) -> Result<Parsed<'_>> {
    let text = text.strip_prefix('\u{feff}').unwrap_or(text);
    if text.trim().is_empty() {
        return Err(Error::new("the file is empty").at(1, 1).help(SHAPE));
    }
    let table: Table = options().from_str(text).map_err(|e| placed(&e, (1, 1)))?;
    if table.rows.is_empty() {
        let help = "write one row per joint: rows: [(a: 0.0, alpha: 0.0, d: 0.3, theta: 0.0)]";
        return Err(Error::new("the table has no rows").at(1, 1).help(help));
    }
    let rows = table.rows.iter().map(|row| located(text, row)).collect::<Result<_>>()?;
    let frames = table.frames.iter().map(|row| located(text, row)).collect::<Result<_>>()?;
    Ok(Parsed { table, rows, frames })
}

/// A field that may be left out is written without `Some(..)`.
fn options() -> ron::Options {
    ron::Options::default().with_default_extension(Extensions::IMPLICIT_SOME)
}

fn located<T: DeserializeOwned>(text: &str, row: &RawValue) -> Result<Located<T>> {
    let row = row.get_ron();
    // The raw value is a slice of the text, so its address tells its place.
    let start = row.as_ptr() as usize - text.as_ptr() as usize;
    let value = options().from_str(row).map_err(|e| placed(&e, position(&text[..start])))?;
    let (line, column) = position(&text[..start + blank_before(row)]);
    Ok(Located { value, line, column })
}

/// Line and column, from 1, right after `before`.
fn position(before: &str) -> (usize, usize) {
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (1 + before.matches('\n').count(), 1 + before[line_start..].chars().count())
}

/// Length of the white space and comments that a raw value begins with.
fn blank_before(row: &str) -> usize {
    let mut rest = row.trim_start();
    loop {
        let end = match rest {
            r if r.starts_with("//") => r.find('\n'),
            r if r.starts_with("/*") => r.find("*/").map(|i| i + 1),
            _ => None,
        };
        let Some(end) = end else { return row.len() - rest.len() };
        rest = rest[end + 1..].trim_start();
    }
}

/// A RON error of a part of the text that begins at line and column `start`.
fn placed(error: &ron::error::SpannedError, start: (usize, usize)) -> Error {
    // The start of what is cut off says little, its end where to look.
    let cut_off = matches!(error.code, ron::Error::Eof);
    let at = if cut_off { error.span.end } else { error.span.start };
    let column = if at.line == 1 { start.1 + at.col - 1 } else { at.col };
    let (text, help) = explained(&error.code);
    Error::new(text).at(start.0 + at.line - 1, column).help(help)
}

fn explained(error: &ron::Error) -> (String, &'static str) {
    use ron::Error::{ExceededRecursionLimit, MissingStructField};
    match error {
        MissingStructField { field, .. } => (format!("the field `{field}` is missing"), help_for(field)),
        ExceededRecursionLimit => ("brackets are nested too deeply for a robot table".into(), SHAPE),
        other => (text::plainly(&other.to_string()), SHAPE),
    }
}

const SHAPE: &str = "robots/panda.ron shows the shape: (name, convention, gravity, angles, rows: [(a, alpha, d, theta, \
    name, kind, limits, inertia)], frames: [(name, a, alpha, d, theta, link)])";

fn help_for(field: &str) -> &'static str {
    match field {
        "convention" => {
            "write `convention: Modified` or `convention: Standard`; it is never guessed, \
            because a table read in the wrong one looks almost right"
        }
        "gravity" => "write gravity in the base frame [m/s²], such as `gravity: (0.0, 0.0, -9.81)`",
        "rows" => "write one row per joint: rows: [(a: 0.0, alpha: 0.0, d: 0.3, theta: 0.0)]",
        "a" | "alpha" | "d" | "theta" => {
            "every row has a, alpha, d and theta; write 0.0 where there is nothing"
        }
        "mass" | "com" | "tensor" => {
            "inertia: (mass: 1.0, com: (0.0, 0.0, 0.0), \
            tensor: (xx: 0.01, xy: 0.0, xz: 0.0, yy: 0.01, yz: 0.0, zz: 0.01)), about the centre of mass"
        }
        "xx" | "xy" | "xz" | "yy" | "yz" | "zz" => "the tensor has the elements xx, xy, xz, yy, yz, zz",
        _ => SHAPE,
    }
}
