//! A map from names to intervals, in the order written.

use serde::de::{Error as _, MapAccess, Visitor};
use serde::ser::SerializeMap;
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// From a lower to an upper limit; either may be infinite.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(try_from = "(f64, f64)", into = "(f64, f64)")]
pub struct Interval {
    /// Lower limit, or `-inf`.
    pub lower: f64,
    /// Upper limit, or `inf`.
    pub upper: f64,
}

impl Interval {
    /// No limit at all.
    pub const ALL: Self = Self { lower: f64::NEG_INFINITY, upper: f64::INFINITY };

    /// Whether both limits are finite.
    pub fn is_finite(&self) -> bool {
        self.lower.is_finite() && self.upper.is_finite()
    }
}

impl TryFrom<(f64, f64)> for Interval {
    type Error = String;

    fn try_from((lower, upper): (f64, f64)) -> Result<Self, String> {
        if lower.is_nan() || upper.is_nan() {
            Err("a limit is not a number\n  help: write -inf or inf for none".into())
        } else if lower > upper {
            Err(format!("the lower limit {lower} is above the upper limit {upper}\n  help: swap them"))
        } else if lower.is_infinite() && lower > 0.0 || upper.is_infinite() && upper < 0.0 {
            Err(format!(
                "no number lies between {lower} and {upper}\n  help: write the smaller limit first, -inf or inf for none"
            ))
        } else {
            Ok(Self { lower, upper })
        }
    }
}

impl From<Interval> for (f64, f64) {
    fn from(i: Interval) -> Self {
        (i.lower, i.upper)
    }
}

/// `{"m1": (0.0, 10.0), ..}`: names are unique, their order is kept.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Intervals(pub Vec<(String, Interval)>);

impl Intervals {
    /// The interval of a name.
    pub fn get(&self, name: &str) -> Option<Interval> {
        self.0.iter().find(|(n, _)| n == name).map(|(_, i)| *i)
    }
}

impl Serialize for Intervals {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let mut map = serializer.serialize_map(Some(self.0.len()))?;
        for (name, interval) in &self.0 {
            map.serialize_entry(name, interval)?;
        }
        map.end()
    }
}

impl<'de> Deserialize<'de> for Intervals {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Entries;
        impl<'de> Visitor<'de> for Entries {
            type Value = Intervals;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("a map from parameters to limits such as {\"m1\": (0.0, 10.0)}")
            }

            fn visit_map<A: MapAccess<'de>>(self, mut map: A) -> Result<Intervals, A::Error> {
                let mut all = Intervals::default();
                while let Some(name) = map.next_key::<String>()? {
                    if all.get(&name).is_some() {
                        return Err(A::Error::custom(format!("`{name}` is bounded twice")));
                    }
                    let interval = map.next_value()?;
                    all.0.push((name, interval));
                }
                Ok(all)
            }
        }
        deserializer.deserialize_map(Entries)
    }
}
