//! Which of many equally good answers: the data leave some directions open, and somebody has to choose. The
//! choice is the user's, and the report says that the choice decided it.

use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::barrier::{Barrier, PathEnd, minimise};
use super::certificate::taken;
use super::cone::{Effort, Ending, Program};
use super::intervals::allowance;
use super::lmi::{constrain, interior, misfit, repair};
use super::{Problem, audit};
use crate::form::{Affine, Body, Form, matrix};
use lacuna_base::error::{Error, Result};

/// Distance that the smallest answer keeps from every limit, relative to its scale.
const MARGIN: f64 = 1e-9;
/// Steps along tangents at most.
const ROUNDS: usize = 20;
/// Gain, in parts of the score, below which they end.
const SETTLED: f64 = 1e-6;

/// What decides between equally good answers.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum TieBreak {
    /// Nearest to these unknowns (values from a drawing, say): the smallest sum over the bodies' matrices of
    /// `tr(P0⁻¹ P) - log det(P0⁻¹ P) - size`, the log-determinant divergence of Lee, Wensing and Park
    /// (2019). It does not depend on units or frames.
    Nearest {
        /// The prior unknowns `z0`; every body's matrix must be positive definite there.
        prior: Vec<f64>,
    },
    /// The largest product of the determinants: mass spread as widely and evenly over the bodies as data and
    /// constraints allow (for a normal distribution of mass, the largest entropy).
    Uniform,
    /// The smallest sum of traces: least mass plus least second moment about the frames' origins, in SI
    /// units.
    Smallest,
}

/// A symmetric matrix that is affine in the unknowns and stands for a body: a link's pseudo-inertia.
#[derive(Debug, Clone, PartialEq)]
pub struct BodyMatrix {
    /// The body's name, for messages.
    pub name: String,
    /// Number of rows.
    pub size: usize,
    /// Lower triangle by rows.
    pub lower: Vec<Affine>,
}

impl BodyMatrix {
    /// That it is one: positive semidefinite.
    fn form(&self) -> Form {
        let body = Body::Psd { size: self.size, lower: self.lower.clone() };
        Form::new(self.name.clone(), "", 1.0, body)
    }
}

/// The answer that a [`TieBreak`] chose.
#[derive(Debug, Clone, PartialEq)]
pub struct Chosen {
    /// The unknowns: they satisfy all forms, and their objective is at most the level asked for.
    pub z: Vec<f64>,
    /// What the tie-break minimises, there: divergence, minus the log-determinants, or the traces.
    pub score: f64,
    /// Newton steps made.
    pub steps: usize,
    /// Whether no other point is better; where forms are not convex a better one may exist elsewhere.
    pub global: bool,
}

/// The feasible point that `choice` prefers among all whose objective is at most `level`.
///
/// Where forms are not convex and their relaxation's answer violates one, the choice is improved step by step
/// from the feasible point `start`, each step keeping to the tangents of those forms (the convex-concave
/// procedure, Yuille and Rangarajan 2003).
///
/// # Errors
/// When a prior body is not physical, the set has no interior (no room to choose), or is unbounded in the
/// direction that the choice prefers.
pub fn choose(
    problem: &Problem,
    bodies: &[BodyMatrix],
    level: f64,
    start: &[f64],
    choice: &TieBreak,
) -> Result<Chosen> {
    let within = Within { problem, bodies, level };
    let convex = taken(&problem.forms);
    let relaxed = within.choose(&convex, choice)?;
    if audit(problem, &relaxed.z).feasible {
        return Ok(relaxed);
    }
    let mut best: Option<Chosen> = None;
    for _ in 0..ROUNDS {
        let at = best.as_ref().map_or(start, |b| &b.z);
        let tangents: Vec<Form> =
            problem.forms.iter().filter(|f| !f.is_convex()).map(|f| tangent(f, at)).collect();
        let forms: Vec<&Form> = convex.iter().copied().chain(&tangents).collect();
        let Ok(next) = within.choose(&forms, choice) else { break };
        let gain = best.as_ref().map_or(f64::INFINITY, |b| b.score - next.score);
        if !audit(problem, &next.z).feasible || gain <= SETTLED * (1.0 + next.score.abs()) {
            break;
        }
        best = Some(Chosen { global: false, ..next });
    }
    best.ok_or_else(|| {
        Error::new("the choice breaks a constraint that no cone expresses, and no step towards it keeps them")
            .help("bound the parameter that breaks it more tightly, or keep the optimum as it is")
    })
}

/// The form's tangent at `z`, to be kept not negative.
fn tangent(form: &Form, z: &[f64]) -> Form {
    let (margin, slopes) = form.gradient(z);
    let at: f64 = slopes.iter().map(|&(i, slope)| slope * z[i]).sum();
    let row = Affine { terms: slopes, constant: margin - at };
    Form::affine(form.label.clone(), form.unit.clone(), form.scale, row)
}

/// What is chosen from.
struct Within<'a> {
    problem: &'a Problem,
    bodies: &'a [BodyMatrix],
    level: f64,
}

impl Within<'_> {
    fn choose(&self, forms: &[&Form], choice: &TieBreak) -> Result<Chosen> {
        match choice {
            TieBreak::Smallest => self.smallest(forms),
            TieBreak::Uniform => self.balanced(forms, &vec![None; self.bodies.len()]),
            TieBreak::Nearest { prior } => self.nearest(forms, prior),
        }
    }

    fn nearest(&self, forms: &[&Form], prior: &[f64]) -> Result<Chosen> {
        if prior.len() != self.problem.space.len() {
            let (given, wanted) = (prior.len(), self.problem.space.len());
            return Err(Error::new(format!("the prior has {given} values, the problem {wanted} unknowns"))
                .help("take the prior from a file of the same robot"));
        }
        let inverses = self.bodies.iter().map(|body| inverse_at(body, prior)).collect::<Result<Vec<_>>>()?;
        let mut chosen = self.balanced(forms, &inverses)?;
        // What the barrier leaves out: log det P0 - size.
        for (body, inverse) in self.bodies.iter().zip(inverses.iter().flatten()) {
            let log_det = inverse.clone().cholesky().map_or(0.0, |f| -log_determinant(&f.l()));
            chosen.score += log_det - body.size as f64;
        }
        Ok(chosen)
    }

    fn smallest(&self, forms: &[&Form]) -> Result<Chosen> {
        let traces = self.bodies.iter().fold(Affine::default(), |sum, body| {
            (0..body.size).fold(sum, |sum, k| sum.plus(1.0, &body.lower[k * (k + 3) / 2]))
        });
        let mut program = Program::new(self.problem.space.len());
        // A little less than allowed, for the solver's rounding.
        let allowance = (1.0 - MARGIN.sqrt()) * allowance(&self.problem.objective, self.level)?;
        misfit(&mut program, &self.problem.objective, Affine::constant(allowance));
        constrain(&mut program, forms, &Affine::constant(MARGIN));
        program.cost.clone_from(&traces.terms);
        let outcome = program.solve(Effort { tolerance: 1e-9, ..Effort::default() }, None)?;
        match outcome.ending {
            Ending::Infeasible => Err(no_room(self.level)),
            Ending::Unbounded => Err(unbounded()),
            _ => {
                let mut z = outcome.x[..self.problem.space.len()].to_vec();
                repair(&mut z, forms)?;
                Ok(Chosen { score: traces.at(&z), z, steps: outcome.iterations as usize, global: true })
            }
        }
    }

    /// Minimises `sum tr(inverse P) - log det P`.
    fn balanced(&self, forms: &[&Form], inverses: &[Option<DMatrix<f64>>]) -> Result<Chosen> {
        let problem = self.problem;
        let allowance = allowance(&problem.objective, self.level)?;
        // The logarithm wants bodies, whether a constraint does or not.
        let bodies: Vec<Form> = self.bodies.iter().map(BodyMatrix::form).collect();
        let wanted: Vec<&Form> = forms.iter().copied().chain(&bodies).collect();
        let start = interior(problem.space.len(), &wanted, |program, depth| {
            // The depth is at most 1, so half of the room at least is left.
            let room = Affine::constant(allowance).plus(-0.5 * allowance, &Affine::variable(depth));
            misfit(program, &problem.objective, room);
        })?;
        let start = start.ok_or_else(|| no_room(self.level))?;
        let barrier = Barrier::new(problem, forms, allowance, self.bodies, inverses);
        let found = minimise(&barrier, start).ok_or_else(|| no_room(self.level))?;
        match found.ending {
            PathEnd::Settled => {
                Ok(Chosen { score: barrier.score(&found.z), z: found.z, steps: found.steps, global: true })
            }
            PathEnd::RunAway => Err(unbounded()),
            PathEnd::Stuck => Err(Error::new(format!(
                "the choice between equally good parameters did not settle in {} steps",
                found.steps
            ))
            .help("allow a larger slack: the set to choose from is very thin")),
        }
    }
}

/// Inverse of a body's matrix at the prior unknowns.
fn inverse_at(body: &BodyMatrix, prior: &[f64]) -> Result<Option<DMatrix<f64>>> {
    let p0 = matrix(body.size, &body.lower, prior);
    let factor = p0.clone().cholesky().filter(|_| p0.iter().all(|v| v.is_finite()));
    let factor = factor.ok_or_else(|| {
        let name = &body.name;
        Error::new(format!(
            "the prior of `{name}` is not a body: its pseudo-inertia is not positive definite"
        ))
        .help("give it mass and an inertia with all three principal moments below the sum of the other two")
    })?;
    Ok(Some(factor.inverse()))
}

/// Logarithm of the determinant of `L Lᵀ`.
pub(super) fn log_determinant(factor: &DMatrix<f64>) -> f64 {
    factor.diagonal().iter().map(|d| 2.0 * libm::log(*d)).sum()
}

fn no_room(level: f64) -> Error {
    Error::new(format!("the parameters with an objective of at most {level:e} leave no room to choose from"))
        .help("allow a larger slack, or keep the optimum as it is")
}

fn unbounded() -> Error {
    Error::new("the choice between equally good parameters has no end: masses or inertias are not bounded")
        .help("add a range of masses and of inertias to the constraints")
}
