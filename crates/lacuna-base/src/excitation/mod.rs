//! Motions that make a robot show its dynamics: what a controller is asked to follow, and where to pose.
//!
//! Every motion gives position, velocity and acceleration in closed form, so that they agree exactly.

mod configurations;
mod fourier;
mod panda;
mod ramped;
mod sinusoidal;

pub use configurations::{position_range, random_configurations};
pub use fourier::{DEFAULT_SPEED, FourierMotion};
pub use panda::{PANDA_EQ_31_AMPLITUDES, panda_eq_31, panda_table_ii};
pub use ramped::Ramped;
pub use sinusoidal::SinusoidalVelocity;

use std::fmt::Debug;

use crate::error::{Error, Result};

/// A motion of all joints, defined at every instant.
pub trait Motion: Debug + Send + Sync {
    /// Number of joints it moves.
    fn dof(&self) -> usize;

    /// Writes position [rad, m], velocity [1/s of that] and acceleration [1/s² of that] at time `t` \[s\].
    ///
    /// # Panics
    /// When a slice is shorter than [`Motion::dof`].
    fn at(&self, t: f64, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]);
}

impl<M: Motion + ?Sized> Motion for Box<M> {
    fn dof(&self) -> usize {
        (**self).dof()
    }

    fn at(&self, t: f64, q: &mut [f64], dq: &mut [f64], ddq: &mut [f64]) {
        (**self).at(t, q, dq, ddq);
    }
}

/// Refuses anything but finite numbers, naming them.
fn all_finite<'a>(what: &str, numbers: impl IntoIterator<Item = &'a f64>) -> Result<()> {
    match numbers.into_iter().find(|x| !x.is_finite()) {
        Some(x) => Err(Error::new(format!("{what} holds {x}")).help("give finite numbers")),
        None => Ok(()),
    }
}

/// Refuses all but positive durations, naming them.
fn positive_duration(what: &str, seconds: f64) -> Result<()> {
    if seconds.is_finite() && seconds > 0.0 {
        return Ok(());
    }
    Err(Error::new(format!("{what} is {seconds} s")).help("give a positive number of seconds"))
}

#[cfg(test)]
pub(crate) mod check {
    use super::Motion;

    /// Largest disagreement between derivatives as given and central differences of step `h`.
    pub(crate) fn derivative_error(motion: &dyn Motion, times: impl Iterator<Item = f64>, h: f64) -> f64 {
        let n = motion.dof();
        let sample = |t: f64| {
            let (mut q, mut dq, mut ddq) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
            motion.at(t, &mut q, &mut dq, &mut ddq);
            (q, dq, ddq)
        };
        let mut worst = 0.0_f64;
        for t in times {
            let (before, here, after) = (sample(t - h), sample(t), sample(t + h));
            for j in 0..n {
                let velocity = (after.0[j] - before.0[j]) / (2.0 * h);
                let acceleration = (after.1[j] - before.1[j]) / (2.0 * h);
                worst = worst.max((velocity - here.1[j]).abs()).max((acceleration - here.2[j]).abs());
            }
        }
        worst
    }
}
