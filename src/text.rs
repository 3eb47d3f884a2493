//! Text in and out: RON with positions, files written whole or not at all.

use std::io::Write;
use std::path::Path;

use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

/// Largest scenario, model or coefficient file that is read [bytes].
const LARGEST: u64 = 16 << 20;

/// Reads a text file.
///
/// # Errors
/// When it is not there, not text, or larger than any such file can be.
pub fn read(path: &Path) -> Result<String> {
    let trouble = |e: std::io::Error| Error::new(format!("cannot read the file: {e}")).in_file(path);
    let size = std::fs::metadata(path).map_err(trouble)?.len();
    if size > LARGEST {
        return Err(Error::new(format!("the file has {size} bytes, more than {LARGEST}")).in_file(path));
    }
    std::fs::read_to_string(path).map_err(trouble)
}

/// Parses RON; errors carry line and column and list what is known there.
///
/// # Errors
/// When the text is not a `T`.
pub fn from_ron<T: DeserializeOwned>(text: &str) -> Result<T> {
    let options = ron::Options::default().with_default_extension(ron::extensions::Extensions::IMPLICIT_SOME);
    options.from_str(text).map_err(|e| {
        let start = e.span.start;
        Error::new(e.code.to_string()).at(start.line, start.col)
    })
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
    let trouble = |e: std::io::Error| Error::new(format!("cannot write: {e}")).in_file(path);
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).map_err(trouble)?;
    }
    let mut partial = path.as_os_str().to_owned();
    partial.push(format!(".{}.partial", std::process::id()));
    let write = || -> std::io::Result<()> {
        let mut file = std::fs::File::create(&partial)?;
        file.write_all(content)?;
        file.sync_all()?;
        std::fs::rename(&partial, path)
    };
    write().map_err(|e| {
        // The half-written file is of no use to anybody; that removing it may fail too changes nothing.
        let _ = std::fs::remove_file(&partial);
        trouble(e)
    })
}
