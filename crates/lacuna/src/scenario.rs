//! The scenario file: what to study, as plain data. Nothing is computed here.
//!
//! RON with unknown fields refused; every file it names is relative to the scenario's own folder.

mod files;
mod published;

pub use files::{find_log, find_poses};
pub use published::{Published, PublishedFriction};

use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use crate::constraints::Constraint;
use crate::effects::{Effect, RigidBody, classic};
use crate::error::{Error, Result};
use crate::excitation::{FourierMotion, SinusoidalVelocity};
use crate::identify::{Search, Weighting};
use crate::plant::{Controller, PlantEffect, Sensors};
use crate::retrieval::{RetrievalEngine, Slack};
use crate::signals::{Folds, Rows, Run, Settings};
use crate::text;
use crate::text::bounds::{FoldCount, Gravity, Harmonics, Percent, PoseCount, Positive, Seconds, Share};

/// Most samples of a simulated run.
const MOST_SAMPLES: f64 = 2e6;

/// A study. Parts that are not given are not done.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scenario {
    /// Robot file.
    pub robot: PathBuf,
    /// Replaces the robot file's gravity [m/s², base frame].
    #[serde(default, deserialize_with = "Gravity::read")]
    pub gravity: Option<[f64; 3]>,
    /// Every random draw follows from it.
    #[serde(default = "one")]
    pub seed: u64,
    /// Static poses to identify from (section IV-A of Gaz et al. 2019).
    #[serde(default)]
    pub poses: Option<Poses>,
    /// Logs of a moving robot to identify from (section III).
    #[serde(default)]
    pub logs: Option<Logs>,
    /// The signal step.
    #[serde(default)]
    pub signals: Settings,
    /// What makes the torque; rigid body, viscous and Coulomb friction and offset when not given.
    #[serde(default = "classic")]
    pub effects: Vec<Box<dyn Effect>>,
    /// Effects that a diagnosis tries beside those of the catalogue, scripts above all.
    #[serde(default)]
    pub candidates: Vec<Box<dyn Effect>>,
    /// How rows are weighed.
    #[serde(default)]
    pub weighting: Weighting,
    /// Coefficients less certain than this [% standard deviation] are dropped; none when not given.
    #[serde(default, deserialize_with = "Positive::read")]
    pub drop_above_percent: Option<f64>,
    /// How data are held out.
    #[serde(default)]
    pub hold_out: HoldOut,
    /// The friction path: rigid part frozen, sigmoid fitted to the rest (section IV-B).
    #[serde(default)]
    pub friction: Option<FrictionPath>,
    /// Files that hold lists of constraints, such as `panda_bounds.ron`.
    #[serde(default)]
    pub presets: Vec<PathBuf>,
    /// What link parameters must satisfy (section V), beside the presets.
    #[serde(default)]
    pub constraints: Vec<Box<dyn Constraint>>,
    /// What is minimised when link parameters are retrieved.
    #[serde(default)]
    pub objective: Objective,
    /// Engines that retrieve feasible link parameters, all on the same problem; none when empty.
    #[serde(default)]
    pub engines: Vec<Box<dyn RetrievalEngine>>,
    /// Ranges of all link parameters over everything that is nearly as good as the best; `()` for the usual
    /// slack. Not computed when not given.
    #[serde(default)]
    pub intervals: Option<Slack>,
    /// Whether to look for what is missing beside these effects, as `lacuna diagnose` does.
    #[serde(default)]
    pub diagnosis: bool,
    /// Other files of the same robot, whose inertias stand beside the retrieved ones under the robots' names.
    #[serde(default)]
    pub beside: Vec<PathBuf>,
    /// Published coefficients to retrieve link parameters from, in place of the identified ones; those that
    /// the identification dropped are left out all the same.
    #[serde(default)]
    pub retrieve_from: Option<PathBuf>,
    /// Which of many equally good sets of link parameters to take; the best engine's when not given.
    #[serde(default)]
    pub choice: Option<Choice>,
}

/// What decides between equally good sets of link parameters: neither data nor constraints do.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Choice {
    /// Nearest to the inertias of a robot file, in the log-determinant sense.
    Nearest {
        /// URDF or Denavit-Hartenberg file of the same robot, whose link frames may differ; the scenario's own
        /// robot when not given.
        #[serde(default)]
        prior: Option<PathBuf>,
    },
    /// Mass spread as widely and evenly as possible.
    Uniform,
    /// Least mass and least second moment.
    Smallest,
}

/// What is minimised when link parameters are retrieved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Objective {
    /// Squared distance to the identified coefficients that were kept (two steps; eq. 29).
    #[default]
    Coefficients,
    /// Squared torque error on the stacked regressor of the logs (one step).
    Torque,
}

fn one() -> u64 {
    1
}

/// Where static poses come from.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Poses {
    /// A table `q1..qn, g1..gn, m11, m21, ..`.
    File(PathBuf),
    /// Read-outs of a model with these coefficients at random configurations within the joint limits.
    ReadOut {
        /// File of published coefficients.
        coefficients: PathBuf,
        /// Number of configurations.
        #[serde(deserialize_with = "PoseCount::read")]
        count: usize,
        /// Noise added to every read-out, as the relative error it makes [%].
        #[serde(deserialize_with = "Percent::read")]
        noise_percent: f64,
    },
}

/// Where logs come from.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Logs {
    /// CSV files.
    Files {
        /// Logs to fit, looked for beside the scenario and then in the folder that `LACUNA_DATA` names; may be
        /// empty where static poses are identified and logs only validate.
        fit: Vec<PathBuf>,
        /// Logs that are never fitted, only predicted.
        #[serde(default)]
        validate: Vec<PathBuf>,
        /// Column map for foreign headers.
        #[serde(default)]
        columns: Option<PathBuf>,
        /// Shown when a log is not there: where to get it.
        #[serde(default)]
        missing: Option<String>,
    },
    /// A simulated run of the scenario's robot: forward dynamics under a tracking controller.
    Simulated(Box<Simulated>),
}

/// A simulated run.
#[derive(Debug, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Simulated {
    /// The commanded motion.
    pub motion: Commanded,
    /// Length of the motion between run-up and run-out \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    pub duration_s: f64,
    /// Length of run-up and run-out \[s\].
    #[serde(default = "half", deserialize_with = "Seconds::read")]
    pub ramp_s: f64,
    /// Physics of the plant beside its rigid links.
    #[serde(default)]
    pub effects: Vec<Box<dyn PlantEffect>>,
    /// What makes it follow the motion.
    #[serde(default)]
    pub controller: Controller,
    /// What is measured.
    #[serde(default)]
    pub sensors: Sensors,
}

fn half() -> f64 {
    0.5
}

impl Simulated {
    /// Refuses what memory could not hold.
    fn check(&self) -> Result<()> {
        let samples = self.sensors.rows(self.duration_s + 2.0 * self.ramp_s);
        if samples.is_nan() || samples > MOST_SAMPLES {
            return Err(Error::new(format!("`duration_s` asks for {samples:.3e} samples")).help(format!(
                "at most {MOST_SAMPLES:.0} are simulated: shorten the motion or sample less often"
            )));
        }
        Ok(())
    }
}

/// Motions that can be commanded.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Commanded {
    /// Finite Fourier series of the velocities (as in Table II of the supplement).
    Fourier(FourierMotion),
    /// Sinusoidal velocities (eq. 31).
    Sinusoidal(SinusoidalVelocity),
    /// The published exciting motion of the Panda (Table II).
    PandaTableII,
    /// A random Fourier series within the joint limits.
    Random {
        /// Number of harmonics.
        #[serde(deserialize_with = "Harmonics::read")]
        harmonics: usize,
        /// Period \[s\].
        #[serde(deserialize_with = "Seconds::read")]
        period_s: f64,
        /// Part of each joint's range and speed that is used, up to 1.
        #[serde(deserialize_with = "Share::read")]
        amplitude: f64,
    },
}

/// How data are held out.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum HoldOut {
    /// Same-phase folds when the motion repeats, else contiguous blocks.
    #[default]
    Auto,
    /// Equal phases of all periods are held out together.
    SamePhase {
        /// Period of the motion \[s\].
        #[serde(deserialize_with = "Seconds::read")]
        period_s: f64,
        /// Number of folds.
        #[serde(deserialize_with = "FoldCount::read")]
        folds: u16,
    },
    /// Contiguous blocks, dealt out to folds in turn.
    Contiguous {
        /// Length of a block \[s\].
        #[serde(deserialize_with = "Seconds::read")]
        block_s: f64,
        /// Number of folds.
        #[serde(deserialize_with = "FoldCount::read")]
        folds: u16,
    },
}

impl HoldOut {
    /// The folds of these runs.
    ///
    /// # Errors
    /// When the runs are too short to hold anything out.
    pub fn folds(self, runs: &[Run]) -> Result<Folds> {
        let rows: Vec<Rows> = runs.iter().map(Run::rows).collect();
        match self {
            Self::Auto => Folds::choose(&runs.iter().collect::<Vec<_>>()),
            Self::SamePhase { period_s, folds } => Folds::same_phase(&rows, period_s, folds),
            Self::Contiguous { block_s, folds } => Folds::contiguous(&rows, block_s, folds),
        }
    }
}

/// The friction path.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionPath {
    /// Coefficients of the frozen rigid part; those of this scenario's static poses when not given.
    #[serde(default)]
    pub coefficients: Option<PathBuf>,
    /// Published friction parameters to use as they are: nothing is fitted then.
    #[serde(default)]
    pub published: Option<PathBuf>,
    /// How the sigmoid is searched.
    #[serde(default)]
    pub search: Search,
}

impl Scenario {
    /// Reads a scenario file.
    ///
    /// # Errors
    /// With file, line and column, and what is known there.
    pub fn open(path: &Path) -> Result<Self> {
        Self::parse(&text::read(path)?).map_err(|e| e.in_file(path))
    }

    /// Reads the text of a scenario.
    ///
    /// # Errors
    /// As [`Scenario::open`], without the file.
    pub fn parse(text: &str) -> Result<Self> {
        let shape = "scenarios/panda.ron shows how a scenario is written";
        let scenario: Self = text::from_ron(text).map_err(|e| e.or_help(shape))?;
        scenario.check().map_err(|e| text::located(e, text))?;
        Ok(scenario)
    }

    fn check(&self) -> Result<()> {
        self.signals.check()?;
        if self.poses.is_none() && self.logs.is_none() {
            return Err(Error::new("the scenario has neither `poses` nor `logs`")
                .help("give it something to identify from"));
        }
        if self.effects.is_empty() {
            return Err(Error::new("`effects` names none, so there is nothing to identify")
                .help(format!("leave `effects` out, or list at least {}", RigidBody::ABOUT.example)));
        }
        self.check_objective()?;
        match &self.logs {
            Some(Logs::Files { fit, validate, .. })
                if fit.is_empty() && (validate.is_empty() || self.poses.is_none()) =>
            {
                return Err(
                    Error::new("`logs` names no file to fit").help("list at least one CSV under `fit`")
                );
            }
            Some(Logs::Files { fit, validate, .. }) => {
                if let Some(both) = validate.iter().find(|file| fit.contains(file)) {
                    return Err(Error::new(format!(
                        "`{}` stands under `fit` and under `validate`",
                        both.display()
                    ))
                    .help(
                        "validate with a log that is not fitted; folds are held out of fitted logs anyway",
                    ));
                }
            }
            Some(Logs::Simulated(simulated)) => simulated.check()?,
            None => {}
        }
        if let Some(friction) = &self.friction {
            if self.logs.is_none() {
                return Err(Error::new("`friction` needs `logs` to be fitted to")
                    .help("give `logs`, or leave `friction` out"));
            }
            if friction.coefficients.is_none() && self.poses.is_none() {
                return Err(Error::new("`friction` needs a rigid part to freeze")
                    .help("give `poses`, or name a file of coefficients in `friction`"));
            }
        }
        Ok(())
    }

    fn check_objective(&self) -> Result<()> {
        if self.retrieve_from.is_some() && self.objective == Objective::Torque {
            return Err(Error::new("`retrieve_from` gives coefficients, `objective: Torque` asks for none")
                .help("leave one of the two out"));
        }
        Ok(())
    }
}
