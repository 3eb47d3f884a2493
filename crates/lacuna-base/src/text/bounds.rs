//! Kinds of numbers that inputs state, each with its bounds and the reason for them.
//!
//! A field gets its bounds in the line above it,
//! `#[serde(deserialize_with = "Seconds::read")]`, and the reader then says name, line and column of a number that
//! lies outside. Numbers that come from elsewhere take `Seconds::check("name", value)`.

use std::marker::PhantomData;

use serde::{Deserialize, Deserializer, de};

use crate::error::{Error, Result};

/// What numbers of a kind may be.
pub trait Kind {
    /// Smallest.
    const LEAST: f64;
    /// Largest.
    const MOST: f64;
    /// Unit, with a blank before it; empty for counts.
    const UNIT: &'static str;
    /// Why, for people.
    const WHY: &'static str;
}

macro_rules! kinds {
    ($($name:ident: $least:literal to $most:literal, $unit:literal, $why:literal;)*) => {$(
        #[doc = concat!("From ", stringify!($least), " to ", stringify!($most), $unit, ": ", $why, ".")]
        #[derive(Debug, Clone, Copy)]
        pub struct $name;

        impl Kind for $name {
            const LEAST: f64 = $least as f64;
            const MOST: f64 = $most as f64;
            const UNIT: &'static str = $unit;
            const WHY: &'static str = $why;
        }

        #[allow(dead_code)]
        impl $name {
            /// Reads a number, or numbers in brackets, of this kind.
            pub fn read<'de, T: Numbers, D: Deserializer<'de>>(from: D) -> Result<T, D::Error> {
                T::read::<Self, D>(from)
            }

            /// Refuses a number that lies outside; `name` is what it is called where it was written.
            pub fn check<T: Number>(name: &str, value: T) -> Result<()> {
                match outside::<Self>(value.value()) {
                    Some((what, help)) => Err(Error::new(format!("`{name}` is {what}")).help(help)),
                    None => Ok(()),
                }
            }
        }
    )*};
}

kinds! {
    Seconds: 1e-6 to 1e6, " s", "it is a time in seconds; no sensor is faster than a microsecond, and 1e6 s are eleven days";
    SecondsOrNone: 0.0 to 1e6, " s", "it is a time in seconds, and 1e6 s are eleven days";
    Hertz: 1e-6 to 1e9, " Hz", "it is a frequency in Hz";
    Positive: 1e-9 to 1e12, "", "it is divided by, and anything smaller is below what sensors see";
    NotNegative: 0.0 to 1e12, "", "it is a size, so it has no sign";
    Finite: -1e12 to 1e12, "", "no quantity of a robot is larger in SI units";
    AboveZero: 1e-30 to 1e12, "", "it is a size, a mass or a tolerance, and those lie above 0";
    Exponent: 1.0 to 10.0, "", "2 is air drag; higher powers than 10 only make numbers overflow";
    Share: 0.0 to 1.0, "", "it is a share of a whole";
    Percent: 0.0 to 100.0, " %", "it is a share of a whole in per cent";
    Mass: 1e-9 to 1e6, " kg", "no link of a robot and nothing that one carries is heavier";
    Gravity: -1e6 to 1e6, " m/s²", "write three numbers, base frame, such as (0.0, 0.0, -9.81)";
    Harmonics: 1 to 1000, "", "5 harmonics are usual, and more than 1000 shake faster than any robot moves";
    JointNumber: 1 to 100_000, "", "joints count from 1, as in the columns q1, q2, ... of a log";
    Digits: 0 to 17, "", "a double has no more digits than 17";
    PoseCount: 1 to 100_000, "", "1000 configurations are plenty";
    FoldCount: 2 to 1000, "", "8 folds are usual; each of them keeps sums of its own";
    Order: 1 to 8, "", "4 is usual; filters of higher order ring and lose digits";
    Every: 1 to 1_000_000, "", "1 keeps every sample, and a longer log than a million rows is not left by any other";
    Runs: 1 to 100_000, "", "20 runs are usual, and each keeps its result";
    Stages: 1 to 1000, "", "4 to 10 stages are usual; the penalty grows in each";
    Moves: 0 to 1_000_000_000, "", "a thousand million take hours";
    Iterations: 1 to 100_000, "", "an interior point takes about 25 iterations, and 200 when it is hard";
    Faces: 6 to 100_000, "", "6 faces make a box, and each face is a constraint of its own";
}

/// What is wrong with a value of a kind, and what to do.
fn outside<K: Kind + ?Sized>(value: f64) -> Option<(String, String)> {
    if (K::LEAST..=K::MOST).contains(&value) {
        return None;
    }
    let (least, most) = (shown(K::LEAST), shown(K::MOST));
    Some((shown(value) + K::UNIT, format!("give {least} to {most}{}: {}", K::UNIT, K::WHY)))
}

fn shown(value: f64) -> String {
    let size = value.abs();
    if size > 0.0 && !(1e-3..1e7).contains(&size) { format!("{value:e}") } else { format!("{value}") }
}

/// How a message of [`Kind`] begins where the reader has not yet put the name there.
pub const NAMELESS: &str = "the number is ";

/// A type of number that inputs hold.
pub trait Number: Copy {
    /// As a double, near enough to compare with bounds.
    fn value(self) -> f64;
}

/// A number, or numbers in lists, of one kind.
pub trait Numbers: Sized {
    /// Reads them one by one, so that the place of one that lies outside is known.
    fn read<'de, K: Kind, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error>;
}

macro_rules! numbers {
    ($($number:ty),*) => {$(
        impl Number for $number {
            fn value(self) -> f64 {
                self as f64
            }
        }

        impl Numbers for $number {
            fn read<'de, K: Kind, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
                let number = <$number>::deserialize(from)?;
                match outside::<K>(number.value()) {
                    Some((what, help)) => {
                        Err(de::Error::custom(format!("{NAMELESS}{what}\n  help: {help}")))
                    }
                    None => Ok(number),
                }
            }
        }
    )*};
}

numbers!(f64, u16, u32, usize);

/// One of several numbers.
struct Each<K, T>(T, PhantomData<K>);

impl<'de, K: Kind, T: Numbers> Deserialize<'de> for Each<K, T> {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        T::read::<K, D>(from).map(|value| Self(value, PhantomData))
    }
}

impl<T: Numbers> Numbers for Option<T> {
    fn read<'de, K: Kind, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Ok(Option::<Each<K, T>>::deserialize(from)?.map(|each| each.0))
    }
}

impl<T: Numbers> Numbers for Vec<T> {
    fn read<'de, K: Kind, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Ok(Vec::<Each<K, T>>::deserialize(from)?.into_iter().map(|each| each.0).collect())
    }
}

impl<T: Numbers> Numbers for [T; 3] {
    fn read<'de, K: Kind, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Ok(<[Each<K, T>; 3]>::deserialize(from)?.map(|each| each.0))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[derive(Debug, Deserialize)]
    #[serde(deny_unknown_fields)]
    struct Written {
        #[serde(default, deserialize_with = "Seconds::read")]
        _time_s: Option<f64>,
        #[serde(default, deserialize_with = "NotNegative::read")]
        _levels: Vec<Vec<f64>>,
        #[serde(deserialize_with = "Runs::read")]
        _runs: usize,
    }

    #[test]
    fn a_number_outside_is_named_placed_and_reasoned() {
        for (text, at, words) in [
            ("(_runs: 0)", 9, ["`_runs` is 0", "give 1 to 100000: 20 runs are usual"]),
            ("(_runs: 4294967295)", 9, ["`_runs` is 4.294967295e9", "each keeps its result"]),
            ("(_time_s: 1e-12, _runs: 1)", 11, ["`_time_s` is 1e-12 s", "give 1e-6 to 1000000 s: "]),
            ("(_levels: [[1, 2], [3, -4]], _runs: 1)", 24, ["`_levels` is -4", "no sign"]),
        ] {
            let error = super::super::from_ron::<Written>(text).expect_err(text);
            let place = error.place().and_then(|p| Some((p.line?, p.column?)));
            assert_eq!(place, Some((1, at)), "{error}");
            words.iter().for_each(|word| assert!(error.to_string().contains(word), "{error}"));
        }
        assert!(super::super::from_ron::<Written>("(_runs: 3, _time_s: 0.5, _levels: [[0, 2.5]])").is_ok());
    }

    #[test]
    fn numbers_from_elsewhere_are_checked_alike() {
        assert_eq!(FoldCount::check("folds", 2_u16), Ok(()));
        let error = FoldCount::check("folds", 1_u16).expect_err("one fold");
        assert!(error.to_string().contains("`folds` is 1"), "{error}");
        assert!(Seconds::check("t", f64::NAN).is_err() && NotNegative::check("x", -0.5).is_err());
    }
}
