//! Rotations and forward kinematics.

use nalgebra::{Matrix3, Vector3};

use super::{Joint, JointKind, Pose, Robot};

/// Sine and cosine, with values within 1e-15 of 0 or ±1 taken as meant exactly.
///
/// Angles of a robot file are mostly multiples of a right angle, and 6e-17 where 0 is meant would
/// later look like a (very poorly) identifiable parameter.
pub(super) fn sin_cos(angle: f64) -> (f64, f64) {
    let snap = |x: f64| {
        let near = libm::round(x);
        if (x - near).abs() < 1e-15 { near + 0.0 } else { x }
    };
    (snap(libm::sin(angle)), snap(libm::cos(angle)))
}

/// Rotation about a unit axis (Rodrigues' formula), from the angle's sine and cosine.
fn rotation((sin, cos): (f64, f64), axis: &Vector3<f64>) -> Matrix3<f64> {
    let turned = axis * axis.transpose();
    Matrix3::identity() * cos + axis.cross_matrix() * sin + turned * (1.0 - cos)
}

/// URDF's roll, pitch, yaw about fixed axes: `Rz(yaw) Ry(pitch) Rx(roll)`.
pub(super) fn from_roll_pitch_yaw(rpy: &Vector3<f64>) -> Matrix3<f64> {
    let about = |angle, axis| rotation(sin_cos(angle), &axis);
    about(rpy.z, Vector3::z()) * about(rpy.y, Vector3::y()) * about(rpy.x, Vector3::x())
}

/// A turn by `angle` about the x axis after a shift by `distance` along it (the two commute).
pub(super) fn along_x(angle: f64, distance: f64) -> Pose {
    Pose { rotation: rotation(sin_cos(angle), &Vector3::x()), translation: Vector3::x() * distance }
}

/// A turn by `angle` about the z axis after a shift by `distance` along it (the two commute).
pub(super) fn along_z(angle: f64, distance: f64) -> Pose {
    Pose { rotation: rotation(sin_cos(angle), &Vector3::z()), translation: Vector3::z() * distance }
}

impl Joint {
    /// Pose of the moved link's frame in the parent link's frame at position `q` [rad or m].
    pub fn pose(&self, q: f64) -> Pose {
        let motion = match self.kind {
            JointKind::Revolute => Pose {
                rotation: rotation((libm::sin(q), libm::cos(q)), &self.axis),
                translation: Vector3::zeros(),
            },
            JointKind::Prismatic => Pose { translation: self.axis * q, ..Pose::identity() },
        };
        self.before.then(&motion).then(&self.after)
    }
}

impl Robot {
    /// Forward kinematics: pose of link `link`'s frame in the base frame at joint positions `q`
    /// [rad or m, one per joint].
    ///
    /// # Panics
    /// When `q` is shorter than the robot has joints or `link` is not one of its links.
    pub fn link_pose(&self, q: &[f64], link: usize) -> Pose {
        self.path_to_base(link).fold(Pose::identity(), |outer, i| self.joints[i].pose(q[i]).then(&outer))
    }
}

/// Joint indices with every parent before its children, otherwise in ascending order; joints on a
/// loop are left out.
pub(super) fn base_outwards(parents: &[Option<usize>]) -> Vec<usize> {
    use std::{cmp::Reverse, collections::BinaryHeap};
    let mut children = vec![Vec::new(); parents.len()];
    let mut ready = BinaryHeap::new();
    for (i, parent) in parents.iter().enumerate() {
        match parent {
            Some(p) => children[*p].push(i),
            None => ready.push(Reverse(i)),
        }
    }
    let mut order = Vec::with_capacity(parents.len());
    while let Some(Reverse(i)) = ready.pop() {
        order.push(i);
        ready.extend(children[i].iter().copied().map(Reverse));
    }
    order
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::{FRAC_PI_2, PI};

    #[test]
    fn right_angles_are_exact_and_others_are_left_alone() {
        assert_eq!(sin_cos(FRAC_PI_2), (1.0, 0.0));
        assert_eq!(sin_cos(-PI), (0.0, -1.0));
        let close = FRAC_PI_2 - 1e-12;
        assert_eq!(sin_cos(close), (1.0, libm::cos(close)));
    }

    #[test]
    fn rotation_keeps_lengths_and_its_axis() {
        let axis = Vector3::new(2.0, -1.0, 0.5).normalize();
        let r = rotation(sin_cos(0.7), &axis);
        assert!((r * r.transpose() - Matrix3::identity()).norm() < 1e-15);
        assert!((r * axis - axis).norm() < 1e-15);
        assert!((r.trace() - (1.0 + 2.0 * libm::cos(0.7))).abs() < 1e-15);
    }

    #[test]
    fn roll_pitch_yaw_turn_about_fixed_axes() {
        // Roll takes y to z, pitch z to x, yaw x to y; x itself goes to -z by pitch and stays there.
        let r = from_roll_pitch_yaw(&Vector3::repeat(FRAC_PI_2));
        assert_eq!(r * Vector3::y(), Vector3::y());
        assert_eq!(r * Vector3::x(), -Vector3::z());
    }

    #[test]
    fn parents_come_first_and_the_document_decides_the_rest() {
        assert_eq!(base_outwards(&[Some(2), None, None, Some(0)]), [1, 2, 0, 3]);
        assert_eq!(base_outwards(&[None, Some(0), Some(1)]), [0, 1, 2]);
        assert_eq!(base_outwards(&[Some(1), Some(0), None]), [2]);
    }
}
