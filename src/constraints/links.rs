//! Which links a constraint is about.

use serde::de::Error as _;
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
            Some(link) => Error::new(format!("`{name}` is not a moving link")).help(format!(
                "it is fixed to `{}`, and both are one body: name that",
                robot.links[link].name
            )),
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

/// RON hands out a bare word only to enums, so the word is one.
#[derive(Deserialize)]
#[serde(untagged, expecting = "links are `All` or a list of names such as [\"link4\"]")]
enum Written {
    Word(Word),
    Names(Vec<String>),
}

#[derive(Deserialize)]
enum Word {
    All,
}

impl<'de> Deserialize<'de> for Links {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        match Written::deserialize(deserializer)? {
            Written::Word(Word::All) => Ok(Self::All),
            Written::Names(names) if names.is_empty() => {
                Err(D::Error::custom("the list of links is empty; write `All` or name at least one"))
            }
            Written::Names(names) => Ok(Self::Named(names)),
        }
    }
}
