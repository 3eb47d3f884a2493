//! Recursive Newton-Euler: joint torques from motion and inertial parameters.

use super::chain::Chain;
use super::motion::{LinkMotion, State, Workspace, propagate};
use super::real::Real;
use super::vector::{add, cross, cross_constant, dot_constant, lift, turn};
use crate::robot::{JointKind, PARAMETERS_PER_LINK};

/// Inverse dynamics `tau = M(q) ddq + c(q, dq) + g(q)` by the recursive Newton-Euler algorithm.
///
/// `parameters` are the stacked [`crate::robot::InertialParameters`] (10 per link), so the result is
/// linear in them. Writes one torque per joint [N m, N] to `tau`; the wrench that each joint carries
/// stays in the workspace ([`wrench`]).
#[inline(always)]
pub fn inverse_dynamics<T: Real>(
    chain: &Chain,
    ws: &mut Workspace<T>,
    state: State<'_, T>,
    parameters: &[f64],
    tau: &mut [T],
) {
    propagate(chain, ws, state);
    for (i, link) in ws.links.iter().enumerate() {
        let at = PARAMETERS_PER_LINK * i;
        (ws.force[i], ws.moment[i]) = body_wrench(link, &parameters[at..at + PARAMETERS_PER_LINK]);
    }
    for &i in chain.order.iter().rev() {
        let node = &chain.joints[i];
        let (force, moment) = (ws.force[i], ws.moment[i]);
        tau[i] = match (node.kind, &node.offset) {
            (JointKind::Prismatic, _) => dot_constant(force, &node.axis),
            (JointKind::Revolute, None) => dot_constant(moment, &node.axis),
            (JointKind::Revolute, Some(d)) => {
                let at_axis = add(moment, cross(lift(tau[i], d), force));
                dot_constant(at_axis, &node.axis)
            }
        };
        if let Some(p) = node.parent {
            let link = &ws.links[i];
            let carried = turn(&link.rotation, force);
            let twist = add(turn(&link.rotation, moment), cross(link.origin, carried));
            ws.force[p] = add(ws.force[p], carried);
            ws.moment[p] = add(ws.moment[p], twist);
        }
    }
}

/// Force \[N\] and moment about the link origin [N m] that joint `i` carries, in link axes, as the last
/// [`inverse_dynamics`] left them.
pub fn wrench<T: Real>(ws: &Workspace<T>, i: usize) -> ([T; 3], [T; 3]) {
    (ws.force[i], ws.moment[i])
}

/// Force and moment about the link origin that the motion of one body asks for.
#[inline(always)]
fn body_wrench<T: Real>(link: &LinkMotion<T>, p: &[f64]) -> ([T; 3], [T; 3]) {
    let (omega, alpha, accel) = (link.omega, link.alpha, link.accel);
    let first = [p[1], p[2], p[3]];
    let inner = cross_constant(omega, &first);
    let force = add(scale_constant(accel, p[0]), add(cross_constant(alpha, &first), cross(omega, inner)));
    let spin = inertia(p, omega);
    let turned = add(inertia(p, alpha), cross(omega, spin));
    // mc × accel = -(accel × mc)
    let lever = cross_constant(accel, &first);
    let moment = [turned[0] - lever[0], turned[1] - lever[1], turned[2] - lever[2]];
    (force, moment)
}

#[inline(always)]
fn scale_constant<T: Real>(a: [T; 3], c: f64) -> [T; 3] {
    [a[0] * c, a[1] * c, a[2] * c]
}

/// `J x` with the inertia about the link origin.
#[inline(always)]
pub(super) fn inertia<T: Real>(p: &[f64], x: [T; 3]) -> [T; 3] {
    [
        x[0] * p[4] + x[1] * p[5] + x[2] * p[6],
        x[0] * p[5] + x[1] * p[7] + x[2] * p[8],
        x[0] * p[6] + x[1] * p[8] + x[2] * p[9],
    ]
}

/// Velocity of the link origin and angular velocity under unit speed of joint `i`, in link axes.
#[inline(always)]
pub(super) fn unit_twist<T: Real>(chain: &Chain, i: usize, like: T) -> ([T; 3], [T; 3]) {
    let node = &chain.joints[i];
    let axis = lift(like, &node.axis);
    let none = [like.lift(0.0); 3];
    match (node.kind, &node.offset) {
        (JointKind::Prismatic, _) => (axis, none),
        (JointKind::Revolute, None) => (none, axis),
        (JointKind::Revolute, Some(d)) => (cross_constant(axis, d), axis),
    }
}
