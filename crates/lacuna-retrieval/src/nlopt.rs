//! Engine `nlopt`: the local solvers of Steven Johnson's NLopt from random starts, as a yardstick for ours.
//!
//! The solvers themselves stand in a crate of their own, `lacuna-nlopt`: it needs CMake and a C compiler, and the
//! library it builds contains code under the LGPL. A program that links it calls [`provide`] once. The engine is
//! always known by name, so that a scenario that asks for it is told what to do.

use std::sync::OnceLock;

use serde::{Deserialize, Serialize};

use super::catalogue::EngineAbout;
use super::checkpoint::Checkpoint;
use super::{Problem, RetrievalEngine, Retrieved, Watch};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{Moves, Runs};

/// Which solver of NLopt.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum NloptAlgorithm {
    /// Sequential quadratic programming (Kraft 1994) with all forms as constraints.
    #[default]
    Slsqp,
    /// Subspace-searching simplex (Rowan 1990, Johnson's version) on the objective plus a linear penalty.
    Sbplx,
}

/// Engine `nlopt`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct NloptEngine {
    /// The user's name for this entry.
    pub label: Option<String>,
    /// Independent runs.
    #[serde(deserialize_with = "Runs::read")]
    pub runs: usize,
    /// The solver.
    pub algorithm: NloptAlgorithm,
    /// Most evaluations of a run; 2000 for `Slsqp` and 200 000 for `Sbplx`, whose evaluations are cheaper,
    /// when not given.
    #[serde(deserialize_with = "Moves::read")]
    pub evaluations: Option<u32>,
    /// Where finished runs are kept.
    #[serde(skip)]
    pub checkpoint: Option<Checkpoint>,
}

impl Default for NloptEngine {
    fn default() -> Self {
        Self { label: None, runs: 5, algorithm: NloptAlgorithm::Slsqp, evaluations: None, checkpoint: None }
    }
}

impl NloptEngine {
    /// What it is, in words.
    pub const ABOUT: EngineAbout = EngineAbout {
        name: "nlopt",
        title: "NLopt's local solvers, as a yardstick (feature `nlopt`)",
        text: "The local solvers of Steven Johnson's NLopt on the same problem. Only in a build with \
               `--features nlopt`, which needs CMake and a C compiler; the library contains code under the \
               LGPL.",
        takes: "every constraint",
        example: r#"{"nlopt": (runs: 5, algorithm: Slsqp)}"#,
        settings: &[
            EngineAbout::LABEL,
            ("runs", "independent runs from random starts"),
            ("algorithm", "Slsqp (gradients, all constraints) or Sbplx (simplex, penalty)"),
            ("evaluations", "most evaluations of a run"),
        ],
    };
}

#[typetag::serde(name = "nlopt")]
impl RetrievalEngine for NloptEngine {
    fn about(&self) -> EngineAbout {
        Self::ABOUT
    }

    fn label(&self) -> &str {
        self.label.as_deref().unwrap_or("nlopt")
    }

    fn available(&self) -> Result<()> {
        solver().map(|_| ())
    }

    fn set_checkpoint(&mut self, checkpoint: Option<Checkpoint>) {
        self.checkpoint = checkpoint;
    }

    fn retrieve(&self, problem: &Problem, watch: &Watch<'_>) -> Result<Retrieved> {
        solver()?(self, problem, watch)
    }
}

/// What solves for the engine.
pub type Solver = fn(&NloptEngine, &Problem, &Watch<'_>) -> Result<Retrieved>;

/// A build either has the solvers or not; this is the one thing in the library that a process sets.
static SOLVER: OnceLock<Solver> = OnceLock::new();

/// Makes the engine available in this process; the first call counts.
pub fn provide(solver: Solver) {
    let _ = SOLVER.set(solver);
}

fn solver() -> Result<Solver> {
    SOLVER.get().copied().ok_or_else(|| {
        Error::new("the engine `nlopt` is not part of this build").help(
            "build with `--features nlopt` (needs CMake and a C compiler; the library it adds is LGPL), \
             or use the engine `penalty`",
        )
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::penalty::testing;

    #[test]
    fn a_build_without_it_says_how_to_get_it() {
        let engine: Box<dyn RetrievalEngine> =
            lacuna_base::text::from_ron(r#"{"nlopt": (algorithm: Sbplx)}"#).expect("known by name");
        let problem = testing::disc();
        let error =
            engine.retrieve(&problem, &|_| std::ops::ControlFlow::Continue(())).expect_err("not there");
        assert!(error.to_string().contains("--features nlopt"), "{error}");
        assert_eq!(engine.available(), Err(error));
    }
}
