//! Local improvement of a point that a search has found.

mod interior;
mod simplex;

use serde::{Deserialize, Serialize};

use super::Problem;
use super::penalty::PenaltyForm;
use interior::Interior;

/// Which local method ends a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Polish {
    /// Newton's method on a logarithmic barrier over all forms and bounds.
    #[default]
    InteriorPoint,
    /// Nelder and Mead's simplex on the penalised objective: whole for at most ten coordinates, else group
    /// by group.
    NelderMead,
    /// Nothing.
    None,
}

/// What is to be minimised: objective plus `weight` times the exterior penalty, within the chart's bounds.
#[derive(Debug, Clone, Copy)]
pub struct Target<'a> {
    /// Objective, forms and bounds.
    pub problem: &'a Problem,
    /// Measure of a violation.
    pub penalty: PenaltyForm,
    /// Weight of the penalty; infinite where forms must hold strictly.
    pub weight: f64,
}

/// What a polish found.
#[derive(Debug, Clone, PartialEq)]
pub struct Polished {
    /// The unknowns.
    pub z: Vec<f64>,
    /// Evaluations of objective or constraints.
    pub evaluations: u64,
}

/// A [`Polish`] ready for a problem.
#[derive(Debug)]
pub struct Polisher<'a> {
    which: Polish,
    interior: Interior<'a>,
}

impl<'a> Polisher<'a> {
    /// Prepares what depends on the problem alone.
    pub fn new(which: Polish, problem: &'a Problem) -> Self {
        Self { which, interior: Interior::new(problem) }
    }

    /// Improves search coordinates `p`. The result may be worse where the method does not suit the target
    /// (an interior point cannot see a constant penalty): judge it before use. `stop` is asked often.
    pub fn run(&self, target: &Target<'_>, p: &[f64], stop: &dyn Fn() -> bool) -> Polished {
        match self.which {
            Polish::InteriorPoint => self.interior.run(target, p, stop),
            Polish::NelderMead => simplex::run(target, p, stop),
            Polish::None => Polished { z: target.problem.chart.unknowns(p), evaluations: 0 },
        }
    }
}
