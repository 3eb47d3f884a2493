//! Which links a constraint is about.

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::{Error, Result};
use crate::robot::Robot;

/// `All`, or a list of link names or numbers (`["upper_arm"]`, `["3"]`).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Links {
    /// Every moving link.
    #[default]
    All,
    /// These links, by name or by number from 1.
    Named(Vec<String>),
}

impl Links {
    /// Link indices on `robot`, in the order given.
    ///
    /// # Errors
    /// When a name is unknown or stands twice; the message lists what is known.
    pub fn indices(&self, robot: &Robot) -> Result<Vec<usize>> {
        let Self::Named(names) = self else { return Ok((0..robot.links.len()).collect()) };
        let mut found = Vec::with_capacity(names.len());
        for name in names {
            let link = link_index(robot, name)?;
            if found.contains(&link) {
                return Err(Error::new(format!("link `{name}` is named twice")).help("name every link once"));
            }
            found.push(link);
        }
        Ok(found)
    }
}

/// Index of a link by name, or by number from 1.
///
/// # Errors
/// When there is no such link; the message lists what is known, or says what a fixed part hangs on.
pub fn link_index(robot: &Robot, name: &str) -> Result<usize> {
    let by_name = robot.links.iter().position(|l| l.name == name);
    let number = || name.parse::<usize>().ok()?.checked_sub(1).filter(|&i| i < robot.links.len());
    if let Some(link) = by_name.or_else(number) {
        return Ok(link);
    }
    if let Some(frame) = robot.frames.iter().find(|f| f.name == name) {
        return Err(match frame.link {
            Some(link) => Error::new(format!("`{name}` is not a moving link"))
                .help(format!("it is fixed to `{}`, and both are one body: name that", robot.links[link].name)),
            None => Error::new(format!("`{name}` is fixed to the base, which has no link parameters")),
        });
    }
    let known: Vec<_> = robot.links.iter().map(|l| l.name.as_str()).collect();
    Err(Error::new(format!("no link `{name}`")).help(format!(
        "`{}` has {}, or numbers 1 to {}",
        robot.name,
        known.join(", "),
        known.len()
    )))
}

impl Serialize for Links {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::All => serializer.serialize_unit_variant("Links", 0, "All"),
            Self::Named(names) => names.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Links {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Links;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("`All` or a list of link names such as [\"link4\"]")
            }

            fn visit_str<E: serde::de::Error>(self, v: &str) -> Result<Links, E> {
                if v == "All" {
                    Ok(Links::All)
                } else {
                    Err(E::invalid_value(serde::de::Unexpected::Str(v), &self))
                }
            }

            fn visit_bytes<E: serde::de::Error>(self, v: &[u8]) -> Result<Links, E> {
                self.visit_str(std::str::from_utf8(v).map_err(E::custom)?)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Links, A::Error> {
                let mut names = Vec::new();
                while let Some(name) = seq.next_element::<String>()? {
                    names.push(name);
                }
                if names.is_empty() {
                    return Err(A::Error::custom(
                        "the list of links is empty; write `All` or name at least one",
                    ));
                }
                Ok(Links::Named(names))
            }
        }
        deserializer.deserialize_any(Either)
    }
}
