//! What is missing? Compares a model with measurements, says where it fails, and names the physical effect
//! that would explain the difference, by what it explains in data that no fit has seen.
//!
//! The way of a diagnosis:
//!
//! 1. The signal step is chosen by held-out error ([`signals`](self)), so that a filter's doing is not
//!    called physics.
//! 2. Every candidate of the catalogue is fitted together with the whole model (never to the residual) on
//!    training blocks; what it predicts in the held-out blocks is scored with a variance that allows for
//!    autocorrelation. The threshold is calibrated on the user's own data by sign flips.
//! 3. The candidate that explains most in units of each joint's noise floor is added, the simplest of those
//!    that tie with it; its nonlinear parameters are refined, everything is fitted again, and so on.
//! 4. At the end every effect must still be needed beside all the others.
//!
//! What it cannot do: tell effects apart that the motion does not separate (it says so), and name an effect
//! that no catalogue entry, script or formula can express (it says on which joint and variable it depends).

mod adding;
mod answer;
mod asked;
mod base;
mod candidates;
mod choosing;
mod closing;
mod data;
mod doubts;
mod entry;
mod events;
mod first;
mod fitting;
mod floor;
mod gates;
mod ladder;
mod late;
mod looking_back;
mod nested;
mod normal;
mod parts;
mod pictures;
mod pieces;
mod poor;
mod present;
mod refine;
mod regions;
mod score;
mod search;
mod sharpness;
mod signals;
mod telling;
mod unknown;
mod unseen;

pub use crate::stop::Stop;
pub use answer::{
    Baseline, Diagnosis, Event, First, Inseparable, Joint, Missing, Moved, Nested, Parameter, Refused,
    Region, Signals, Step, Undecided, Unexplained, Validation, Verdict,
};
pub use closing::Proposed;
pub use entry::{Outcome, Request, Start, diagnose};
pub use fitting::{Fitted, Fitting, JointFit};
pub use unseen::unseen_error;

/// When something is believed.
#[derive(Debug, Clone, PartialEq)]
pub struct Limits {
    /// Least z of a held-out effect; raised where sign flips of the same data reach higher.
    pub least_z: f64,
    /// Least part of the held-out weighted squared error.
    pub least_share: f64,
    /// Least part of the held-out squared error of a joint that it acts on: what matters less is no finding.
    pub least_of_joint: f64,
    /// Least gain in units of the noise floor, per sample.
    pub least_usefulness: f64,
    /// Least z without the one second that helps most.
    pub z_without_best: f64,
    /// Most that one second may bring of an effect's gain, unless it is significant without that second: physics acts
    /// more than once.
    pub most_in_one_second: f64,
    /// Two explanations tie when one has this part of the other's gain, and the paired losses do not differ.
    pub tie_gain: f64,
    /// Sign flips cannot raise the threshold beyond this, the most that they reach on pure noise: where large
    /// structure is left in the residual they reach far higher.
    pub most_z: f64,
    /// Replicates that calibrate the threshold.
    pub sign_flips: usize,
    /// Most effects that are added.
    pub steps: usize,
    /// A formula needs this z and this part of its joint's held-out squared error.
    pub formula: (f64, f64),
    /// A variable without a formula needs this z and this part of its joint's held-out squared error.
    pub variable: (f64, f64),
    /// When the search ends whatever is left.
    pub stop: Stop,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            least_z: 5.5,
            least_share: 0.002,
            least_of_joint: 0.05,
            least_usefulness: 0.1,
            z_without_best: 3.0,
            most_in_one_second: 0.6,
            tie_gain: 0.75,
            most_z: 5.8,
            sign_flips: 40,
            steps: 40,
            formula: (6.0, 0.35),
            variable: (7.5, 0.25),
            stop: Stop::default(),
        }
    }
}
