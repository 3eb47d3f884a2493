//! Solutions and their uncertainty from a [`Triangle`].

use nalgebra::{DMatrix, DVector};

use super::Triangle;
use crate::error::{Error, Result};

/// Least-squares solution of `A x = b`, where the triangle's last column is `b`.
#[derive(Debug, Clone, PartialEq)]
pub struct Solution {
    /// One value per unknown.
    pub x: Vec<f64>,
    /// `(AᵀA)⁻¹`.
    pub inverse: DMatrix<f64>,
    /// Sum of squared residuals.
    pub residual_squares: f64,
    /// Number of rows.
    pub rows: usize,
}

impl Solution {
    /// Solves by back substitution.
    ///
    /// # Errors
    /// When the columns are linearly dependent to working precision; the message names the column's number.
    pub fn new(triangle: &Triangle) -> Result<Self> {
        let n = triangle.columns() - 1;
        let (r, x) = back_substituted(triangle)?;
        let root = r.solve_upper_triangular(&DMatrix::identity(n, n)).ok_or_else(singular)?;
        Ok(Self {
            x: x.iter().copied().collect(),
            inverse: product(&root, &root.transpose()),
            residual_squares: triangle.at(n, n).powi(2),
            rows: triangle.rows(),
        })
    }

    /// Residual variance `|r|² / (rows - unknowns)`; `None` when rows do not outnumber unknowns.
    pub fn variance(&self) -> Option<f64> {
        let free = self.rows.checked_sub(self.x.len()).filter(|&f| f > 0)?;
        Some(self.residual_squares / free as f64)
    }
}

/// The unknowns of a [`Solution`] alone, to the same bits.
///
/// # Errors
/// As [`Solution::new`].
pub(crate) fn solved(triangle: &Triangle) -> Result<Vec<f64>> {
    Ok(back_substituted(triangle)?.1.iter().copied().collect())
}

/// The factor without its right-hand side, and the unknowns.
fn back_substituted(triangle: &Triangle) -> Result<(DMatrix<f64>, DVector<f64>)> {
    let n = triangle.columns() - 1;
    let r = factor(triangle);
    for j in 0..n {
        let size = triangle.column_squares(j).sqrt();
        let pivot = r[(j, j)].abs();
        if pivot.is_nan() || pivot <= 1e-13 * size {
            return Err(Error::new(format!("column {j} of the regressor depends on the columns before it"))
                .help("record a richer motion, or leave out the effect this column belongs to"));
        }
    }
    let b = DVector::from_fn(n, |i, _| triangle.at(i, n));
    let x = r.solve_upper_triangular(&b).ok_or_else(singular)?;
    Ok((r, x))
}

fn singular() -> Error {
    Error::new(
        "the regressor is singular: some parameter has no influence on the torque, or several have the same",
    )
    .help("record a richer motion, or leave out the effect that asks for it")
}

/// Condition number in the 2-norm of the columns without the right-hand side, unscaled.
pub fn condition_number(triangle: &Triangle) -> f64 {
    let values = factor(triangle).singular_values();
    values.max() / values.min()
}

/// `a b` by plain sums. The library's own product of large matrices fuses multiplication and addition on
/// some processors, and results must not depend on the processor.
pub fn product(a: &DMatrix<f64>, b: &DMatrix<f64>) -> DMatrix<f64> {
    DMatrix::from_fn(a.nrows(), b.ncols(), |i, j| (0..a.ncols()).map(|k| a[(i, k)] * b[(k, j)]).sum())
}

fn factor(triangle: &Triangle) -> DMatrix<f64> {
    let n = triangle.columns() - 1;
    DMatrix::from_fn(n, n, |i, j| triangle.at(i, j))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(count: usize) -> Vec<[f64; 4]> {
        (0..count)
            .map(|k| {
                let t = k as f64 * 0.37;
                [1.0, t.sin(), t * 0.1, 2.0 - 3.0 * t.sin() + 0.5 * t * 0.1 + 0.01 * (7.0 * t).cos()]
            })
            .collect()
    }

    fn absorbed(rows: &[[f64; 4]], step: usize) -> Triangle {
        let mut triangle = Triangle::new(4);
        for part in rows.chunks(step) {
            let length = Triangle::padded(part.len());
            let mut block = vec![0.0; 4 * length];
            for (k, row) in part.iter().enumerate() {
                for (j, value) in row.iter().enumerate() {
                    block[j * length + k] = *value;
                }
            }
            triangle.absorb(&mut block, part.len());
        }
        triangle
    }

    #[test]
    fn equals_nalgebra_whatever_the_block_size() {
        let rows = rows(1000);
        let a = DMatrix::from_fn(1000, 3, |i, j| rows[i][j]);
        let b = DVector::from_fn(1000, |i, _| rows[i][3]);
        let reference = a.clone().svd(true, true).solve(&b, 1e-12).expect("full rank");
        for step in [1, 7, 16, 100, 1000] {
            let triangle = absorbed(&rows, step);
            let solution = Solution::new(&triangle).expect("full rank");
            for (x, y) in solution.x.iter().zip(reference.iter()) {
                assert!((x - y).abs() < 1e-12, "{x} {y}");
            }
            let residual = (&a * &reference - &b).norm_squared();
            assert!((solution.residual_squares - residual).abs() < 1e-12);
            let singular = a.singular_values();
            assert!((condition_number(&triangle) - singular.max() / singular.min()).abs() < 1e-9);
        }
    }

    #[test]
    fn merged_triangles_are_as_good_as_all_rows() {
        let rows = rows(500);
        let whole = Solution::new(&absorbed(&rows, 64)).expect("full rank");
        let mut merged = absorbed(&rows[..123], 64);
        merged.merge_same(&absorbed(&rows[123..], 64));
        let parts = Solution::new(&merged).expect("full rank");
        assert_eq!(parts.rows, 500);
        for (x, y) in whole.x.iter().zip(&parts.x) {
            assert!((x - y).abs() < 1e-13);
        }
    }

    #[test]
    fn dependent_columns_are_refused() {
        let twice: Vec<[f64; 4]> = rows(50).iter().map(|r| [r[0], r[1], 2.0 * r[1], r[3]]).collect();
        assert!(Solution::new(&absorbed(&twice, 16)).is_err());
    }
}
