//! What a study keeps in its folder, and what it may say: the file is an input like any other, whoever wrote it.

use std::collections::BTreeSet;
use std::path::PathBuf;

use serde::{Deserialize, Serialize};

use super::scripts::is_name;
use super::study::{Addition, JointNumbers, Numbers, Role, Root, ScriptFile, Signals};
use crate::effects::Effect;
use crate::error::{Error, Result};
use crate::log::ColumnMap;
use crate::retrieval::RetrievalEngine;
use crate::scenario::HoldOut;
use crate::text;

/// Logs, steps, scripts and engines of a study at most.
const MOST: usize = 10_000;
/// Longest name of a study or log [characters].
const LONGEST: usize = 300;
/// Strongest gravity [m/s²].
const HEAVIEST: f64 = 1e6;

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Saved {
    pub lacuna: String,
    pub name: String,
    pub robot: Option<PathBuf>,
    pub gravity: Option<[f64; 3]>,
    pub logs: Vec<SavedLog>,
    pub columns: Option<String>,
    pub signals: Signals,
    pub hold_out: HoldOut,
    pub seed: u64,
    pub steps: Vec<SavedStep>,
    pub shown: Option<usize>,
    pub against: Option<usize>,
    pub constraints: String,
    pub scripts: Vec<ScriptFile>,
    pub engines: Vec<String>,
    pub intervals: bool,
    /// The step that link parameters were retrieved for; the results stand in `report.json`.
    pub retrieved: Option<usize>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SavedLog {
    pub name: String,
    pub path: PathBuf,
    pub role: Role,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct SavedStep {
    pub id: usize,
    pub parent: Option<usize>,
    pub root: Option<Root>,
    pub added: Option<Addition>,
    pub effects: Vec<Box<dyn Effect>>,
    pub numbers: Numbers,
}

impl Saved {
    /// Whether it can be a study; paths are not looked at.
    ///
    /// # Errors
    /// When something in it cannot be; the message quotes it.
    pub fn check(&self) -> Result<()> {
        let counts = [
            ("logs", self.logs.len()),
            ("steps", self.steps.len()),
            ("scripts", self.scripts.len()),
            ("engines", self.engines.len()),
            ("widths", self.signals.widths.len()),
        ];
        if let Some((name, count)) = counts.iter().find(|(_, count)| *count > MOST) {
            return Err(Error::new(format!("`{name}` holds {count} entries, {MOST} are the most")));
        }
        let mut names = self.logs.iter().map(|l| &l.name).chain([&self.name]);
        if let Some(name) = names.find(|n| n.chars().count() > LONGEST || n.chars().any(char::is_control)) {
            return Err(Error::new(format!("`{}` is no `name`", name.escape_debug())));
        }
        if self.gravity.iter().flatten().any(|g| !(g.abs() <= HEAVIEST)) {
            return Err(Error::new("`gravity` is beyond anything on a planet"));
        }
        self.signals.settings.check()?;
        if let Some(width) = self.signals.widths.iter().find(|w| !(w.is_finite() && **w > 0.0)) {
            return Err(Error::new(format!("`widths` holds {width:?}; widths are above 0")));
        }
        self.columns.as_deref().map_or(Ok(()), |map| {
            ColumnMap::parse(map).map(|_| ()).map_err(|e| Error::new(format!("`columns`: {}", e.message())))
        })?;
        for engine in &self.engines {
            text::from_ron::<Box<dyn RetrievalEngine>>(engine)
                .map_err(|e| Error::new(format!("`engines`: {}", e.message())))?;
        }
        self.check_scripts()?;
        self.check_steps()
    }

    fn check_scripts(&self) -> Result<()> {
        let mut seen = BTreeSet::new();
        for script in &self.scripts {
            if !is_name(&script.file) {
                return Err(Error::new(format!("`{}` is no name of a script in this folder", script.file)));
            }
            if !seen.insert(&script.file) {
                return Err(Error::new(format!("the script `{}` stands twice", script.file)));
            }
        }
        Ok(())
    }

    /// A step is added to one with a smaller number, so that none comes before itself. A step may be lost while its
    /// successors are still there: they go with the next fit.
    fn check_steps(&self) -> Result<()> {
        let mut seen = BTreeSet::new();
        for step in &self.steps {
            let id = step.id;
            let wrong = |what: String| Err(Error::new(format!("`steps`: step {id} {what}")));
            if id > MOST * MOST || !seen.insert(id) {
                return wrong("has a number that is too large or stands twice".to_string());
            }
            match (step.parent, &step.root, &step.added) {
                (None, Some(_), None) => {}
                (Some(parent), None, Some(_)) if parent < id => {}
                (Some(parent), None, Some(_)) => {
                    return wrong(format!("was added to step {parent}, a later one"));
                }
                _ => return wrong("needs either `root`, or `parent` and `added`".to_string()),
            }
            if !is_possible(&step.numbers) {
                return wrong("has `numbers` below 0".to_string());
            }
        }
        Ok(())
    }
}

/// Whether numbers can be those of a fit.
fn is_possible(numbers: &Numbers) -> bool {
    let joint = |j: &JointNumbers| {
        let all = [Some(j.torque_rms), Some(j.held_out_rms), j.repeat_floor_rms];
        all.into_iter().flatten().collect::<Vec<_>>()
    };
    let unseen = numbers.unseen_rms.iter().flatten().map(|(_, rms)| *rms);
    let all = numbers.joints.iter().flat_map(joint).chain(unseen);
    all.chain(numbers.held_out_percent).chain(numbers.unseen_percent).all(|x| x.is_finite() && x >= 0.0)
}
