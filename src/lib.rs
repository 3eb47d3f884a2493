//! Identify robot arms from their logs, and find the physics the model is missing.

pub mod benchmark;
pub mod check;
pub mod conformance;
pub mod constraints;
pub mod diagnose;
pub mod effects;
pub mod error;
pub mod excitation;
pub mod export;
pub mod form;
pub mod identify;
pub mod kernels;
pub mod linalg;
pub mod log;
pub mod model;
pub mod model_file;
pub mod plant;
pub mod predict;
mod random;
pub mod report;
pub mod retrieval;
pub mod robot;
pub mod scenario;
pub mod script;
pub mod signals;
pub mod simulate;
pub mod space;
mod stop;
pub mod study;
pub mod text;
pub mod workbench;

pub use error::{Error, Result};
