//! The outward pass that every kernel starts with: where each link is and how it moves.

use super::chain::{Chain, Node};
use super::real::Real;
use super::vector::{add, along, cross, cross_constant, lift, turn_back};
use crate::robot::{JointKind, PARAMETERS_PER_LINK};

/// State of one link, in its own frame.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkMotion<T> {
    /// Link-to-parent rotation.
    pub rotation: [[T; 3]; 3],
    /// Link origin in the parent frame.
    pub origin: [T; 3],
    /// Angular velocity.
    pub omega: [T; 3],
    /// Angular acceleration.
    pub alpha: [T; 3],
    /// Acceleration of the link origin, less gravity.
    pub accel: [T; 3],
}

/// What a kernel needs besides its inputs, kept from call to call.
#[derive(Debug, Clone)]
pub struct Workspace<T> {
    pub(super) links: Vec<LinkMotion<T>>,
    pub(super) force: Vec<[T; 3]>,
    pub(super) moment: Vec<[T; 3]>,
    /// What each joint carries, as one body.
    pub(super) carried: Vec<[T; PARAMETERS_PER_LINK]>,
    /// Sine and cosine of each joint's angle, and its shift along the axis.
    pub(super) turns: Vec<[T; 3]>,
}

impl<T: Real> Workspace<T> {
    /// Room for `chain`; `like` is any number of the kind that will be computed with.
    pub fn new(chain: &Chain, like: T) -> Self {
        Self::sized(chain.dof(), like)
    }

    /// The same for a chain of `n` joints.
    pub(super) fn sized(n: usize, like: T) -> Self {
        let o = like.lift(0.0);
        let link =
            LinkMotion { rotation: [[o; 3]; 3], origin: [o; 3], omega: [o; 3], alpha: [o; 3], accel: [o; 3] };
        let (three, ten) = (vec![[o; 3]; n], vec![[o; PARAMETERS_PER_LINK]; n]);
        Self { links: vec![link; n], force: three.clone(), moment: three.clone(), carried: ten, turns: three }
    }
}

/// A joint state: positions, velocities, accelerations, each with one entry per joint.
#[derive(Debug, Clone, Copy)]
pub struct State<'a, T> {
    /// Positions [rad, m].
    pub q: &'a [T],
    /// Velocities [rad/s, m/s].
    pub dq: &'a [T],
    /// Accelerations [rad/s², m/s²].
    pub ddq: &'a [T],
}

impl<'a, T: Real> State<'a, T> {
    /// Borrows three slices of equal length.
    pub fn new(q: &'a [T], dq: &'a [T], ddq: &'a [T]) -> Self {
        Self { q, dq, ddq }
    }
}

/// Places every link: rotation and origin against its parent.
#[inline(always)]
pub(super) fn place<T: Real>(chain: &Chain, ws: &mut Workspace<T>, q: &[T]) {
    for (i, node) in chain.joints.iter().enumerate() {
        let link = &mut ws.links[i];
        (link.rotation, link.origin) = placement(node, q[i]);
    }
}

#[inline(always)]
fn placement<T: Real>(node: &Node, q: T) -> ([[T; 3]; 3], [T; 3]) {
    let [c0, c1, c2] = &node.turn;
    match node.kind {
        JointKind::Revolute => {
            let (sin, cos) = q.sin_cos();
            let rotation = [
                turned_row(sin, cos, [&c0[0], &c1[0], &c2[0]]),
                turned_row(sin, cos, [&c0[1], &c1[1], &c2[1]]),
                turned_row(sin, cos, [&c0[2], &c1[2], &c2[2]]),
            ];
            let place = lift(q, &node.place);
            let origin = match &node.offset {
                None => place,
                Some(d) => add(place, super::vector::turn(&rotation, lift(q, d))),
            };
            (rotation, origin)
        }
        JointKind::Prismatic => {
            let rotation = [lift(q, &c0[0]), lift(q, &c0[1]), lift(q, &c0[2])];
            (rotation, add(lift(q, &node.place), along(&node.slide, q)))
        }
    }
}

/// A row of `c0 + sin c1 + cos c2`. Written out here as in all of the kernels: closures handed to the
/// standard library are compiled without the wide registers, and every operation becomes a call.
#[inline(always)]
fn turned_row<T: Real>(sin: T, cos: T, [c0, c1, c2]: [&[f64; 3]; 3]) -> [T; 3] {
    [
        (sin * c1[0] + cos * c2[0]) + sin.lift(c0[0]),
        (sin * c1[1] + cos * c2[1]) + sin.lift(c0[1]),
        (sin * c1[2] + cos * c2[2]) + sin.lift(c0[2]),
    ]
}

/// Places every link and propagates velocity and acceleration outwards (classical Newton-Euler recursion:
/// accelerations of points, not spatial ones). Gravity enters as an upward acceleration of the base.
#[inline(always)]
pub(super) fn propagate<T: Real>(chain: &Chain, ws: &mut Workspace<T>, state: State<'_, T>) {
    place(chain, ws, state.q);
    for &i in &chain.order {
        let node = &chain.joints[i];
        let (dq, ddq) = (state.dq[i], state.ddq[i]);
        let mut link = ws.links[i];
        let (omega, alpha, accel) = match node.parent {
            Some(p) => {
                let up = &ws.links[p];
                let lever = match node.kind {
                    JointKind::Revolute => lift(dq, &node.place),
                    JointKind::Prismatic => link.origin,
                };
                let swing = add(cross(up.alpha, lever), cross(up.omega, cross(up.omega, lever)));
                let r = &link.rotation;
                (turn_back(r, up.omega), turn_back(r, up.alpha), turn_back(r, add(up.accel, swing)))
            }
            None => {
                let o = dq.lift(0.0);
                let lifted = lift(dq, &chain.gravity.map(|g| -g));
                ([o; 3], [o; 3], turn_back(&link.rotation, lifted))
            }
        };
        let spin = along(&node.axis, dq);
        match node.kind {
            JointKind::Revolute => {
                link.omega = add(omega, spin);
                link.alpha = add(add(alpha, along(&node.axis, ddq)), cross(omega, spin));
                link.accel = match &node.offset {
                    None => accel,
                    Some(d) => {
                        let inner = cross_constant(link.omega, d);
                        add(accel, add(cross_constant(link.alpha, d), cross(link.omega, inner)))
                    }
                };
            }
            JointKind::Prismatic => {
                link.omega = omega;
                link.alpha = alpha;
                let twice = along(&node.axis, dq * 2.0);
                link.accel = add(accel, add(along(&node.axis, ddq), cross(omega, twice)));
            }
        }
        ws.links[i] = link;
    }
}
