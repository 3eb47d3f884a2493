//! Measurements as they were recorded: a [`Log`] of a moving robot, or [`StaticPoses`].
//!
//! Nothing here filters or repairs; that is the business of the signal step (`lacuna::signals`). Rows that cannot be
//! read are counted by reason and left out; rows that repeat or go back in time are kept.

mod columns;
mod header;
mod layout;
mod number;
mod read;
mod source;
mod statics;
mod table;
mod write;

pub use columns::{
    AngleUnit, ColumnId, ColumnMap, Columns, LengthUnit, Motion, Others, Time, TimeUnit, Torque, TorqueUnit,
};
pub use statics::StaticPoses;
pub use write::Decimals;

use std::collections::BTreeMap;
use std::io::Read;
use std::path::Path;
use std::sync::Arc;

use crate::error::Result;
use crate::robot::Robot;

/// Samples of a moving robot, row by row as recorded. Joint quantities are stored joint by joint:
/// `q[j][k]` is joint `j` at row `k`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Log {
    /// File name without folder.
    pub name: String,
    /// Time stamps in seconds; empty only where [`Log::open_states`] found none.
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
    pub dropped: BTreeMap<String, Dropped>,
    /// Columns left out while reading, with the reason (no name, hardly any numbers).
    pub ignored: BTreeMap<String, String>,
    /// How it was thinned, where it is very long (`lacuna::signals::thinned`).
    pub thinned: Option<Thinned>,
    /// Whether the header called the joints by name (`q_elbow`) instead of by number (`q3`).
    pub named_joints: bool,
}

/// Rows left out for one reason, and where the first of them stands.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Dropped {
    /// How many.
    pub rows: usize,
    /// Line of the first, from 1; 0 where the row was left out after reading.
    pub first_line: usize,
    /// Number of the field at fault in that line, from 1.
    pub first_column: usize,
}

/// What was known of a very long log before only some of its samples were kept.
#[derive(Debug, Clone, PartialEq)]
pub struct Thinned {
    /// Every so-many-th sample was kept.
    pub every: usize,
    /// Rows that were used.
    pub rows: usize,
    /// Samples on its uniform clock.
    pub samples: usize,
    /// Samples among them that were filled in gaps.
    pub samples_filled: usize,
    /// Longest distance between rows \[s\].
    pub longest_gap_s: f64,
    /// Its sampling time \[s\].
    pub period_s: f64,
    /// Where its clock came from, as in a signal report.
    pub clock: &'static str,
    /// Mismatch of positions and velocities by its stamps, and on the clock that was used [rad/s, m/s].
    pub velocity_mismatch: [Option<f64>; 2],
    /// Samples of a rebuilt clock that no row showed.
    pub skipped_samples: usize,
    /// [`Log::row_keys`] of its rows.
    pub row_keys: Arc<[u64]>,
}

/// What a reader cannot do without, beside the positions.
#[derive(Debug, Clone, Copy)]
struct Needs {
    time: bool,
    rates: bool,
    torque: bool,
}

const MEASUREMENT: Needs = Needs { time: true, rates: false, torque: true };
const MOTION: Needs = Needs { time: true, rates: false, torque: false };
const STATES: Needs = Needs { time: false, rates: true, torque: false };

impl Log {
    /// Reads a CSV or `.csv.gz` log for `robot`; `columns` renames, rescales and reorders where given.
    ///
    /// # Errors
    /// When the file is not such a log; with file, line, column and remedy.
    pub fn open(path: impl AsRef<Path>, robot: &Robot, columns: Option<&ColumnMap>) -> Result<Self> {
        read::open(path.as_ref(), robot, columns, MEASUREMENT)
    }

    /// As [`Log::open`], for motions recorded without torque: `tau` stays empty when no torque column is there.
    ///
    /// # Errors
    /// When the file is not such a log; with file, line, column and remedy.
    pub fn open_without_torque(
        path: impl AsRef<Path>,
        robot: &Robot,
        columns: Option<&ColumnMap>,
    ) -> Result<Self> {
        read::open(path.as_ref(), robot, columns, MOTION)
    }

    /// Reads states for inverse dynamics: `q`, `dq` and `ddq` of every joint, with or without `t` and `tau`.
    ///
    /// # Errors
    /// When the file is not such a table; with file, line, column and remedy.
    pub fn open_states(path: impl AsRef<Path>, robot: &Robot) -> Result<Self> {
        read::open(path.as_ref(), robot, None, STATES)
    }

    /// As [`Log::open`], from bytes that are at hand already (plain or gzip); `name` stands in the log
    /// and in error messages.
    ///
    /// # Errors
    /// When the bytes are not such a log; with line, column and remedy.
    pub fn from_reader(
        bytes: impl Read,
        name: &str,
        robot: &Robot,
        columns: Option<&ColumnMap>,
    ) -> Result<Self> {
        read::read(Box::new(bytes), name, robot, columns, MEASUREMENT).map_err(|e| e.in_file(name))
    }

    /// A key of every row as it was recorded, from positions and torques: rows of two logs that have the same one are
    /// the same measurement.
    pub fn row_keys(&self) -> Arc<[u64]> {
        if let Some(thinned) = &self.thinned {
            return Arc::clone(&thinned.row_keys);
        }
        // FNV-1a over eight bytes at a time, so that a long log is told by eight bytes a row.
        let mut keys = vec![0xCBF2_9CE4_8422_2325_u64; self.rows()];
        for column in self.q.iter().chain(&self.tau) {
            for (key, value) in keys.iter_mut().zip(column) {
                *key = (*key ^ value.to_bits()).wrapping_mul(0x0100_0000_01B3);
                *key ^= *key >> 32;
            }
        }
        keys.into()
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.q.first().map_or(self.t.len(), Vec::len)
    }
}
