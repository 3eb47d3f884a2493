//! Measurements from a described plant: what `lacuna simulate` does.
//!
//! An [`Experiment`] says which robot, which physics beside its rigid links, which controller and sensors, and
//! which logs to record. [`run`] records them. What was really so goes into a folder of its own, and no other
//! part of this crate knows that folder's name.

mod experiment;
pub mod hidden;
mod recording;

pub use experiment::{Experiment, Recording};
pub use recording::{Outcome, Recorded, files, open, run};

use crate::error::Result;
use crate::excitation::{FourierMotion, Motion, panda_table_ii};
use crate::robot::Robot;
use crate::scenario::Commanded;

/// The motion that `commanded` asks of `robot`; `seed` draws it where it is random.
///
/// # Errors
/// When a random motion finds no joint limits, or has no harmonics.
pub fn motion(robot: &Robot, commanded: &Commanded, seed: u64) -> Result<Box<dyn Motion>> {
    Ok(match commanded {
        Commanded::Fourier(motion) => Box::new(motion.clone()),
        Commanded::Sinusoidal(motion) => Box::new(motion.clone()),
        Commanded::PandaTableII => Box::new(panda_table_ii()),
        Commanded::Random { harmonics, period_s, amplitude } => {
            Box::new(FourierMotion::random(robot, seed, *harmonics, *period_s, *amplitude)?)
        }
    })
}
