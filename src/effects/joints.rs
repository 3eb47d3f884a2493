//! Which joints an effect acts on.

use serde::de::{Error as _, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

use crate::error::{Error, Result};
use crate::robot::Robot;

/// `All`, or a list of joint names or numbers (`["elbow_joint"]`, `["3"]`).
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub enum Joints {
    /// Every joint.
    #[default]
    All,
    /// These joints, by name or by number from 1.
    Named(Vec<String>),
}

impl Joints {
    /// Joint indices on `robot`, in the order given.
    ///
    /// # Errors
    /// When a name is unknown; the message lists what is known.
    pub fn indices(&self, robot: &Robot) -> Result<Vec<usize>> {
        match self {
            Self::All => Ok((0..robot.dof()).collect()),
            Self::Named(names) => names.iter().map(|name| find(robot, name)).collect(),
        }
    }

    /// One symbol per joint the effect acts on: `prefix` and the joint's number.
    pub(crate) fn terms(&self, robot: &Robot, prefix: &str, unit: &'static str) -> Result<Vec<super::Term>> {
        let term = |j: usize| super::Term { symbol: format!("{prefix}{}", j + 1), unit, joints: vec![j] };
        Ok(self.indices(robot)?.into_iter().map(term).collect())
    }
}

fn find(robot: &Robot, name: &str) -> Result<usize> {
    robot.joint_index(name).ok_or_else(|| {
        let known: Vec<_> = robot.joints.iter().map(|j| j.name.as_str()).collect();
        Error::new(format!("no joint `{name}`")).help(format!(
            "`{}` has {}, or numbers 1 to {}",
            robot.name,
            known.join(", "),
            robot.dof()
        ))
    })
}

impl Serialize for Joints {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        match self {
            Self::All => serializer.serialize_unit_variant("Joints", 0, "All"),
            Self::Named(names) => names.serialize(serializer),
        }
    }
}

impl<'de> Deserialize<'de> for Joints {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        struct Either;
        impl<'de> Visitor<'de> for Either {
            type Value = Joints;

            fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
                f.write_str("`All` or a list of joint names such as [\"joint4\"]")
            }

            fn visit_str<E: serde::de::Error>(self, v: &str) -> Result<Joints, E> {
                if v == "All" {
                    Ok(Joints::All)
                } else {
                    Err(E::invalid_value(serde::de::Unexpected::Str(v), &self))
                }
            }

            fn visit_bytes<E: serde::de::Error>(self, v: &[u8]) -> Result<Joints, E> {
                self.visit_str(std::str::from_utf8(v).map_err(E::custom)?)
            }

            fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Joints, A::Error> {
                let mut names = Vec::new();
                while let Some(name) = seq.next_element::<String>()? {
                    names.push(name);
                }
                if names.is_empty() {
                    return Err(A::Error::custom(
                        "the list of joints is empty; write `All` or name at least one",
                    ));
                }
                Ok(Joints::Named(names))
            }
        }
        deserializer.deserialize_any(Either)
    }
}
