//! The model at hand, fitted: on all data, and without each fold.

use std::ops::Range;
use std::sync::Arc;

use nalgebra::DMatrix;
use rayon::prelude::*;

use super::data::{Column, Data};
use super::normal::Cholesky;
use crate::linalg::{dots, subtract_product};

/// Columns whose remainder is below this part of their squared size are left out of a fit.
const DEPENDENT: f64 = 1e-9;
/// Keeps a fold's fit defined where only the held-out fold excites a column.
const RIDGE: f64 = 1e-10;
/// Nuisances are held back by this part of their size: a column of rare spikes must not run wild in a fold.
const NUISANCE_RIDGE: f64 = 0.1;
/// Rounds of weighting joints by one over their residual rms.
const ROUNDS: usize = 3;

/// Columns to fit; the last `nuisances` of them are nobody's physics.
#[derive(Debug, Clone)]
pub(super) struct Columns {
    pub columns: Vec<Arc<Column>>,
    pub nuisances: usize,
}

/// The model at hand with its fits. Residuals and the effects of candidates are held out: every fold is
/// predicted by a fit of the others.
#[derive(Debug, Clone)]
pub(super) struct Present {
    pub columns: Vec<Arc<Column>>,
    /// Columns that reach each joint.
    pub active: Vec<Vec<usize>>,
    /// The last so many columns are nuisances: held back where data say little about them.
    nuisances: usize,
    /// One over the residual rms of each joint.
    pub weights: Vec<f64>,
    /// Factor of the normal equations of all data.
    pub all: Cholesky,
    /// Factor without each fold.
    pub folds: Vec<Cholesky>,
    /// `grams[fold][joint]`: products of the joint's active columns.
    grams: Vec<Vec<Vec<f64>>>,
}

/// Fits of one response (the torque, or a stand-in for it) by the model at hand.
#[derive(Debug, Clone)]
pub(super) struct Response {
    /// The response itself: rows of each joint.
    pub y: Vec<Vec<f64>>,
    /// Products of every column with it, `products[fold][column]`, weighted.
    pub products: Vec<Vec<f64>>,
    /// Held-out residual of each joint.
    pub residual: Vec<Vec<f64>>,
}

impl Present {
    /// Prepares the fits of `columns`; joints are weighed by their residual under this very model.
    pub fn new(data: &Data, columns: Columns) -> Self {
        let mut this = Self::unfitted(data, columns);
        this.weights = weights(data, &data.tau);
        for _ in 0..ROUNDS {
            let total = this.factor_all();
            let residual = this.residual_with(data, &total);
            this.weights = weights(data, &residual);
        }
        this.factor(data.fold_ranges.len());
        this
    }

    /// The same with given weights of the joints.
    pub fn with_weights(data: &Data, columns: Columns, weights: &[f64]) -> Self {
        let mut this = Self::unfitted(data, columns);
        this.weights = weights.to_vec();
        this.factor(data.fold_ranges.len());
        this
    }

    /// The same columns with other weights of the joints, fitted to all data only: no fold has a fit of its own.
    pub fn reweighted(&self, weights: Vec<f64>) -> Self {
        let mut this = Self { weights, folds: Vec::new(), ..self.clone() };
        this.all = this.factor_all();
        this
    }

    fn unfitted(data: &Data, columns: Columns) -> Self {
        let Columns { columns, nuisances } = columns;
        let active: Vec<Vec<usize>> = (0..data.dof())
            .map(|j| (0..columns.len()).filter(|&c| columns[c].part(j).is_some()).collect())
            .collect();
        let grams: Vec<Vec<Vec<f64>>> = data
            .fold_ranges
            .par_iter()
            .map(|ranges| (0..data.dof()).map(|j| gram(&columns, &active[j], j, ranges)).collect())
            .collect();
        let none = Cholesky::new(&[], 0, DEPENDENT, 0.0);
        let weights = vec![1.0; data.dof()];
        Self { columns, active, nuisances, weights, all: none, folds: Vec::new(), grams }
    }

    /// Number of columns.
    pub fn width(&self) -> usize {
        self.columns.len()
    }

    fn normal_of(&self, folds: impl Iterator<Item = usize>) -> Vec<f64> {
        let p = self.width();
        let mut a = vec![0.0; p * p];
        for fold in folds {
            for (joint, active) in self.active.iter().enumerate() {
                let w = self.weights[joint] * self.weights[joint];
                let gram = &self.grams[fold][joint];
                for (i, &ci) in active.iter().enumerate() {
                    for (k, &ck) in active.iter().enumerate().take(i + 1) {
                        a[ci * p + ck] += w * gram[i * active.len() + k];
                    }
                }
            }
        }
        for i in 0..p {
            for k in 0..i {
                // Columns are ascending within a joint, so all sums stand below the diagonal.
                a[k * p + i] = a[i * p + k];
            }
        }
        a
    }

    /// Normal equations of all data, nuisances held back.
    fn normal(&self) -> Vec<f64> {
        let p = self.width();
        let mut a = self.normal_of(0..self.grams.len());
        for c in p - self.nuisances..p {
            a[c * p + c] *= 1.0 + NUISANCE_RIDGE;
        }
        a
    }

    fn factor_all(&self) -> Cholesky {
        Cholesky::new(&self.normal(), self.width(), DEPENDENT, 0.0)
    }

    fn factor(&mut self, folds: usize) {
        let p = self.width();
        self.all = self.factor_all();
        let mut blocked = self.normal();
        // What all data cannot tell apart stays out of every fold, and so does what acts between two times only.
        let out = |c: &usize| self.columns[*c].in_interval || self.all.kept.binary_search(c).is_err();
        for c in (0..p).filter(out) {
            blocked[c * p + c] = 0.0;
        }
        let without = |fold: usize| {
            let own = self.normal_of(std::iter::once(fold));
            let rest: Vec<f64> = blocked.iter().zip(&own).map(|(a, b)| a - b).collect();
            Cholesky::new(&rest, p, RIDGE, RIDGE)
        };
        self.folds = (0..folds).into_par_iter().map(without).collect();
    }

    /// Products of the columns with rows `y` over some rows, weighted.
    pub fn products_of(&self, y: &[Vec<f64>], ranges: &[Range<usize>]) -> Vec<f64> {
        let mut b = vec![0.0; self.width()];
        for (joint, active) in self.active.iter().enumerate() {
            let w = self.weights[joint] * self.weights[joint];
            for range in ranges {
                let columns = active.iter().map(|&c| &self.rows(c, joint)[range.clone()]);
                let mut places = active.iter();
                dots(&y[joint][range.clone()], columns, |dot| {
                    if let Some(&c) = places.next() {
                        b[c] += w * dot;
                    }
                });
            }
        }
        b
    }

    /// Rows of column `c` in `joint`, which it must reach.
    pub fn rows(&self, c: usize, joint: usize) -> &[f64] {
        self.columns[c].part(joint).unwrap_or(&[])
    }

    /// What is left of `y` in `joint` over `range` when the columns are taken away `x` times.
    pub fn take_away(&self, x: &[f64], joint: usize, range: Range<usize>, y: &mut [f64]) {
        let used = self.active[joint].iter().filter(|&&c| x[c] != 0.0);
        subtract_product(y, used.map(|&c| (x[c], &self.rows(c, joint)[range.clone()])));
    }

    fn residual_with(&self, data: &Data, factor: &Cholesky) -> Vec<Vec<f64>> {
        let all = 0..data.count();
        let x = factor.solve(&self.products_of(&data.tau, std::slice::from_ref(&all)));
        self.residual_of(&data.tau, &x)
    }

    /// Residual of parameters `x` in all rows.
    pub fn residual_of(&self, y: &[Vec<f64>], x: &[f64]) -> Vec<Vec<f64>> {
        y.iter()
            .enumerate()
            .map(|(joint, y)| {
                let mut rest = y.clone();
                self.take_away(x, joint, 0..y.len(), &mut rest);
                rest
            })
            .collect()
    }

    /// Parameters fitted to all rows of `y`.
    pub fn fit(&self, y: &[Vec<f64>]) -> Vec<f64> {
        self.all.solve(&self.products_of(y, std::slice::from_ref(&(0..y[0].len()))))
    }

    /// Covariance of some parameters of the fit `x` to the torque: a sandwich over clusters of one second, so
    /// that it allows for autocorrelation and for what the model does not explain.
    pub fn covariance(&self, data: &Data, x: &[f64], wanted: Range<usize>) -> DMatrix<f64> {
        let residual = self.residual_of(&data.tau, x);
        let rows: Vec<Vec<f64>> = wanted
            .clone()
            .map(|c| {
                let mut unit = vec![0.0; self.width()];
                unit[c] = 1.0;
                self.all.solve(&unit)
            })
            .collect();
        let seconds = data.seconds();
        let mut clusters = vec![vec![0.0; rows.len()]; seconds.last().map_or(0, |s| s + 1)];
        for (joint, active) in self.active.iter().enumerate() {
            let w = self.weights[joint] * self.weights[joint];
            for (i, row) in rows.iter().enumerate() {
                let mut influence = vec![0.0; data.count()];
                let used = active.iter().map(|&c| (-row[c], self.rows(c, joint)));
                subtract_product(&mut influence, used);
                for (k, value) in influence.iter().enumerate() {
                    clusters[seconds[k]][i] += w * value * residual[joint][k];
                }
            }
        }
        let n = rows.len();
        DMatrix::from_fn(n, n, |a, b| clusters.iter().map(|c| c[a] * c[b]).sum())
    }

    /// Takes away what acts between two times only, as all data together say it: the fold in which these times lie
    /// knows nothing of it, or a sliver that runs wild.
    fn without_events(&self, y: Vec<Vec<f64>>) -> Vec<Vec<f64>> {
        if self.columns.iter().all(|c| !c.in_interval) {
            return y;
        }
        let mut x = self.fit(&y);
        x.iter_mut().zip(&self.columns).filter(|(_, c)| !c.in_interval).for_each(|(x, _)| *x = 0.0);
        self.residual_of(&y, &x)
    }

    /// Fits `y` without each fold.
    pub fn respond(&self, data: &Data, y: Vec<Vec<f64>>) -> Response {
        let y = self.without_events(y);
        let products: Vec<Vec<f64>> =
            data.fold_ranges.iter().map(|ranges| self.products_of(&y, ranges)).collect();
        let total = sum(&products);
        let mut residual = y.clone();
        for (fold, ranges) in data.fold_ranges.iter().enumerate() {
            let train: Vec<f64> = total.iter().zip(&products[fold]).map(|(a, b)| a - b).collect();
            let x = self.folds[fold].solve(&train);
            for range in ranges {
                for (joint, rest) in residual.iter_mut().enumerate() {
                    self.take_away(&x, joint, range.clone(), &mut rest[range.clone()]);
                }
            }
        }
        // What is not measured has no error.
        for (rest, _) in residual.iter_mut().zip(&data.silent).filter(|(_, silent)| **silent) {
            rest.fill(0.0);
        }
        Response { y, products, residual }
    }
}

/// One over the rms of each joint's rows; none for joints without a measurement.
fn weights(data: &Data, rows: &[Vec<f64>]) -> Vec<f64> {
    let weight = |(rows, silent): (&Vec<f64>, &bool)| if *silent { 0.0 } else { 1.0 / rms(rows).max(1e-12) };
    rows.iter().zip(&data.silent).map(weight).collect()
}

/// Sum of vectors of equal length.
pub(super) fn sum(parts: &[Vec<f64>]) -> Vec<f64> {
    let mut total = vec![0.0; parts.first().map_or(0, Vec::len)];
    for part in parts {
        total.iter_mut().zip(part).for_each(|(t, x)| *t += x);
    }
    total
}

/// Root mean square of the rows that count: those that are left out are zero to the bit.
pub(super) fn rms(x: &[f64]) -> f64 {
    let counted = x.iter().filter(|x| **x != 0.0).count();
    (square_sum(x) / counted.max(1) as f64).sqrt()
}

/// Sum of squares.
pub(super) fn square_sum(x: &[f64]) -> f64 {
    x.iter().map(|x| x * x).sum()
}

fn gram(columns: &[Arc<Column>], active: &[usize], joint: usize, ranges: &[Range<usize>]) -> Vec<f64> {
    let n = active.len();
    let mut gram = vec![0.0; n * n];
    let rows: Vec<&[f64]> = active.iter().filter_map(|&c| columns[c].part(joint)).collect();
    for range in ranges {
        for i in 0..n {
            let mut k = 0;
            let others = rows[..=i].iter().map(|r| &r[range.clone()]);
            dots(&rows[i][range.clone()], others, |dot| {
                gram[i * n + k] += dot;
                k += 1;
            });
        }
    }
    gram
}
