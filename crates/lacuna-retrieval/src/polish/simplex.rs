//! Nelder and Mead's simplex method on the penalised objective, in search coordinates.
//!
//! Up to ten coordinates at once; a larger problem is taken group by group, cyclically, as a simplex of
//! seventy corners does not get anywhere.

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;

use super::{Polished, Target};
use crate::space::Parameter;

/// Most coordinates of one simplex.
const MOST: usize = 10;
/// Rounds over all blocks.
const ROUNDS: usize = 12;
/// Iterations of one simplex per coordinate.
const ITERATIONS: u64 = 60;
/// A round that improves by less than this share is the last.
const WORTH: f64 = 1e-6;

/// Improves coordinates `p` for a target.
pub(super) fn run(target: &Target<'_>, p: &[f64], stop: &dyn Fn() -> bool) -> Polished {
    let bounds = &target.problem.chart.space().parameters;
    let blocks = blocks(target);
    let mut p = p.to_vec();
    let mut steps: Vec<f64> = bounds.iter().map(|b| 0.05 * (b.upper - b.lower)).collect();
    let mut evaluations = 1;
    let mut value = cost(target, &p);
    for _ in 0..ROUNDS {
        let before = value;
        for block in &blocks {
            if stop() {
                break;
            }
            evaluations += improve(target, &mut p, block, &steps, &mut value);
        }
        if stop() || before - value <= WORTH * before.abs() {
            break;
        }
        steps.iter_mut().for_each(|s| *s *= 0.5);
    }
    Polished { z: target.problem.chart.unknowns(&p), evaluations }
}

/// Coordinates that are moved together: groups, cut where they are too large.
fn blocks(target: &Target<'_>) -> Vec<Vec<usize>> {
    let space = target.problem.chart.space();
    let free = |i: &usize| space.parameters[*i].upper > space.parameters[*i].lower;
    let all: Vec<usize> = (0..space.len()).filter(free).collect();
    if all.len() <= MOST {
        return vec![all];
    }
    let groups = space.ranges().into_iter().map(|range| range.filter(free).collect::<Vec<_>>());
    groups.flat_map(|g| g.chunks(MOST).map(<[usize]>::to_vec).collect::<Vec<_>>()).collect()
}

/// A finite number however wild the step: the simplex hangs on infinite costs.
fn cost(target: &Target<'_>, p: &[f64]) -> f64 {
    let value = target.value(&target.problem.chart.unknowns(p));
    if value.is_finite() { value } else { 1e300 }
}

struct Block<'a> {
    target: &'a Target<'a>,
    bounds: &'a [Parameter],
    p: &'a [f64],
    members: &'a [usize],
}

impl Block<'_> {
    /// All coordinates with those of the block replaced, within bounds.
    fn whole(&self, x: &[f64]) -> Vec<f64> {
        let mut p = self.p.to_vec();
        for (&i, value) in self.members.iter().zip(x) {
            p[i] = value.clamp(self.bounds[i].lower, self.bounds[i].upper);
        }
        p
    }
}

impl CostFunction for &Block<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        Ok(cost(self.target, &self.whole(x)))
    }
}

/// One simplex over the members of a block; takes its result where that is better.
fn improve(target: &Target<'_>, p: &mut Vec<f64>, members: &[usize], steps: &[f64], value: &mut f64) -> u64 {
    let bounds = &target.problem.chart.space().parameters;
    let start: Vec<f64> = members.iter().map(|&i| p[i]).collect();
    let mut simplex = vec![start.clone()];
    for (k, &i) in members.iter().enumerate() {
        let mut corner = start.clone();
        let inward = if corner[k] + steps[i] > bounds[i].upper { -steps[i] } else { steps[i] };
        corner[k] += inward;
        simplex.push(corner);
    }
    let block = Block { target, bounds, p, members };
    let Ok(solver) = adapted(NelderMead::new(simplex), members.len(), 1e-10 * value.abs()) else { return 0 };
    let most = ITERATIONS * members.len() as u64;
    let Ok(result) = Executor::new(&block, solver).configure(|s| s.max_iters(most)).timer(false).run() else {
        return 0;
    };
    let state = result.state();
    let evaluations = state.get_func_counts().get("cost_count").copied().unwrap_or(0);
    if let Some(found) = state.get_best_param()
        && state.get_best_cost() < *value
    {
        *value = state.get_best_cost();
        *p = block.whole(found);
    }
    evaluations
}

/// Expansion and shrinkage that depend on the dimension (Gao and Han 2012), without which ten coordinates stall.
fn adapted(
    solver: NelderMead<Vec<f64>, f64>,
    dimension: usize,
    tolerance: f64,
) -> Result<NelderMead<Vec<f64>, f64>, argmin::core::Error> {
    let n = dimension.max(2) as f64;
    solver.with_sd_tolerance(tolerance)?.with_gamma(1.0 + 2.0 / n)?.with_sigma(1.0 - 1.0 / n)
}
