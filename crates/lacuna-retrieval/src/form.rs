//! Constraints lowered to what solvers understand. Nothing here knows robots.
//!
//! A [`Form`] holds where its margin is not negative. Affine, norm and semidefinite forms are convex and
//! reach every engine; whatever leaves them is [`Body::General`] with value and exact gradient.

use std::fmt::Debug;
use std::sync::Arc;

use nalgebra::{DMatrix, SymmetricEigen};

/// `constant + sum of factor * z[index]`.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Affine {
    /// Index and factor; every index at most once.
    pub terms: Vec<(usize, f64)>,
    /// Constant part.
    pub constant: f64,
}

impl Affine {
    /// A number.
    pub fn constant(value: f64) -> Self {
        Self { terms: Vec::new(), constant: value }
    }

    /// The unknown with this index.
    pub fn variable(index: usize) -> Self {
        Self { terms: vec![(index, 1.0)], constant: 0.0 }
    }

    /// Value at `z`.
    pub fn at(&self, z: &[f64]) -> f64 {
        self.terms.iter().map(|&(i, f)| f * z[i]).sum::<f64>() + self.constant
    }

    /// `self + factor * other`.
    #[must_use]
    pub fn plus(mut self, factor: f64, other: &Affine) -> Self {
        for &(i, f) in &other.terms {
            match self.terms.iter_mut().find(|(k, _)| *k == i) {
                Some((_, sum)) => *sum += factor * f,
                None => self.terms.push((i, factor * f)),
            }
        }
        self.constant += factor * other.constant;
        self
    }

    /// `factor * self`.
    #[must_use]
    pub fn times(mut self, factor: f64) -> Self {
        self.terms.iter_mut().for_each(|(_, f)| *f *= factor);
        self.constant *= factor;
        self
    }
}

/// A margin with its exact gradient, for constraints that no cone expresses.
pub trait General: Debug + Send + Sync {
    /// The unknowns it depends on, ascending.
    fn support(&self) -> Vec<usize>;

    /// Margin at `z`: not negative where the constraint holds.
    fn margin(&self, z: &[f64]) -> f64;

    /// Margin and its derivative with respect to each member of [`General::support`], in that order; a
    /// one-sided choice where the margin has a kink.
    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>);
}

/// What must hold.
#[derive(Debug, Clone)]
pub enum Body {
    /// `row >= 0`.
    Affine(Affine),
    /// `bound - |rows| >= 0` in the 2-norm.
    Norm {
        /// The vector.
        rows: Vec<Affine>,
        /// Its bound.
        bound: Affine,
    },
    /// A symmetric matrix is positive semidefinite; the margin is its smallest eigenvalue.
    Psd {
        /// Number of rows.
        size: usize,
        /// Lower triangle by rows.
        lower: Vec<Affine>,
    },
    /// Anything else.
    General {
        /// Margin and gradient.
        function: Arc<dyn General>,
        /// Why it is none of the others, for people.
        why: String,
        /// Convex forms that it implies, for engines that cannot take it; may be empty.
        implied: Vec<Form>,
    },
}

/// A lowered constraint.
#[derive(Debug, Clone)]
pub struct Form {
    /// For people, as in `link3: mass >= 0.1 kg`.
    pub label: String,
    /// Unit of the margin that is reported.
    pub unit: String,
    /// The margin is divided by this before violations are compared: the constraint's bound, or 1.
    pub scale: f64,
    /// What must hold.
    pub body: Body,
    /// Margin to report in the constraint's own unit where that is not the body's; same sign as the body's.
    pub measure: Option<Arc<dyn General>>,
}

impl Form {
    /// A form that reports its own margin.
    pub fn new(label: impl Into<String>, unit: impl Into<String>, scale: f64, body: Body) -> Self {
        let scale = if scale.is_finite() && scale.abs() > 0.0 { scale.abs() } else { 1.0 };
        Self { label: label.into(), unit: unit.into(), scale, body, measure: None }
    }

    /// `row >= 0`, scaled by `scale`.
    pub fn affine(label: impl Into<String>, unit: impl Into<String>, scale: f64, row: Affine) -> Self {
        Self::new(label, unit, scale, Body::Affine(row))
    }

    /// Whether a cone expresses it.
    pub fn is_convex(&self) -> bool {
        !matches!(self.body, Body::General { .. })
    }

    /// Margin of the body at `z`.
    pub fn margin(&self, z: &[f64]) -> f64 {
        match &self.body {
            Body::Affine(row) => row.at(z),
            Body::Norm { rows, bound } => {
                bound.at(z) - rows.iter().map(|r| r.at(z).powi(2)).sum::<f64>().sqrt()
            }
            Body::Psd { size, lower } => matrix(*size, lower, z).symmetric_eigenvalues().min(),
            Body::General { function, .. } => function.margin(z),
        }
    }

    /// Margin in the constraint's own unit.
    pub fn reported_margin(&self, z: &[f64]) -> f64 {
        self.measure.as_ref().map_or_else(|| self.margin(z), |m| m.margin(z))
    }

    /// By how much it is violated, scaled: 0 where it holds, infinite where the margin is not a number.
    pub fn violation(&self, z: &[f64]) -> f64 {
        let margin = self.reported_margin(z);
        if margin.is_nan() { f64::INFINITY } else { (-margin / self.scale).max(0.0) }
    }

    /// Unknowns it depends on, ascending.
    pub fn support(&self) -> Vec<usize> {
        let mut all: Vec<usize> = match &self.body {
            Body::Affine(row) => row.terms.iter().map(|t| t.0).collect(),
            Body::Norm { rows, bound } => {
                rows.iter().chain([bound]).flat_map(|r| &r.terms).map(|t| t.0).collect()
            }
            Body::Psd { lower, .. } => lower.iter().flat_map(|r| &r.terms).map(|t| t.0).collect(),
            Body::General { function, .. } => function.support(),
        };
        all.sort_unstable();
        all.dedup();
        all
    }

    /// Margin of the body and its gradient as `(index, derivative)` pairs.
    pub fn gradient(&self, z: &[f64]) -> (f64, Vec<(usize, f64)>) {
        match &self.body {
            Body::Affine(row) => (row.at(z), row.terms.clone()),
            Body::Norm { rows, bound } => norm_gradient(rows, bound, z),
            Body::Psd { size, lower } => psd_gradient(*size, lower, z),
            Body::General { function, .. } => {
                let (margin, slopes) = function.gradient(z);
                (margin, function.support().into_iter().zip(slopes).collect())
            }
        }
    }
}

/// The symmetric matrix of a semidefinite form at `z`.
pub fn matrix(size: usize, lower: &[Affine], z: &[f64]) -> DMatrix<f64> {
    DMatrix::from_fn(size, size, |i, j| {
        let (i, j) = (i.max(j), i.min(j));
        lower[i * (i + 1) / 2 + j].at(z)
    })
}

fn norm_gradient(rows: &[Affine], bound: &Affine, z: &[f64]) -> (f64, Vec<(usize, f64)>) {
    let values: Vec<f64> = rows.iter().map(|r| r.at(z)).collect();
    let norm = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    let mut sum = bound.clone();
    for (row, value) in rows.iter().zip(&values) {
        // At the tip of the cone the slope is 0, one of those that will do there.
        let slope = if norm > 0.0 { -value / norm } else { 0.0 };
        sum = sum.plus(slope, row);
    }
    (bound.at(z) - norm, sum.terms)
}

fn psd_gradient(size: usize, lower: &[Affine], z: &[f64]) -> (f64, Vec<(usize, f64)>) {
    let eigen = SymmetricEigen::new(matrix(size, lower, z));
    let least = eigen.eigenvalues.imin();
    let v = eigen.eigenvectors.column(least);
    let mut sum = Affine::default();
    for i in 0..size {
        for j in 0..=i {
            let weight = if i == j { v[i] * v[j] } else { 2.0 * v[i] * v[j] };
            sum = sum.plus(weight, &lower[i * (i + 1) / 2 + j]);
        }
    }
    (eigen.eigenvalues[least], sum.terms)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn check_gradient(form: &Form, z: &[f64]) {
        let (margin, gradient) = form.gradient(z);
        assert!((margin - form.margin(z)).abs() < 1e-12);
        for (i, slope) in gradient {
            let h = 1e-6;
            let moved = |d: f64| {
                let mut z = z.to_vec();
                z[i] += d;
                form.margin(&z)
            };
            let difference = (moved(h) - moved(-h)) / (2.0 * h);
            assert!((slope - difference).abs() < 1e-8, "{} at {i}: {slope} {difference}", form.label);
        }
    }

    #[test]
    fn gradients_are_those_of_the_margins() {
        let v = Affine::variable;
        let z = [0.3, -0.7, 1.9, 0.4];
        check_gradient(&Form::affine("a", "kg", 1.0, v(0).plus(2.0, &v(2))), &z);
        let norm = Body::Norm { rows: vec![v(0), v(1).plus(0.5, &v(3))], bound: v(2).times(3.0) };
        check_gradient(&Form::new("n", "m", 1.0, norm), &z);
        let lower =
            vec![v(2), v(0), v(3).plus(1.0, &Affine::constant(1.0)), v(1), v(0).times(0.2), v(2).times(2.0)];
        check_gradient(&Form::new("p", "kg", 1.0, Body::Psd { size: 3, lower }), &z);
    }

    #[test]
    fn violation_is_scaled_and_never_silent_about_nan() {
        let form = Form::affine("m >= 2", "kg", 2.0, Affine::variable(0).plus(1.0, &Affine::constant(-2.0)));
        assert!((form.violation(&[1.0]) - 0.5).abs() < 1e-15);
        assert!(form.violation(&[3.0]).abs() < 1e-15);
        assert!(form.violation(&[f64::NAN]).is_infinite());
    }
}
