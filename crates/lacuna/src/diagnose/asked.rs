//! Effects that the user asks for.

use super::candidates::Candidate;
use super::ladder::Ladder;
use super::score::{Projection, Ridge};
use super::telling::Added;
use crate::error::{Error, Part, Result};

/// Adds effects that the user asked for, without asking whether they help.
pub(super) fn add(ladder: &mut Ladder, wanted: &[(String, Option<String>)]) -> Result<Vec<Added>> {
    let mut added = Vec::new();
    for (name, joint) in wanted {
        let index = joint.as_ref().map(|j| joint_number(ladder, j)).transpose()?;
        let named = |c: &Candidate| c.name() == name && (index.is_none() || c.identity.joint == index);
        let fitting: Vec<usize> = (0..ladder.candidates.len())
            .filter(|&k| named(&ladder.candidates[k]) && !ladder.candidates[k].columns.is_empty())
            .collect();
        if fitting.is_empty() {
            let trouble = ladder.candidates.iter().filter(|c| named(c)).find_map(|c| c.trouble.clone());
            return Err(trouble.unwrap_or_else(|| unknown_effect(name, joint.as_deref(), ladder)));
        }
        let mut parts = Vec::new();
        for candidate in fitting {
            if ladder.parts.has(&ladder.candidates[candidate]) {
                continue;
            }
            let projection = Projection::new(
                &ladder.data,
                &ladder.present,
                ladder.candidates[candidate].columns.clone(),
                Ridge::None,
            );
            let best = projection.score(&ladder.data, &ladder.present, &ladder.response);
            let Some(score) = best else { continue };
            parts.extend(ladder.try_add(candidate, score.alternative)?);
        }
        ladder.refit()?;
        added.push(Added::now(ladder, name, index, &parts));
    }
    Ok(added)
}

fn joint_number(ladder: &Ladder, joint: &str) -> Result<usize> {
    let robot = &ladder.data.robot;
    robot.joint_index(joint).ok_or_else(|| {
        let known: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
        Error::new(format!("no joint `{joint}`"))
            .help(format!("known are {}", known.join(", ")))
            .of_part(Part::Add)
    })
}

fn unknown_effect(name: &str, joint: Option<&str>, ladder: &Ladder) -> Error {
    let mut known: Vec<&str> = ladder.candidates.iter().map(Candidate::name).collect();
    known.dedup();
    if known.contains(&name) {
        let where_ = joint.map_or_else(String::new, |j| format!(" on `{j}`"));
        return Error::new(format!("`{name}` cannot be added{where_}: these data cannot show it"))
            .help(format!("lacuna list effects {name} explains it"))
            .of_part(Part::Add);
    }
    Error::new(format!("no effect called `{name}`"))
        .help(format!("known are {}", known.join(", ")))
        .of_part(Part::Add)
}
