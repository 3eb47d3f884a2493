//! What a file is, from its name and its content.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use flate2::read::MultiGzDecoder;
use serde::Serialize;

use super::fields::outer_fields;
use crate::error::{Error, Result};

/// Kinds of files that are known.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Kind {
    /// Robot as URDF.
    Urdf,
    /// Robot as Denavit-Hartenberg table.
    DenavitHartenberg,
    /// Study.
    Scenario,
    /// Log of a moving robot.
    Log,
    /// Static poses.
    Poses,
    /// Column map.
    ColumnMap,
    /// Finished model.
    Model,
    /// Published coefficients.
    Coefficients,
    /// Published sigmoid friction.
    Friction,
    /// List of constraints.
    Constraints,
    /// Script of constraints.
    Script,
    /// Script of an effect.
    EffectScript,
    /// Plant and logs to simulate.
    Experiment,
}

impl Kind {
    /// All of them.
    pub const ALL: [Self; 13] = [
        Self::Scenario,
        Self::Urdf,
        Self::DenavitHartenberg,
        Self::Log,
        Self::Poses,
        Self::ColumnMap,
        Self::Model,
        Self::Coefficients,
        Self::Friction,
        Self::Constraints,
        Self::Script,
        Self::EffectScript,
        Self::Experiment,
    ];

    /// In words.
    pub fn text(self) -> &'static str {
        match self {
            Self::Urdf => "a robot (URDF)",
            Self::DenavitHartenberg => "a robot (Denavit-Hartenberg table)",
            Self::Scenario => "a scenario",
            Self::Log => "a log of a moving robot (CSV)",
            Self::Poses => "static poses of a robot (CSV)",
            Self::ColumnMap => "a column map",
            Self::Model => "a finished model",
            Self::Coefficients => "published coefficients",
            Self::Friction => "published sigmoid friction",
            Self::Constraints => "a list of constraints",
            Self::Script => "a script of constraints",
            Self::EffectScript => "a script of an effect",
            Self::Experiment => "a plant to simulate",
        }
    }
}

impl Kind {
    /// The command, or the place in a scenario, that takes such a file.
    pub fn taken_by(self, path: &Path) -> String {
        let file = path.display();
        match self {
            Self::Urdf | Self::DenavitHartenberg => {
                format!("robots go with --robot, as in lacuna diagnose --robot {file} --data LOG.csv")
            }
            Self::Scenario => {
                format!("lacuna scenario {file} runs it, lacuna diagnose {file} asks what is missing")
            }
            Self::Log => format!("logs go with --data, as in lacuna diagnose --robot ROBOT --data {file}"),
            Self::Poses => format!("a scenario takes them: poses: File(\"{file}\")"),
            Self::ColumnMap => format!("maps go with --columns, as in lacuna check LOG.csv --columns {file}"),
            Self::Model => format!(
                "lacuna compare {file} --robot ROBOT --data LOG.csv predicts a log with it, lacuna diagnose .. \
                 --model {file} starts from it, lacuna export {file} writes it for other tools"
            ),
            Self::Coefficients => format!("a scenario takes them: retrieve_from: \"{file}\""),
            Self::Friction => format!("a scenario takes it: friction: (published: \"{file}\")"),
            Self::Constraints => format!("a scenario takes it: presets: [\"{file}\"]"),
            Self::Script => format!(
                "a scenario takes it: constraints: [{{\"script\": (path: \"{file}\")}}]; lacuna check {file} --robot \
                 ROBOT says what it means"
            ),
            Self::EffectScript => format!(
                "scripts of effects go with --add or --try, as in lacuna diagnose --robot ROBOT --data LOG.csv --try \
                 {file}"
            ),
            Self::Experiment => format!("lacuna simulate {file} --out DIR makes its logs"),
        }
    }
}

/// What to answer when the file at `path`, which had to be one of `wanted`, cannot be used for the reason `error`:
/// where it is a file of another kind, what it is and what takes it; else the reason.
#[must_use]
pub fn misplaced(error: Error, path: &Path, wanted: &[Kind]) -> Error {
    match (recognise(path), wanted.first()) {
        (Ok(found), Some(first)) if !wanted.contains(&found) && !reads_as(path, found, wanted) => {
            Error::new(format!("this is {}, not {}", found.text(), first.text()))
                .in_file(path)
                .help(found.taken_by(path))
        }
        _ => error,
    }
}

/// Whether the fields of a RON file speak for one of `wanted` as much as for `found`.
fn reads_as(path: &Path, found: Kind, wanted: &[Kind]) -> bool {
    let Ok(head) = head(path) else { return false };
    let text = String::from_utf8_lossy(&head);
    let fields = outer_fields(text.trim_start_matches('\u{feff}'));
    let hits = |kind: Kind| {
        let known = FIELDS.iter().find(|(k, _)| *k == kind).map(|(_, known)| *known);
        known.map(|known| fields.iter().filter(|f| known.contains(&f.name)).count())
    };
    let Some(least) = hits(found) else { return false };
    wanted.iter().any(|&kind| hits(kind).is_some_and(|hits| hits >= least))
}

/// Bytes that are looked at.
const HEAD: u64 = 1 << 16;

/// Outermost fields by which RON files are told apart.
const FIELDS: [(Kind, &[&str]); 7] = [
    (Kind::DenavitHartenberg, &["convention", "rows", "gravity", "frames", "angles", "name"]),
    (
        Kind::Scenario,
        &[
            "robot",
            "poses",
            "logs",
            "signals",
            "effects",
            "candidates",
            "hold_out",
            "friction",
            "seed",
            "weighting",
            "gravity",
            "drop_above_percent",
            "presets",
            "constraints",
            "objective",
            "engines",
            "intervals",
            "choice",
            "retrieve_from",
            "beside",
        ],
    ),
    (
        Kind::Experiment,
        &[
            "robot",
            "logs",
            "effects",
            "seed",
            "gravity",
            "parameters",
            "controller",
            "sensors",
            "method",
            "decimals",
            "exact_motion",
        ],
    ),
    (Kind::Model, &["lacuna", "robot", "origin", "signals", "effects", "parameters"]),
    (Kind::Coefficients, &["source", "coefficients"]),
    (Kind::Friction, &["phi1", "phi2", "phi3"]),
    (
        Kind::ColumnMap,
        &[
            "delimiter",
            "header",
            "decimal_comma",
            "time",
            "position",
            "velocity",
            "acceleration",
            "torque",
            "channels",
            "other_columns",
        ],
    ),
];

/// Recognises a file.
///
/// # Errors
/// When it cannot be read, or is none of the known kinds.
pub fn recognise(path: &Path) -> Result<Kind> {
    let head = head(path)?;
    let extension = path.extension().map(|e| e.to_string_lossy().to_lowercase()).unwrap_or_default();
    let text = String::from_utf8_lossy(&head);
    let start = text.trim_start_matches('\u{feff}').trim_start();
    match extension.as_str() {
        "rhai" => Ok(script(start)),
        "urdf" => Ok(Kind::Urdf),
        "csv" | "gz" | "txt" | "tsv" => Ok(table(start)),
        "ron" => ron(path, start),
        _ if start.starts_with('<') && !is_page(start) => Ok(Kind::Urdf),
        _ if start.starts_with('(') || start.starts_with("//") => ron(path, start),
        _ if start.lines().next().is_some_and(|line| line.contains(',')) => Ok(table(start)),
        _ => Err(unknown(path)),
    }
}

fn ron(path: &Path, text: &str) -> Result<Kind> {
    let code = text.lines().map(str::trim_start).find(|line| !line.is_empty() && !line.starts_with("//"));
    if code.is_some_and(|line| line.starts_with('[')) {
        return Ok(Kind::Constraints);
    }
    let fields = outer_fields(text);
    let hits = |known: &[&str]| fields.iter().filter(|f| known.contains(&f.name)).count();
    let best = FIELDS.iter().rev().max_by_key(|(_, known)| hits(known)).filter(|(_, known)| hits(known) > 0);
    // `()` is a column map that changes nothing.
    let empty = fields.is_empty() && text.trim_end().ends_with("()");
    match best {
        Some((kind, _)) => Ok(*kind),
        None if empty => Ok(Kind::ColumnMap),
        None => Err(unknown(path)),
    }
}

/// Effects have columns; a script that does not compile is told apart all the same.
fn script(text: &str) -> Kind {
    let defines = |line: &str| {
        line.trim_start().strip_prefix("fn ").map(str::trim_start).is_some_and(|l| l.starts_with("columns"))
    };
    if text.lines().any(defines) { Kind::EffectScript } else { Kind::Script }
}

/// A report is no robot, though both are in angle brackets.
fn is_page(text: &str) -> bool {
    text.get(..9).is_some_and(|start| start.eq_ignore_ascii_case("<!doctype"))
}

/// Poses have inertia matrices, logs do not.
fn table(text: &str) -> Kind {
    let header = text.lines().next().unwrap_or_default();
    let has = |name: &str| header.split(',').any(|field| field.trim() == name);
    if has("m11") && !has("t") { Kind::Poses } else { Kind::Log }
}

/// The first bytes, unpacked.
pub(super) fn head(path: &Path) -> Result<Vec<u8>> {
    let trouble = |e: std::io::Error| {
        Error::new(format!("cannot read the file: {e}"))
            .in_file(path)
            .help("check the path and its permissions")
    };
    let mut head = Vec::new();
    let file = File::open(path).map_err(trouble)?;
    if file.metadata().map_err(trouble)?.is_dir() {
        return Err(Error::new("this is a folder, not a file").in_file(path).help("name a file in it"));
    }
    file.take(HEAD).read_to_end(&mut head).map_err(trouble)?;
    if head.starts_with(&[0x1F, 0x8B]) {
        let mut unpacked = Vec::new();
        // A head that is cut off ends in an error; what came before it is all that is wanted.
        let _ = MultiGzDecoder::new(head.as_slice()).take(HEAD).read_to_end(&mut unpacked);
        return Ok(unpacked);
    }
    Ok(head)
}

fn unknown(path: &Path) -> Error {
    Error::new("this is no file that is known here").in_file(path).at(1, 1).help(
        "known are robots (URDF, or RON with `convention` and `rows`), scenarios (RON with `robot`), logs and \
         static poses (CSV with a header), column maps, models, coefficients and lists of constraints (RON)",
    )
}
