//! Numbers of a constraint, refused where they stand when they make no sense.

use serde::Deserializer;
use serde::de::Error as _;

use crate::error::{Error, Result};
use crate::text::bounds::{AboveZero, Finite, NotNegative};

/// A finite number.
pub(super) fn finite<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    Finite::read(deserializer)
}

/// A finite number above 0.
pub(super) fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    AboveZero::read(deserializer)
}

/// A finite number, 0 or above.
pub(super) fn not_negative<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    NotNegative::read(deserializer)
}

/// A finite number, if any.
pub(super) fn optional<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    Finite::read(deserializer)
}

/// A finite number above 0, if any.
pub(super) fn optional_positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    AboveZero::read(deserializer)
}

/// Three finite numbers.
pub(super) fn triple<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    Finite::read(deserializer)
}

/// Three finite numbers above 0.
pub(super) fn positive_triple<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    AboveZero::read(deserializer)
}

/// A direction: three finite numbers, not all 0.
pub(super) fn direction<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    let x = triple(deserializer)?;
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length.is_normal() {
        Ok(x)
    } else {
        Err(D::Error::custom("the axis has no direction\n  help: write for example (0.0, 0.0, 1.0)"))
    }
}

/// Refuses a lower limit above the upper one, and two limits that are not there.
pub(super) fn ordered(what: &str, min: Option<f64>, max: Option<f64>, unit: &str) -> Result<()> {
    match (min, max) {
        (None, None) => {
            Err(Error::new(format!("{what} has neither `min` nor `max`")).help("give at least one of them"))
        }
        (Some(min), Some(max)) if min > max => {
            Err(Error::new(format!("{what}: min {min} {unit} is above max {max} {unit}")).help("swap them"))
        }
        _ => Ok(()),
    }
}
