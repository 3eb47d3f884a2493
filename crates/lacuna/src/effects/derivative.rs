//! Derivatives of the model's torque: in time, and along a displacement of one joint.

use std::ops::Range;

use super::Stretch;
use crate::kernels::{Direction, torque_derivative_batch};
use crate::robot::Robot;
use crate::signals::{ModelTorque, ZeroPhase, smooth_derivative};

/// Samples on both sides of a stretch that its differences need; more than enough for second ones that are
/// one-sided at the ends of the run.
const MARGIN: usize = 8;
/// Order of the low-pass that leaves the slow part of a torque.
const SLOW_ORDER: usize = 2;

/// First and second time derivative of `column`, which covers the whole run, over `range`.
pub(super) fn time_derivatives(column: &[f64], dt: f64, range: Range<usize>) -> [Vec<f64>; 2] {
    let wide = range.start.saturating_sub(MARGIN)..(range.end + MARGIN).min(column.len());
    let inner = range.start - wide.start..range.end - wide.start;
    let first = smooth_derivative(&column[wide], dt);
    let second = smooth_derivative(&first, dt);
    [first[inner.clone()].to_vec(), second[inner].to_vec()]
}

/// Periods of a low-pass's cut-off after which nothing is left of a disturbance that matters here (of order 4:
/// exp(-0.38 2 pi 10), some 4e-11 of it).
const FADED: f64 = 10.0;

/// `wanted` and as many samples on both sides as `filter` needs to be right there, of a run of `samples`.
fn around(wanted: &Range<usize>, filter: &ZeroPhase, dt: f64, samples: usize) -> Range<usize> {
    let reach = (FADED / (filter.cutoff_hz() * dt)).ceil() as usize;
    wanted.start.saturating_sub(reach)..(wanted.end + reach).min(samples)
}

/// A displacement of a joint that jumps with the torque it carries, as the measured motion has it: `shift` of the
/// torque, sent through the filter that the positions of the log went through before they were differentiated.
/// Covers the run, and is right over the stretch.
///
/// The measured motion has the jump in it, so a torque computed from it swings to and fro where it changes sign, and
/// would cross zero several times. Its slow part, below `slow_hz`, does not: the area under the swing is zero. A motion
/// that went through no filter is no measurement, and taken as it is.
pub(super) fn jump(at: &Stretch<'_>, torque: &[f64], slow_hz: f64, shift: impl Fn(f64) -> f64) -> Vec<f64> {
    let Some(measured) = &at.run.motion_filter else { return torque.iter().map(|tau| shift(*tau)).collect() };
    let (dt, samples) = (at.run.dt, at.run.samples());
    let own = at.range.start.saturating_sub(MARGIN)..(at.range.end + MARGIN).min(samples);
    let wide = around(&own, measured, dt, samples);
    let mut slow = torque.to_vec();
    if let Ok(filter) = ZeroPhase::butterworth(SLOW_ORDER, slow_hz, dt) {
        let wider = around(&wide, &filter, dt, samples);
        filter.apply(&mut slow[wider]);
    }
    let mut seen = vec![0.0; samples];
    seen[wide.clone()].iter_mut().zip(&slow[wide.clone()]).for_each(|(y, tau)| *y = shift(*tau));
    measured.apply(&mut seen[wide]);
    seen
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
