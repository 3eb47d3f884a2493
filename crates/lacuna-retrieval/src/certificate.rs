//! A lower bound that nobody has to believe: recomputed from the multipliers, whatever solver made them.
//!
//! For multipliers in their cones every feasible `z` has `sum <y, form(z)> = gᵀz + c >= 0`, so with any
//! vector `w` and any `s >= 0`
//!
//! ```text
//! |r z - d|² >= 2 wᵀ(r z - d) - |w|² - s (gᵀz + c) = (2 rᵀw - s g)ᵀ z - 2 wᵀd - |w|² - s c.
//! ```
//!
//! Multipliers are projected to their cones, `w` is the least-squares solution of `2 rᵀw = s g`, and what
//! remains of the bracket is charged with bounds on `z` that follow from the forms themselves. So the
//! bound holds however early the solver stopped; it is only weaker then.

use nalgebra::{DMatrix, DVector, SymmetricEigen};

use super::{Multiplier, Problem, Quadratic};
use crate::form::{Affine, Body, Form, matrix};
use lacuna_base::error::{Error, Result};

/// Relative rounding error charged on every sum: some 64 times that of one operation.
const ROUNDING: f64 = 64.0 * f64::EPSILON;
/// Part of the objective's size below which a direction counts as not seen.
const UNSEEN: f64 = 1e-11;

/// What a lower bound holds for.
#[derive(Debug, Clone, Copy, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum BoundIs {
    /// The problem itself.
    Exact,
    /// The problem without the forms that no cone expresses; its optimum may lie below the true one.
    Relaxation,
}

/// A lower bound on the objective over everything the forms allow.
#[derive(Debug, Clone, PartialEq)]
pub struct Certificate {
    /// No feasible point has a smaller objective.
    pub lower_bound: f64,
    /// What it holds for.
    pub bound_is: BoundIs,
    /// What the multipliers' inexactness cost, in the unit of the objective's root.
    pub charge: f64,
    /// Whether bounds of the search coordinates were needed where the forms leave `z` unbounded: then it holds within
    /// those bounds only.
    pub within_search_bounds: bool,
}

/// The convex forms: those of the problem, and those that the others imply, in order.
pub fn taken(forms: &[Form]) -> Vec<&Form> {
    let mut all = Vec::new();
    for form in forms {
        match &form.body {
            Body::General { implied, .. } => all.extend(taken(implied)),
            _ => all.push(form),
        }
    }
    all
}

/// Recomputes the bound from `multipliers` of `forms`, one each, known up to a common positive factor.
///
/// # Errors
/// When the multipliers do not belong to the forms.
pub fn lower_bound(problem: &Problem, forms: &[&Form], multipliers: &[Multiplier]) -> Result<Certificate> {
    let n = problem.space.len();
    let combined = Combination::new(n, forms, multipliers)?;
    let (reach, within_search_bounds) = reach(problem, forms);
    let (bound, charge) = best(&problem.objective, &combined, &reach);
    let general = problem.forms.iter().any(|f| !f.is_convex());
    Ok(Certificate {
        lower_bound: bound,
        bound_is: if general { BoundIs::Relaxation } else { BoundIs::Exact },
        charge,
        within_search_bounds: within_search_bounds && charge > 0.0,
    })
}

/// `gᵀz + c`: not negative wherever the forms hold.
struct Combination {
    g: DVector<f64>,
    /// Sum of the sizes of what `g` is the sum of.
    size: DVector<f64>,
    c: f64,
}

impl Combination {
    fn new(n: usize, forms: &[&Form], multipliers: &[Multiplier]) -> Result<Self> {
        let mut sum = Self { g: DVector::zeros(n), size: DVector::zeros(n), c: 0.0 };
        if forms.len() != multipliers.len() {
            return Err(Error::new(format!("{} multipliers for {} forms", multipliers.len(), forms.len())));
        }
        for (form, multiplier) in forms.iter().zip(multipliers) {
            let y = project(form, &multiplier.values).ok_or_else(|| {
                Error::new(format!("the multiplier of `{}` does not have its shape", form.label))
            })?;
            match &form.body {
                Body::Affine(row) => sum.add(y[0], row),
                Body::Norm { rows, bound } => {
                    sum.add(y[0], bound);
                    rows.iter().zip(&y[1..]).for_each(|(row, &y)| sum.add(y, row));
                }
                Body::Psd { size, lower } => {
                    for (i, j) in (0..*size).flat_map(|i| (0..=i).map(move |j| (i, j))) {
                        let k = i * (i + 1) / 2 + j;
                        sum.add(if i == j { y[k] } else { 2.0 * y[k] }, &lower[k]);
                    }
                }
                Body::General { .. } => {}
            }
        }
        Ok(sum)
    }

    fn add(&mut self, y: f64, row: &Affine) {
        for &(i, factor) in &row.terms {
            self.g[i] += y * factor;
            self.size[i] += (y * factor).abs();
        }
        // Rounding goes to the safe side: a larger constant gives a smaller bound.
        self.c += y * row.constant + ROUNDING * (y * row.constant).abs();
    }
}

/// The nearest multiplier in the form's cone, in the same layout; `None` when it has another shape. A
/// multiplier that is not finite counts as 0.
fn project(form: &Form, y: &[f64]) -> Option<Vec<f64>> {
    let y: Vec<f64> = if y.iter().all(|v| v.is_finite()) { y.to_vec() } else { vec![0.0; y.len()] };
    match &form.body {
        Body::Affine(_) => (y.len() == 1).then(|| vec![y[0].max(0.0)]),
        Body::Norm { rows, .. } => (y.len() == rows.len() + 1).then(|| {
            let length = y[1..].iter().map(|v| v * v).sum::<f64>().sqrt() * (1.0 + ROUNDING);
            // Raising the first entry is always enough.
            let mut y = y;
            y[0] = y[0].max(length);
            y
        }),
        Body::Psd { size, lower } => (y.len() == lower.len()).then(|| {
            let rows: Vec<Affine> = y.iter().map(|&v| Affine::constant(v)).collect();
            let eigen = SymmetricEigen::new(matrix(*size, &rows, &[]));
            let largest = eigen.eigenvalues.iter().fold(0.0, |m: f64, v| m.max(v.abs()));
            // A hair more than zero, so that rounding in the product below stays inside the cone.
            let values = eigen.eigenvalues.map(|v| v.max(ROUNDING * largest));
            let v = &eigen.eigenvectors;
            let entry = |i: usize, j: usize| (0..*size).map(|k| v[(i, k)] * values[k] * v[(j, k)]).sum();
            (0..*size).flat_map(|i| (0..=i).map(move |j| (i, j))).map(|(i, j)| entry(i, j)).collect()
        }),
        Body::General { .. } => None,
    }
}

/// The largest bound over `s`, and the charge in it.
fn best(objective: &Quadratic, sum: &Combination, reach: &[f64]) -> (f64, f64) {
    let (r, d) = (&objective.r, &objective.d);
    let span = Rows::new(r);
    let pull = span.least_squares(&sum.g);
    let apart = span.out_of_reach(d);
    let charged = |left: DVector<f64>, size: DVector<f64>| -> f64 {
        let left = left.iter().zip(&size).map(|(l, s)| l.abs() + ROUNDING * s);
        // No remainder, no charge, even where `z` is unbounded.
        left.zip(reach).filter(|(l, _)| *l > 0.0).map(|(l, z)| l * z).sum()
    };
    let (along, along_size) = transposed_product(r, &pull);
    let charge = charged(2.0 * along - &sum.g, 2.0 * along_size + &sum.size);
    let (beside, beside_size) = transposed_product(r, &apart);
    let floor_charge = 2.0 * charged(beside, beside_size);
    let rounding = |a: &DVector<f64>, b: &DVector<f64>| {
        ROUNDING * a.iter().zip(b).map(|(x, y)| (x * y).abs()).sum::<f64>()
    };
    let floor = 2.0 * apart.dot(d) - apart.norm_squared() - floor_charge - 3.0 * rounding(&apart, d);
    let (floor, apart) = if floor > 0.0 { (floor, apart) } else { (0.0, DVector::zeros(d.len())) };
    let slope = 2.0 * pull.dot(&apart)
        - 2.0 * pull.dot(d)
        - sum.c
        - charge
        - 2.0 * rounding(&pull, d)
        - 2.0 * rounding(&pull, &apart);
    let curvature = pull.norm_squared() * (1.0 + ROUNDING);
    let gain = if slope > 0.0 && curvature > 0.0 { slope * slope / (4.0 * curvature) } else { 0.0 };
    let per_root = if curvature > 0.0 { charge / (2.0 * curvature.sqrt()) } else { 0.0 };
    (objective.floor + (floor + gain) * (1.0 - ROUNDING), per_root)
}

/// `rᵀ w`, and the same with every term's size.
fn transposed_product(r: &DMatrix<f64>, w: &DVector<f64>) -> (DVector<f64>, DVector<f64>) {
    let sums = |size: bool| {
        let entry = |(x, y): (&f64, &f64)| if size { (x * y).abs() } else { x * y };
        DVector::from_iterator(r.ncols(), r.column_iter().map(|c| c.iter().zip(w).map(entry).sum()))
    };
    (sums(false), sums(true))
}

/// Least squares with `rᵀ`, whatever its rank, from the triangle of `[rᵀ; e 1]`. How exact they are decides
/// only how good the bound is: it holds for any vectors.
struct Rows {
    /// Orthonormal columns that span those of `r`, where `r` is tall; then the rest works with their factor.
    frame: Option<DMatrix<f64>>,
    qr: nalgebra::QR<f64, nalgebra::Dyn, nalgebra::Dyn>,
    rows: usize,
    columns: usize,
    damping: f64,
}

impl Rows {
    fn new(r: &DMatrix<f64>) -> Self {
        if r.nrows() > r.ncols() {
            let qr = r.clone().qr();
            return Self { frame: Some(qr.q()), ..Self::new(&qr.r()) };
        }
        let (m, n) = r.shape();
        let size = r.norm();
        let damping = UNSEEN * if size > 0.0 { size } else { 1.0 };
        let stacked = DMatrix::from_fn(n + m, m, |i, j| {
            if i < n {
                r[(j, i)]
            } else if i - n == j {
                damping
            } else {
                0.0
            }
        });
        Self { frame: None, qr: stacked.qr(), rows: m, columns: n, damping }
    }

    fn solve(&self, right: impl Fn(usize) -> f64) -> DVector<f64> {
        let mut right = DVector::from_fn(self.rows + self.columns, |i, _| right(i));
        self.qr.q_tr_mul(&mut right);
        let solved = self.qr.r().solve_upper_triangular(&right.rows(0, self.rows).into_owned());
        solved.unwrap_or_else(|| DVector::zeros(self.rows))
    }

    /// The smallest `w` with `2 rᵀw` nearest to `g`.
    fn least_squares(&self, g: &DVector<f64>) -> DVector<f64> {
        let w = self.solve(|i| if i < self.columns { 0.5 * g[i] } else { 0.0 });
        self.frame.as_ref().map_or_else(|| w.clone(), |frame| frame * &w)
    }

    /// The part of `d` that no `r z` reaches.
    fn out_of_reach(&self, d: &DVector<f64>) -> DVector<f64> {
        let inside = self.frame.as_ref().map_or_else(|| d.clone(), |frame| frame.tr_mul(d));
        let apart =
            self.solve(|i| if i < self.columns { 0.0 } else { self.damping * inside[i - self.columns] });
        self.frame.as_ref().map_or_else(|| apart.clone(), |frame| d - frame * (&inside - &apart))
    }
}

/// Largest `|z|` that the forms allow, and whether the search coordinates' bounds had to help.
fn reach(problem: &Problem, forms: &[&Form]) -> (Vec<f64>, bool) {
    let mut reach: Vec<f64> =
        intervals(problem.space.len(), forms).iter().map(|(l, u)| l.abs().max(u.abs())).collect();
    let mut helped = false;
    if let Some(search) = problem.chart.reach() {
        for (z, bound) in reach.iter_mut().zip(search).filter(|(z, _)| z.is_infinite()) {
            (*z, helped) = (bound, true);
        }
    }
    (reach, helped)
}

/// Rounds of bound tightening at most.
const ROUNDS: usize = 30;

/// Intervals of `z` by bound tightening on the linear consequences of the forms.
fn intervals(n: usize, forms: &[&Form]) -> Vec<(f64, f64)> {
    let rows: Vec<Affine> = forms.iter().flat_map(|form| consequences(form)).collect();
    let mut box_ = vec![(f64::NEG_INFINITY, f64::INFINITY); n];
    for _ in 0..ROUNDS {
        let mut moved = false;
        for row in &rows {
            moved |= tighten(row, &mut box_);
        }
        if !moved {
            break;
        }
    }
    box_
}

/// Rows that are not negative where the form holds.
fn consequences(form: &Form) -> Vec<Affine> {
    match &form.body {
        Body::Affine(row) => vec![row.clone()],
        Body::Norm { rows, bound } => {
            rows.iter().flat_map(|r| [1.0, -1.0].map(|sign| bound.clone().plus(sign, r))).collect()
        }
        Body::Psd { size, lower } => {
            let at = |i: usize, j: usize| &lower[i * (i + 1) / 2 + j];
            let mut rows: Vec<Affine> = (0..*size).map(|i| at(i, i).clone()).collect();
            for (i, j) in (0..*size).flat_map(|i| (0..i).map(move |j| (i, j))) {
                let both = at(i, i).clone().plus(1.0, at(j, j));
                // vᵀ M v for v = e_i + e_j and e_i - e_j, and their mean.
                rows.extend([2.0, -2.0, 0.0].map(|sign| both.clone().plus(sign, at(i, j))));
            }
            rows
        }
        Body::General { .. } => Vec::new(),
    }
}

/// Tightens the interval of every unknown in `row >= 0`; whether one moved by more than a thousandth.
fn tighten(row: &Affine, bounds: &mut [(f64, f64)]) -> bool {
    let largest = |(i, f): (usize, f64), b: &[(f64, f64)]| (f * b[i].0).max(f * b[i].1);
    let terms: Vec<(usize, f64)> = row.terms.iter().copied().filter(|t| t.1.abs() > 0.0).collect();
    let mut moved = false;
    for (k, &(i, factor)) in terms.iter().enumerate() {
        let others = terms.iter().enumerate().filter(|(l, _)| *l != k);
        let rest: f64 = row.constant + others.map(|(_, &t)| largest(t, bounds)).sum::<f64>();
        if !rest.is_finite() {
            continue;
        }
        let limit = -rest / factor;
        // Outwards by more than rounding.
        let slack = 1e-9 * (1.0 + limit.abs());
        let (lower, upper) = bounds[i];
        if factor > 0.0 && limit - slack > lower + 1e-3 * (1.0 + lower.abs().min(limit.abs())) {
            (bounds[i].0, moved) = (limit - slack, true);
        } else if factor < 0.0 && limit + slack < upper - 1e-3 * (1.0 + upper.abs().min(limit.abs())) {
            (bounds[i].1, moved) = (limit + slack, true);
        }
    }
    moved
}
