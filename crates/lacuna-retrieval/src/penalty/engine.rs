//! Our default: Algorithm 1 of Gaz et al. 2019 with cheap coordinate moves, adaptive widths and a polish
//! that knows the constraints.

use serde::{Deserialize, Serialize};

use super::anneal::{Schedule, anneal};
use super::function::PenaltyForm;
use super::runs::{self, Monitor, Plan, better, judge, random_start};
use super::walk::{Ground, Walk};
use crate::catalogue::EngineAbout;
use crate::checkpoint::{Checkpoint, Outcome};
use crate::form::Form;
use crate::polish::{Polish, Polisher, Target};
use crate::{FEASIBLE, Problem, RetrievalEngine, Retrieved, Watch};
use lacuna_base::error::Result;
use lacuna_base::random::Stream;
use lacuna_base::text::bounds::{Moves, Runs, Stages};

/// A stage that improves the objective by less than this share is the last.
const WORTH: f64 = 1e-4;
/// An objective below this share of the data's squares counts as zero.
const ZERO: f64 = 1e-13;
/// Growth of the penalty's weight from stage to stage.
const GROWTH: f64 = 10.0;
/// Further random points that are polished after the first stage where the feasible set may be in parts.
const ELSEWHERE: usize = 16;

/// Engine `penalty`: from random starts within the bounds, simulated annealing by coordinate moves on
/// objective plus penalty, then a polish within the constraints; stage after stage until nothing improves.
/// Where a constraint is none that a cone expresses, the first stage also polishes further random points.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PenaltyEngine {
    /// The user's name for this entry.
    pub label: Option<String>,
    /// Independent runs (`Q`).
    #[serde(deserialize_with = "Runs::read")]
    pub runs: usize,
    /// Most stages of a run (`kappa`).
    #[serde(deserialize_with = "Stages::read")]
    pub stages: usize,
    /// Moves tried in each stage.
    #[serde(deserialize_with = "Moves::read")]
    pub proposals: usize,
    /// Measure of a violation while annealing.
    pub penalty: PenaltyForm,
    /// What ends each stage.
    pub polish: Polish,
    /// Where finished runs are kept.
    #[serde(skip)]
    pub checkpoint: Option<Checkpoint>,
}

impl Default for PenaltyEngine {
    fn default() -> Self {
        Self {
            label: None,
            runs: 20,
            stages: 4,
            proposals: 30_000,
            penalty: PenaltyForm::Linear,
            polish: Polish::InteriorPoint,
            checkpoint: None,
        }
    }
}

impl PenaltyEngine {
    /// What it is, in words.
    pub const ABOUT: EngineAbout = EngineAbout {
        name: "penalty",
        title: "random starts, annealing with penalties, polish",
        text: "Algorithm 1 of Gaz et al. 2019 with cheap coordinate moves and a polish that knows the \
               constraints. The one to start with, and the only kind where constraints are not convex. It \
               finds no proof that its answer is the best; the spread over its runs is a hint, and `lmi` on \
               the same problem gives a bound.",
        takes: "every constraint",
        example: r#"{"penalty": (runs: 20, stages: 4)}"#,
        settings: &[
            EngineAbout::LABEL,
            ("runs", "independent runs from random starts, Q in the paper"),
            ("stages", "most stages of a run, kappa in the paper"),
            ("proposals", "moves tried in each stage"),
            EngineAbout::PENALTY,
            EngineAbout::POLISH,
        ],
    };
}

#[typetag::serde(name = "penalty")]
impl RetrievalEngine for PenaltyEngine {
    fn about(&self) -> EngineAbout {
        Self::ABOUT
    }

    fn label(&self) -> &str {
        self.label.as_deref().unwrap_or("penalty")
    }

    fn set_checkpoint(&mut self, checkpoint: Option<Checkpoint>) {
        self.checkpoint = checkpoint;
    }

    fn retrieve(&self, problem: &Problem, watch: &Watch<'_>) -> Result<Retrieved> {
        let plan = Plan::new(self, (self.runs, self.stages), self.checkpoint.as_ref(), problem, watch)?;
        let ground = Ground::new(problem);
        let polisher = Polisher::new(self.polish, problem);
        runs::all(&plan, |stream, monitor| {
            Search { engine: self, ground: &ground, polisher: &polisher, monitor, stream }.run()
        })?
        .best()
    }
}

/// One run.
struct Search<'a> {
    engine: &'a PenaltyEngine,
    ground: &'a Ground<'a>,
    polisher: &'a Polisher<'a>,
    monitor: &'a Monitor<'a>,
    stream: Stream,
}

impl<'a> Search<'a> {
    /// All stages; `false` when stopped.
    fn run(mut self) -> (Outcome, bool) {
        let (problem, stages) = (self.ground.problem(), self.engine.stages);
        let start = random_start(problem, &mut self.stream);
        let mut best = judge(problem, problem.chart.unknowns(&start), 1);
        let mut p = start;
        for stage in 0..stages {
            let found = self.stage(stage, p, &best);
            let before = best.objective;
            let was_feasible = best.violation <= FEASIBLE;
            keep(&mut best, found);
            if stage == 0 {
                self.elsewhere(&mut best);
            }
            let idle = was_feasible && before - best.objective <= WORTH * before.abs();
            if self.monitor.stop() {
                return (best, false);
            }
            self.monitor.stage(&best);
            if (stage > 0 && idle) || vanishes(problem, &best) {
                self.monitor.skip(stages - stage - 1);
                break;
            }
            p = problem.chart.coordinates(&best.z);
        }
        (best, true)
    }

    /// Polishes other random points, where forms that no cone expresses may cut the feasible set into parts:
    /// annealing freezes in one of them, and no later shake leaves it.
    fn elsewhere(&mut self, best: &mut Outcome) {
        let problem = self.ground.problem();
        if problem.forms.iter().all(Form::is_convex) || self.engine.polish == Polish::None {
            return;
        }
        let stop = || self.monitor.stop();
        let target = self.target(weight(problem));
        for _ in 0..ELSEWHERE {
            if vanishes(problem, best) || stop() {
                break;
            }
            let start = random_start(problem, &mut self.stream);
            let polished = self.polisher.run(&target, &start, &stop);
            keep(best, judge(problem, polished.z, polished.evaluations));
        }
    }

    /// What a polish minimises. A simplex needs a slope to follow where constraints are violated; an
    /// interior point has its own.
    fn target(&self, weight: f64) -> Target<'a> {
        let strict = if self.engine.polish == Polish::InteriorPoint { f64::INFINITY } else { weight };
        Target { problem: self.ground.problem(), penalty: self.engine.penalty, weight: strict }
    }

    /// Anneals from `p`, then polishes; returns the better of the two ends.
    fn stage(&mut self, stage: usize, p: Vec<f64>, best: &Outcome) -> Outcome {
        let (problem, engine) = (self.ground.problem(), self.engine);
        let stop = || self.monitor.stop();
        let weight = weight(problem) * libm::pow(GROWTH, stage as f64);
        let mut walk = Walk::new(self.ground, engine.penalty, weight, p);
        let schedule =
            schedule(stage, walk.value(), best.objective - problem.objective.floor, engine.proposals);
        let bounds = &problem.chart.space().parameters;
        let tried = anneal(&mut walk, bounds, schedule, &mut self.stream, &stop);
        let annealed = judge(problem, problem.chart.unknowns(walk.coordinates()), tried);
        let polished = self.polisher.run(&self.target(weight), walk.coordinates(), &stop);
        let polished = judge(problem, polished.z, polished.evaluations);
        let evaluations = annealed.evaluations + polished.evaluations;
        let found = if better(&polished, &annealed) { polished } else { annealed };
        Outcome { evaluations, ..found }
    }
}

/// The better of the two, and the evaluations of both.
fn keep(best: &mut Outcome, found: Outcome) {
    let evaluations = best.evaluations + found.evaluations;
    if better(&found, best) {
        *best = found;
    }
    best.evaluations = evaluations;
}

/// The first stage begins as hot as its start is bad; later ones shake the best point found.
fn schedule(stage: usize, value: f64, best: f64, proposals: usize) -> Schedule {
    let hot = if stage == 0 { 0.02 * value } else { 0.3 * best }.max(f64::MIN_POSITIVE);
    let cold = if stage == 0 { 1e-9 } else { 1e-4 } * hot;
    Schedule { hot, cold, proposals }
}

/// Whether nothing is left of the objective that any search could take away.
fn vanishes(problem: &Problem, best: &Outcome) -> bool {
    let above = best.objective - problem.objective.floor;
    best.violation <= FEASIBLE && above <= ZERO * problem.objective.d.norm_squared()
}

/// Size of the data: what a violation of 1 costs in the first stage.
fn weight(problem: &Problem) -> f64 {
    let squares = problem.objective.d.norm_squared();
    if squares > 0.0 { squares } else { 1.0 }
}
