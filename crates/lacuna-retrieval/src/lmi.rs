//! The engine `lmi`: linear matrix inequalities. Where every constraint is convex, the problem is a
//! semidefinite program (Wensing, Kim and Slotine 2018; Sousa and Cortesão 2014) and its optimum is global.

use std::ops::ControlFlow;

use serde::{Deserialize, Serialize};

use super::catalogue::EngineAbout;
use super::certificate::{lower_bound, taken};
use super::cone::{Effort, Ending, Outcome, Program};
use super::conflict::conflict;
use super::{FEASIBLE, Multiplier, Problem, Quadratic, RetrievalEngine, Retrieved, Step, Watch};
use crate::form::{Affine, Body, Form};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{Iterations, Share};

/// Iterations a solve usually takes, for the progress shown.
const USUAL_ITERATIONS: f64 = 25.0;
/// Relative precision to which two rows count as each other's negative.
const SAME: f64 = 1e-14;

/// Minimises the objective over all convex forms with an interior-point method (clarabel).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct LmiEngine {
    /// The user's name for this entry of the study.
    pub label: Option<String>,
    /// Relative gap and feasibility at which the solver stops.
    #[serde(deserialize_with = "Share::read")]
    pub tolerance: f64,
    /// Iterations at most.
    #[serde(deserialize_with = "Iterations::read")]
    pub iterations: u32,
    /// Every constraint is kept at least this far from its limit, relative to its scale, so that rounding
    /// cannot push the answer over it; left out where constraints have no interior.
    #[serde(deserialize_with = "Share::read")]
    pub margin: f64,
}

impl Default for LmiEngine {
    fn default() -> Self {
        Self { label: None, tolerance: 1e-10, iterations: 200, margin: 1e-9 }
    }
}

/// What the solver gave, before it is judged.
#[derive(Debug, Clone, PartialEq)]
pub struct LmiSolution {
    /// The unknowns.
    pub z: Vec<f64>,
    /// One multiplier per convex form, in the order of [`taken`]; up to a common positive factor.
    pub multipliers: Vec<Multiplier>,
    /// How it ended, for people.
    pub status: String,
    /// Interior-point iterations.
    pub iterations: u32,
    /// Whether it was asked to stop.
    pub stopped: bool,
    /// The margin that was kept, relative to each form's scale.
    pub margin: f64,
}

impl LmiEngine {
    /// Solves the convex part of the problem: all convex forms, and what the others imply.
    ///
    /// # Errors
    /// When the settings are out of range, numbers are not finite, or the convex forms contradict each
    /// other; the message names a smallest conflicting set.
    pub fn solve(&self, problem: &Problem, watch: &Watch<'_>) -> Result<LmiSolution> {
        self.check()?;
        let forms = taken(&problem.forms);
        let mut margin = self.margin;
        let (mut outcome, mut places) = self.attempt(problem, &forms, margin, watch)?;
        if outcome.ending == Ending::Infeasible && margin > 0.0 {
            margin = 0.0;
            (outcome, places) = self.attempt(problem, &forms, margin, watch)?;
        }
        if outcome.ending == Ending::Infeasible {
            return Err(match conflict(problem.space.len(), &problem.forms)? {
                Some(conflict) => conflict.into_error(),
                None => Error::new(format!("engine `lmi`: the solver ended with {}", outcome.status))
                    .help("the constraints leave hardly any room: widen the narrowest of them"),
            });
        }
        let mut z = outcome.x[..problem.space.len()].to_vec();
        if z.iter().any(|v| !v.is_finite()) {
            return Err(Error::new(format!("engine `lmi`: the solver broke down ({})", outcome.status))
                .help(
                    "bring the numbers of objective and constraints to similar sizes, or loosen `tolerance`",
                ));
        }
        repair(&mut z, &forms)?;
        Ok(LmiSolution {
            z,
            multipliers: multipliers(&forms, &places, &outcome.duals),
            status: outcome.status,
            iterations: outcome.iterations,
            stopped: outcome.ending == Ending::Stopped,
            margin,
        })
    }

    fn check(&self) -> Result<()> {
        let in_range =
            self.tolerance > 0.0 && self.tolerance < 1.0 && self.margin >= 0.0 && self.margin < 1.0;
        if in_range && self.iterations > 0 {
            return Ok(());
        }
        Err(Error::new("engine `lmi`: `tolerance` and `margin` lie below 1 and are not negative, `tolerance` and `iterations` not 0")
            .help("leave them out: tolerance 1e-10, margin 1e-9, 200 iterations"))
    }

    fn attempt(
        &self,
        problem: &Problem,
        forms: &[&Form],
        margin: f64,
        watch: &Watch<'_>,
    ) -> Result<(Outcome, Vec<Place>)> {
        let mut program = Program::new(problem.space.len());
        let distance = program.unknown();
        program.cost = vec![(distance, 1.0)];
        misfit(&mut program, &problem.objective, Affine::variable(distance));
        let places = constrain(&mut program, forms, &Affine::constant(margin));
        let mut tell = |iteration: u32| {
            let done = f64::from(iteration) / USUAL_ITERATIONS;
            let unknown = f64::INFINITY;
            let step = Step { done: done.min(0.95), objective: unknown, violation: unknown };
            watch(&step) == ControlFlow::Continue(())
        };
        let effort = Effort { tolerance: self.tolerance, iterations: self.iterations };
        Ok((program.solve(effort, Some(&mut tell))?, places))
    }
}

impl LmiEngine {
    /// What it is, in words.
    pub const ABOUT: EngineAbout = EngineAbout {
        name: "lmi",
        title: "global optimum under convex constraints, with a certified bound",
        text: "Linear matrix inequalities solved by an interior-point method (Wensing, Kim and Slotine 2018; \
               Sousa and Cortesao 2014). Milliseconds, no random draws, and a certified lower bound on what \
               any engine can reach.",
        takes: "convex constraints; of others it takes what they imply, and the audit shows the rest",
        example: r#"{"lmi": (tolerance: 1e-10)}"#,
        settings: &[
            EngineAbout::LABEL,
            ("tolerance", "relative gap and feasibility at which the solver stops"),
            ("iterations", "iterations at most"),
            ("margin", "distance kept from every limit, relative to its scale"),
        ],
    };
}

#[typetag::serde(name = "lmi")]
impl RetrievalEngine for LmiEngine {
    fn about(&self) -> EngineAbout {
        Self::ABOUT
    }

    fn label(&self) -> &str {
        self.label.as_deref().unwrap_or("lmi")
    }

    fn accepts(&self, form: &Form) -> Result<(), String> {
        match &form.body {
            Body::General { why, .. } => Err(format!("no cone expresses it: {why}")),
            _ => Ok(()),
        }
    }

    fn retrieve(&self, problem: &Problem, watch: &Watch<'_>) -> Result<Retrieved> {
        let solution = self.solve(problem, watch)?;
        let certificate = lower_bound(problem, &taken(&problem.forms), &solution.multipliers)?;
        let audit = super::audit(problem, &solution.z);
        // Nothing is left to stop.
        let _ = watch(&Step { done: 1.0, objective: audit.objective, violation: audit.violation });
        let within = if certificate.within_search_bounds {
            "; the forms leave some unknowns open, so the bound holds within the search bounds"
        } else {
            ""
        };
        Ok(Retrieved {
            runs: 1,
            stages: 1,
            evaluations: u64::from(solution.iterations),
            status: format!("{} after {} iterations{within}", solution.status, solution.iterations),
            stopped: solution.stopped,
            lower_bound: Some(certificate.lower_bound),
            z: solution.z,
        })
    }
}

/// `|r z - d| <= bound` with both sides divided by the data's size: the bound is a part of it.
pub(super) fn misfit(program: &mut Program, objective: &Quadratic, bound: Affine) {
    program.second_order(bound, misfit_rows(objective));
}

/// `r z - d`, divided by the data's size.
pub(super) fn misfit_rows(objective: &Quadratic) -> Vec<Affine> {
    let scale = misfit_scale(objective);
    let row = |k: usize| {
        let r = objective.r.row(k);
        let terms = r.iter().enumerate().filter(|(_, f)| f.abs() > 0.0).map(|(i, f)| (i, f / scale));
        Affine { terms: terms.collect(), constant: -objective.d[k] / scale }
    };
    (0..objective.d.len()).map(row).collect()
}

/// Size of the data, in which misfits are measured.
pub(super) fn misfit_scale(objective: &Quadratic) -> f64 {
    let size = objective.d.norm();
    if size > 0.0 { size } else { 1.0 }
}

/// Where the solver's dual of a form stands.
#[derive(Debug, Clone, Copy)]
pub(super) struct Place {
    /// Number of the block.
    pub block: usize,
    /// An equality's dual is free: this sign of it belongs to the form. `None`: the whole dual does.
    sign: Option<f64>,
}

/// All forms, each with `margin` times its scale to spare; pairs that make an equality have none to spare.
/// Where each one's dual will stand.
pub(super) fn constrain(program: &mut Program, forms: &[&Form], margin: &Affine) -> Vec<Place> {
    let partner = equalities(forms);
    let mut places: Vec<Place> = Vec::with_capacity(forms.len());
    for (i, form) in forms.iter().enumerate() {
        let block = program.blocks();
        let place = match (&form.body, partner[i]) {
            // The other side of an equality that is there already; counted once if repeated.
            (_, Some(other)) if other < i => {
                let first = partner[other] == Some(i);
                Place { block: places[other].block, sign: Some(if first { -1.0 } else { 0.0 }) }
            }
            (Body::Affine(row), Some(_)) => {
                program.zero(row.clone());
                Place { block, sign: Some(1.0) }
            }
            _ => {
                program.form(form, margin);
                Place { block, sign: None }
            }
        };
        places.push(place);
    }
    places
}

/// For every form the one that is its negative, so that both together are an equality.
pub(super) fn equalities(forms: &[&Form]) -> Vec<Option<usize>> {
    let sorted: Vec<Option<Vec<(usize, f64)>>> = forms
        .iter()
        .map(|form| {
            let Body::Affine(row) = &form.body else { return None };
            let mut terms: Vec<(usize, f64)> =
                row.terms.iter().copied().filter(|t| t.1.abs() > 0.0).collect();
            terms.sort_unstable_by_key(|t| t.0);
            terms.push((usize::MAX, row.constant));
            Some(terms)
        })
        .collect();
    let opposite = |a: &[(usize, f64)], b: &[(usize, f64)]| {
        a.len() == b.len()
            && a.len() > 1
            && a.iter().zip(b).all(|(x, y)| x.0 == y.0 && (x.1 + y.1).abs() <= SAME * x.1.abs())
    };
    let partner = |i: usize| {
        let mine = sorted[i].as_ref()?;
        (0..forms.len()).find(|&k| sorted[k].as_ref().is_some_and(|other| opposite(mine, other)))
    };
    (0..forms.len()).map(partner).collect()
}

/// The solver's duals, one per form: an equality's free multiplier falls to the side that it presses on.
fn multipliers(forms: &[&Form], places: &[Place], duals: &[Vec<f64>]) -> Vec<Multiplier> {
    let values = |place: &Place| {
        let dual = &duals[place.block];
        place.sign.map_or_else(|| dual.clone(), |sign| vec![(sign * dual[0]).max(0.0)])
    };
    let of =
        |(form, place): (&&Form, &Place)| Multiplier { label: form.label.clone(), values: values(place) };
    forms.iter().zip(places).map(of).collect()
}

/// The point deepest inside all forms: maximises the least scaled margin, up to 1. `None` when there is none
/// with a positive margin.
pub(super) fn interior(
    unknowns: usize,
    forms: &[&Form],
    more: impl FnOnce(&mut Program, usize),
) -> Result<Option<Vec<f64>>> {
    let mut program = Program::new(unknowns);
    let depth = program.unknown();
    program.cost = vec![(depth, -1.0)];
    program.nonnegative(Affine::constant(1.0).plus(-1.0, &Affine::variable(depth)));
    constrain(&mut program, forms, &Affine::variable(depth));
    more(&mut program, depth);
    let outcome = program.solve(Effort::default(), None)?;
    let deep = outcome.ending != Ending::Infeasible && outcome.x[depth] > 0.0;
    Ok(deep.then(|| outcome.x[..unknowns].to_vec()))
}

/// Moves a point that rounding left outside towards the inside, as little as makes it feasible. Margins of
/// convex forms are concave, so the way is a straight line.
pub(super) fn repair(z: &mut [f64], forms: &[&Form]) -> Result<()> {
    let worst = |z: &[f64]| forms.iter().map(|f| f.violation(z)).fold(0.0, f64::max);
    let outside = worst(z);
    if outside <= 0.5 * FEASIBLE || outside.is_infinite() {
        return Ok(());
    }
    let Some(inside) = interior(z.len(), forms, |_, _| {})? else { return Ok(()) };
    let start = z.to_vec();
    for power in -40..=0 {
        let part = libm::exp2(f64::from(power));
        for ((z, a), b) in z.iter_mut().zip(&start).zip(&inside) {
            *z = a + part * (b - a);
        }
        if worst(z) <= 0.5 * FEASIBLE {
            return Ok(());
        }
    }
    z.copy_from_slice(&start);
    Ok(())
}
