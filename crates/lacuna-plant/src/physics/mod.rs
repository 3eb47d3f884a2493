//! The effects of the catalogue, and some that no catalogue has, as physics of the plant. One file each
//! (close relatives together), written from the formulas and not from the code that is fitted to them.

mod asymmetric;
mod base_tilt;
mod contact;
mod coupled;
mod drift;
mod elasticity;
mod factor;
mod load_dependent;
mod measurement;
mod nonlinear_viscous;
mod payload;
mod position;
mod presliding;
mod product;
mod stribeck;
#[cfg(test)]
mod tests;
mod thermal;

pub use asymmetric::AsymmetricFriction;
pub use base_tilt::BaseTilt;
pub use contact::ContactForce;
pub use coupled::CoupledFriction;
pub use drift::{FrictionDrift, TorqueDrift};
pub use elasticity::{Backlash, JointElasticity};
pub use factor::Factor;
pub use load_dependent::LoadDependentFriction;
pub use measurement::{JointZeroError, TimeDelay, TorqueGain};
pub use nonlinear_viscous::NonlinearViscousFriction;
pub use payload::Payload;
pub use position::{JointSpring, PositionDependentFriction, TorqueRipple};
pub use presliding::PreslidingHysteresis;
pub use product::Product;
pub use stribeck::StribeckFriction;
pub use thermal::ThermalFriction;

use super::per_joint::PerJoint;
use super::{effect, twin};
use lacuna_base::error::{Error, Result};

/// Velocity at which a smoothed sign has reached 76 %, unless said otherwise [rad/s, m/s].
fn usual_width() -> f64 {
    5e-3
}

/// A sign with a smooth passage through rest.
fn smooth_sign(velocity: f64, width: f64) -> f64 {
    libm::tanh(velocity / width)
}

/// Refuses all but positive, finite numbers; `what` names the number in the message.
fn check_positive(what: &str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::new(format!("{what} is {value}")).help("give a positive number"))
}

/// Refuses numbers that are not finite.
fn check_finite(what: &str, values: &[f64]) -> Result<()> {
    match values.iter().find(|x| !x.is_finite()) {
        Some(x) => Err(Error::new(format!("{what} holds {x}")).help("give finite numbers")),
        None => Ok(()),
    }
}

/// The index of joint number `number` (from 1, as in `q1`) of a robot with `dof` joints.
fn joint_index(what: &str, number: usize, dof: usize) -> Result<usize> {
    if (1..=dof).contains(&number) {
        return Ok(number - 1);
    }
    Err(Error::new(format!("{what} names joint {number} of a robot with {dof}"))
        .help("joints count from 1, as in the columns q1, q2, ... of a log"))
}
