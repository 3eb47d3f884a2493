//! Rigid-body kernels: inverse dynamics, inertia matrix, regressors, Lagrangian terms.
//!
//! All of them read a [`Chain`] and work on any [`Real`]: one sample, several side by side, or dual
//! numbers. Frames, order and units of the parameters are those of [`crate::robot::InertialParameters`].

mod axes;
mod batch;
mod chain;
mod derivative;
mod lagrange;
mod mass;
mod motion;
mod real;
mod regressor;
mod rnea;
mod trig;
mod vector;

pub use batch::{RegressorBlock, Samples, inverse_dynamics_batch};
pub use chain::Chain;
pub use derivative::{Direction, torque_derivative_batch};
pub use lagrange::{LagrangianTerms, lagrangian_torque};
pub use mass::{MassMatrix, MassMatrixBlock};
pub use motion::{State, Workspace};
pub use real::{Dual, Lanes, Real};
pub use regressor::{Twists, regressor, static_regressor};
pub use rnea::{inverse_dynamics, wrench};

#[cfg(test)]
mod tests;
