//! Recursive Newton-Euler: joint torques from motion and inertial parameters.

use super::chain::Chain;
use super::motion::{LinkMotion, State, Workspace, propagate};
use super::real::Real;
use super::vector::{add, cross, cross_constant, dot, dot_constant, lift, scale, turn};
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

/// Joint-space inertia matrix `M(q)` by the composite-rigid-body idea on wrenches: column `j` is the
/// torque of a unit acceleration of joint `j` alone. Writes the full matrix row by row.
pub fn mass_matrix<T: Real>(chain: &Chain, ws: &mut Workspace<T>, q: &[T], parameters: &[f64], m: &mut [T]) {
    let n = chain.dof();
    super::motion::place(chain, ws, q);
    let zero = q[0].lift(0.0);
    m.fill(zero);
    let composite = composite_inertia(chain, ws, parameters);
    for j in 0..n {
        // Wrench of the composite body behind joint j under a unit acceleration of that joint.
        let (lin, ang) = unit_twist(chain, j, zero);
        let c = &composite[j];
        let first = [c[1], c[2], c[3]];
        let mut force = add(scale(lin, c[0]), cross(ang, first));
        let mut moment = add(composite_turn(c, ang), cross(first, lin));
        let mut at = j;
        loop {
            let (lin, ang) = unit_twist(chain, at, zero);
            let value = dot(lin, force) + dot(ang, moment);
            m[j * n + at] = value;
            m[at * n + j] = value;
            let Some(p) = chain.joints[at].parent else { break };
            let link = &ws.links[at];
            force = turn(&link.rotation, force);
            moment = add(turn(&link.rotation, moment), cross(link.origin, force));
            at = p;
        }
    }
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

#[inline(always)]
fn composite_turn<T: Real>(c: &[T; PARAMETERS_PER_LINK], x: [T; 3]) -> [T; 3] {
    [
        c[4] * x[0] + c[5] * x[1] + c[6] * x[2],
        c[5] * x[0] + c[7] * x[1] + c[8] * x[2],
        c[6] * x[0] + c[8] * x[1] + c[9] * x[2],
    ]
}

/// Inertial parameters of everything that each joint carries, in the link frame of that joint.
fn composite_inertia<T: Real>(
    chain: &Chain,
    ws: &Workspace<T>,
    parameters: &[f64],
) -> Vec<[T; PARAMETERS_PER_LINK]> {
    let like = ws.links[0].origin[0];
    let mut all: Vec<[T; PARAMETERS_PER_LINK]> = parameters
        .chunks_exact(PARAMETERS_PER_LINK)
        .map(|p| std::array::from_fn(|i| like.lift(p[i])))
        .collect();
    for &i in chain.order.iter().rev() {
        if let Some(p) = chain.joints[i].parent {
            let moved = moved_inertia(&all[i], &ws.links[i].rotation, ws.links[i].origin);
            for (sum, part) in all[p].iter_mut().zip(moved) {
                *sum += part;
            }
        }
    }
    all
}

/// Inertial parameters in the parent frame: rotate, then shift the point of reference.
fn moved_inertia<T: Real>(
    c: &[T; PARAMETERS_PER_LINK],
    r: &[[T; 3]; 3],
    p: [T; 3],
) -> [T; PARAMETERS_PER_LINK] {
    let mc = turn(r, [c[1], c[2], c[3]]);
    let j = [[c[4], c[5], c[6]], [c[5], c[7], c[8]], [c[6], c[8], c[9]]];
    let jr: [[T; 3]; 3] = std::array::from_fn(|row| turn(&j, r[row]));
    let rotated = |a: usize, b: usize| dot(r[a], jr[b]);
    // About the parent origin: J + (2 p·mc + m p·p) 1 - (p mcᵀ + mc pᵀ) - m p pᵀ.
    let trace = dot(p, mc) * 2.0 + c[0] * dot(p, p);
    let shift = |a: usize, b: usize| {
        let off = -(p[a] * mc[b] + mc[a] * p[b] + c[0] * p[a] * p[b]);
        if a == b { off + trace } else { off }
    };
    let first = add(mc, scale(p, c[0]));
    let entry = |a: usize, b: usize| rotated(a, b) + shift(a, b);
    [
        c[0],
        first[0],
        first[1],
        first[2],
        entry(0, 0),
        entry(0, 1),
        entry(0, 2),
        entry(1, 1),
        entry(1, 2),
        entry(2, 2),
    ]
}
