//! Is this file what it should be? Checks of every kind of file, and of a log against its robot.
//!
//! [`file()`] recognises a file and says what it is, what it will do and what is wrong with it.
//! [`log_against_robot`] tests the mistakes that reading alone cannot see: units, signs, order of joints,
//! mounting, torque without gravity, a Denavit-Hartenberg table in the wrong convention.

mod effect_script;
mod fields;
mod file;
mod kind;
mod log;
mod pair;
mod report;
mod robot;
mod scenario;
mod script;

pub use file::{Options, file, log_against_file};
pub use kind::{Kind, misplaced, recognise};
pub use log::{JointRange, LogFacts};
pub use pair::{Finding, Findings, Severity, log_against_robot};
pub use report::{Problem, Report, Section};
pub use robot::{JointFacts, RobotFacts};
