//! Derivatives of the model's torque: in time, and along a displacement of one joint.

use std::ops::Range;

use super::Stretch;
use crate::kernels::{Direction, torque_derivative_batch};
use crate::robot::Robot;
use crate::signals::{ModelTorque, central_difference};

/// Samples on both sides of a stretch that its differences need; more than enough for second ones that are
/// one-sided at the ends of the run.
const MARGIN: usize = 8;

/// First and second time derivative of `column`, which covers the whole run, over `range`.
pub(super) fn time_derivatives(column: &[f64], dt: f64, range: Range<usize>) -> [Vec<f64>; 2] {
    let wide = range.start.saturating_sub(MARGIN)..(range.end + MARGIN).min(column.len());
    let inner = range.start - wide.start..range.end - wide.start;
    let first = central_difference(&column[wide], dt);
    let second = central_difference(&first, dt);
    [first[inner.clone()].to_vec(), second[inner].to_vec()]
}

/// Change of all joint torques per unit of a displacement of `joint` that is `shift[k]` at sample `k` of the
/// whole run, with the velocity and acceleration that go with it; over the stretch.
pub(super) fn along_shift(
    at: &Stretch<'_>,
    model: &ModelTorque,
    joint: usize,
    shift: &[f64],
) -> Vec<Vec<f64>> {
    let [dq, ddq] = time_derivatives(shift, at.run.dt, at.range.clone());
    let direction = Direction { joint, q: &shift[at.range.clone()], dq: &dq, ddq: &ddq };
    torque_derivative_batch(at.chain, at.samples(), at.range.clone(), direction, &model.links)
}

/// Change of all joint torques per unit of a constant displacement of `joint`.
pub(super) fn along_position(at: &Stretch<'_>, model: &ModelTorque, joint: usize) -> Vec<Vec<f64>> {
    let (one, none) = (vec![1.0; at.range.len()], vec![0.0; at.range.len()]);
    let direction = Direction { joint, q: &one, dq: &none, ddq: &none };
    torque_derivative_batch(at.chain, at.samples(), at.range.clone(), direction, &model.links)
}

/// The joints whose torque depends on the motion of `joint`: those it carries and those that carry it.
pub(super) fn concerned(robot: &Robot, joint: usize) -> Vec<usize> {
    let on_path = |from: usize, to: usize| robot.path_to_base(from).any(|i| i == to);
    (0..robot.dof()).filter(|&i| on_path(i, joint) || on_path(joint, i)).collect()
}
