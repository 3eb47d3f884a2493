//! Text in and out: RON with positions, files written whole or not at all.

pub mod bounds;
mod explain;
pub mod files;
mod find;
mod guard;
pub mod names;
pub mod shown;

pub use shown::{harmless, harmless_json, one_line};
pub mod output;
mod partial;

pub use names::suggestion;
pub use output::Output;

use std::io::Read;
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// Largest scenario, model, coefficient or robot file that is read [bytes].
const LARGEST: u64 = 16 << 20;

/// Reads a text file, without its byte order mark where it has one.
///
/// # Errors
/// When it is not there, not UTF-8, or larger than any such file can be.
pub fn read(path: &Path) -> Result<String> {
    read_bounded(path).map_err(|e| e.in_file(path))
}

fn read_bounded(path: &Path) -> Result<String> {
    let trouble = |e: std::io::Error| Error::new(format!("cannot read the file: {e}")).help(remedy(e.kind()));
    let mut file = std::fs::File::open(path).map_err(trouble)?;
    if file.metadata().map_err(trouble)?.is_dir() {
        return Err(Error::new("this is a folder, not a file").help("name the file in it"));
    }
    let mut bytes = Vec::new();
    // Not by the size that the system says: a device or pipe has none.
    Read::take(&mut file, LARGEST + 1).read_to_end(&mut bytes).map_err(trouble)?;
    if bytes.len() as u64 > LARGEST {
        return Err(Error::new(format!("the file is larger than {} MiB", LARGEST >> 20))
            .help("no scenario, model or robot is; name the right file"));
    }
    match String::from_utf8(bytes) {
        Ok(text) => Ok(text.strip_prefix('\u{feff}').map_or_else(|| text.clone(), str::to_owned)),
        Err(e) => Err(not_utf8(&e.as_bytes()[..e.utf8_error().valid_up_to()])),
    }
}

fn remedy(kind: std::io::ErrorKind) -> &'static str {
    match kind {
        std::io::ErrorKind::NotFound => "check the path; it counts from the folder you are in",
        std::io::ErrorKind::PermissionDenied => "get permission to read it",
        _ => "check the path and its permissions",
    }
}

fn not_utf8(good: &[u8]) -> Error {
    let line_start = good.iter().rposition(|&b| b == b'\n').map_or(0, |i| i + 1);
    let line = 1 + good.iter().filter(|&&b| b == b'\n').count();
    let column = 1 + String::from_utf8_lossy(&good[line_start..]).chars().count();
    Error::new("the file is not UTF-8 text").at(line, column).help("save it in the encoding UTF-8")
}

/// Parses RON; errors carry line and column and list what is known there.
///
/// # Errors
/// When the text is not a `T`, or holds a number that is not finite or larger than any of a robot.
pub fn from_ron<T: DeserializeOwned>(text: &str) -> Result<T> {
    if text.trim().is_empty() {
        return Err(Error::new("the file is empty").at(1, 1));
    }
    guard::check(text)?;
    let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    options.from_str(text).map_err(|e| explain::explained(&e, text))
}

/// What RON's reader says, in words of ours where there are some.
pub(crate) fn plainly(said: &str) -> String {
    explain::shape(said).map_or_else(|| said.to_owned(), |(what, _)| what)
}

/// An error about what a RON text holds, with the line and column of what it is about: the first of its
/// message's words in backticks that the text holds, else the beginning. A place that it has stays.
#[must_use]
pub fn located(error: Error, text: &str) -> Error {
    if error.place().is_some() {
        return error;
    }
    let (line, column) = find::find_quoted(text, error.message()).unwrap_or_else(|| find::beginning(text));
    error.at(line, column)
}

/// An error about what the RON file `path` asks for, found long after reading it: as [`located`], but the
/// file alone when the message quotes nothing that the file holds.
#[must_use]
pub fn placed(error: Error, path: &Path) -> Error {
    if error.place().is_some() {
        return error;
    }
    let text = read(path).unwrap_or_default();
    match find::find_quoted(&text, error.message()) {
        Some((line, column)) => error.at(line, column).in_file(path),
        None => error.in_file(path),
    }
}

/// Writes a value as readable RON.
///
/// # Errors
/// When the value cannot be written as RON.
pub fn to_ron<T: serde::Serialize>(value: &T) -> Result<String> {
    let pretty = ron::ser::PrettyConfig::new().depth_limit(3).struct_names(false);
    ron::Options::default()
        .with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME)
        .to_string_pretty(value, pretty)
        .map(|s| s + "\n")
        .map_err(|e| Error::new(format!("cannot write RON: {e}")))
}

/// Writes a file whole or not at all: beside its place first, then moved there.
///
/// # Errors
/// When the folder cannot be written to.
pub fn write_whole(path: &Path, content: &[u8]) -> Result<()> {
    let trouble = |e: std::io::Error| cannot_write(path, &e);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(trouble)?;
    }
    partial::write(path, content, false, true).map_err(trouble)
}

fn cannot_write(path: &Path, error: &std::io::Error) -> Error {
    Error::new(format!("cannot write here: {error}"))
        .in_file(path)
        .help("name a folder that you may write to with `--out DIR`")
}
