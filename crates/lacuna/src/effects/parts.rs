//! What many effects share: parts of friction, velocities with a smoothed sign, checks of settings.

use serde::{Deserialize, Serialize};

use super::Stretch;
use crate::error::{Error, Result};

/// Which part of friction an effect acts on.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum FrictionPart {
    /// The part that grows with speed.
    Viscous,
    /// The part of constant size.
    #[default]
    Coulomb,
    /// Each with its own parameter, viscous first.
    Both,
}

impl FrictionPart {
    /// The single parts, in the order of their parameters.
    pub(super) fn singles(self) -> &'static [FrictionPart] {
        match self {
            Self::Viscous => &[Self::Viscous],
            Self::Coulomb => &[Self::Coulomb],
            Self::Both => &[Self::Viscous, Self::Coulomb],
        }
    }

    /// Symbol and unit of each single part, for [`super::Joints::terms_each`].
    pub(super) fn named(
        self,
        viscous: (&'static str, &'static str),
        coulomb: (&'static str, &'static str),
    ) -> Vec<(&'static str, &'static str)> {
        let of = |part: &Self| if *part == Self::Viscous { viscous } else { coulomb };
        self.singles().iter().map(of).collect()
    }

    /// Writes the velocity of `joint`, or its sign, to `slot`.
    pub(super) fn fill(self, at: &Stretch<'_>, joint: usize, width: f64, slot: &mut [f64]) {
        match self {
            Self::Viscous => slot.copy_from_slice(at.dq(joint)),
            _ => fill_with(slot, at.friction_dq(joint), |v| sign(v, width)),
        }
    }
}

/// Sets every entry of `slot` to `f` of the entry of `from`.
pub(super) fn fill_with(slot: &mut [f64], from: &[f64], f: impl Fn(f64) -> f64) {
    slot.iter_mut().zip(from).for_each(|(y, &x)| *y = f(x));
}

/// Multiplies every entry of `slot` by `f` of the entry of `from`.
pub(super) fn scale_with(slot: &mut [f64], from: &[f64], f: impl Fn(f64) -> f64) {
    slot.iter_mut().zip(from).for_each(|(y, &x)| *y *= f(x));
}

/// Hard sign (0 at 0), or its smooth form `tanh(v / width)`.
pub(super) fn sign(v: f64, width: f64) -> f64 {
    if width > 0.0 {
        libm::tanh(v / width)
    } else if v > 0.0 {
        1.0
    } else if v < 0.0 {
        -1.0
    } else {
        0.0
    }
}

/// Refuses a setting that is not a positive number.
pub(super) fn positive(effect: &str, setting: &str, value: f64) -> Result<()> {
    if value.is_finite() && value > 0.0 {
        return Ok(());
    }
    Err(Error::new(format!("`{setting}` of {effect} is {value}")).help("give a positive number"))
}

/// What friction with a negative coefficient would be.
pub(super) const DRIVES_MOTION: &str = "friction that drives the motion";
