//! A smooth convex function over the inside of forms, minimised by Newton's method with a logarithmic
//! barrier (Boyd and Vandenberghe 2004, chapter 11).

use nalgebra::{DMatrix, DVector};

use super::Problem;
use super::lmi::{equalities, misfit_rows};
use super::prior::{BodyMatrix, log_determinant};
use crate::form::{Affine, Body, Form, matrix};

/// The path stops when the barrier's pull is below this (in the unit of the function: nats).
const GAP: f64 = 1e-6;
/// Growth of the function's weight along the path.
const GROWTH: f64 = 20.0;
/// What may be left to gain where rounding ends the path before.
const ENOUGH: f64 = 1e-4;
/// Newton steps in all.
const STEPS: usize = 2000;
/// Newton steps per weight: more are needed only where rounding leads astray.
const STEPS_PER_WEIGHT: usize = 100;
/// Square of Newton's length up to which a point counts as a centre.
const CENTRED: f64 = 0.1;
/// Square of Newton's length below which full steps converge (Nesterov and Nemirovskii 1994).
const NEAR: f64 = 0.05;
/// Full steps at most, each of which squares the error.
const FULL_STEPS: usize = 5;
/// Unknowns beyond this run away.
const FARTHEST: f64 = 1e9;
/// They also do where the path gets stuck after they have grown by this factor.
const GROWN: f64 = 1e3;

/// `|r z - d| <= radius` and forms as barriers, bodies' matrices as function.
pub(super) struct Barrier<'a> {
    forms: Vec<&'a Form>,
    /// Directions that keep the equalities; `None` where there are none.
    free: Option<DMatrix<f64>>,
    bodies: &'a [BodyMatrix],
    inverses: &'a [Option<DMatrix<f64>>],
    misfit: Body,
    unknowns: usize,
}

/// Where the minimisation ended.
pub(super) struct Minimum {
    pub z: Vec<f64>,
    pub steps: usize,
    pub ending: PathEnd,
}

/// How the path ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum PathEnd {
    /// At the minimum, to the gap.
    Settled,
    /// Rounding or the number of steps ended it before.
    Stuck,
    /// There is no minimum.
    RunAway,
}

/// Value, gradient and Hessian of one sum.
struct Model {
    value: f64,
    gradient: DVector<f64>,
    hessian: DMatrix<f64>,
}

impl Model {
    fn add(&mut self, weight: f64, row: &[(usize, f64)]) {
        row.iter().for_each(|&(i, f)| self.gradient[i] += weight * f);
    }

    fn add_square(&mut self, weight: f64, a: &[(usize, f64)]) {
        for &(i, f) in a {
            for &(j, g) in a {
                self.hessian[(i, j)] += weight * f * g;
            }
        }
    }
}

impl<'a> Barrier<'a> {
    pub fn new(
        problem: &Problem,
        forms: &[&'a Form],
        allowance: f64,
        bodies: &'a [BodyMatrix],
        inverses: &'a [Option<DMatrix<f64>>],
    ) -> Self {
        let unknowns = problem.space.len();
        let rows = misfit_rows(&problem.objective);
        let pairs = equalities(forms);
        let fixed: Vec<&Affine> = forms
            .iter()
            .zip(&pairs)
            .filter_map(|(form, pair)| match &form.body {
                Body::Affine(row) if pair.is_some() => Some(row),
                _ => None,
            })
            .collect();
        let open = forms.iter().zip(&pairs).filter(|(_, pair)| pair.is_none()).map(|(form, _)| *form);
        Self {
            forms: open.collect(),
            free: (!fixed.is_empty()).then(|| kernel(unknowns, &fixed)),
            bodies,
            inverses,
            misfit: Body::Norm { rows, bound: Affine::constant(allowance) },
            unknowns,
        }
    }

    /// What is minimised, at `z`.
    pub fn score(&self, z: &[f64]) -> f64 {
        let of = |(body, inverse): (&BodyMatrix, &Option<DMatrix<f64>>)| {
            let p = matrix(body.size, &body.lower, z);
            let trace = inverse.as_ref().map_or(0.0, |inverse| inverse.dot(&p));
            Some(trace - log_determinant(&p.cholesky()?.l()))
        };
        self.bodies.iter().zip(self.inverses).filter_map(of).sum()
    }

    /// Number of barriers: the gap is this over the weight.
    fn degree(&self) -> f64 {
        let of = |body: &Body| match body {
            Body::Affine(_) => 1.0,
            Body::Norm { .. } => 2.0,
            Body::Psd { size, .. } => *size as f64,
            Body::General { .. } => 0.0,
        };
        self.forms.iter().map(|f| of(&f.body)).sum::<f64>() + of(&self.misfit)
    }

    /// `weight * function + barriers`; `None` outside. Derivatives only where asked for.
    fn at(&self, weight: f64, z: &[f64], derivatives: bool) -> Option<Model> {
        let n = if derivatives { self.unknowns } else { 0 };
        let mut model = Model { value: 0.0, gradient: DVector::zeros(n), hessian: DMatrix::zeros(n, n) };
        for body in self.forms.iter().map(|f| &f.body).chain([&self.misfit]) {
            match body {
                Body::Affine(row) => logarithm(&mut model, row, z, derivatives)?,
                Body::Norm { rows, bound } => norm(&mut model, rows, bound, z, derivatives)?,
                Body::Psd { size, lower } => determinant(&mut model, 1.0, (*size, lower), z, derivatives)?,
                Body::General { .. } => {}
            }
        }
        for (body, inverse) in self.bodies.iter().zip(self.inverses) {
            determinant(&mut model, weight, (body.size, &body.lower), z, derivatives)?;
            let Some(inverse) = inverse else { continue };
            for (i, j) in (0..body.size).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                let row = &body.lower[i * (i + 1) / 2 + j];
                let factor = weight * inverse[(i, j)] * if i == j { 1.0 } else { 2.0 };
                model.value += factor * row.at(z);
                if derivatives {
                    model.add(factor, &row.terms);
                }
            }
        }
        model.value.is_finite().then_some(model)
    }

    /// Newton's step in the free directions, and the square of its length in the Hessian's measure.
    fn step(&self, model: &Model) -> Option<(DVector<f64>, f64)> {
        let (mut hessian, gradient) = match &self.free {
            None => (model.hessian.clone(), model.gradient.clone()),
            Some(free) => {
                (product(&product(&free.transpose(), &model.hessian), free), free.tr_mul(&model.gradient))
            }
        };
        // Unknowns that nothing sees stay where they are.
        let largest = hessian.diagonal().max();
        for i in 0..hessian.nrows() {
            let own = hessian[(i, i)];
            hessian[(i, i)] += (1e-15 * own).max(1e-30 * largest);
        }
        let step = -hessian.cholesky()?.solve(&gradient);
        let length = -step.dot(&gradient);
        Some((
            match &self.free {
                None => step,
                Some(free) => free * step,
            },
            length,
        ))
    }
}

/// `-log(row)`.
fn logarithm(model: &mut Model, row: &Affine, z: &[f64], derivatives: bool) -> Option<()> {
    let a = row.at(z);
    if a.is_nan() || a <= 0.0 {
        return None;
    }
    model.value -= libm::log(a);
    if derivatives {
        model.add(-1.0 / a, &row.terms);
        model.add_square(1.0 / (a * a), &row.terms);
    }
    Some(())
}

/// `-log(bound² - |rows|²)`.
fn norm(model: &mut Model, rows: &[Affine], bound: &Affine, z: &[f64], derivatives: bool) -> Option<()> {
    let (b, values) = (bound.at(z), rows.iter().map(|r| r.at(z)).collect::<Vec<f64>>());
    let length = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    // Factored: the difference of squares would lose digits near the edge.
    let room = (b - length) * (b + length);
    if room.is_nan() || room <= 0.0 || b <= 0.0 {
        return None;
    }
    model.value -= libm::log(room);
    if derivatives {
        let slope =
            rows.iter().zip(&values).fold(bound.clone().times(2.0 * b), |s, (r, v)| s.plus(-2.0 * v, r));
        model.add(-1.0 / room, &slope.terms);
        model.add_square(1.0 / (room * room), &slope.terms);
        model.add_square(-2.0 / room, &bound.terms);
        rows.iter().for_each(|r| model.add_square(2.0 / room, &r.terms));
    }
    Some(())
}

/// `-weight log det` of an affine matrix.
fn determinant(
    model: &mut Model,
    weight: f64,
    (size, lower): (usize, &[Affine]),
    z: &[f64],
    derivatives: bool,
) -> Option<()> {
    let factor = matrix(size, lower, z).cholesky()?;
    model.value -= weight * log_determinant(&factor.l());
    if !derivatives {
        return Some(());
    }
    let inverse = factor.inverse();
    // For every unknown the matrix that it multiplies, from both triangles.
    let mut slopes: Vec<(usize, DMatrix<f64>)> = Vec::new();
    for (i, j) in (0..size).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        for &(unknown, f) in &lower[i * (i + 1) / 2 + j].terms {
            let at = slopes.iter().position(|s| s.0 == unknown).unwrap_or_else(|| {
                slopes.push((unknown, DMatrix::zeros(size, size)));
                slopes.len() - 1
            });
            slopes[at].1[(i, j)] += f;
            if i != j {
                slopes[at].1[(j, i)] += f;
            }
        }
    }
    let turned: Vec<(usize, DMatrix<f64>)> = slopes.iter().map(|(u, s)| (*u, product(&inverse, s))).collect();
    for (u, a) in &turned {
        model.gradient[*u] -= weight * a.trace();
        for (v, b) in &turned {
            model.hessian[(*u, *v)] += weight * a.dot(&b.transpose());
        }
    }
    Some(())
}

/// Follows the path from a point strictly inside; `None` when the start is not.
pub(super) fn minimise(barrier: &Barrier<'_>, start: Vec<f64>) -> Option<Minimum> {
    let size = |z: &[f64]| z.iter().fold(1.0, |most: f64, v| most.max(v.abs()));
    let far = GROWN * size(&start);
    let mut at = Minimum { z: start, steps: 0, ending: PathEnd::Stuck };
    let mut weight = 1.0;
    // The best centre so far and what may be left to gain there.
    let mut best = (f64::INFINITY, at.z.clone());
    barrier.at(weight, &at.z, false)?;
    loop {
        let left = centre(barrier, weight, &mut at);
        if at.z.iter().any(|v| v.abs() > FARTHEST) {
            at.ending = PathEnd::RunAway;
            return Some(at);
        }
        // Near a centre half the square of Newton's length is what is left, in units of 1 / weight.
        let gap = (barrier.degree() + left) / weight;
        if left < CENTRED && gap < best.0 {
            best = (gap, at.z.clone());
        }
        if barrier.degree() / weight < GAP || at.steps >= STEPS {
            let ending = match best.0 < ENOUGH {
                true => PathEnd::Settled,
                false if size(&at.z) > far => PathEnd::RunAway,
                false => PathEnd::Stuck,
            };
            return Some(Minimum { z: best.1, steps: at.steps, ending });
        }
        weight *= GROWTH;
    }
}

/// Newton's method for one weight; the square of Newton's last length.
fn centre(barrier: &Barrier<'_>, weight: f64, found: &mut Minimum) -> f64 {
    let (mut left, mut near) = (f64::INFINITY, 0);
    let last = (found.steps + STEPS_PER_WEIGHT).min(STEPS);
    while let Some(model) = barrier.at(weight, &found.z, true) {
        let Some((step, length)) = barrier.step(&model) else { break };
        left = length;
        if length.is_nan() || length < 1e-10 || near >= FULL_STEPS || found.steps >= last {
            break;
        }
        let next = if length < NEAR {
            near += 1;
            // Full steps stay inside here and square the error; the value is too coarse a judge.
            let full: Vec<f64> = found.z.iter().zip(&step).map(|(z, s)| z + s).collect();
            barrier.at(weight, &full, false).map(|_| full)
        } else {
            search(barrier, weight, &found.z, &model, (&step, length))
        };
        let Some(next) = next else { break };
        found.z = next;
        found.steps += 1;
        if found.z.iter().any(|v| v.abs() > FARTHEST) {
            break;
        }
    }
    left
}

/// The first of the steps 1, 1/2, 1/4 ... that stays inside and gains enough.
fn search(
    barrier: &Barrier<'_>,
    weight: f64,
    z: &[f64],
    model: &Model,
    (step, length): (&DVector<f64>, f64),
) -> Option<Vec<f64>> {
    let mut part = 1.0;
    while part > 1e-12 {
        let next: Vec<f64> = z.iter().zip(step).map(|(z, s)| z + part * s).collect();
        let gained =
            barrier.at(weight, &next, false).is_some_and(|m| m.value <= model.value - 0.1 * part * length);
        if gained {
            return Some(next);
        }
        part *= 0.5;
    }
    None
}

/// Orthonormal directions along which no row changes.
fn kernel(unknowns: usize, rows: &[&Affine]) -> DMatrix<f64> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let push = |mut v: DVector<f64>, basis: &mut Vec<DVector<f64>>| {
        let size = v.norm();
        for _ in 0..2 {
            for b in basis.iter() {
                let part = b.dot(&v);
                v.axpy(-part, b, 1.0);
            }
        }
        let left = v.norm();
        // An axis keeps little of its length when the basis nearly spans it: others will do.
        if left > 1e-6 * size {
            basis.push(v / left);
        }
    };
    for row in rows {
        let mut v = DVector::zeros(unknowns);
        row.terms.iter().for_each(|&(i, f)| v[i] += f);
        push(v, &mut basis);
    }
    let fixed = basis.len();
    for i in 0..unknowns {
        push(DVector::from_fn(unknowns, |k, _| if k == i { 1.0 } else { 0.0 }), &mut basis);
    }
    DMatrix::from_columns(&basis[fixed..])
}

/// `a b` by plain sums: the library's product fuses on some processors.
fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), b.ncols(), |i, j| (0..a.ncols()).map(|k| a[(i, k)] * b[(k, j)]).sum())
}
