//! A robot boiled down to the constants that the kernels read.

use nalgebra::Matrix3;

use crate::robot::{JointKind, Robot};

pub(super) type V3 = [f64; 3];
pub(super) type M3 = [[f64; 3]; 3];

/// Geometry of a robot as the kernels need it. Build it once, use it for every sample.
#[derive(Debug, Clone, PartialEq)]
pub struct Chain {
    pub(super) joints: Vec<Node>,
    /// Base outwards.
    pub(super) order: Vec<usize>,
    /// Gravity in the base frame [m/s²].
    pub(super) gravity: V3,
}

/// One joint: how its link moves against the parent.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Node {
    pub parent: Option<usize>,
    pub kind: JointKind,
    /// Link-to-parent rotation `turn[0] + sin(q) turn[1] + cos(q) turn[2]`; a prismatic joint has only the first.
    pub turn: [M3; 3],
    /// Origin of the joint frame in the parent frame; a prismatic joint adds `slide * q`.
    pub place: V3,
    pub slide: V3,
    /// Axis in link coordinates.
    pub axis: V3,
    /// From the joint's point on the axis to the link origin, in link coordinates (standard
    /// Denavit-Hartenberg only, where the link frame sits at the far end).
    pub offset: Option<V3>,
}

fn rows(m: &Matrix3<f64>) -> M3 {
    std::array::from_fn(|i| std::array::from_fn(|j| m[(i, j)]))
}

impl Node {
    fn new(joint: &crate::robot::Joint) -> Self {
        let (before, after) = (&joint.before, &joint.after);
        let a = joint.axis;
        let axis = (after.rotation.transpose() * a).into();
        let base = Self {
            parent: joint.parent,
            kind: joint.kind,
            turn: [[[0.0; 3]; 3]; 3],
            place: [0.0; 3],
            slide: [0.0; 3],
            axis,
            offset: None,
        };
        match joint.kind {
            JointKind::Revolute => {
                // Rodrigues: R = aaᵀ + sin [a]x + cos (1 - aaᵀ).
                let along = a * a.transpose();
                let parts = [along, a.cross_matrix(), Matrix3::identity() - along];
                let turn = parts.map(|p| rows(&(before.rotation * p * after.rotation)));
                let d = after.rotation.transpose() * after.translation;
                let offset = (d.norm() > 0.0).then(|| d.into());
                Self { turn, place: before.translation.into(), offset, ..base }
            }
            JointKind::Prismatic => {
                let rotation = before.rotation * after.rotation;
                let place = before.translation + before.rotation * after.translation;
                let turn = [rows(&rotation), [[0.0; 3]; 3], [[0.0; 3]; 3]];
                Self { turn, place: place.into(), slide: (before.rotation * a).into(), ..base }
            }
        }
    }
}

impl Chain {
    /// The constants of `robot`.
    pub fn new(robot: &Robot) -> Self {
        Self {
            joints: robot.joints.iter().map(Node::new).collect(),
            order: robot.order.clone(),
            gravity: robot.gravity.into(),
        }
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// The same chain under another gravity [m/s², base frame].
    #[must_use]
    pub fn with_gravity(&self, gravity: [f64; 3]) -> Self {
        Self { gravity, ..self.clone() }
    }

    /// Whether the torque of `joint` depends on `link`: the joint carries it.
    pub fn carries(&self, joint: usize, link: usize) -> bool {
        let mut at = Some(link);
        while let Some(k) = at {
            if k == joint {
                return true;
            }
            at = self.joints[k].parent;
        }
        false
    }
}
