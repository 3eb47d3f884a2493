//! Numbers of a constraint, refused where they stand when they make no sense.

use serde::de::Error as _;
use serde::{Deserialize, Deserializer};

use crate::error::{Error, Result};

fn one<'de, D: Deserializer<'de>>(
    deserializer: D,
    fits: impl Fn(f64) -> bool,
    what: &str,
) -> Result<f64, D::Error> {
    let x = f64::deserialize(deserializer)?;
    if x.is_finite() && fits(x) { Ok(x) } else { Err(D::Error::custom(format!("{x} is not {what}"))) }
}

/// A finite number.
pub(super) fn finite<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    one(deserializer, |_| true, "a finite number")
}

/// A finite number above 0.
pub(super) fn positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    one(deserializer, |x| x > 0.0, "a finite number above 0")
}

/// A finite number, 0 or above.
pub(super) fn not_negative<'de, D: Deserializer<'de>>(deserializer: D) -> Result<f64, D::Error> {
    one(deserializer, |x| x >= 0.0, "a finite number of 0 or above")
}

/// A finite number, if any.
pub(super) fn optional<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    match Option::<f64>::deserialize(deserializer)? {
        Some(x) if !x.is_finite() => {
            Err(D::Error::custom(format!("{x} is not a finite number; leave the field out for no limit")))
        }
        x => Ok(x),
    }
}

/// A finite number above 0, if any.
pub(super) fn optional_positive<'de, D: Deserializer<'de>>(deserializer: D) -> Result<Option<f64>, D::Error> {
    match optional(deserializer)? {
        Some(x) if x <= 0.0 => Err(D::Error::custom(format!("{x} is not above 0"))),
        x => Ok(x),
    }
}

/// Three finite numbers.
pub(super) fn triple<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    let x = <[f64; 3]>::deserialize(deserializer)?;
    match x.iter().find(|x| !x.is_finite()) {
        Some(bad) => Err(D::Error::custom(format!("{bad} is not a finite number"))),
        None => Ok(x),
    }
}

/// Three finite numbers above 0.
pub(super) fn positive_triple<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    let x = triple(deserializer)?;
    match x.iter().find(|x| **x <= 0.0) {
        Some(bad) => Err(D::Error::custom(format!("{bad} is not above 0"))),
        None => Ok(x),
    }
}

/// A direction: three finite numbers, not all 0.
pub(super) fn direction<'de, D: Deserializer<'de>>(deserializer: D) -> Result<[f64; 3], D::Error> {
    let x = triple(deserializer)?;
    let length = x.iter().map(|x| x * x).sum::<f64>().sqrt();
    if length.is_normal() {
        Ok(x)
    } else {
        Err(D::Error::custom("the axis has no direction; write for example (0.0, 0.0, 1.0)"))
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
