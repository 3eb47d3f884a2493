//! Identify robot arms from their logs, and find the physics the model is missing.

pub mod benchmark;
pub mod check;
pub mod conformance;
pub mod constraints;
pub mod diagnose;
pub mod effects;
pub mod export;
pub mod identify;
pub mod kernels;
pub mod linalg;
pub mod model;
pub mod model_file;
pub mod predict;
pub mod report;
pub mod scenario;
pub mod script;
pub mod signals;
pub mod simulate;
pub mod study;

pub use lacuna_base::{Error, Result, error, excitation, log, random, robot, stop, text};
pub use lacuna_plant as plant;
pub use lacuna_retrieval as retrieval;
pub use lacuna_retrieval::{form, space};
