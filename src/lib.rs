//! Identify robot arms from their logs, and find the physics the model is missing.

pub mod effects;
pub mod error;
pub mod excitation;
pub mod identify;
pub mod kernels;
pub mod linalg;
pub mod log;
pub mod model;
pub mod plant;
pub mod robot;
pub mod signals;

pub use error::{Error, Result};
