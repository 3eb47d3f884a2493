//! Search for the nonlinear parameters of an effect (variable projection).

use std::sync::Arc;

use super::data::Data;
use super::present::Present;
use super::score::{Projection, Ridge};
use crate::effects::{Effect, Shape};
use crate::error::Result;

/// Rounds of halving the steps.
const ROUNDS: usize = 8;

/// The effect with the shapes that explain most beside the model at hand; linear parameters are projected out.
pub(super) fn shapes(data: &Data, present: &Present, start: Box<dyn Effect>) -> Result<Box<dyn Effect>> {
    let shapes = start.shapes();
    if shapes.is_empty() {
        return Ok(start);
    }
    let explained = |values: &[f64]| -> Result<f64> {
        let effect = start.with_shapes(values);
        let columns = data.candidate_columns(effect.as_ref())?.into_iter().map(Arc::new).collect();
        let projection = Projection::new(data, present, vec![columns], Ridge::None);
        Ok(projection.explained(data, present, &data.tau, 0).unwrap_or(f64::NEG_INFINITY))
    };
    let mut now: Vec<f64> = shapes.iter().map(|s| s.value).collect();
    let mut best = explained(&now)?;
    let mut step = 0.5;
    for _ in 0..ROUNDS {
        let mut moved = true;
        let mut turns = 0;
        while moved && turns < 6 {
            (moved, turns) = (false, turns + 1);
            for (k, shape) in shapes.iter().enumerate() {
                for sign in [1.0, -1.0] {
                    let mut next = now.clone();
                    next[k] = stepped(shape, now[k], sign * step);
                    let value = explained(&next)?;
                    if value > best {
                        (best, now, moved) = (value, next, true);
                    }
                }
            }
        }
        step *= 0.5;
    }
    Ok(start.with_shapes(&now))
}

/// One step from `x`: by a factor where the shape is positive, else by a part of its range.
fn stepped(shape: &Shape, x: f64, step: f64) -> f64 {
    let next = if shape.low > 0.0 { x * libm::exp(step) } else { x + 0.2 * step * (shape.high - shape.low) };
    next.clamp(shape.low, shape.high)
}
