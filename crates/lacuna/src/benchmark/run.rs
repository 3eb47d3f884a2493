//! The examination as a whole: many draws side by side, kept as they come.

use std::path::Path;

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::plan::Item;
use super::{Examination, examine};
use crate::error::{Error, Result};
use crate::text;

/// What has been examined so far; written to `benchmark.json`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Record {
    /// Version.
    pub lacuna: String,
    /// Seed that all draws come from.
    pub seed: u64,
    /// The draws, in the order of the plan.
    pub sets: Vec<Examination>,
}

impl Record {
    /// Nothing examined yet.
    pub fn new(seed: u64) -> Self {
        Self { lacuna: env!("CARGO_PKG_VERSION").to_string(), seed, sets: Vec::new() }
    }

    /// Reads what an earlier run wrote.
    ///
    /// # Errors
    /// When the file cannot be read, is damaged, or belongs to other draws.
    pub fn open(path: &Path, seed: u64) -> Result<Self> {
        let text = text::read(path)?;
        let record: Self = serde_json::from_str(&text).map_err(|e| {
            Error::new(format!("this is no record of an examination: {e}"))
                .in_file(path)
                .help("start again without --resume")
        })?;
        if record.seed != seed || record.lacuna != env!("CARGO_PKG_VERSION") {
            return Err(Error::new(format!(
                "the record is of seed {} and version {}, not of seed {seed} and version {}",
                record.seed,
                record.lacuna,
                env!("CARGO_PKG_VERSION")
            ))
            .in_file(path)
            .help("give the same seed, or start again without --resume"));
        }
        Ok(record)
    }

    fn knows(&self, item: &Item) -> bool {
        self.sets.iter().any(|s| s.part == item.part.name() && s.number == item.number && s.seed == item.seed)
    }
}

/// Examines what `record` does not know yet, as many draws at a time as there are threads; `each` is called with the
/// record and the number of draws left after every batch.
///
/// # Errors
/// When a simulation or a diagnosis fails, or `each` does.
pub fn run(
    items: &[Item],
    record: &mut Record,
    each: &mut dyn FnMut(&Record, usize) -> Result<()>,
) -> Result<()> {
    let open: Vec<&Item> = items.iter().filter(|item| !record.knows(item)).collect();
    let mut left = open.len();
    for batch in open.chunks(rayon::current_num_threads().max(1)) {
        let done: Vec<Examination> = batch.par_iter().map(|item| examine(item)).collect::<Result<_>>()?;
        record.sets.extend(done);
        left -= batch.len();
        each(record, left)?;
    }
    Ok(())
}
