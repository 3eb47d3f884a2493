//! How sharply Coulomb friction turns round on each joint. That is no finding (the sampling, the filters and the
//! controller all have a hand in it), but a sign too sharp or too soft leaves an error that looks like physics.

use std::sync::Arc;

use rayon::prelude::*;

use super::data::{Column, Data};
use super::parts::Parts;
use super::present::{Columns, Present};
use super::score::{Projection, Ridge};
use crate::effects::{CoulombFriction, Effect, Joints};
use crate::error::Result;
use crate::robot::Robot;

/// Widths within this factor of what the signal step chose are tried: how soft a sign may be is decided there, on
/// held-out data.
const AROUND: f64 = 1.8;
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
        let width = width(data, &present, effect, parts.widths[joint])?;
        let sharpened = parts.get(part).effect.with_width(width);
        parts.widths[joint] = width;
        parts.replace(part, data, sharpened)?;
    }
    parts.rebuild(data, true)
}

fn width(data: &Data, present: &Present, effect: &dyn Effect, near: f64) -> Result<f64> {
    let at = |place: f64| near * libm::pow(AROUND, 2.0 * place / (TRIALS - 1) as f64 - 1.0);
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
