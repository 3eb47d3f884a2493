//! Which joints an effect acts on.

use serde::{Deserialize, Serialize};

use super::{Columns, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// `All`, or `Only([..])` with joint names or numbers: `Only(["elbow_joint", "6"])`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Joints {
    /// Every joint.
    #[default]
    All,
    /// These joints, by name or by number from 1.
    Only(Vec<String>),
}

impl Joints {
    /// Joint indices on `robot`, in the order given.
    ///
    /// # Errors
    /// When a name is unknown or stands twice, or the list is empty; the message lists what is known.
    pub fn indices(&self, robot: &Robot) -> Result<Vec<usize>> {
        let names = match self {
            Self::All => return Ok((0..robot.dof()).collect()),
            Self::Only(names) => names,
        };
        if names.is_empty() {
            return Err(
                Error::new("the list of joints is empty").help("write `All`, or name at least one joint")
            );
        }
        let found: Vec<usize> = names.iter().map(|name| find(robot, name)).collect::<Result<_>>()?;
        match (1..found.len()).find(|&k| found[..k].contains(&found[k])) {
            Some(k) => Err(Error::new(format!("joint `{}` stands twice in the list", names[k]))
                .help("name every joint once, by name or by number")),
            None => Ok(found),
        }
    }

    /// The joint, where it is one.
    pub(crate) fn only_one(&self, robot: &Robot) -> Result<Option<usize>> {
        let joints = self.indices(robot)?;
        Ok(joints.first().copied().filter(|_| joints.len() == 1))
    }

    /// One symbol per joint the effect acts on: `prefix` and the joint's number.
    pub(crate) fn terms(&self, robot: &Robot, prefix: &str, unit: &'static str) -> Result<Vec<Term>> {
        self.terms_each(robot, &[(prefix, unit)])
    }

    /// The same with several parameters per joint (prefix and unit), joint by joint.
    pub(crate) fn terms_each(&self, robot: &Robot, parts: &[(&str, &'static str)]) -> Result<Vec<Term>> {
        let one = |j: usize, (prefix, unit): &(&str, &'static str)| Term {
            symbol: format!("{prefix}{}", j + 1),
            unit,
            joints: vec![j],
        };
        let joints = self.indices(robot)?.into_iter();
        Ok(joints.flat_map(|j| parts.iter().map(move |part| one(j, part))).collect())
    }

    /// Offers the columns of [`Joints::terms_each`]: `fill(part, joint, slot)` for each of them.
    pub(crate) fn fill(
        &self,
        at: &Stretch<'_>,
        out: &mut Columns<'_>,
        parts: usize,
        fill: impl Fn(usize, usize, &mut [f64]),
    ) -> Result<()> {
        for (place, joint) in self.indices(at.robot)?.into_iter().enumerate() {
            for part in 0..parts {
                out.column(place * parts + part, joint, |slot| fill(part, joint, slot));
            }
        }
        Ok(())
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_of_writing_come_back() -> Result<()> {
        for text in ["All", "Only([\"joint2\",\"1\"])"] {
            let joints: Joints = crate::text::from_ron(text)?;
            let again: Joints = crate::text::from_ron(&crate::text::to_ron(&joints)?)?;
            assert_eq!(joints, again);
        }
        let typo = crate::text::from_ron::<Joints>("Al").expect_err("a typo must not pass");
        assert!(typo.to_string().contains("known names: All, Only"), "{typo}");
        Ok(())
    }
}
