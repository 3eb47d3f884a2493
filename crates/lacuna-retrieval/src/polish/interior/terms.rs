//! Barrier terms `-ln(margin)`: value, gradient and a positive semidefinite Hessian.
//!
//! Boyd and Vandenberghe, Convex Optimization, section 11.2 and 11.6.

use std::sync::Arc;

use super::cholesky::{factor_small, invert_small};
use crate::form::{Affine, Body, Form, General};

/// What the terms add to: gradient and lower triangle (column by column) of the Hessian.
pub(super) struct Slopes<'a> {
    pub size: usize,
    pub gradient: &'a mut [f64],
    pub hessian: &'a mut [f64],
}

impl Slopes<'_> {
    /// Adds `value` at `(i, j)` and, by symmetry, at `(j, i)`.
    fn pair(&mut self, i: usize, j: usize, value: f64) {
        let (row, column) = if i >= j { (i, j) } else { (j, i) };
        self.hessian[column * self.size + row] += value;
    }

    /// Adds `first * v` to the gradient and `second * v vᵀ` to the Hessian for a sparse `v`.
    pub(super) fn outer(&mut self, v: &[(usize, f64)], first: f64, second: f64) {
        for (k, &(i, a)) in v.iter().enumerate() {
            self.gradient[i] += first * a;
            for &(j, b) in &v[..=k] {
                self.pair(i, j, second * a * b);
            }
        }
    }
}

/// A sum of logarithms that takes few of them; not a number once a factor is not positive.
pub(super) struct LogSum {
    product: f64,
    sum: f64,
}

impl LogSum {
    pub(super) fn new() -> Self {
        Self { product: 1.0, sum: 0.0 }
    }

    /// Adds `ln(value)`; `false` where there is none.
    pub(super) fn add(&mut self, value: f64) -> bool {
        if !(value > 0.0 && value.is_finite()) {
            return false;
        }
        // The product of two factors within these limits is still a normal number.
        if !(1e-100..1e100).contains(&value) {
            self.sum += libm::log(value);
            return true;
        }
        self.product *= value;
        if !(1e-100..1e100).contains(&self.product) {
            self.sum += libm::log(self.product);
            self.product = 1.0;
        }
        true
    }

    pub(super) fn total(&self) -> f64 {
        self.sum + libm::log(self.product)
    }
}

/// A slack that relaxes a form: its index and how much margin a unit of it gives.
pub(super) type Slack = Option<(usize, f64)>;

/// One barrier term.
#[derive(Debug, Clone)]
pub(super) enum Term {
    /// `-ln(row)`.
    Affine(Affine),
    /// `-ln(bound² - |rows|²)`.
    Cone { rows: Vec<Affine>, bound: Affine },
    /// `-ln det(matrix)`.
    Psd(Block),
    /// `-ln(margin)`, with the Gauss-Newton part of its Hessian.
    General { function: Arc<dyn General>, support: Vec<usize>, slack: Slack },
}

/// A matrix that depends linearly on the unknowns.
#[derive(Debug, Clone)]
pub(super) struct Block {
    size: usize,
    constant: Vec<f64>,
    support: Vec<usize>,
    /// Per member of the support: row, column (not above the diagonal), factor.
    entries: Vec<Vec<(usize, usize, f64)>>,
}

/// Room for the matrices of a block.
#[derive(Debug, Default)]
pub(super) struct Scratch {
    matrix: Vec<f64>,
    root: Vec<f64>,
    inverse: Vec<f64>,
    turned: Vec<f64>,
}

impl Term {
    /// The barrier of a form, relaxed by a slack.
    pub(super) fn new(form: &Form, slack: Slack) -> Self {
        let relaxed = |row: &Affine| match slack {
            Some((index, factor)) => row.clone().plus(factor, &Affine::variable(index)),
            None => row.clone(),
        };
        Self::of(&form.body, slack, &relaxed)
    }

    /// The barrier of one bound of a chart.
    pub(super) fn bound(body: &Body) -> Self {
        Self::of(body, None, &Affine::clone)
    }

    fn of(body: &Body, slack: Slack, relaxed: &dyn Fn(&Affine) -> Affine) -> Self {
        match body {
            Body::Affine(row) => Self::Affine(relaxed(row)),
            Body::Norm { rows, bound } => Self::Cone { rows: rows.clone(), bound: relaxed(bound) },
            Body::Psd { size, lower } => Self::Psd(Block::new(*size, lower, slack)),
            Body::General { function, .. } => {
                Self::General { function: Arc::clone(function), support: function.support(), slack }
            }
        }
    }

    /// The condition of an affine term.
    pub(super) fn affine(&self) -> Option<&Affine> {
        match self {
            Self::Affine(row) => Some(row),
            _ => None,
        }
    }

    /// Weight of the term in the duality gap: a gap of `mu` times this remains at the end.
    pub(super) fn degree(&self) -> f64 {
        match self {
            Self::Affine(_) | Self::General { .. } => 1.0,
            Self::Cone { .. } => 2.0,
            Self::Psd(block) => block.size as f64,
        }
    }

    /// Adds its logarithms; `false` outside of its domain.
    pub(super) fn add_logs(&self, x: &[f64], scratch: &mut Scratch, logs: &mut LogSum) -> bool {
        match self {
            Self::Affine(row) => logs.add(row.at(x)),
            Self::Cone { rows, bound } => {
                let (b, norm) = (bound.at(x), rows.iter().map(|r| r.at(x).powi(2)).sum::<f64>().sqrt());
                b > norm && logs.add((b - norm) * (b + norm))
            }
            Self::Psd(block) => {
                block.fill(x, &mut scratch.matrix);
                let n = block.size;
                factor_small(&mut scratch.matrix, n)
                    && (0..n).all(|i| logs.add(scratch.matrix[i * n + i].powi(2)))
            }
            Self::General { function, slack, .. } => {
                logs.add(function.margin(x) + slack.map_or(0.0, |(i, f)| f * x[i]))
            }
        }
    }

    /// Adds `mu` times its derivatives.
    pub(super) fn add_slopes(&self, x: &[f64], mu: f64, scratch: &mut Scratch, slopes: &mut Slopes<'_>) {
        match self {
            Self::Affine(row) => {
                let inverse = 1.0 / row.at(x);
                slopes.outer(&row.terms, -mu * inverse, mu * inverse * inverse);
            }
            Self::Cone { rows, bound } => add_cone(rows, bound, x, mu, slopes),
            Self::Psd(block) => block.add_slopes(x, mu, scratch, slopes),
            Self::General { function, support, slack } => {
                let (margin, slope) = function.gradient(x);
                let mut v: Vec<(usize, f64)> = support.iter().copied().zip(slope).collect();
                v.extend(slack);
                let inverse = 1.0 / (margin + slack.map_or(0.0, |(i, f)| f * x[i]));
                slopes.outer(&v, -mu * inverse, mu * inverse * inverse);
            }
        }
    }

    /// Largest step along `d` that keeps an affine term positive; infinite for the others, which are tried.
    pub(super) fn reach(&self, x: &[f64], d: &[f64]) -> f64 {
        let Self::Affine(row) = self else { return f64::INFINITY };
        let slope: f64 = row.terms.iter().map(|&(i, f)| f * d[i]).sum();
        if slope < 0.0 { -row.at(x) / slope } else { f64::INFINITY }
    }
}

/// With `u = b² - |r|²`: gradient `-u'/u`, Hessian `u'u'ᵀ/u² - u''/u`, `u'' = 2 (b'b'ᵀ - Σ r'r'ᵀ)`.
fn add_cone(rows: &[Affine], bound: &Affine, x: &[f64], mu: f64, slopes: &mut Slopes<'_>) {
    let b = bound.at(x);
    let values: Vec<f64> = rows.iter().map(|r| r.at(x)).collect();
    let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    let u = (b - norm) * (b + norm);
    let mut slope = bound.clone().times(2.0 * b);
    for (row, value) in rows.iter().zip(&values) {
        slope = slope.plus(-2.0 * value, row);
        slopes.outer(&row.terms, 0.0, 2.0 * mu / u);
    }
    slopes.outer(&bound.terms, 0.0, -2.0 * mu / u);
    slopes.outer(&slope.terms, -mu / u, mu / (u * u));
}

impl Block {
    fn new(size: usize, lower: &[Affine], slack: Slack) -> Self {
        let mut block =
            Self { size, constant: vec![0.0; size * size], support: Vec::new(), entries: Vec::new() };
        for i in 0..size {
            for j in 0..=i {
                let row = &lower[i * (i + 1) / 2 + j];
                block.constant[i * size + j] = row.constant;
                row.terms.iter().for_each(|&(v, factor)| block.insert(v, i, j, factor));
            }
            if let Some((v, factor)) = slack {
                block.insert(v, i, i, factor);
            }
        }
        block
    }

    fn insert(&mut self, variable: usize, i: usize, j: usize, factor: f64) {
        let at = self.support.iter().position(|&v| v == variable).unwrap_or_else(|| {
            self.support.push(variable);
            self.entries.push(Vec::new());
            self.support.len() - 1
        });
        self.entries[at].push((i, j, factor));
    }

    /// Writes the lower triangle at `x`, by rows.
    fn fill(&self, x: &[f64], matrix: &mut Vec<f64>) {
        matrix.clone_from(&self.constant);
        for (&variable, entries) in self.support.iter().zip(&self.entries) {
            for &(i, j, factor) in entries {
                matrix[i * self.size + j] += factor * x[variable];
            }
        }
    }

    /// Gradient `-tr(X A_i)`, Hessian `tr(X A_i X A_j)`, with `X` the inverse of the matrix.
    fn add_slopes(&self, x: &[f64], mu: f64, scratch: &mut Scratch, slopes: &mut Slopes<'_>) {
        let n = self.size;
        self.fill(x, &mut scratch.matrix);
        for room in [&mut scratch.root, &mut scratch.inverse, &mut scratch.turned] {
            room.resize(n * n, 0.0);
        }
        factor_small(&mut scratch.matrix, n);
        invert_small(&scratch.matrix, n, &mut scratch.root, &mut scratch.inverse);
        let trace = |matrix: &[f64], entries: &[(usize, usize, f64)]| -> f64 {
            entries.iter().map(|&(i, j, f)| matrix[i * n + j] * if i == j { f } else { 2.0 * f }).sum()
        };
        for (k, (&variable, entries)) in self.support.iter().zip(&self.entries).enumerate() {
            slopes.gradient[variable] -= mu * trace(&scratch.inverse, entries);
            turn(&scratch.inverse, n, entries, &mut scratch.turned);
            for (&other, others) in self.support[..=k].iter().zip(&self.entries) {
                slopes.pair(variable, other, mu * trace(&scratch.turned, others));
            }
        }
    }
}

/// `X A X`, symmetric, for the sparse `A`.
fn turn(x: &[f64], n: usize, entries: &[(usize, usize, f64)], result: &mut [f64]) {
    result.fill(0.0);
    for &(r, c, factor) in entries {
        for i in 0..n {
            let (a, b) = (factor * x[i * n + r], if r == c { 0.0 } else { factor * x[i * n + c] });
            for j in 0..n {
                result[i * n + j] += a * x[c * n + j] + b * x[r * n + j];
            }
        }
    }
}
