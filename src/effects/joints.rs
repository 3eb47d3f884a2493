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
        Error::new(format!("there is no joint `{name}`")).help(format!(
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

/// RON hands over a value under this name as it is written. A bare word like `All` is otherwise known to be
/// there but not which it is, so a typo would pass for `All`.
const AS_WRITTEN: &str = "$ron::private::RawValue";

impl<'de> Deserialize<'de> for Joints {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let names = match deserializer.deserialize_newtype_struct(AS_WRITTEN, Written)? {
            Value::Text(text) if text.trim() == "All" => return Ok(Self::All),
            Value::Text(list) => crate::text::from_ron(&list).map_err(|_| D::Error::custom(wrong(&list)))?,
            Value::Names(names) => names,
        };
        if names.is_empty() {
            return Err(D::Error::custom(
                "the list of joints is empty\n  help: write `All`, or name at least one",
            ));
        }
        Ok(Self::Named(names))
    }
}

fn wrong(text: &str) -> String {
    let text = crate::text::names::shorten(text.trim());
    format!("these are no joints: {text}\n  help: write {SHAPE}; a joint's number stands in quotes, too")
}

const SHAPE: &str = "All, or a list of joint names such as [\"joint4\"]";

enum Value {
    /// RON as written, or `All` in other formats.
    Text(String),
    Names(Vec<String>),
}

struct Written;

impl<'de> Visitor<'de> for Written {
    type Value = Value;

    fn expecting(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(SHAPE)
    }

    fn visit_str<E: serde::de::Error>(self, text: &str) -> Result<Value, E> {
        Ok(Value::Text(text.to_owned()))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut seq: A) -> Result<Value, A::Error> {
        let mut names = Vec::new();
        while let Some(name) = seq.next_element()? {
            names.push(name);
        }
        Ok(Value::Names(names))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, inner: D) -> Result<Value, D::Error> {
        inner.deserialize_any(self)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::effects::Effect;
    use crate::text::{from_ron, to_ron};

    fn joints(text: &str) -> Result<String> {
        let effect: Box<dyn Effect> = from_ron(&format!("{{\"torque_offset\": (joints: {text})}}"))?;
        Ok(format!("{effect:?}"))
    }

    #[test]
    fn all_and_lists_are_read_as_written_and_typos_refused() -> Result<()> {
        assert_eq!(joints(" All ")?, "TorqueOffset { joints: All }");
        assert_eq!(joints("/* one */ [\"elbow\"]")?, "TorqueOffset { joints: Named([\"elbow\"]) }");
        for wrong in ["Al", "all", "[1]", "\"All\"", "[]", "()", "4", "Some(All)"] {
            let error = joints(wrong).expect_err(wrong);
            assert!(error.place().is_some() && error.to_string().contains("All"), "{wrong}: {error}");
        }
        Ok(())
    }

    #[test]
    fn every_format_brings_back_what_was_written() -> Result<()> {
        for joints in [Joints::All, Joints::Named(vec!["a \"b\"".into(), "2".into()])] {
            assert_eq!(from_ron::<Joints>(&to_ron(&joints)?)?, joints);
            let json = serde_json::to_string(&joints).map_err(|e| Error::new(e.to_string()))?;
            let back: Joints = serde_json::from_str(&json).map_err(|e| Error::new(e.to_string()))?;
            assert_eq!(back, joints);
        }
        Ok(())
    }
}
