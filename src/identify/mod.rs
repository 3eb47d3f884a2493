//! Identification.

mod base;

pub use base::{BaseParameters, parameter_name};
