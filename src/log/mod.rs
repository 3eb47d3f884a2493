//! Measurements as they were recorded: a [`Log`] of a moving robot, or [`StaticPoses`].
//!
//! Nothing here filters or repairs; that is the business of [`crate::signals`].

mod columns;
mod csv;
mod statics;

pub use columns::ColumnMap;
pub use statics::StaticPoses;

use std::collections::BTreeMap;
use std::path::Path;

use crate::error::Result;
use crate::robot::Robot;

/// Samples of a moving robot, row by row as recorded. Joint quantities are stored joint by joint:
/// `q[j][k]` is joint `j` at row `k`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// File name without folder.
    pub name: String,
    /// Time stamps [s].
    pub t: Vec<f64>,
    /// Positions [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Velocities [rad/s, m/s], where logged.
    pub dq: Option<Vec<Vec<f64>>>,
    /// Accelerations [rad/s², m/s²], where logged.
    pub ddq: Option<Vec<Vec<f64>>>,
    /// Torques [N m, N]; empty where the file has none and none were asked for.
    pub tau: Vec<Vec<f64>>,
    /// Every other column by its header.
    pub channels: BTreeMap<String, Vec<f64>>,
    /// Rows left out while reading, by reason (`"not a number"`, ...).
    pub dropped: BTreeMap<String, usize>,
}

impl Log {
    /// Reads a CSV or `.csv.gz` log for `robot`; `columns` renames, rescales and reorders where given.
    ///
    /// # Errors
    /// When the file is not such a log; with file, line, column and remedy.
    pub fn open(path: impl AsRef<Path>, robot: &Robot, columns: Option<&ColumnMap>) -> Result<Self> {
        csv::open(path.as_ref(), robot, columns)
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.t.len()
    }
}
