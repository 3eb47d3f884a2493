//! What an answer must admit: explanations that tie, structure that is left, and effects of the pipeline.

use super::answer::Inseparable;
use super::data::Data;
use super::ladder::{Ladder, Refusal, Rung};
use super::late::OF_A_SAMPLE;
use crate::effects::{About, Effect, Imitation};
use crate::error::Result;

/// What noise of the acceleration imitates must survive a position filter of half the cut-off: the part of its
/// threshold that it must keep there.
const KEPT: f64 = 0.5;

/// Explanations that tie with a finding, each once; not its own with other parameters.
fn ties(ladder: &Ladder, rung: &Rung) -> Vec<About> {
    let own = ladder.parts.get(rung.part).effect.about().name;
    let mut all: Vec<About> = Vec::new();
    for other in rung.also_possible.iter().map(|&c| ladder.candidates[c].effect.about()) {
        if other.name != own && all.iter().all(|known| known.name != other.name) {
            all.push(other);
        }
    }
    all
}

/// Their names.
pub(super) fn also_possible(ladder: &Ladder, rung: &Rung) -> Vec<String> {
    ties(ladder, rung).into_iter().map(|about| about.name.to_string()).collect()
}

/// Findings with the explanations that tie with them, and a motion that would tell.
pub(super) fn inseparable(ladder: &Ladder) -> Vec<Inseparable> {
    let mut all: Vec<Inseparable> = Vec::new();
    for rung in &ladder.rungs {
        let title = ladder.parts.title(rung.part, &ladder.data.robot);
        let about = ladder.parts.get(rung.part).effect.about();
        for other in ties(ladder, rung) {
            let separating_motion = about.motion_between(&other).to_string();
            let other = other.name.to_string();
            let same =
                |i: &&mut Inseparable| i.effects[0] == title && i.separating_motion == separating_motion;
            match all.iter_mut().find(same) {
                Some(known) => known.effects.push(other),
                None => all.push(Inseparable { effects: vec![title.clone(), other], separating_motion }),
            }
        }
    }
    all
}

/// Why a delay of the whole robot is no physics: it is shorter than the clock of the log can tell. A delay of one joint
/// against the others is no clock's doing.
pub(super) fn of_the_clock(effect: &dyn Effect, values: &[f64], data: &Data) -> Option<String> {
    let dt = data.runs.first().map_or(0.0, |run| run.dt);
    let whole = effect.terms(&data.robot).is_ok_and(|t| t.iter().all(|t| t.joints.len() == data.dof()));
    let of_the_clock = effect.about().is_imitated_by(Imitation::Clock);
    let short = whole && of_the_clock && values.iter().all(|s| s.abs() < OF_A_SAMPLE * dt);
    let milliseconds = 1e3 * values.first().copied().unwrap_or(0.0);
    short.then(|| format!("{milliseconds:.2} ms is a small part of the sampling time: the clock's doing"))
}

/// Structure that is left on a joint whose effect was named.
pub(super) fn remainder(ladder: &Ladder, joint: usize) -> Option<String> {
    let (z, part) = ladder.limits.variable;
    let strongest =
        ladder.search_on(joint).dependences().into_iter().find(|d| d.score.z >= z && d.part >= part)?;
    let percent = 100.0 * strongest.part;
    Some(format!(
        "{percent:.0} % of what is left depends on {} (z {:.1})",
        strongest.variables.join(", "),
        strongest.score.z
    ))
}

/// Looks again with the position filter at half its cut-off: what then disappears was noise of the
/// acceleration, not physics. Answers whether anything was dropped.
pub(super) fn drop_artefacts(ladder: &mut Ladder, smoother: Data) -> Result<bool> {
    let suspects: Vec<usize> = ladder
        .rungs
        .iter()
        .map(|r| r.part)
        .filter(|&p| ladder.parts.get(p).effect.about().is_imitated_by(Imitation::AccelerationNoise))
        .collect();
    if suspects.is_empty() {
        return Ok(false);
    }
    let again = ladder.on(smoother)?;
    let mut dropped = false;
    for part in suspects {
        let z = again.without(part)?.0.map_or(0.0, |s| s.z);
        let joint = ladder.parts.joint(part);
        if z < KEPT * ladder.gates.of(joint) {
            let identity = ladder.parts.get(part).identity.clone();
            let reason = format!("disappears (z {z:.1}) when positions are filtered at half the cut-off");
            ladder.refused.push(Refusal { identity, reason });
            ladder.take_out(part);
            dropped = true;
        }
    }
    if dropped {
        ladder.refit()?;
    }
    Ok(dropped)
}
