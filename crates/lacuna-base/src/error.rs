//! One error type for everything a user can get wrong: it names the place and the remedy.

use std::fmt;
use std::path::Path;

use crate::text::shown::{cut_message, cut_path, cut_quotes};

/// Result with the crate's [`Error`].
pub type Result<T, E = Error> = std::result::Result<T, E>;

/// Where in an input the trouble stands; lines and columns count from 1.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Place {
    /// File name as the user wrote it.
    pub file: String,
    /// Line, where the format has lines.
    pub line: Option<usize>,
    /// Column (in characters, or the field's number in a table) where it is known.
    pub column: Option<usize>,
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", cut_path(&self.file))?;
        if let Some(line) = self.line {
            write!(f, ":{line}")?;
            if let Some(column) = self.column {
                write!(f, ":{column}")?;
            }
        }
        Ok(())
    }
}

/// What of a request an error is about, for callers that have names of their own for it: flags, fields of a page.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Effects to add to the model.
    Add,
    /// The time up to which a nested search looks.
    Nested,
    /// The map from the columns of a log.
    Columns,
}

/// What went wrong, where, and what to do about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Error {
    what: String,
    place: Option<Place>,
    help: Option<String>,
    /// Whether it is about the work, not about what is worked on.
    ends: bool,
    part: Option<Part>,
}

impl Error {
    /// A message without a place, for trouble that is not in a file.
    pub fn new(what: impl Into<String>) -> Self {
        Self { what: what.into(), place: None, help: None, ends: false, part: None }
    }

    /// The same error, placed in a file.
    #[must_use]
    pub fn in_file(mut self, file: impl AsRef<Path>) -> Self {
        let place = self.place.get_or_insert_default();
        place.file = file.as_ref().display().to_string();
        self
    }

    /// The same error, placed at a line and column (both from 1).
    #[must_use]
    pub fn at(mut self, line: usize, column: usize) -> Self {
        let place = self.place.get_or_insert_default();
        (place.line, place.column) = (Some(line), Some(column));
        self
    }

    /// The same error, with what the user can do.
    #[must_use]
    pub fn help(mut self, help: impl Into<String>) -> Self {
        self.help = Some(help.into());
        self
    }

    /// The same error, said to be about `part` (a constraint of a list, say) where it does not say so itself.
    #[must_use]
    pub fn within(mut self, part: &str) -> Self {
        if !self.what.contains(part) {
            self.what = format!("{part}: {}", self.what);
        }
        self
    }

    /// The same error, its message led in by what it is about.
    #[must_use]
    pub fn about(mut self, subject: &str) -> Self {
        self.what = format!("{subject}: {}", self.what);
        self
    }

    /// The same error, with what the user can do unless that is said already.
    #[must_use]
    pub fn or_help(mut self, help: impl Into<String>) -> Self {
        self.help.get_or_insert_with(|| help.into());
        self
    }

    /// The same error, as one that ends the work: a limit was reached or somebody stopped it, so it says nothing about
    /// the data and is no reason to go on without what it is about.
    #[must_use]
    pub fn ending(mut self) -> Self {
        self.ends = true;
        self
    }

    /// Whether it ends the work.
    pub fn ends_work(&self) -> bool {
        self.ends
    }

    /// The same error, said to be about a part of the request.
    #[must_use]
    pub fn of_part(self, part: Part) -> Self {
        Self { part: Some(part), ..self }
    }

    /// The part of the request that it is about, where that is known.
    pub fn part(&self) -> Option<Part> {
        self.part
    }

    /// The same error, with more at the end of its help.
    #[must_use]
    pub fn with_hint(mut self, hint: &str) -> Self {
        self.help = Some(self.help.map_or_else(|| hint.to_string(), |help| format!("{help}: {hint}")));
        self
    }

    /// The message without place and help.
    pub fn message(&self) -> &str {
        &self.what
    }

    /// The message with long quotes cut, as it is shown.
    pub fn brief(&self) -> String {
        cut_message(&self.what)
    }

    /// Where it happened, if it has a place.
    pub fn place(&self) -> Option<&Place> {
        self.place.as_ref()
    }
}

impl fmt::Display for Error {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        if let Some(place) = &self.place {
            write!(f, "{place}: ")?;
        }
        write!(f, "{}", self.brief())?;
        if let Some(help) = &self.help {
            write!(f, "\n  help: {}", cut_quotes(help))?;
        }
        Ok(())
    }
}

impl std::error::Error for Error {}
