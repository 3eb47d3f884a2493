//! Retrieval: the best parameters that satisfy every constraint. The engines know parameters, an
//! objective and forms; nothing here knows robots, data or effects.

mod audit;
mod barrier;
pub mod catalogue;
pub mod certificate;
mod chart;
pub mod checkpoint;
mod cone;
mod conflict;
pub mod form;
mod intervals;
mod lmi;
pub mod nlopt;
mod objective;
pub mod penalty;
pub mod polish;
mod prior;
pub mod space;

pub use audit::{Audit, ConstraintAudit, FEASIBLE, audit};
pub use chart::{Chart, Identity, Side};
pub use conflict::{Conflict, conflict};
pub use intervals::{Interval, Quantity, Slack, intervals};
pub use lmi::{LmiEngine, LmiSolution};
pub use objective::Quadratic;
pub use prior::{BodyMatrix, Chosen, TieBreak, choose};

use std::fmt::Debug;
use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use crate::form::Form;
use crate::space::Space;
use catalogue::EngineAbout;
use lacuna_base::error::Result;

/// What is to be solved: minimise the objective over the unknowns `z` subject to all forms.
#[derive(Debug)]
pub struct Problem {
    /// The unknowns `z`, in which objective and forms are written.
    pub space: Space,
    /// What is minimised.
    pub objective: Quadratic,
    /// What must hold.
    pub forms: Vec<Form>,
    /// Coordinates in which engines that search move, with their bounds (all finite).
    pub chart: Box<dyn Chart>,
    /// Every random draw follows from it.
    pub seed: u64,
}

/// How far an engine is; given to the caller now and then.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Step {
    /// Share of the work done, 0 to 1.
    pub done: f64,
    /// Best objective so far.
    pub objective: f64,
    /// Its largest scaled violation.
    pub violation: f64,
}

/// Called with every [`Step`]; `Break` asks the engine to stop and return its best. Called from several threads.
pub type Watch<'a> = dyn Fn(&Step) -> ControlFlow<()> + Sync + 'a;

/// Lagrange multipliers of the convex forms: one entry per form the engine took (implied forms included),
/// in the cone of that form.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Multiplier {
    /// Label of the form.
    pub label: String,
    /// Affine: one number; norm: bound first, then rows; semidefinite: lower triangle by rows, unscaled.
    pub values: Vec<f64>,
}

/// What an engine found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Retrieved {
    /// The unknowns.
    pub z: Vec<f64>,
    /// Independent runs made.
    pub runs: usize,
    /// Stages of each run.
    pub stages: usize,
    /// Evaluations of objective or constraints.
    pub evaluations: u64,
    /// How it ended, for people.
    pub status: String,
    /// Whether it was asked to stop before it was done.
    pub stopped: bool,
    /// Certified lower bound on the objective, where the engine has one.
    pub lower_bound: Option<f64>,
}

/// A way to solve a [`Problem`]; a plug-in, one file each.
#[typetag::serde]
pub trait RetrievalEngine: Debug + Send + Sync {
    /// Name, text, settings and an example.
    fn about(&self) -> EngineAbout;

    /// Its name in the catalogue (`penalty`, `lmi`, ...).
    fn name(&self) -> &'static str {
        self.about().name
    }

    /// The user's name for this entry of the study; the engine's own name when there is none.
    fn label(&self) -> &str;

    /// Whether this build can run it; the message says how to get one that can.
    ///
    /// # Errors
    /// When it was not compiled in.
    fn available(&self) -> Result<()> {
        Ok(())
    }

    /// Whether it takes this form; asked for every form before it starts. What it does not take is left
    /// out of its problem (implied forms are used instead) and shows in the audit. Engines that search take
    /// every form.
    ///
    /// # Errors
    /// With the reason, for people.
    fn accepts(&self, _form: &Form) -> Result<(), String> {
        Ok(())
    }

    /// Where finished parts of its work are kept from now on; engines that are done at once need nothing.
    fn set_checkpoint(&mut self, _checkpoint: Option<checkpoint::Checkpoint>) {}

    /// Solves the problem.
    ///
    /// # Errors
    /// When it cannot start; a bad result is no error, the audit shows it.
    fn retrieve(&self, problem: &Problem, watch: &Watch<'_>) -> Result<Retrieved>;
}
