//! The objective: a sum of squares, linear inside.

use nalgebra::{DMatrix, DVector};

/// `|r z - d|² + floor`: the distance to identified coefficients (two-step), or the torque error from the
/// triangle of the stacked regressor (one-step), where `floor` is the part no parameter can change.
#[derive(Debug, Clone, PartialEq)]
pub struct Quadratic {
    /// One row per residual.
    pub r: DMatrix<f64>,
    /// What `r z` should be.
    pub d: DVector<f64>,
    /// Constant part.
    pub floor: f64,
    /// Unit of the value, for reports.
    pub unit: String,
}

impl Quadratic {
    /// Value at `z`.
    pub fn value(&self, z: &[f64]) -> f64 {
        self.residual(z).norm_squared() + self.floor
    }

    /// `r z - d`.
    pub fn residual(&self, z: &[f64]) -> DVector<f64> {
        let mut rest = -&self.d;
        for (column, &value) in self.r.column_iter().zip(z) {
            rest.axpy(value, &column, 1.0);
        }
        rest
    }

    /// Gradient `2 rᵀ (r z - d)`.
    pub fn gradient(&self, z: &[f64]) -> DVector<f64> {
        let rest = self.residual(z);
        DVector::from_iterator(self.r.ncols(), self.r.column_iter().map(|c| 2.0 * c.dot(&rest)))
    }
}
