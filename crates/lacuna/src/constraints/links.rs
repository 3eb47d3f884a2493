//! Which links a constraint is about.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::robot::Robot;

/// `All`, or `Only([..])` with link names or numbers: `Only(["upper_arm", "3"])`.
#[derive(Debug, Clone, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Links {
    /// Every moving link.
    #[default]
    All,
    /// These links, by name or by number from 1.
    Only(Vec<String>),
}

impl Links {
    /// Link indices on `robot`, in the order given.
    ///
    /// # Errors
    /// When a name is unknown or stands twice, or the list is empty; the message lists what is known.
    pub fn indices(&self, robot: &Robot) -> Result<Vec<usize>> {
        let Self::Only(names) = self else { return Ok((0..robot.links.len()).collect()) };
        if names.is_empty() {
            return Err(
                Error::new("the list of links is empty").help("write `All`, or name at least one link")
            );
        }
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn both_ways_of_writing_come_back() -> Result<()> {
        for text in ["All", "Only([\"link2\",\"1\"])"] {
            let links: Links = crate::text::from_ron(text)?;
            let again: Links = crate::text::from_ron(&crate::text::to_ron(&links)?)?;
            assert_eq!(links, again);
        }
        let typo = crate::text::from_ron::<Links>("Al").expect_err("a typo must not pass");
        assert!(typo.to_string().contains("known names: All, Only"), "{typo}");
        Ok(())
    }
}
