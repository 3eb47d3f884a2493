//! Identification: base parameters, least squares, uncertainty, the paper's two ways.

mod base;
mod evidence;
mod fit;
mod friction;
mod levenberg;
mod rows;
mod settle;
mod statics;
mod uncertainty;

pub use base::{BaseParameters, parameter_name};
pub use evidence::{Evidence, RowWeight};
pub use fit::{
    ErrorSums, Errors, Fit, Weighting, errors, fit, fit_huber, fit_with_weights, held_out, with_robust_sd,
};
pub(crate) use friction::STEEPEST;
pub use friction::{Search, SigmoidFit, fit_sigmoid};
pub use rows::{RowView, over_rows};
pub use settle::{Settled, refresh_model_torque, settle, with_model_torque};
pub use statics::{StaticFit, relative_deviations};
pub use uncertainty::{BANDWIDTH_S, score_variance};
