//! NLopt's solvers on a retrieval problem, from random starts.

use std::cell::Cell;

use nlopt::{Algorithm, Nlopt, ObjFn, Target as Goal};

use lacuna_base::Result;
use lacuna_base::random::Stream;
use lacuna_retrieval::checkpoint::Outcome;
use lacuna_retrieval::nlopt::{NloptAlgorithm, NloptEngine};
use lacuna_retrieval::penalty::PenaltyForm;
use lacuna_retrieval::penalty::runs::{self, Monitor, Plan, better, judge, random_start};
use lacuna_retrieval::polish::Target;
use lacuna_retrieval::{Problem, Retrieved, Watch};

/// Scaled margin that constraints are held to, so that the solver's own rounding does not violate them.
const MARGIN: f64 = 1e-8;
/// Relative change of the objective that counts as none.
const CHANGE: f64 = 1e-7;
/// A value that no objective has: it tells the solver that its goal is reached, for it cannot be stopped
/// from within.
const REACHED: f64 = -2.0;

pub(crate) fn retrieve(engine: &NloptEngine, problem: &Problem, watch: &Watch<'_>) -> Result<Retrieved> {
    let plan = Plan::new(engine, (engine.runs, 1), engine.checkpoint.as_ref(), problem, watch)?;
    runs::all(&plan, |stream, monitor| run(engine, problem, stream, monitor))?.best()
}

fn run(
    engine: &NloptEngine,
    problem: &Problem,
    mut stream: Stream,
    monitor: &Monitor<'_>,
) -> (Outcome, bool) {
    let start = random_start(problem, &mut stream);
    let first = judge(problem, problem.chart.unknowns(&start), 1);
    let (p, evaluations) = match engine.algorithm {
        NloptAlgorithm::Slsqp => sequential(engine, problem, start, monitor),
        NloptAlgorithm::Sbplx => simplex(engine, problem, start, monitor),
    };
    let found = judge(problem, problem.chart.unknowns(&p), evaluations);
    let found = if better(&found, &first) { found } else { Outcome { evaluations, ..first } };
    monitor.stage(&found);
    let finished = !monitor.stop();
    (found, finished)
}

/// SLSQP in search coordinates, scaled so that the bounds are 0 and 1 apart.
fn sequential(
    engine: &NloptEngine,
    problem: &Problem,
    start: Vec<f64>,
    monitor: &Monitor<'_>,
) -> (Vec<f64>, u64) {
    let units = Units::new(problem);
    let count = Cell::new(0);
    let stopped = Cell::new(false);
    let objective = |x: &[f64], slope: Option<&mut [f64]>, (): &mut ()| {
        count.set(count.get() + 1);
        stopped.set(monitor.stop());
        if stopped.get() {
            return REACHED;
        }
        let p = units.coordinates(x);
        let z = problem.chart.unknowns(&p);
        if let Some(slope) = slope {
            let gradient = problem.objective.gradient(&z);
            slope.copy_from_slice(&units.pull(&p, gradient.as_slice()));
        }
        problem.objective.value(&z)
    };
    let constraints = |values: &mut [f64], x: &[f64], slopes: Option<&mut [f64]>, (): &mut ()| {
        if stopped.get() {
            return values.fill(REACHED);
        }
        let p = units.coordinates(x);
        let z = problem.chart.unknowns(&p);
        for (value, form) in values.iter_mut().zip(&problem.forms) {
            *value = MARGIN - form.margin(&z) / form.scale;
        }
        if let Some(slopes) = slopes {
            for (row, form) in slopes.chunks_exact_mut(x.len()).zip(&problem.forms) {
                let mut dense = vec![0.0; z.len()];
                form.gradient(&z).1.iter().for_each(|&(i, s)| dense[i] -= s / form.scale);
                row.copy_from_slice(&units.pull(&p, &dense));
            }
        }
    };
    let n = start.len();
    let mut solver = Nlopt::new(Algorithm::Slsqp, n, objective, Goal::Minimize, ());
    let tolerances = vec![0.0; problem.forms.len()];
    let ready = prepare(&mut solver, n, engine.evaluations.unwrap_or(2000))
        && (problem.forms.is_empty()
            || solver.add_inequality_mconstraint(problem.forms.len(), constraints, (), &tolerances).is_ok());
    (ended(solver, ready, &units, &start), count.get())
}

fn simplex(
    engine: &NloptEngine,
    problem: &Problem,
    start: Vec<f64>,
    monitor: &Monitor<'_>,
) -> (Vec<f64>, u64) {
    let units = Units::new(problem);
    let weight = problem.objective.d.norm_squared().max(f64::MIN_POSITIVE);
    let target = Target { problem, penalty: PenaltyForm::Linear, weight };
    let count = Cell::new(0);
    let objective = |x: &[f64], _: Option<&mut [f64]>, (): &mut ()| {
        count.set(count.get() + 1);
        if monitor.stop() {
            return REACHED;
        }
        target.value(&problem.chart.unknowns(&units.coordinates(x)))
    };
    let n = start.len();
    let mut solver = Nlopt::new(Algorithm::Sbplx, n, objective, Goal::Minimize, ());
    let ready = prepare(&mut solver, n, engine.evaluations.unwrap_or(200_000));
    (ended(solver, ready, &units, &start), count.get())
}

/// Runs a solver from `start`, if it is ready; the search coordinates where it ended.
fn ended<F: ObjFn<()>>(solver: Nlopt<F, ()>, ready: bool, units: &Units<'_>, start: &[f64]) -> Vec<f64> {
    let mut x = units.scaled(start);
    if ready {
        // Rounding may end it with an error at the optimum; the point is judged either way.
        let _ = solver.optimize(&mut x);
    }
    units.coordinates(&x)
}

/// Bounds and limits; `false` when the solver refuses one.
fn prepare<F: ObjFn<()>>(solver: &mut Nlopt<F, ()>, size: usize, evaluations: u32) -> bool {
    solver.set_lower_bounds(&vec![0.0; size]).is_ok()
        && solver.set_upper_bounds(&vec![1.0; size]).is_ok()
        && solver.set_maxeval(evaluations).is_ok()
        && solver.set_ftol_rel(CHANGE).is_ok()
        && solver.set_stopval(0.5 * REACHED).is_ok()
}

/// Search coordinates in units of their bounds' distance.
struct Units<'a> {
    problem: &'a Problem,
    lower: Vec<f64>,
    width: Vec<f64>,
}

impl<'a> Units<'a> {
    fn new(problem: &'a Problem) -> Self {
        let all = &problem.chart.space().parameters;
        let lower = all.iter().map(|p| p.lower).collect();
        Self { problem, lower, width: all.iter().map(|p| p.upper - p.lower).collect() }
    }

    fn coordinates(&self, x: &[f64]) -> Vec<f64> {
        x.iter()
            .zip(self.lower.iter().zip(&self.width))
            .map(|(x, (l, w))| l + x.clamp(0.0, 1.0) * w)
            .collect()
    }

    fn scaled(&self, p: &[f64]) -> Vec<f64> {
        let unit = |(p, (l, w)): (&f64, (&f64, &f64))| if *w > 0.0 { (p - l) / w } else { 0.0 };
        p.iter().zip(self.lower.iter().zip(&self.width)).map(unit).collect()
    }

    /// Derivatives with respect to scaled coordinates from those with respect to unknowns, by central
    /// differences of the chart.
    fn pull(&self, p: &[f64], gradient: &[f64]) -> Vec<f64> {
        let chart = &self.problem.chart;
        let mut result = vec![0.0; p.len()];
        for (group, range) in chart.space().ranges().into_iter().enumerate() {
            let mut moved = p[range.clone()].to_vec();
            let (mut above, mut below) = (vec![0.0; moved.len()], vec![0.0; moved.len()]);
            for k in range.clone() {
                let (at, h) = (k - range.start, 1e-5 * self.width[k].max(1e-9));
                moved[at] = p[k] + h;
                chart.group_to_unknowns(group, &moved, &mut above);
                moved[at] = p[k] - h;
                chart.group_to_unknowns(group, &moved, &mut below);
                moved[at] = p[k];
                let change = above.iter().zip(&below).zip(&gradient[range.clone()]);
                let slope: f64 = change.map(|((a, b), g)| g * (a - b)).sum::<f64>() / (2.0 * h);
                result[k] = slope * self.width[k];
            }
        }
        result
    }
}
