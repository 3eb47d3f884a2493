//! Frames along the joint axes, in which a step from a body to its parent costs little.
//!
//! The inertia matrix does not depend on where link frames sit. So each body gets one of its own: z along its joint's
//! axis, x along the common normal to the axis of its first child (Denavit and Hartenberg 1955). A step to the parent is
//! then a turn about z, a shift along z, a turn about x and a shift along x, most of which real robots do not have. Where
//! two axes are nearly parallel their common normal lies anywhere, and x points at the other axis instead.

use nalgebra::{Matrix3, Vector3};

use super::chain::{Chain, Node};
use crate::robot::JointKind;

/// Angles \[rad\] and lengths \[m\] below this are rounding of the robot file's numbers.
const ROUNDING: f64 = 1e-14;
/// Axes whose angle has a smaller sine have no common normal worth the name.
const NEARLY_PARALLEL: f64 = 0.05;

/// From a body's frame to its parent's: the joint's own motion first, then these in order.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Step {
    pub parent: Option<usize>,
    pub kind: JointKind,
    /// Angle about the axis where the joint is at 0 \[rad\].
    pub angle: f64,
    /// Shift along the axis where the joint is at 0 \[m\].
    pub rise: Option<f64>,
    /// Turn about x.
    pub tilt: Tilt,
    /// Sine and cosine of a turn about the parent's z; only where the parent's x serves another child.
    pub twist: Option<[f64; 2]>,
    /// Shift along the parent's x, y, z \[m\].
    pub shift: [Option<f64>; 3],
}

/// How the axis leans against its parent's.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Tilt {
    /// Parallel.
    None,
    /// By a right angle.
    Quarter,
    /// By an angle with this sine and cosine.
    Any([f64; 2]),
}

/// Where a body's frame sits in the link frame.
#[derive(Debug, Clone)]
pub(super) struct Seat {
    /// x, y, z as columns.
    pub rotation: Matrix3<f64>,
    pub origin: Vector3<f64>,
}

fn matrix(rows: &[[f64; 3]; 3]) -> Matrix3<f64> {
    Matrix3::from_fn(|i, j| rows[i][j])
}

/// Rotation of a link against its parent where its joint is at 0.
fn at_rest(node: &Node) -> Matrix3<f64> {
    match node.kind {
        JointKind::Revolute => matrix(&node.turn[0]) + matrix(&node.turn[2]),
        JointKind::Prismatic => matrix(&node.turn[0]),
    }
}

/// The point of the axis that lies at `node.place` in the parent link, in link coordinates.
fn point(node: &Node) -> Vector3<f64> {
    -Vector3::from(node.offset.unwrap_or_default())
}

/// `None` where it is rounding.
fn length(x: f64) -> Option<f64> {
    (x.abs() > ROUNDING).then_some(x)
}

/// A unit vector across `z`.
fn across(z: &Vector3<f64>) -> Vector3<f64> {
    z.cross(&Vector3::ith(z.iamin(), 1.0)).normalize()
}

/// The body's frame for the axis of its joint and that of its first child.
fn seat(node: &Node, child: Option<&Node>) -> Seat {
    let (z, start) = (Vector3::from(node.axis).normalize(), point(node));
    let (x, origin) = match child {
        None => (across(&z), start),
        Some(child) => {
            let other = at_rest(child) * Vector3::from(child.axis).normalize();
            let (between, normal) = (Vector3::from(child.place) - start, z.cross(&other));
            let sine = normal.norm();
            if sine > NEARLY_PARALLEL {
                let foot = between.cross(&other).dot(&normal) / (sine * sine);
                (normal / sine, start + z * foot)
            } else {
                let foot = z.dot(&between);
                let aside = between - z * foot;
                let x = if aside.norm() > 1e-9 { aside.normalize() } else { across(&z) };
                (x, start + z * foot)
            }
        }
    };
    Seat { rotation: Matrix3::from_columns(&[x, z.cross(&x), z]), origin }
}

/// The step from the frame `own` of `node` to that of its parent, `up`.
fn step(node: &Node, own: &Seat, up: Option<&Seat>) -> Step {
    let none = Step {
        parent: node.parent,
        kind: node.kind,
        angle: 0.0,
        rise: None,
        tilt: Tilt::None,
        twist: None,
        shift: [None; 3],
    };
    let Some(up) = up else { return none };
    let turned = up.rotation.transpose() * at_rest(node) * own.rotation;
    let z = turned.column(2);
    // z of the child is (sin tilt sin twist, -sin tilt cos twist, cos tilt).
    let (sine, cosine) = (libm::hypot(z[0], z[1]), z[2]);
    let (tilt, twist) = match sine {
        s if s <= ROUNDING && cosine > 0.0 => (Tilt::None, [0.0, 1.0]),
        s if s <= ROUNDING => (Tilt::Any([0.0, -1.0]), [0.0, 1.0]),
        s if cosine.abs() <= ROUNDING => (Tilt::Quarter, [z[0] / s, -z[1] / s]),
        s => (Tilt::Any([s, cosine]), [z[0] / s, -z[1] / s]),
    };
    let [s, c] = twist;
    let (sin, cos) = match tilt {
        Tilt::None => (0.0, 1.0),
        Tilt::Quarter => (1.0, 0.0),
        Tilt::Any([sin, cos]) => (sin, cos),
    };
    let about_z = Matrix3::new(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
    let about_x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cos, -sin, 0.0, sin, cos);
    let x = (about_z * about_x).transpose() * turned.column(0);
    let shift = up.rotation.transpose() * (Vector3::from(node.place) - up.origin);
    Step {
        angle: libm::atan2(x[1], x[0]),
        rise: length((own.origin - point(node)).dot(&Vector3::from(node.axis))),
        tilt,
        twist: (s.abs() > ROUNDING || c < 0.0).then_some(twist),
        shift: [length(shift[0]), length(shift[1]), length(shift[2])],
        ..none
    }
}

/// A frame for every body, and the steps between them.
pub(super) fn axes(chain: &Chain) -> (Vec<Seat>, Vec<Step>) {
    let first_child = |i: usize| chain.joints.iter().find(|node| node.parent == Some(i));
    let seats: Vec<Seat> =
        chain.joints.iter().enumerate().map(|(i, node)| seat(node, first_child(i))).collect();
    let of = |(node, own): (&Node, &Seat)| step(node, own, node.parent.map(|p| &seats[p]));
    let steps = chain.joints.iter().zip(&seats).map(of).collect();
    (seats, steps)
}
