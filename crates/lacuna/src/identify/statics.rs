//! Identification from static poses: the numerical inertia matrix and gravity torque read out at rest
//! (the reverse engineering of Gaz et al. 2019, section IV-A, eq. 17-22).

use nalgebra::DMatrix;

use crate::error::{Error, Result};
use crate::kernels::{Chain, static_regressor};
use crate::linalg::{Solution, Triangle, condition_number};
use crate::log::StaticPoses;
use crate::robot::Robot;

use super::base::BaseParameters;

/// Poses turned into rows at once.
const BLOCK: usize = 16;
/// A gravity row carries nothing when its torque stays below this part of the largest read-out.
const SILENT: f64 = 1e-9;

/// Result of the identification from static poses.
#[derive(Debug, Clone, PartialEq)]
pub struct StaticFit {
    /// Base parameters of the robot.
    pub base: BaseParameters,
    /// One value per base parameter.
    pub coefficients: Vec<f64>,
    /// `(YᵀY)⁻¹`.
    pub inverse: DMatrix<f64>,
    /// Sum of squared residuals, mixed units (kg m², kg m, kg and N m rows alike).
    pub residual_squares: f64,
    /// Norm of the stacked read-outs.
    pub norm: f64,
    /// Number of scalar rows.
    pub rows: usize,
    /// Condition number of the regressor, SI units, unscaled.
    pub condition_number: f64,
    /// Joints whose gravity row carries nothing and was left out.
    pub silent_gravity: Vec<usize>,
}

impl StaticFit {
    /// Fits all base parameters to the poses.
    ///
    /// # Errors
    /// When there are too few poses, or they leave a base parameter undetermined.
    pub fn new(robot: &Robot, poses: &StaticPoses) -> Result<Self> {
        let (n, count) = (robot.dof(), poses.rows());
        let base = BaseParameters::new(robot);
        let silent = silent_gravity(poses);
        let per_pose = n * (n + 1) / 2 + n - silent.len();
        let p = base.rank();
        if count * per_pose <= p {
            return Err(Error::new(format!("{count} poses give {} rows for {p} unknowns", count * per_pose))
                .help("record more poses; rows should far outnumber unknowns (eq. 18)"));
        }
        let triangle = absorb(&Chain::new(robot), &base, poses, &silent);
        let solution = Solution::new(&triangle).map_err(|e| {
            Error::new(format!("the poses do not determine all base parameters: {}", e.message()))
                .help("add poses that differ in every joint")
        })?;
        Ok(Self {
            coefficients: solution.x.clone(),
            inverse: solution.inverse.clone(),
            residual_squares: solution.residual_squares,
            norm: triangle.column_squares(p).sqrt(),
            rows: solution.rows,
            condition_number: condition_number(&triangle),
            silent_gravity: silent,
            base,
        })
    }

    /// `100 |residual| / |read-outs|` (Sousa and Cortesão 2014, eq. 84).
    pub fn relative_error_percent(&self) -> f64 {
        100.0 * self.residual_squares.sqrt() / self.norm
    }

    /// Standard deviation of the rows as the residual shows it.
    pub fn residual_deviation(&self) -> f64 {
        (self.residual_squares / (self.rows - self.coefficients.len()) as f64).sqrt()
    }

    /// Standard deviation of the rows that a relative error in per cent implies; the paper's 0.0315 %
    /// belongs to raw read-outs.
    pub fn deviation_implied_by(&self, relative_error_percent: f64) -> f64 {
        let residual = relative_error_percent / 100.0 * self.norm;
        residual / ((self.rows - self.coefficients.len()) as f64).sqrt()
    }

    /// Standard deviation of every coefficient when rows have standard deviation `sigma`.
    pub fn standard_deviations(&self, sigma: f64) -> Vec<f64> {
        (0..self.coefficients.len()).map(|i| sigma * self.inverse[(i, i)].sqrt()).collect()
    }
}

/// Standard deviation of each value in per cent of its size (of the unrounded value).
pub fn relative_deviations(values: &[f64], deviations: &[f64]) -> Vec<f64> {
    values.iter().zip(deviations).map(|(x, sd)| 100.0 * sd / x.abs()).collect()
}

fn silent_gravity(poses: &StaticPoses) -> Vec<usize> {
    let largest = |rows: &[Vec<f64>]| rows.iter().flatten().fold(0.0_f64, |m, x| m.max(x.abs()));
    let scale = largest(&poses.g).max(largest(&poses.m));
    (0..poses.g.len()).filter(|&j| largest(&poses.g[j..=j]) <= SILENT * scale).collect()
}

/// Streams the rows of all poses into a triangle: base columns, then the read-outs.
fn absorb(chain: &Chain, base: &BaseParameters, poses: &StaticPoses, silent: &[usize]) -> Triangle {
    let n = chain.dof();
    let triangle_rows = n * (n + 1) / 2;
    let kept: Vec<usize> =
        (0..triangle_rows + n).filter(|r| !silent.iter().any(|j| r == &(triangle_rows + j))).collect();
    let width = base.rank() + 1;
    let mut sum = Triangle::new(width);
    let count = poses.rows();
    for first in (0..count).step_by(BLOCK) {
        let last = (first + BLOCK).min(count);
        let rows = (last - first) * kept.len();
        let length = Triangle::padded(rows);
        let mut block = vec![0.0; width * length];
        for pose in first..last {
            let q: Vec<f64> = poses.q.iter().map(|q| q[pose]).collect();
            let y = static_regressor(chain, &q);
            let columns = y.len() / (triangle_rows + n);
            for (i, &row) in kept.iter().enumerate() {
                let at = (pose - first) * kept.len() + i;
                for (c, &pivot) in base.pivots.iter().enumerate() {
                    block[c * length + at] = y[row * columns + pivot];
                }
                block[(width - 1) * length + at] =
                    if row < triangle_rows { poses.m[row][pose] } else { poses.g[row - triangle_rows][pose] };
            }
        }
        sum.absorb(&mut block, rows);
    }
    sum
}
