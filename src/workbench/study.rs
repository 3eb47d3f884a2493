//! What a study is: its files, its steps, and what is known of them. Plain data; [`Bench`](super::bench::Bench)
//! guards it.

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::Arc;

use serde::{Deserialize, Serialize};
use serde_json::Value;

use crate::check::Findings;
use crate::diagnose::{Diagnosis, Fitted, Proposed, Start};
use crate::effects::Effect;
use crate::error::Error;
use crate::log::Log;
use crate::report::pictures::Ranked;
use crate::robot::Robot;
use crate::scenario::HoldOut;
use crate::signals::Settings;
use crate::text::Output;

/// Everything that the page shows and the folder keeps.
pub(super) struct Study {
    pub name: String,
    pub folder: PathBuf,
    /// The same for writing: what was made there, and nobody else's.
    pub output: Output,
    pub robot: Option<RobotFile>,
    pub gravity: Option<[f64; 3]>,
    pub logs: Vec<LogFile>,
    /// Column map as text, with what is wrong with it.
    pub columns: Option<String>,
    pub signals: Signals,
    pub hold_out: HoldOut,
    pub seed: u64,
    pub steps: Vec<Step>,
    /// Numbers of the model on show and the one it is compared with.
    pub shown: Option<usize>,
    pub against: Option<usize>,
    /// List of constraints as text.
    pub constraints: String,
    pub scripts: Vec<ScriptFile>,
    /// Engines of the last retrieval, as RON.
    pub engines: Vec<String>,
    /// Whether ranges of all link parameters were asked for.
    pub intervals: bool,
    pub retrieval: Option<Retrieval>,
    /// What the last job ended with.
    pub trouble: Option<Error>,
}

/// The robot of a study.
#[derive(Clone)]
pub(super) struct RobotFile {
    pub path: PathBuf,
    pub robot: Option<Arc<Robot>>,
    pub problem: Option<Error>,
}

/// What a log is used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Role {
    /// It is fitted.
    Fit,
    /// It is only predicted.
    Validate,
}

/// A log of a study.
#[derive(Clone)]
pub(super) struct LogFile {
    pub id: usize,
    /// As the user called it.
    pub name: String,
    pub path: PathBuf,
    pub role: Role,
    /// Itself, once it was read and can be used; thinned where it is very long.
    pub log: Option<Arc<Log>>,
    /// What is in it; `None` until it was read.
    pub seen: Option<Seen>,
    /// Units, signs and order against the robot; `None` until they were checked.
    pub findings: Option<Arc<Findings>>,
}

/// What a look into a log shows.
#[derive(Debug, Clone, Default)]
pub(super) struct Seen {
    pub rows: usize,
    pub seconds: f64,
    pub rate_hz: Option<f64>,
    pub dropped: BTreeMap<String, usize>,
    pub columns: Vec<Column>,
    /// The first rows as they stand there.
    pub sample: Vec<Vec<String>>,
    pub problem: Option<Error>,
    pub remarks: Vec<String>,
}

/// A column of a log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(super) struct Column {
    pub number: usize,
    pub header: String,
    pub meaning: &'static str,
    pub joint: Option<String>,
    pub unit: String,
}

/// The signal step in force.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Signals {
    pub settings: Settings,
    /// Widths of the smoothed sign of each joint [rad/s]; empty until a diagnosis chose them.
    pub widths: Vec<f64>,
    /// Whether a diagnosis chose them, or the user did.
    pub chosen: bool,
}

/// The model that a row of steps begins with.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Root {
    /// Rigid body alone.
    Rigid,
    /// Rigid body, viscous and Coulomb friction and offset.
    Classic,
    /// These effects.
    Effects(Vec<Box<dyn Effect>>),
}

impl Root {
    pub fn start(&self) -> Start {
        match self {
            Self::Rigid => Start::Rigid,
            Self::Classic => Start::Classic,
            Self::Effects(effects) => Start::Effects(effects.clone()),
        }
    }

    pub fn label(&self) -> &'static str {
        match self {
            Self::Rigid => "rigid model",
            Self::Classic => "classic model",
            Self::Effects(_) => "given model",
        }
    }
}

/// An effect that a step adds to its parent's model.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Addition {
    pub effect: String,
    /// Joints; wherever it fits when none is named.
    #[serde(default)]
    pub joints: Vec<String>,
}

/// A finished step: a model.
#[derive(Clone)]
pub(super) struct Step {
    pub id: usize,
    pub parent: Option<usize>,
    /// What a first step starts from.
    pub root: Option<Root>,
    /// What any other adds.
    pub added: Option<Addition>,
    /// The effects with their shapes, once fitted.
    pub effects: Vec<Box<dyn Effect>>,
    /// `None` until it is fitted in this process.
    pub fitted: Option<Arc<Fitted>>,
    /// One scoring of the catalogue beside it.
    pub ranking: Option<Arc<Vec<Ranked>>>,
    /// The full diagnosis of it.
    pub scan: Option<Arc<Scan>>,
    /// Numbers to show until it is fitted again.
    pub numbers: Numbers,
}

/// What a step is judged by.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Numbers {
    pub held_out_percent: Option<f64>,
    pub joints: Vec<JointNumbers>,
    pub unseen_percent: Option<f64>,
    pub unseen_rms: Option<BTreeMap<String, f64>>,
}

/// A joint of a step.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct JointNumbers {
    pub name: String,
    pub torque_rms: f64,
    pub held_out_rms: f64,
    pub repeat_floor_rms: Option<f64>,
}

/// What a search beside a step found.
pub(super) struct Scan {
    pub diagnosis: Diagnosis,
    /// Scripts of what is unexplained, in its order, with the names under which they were kept.
    pub proposed: Vec<Option<(String, Proposed)>>,
    pub ranking: Vec<Ranked>,
    pub verdict: Vec<String>,
}

/// What a script is for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum ScriptKind {
    /// It states an effect.
    Effect,
    /// It states rules on link parameters.
    Constraint,
}

/// A script of the study.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct ScriptFile {
    pub file: String,
    pub kind: ScriptKind,
    pub text: String,
    /// Whether a search proposed it and nobody took it yet: then it is no candidate of the next one.
    #[serde(default)]
    pub proposed: bool,
}

/// A retrieval of link parameters.
#[derive(Debug, Clone, Default)]
pub(super) struct Retrieval {
    pub step: usize,
    pub running: bool,
    pub stopped: bool,
    pub engines: Vec<String>,
    /// The engine that runs.
    pub engine: Option<String>,
    /// `[seconds, objective, violation]` of its best, thinned.
    pub history: Vec<[Option<f64>; 3]>,
    /// The study's report, once it is finished.
    pub report: Option<Arc<Value>>,
}

impl Study {
    pub fn step(&self, id: usize) -> Option<&Step> {
        self.steps.iter().find(|s| s.id == id)
    }

    pub fn step_mut(&mut self, id: usize) -> Option<&mut Step> {
        self.steps.iter_mut().find(|s| s.id == id)
    }

    /// The model on show; `None` while there is none for the data at hand.
    pub fn on_show(&self) -> Option<&Step> {
        self.step(self.shown?).filter(|s| s.is_there())
    }

    /// The steps from the first one to `id`.
    pub fn path(&self, id: usize) -> Vec<usize> {
        let mut path = Vec::new();
        let mut next = Some(id);
        while let Some(step) = next.and_then(|id| self.step(id)).filter(|s| !path.contains(&s.id)) {
            path.push(step.id);
            next = step.parent;
        }
        path.reverse();
        path
    }

    pub fn next_id(&self) -> usize {
        self.steps.iter().map(|s| s.id + 1).max().unwrap_or(0)
    }

    /// Whether there is something to fit.
    pub fn is_ready(&self) -> bool {
        self.robot.as_ref().is_some_and(|r| r.robot.is_some()) && self.usable(Role::Fit).next().is_some()
    }

    /// Logs of a role that can be used.
    pub fn usable(&self, role: Role) -> impl Iterator<Item = &LogFile> {
        let good = |log: &&LogFile| log.seen.as_ref().is_none_or(|seen| seen.problem.is_none());
        self.logs.iter().filter(move |log| log.role == role).filter(good)
    }

    /// The robot, once it was read.
    pub fn robot(&self) -> Option<&Arc<Robot>> {
        self.robot.as_ref().and_then(|r| r.robot.as_ref())
    }
}

impl Step {
    /// Whether it was fitted to the data that the study has now.
    pub fn is_there(&self) -> bool {
        !self.effects.is_empty()
    }

    /// What to call it.
    pub fn label(&self) -> String {
        match (&self.added, &self.root) {
            (Some(added), _) => {
                let on = if added.joints.is_empty() {
                    String::new()
                } else {
                    format!(" on {}", added.joints.join(", "))
                };
                format!("+ {}{on}", added.effect.replace('_', " "))
            }
            (None, Some(root)) => root.label().to_string(),
            (None, None) => "model".to_string(),
        }
    }
}

impl Numbers {
    pub fn of(fitted: &Fitted) -> Self {
        let joint = |j: &crate::diagnose::JointFit| JointNumbers {
            name: j.name.clone(),
            torque_rms: j.torque_rms,
            held_out_rms: j.held_out_rms,
            repeat_floor_rms: j.repeat_floor_rms,
        };
        Self {
            held_out_percent: fitted.held_out_percent,
            joints: fitted.joints.iter().map(joint).collect(),
            unseen_percent: fitted.unseen.as_ref().and_then(|u| u.0),
            unseen_rms: fitted.unseen.as_ref().map(|u| u.1.clone()),
        }
    }
}
