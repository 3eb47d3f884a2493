//! Algorithm 1 of Gaz et al. 2019 as printed.

use std::cell::RefCell;

use argmin::core::{CostFunction, Executor};
use argmin::solver::simulatedannealing::{Anneal, SATempFunc, SimulatedAnnealing};
use rand_xoshiro_07::Xoshiro256PlusPlus;
use rand_xoshiro_07::rand_core::SeedableRng;
use serde::{Deserialize, Serialize};

use super::function::PenaltyForm;
use super::runs::{self, Monitor, Plan, judge, random_start};
use crate::catalogue::EngineAbout;
use crate::checkpoint::{Checkpoint, Outcome};
use crate::polish::{Polish, Polisher, Target};
use crate::{Problem, RetrievalEngine, Retrieved, Watch};
use lacuna_base::error::{Error, Result};
use lacuna_base::random::Stream;
use lacuna_base::text::bounds::{Moves, Positive, Runs, Share, Stages};

/// Engine `penalty_paper`: `Q` runs from uniform random starts; `kappa` stages with the penalty's weight
/// `xi = 0, 10, 20, ..`; in each simulated annealing over all coordinates at once, then a polish.
///
/// The paper used Matlab's `simulannealbnd` with `fmincon`. Like the former, a move here has the length of
/// the temperature and a random direction, temperatures fall geometrically and rise again now and then, and
/// moves out of bounds are drawn back between. Unlike the latter, the interior point here resolves the kinks
/// of the penalty by slack variables.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PaperEngine {
    /// The user's name for this entry.
    pub label: Option<String>,
    /// Independent runs (`Q`).
    #[serde(deserialize_with = "Runs::read")]
    pub runs: usize,
    /// Stages of a run (`kappa`).
    #[serde(deserialize_with = "Stages::read")]
    pub stages: usize,
    /// Evaluations of the annealing in each stage.
    #[serde(deserialize_with = "Moves::read")]
    pub evaluations: usize,
    /// Temperature at the start of a stage: of the objective, and of the length of moves.
    #[serde(deserialize_with = "Positive::read")]
    pub temperature: f64,
    /// Factor on the temperature from move to move.
    #[serde(deserialize_with = "Share::read")]
    pub cooling: f64,
    /// Moves after which the temperature returns to its start.
    #[serde(deserialize_with = "Moves::read")]
    pub reanneal: usize,
    /// Measure of a violation.
    pub penalty: PenaltyForm,
    /// What ends each stage.
    pub polish: Polish,
    /// Where finished runs are kept.
    #[serde(skip)]
    pub checkpoint: Option<Checkpoint>,
}

impl Default for PaperEngine {
    fn default() -> Self {
        Self {
            label: None,
            runs: 100,
            stages: 10,
            evaluations: 5000,
            temperature: 100.0,
            cooling: 0.95,
            reanneal: 500,
            penalty: PenaltyForm::Linear,
            polish: Polish::InteriorPoint,
            checkpoint: None,
        }
    }
}

impl PaperEngine {
    /// What it is, in words.
    pub const ABOUT: EngineAbout = EngineAbout {
        name: "penalty_paper",
        title: "the paper's Algorithm 1 to the letter",
        text: "Algorithm 1 of Gaz et al. 2019 as printed: penalty weights 0, 10, 20, .. and annealing over \
               all unknowns at once. To reproduce the paper; `penalty` reaches the same optimum sooner.",
        takes: "every constraint",
        example: r#"{"penalty_paper": (runs: 10, stages: 10)}"#,
        settings: &[
            EngineAbout::LABEL,
            ("runs", "independent runs from random starts, Q in the paper"),
            ("stages", "stages of a run, kappa in the paper"),
            ("evaluations", "evaluations of the annealing in each stage"),
            ("temperature", "temperature at the start of a stage"),
            ("cooling", "factor on the temperature from move to move"),
            ("reanneal", "moves after which the temperature returns to its start"),
            EngineAbout::PENALTY,
            EngineAbout::POLISH,
        ],
    };
}

#[typetag::serde(name = "penalty_paper")]
impl RetrievalEngine for PaperEngine {
    fn about(&self) -> EngineAbout {
        Self::ABOUT
    }

    fn label(&self) -> &str {
        self.label.as_deref().unwrap_or("penalty_paper")
    }

    fn set_checkpoint(&mut self, checkpoint: Option<Checkpoint>) {
        self.checkpoint = checkpoint;
    }

    fn retrieve(&self, problem: &Problem, watch: &Watch<'_>) -> Result<Retrieved> {
        self.outcomes(problem, watch)?.best()
    }
}

impl PaperEngine {
    /// Results of all runs.
    pub(super) fn outcomes<'a>(
        &'a self,
        problem: &'a Problem,
        watch: &'a Watch<'a>,
    ) -> Result<runs::Outcomes> {
        self.check()?;
        let plan = Plan::new(self, (self.runs, self.stages), self.checkpoint.as_ref(), problem, watch)?;
        let polisher = Polisher::new(self.polish, problem);
        runs::all(&plan, |stream, monitor| self.run(problem, &polisher, stream, monitor))
    }

    fn check(&self) -> Result<()> {
        if !(self.temperature > 0.0 && self.temperature.is_finite()) {
            return Err(Error::new("the `temperature` is not positive").help("Matlab starts at 100"));
        }
        if !(self.cooling > 0.0 && self.cooling < 1.0) {
            return Err(Error::new("the factor of `cooling` is not between 0 and 1").help("Matlab uses 0.95"));
        }
        Ok(())
    }

    /// Lines 1 to 7 of the algorithm; `false` when stopped.
    fn run(
        &self,
        problem: &Problem,
        polisher: &Polisher<'_>,
        mut stream: Stream,
        monitor: &Monitor<'_>,
    ) -> (Outcome, bool) {
        let stop = || monitor.stop();
        let mut p = random_start(problem, &mut stream);
        let mut outcome = judge(problem, problem.chart.unknowns(&p), 1);
        for stage in 0..self.stages {
            let target = Target { problem, penalty: self.penalty, weight: 10.0 * stage as f64 };
            let generator = Xoshiro256PlusPlus::seed_from_u64(stream.bits());
            let annealing = Annealing::new(self, &target, &mut stream, p, &stop);
            let (annealed, value, tried) = annealing.run(generator);
            let polished = polisher.run(&target, &annealed, &stop);
            let z = if target.value(&polished.z) < value {
                polished.z
            } else {
                problem.chart.unknowns(&annealed)
            };
            outcome = judge(problem, z, outcome.evaluations + tried + polished.evaluations);
            if stop() {
                return (outcome, false);
            }
            monitor.stage(&outcome);
            p = problem.chart.coordinates(&outcome.z);
        }
        (outcome, true)
    }
}

/// One stage of annealing; argmin holds the temperature and decides on moves.
struct Annealing<'a> {
    engine: &'a PaperEngine,
    target: &'a Target<'a>,
    state: RefCell<State<'a>>,
    stop: &'a dyn Fn() -> bool,
    start: Vec<f64>,
}

/// What changes with every move.
struct State<'a> {
    stream: &'a mut Stream,
    best: Vec<f64>,
    value: f64,
    evaluations: u64,
}

impl<'a> Annealing<'a> {
    fn new(
        engine: &'a PaperEngine,
        target: &'a Target<'a>,
        stream: &'a mut Stream,
        p: Vec<f64>,
        stop: &'a dyn Fn() -> bool,
    ) -> Self {
        let value = target.value(&target.problem.chart.unknowns(&p));
        let state = State { stream, best: p.clone(), value, evaluations: 1 };
        Self { engine, target, state: RefCell::new(state), stop, start: p }
    }

    /// The best coordinates met, their value, and the number of evaluations.
    fn run(self, generator: Xoshiro256PlusPlus) -> (Vec<f64>, f64, u64) {
        let engine = self.engine;
        if engine.evaluations > 0
            && let Ok(solver) = SimulatedAnnealing::new_with_rng(engine.temperature, generator)
        {
            let solver = solver.with_temp_func(SATempFunc::Exponential(engine.cooling));
            let solver = solver.with_reannealing_fixed(engine.reanneal.max(1) as u64);
            let start = self.start.clone();
            let configured = Executor::new(&self, solver)
                .configure(|s| s.param(start).max_iters(engine.evaluations as u64))
                .timer(false);
            // It ends with an error when asked to stop; the best point is kept here, not there.
            let _ = configured.run();
        }
        let state = self.state.into_inner();
        (state.best, state.value, state.evaluations)
    }

    /// The temperature from the rule that it follows: argmin's own has last digits that differ between
    /// processors, as it is a power from the system's library.
    fn snapped(&self, temperature: f64) -> f64 {
        let (start, cooling) = (self.engine.temperature, self.engine.cooling);
        let moves = (libm::log(temperature / start) / libm::log(cooling)).round();
        start * libm::pow(cooling, moves)
    }
}

impl CostFunction for &Annealing<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, p: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        let value = self.target.value(&self.target.problem.chart.unknowns(p));
        let mut state = self.state.borrow_mut();
        state.evaluations += 1;
        if value < state.value {
            state.value = value;
            state.best.clone_from(p);
        }
        Ok(value)
    }
}

impl Anneal for &Annealing<'_> {
    type Param = Vec<f64>;
    type Output = Vec<f64>;
    type Float = f64;

    /// A step as long as the temperature in a random direction; where it leaves the bounds it is put on
    /// them and then drawn back towards where it came from by a random share.
    fn anneal(&self, p: &Vec<f64>, temperature: f64) -> Result<Vec<f64>, argmin::core::Error> {
        if (self.stop)() {
            return Err(argmin::core::Error::msg("stopped"));
        }
        let stream = &mut *self.state.borrow_mut().stream;
        let direction: Vec<f64> = p.iter().map(|_| stream.normal()).collect();
        let length = direction.iter().map(|d| d * d).sum::<f64>().sqrt();
        let step = self.snapped(temperature) / length;
        let bounds = &self.target.problem.chart.space().parameters;
        let moved: Vec<f64> = p.iter().zip(&direction).map(|(p, d)| p + step * d).collect();
        let inside = |(v, b): (&f64, &crate::space::Parameter)| (b.lower..=b.upper).contains(v);
        if moved.iter().zip(bounds).all(inside) {
            return Ok(moved);
        }
        let share = stream.uniform();
        let clamped = moved.iter().zip(bounds).map(|(v, b)| v.clamp(b.lower, b.upper));
        Ok(clamped
            .zip(p)
            .zip(bounds)
            .map(|((v, p), b)| (p + share * (v - p)).clamp(b.lower, b.upper))
            .collect())
    }
}
