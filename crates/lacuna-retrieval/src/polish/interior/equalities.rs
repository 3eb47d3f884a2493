//! Equations among the unknowns: affine conditions that come in opposite pairs (`row >= 0` and
//! `-row >= 0`) have no interior; steps are taken within them instead.

use nalgebra::{DMatrix, DVector};

use super::cholesky::{dot, factor, solve};
use crate::Quadratic;
use crate::form::Affine;

/// Rows whose remainder is below this part of their size follow from earlier ones.
const DEPENDENT: f64 = 1e-10;

/// Independent equations `rows x = values`.
#[derive(Debug, Clone, Default)]
pub(super) struct Equalities {
    /// Dense, orthonormal.
    rows: Vec<Vec<f64>>,
    values: Vec<f64>,
}

impl Equalities {
    /// Takes the opposite pairs out of a list of conditions on `size` unknowns.
    pub(super) fn extract(conditions: &mut Vec<Affine>, size: usize) -> Self {
        let mut all = Self::default();
        let sorted = |row: &Affine| {
            let mut terms = row.terms.clone();
            terms.retain(|t| t.1.abs() > 0.0);
            terms.sort_unstable_by_key(|t| t.0);
            terms
        };
        let mut i = 0;
        while i < conditions.len() {
            let (terms, constant) = (sorted(&conditions[i]), conditions[i].constant);
            let opposite = |other: &Affine| {
                let others = sorted(other);
                !terms.is_empty()
                    && others.len() == terms.len()
                    && terms.iter().zip(&others).all(|(a, b)| a.0 == b.0 && near(a.1, -b.1))
                    && near(constant, -other.constant)
            };
            match (i + 1..conditions.len()).find(|&j| opposite(&conditions[j])) {
                Some(j) => {
                    conditions.remove(j);
                    let row = conditions.remove(i);
                    all.push(&row, size);
                }
                None => i += 1,
            }
        }
        all
    }

    /// Orthogonalises a new equation; one that follows from the others is left out.
    fn push(&mut self, row: &Affine, size: usize) {
        let (mut dense, mut value) = (vec![0.0; size], -row.constant);
        row.terms.iter().for_each(|&(i, f)| dense[i] += f);
        let before = dot(&dense, &dense).sqrt();
        for _ in 0..2 {
            for (other, &v) in self.rows.iter().zip(&self.values) {
                let share = dot(&dense, other);
                dense.iter_mut().zip(other).for_each(|(a, b)| *a -= share * b);
                value -= share * v;
            }
        }
        let norm = dot(&dense, &dense).sqrt();
        if norm > DEPENDENT * before {
            dense.iter_mut().for_each(|a| *a /= norm);
            self.rows.push(dense);
            self.values.push(value / norm);
        }
    }

    pub(super) fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// The sum of squared defects, to be minimised within bounds.
    pub(super) fn defect(&self) -> Quadratic {
        let size = self.rows.first().map_or(0, Vec::len);
        Quadratic {
            r: DMatrix::from_fn(self.rows.len(), size, |i, j| self.rows[i][j]),
            d: DVector::from_column_slice(&self.values),
            floor: 0.0,
            unit: String::new(),
        }
    }

    /// The nearest point that satisfies them; slacks behind the unknowns stay.
    pub(super) fn project(&self, x: &mut [f64]) {
        for (row, value) in self.rows.iter().zip(&self.values) {
            let defect = value - dot(row, &x[..row.len()]);
            x.iter_mut().zip(row).for_each(|(x, r)| *x += defect * r);
        }
    }

    /// Turns a Newton direction into the best one within the equations, given the Hessian's factor.
    pub(super) fn restrict(&self, hessian: &[f64], n: usize, direction: &mut [f64]) {
        let m = self.rows.len();
        if m == 0 {
            return;
        }
        let columns: Vec<Vec<f64>> = self
            .rows
            .iter()
            .map(|row| {
                let mut column = vec![0.0; n];
                column[..row.len()].copy_from_slice(row);
                solve(hessian, n, &mut column);
                column
            })
            .collect();
        let along = |column: &[f64], row: &[f64]| dot(&column[..row.len()], row);
        let mut schur: Vec<f64> = (0..m * m).map(|k| along(&columns[k / m], &self.rows[k % m])).collect();
        let mut pull: Vec<f64> = self.rows.iter().map(|row| -along(direction, row)).collect();
        if !factor(&mut schur, m) {
            direction.fill(0.0);
            return;
        }
        solve(&schur, m, &mut pull);
        for (column, pull) in columns.iter().zip(pull) {
            direction.iter_mut().zip(column).for_each(|(d, c)| *d += pull * c);
        }
        // Rounding would add up over many steps.
        for row in &self.rows {
            let defect = along(direction, row);
            direction.iter_mut().zip(row).for_each(|(d, r)| *d -= defect * r);
        }
    }
}

/// Equal up to rounding.
fn near(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-13 * a.abs().max(b.abs())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn opposite_pairs_become_equations() {
        let v = Affine::variable;
        let sum = v(0).plus(1.0, &v(1)).plus(-1.0, &Affine::constant(1.0));
        let mut conditions = vec![v(0), sum.clone(), v(2), sum.times(-1.0), v(1).times(2.0)];
        let equalities = Equalities::extract(&mut conditions, 3);
        assert_eq!(conditions.len(), 3);
        assert_eq!(equalities.rows.len(), 1);
        let mut x = [3.0, 0.0, 5.0];
        equalities.project(&mut x);
        assert!((x[0] - 2.0).abs() < 1e-12 && (x[1] + 1.0).abs() < 1e-12 && (x[2] - 5.0).abs() < 1e-12);
        // With the Hessian 1, the direction is projected.
        let mut identity = vec![0.0; 9];
        (0..3).for_each(|i| identity[4 * i] = 1.0);
        let mut direction = [1.0, 0.0, 7.0];
        equalities.restrict(&identity, 3, &mut direction);
        assert!((direction[0] - 0.5).abs() < 1e-12 && (direction[1] + 0.5).abs() < 1e-12);
    }
}
