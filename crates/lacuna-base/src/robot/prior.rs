//! Inertias of one file as a prior for those of another.

use nalgebra::Vector3;

use super::{JointKind, Pose, Robot};
use crate::error::{Error, Result};

/// By how much two files may round the place of the same axis [m, rad].
const SAME: f64 = 1e-3;

impl Robot {
    /// Stacked inertial parameters of this file's links, in the link frames of `other`, link by link.
    ///
    /// Link frames may differ (a URDF's sit on the joints, those of the standard Denavit-Hartenberg convention
    /// at the far ends), joints may not: at zero position the axes of both files must be the same lines in
    /// the base frame, else the numbers would speak of different bodies.
    ///
    /// # Errors
    /// When a link has no inertia, or the joints differ.
    pub fn prior_for(&self, other: &Self) -> Result<Vec<f64>> {
        let remedy =
            "take the prior from a file of the same robot, with the same base frame and zero position";
        if self.dof() != other.dof() {
            let (own, wanted) = (self.dof(), other.dof());
            let what = format!("`{}` has {own} moving links, not {wanted}", self.name);
            return Err(Error::new(what).help(remedy));
        }
        self.inertial_parameters()?;
        let zero = vec![0.0; self.dof()];
        let mut all = Vec::new();
        for (i, link) in self.links.iter().enumerate() {
            let (from, to) = (self.link_pose(&zero, i), other.link_pose(&zero, i));
            if let Some(how) = differ(self.axis_at(i, &from), other.axis_at(i, &to)) {
                let (name, others) = (&self.joints[i].name, &other.joints[i].name);
                let what = format!("its joint `{name}` {how} that of `{others}`, so its links are others");
                return Err(Error::new(what).help(remedy));
            }
            let inertia = link.inertia.unwrap_or(super::InertialParameters::ZERO);
            // No rounding where nothing moves.
            let same = from == to;
            let moved = if same { inertia } else { inertia.moved(&to.inverse().then(&from)) };
            all.extend_from_slice(moved.as_slice());
        }
        Ok(all)
    }

    /// Kind, point and direction of a joint's axis in the base frame, from its link's pose there.
    fn axis_at(&self, i: usize, link: &Pose) -> (JointKind, Vector3<f64>, Vector3<f64>) {
        let joint = &self.joints[i];
        let moved = link.then(&joint.after.inverse());
        (joint.kind, moved.translation, moved.rotation * joint.axis)
    }
}

/// What about an axis differs from another one, in words; `None` when they are the same line.
fn differ(
    (kind, point, direction): (JointKind, Vector3<f64>, Vector3<f64>),
    (other_kind, other_point, other_direction): (JointKind, Vector3<f64>, Vector3<f64>),
) -> Option<&'static str> {
    if kind != other_kind {
        return Some("is of another kind than");
    }
    if (direction - other_direction).norm() > SAME {
        return Some("has another direction than");
    }
    let apart = (point - other_point).cross(&other_direction).norm();
    (kind == JointKind::Revolute && apart > SAME).then_some("lies elsewhere than")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn shipped(name: &str) -> Robot {
        Robot::open(format!("../../robots/{name}")).expect("the shipped robot reads")
    }

    #[test]
    fn the_same_file_gives_the_same_bits() {
        let robot = shipped("panda.ron");
        assert_eq!(robot.prior_for(&robot).ok(), robot.inertial_parameters().ok());
    }

    #[test]
    fn frames_at_the_far_end_and_on_the_joint_mean_the_same_bodies() {
        let robot = shipped("two_link.ron");
        let mut near = robot.clone();
        for i in 0..near.dof() {
            // The link frame moves to the joint: what was behind it goes before the next joint.
            let after = std::mem::replace(&mut near.joints[i].after, Pose::identity());
            near.links[i].inertia = near.links[i].inertia.map(|inertia| inertia.moved(&after));
            for joint in near.joints.iter_mut().filter(|j| j.parent == Some(i)) {
                joint.before = after.then(&joint.before);
            }
        }
        let (own, prior) =
            (robot.inertial_parameters().expect("there"), near.prior_for(&robot).expect("same"));
        for (own, prior) in own.iter().zip(&prior) {
            assert!((own - prior).abs() < 1e-12, "{own} {prior}");
        }
        assert_ne!(near.inertial_parameters().expect("there"), own);
    }

    #[test]
    fn other_robots_are_refused() {
        let (two, seven) = (shipped("two_link.ron"), shipped("panda.ron"));
        let error = two.prior_for(&seven).expect_err("two are not seven").to_string();
        assert!(error.contains("has 2 moving links, not 7"), "{error}");
        let mut bent = two.clone();
        // Along its own axis it may sit anywhere.
        bent.joints[1].before.translation.z += 0.01;
        assert!(bent.prior_for(&two).is_ok());
        bent.joints[1].before.translation.x += 0.01;
        let error = bent.prior_for(&two).expect_err("it is elsewhere").to_string();
        assert!(error.contains("`joint2` lies elsewhere") && error.contains("help: "), "{error}");
        let mut turned = two.clone();
        turned.joints[0].axis = -turned.joints[0].axis;
        let error = turned.prior_for(&two).expect_err("it turns the other way").to_string();
        assert!(error.contains("`joint1` has another direction"), "{error}");
    }
}
