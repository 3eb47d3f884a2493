//! Interior point: Newton's method on the objective plus a logarithmic barrier over all forms and bounds.
//!
//! Affine, norm and semidefinite forms have their self-concordant barriers, so on convex problems the end is
//! the global optimum up to a known gap; a general form enters with the Gauss-Newton part of its barrier.
//! A start that violates forms is led inside first by minimising one slack that relaxes them all.

mod bounds;
mod cholesky;
mod equalities;
mod newton;
mod program;
mod terms;

use newton::Newton;
use program::{Program, Relaxation, Squares};

use super::{Polished, Target};
use crate::Problem;
use crate::form::Form;
use crate::penalty::PenaltyForm;

/// Gap to the optimum at the end, relative to the objective.
const GAP: f64 = 1e-6;
/// Gap at the end for objectives that vanish, relative to the size of the data.
const LEAST: f64 = 1e-15;
/// How far from the bounds a start is kept, relative to their distance.
const INSET: f64 = 1e-3;

/// The solver; keeps what depends on the problem alone.
#[derive(Debug)]
pub(super) struct Interior<'a> {
    problem: &'a Problem,
    squares: Squares<'a>,
}

impl<'a> Interior<'a> {
    pub(super) fn new(problem: &'a Problem) -> Self {
        Self { problem, squares: Squares::new(&problem.objective) }
    }

    /// Improves coordinates `p` for a target.
    pub(super) fn run(&self, target: &Target<'_>, p: &[f64], stop: &dyn Fn() -> bool) -> Polished {
        let z = self.problem.chart.unknowns(&inset(self.problem, p));
        let forms: Vec<&Form> = self.problem.forms.iter().collect();
        let weight = target.weight;
        match target.penalty {
            _ if weight.is_infinite() => self.strict(&forms, z, stop),
            // Almost everywhere a constant penalty is flat: a polish does not see it.
            PenaltyForm::Linear if weight > 0.0 => self.relaxed(&forms, z, [weight, 0.0], stop),
            PenaltyForm::Squared if weight > 0.0 => self.relaxed(&forms, z, [0.0, weight], stop),
            _ => self.follow(&self.program(&[], Relaxation::None), z, stop),
        }
    }

    fn program(&self, forms: &[&Form], relaxation: Relaxation) -> Program<'_> {
        Program::new(&self.squares, self.problem.chart.as_ref(), forms, relaxation)
    }

    /// All forms hold strictly at the end, or the point is returned that comes nearest to that.
    fn strict(&self, forms: &[&Form], z: Vec<f64>, stop: &dyn Fn() -> bool) -> Polished {
        let (z, evaluations, inside) = self.first_point(forms, z, stop);
        if !inside {
            return Polished { z, evaluations };
        }
        let mut polished = self.follow(&self.program(forms, Relaxation::None), z, stop);
        polished.evaluations += evaluations;
        polished
    }

    /// Phase 1: minimises the slack that all forms need until they hold without it.
    fn first_point(&self, forms: &[&Form], z: Vec<f64>, stop: &dyn Fn() -> bool) -> (Vec<f64>, u64, bool) {
        let program = self.program(forms, Relaxation::Shared);
        let n = program.unknowns();
        let (z, before) = self.onto_equations(&program, z, stop);
        if Newton::new(&self.program(forms, Relaxation::None), z.clone()).is_some() {
            return (z, before, true);
        }
        let worst = forms.iter().map(|f| -f.margin(&z) / f.scale).fold(0.0, f64::max);
        let slack = 1.1 * worst + 1e-9;
        let mut x = z.clone();
        x.push(slack);
        let Some(mut newton) = Newton::new(&program, x) else { return (z, before, false) };
        let enough = -(0.1 * slack).min(1e-4);
        let mut asked = false;
        newton.follow(
            slack / program.degree(),
            |_| 1e-9 * slack.min(1.0),
            |x| {
                asked = stop();
                x[n] < enough || asked
            },
        );
        let inside = newton.x[n] < 0.0 && !asked;
        newton.x.truncate(n);
        (std::mem::take(&mut newton.x), before + newton.evaluations, inside)
    }

    /// Moves `z` within the bounds until the equations hold, then onto them to the last digit.
    fn onto_equations(&self, program: &Program<'_>, z: Vec<f64>, stop: &dyn Fn() -> bool) -> (Vec<f64>, u64) {
        let equalities = program.equalities();
        if equalities.is_empty() {
            return (z, 0);
        }
        let defect = equalities.defect();
        let squares = Squares::new(&defect);
        let bounds = program.within_bounds(&squares);
        let Some(mut newton) = Newton::new(&bounds, z.clone()) else { return (z, 1) };
        let start = bounds.cost(&z).max(f64::MIN_POSITIVE);
        newton.follow(start / bounds.degree(), |_| 1e-16 * start, |_| stop());
        let mut z = std::mem::take(&mut newton.x);
        equalities.project(&mut z);
        (z, newton.evaluations)
    }

    /// The exterior penalty as a smooth program: one slack per form.
    fn relaxed(&self, forms: &[&Form], z: Vec<f64>, cost: [f64; 2], stop: &dyn Fn() -> bool) -> Polished {
        let [linear, square] = cost;
        let program = self.program(forms, Relaxation::Each { linear, square });
        let mut x = z.clone();
        x.extend(forms.iter().map(|f| (-1.1 * f.margin(&z) / f.scale).max(0.0) + 1e-3));
        let mut polished = self.follow(&program, x, stop);
        polished.z.truncate(program.unknowns());
        polished
    }

    fn follow(&self, program: &Program<'_>, x: Vec<f64>, stop: &dyn Fn() -> bool) -> Polished {
        let least = LEAST * self.problem.objective.d.norm_squared().max(f64::MIN_POSITIVE);
        let start = program.cost(&x).max(least);
        let Some(mut newton) = Newton::new(program, x.clone()) else {
            return Polished { z: x, evaluations: 1 };
        };
        newton.follow(start / program.degree(), |cost| (GAP * cost).max(least), |_| stop());
        Polished { z: newton.x, evaluations: newton.evaluations }
    }
}

/// Coordinates moved off their bounds.
fn inset(problem: &Problem, p: &[f64]) -> Vec<f64> {
    let inside = |(value, about): (&f64, &crate::space::Parameter)| {
        let width = about.upper - about.lower;
        value.clamp(about.lower + INSET * width, about.upper - INSET * width)
    };
    p.iter().zip(&problem.chart.space().parameters).map(inside).collect()
}
