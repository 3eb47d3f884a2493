//! The Lagrangian form `M(q) ddq + c(q, dq) + g(q)` from the static regressor alone, with the velocity
//! terms from Christoffel symbols of that `M` (Gaz et al. 2019, eq. 22-23). An independent route to the
//! same torque as [`super::inverse_dynamics`].

use super::chain::Chain;
use super::motion::State;
use super::real::Dual;
use super::regressor::static_regressor;
use crate::robot::PARAMETERS_PER_LINK;

/// Inertia matrix, velocity torque and gravity torque at one state.
#[derive(Debug, Clone, PartialEq)]
pub struct LagrangianTerms {
    /// `M(q)`, row by row.
    pub mass_matrix: Vec<f64>,
    /// `c(q, dq)` [N m, N].
    pub coriolis: Vec<f64>,
    /// `g(q)` [N m, N].
    pub gravity: Vec<f64>,
}

impl LagrangianTerms {
    /// Evaluates the three terms for stacked inertial parameters; derivatives of `M` are exact.
    pub fn new(chain: &Chain, q: &[f64], dq: &[f64], parameters: &[f64]) -> Self {
        let n = chain.dof();
        let triangle = n * (n + 1) / 2;
        let at = static_regressor(chain, q);
        let value = |row: usize| -> f64 { product(&at, row, parameters) };
        let full = |lower: &[f64]| -> Vec<f64> {
            (0..n * n)
                .map(|k| {
                    let (i, j) = ((k / n).max(k % n), (k / n).min(k % n));
                    lower[i * (i + 1) / 2 + j]
                })
                .collect()
        };
        let mass_matrix = full(&(0..triangle).map(value).collect::<Vec<_>>());
        let gravity = (0..n).map(|i| value(triangle + i)).collect();
        let slopes: Vec<Vec<f64>> = (0..n).map(|k| full(&mass_slope(chain, q, k, parameters))).collect();
        // c_i = sum_jk (dM_ij/dq_k - dM_jk/dq_i / 2) dq_j dq_k
        let coriolis = (0..n)
            .map(|i| {
                let mut sum = 0.0;
                for j in 0..n {
                    for k in 0..n {
                        sum += (slopes[k][i * n + j] - 0.5 * slopes[i][j * n + k]) * dq[j] * dq[k];
                    }
                }
                sum
            })
            .collect();
        Self { mass_matrix, coriolis, gravity }
    }

    /// Joint torque for accelerations `ddq` [N m, N].
    pub fn torque(&self, ddq: &[f64]) -> Vec<f64> {
        let n = ddq.len();
        (0..n)
            .map(|i| {
                let inertial: f64 = (0..n).map(|j| self.mass_matrix[i * n + j] * ddq[j]).sum();
                inertial + self.coriolis[i] + self.gravity[i]
            })
            .collect()
    }
}

/// Torque in the Lagrangian form; see [`LagrangianTerms`].
pub fn lagrangian_torque(chain: &Chain, state: State<'_, f64>, parameters: &[f64]) -> Vec<f64> {
    LagrangianTerms::new(chain, state.q, state.dq, parameters).torque(state.ddq)
}

fn product(rows: &[f64], row: usize, parameters: &[f64]) -> f64 {
    let width = parameters.len();
    rows[row * width..(row + 1) * width].iter().zip(parameters).map(|(y, p)| y * p).sum()
}

/// Derivative of the lower triangle of `M` with respect to `q_k`.
fn mass_slope(chain: &Chain, q: &[f64], k: usize, parameters: &[f64]) -> Vec<f64> {
    let n = chain.dof();
    let at: Vec<Dual> = q
        .iter()
        .enumerate()
        .map(|(i, &x)| if i == k { Dual::variable(x) } else { Dual::constant(x) })
        .collect();
    let rows = static_regressor(chain, &at);
    let width = PARAMETERS_PER_LINK * n;
    rows.chunks_exact(width)
        .take(n * (n + 1) / 2)
        .map(|row| row.iter().zip(parameters).map(|(y, p)| y.slope * p).sum())
        .collect()
}
