//! Where the plant's links are: forward kinematics of the plant's own.

use nalgebra::{Matrix3, Vector3};

use lacuna_base::error::{Error, Result};
use lacuna_base::robot::{InertialParameters, JointKind, PARAMETERS_PER_LINK, Pose, Robot};

/// One joint, with what its motion needs worked out once.
#[derive(Debug, Clone)]
pub(super) struct JointGeometry {
    pub(super) kind: JointKind,
    pub(super) parent: Option<usize>,
    pub(super) before: Pose,
    pub(super) axis: Vector3<f64>,
    pub(super) after: Pose,
    cross: Matrix3<f64>,
    cross_squared: Matrix3<f64>,
}

impl JointGeometry {
    /// Pose of the link frame in the parent link frame at joint position `position` [rad, m].
    pub(super) fn pose(&self, position: f64) -> Pose {
        let moved = match self.kind {
            // Rodrigues' formula.
            JointKind::Revolute => {
                let (sin, cos) = libm::sincos(position);
                let turn = Matrix3::identity() + self.cross * sin + self.cross_squared * (1.0 - cos);
                Pose { rotation: turn, translation: Vector3::zeros() }
            }
            JointKind::Prismatic => Pose { rotation: Matrix3::identity(), translation: self.axis * position },
        };
        self.before.then(&moved).then(&self.after)
    }
}

/// The tree of joints of a robot, checked: poses of all links from joint positions.
#[derive(Debug, Clone)]
pub struct Kinematics {
    pub(super) joints: Vec<JointGeometry>,
    pub(super) order: Vec<usize>,
}

impl Kinematics {
    /// Takes the geometry of `robot`.
    ///
    /// # Errors
    /// When `order` does not name every joint once, parents first, or an axis is not a unit vector.
    pub fn new(robot: &Robot) -> Result<Self> {
        check_order(robot)?;
        let mut joints = Vec::with_capacity(robot.dof());
        for joint in &robot.joints {
            let length = joint.axis.norm();
            if !length.is_finite() || (length - 1.0).abs() > 1e-9 {
                let what = format!("the axis of joint `{}` has length {length}", joint.name);
                return Err(Error::new(what).help("give a unit vector"));
            }
            let cross = joint.axis.cross_matrix();
            joints.push(JointGeometry {
                kind: joint.kind,
                parent: joint.parent,
                before: joint.before,
                axis: joint.axis,
                after: joint.after,
                cross,
                cross_squared: cross * cross,
            });
        }
        Ok(Self { joints, order: robot.order.clone() })
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Pose of every link frame in the base frame at joint positions `q` [rad, m].
    ///
    /// # Panics
    /// When `q` is shorter than [`Kinematics::dof`].
    pub fn poses(&self, q: &[f64]) -> Vec<Pose> {
        let mut poses = vec![Pose::identity(); self.dof()];
        for &i in &self.order {
            let joint = &self.joints[i];
            let local = joint.pose(q[i]);
            poses[i] = joint.parent.map_or(local, |p| poses[p].then(&local));
        }
        poses
    }

    /// Adds to `out` the joint torques [N m, N] that a force \[N\] (base frame) at `point` \[m\] of link `link`
    /// (its frame) makes at positions `q` [rad, m].
    ///
    /// # Panics
    /// When there is no such link or a slice is shorter than [`Kinematics::dof`].
    pub fn add_push(
        &self,
        q: &[f64],
        link: usize,
        point: &Vector3<f64>,
        force: &Vector3<f64>,
        out: &mut [f64],
    ) {
        let poses = self.poses(q);
        let at = poses[link].rotation * point + poses[link].translation;
        let mut next = Some(link);
        while let Some(i) = next {
            let joint = &self.joints[i];
            let foot = joint.parent.map_or(joint.before, |p| poses[p].then(&joint.before));
            let axis = foot.rotation * joint.axis;
            let way = match joint.kind {
                JointKind::Revolute => axis.cross(&(at - foot.translation)),
                JointKind::Prismatic => axis,
            };
            out[i] += way.dot(force);
            next = joint.parent;
        }
    }
}

fn check_order(robot: &Robot) -> Result<()> {
    let mut seen = vec![false; robot.dof()];
    for &i in &robot.order {
        let parent_stands =
            |joint: &lacuna_base::robot::Joint| joint.parent.is_none_or(|p| seen.get(p) == Some(&true));
        let fits = robot.joints.get(i).is_some_and(parent_stands) && !seen[i];
        if !fits {
            return Err(Error::new("the joint order of the robot does not run from the base outwards")
                .help("list every joint once in `order`, parents before children"));
        }
        seen[i] = true;
    }
    if robot.order.len() == robot.dof() && robot.links.len() == robot.dof() {
        return Ok(());
    }
    let (links, ordered) = (robot.links.len(), robot.order.len());
    Err(Error::new(format!("{} joints, {links} links and {ordered} joints in order", robot.dof()))
        .help("every joint moves one link and stands once in `order`"))
}

/// Cuts stacked inertial parameters into links.
pub(super) fn bodies(robot: &Robot, parameters: &[f64]) -> Result<Vec<InertialParameters>> {
    let wanted = PARAMETERS_PER_LINK * robot.dof();
    if parameters.len() != wanted || !parameters.iter().all(|p| p.is_finite()) {
        let what = format!("{} inertial parameters for {} links", parameters.len(), robot.dof());
        return Err(Error::new(what).help(format!("give {wanted} finite numbers, ten per link")));
    }
    let (chunks, _) = parameters.as_chunks::<PARAMETERS_PER_LINK>();
    Ok(chunks.iter().copied().map(InertialParameters).collect())
}
