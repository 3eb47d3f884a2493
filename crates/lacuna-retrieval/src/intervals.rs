//! What data and constraints determine: for each quantity the smallest and the largest value among all
//! feasible points that are nearly as good as the best.

use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::certificate::taken;
use super::cone::{Effort, Ending, Outcome, Program};
use super::lmi::{constrain, misfit, misfit_scale};
use super::{Problem, Quadratic};
use crate::form::{Affine, Form};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::NotNegative;

/// Tolerances tried in turn where a solve stalls.
const TOLERANCES: [f64; 3] = [1e-9, 1e-7, 1e-6];

/// How much worse than the best a point may be and still count as equally good.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Slack {
    /// Share of the best objective.
    #[serde(deserialize_with = "NotNegative::read")]
    pub relative: f64,
    /// On top, in the unit of the objective: `s² q` with the residual variance `s²` and a quantile `q` of
    /// the chi-squared distribution makes the set a confidence region.
    #[serde(deserialize_with = "NotNegative::read")]
    pub absolute: f64,
}

impl Default for Slack {
    fn default() -> Self {
        Self { relative: 1e-3, absolute: 1e-12 }
    }
}

impl Slack {
    /// Whether both numbers are finite and not negative.
    pub fn is_usable(&self) -> bool {
        [self.relative, self.absolute].iter().all(|x| x.is_finite() && *x >= 0.0)
    }

    /// The largest objective that counts as equally good.
    pub fn level(&self, best: f64) -> f64 {
        best + self.relative * best.abs() + self.absolute
    }
}

/// A quantity whose range is asked for: `numerator`, or `numerator / denominator`.
#[derive(Debug, Clone, PartialEq)]
pub struct Quantity {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// A linear function of the unknowns.
    pub numerator: Affine,
    /// What it is divided by, and the least value of that at which the ratio has a meaning (positive).
    pub denominator: Option<(Affine, f64)>,
}

/// The range of a quantity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Interval {
    /// Name of the quantity.
    pub parameter: String,
    /// Smallest value; `None` where there is no bound, or the solver found none.
    pub low: Option<f64>,
    /// Largest value; `None` where there is no bound, or the solver found none.
    pub high: Option<f64>,
    /// Unit.
    pub unit: String,
}

/// The range of every quantity over `{forms hold, objective <= level}`, from the convex forms; where others
/// were left out the ranges may be too wide, never too narrow (to the solver's accuracy, 1e-9 of the data's
/// size). In parallel; the result does not depend on the number of threads.
///
/// # Errors
/// When no point is as good as `level`, or numbers are not finite.
pub fn intervals(problem: &Problem, level: f64, quantities: &[Quantity]) -> Result<Vec<Interval>> {
    let forms = taken(&problem.forms);
    quantities
        .par_iter()
        .map(|quantity| {
            let end = |sign: f64| end(problem, &forms, level, quantity, sign);
            let (low, high) = (end(1.0)?, end(-1.0)?);
            Ok(Interval { parameter: quantity.name.clone(), low, high, unit: quantity.unit.clone() })
        })
        .collect()
}

/// The distance `|r z - d|` that `level` leaves, as a part of the data's size.
///
/// # Errors
/// When no parameters at all reach the level.
pub(super) fn allowance(objective: &Quadratic, level: f64) -> Result<f64> {
    let squares = level - objective.floor;
    if squares > 0.0 && squares.is_finite() {
        return Ok(squares.sqrt() / misfit_scale(objective));
    }
    Err(Error::new(format!("no parameters have an objective of {level:e}"))
        .help("give a level above the best objective, for example by a slack of 1e-3"))
}

/// Smallest value of `sign * quantity`, times `sign`.
fn end(
    problem: &Problem,
    forms: &[&Form],
    level: f64,
    quantity: &Quantity,
    sign: f64,
) -> Result<Option<f64>> {
    let mut program = Program::new(problem.space.len());
    misfit(&mut program, &problem.objective, Affine::constant(allowance(&problem.objective, level)?));
    constrain(&mut program, forms, &Affine::constant(0.0));
    let value = match &quantity.denominator {
        None => quantity.numerator.clone(),
        Some((denominator, least)) => ratio(&mut program, &quantity.numerator, denominator, *least),
    };
    program.cost = value.terms.iter().map(|&(i, f)| (i, sign * f)).collect();
    let outcome = solve(&program)?;
    match outcome.ending {
        Ending::Solved | Ending::Nearly => Ok(Some(value.at(&outcome.x))),
        Ending::Unbounded | Ending::Stopped | Ending::Early => Ok(None),
        // The best point proves that the set is not empty, so the ratio has no meaning anywhere in it.
        Ending::Infeasible if quantity.denominator.is_some() => Ok(None),
        Ending::Infeasible => {
            Err(Error::new(format!("no feasible parameters have an objective of {level:e}"))
                .help("give a level above the best objective, for example by a slack of 1e-3"))
        }
    }
}

/// Turns the unknowns `z` into `z / denominator` and adds `1 / denominator` as one more (Charnes and Cooper
/// 1962): the ratio becomes linear and the set stays convex.
fn ratio(program: &mut Program, numerator: &Affine, denominator: &Affine, least: f64) -> Affine {
    let inverse = program.unknown();
    let over = |row: &Affine| {
        let mut row = row.clone();
        row.terms.push((inverse, std::mem::take(&mut row.constant)));
        row
    };
    program.homogenise(inverse);
    program.zero(over(denominator).plus(1.0, &Affine::constant(-1.0)));
    program.nonnegative(Affine::variable(inverse));
    program.nonnegative(Affine::constant(1.0 / least).plus(-1.0, &Affine::variable(inverse)));
    over(numerator)
}

fn solve(program: &Program) -> Result<Outcome> {
    let attempt = |tolerance| program.solve(Effort { tolerance, ..Effort::default() }, None);
    let mut outcome = attempt(TOLERANCES[0])?;
    for tolerance in &TOLERANCES[1..] {
        if !matches!(outcome.ending, Ending::Early | Ending::Nearly) {
            break;
        }
        outcome = attempt(*tolerance)?;
    }
    Ok(outcome)
}
