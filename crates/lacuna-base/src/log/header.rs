//! The first line of a table: the names of its columns, or the proof that there are none.

use std::collections::HashMap;

use super::number::number;
use super::source::Source;
use super::table::{Format, split};
use crate::error::{Error, Part, Result};
use crate::text::names::{list, nearest, shorten};

/// Most columns a table may have; a real log has a few dozen.
const MOST_COLUMNS: usize = 4096;

/// Column names, in file order, and the line they stand in.
#[derive(Debug)]
pub(super) struct Header {
    /// Trimmed names; empty where the file gives none.
    pub names: Vec<String>,
    /// Number of the header line, from 1.
    pub line: usize,
    /// Whether the file has names, or its columns are called `column1`, `column2`, ...
    pub named: bool,
    index: HashMap<String, usize>,
}

impl Header {
    /// Reads the header line. Without one (`named` false) the columns are called by number, and the
    /// line that was read, which is data, is left in `line`.
    pub(super) fn read(
        source: &mut Source<'_>,
        format: &Format,
        named: bool,
        line: &mut Vec<u8>,
    ) -> Result<Self> {
        if !source.next_line(line)? {
            return Err(Error::new("the file is empty")
                .at(1, 1)
                .help("a log is CSV with a header line: t,q1,..,qn,tau1,..,taun"));
        }
        let place = |e: Error| e.at(source.line_number(), 1);
        check_text(line).map_err(|(e, column)| e.at(source.line_number(), column))?;
        check_shape(line, format).map_err(place)?;
        let fields = fields(line, format);
        check_numbers(&fields, named).map_err(place)?;
        let names = if named { fields } else { (1..=fields.len()).map(|i| format!("column{i}")).collect() };
        Self::of_names(names, source.line_number(), named)
    }

    fn of_names(names: Vec<String>, line: usize, named: bool) -> Result<Self> {
        let mut index = HashMap::with_capacity(names.len());
        for (i, name) in names.iter().enumerate().filter(|(_, name)| !name.is_empty()) {
            if let Some(first) = index.insert(name.clone(), i) {
                let what =
                    format!("two columns are called `{}`: number {} and {}", shorten(name), first + 1, i + 1);
                return Err(Error::new(what).at(line, i + 1).help("rename or remove one of them"));
            }
        }
        Ok(Self { names, line, named, index })
    }

    /// Index of the column called `name`, from 0.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        self.index.get(name).copied()
    }

    /// An error about the header line as a whole.
    pub(super) fn error(&self, what: impl Into<String>) -> Error {
        Error::new(what).at(self.line, 1)
    }

    /// The error for a column that must be there and is not.
    pub(super) fn missing(&self, wanted: &str) -> Error {
        let mut what = format!("there is no column `{}`", shorten(wanted));
        if self.named {
            what += &format!("; there are {}", list(self.names.iter().map(String::as_str)));
        } else {
            what += &format!("; the file has {} columns", self.names.len());
        }
        let help = match self.meant(wanted) {
            Some(near) => format!("did you mean `{near}`? rename it, or map it with a column map"),
            None => "add the column, or map another one to it with a column map".to_owned(),
        };
        self.error(what).help(help).of_part(Part::Columns)
    }

    /// What the user may have called `wanted`.
    fn meant(&self, wanted: &str) -> Option<&str> {
        const TIME: [&str; 6] = ["time", "timestamp", "stamp", "time_s", "sec", "seconds"];
        let names = self.names.iter().map(String::as_str).filter(|name| !name.is_empty() && !is_ours(name));
        if wanted == "t" {
            return names.into_iter().find(|name| TIME.contains(&name.to_lowercase().as_str()));
        }
        nearest(wanted, names)
    }
}

/// Whether a name is one of ours already (`q1`, `tau7`, ...), so that nothing else was meant by it.
fn is_ours(name: &str) -> bool {
    let letters = name.trim_end_matches(|c: char| c.is_ascii_digit());
    name == "t" || (letters.len() < name.len() && ["q", "dq", "ddq", "tau", "g", "m"].contains(&letters))
}

fn fields(line: &[u8], format: &Format) -> Vec<String> {
    let mut fields = Vec::new();
    split(line, format, |field| fields.push(String::from_utf8_lossy(field).trim().to_owned()));
    fields
}

/// Refuses what is no text; the column is counted in characters up to the trouble.
fn check_text(line: &[u8]) -> Result<(), (Error, usize)> {
    if let Some(at) = line.iter().position(|b| *b < 0x20 && *b != b'\t') {
        let (what, help) = match line[at] {
            b'\r' => ("lines end with a bare carriage return", "save the file with LF or CRLF line ends"),
            0 => ("there is a NUL byte: this is a binary file or UTF-16 text", "save it as CSV in UTF-8"),
            _ => ("there is a control character: this is no CSV file", "save it as CSV in UTF-8"),
        };
        return Err((Error::new(what).help(help), at + 1));
    }
    match std::str::from_utf8(line) {
        Ok(_) => Ok(()),
        Err(e) => {
            let before = String::from_utf8_lossy(&line[..e.valid_up_to()]).chars().count();
            Err((Error::new("the header is not UTF-8 text").help("save the file as UTF-8"), before + 1))
        }
    }
}

/// Refuses comments, absurd widths and the wrong delimiter.
fn check_shape(line: &[u8], format: &Format) -> Result<()> {
    if line.trim_ascii_start().starts_with(b"#") {
        return Err(Error::new("the first line is a comment (`#`)")
            .help("remove the comment lines; if this one holds the column names, remove only the `#`"));
    }
    let count = 1 + line.iter().filter(|b| **b == format.delimiter).count();
    if count > MOST_COLUMNS {
        return Err(Error::new(format!("the table has {count} columns; at most {MOST_COLUMNS} are read"))
            .help("write one sample per line and only the columns that are needed"));
    }
    let occurs = |d: u8| d != format.delimiter && line.contains(&d);
    if count > 1 {
        return Ok(());
    }
    let Some(other) = [b';', b'\t', b',', b'|', b' '].into_iter().find(|d| occurs(*d)) else { return Ok(()) };
    Err(Error::new(format!(
        "columns are separated by {:?}, not by {:?}",
        char::from(other),
        char::from(format.delimiter)
    ))
    .help(format!("save it with commas, or give a column map with `delimiter: {:?}`", char::from(other)))
    .of_part(Part::Columns))
}

/// A header of numbers is no header, and names are no data.
fn check_numbers(fields: &[String], named: bool) -> Result<()> {
    let is_number = |field: &String| number(field.as_bytes(), false).is_ok();
    if named && fields.iter().all(is_number) {
        return Err(Error::new("the first line holds numbers: the file has no header line")
            .help(
                "put the column names in the first line (t,q1,..,tau1,..), \
                 or give a column map with `header: false` and columns by number",
            )
            .of_part(Part::Columns));
    }
    if !named && fields.len() > 1 && fields.iter().all(|f| f.starts_with(char::is_alphabetic)) {
        return Err(Error::new("the first line holds names, but the column map says `header: false`")
            .help("set `header: true` in the column map"));
    }
    Ok(())
}
