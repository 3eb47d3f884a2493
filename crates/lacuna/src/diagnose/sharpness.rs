//! How sharply Coulomb friction turns round on each joint. That is no finding (the sampling, the filters and the
//! controller all have a hand in it), but a sign too sharp or too soft leaves an error that looks like physics.

use std::sync::Arc;

use rayon::prelude::*;

use super::candidates;
use super::data::{Column, Data};
use super::ladder::Ladder;
use super::parts::Parts;
use super::present::{Columns, Present};
use super::score::{Projection, Ridge};
use super::signals::SOFTEST;
use crate::effects::{CoulombFriction, Effect, Joints};
use crate::error::Result;
use crate::robot::Robot;

/// Widths within this factor of what the signal step chose are tried: how soft a sign may be is decided there, on
/// held-out data.
const AROUND: f64 = 1.8;
/// The same beside a model in which much was found since: what was missing then may have bent the choice.
const FAR_AROUND: f64 = 4.0;
/// A width that changes by less than this factor stays.
const WORTH: f64 = 1.3;
/// Widths tried, evenly in the logarithm.
const TRIALS: usize = 9;

/// The same effects with Coulomb friction joint by joint, so that every joint can have a width of its own.
pub(super) fn by_joint(robot: &Robot, effects: &[Box<dyn Effect>]) -> Result<Vec<Box<dyn Effect>>> {
    let mut all: Vec<Box<dyn Effect>> = Vec::new();
    for effect in effects {
        if effect.about().name != CoulombFriction::ABOUT.name {
            all.push(effect.clone());
            continue;
        }
        for joint in effect.terms(robot)?.iter().flat_map(|term| term.joints.clone()) {
            let joints = Joints::Only(vec![robot.joints[joint].name.clone()]);
            all.push(Box::new(CoulombFriction { joints, ..CoulombFriction::default() }));
        }
    }
    Ok(all)
}

/// Gives every part with Coulomb friction of one joint the width that explains most in held-out data
/// beside all the others.
pub(super) fn sharpen(parts: &mut Parts, data: &Data) -> Result<()> {
    sharpen_within(parts, data, AROUND, 1.0, f64::INFINITY)
}

/// Chooses the widths again beside everything that was found; answers whether any changed.
pub(super) fn sharpen_again(ladder: &mut Ladder, extra: &[Box<dyn Effect>]) -> Result<bool> {
    let before = ladder.parts.widths.clone();
    sharpen_within(&mut ladder.parts, &ladder.data, FAR_AROUND, WORTH, SOFTEST)?;
    ladder.refit()?;
    let changed: Vec<bool> = (0..before.len()).map(|j| differ(before[j], ladder.parts.widths[j])).collect();
    if !changed.contains(&true) {
        return Ok(false);
    }
    // Everything else that was found and has a sign of such a joint gets its new width.
    let robot = ladder.data.robot.clone();
    for part in ladder.parts.numbers().into_iter().filter(|&p| ladder.parts.get(p).found).collect::<Vec<_>>()
    {
        let effect = ladder.parts.get(part).effect.clone();
        if let Some(joint) = effect.sign_of(&robot)?.or(ladder.parts.joint(part)).filter(|j| changed[*j]) {
            ladder.parts.replace(part, &ladder.data, effect.with_width(ladder.parts.widths[joint]))?;
        }
    }
    // What was refused may have been so because of the width.
    ladder.refused.clear();
    ladder.candidates = candidates::catalogue(&ladder.data, &ladder.parts.widths, extra)?;
    ladder.refit()?;
    ladder.refresh_torque()?;
    candidates::fill(&mut ladder.candidates, &ladder.data, false)?;
    Ok(true)
}

fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > 0.0
}

/// Widths within a factor `around` of those there are; a change by less than a factor `worth` is none, and softer than
/// `softest` is only what was so before: softer than any filter makes a sign is physics.
fn sharpen_within(parts: &mut Parts, data: &Data, around: f64, worth: f64, softest: f64) -> Result<()> {
    let weights = Present::new(data, parts.columns()).weights;
    for part in parts.numbers() {
        let Some(joint) = parts.joint(part) else { continue };
        if parts.get(part).effect.about().name != CoulombFriction::ABOUT.name || data.still[joint] {
            continue;
        }
        let Columns { mut columns, nuisances } = parts.columns_without(&[part]);
        columns.truncate(columns.len() - nuisances);
        let present = Present::with_weights(data, Columns { columns, nuisances: 0 }, &weights);
        let effect = parts.get(part).effect.as_ref();
        let near = parts.widths[joint];
        let width = width(data, &present, effect, near, around)?.min(near.max(softest));
        if width < near * worth && near < width * worth {
            continue;
        }
        let sharpened = parts.get(part).effect.with_width(width);
        parts.widths[joint] = width;
        parts.replace(part, data, sharpened)?;
    }
    parts.rebuild(data, true)
}

fn width(data: &Data, present: &Present, effect: &dyn Effect, near: f64, around: f64) -> Result<f64> {
    let at = |place: f64| near * libm::pow(around, 2.0 * place / (TRIALS - 1) as f64 - 1.0);
    let effects: Vec<Box<dyn Effect>> = (0..TRIALS).map(|k| effect.with_width(at(k as f64))).collect();
    let effects: Vec<&dyn Effect> = effects.iter().map(AsRef::as_ref).collect();
    let shared = |columns: Vec<Column>| -> Vec<Arc<Column>> { columns.into_iter().map(Arc::new).collect() };
    let alternatives: Vec<_> = data.columns_of_each(&effects)?.into_iter().map(shared).collect();
    let response = present.respond(data, data.tau.clone());
    let gain = |columns| {
        let score =
            Projection::new(data, present, vec![columns], Ridge::None).score(data, present, &response);
        score.map_or(f64::NEG_INFINITY, |s| s.gain)
    };
    let explained: Vec<f64> = alternatives.into_par_iter().map(gain).collect();
    let best = (0..TRIALS).fold(0, |best, k| if explained[k] > explained[best] { k } else { best });
    if best == 0 || best + 1 == TRIALS {
        return Ok(at(best as f64));
    }
    // The top of the parabola through the best and its neighbours.
    let [a, b, c] = [explained[best - 1], explained[best], explained[best + 1]];
    let bend = a - 2.0 * b + c;
    let shift = if bend < 0.0 { (0.5 * (a - c) / bend).clamp(-0.5, 0.5) } else { 0.0 };
    Ok(at(best as f64 + shift))
}
