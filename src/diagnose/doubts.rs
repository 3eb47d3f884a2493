//! What an answer must admit: explanations that tie, structure that is left, and effects of the pipeline.

use super::answer::Inseparable;
use super::data::Data;
use super::ladder::{Ladder, Refusal, Rung};
use super::late::OF_A_SAMPLE;
use crate::effects::Effect;
use crate::error::Result;

/// Effects that noise of the acceleration can imitate; they must survive a position filter of half the cut-off.
const OF_ACCELERATION: [&str; 5] =
    ["joint_elasticity", "rotor_inertia", "time_delay", "joint_zero_error", "backlash"];
/// Part of the threshold that such an effect must keep.
const KEPT: f64 = 0.5;

/// Names of the explanations that tie with a finding, each once; not its own with other parameters.
pub(super) fn also_possible(ladder: &Ladder, rung: &Rung) -> Vec<String> {
    let own = ladder.parts.get(rung.part).effect.about().name;
    let mut names: Vec<String> = Vec::new();
    for other in rung.also_possible.iter().map(|&c| ladder.candidates[c].name()).filter(|n| *n != own) {
        if !names.iter().any(|n| n == other) {
            names.push(other.to_string());
        }
    }
    names
}

/// Findings with the explanations that tie with them, and a motion that would tell.
pub(super) fn inseparable(ladder: &Ladder) -> Vec<Inseparable> {
    let mut all: Vec<Inseparable> = Vec::new();
    for rung in &ladder.rungs {
        let title = ladder.parts.title(rung.part, &ladder.data.robot);
        let name = ladder.parts.get(rung.part).effect.about().name;
        for other in also_possible(ladder, rung) {
            let separating_motion = separating_motion(name, &other).to_string();
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

/// A motion in which two effects differ.
fn separating_motion(a: &str, b: &str) -> &'static str {
    let pair = |x: &str, y: &str| (a == x && b == y) || (a == y && b == x);
    let any = |x: &str| a == x || b == x;
    if pair("presliding_hysteresis", "stribeck_friction") {
        "small reversals of 5 to 50 mrad, each position approached from both sides"
    } else if any("stribeck_friction") {
        "a wider range of speeds, with slow reversals well below the Stribeck speed"
    } else if any("torque_gain") {
        "the same motion with and without a known payload, or poses with only one joint loaded"
    } else if any("time_delay") {
        "a faster motion of that joint alone"
    } else if any("load_dependent_friction") {
        "the same speeds in poses with high and with low gravity load, or two payloads"
    } else if any("joint_spring") || any("base_tilt") {
        "a large range of that joint, and poses with opposite signs of the gravity torque"
    } else if any("sigmoid_friction") || any("nonlinear_viscous_friction") || any("viscous_friction") {
        "a wider range of speeds, from crawling to full speed"
    } else if any("torque_ripple") || any("position_dependent_friction") {
        "the whole range of the joint at two different speeds, in both directions"
    } else if any("torque_drift") || any("friction_drift") || any("thermal_friction") {
        "a longer log, or the same motion cold and warm, with temperatures logged"
    } else {
        "a motion of that joint with other speeds and in other poses"
    }
}

/// Why a delay of the whole robot is no physics: it is shorter than the clock of the log can tell. A delay of one joint
/// against the others is no clock's doing.
pub(super) fn of_the_clock(effect: &dyn Effect, values: &[f64], data: &Data) -> Option<String> {
    let dt = data.runs.first().map_or(0.0, |run| run.dt);
    let whole = effect.terms(&data.robot).is_ok_and(|t| t.iter().all(|t| t.joints.len() == data.dof()));
    let short =
        whole && effect.about().name == "time_delay" && values.iter().all(|s| s.abs() < OF_A_SAMPLE * dt);
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
        .filter(|&p| OF_ACCELERATION.contains(&ladder.parts.get(p).effect.about().name))
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
