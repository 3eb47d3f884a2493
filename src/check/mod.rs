//! Is this file what it should be? Checks of every kind of file, and of a log against its robot.

mod pair;

pub use pair::{Finding, Findings, Severity, log_against_robot};
