//! Independent runs from random starts, in parallel: the same bits on any number of threads.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::prelude::*;
use serde::Serialize;

use crate::checkpoint::{Checkpoint, Origin, Outcome};
use crate::{FEASIBLE, Problem, RetrievalEngine, Retrieved, Step, Watch};
use lacuna_base::error::{Error, Result};
use lacuna_base::random::Stream;
use lacuna_base::text;
use lacuna_base::text::bounds::{Runs, Stages};

/// The caller is asked whether to go on once in so many questions of the solvers.
const ASK_EVERY: usize = 100;
/// A checkpoint is written whenever this share of the runs has been added (and when stopped).
const SAVE_PARTS: usize = 20;
/// Most stages of all runs together.
const MOST_STAGES: usize = 1_000_000;
/// Most numbers that finished runs keep; ten such numbers are some hundred megabytes in checkpoints.
const MOST_KEPT: usize = 10_000_000;

/// What all runs of an engine have in common.
pub struct Plan<'a> {
    /// What is solved.
    pub problem: &'a Problem,
    /// Name of the engine in results.
    pub label: &'a str,
    /// Independent runs.
    pub runs: usize,
    /// Stages of a run.
    pub stages: usize,
    /// What a checkpoint belongs to.
    pub origin: Origin,
    /// Where finished runs are kept.
    pub checkpoint: Option<&'a Checkpoint>,
    /// Told of progress, and asked whether to go on.
    pub watch: &'a Watch<'a>,
}

impl<'a> Plan<'a> {
    /// The plan of an engine that makes `runs` of `stages` each; settings and problem are checked.
    pub fn new<E: RetrievalEngine + Serialize>(
        engine: &'a E,
        (runs, stages): (usize, usize),
        checkpoint: Option<&'a Checkpoint>,
        problem: &'a Problem,
        watch: &'a Watch<'a>,
    ) -> Result<Self> {
        check(problem, runs, stages)?;
        let origin = Origin::new(engine.name(), text::to_ron(engine)?, problem);
        Ok(Self { problem, label: engine.label(), runs, stages, origin, checkpoint, watch })
    }
}

/// Carries word between runs and caller.
pub struct Monitor<'a> {
    watch: &'a Watch<'a>,
    stopped: AtomicBool,
    questions: AtomicUsize,
    stages: usize,
    stages_done: AtomicUsize,
    best: Mutex<Option<Outcome>>,
}

/// Measures a point as the audit does.
pub fn judge(problem: &Problem, z: Vec<f64>, evaluations: u64) -> Outcome {
    let violation = problem.forms.iter().map(|f| f.violation(&z)).fold(0.0, f64::max);
    Outcome { objective: problem.objective.value(&z), violation, z, evaluations }
}

/// Whether `a` is the better result: feasible first, then the objective; among infeasible ones the violation.
pub fn better(a: &Outcome, b: &Outcome) -> bool {
    let rank = |o: &Outcome| {
        if !o.objective.is_finite() {
            (2, 0.0)
        } else if o.violation <= FEASIBLE {
            (0, o.objective)
        } else {
            (1, o.violation)
        }
    };
    rank(a) < rank(b)
}

impl Monitor<'_> {
    /// Whether to stop; asks the caller now and then.
    pub fn stop(&self) -> bool {
        if self.questions.fetch_add(1, Ordering::Relaxed) % ASK_EVERY == ASK_EVERY - 1 {
            self.tell();
        }
        self.stopped.load(Ordering::Relaxed)
    }

    /// Takes note of a stage that has ended at `outcome`.
    pub fn stage(&self, outcome: &Outcome) {
        {
            let mut best = self.best.lock().unwrap_or_else(PoisonError::into_inner);
            if best.as_ref().is_none_or(|b| better(outcome, b)) {
                *best = Some(outcome.clone());
            }
        }
        self.stages_done.fetch_add(1, Ordering::Relaxed);
        self.tell();
    }

    /// Stages that a run did not need.
    pub fn skip(&self, stages: usize) {
        self.stages_done.fetch_add(stages, Ordering::Relaxed);
    }

    fn tell(&self) {
        let (objective, violation) = {
            let best = self.best.lock().unwrap_or_else(PoisonError::into_inner);
            best.as_ref().map_or((f64::INFINITY, f64::INFINITY), |b| (b.objective, b.violation))
        };
        let done = self.stages_done.load(Ordering::Relaxed) as f64 / self.stages.max(1) as f64;
        let step = Step { done: done.min(1.0), objective, violation };
        if (self.watch)(&step) == ControlFlow::Break(()) {
            self.stopped.store(true, Ordering::Relaxed);
        }
    }
}

/// Uniform in the bounds of the search coordinates.
pub fn random_start(problem: &Problem, stream: &mut Stream) -> Vec<f64> {
    problem.chart.space().parameters.iter().map(|p| stream.between(p.lower, p.upper)).collect()
}

/// What a search needs of its settings and of a problem.
fn check(problem: &Problem, runs: usize, stages: usize) -> Result<()> {
    Runs::check("runs", runs)?;
    Stages::check("stages", stages)?;
    let space = problem.chart.space();
    if runs * stages > MOST_STAGES || runs * space.len().max(1) > MOST_KEPT {
        return Err(Error::new(format!("`runs` is {runs}, with {stages} stages and {} unknowns", space.len()))
            .help(format!(
                "runs times stages are at most {MOST_STAGES}, and runs times unknowns, which are kept, {MOST_KEPT}"
            )));
    }
    let sizes = [problem.space.len(), problem.objective.r.ncols()];
    if sizes.iter().any(|&n| n != space.len()) || problem.objective.r.nrows() != problem.objective.d.len() {
        return Err(Error::new("space, chart and objective of the problem differ in size"));
    }
    if let Some(p) = space.parameters.iter().find(|p| p.lower > p.upper) {
        return Err(Error::new(format!(
            "{}: the lower bound {} exceeds the upper {}",
            p.name, p.lower, p.upper
        ))
        .help("swap the two, or widen them"));
    }
    if let Some(p) = space.parameters.iter().find(|p| !(p.lower.is_finite() && p.upper.is_finite())) {
        return Err(Error::new(format!("{} has no finite bounds to draw a start from", p.name))
            .help("add a parameter_bounds constraint for it"));
    }
    let beyond = problem.forms.iter().find(|f| f.support().last().is_some_and(|&i| i >= space.len()));
    beyond.map_or(Ok(()), |f| Err(Error::new(format!("`{}` uses an unknown that is not there", f.label))))
}

/// Makes all runs that no checkpoint has; `one` is given the run's number and its random stream, and says
/// whether it came to its end.
pub fn all(
    plan: &Plan<'_>,
    one: impl Fn(Stream, &Monitor<'_>) -> (Outcome, bool) + Sync,
) -> Result<Outcomes> {
    let mut kept: Vec<Option<Outcome>> = vec![None; plan.runs];
    if let Some(checkpoint) = plan.checkpoint {
        for (run, outcome) in checkpoint.load(plan.label, &plan.origin)? {
            if let Some(slot) = kept.get_mut(run) {
                *slot = Some(outcome);
            }
        }
    }
    let monitor = monitor(plan, &kept);
    let open: Vec<usize> = (0..plan.runs).filter(|&run| kept[run].is_none()).collect();
    let kept = Mutex::new(kept);
    let work = |&run: &usize| -> Result<Option<Outcome>> {
        if monitor.stopped.load(Ordering::Relaxed) {
            return Ok(None);
        }
        let (outcome, finished) = one(Stream::new(plan.problem.seed, run), &monitor);
        if !finished {
            return Ok(Some(outcome));
        }
        let mut kept = kept.lock().unwrap_or_else(PoisonError::into_inner);
        kept[run] = Some(outcome);
        let count = kept.iter().flatten().count();
        if count.is_multiple_of(plan.runs.div_ceil(SAVE_PARTS)) {
            save(plan, &kept).map(|()| None)
        } else {
            Ok(None)
        }
    };
    let partial = open.par_iter().map(work).collect::<Result<Vec<_>>>()?;
    let kept = kept.into_inner().unwrap_or_else(PoisonError::into_inner);
    save(plan, &kept)?;
    let partial = partial.into_iter().flatten().collect();
    Ok(Outcomes {
        runs: plan.runs,
        stages: plan.stages,
        finished: kept.into_iter().flatten().collect(),
        partial,
    })
}

fn monitor<'a>(plan: &Plan<'a>, kept: &[Option<Outcome>]) -> Monitor<'a> {
    let mut best: Option<&Outcome> = None;
    for outcome in kept.iter().flatten() {
        if best.is_none_or(|b| better(outcome, b)) {
            best = Some(outcome);
        }
    }
    Monitor {
        watch: plan.watch,
        stopped: AtomicBool::new(false),
        questions: AtomicUsize::new(0),
        stages: plan.runs * plan.stages,
        stages_done: AtomicUsize::new(kept.iter().flatten().count() * plan.stages),
        best: Mutex::new(best.cloned()),
    }
}

fn save(plan: &Plan<'_>, kept: &[Option<Outcome>]) -> Result<()> {
    plan.checkpoint.map_or(Ok(()), |c| c.save(plan.label, &plan.origin, kept))
}

/// What all runs found, in their order.
#[derive(Debug, Clone)]
pub struct Outcomes {
    runs: usize,
    stages: usize,
    finished: Vec<Outcome>,
    /// Of runs that were stopped.
    partial: Vec<Outcome>,
}

impl Outcomes {
    /// All outcomes, in the order of the runs.
    pub fn iter(&self) -> impl Iterator<Item = &Outcome> {
        self.finished.iter().chain(&self.partial)
    }

    /// The best of all; of equals the first.
    pub fn best(&self) -> Result<Retrieved> {
        let mut best: Option<&Outcome> = None;
        for outcome in self.iter() {
            if best.is_none_or(|b| better(outcome, b)) {
                best = Some(outcome);
            }
        }
        let best = best.ok_or_else(|| Error::new("stopped before the first point was judged"))?;
        let feasible = |o: &&Outcome| o.violation <= FEASIBLE;
        let near = |o: &&Outcome| o.objective <= best.objective + 0.01 * best.objective.abs();
        let finished = self.finished.len();
        let stopped = finished < self.runs;
        let begin = if stopped {
            format!("stopped after {finished} of {} runs", self.runs)
        } else {
            format!("{finished} runs")
        };
        let (good, near) =
            (self.iter().filter(feasible).count(), self.iter().filter(feasible).filter(near).count());
        Ok(Retrieved {
            z: best.z.clone(),
            runs: finished,
            stages: self.stages,
            evaluations: self.iter().map(|o| o.evaluations).sum(),
            status: format!("{begin}: {good} feasible, {near} within 1 % of the best"),
            stopped,
            lower_bound: None,
        })
    }
}
