//! The file that describes a simulated experiment.

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::log::Decimals;
use crate::plant::{Controller, Method, PlantEffect, Sensors};
use crate::scenario::Commanded;
use crate::text;
use crate::text::bounds::{Gravity, Seconds};

/// A plant, and the logs that are recorded of it.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Experiment {
    /// Robot file, relative to this one.
    pub robot: PathBuf,
    /// Replaces the robot file's gravity [m/s², base frame].
    #[serde(default, deserialize_with = "Gravity::read")]
    pub gravity: Option<[f64; 3]>,
    /// Replaces the robot file's inertial parameters: per link mass, mass times centre of mass (x, y, z), and
    /// inertia about the link frame's origin (xx, xy, xz, yy, yz, zz) [kg, kg m, kg m²].
    #[serde(default)]
    pub parameters: Option<Vec<[f64; 10]>>,
    /// Every random draw follows from it.
    #[serde(default = "one")]
    pub seed: u64,
    /// Physics beside rigid links, in all logs.
    #[serde(default)]
    pub effects: Vec<Box<dyn PlantEffect>>,
    /// What makes the robot follow its motions.
    #[serde(default)]
    pub controller: Controller,
    /// What is measured.
    #[serde(default)]
    pub sensors: Sensors,
    /// How motions are integrated.
    #[serde(default = "quick")]
    pub method: Method,
    /// What is recorded.
    pub logs: Vec<Recording>,
    /// Digits of the written logs.
    #[serde(default)]
    pub decimals: Decimals,
    /// Whether the motions without noise are written beside the truth.
    #[serde(default)]
    pub exact_motion: bool,
}

/// One log.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recording {
    /// Name of the file, without its ending.
    pub name: String,
    /// The commanded motion.
    pub motion: Commanded,
    /// Length of the motion between run-up and run-out \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    pub duration_s: f64,
    /// Length of run-up and run-out \[s\].
    #[serde(default = "half", deserialize_with = "Seconds::read")]
    pub ramp_s: f64,
    /// Seed of this log's motion and noise; the experiment's seed plus the log's place in the list when not
    /// given.
    #[serde(default)]
    pub seed: Option<u64>,
    /// Physics in this log only, such as a payload.
    #[serde(default)]
    pub effects: Vec<Box<dyn PlantEffect>>,
}

fn one() -> u64 {
    1
}

fn half() -> f64 {
    0.5
}

fn quick() -> Method {
    Method::Implicit
}

impl Experiment {
    /// Reads the file.
    ///
    /// # Errors
    /// With file, line and column, and what is known there.
    pub fn open(path: &Path) -> Result<Self> {
        let written = text::read(path)?;
        let experiment: Self = text::from_ron(&written).map_err(|e| e.in_file(path))?;
        experiment.check().map_err(|e| text::located(e, &written).in_file(path))?;
        Ok(experiment)
    }

    fn check(&self) -> Result<()> {
        if self.logs.is_empty() {
            return Err(Error::new("`logs` is empty").help("describe at least one log to record"));
        }
        for (i, log) in self.logs.iter().enumerate() {
            let word = |c: char| c.is_ascii_alphanumeric() || c == '_' || c == '-';
            if log.name.is_empty() || !log.name.chars().all(word) {
                return Err(Error::new(format!("`{}` is no name for a log", log.name))
                    .help("use letters, digits, `_` and `-`; the ending .csv.gz is added"));
            }
            if self.logs[..i].iter().any(|other| other.name == log.name) {
                return Err(Error::new(format!("two logs are called `{}`", log.name))
                    .help("give every log its own name"));
            }
        }
        Ok(())
    }
}
