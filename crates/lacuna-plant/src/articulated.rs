//! Forward dynamics by articulated bodies (Featherstone 2008, table 7.1), for any tree of joints.
//!
//! Spatial vectors stack angular over linear, (moment over force) and are written in link frames. Nothing
//! here is shared with the inverse dynamics and regressors that identification uses.

use nalgebra::{Matrix3, Matrix6, Vector3, Vector6};

use super::kinematics::{Kinematics, bodies};
use lacuna_base::error::Result;
use lacuna_base::robot::{InertialParameters, JointKind, Pose, Robot};

/// What one link needs: constants first, then the scratch of one evaluation.
#[derive(Debug, Clone)]
struct Body {
    /// Direction of the joint's motion in the link frame, constant there.
    subspace: Vector6<f64>,
    inertia: Matrix6<f64>,
    /// Motion vectors from the parent link frame to this one.
    transform: Matrix6<f64>,
    velocity: Vector6<f64>,
    velocity_product: Vector6<f64>,
    articulated_inertia: Matrix6<f64>,
    bias_force: Vector6<f64>,
    acceleration: Vector6<f64>,
    /// Articulated inertia times subspace, and its projection on the joint.
    coupling: Vector6<f64>,
    joint_inertia: f64,
    joint_force: f64,
}

/// Forward dynamics of one robot with its workspace: evaluations allocate nothing.
#[derive(Debug, Clone)]
pub struct ForwardDynamics {
    kinematics: Kinematics,
    bodies: Vec<Body>,
    gravity: Vector3<f64>,
    armature: Vec<f64>,
}

impl ForwardDynamics {
    /// For `robot` with the stacked inertial parameters `parameters` (ten per link).
    ///
    /// # Errors
    /// When the parameters do not fit the robot or are not finite, or its tree of joints is not one.
    pub fn new(robot: &Robot, parameters: &[f64]) -> Result<Self> {
        let kinematics = Kinematics::new(robot)?;
        let inertias = bodies(robot, parameters)?;
        let link = |(joint, inertia): (&super::kinematics::JointGeometry, &InertialParameters)| Body {
            subspace: subspace(joint.kind, &joint.axis, &joint.after),
            inertia: spatial_inertia(inertia),
            transform: Matrix6::identity(),
            velocity: Vector6::zeros(),
            velocity_product: Vector6::zeros(),
            articulated_inertia: Matrix6::zeros(),
            bias_force: Vector6::zeros(),
            acceleration: Vector6::zeros(),
            coupling: Vector6::zeros(),
            joint_inertia: 0.0,
            joint_force: 0.0,
        };
        let bodies = kinematics.joints.iter().zip(&inertias).map(link).collect();
        let armature = vec![0.0; robot.dof()];
        Ok(Self { kinematics, bodies, gravity: robot.gravity, armature })
    }

    /// Sets inertia that a joint feels without moving a link, such as a geared rotor's [kg m², kg].
    ///
    /// # Panics
    /// When the slice is not one number per joint.
    pub fn set_armature(&mut self, armature: &[f64]) {
        self.armature.copy_from_slice(armature);
    }

    /// Writes joint accelerations `ddq` [rad/s², m/s²] under joint torques `tau` [N m, N] at positions `q`
    /// [rad, m] and velocities `dq` [rad/s, m/s]. They are not finite where a joint moves no inertia.
    ///
    /// # Panics
    /// When a slice is shorter than the number of joints.
    pub fn acceleration(&mut self, q: &[f64], dq: &[f64], tau: &[f64], ddq: &mut [f64]) {
        self.spread_velocities(q, dq);
        self.gather_inertia(tau);
        self.spread_accelerations(ddq);
    }

    /// Diagonal of the inverse mass matrix at `q`: how fast each joint answers a unit torque on itself.
    ///
    /// # Panics
    /// When `q` is shorter than the number of joints.
    pub fn mobility(&mut self, q: &[f64]) -> Vec<f64> {
        let n = self.bodies.len();
        let (rest, mut tau) = (vec![0.0; n], vec![0.0; n]);
        let (mut free, mut pushed) = (vec![0.0; n], vec![0.0; n]);
        self.acceleration(q, &rest, &tau, &mut free);
        (0..n)
            .map(|j| {
                tau[j] = 1.0;
                self.acceleration(q, &rest, &tau, &mut pushed);
                tau[j] = 0.0;
                pushed[j] - free[j]
            })
            .collect()
    }

    fn spread_velocities(&mut self, q: &[f64], dq: &[f64]) {
        for &i in &self.kinematics.order {
            let joint = &self.kinematics.joints[i];
            let transform = motion_transform(&joint.pose(q[i]));
            let carried = joint.parent.map_or_else(Vector6::zeros, |p| transform * self.bodies[p].velocity);
            let body = &mut self.bodies[i];
            let own = body.subspace * dq[i];
            body.transform = transform;
            body.velocity = carried + own;
            body.velocity_product = cross_motion(&body.velocity, &own);
            body.articulated_inertia = body.inertia;
            body.bias_force = cross_force(&body.velocity, &(body.inertia * body.velocity));
        }
    }

    fn gather_inertia(&mut self, tau: &[f64]) {
        for &i in self.kinematics.order.iter().rev() {
            let body = &mut self.bodies[i];
            body.coupling = body.articulated_inertia * body.subspace;
            body.joint_inertia = body.subspace.dot(&body.coupling) + self.armature[i];
            body.joint_force = tau[i] - body.subspace.dot(&body.bias_force);
            let Some(parent) = self.kinematics.joints[i].parent else { continue };
            let across =
                body.articulated_inertia - body.coupling * (body.coupling / body.joint_inertia).transpose();
            let bias = body.bias_force
                + across * body.velocity_product
                + body.coupling * (body.joint_force / body.joint_inertia);
            let back = body.transform.transpose();
            let (inertia, force) = (back * across * body.transform, back * bias);
            self.bodies[parent].articulated_inertia += inertia;
            self.bodies[parent].bias_force += force;
        }
    }

    fn spread_accelerations(&mut self, ddq: &mut [f64]) {
        // A base that accelerates upwards feels like gravity.
        let base = stack(Vector3::zeros(), -self.gravity);
        for &i in &self.kinematics.order {
            let from = self.kinematics.joints[i].parent.map_or(base, |p| self.bodies[p].acceleration);
            let body = &mut self.bodies[i];
            let carried = body.transform * from + body.velocity_product;
            ddq[i] = (body.joint_force - body.coupling.dot(&carried)) / body.joint_inertia;
            body.acceleration = carried + body.subspace * ddq[i];
        }
    }
}

fn stack(upper: Vector3<f64>, lower: Vector3<f64>) -> Vector6<f64> {
    Vector6::new(upper.x, upper.y, upper.z, lower.x, lower.y, lower.z)
}

fn split(v: &Vector6<f64>) -> (Vector3<f64>, Vector3<f64>) {
    (Vector3::new(v[0], v[1], v[2]), Vector3::new(v[3], v[4], v[5]))
}

/// Unit joint motion seen from the link frame, which sits at `after` in the moved joint frame.
fn subspace(kind: JointKind, axis: &Vector3<f64>, after: &Pose) -> Vector6<f64> {
    let back = after.rotation.transpose();
    match kind {
        JointKind::Revolute => stack(back * axis, back * axis.cross(&after.translation)),
        JointKind::Prismatic => stack(Vector3::zeros(), back * axis),
    }
}

fn spatial_inertia(body: &InertialParameters) -> Matrix6<f64> {
    let moment = body.first_moment().cross_matrix();
    let mut inertia = Matrix6::zeros();
    inertia.fixed_view_mut::<3, 3>(0, 0).copy_from(&body.inertia_at_origin());
    inertia.fixed_view_mut::<3, 3>(0, 3).copy_from(&moment);
    inertia.fixed_view_mut::<3, 3>(3, 0).copy_from(&moment.transpose());
    inertia.fixed_view_mut::<3, 3>(3, 3).copy_from(&(Matrix3::identity() * body.mass()));
    inertia
}

/// Takes motion vectors of the parent frame to the frame that has `pose` in it.
fn motion_transform(pose: &Pose) -> Matrix6<f64> {
    let turn = pose.rotation.transpose();
    let mut transform = Matrix6::zeros();
    transform.fixed_view_mut::<3, 3>(0, 0).copy_from(&turn);
    transform.fixed_view_mut::<3, 3>(3, 0).copy_from(&(-turn * pose.translation.cross_matrix()));
    transform.fixed_view_mut::<3, 3>(3, 3).copy_from(&turn);
    transform
}

fn cross_motion(v: &Vector6<f64>, m: &Vector6<f64>) -> Vector6<f64> {
    let ((w, u), (mw, mu)) = (split(v), split(m));
    stack(w.cross(&mw), w.cross(&mu) + u.cross(&mw))
}

fn cross_force(v: &Vector6<f64>, f: &Vector6<f64>) -> Vector6<f64> {
    let ((w, u), (moment, force)) = (split(v), split(f));
    stack(w.cross(&moment) + u.cross(&force), w.cross(&force))
}

#[cfg(test)]
mod tests {
    use std::time::Instant;

    use super::*;
    use lacuna_base::robot::samples;

    fn dynamics(robot: &Robot) -> Result<ForwardDynamics> {
        ForwardDynamics::new(robot, &robot.inertial_parameters()?)
    }

    fn accelerate(robot: &Robot, q: &[f64], dq: &[f64], tau: &[f64]) -> Result<Vec<f64>> {
        let mut ddq = vec![0.0; robot.dof()];
        dynamics(robot)?.acceleration(q, dq, tau, &mut ddq);
        Ok(ddq)
    }

    #[test]
    fn pendulum_obeys_its_equation() -> Result<()> {
        let (m, l, i, g) = (1.3, 0.4, 0.02, 9.81);
        let robot = samples::pendulum(m, l, i);
        for (q, dq, tau) in [(0.0, 0.0, 0.7), (0.8, 2.0, -0.3), (-2.5, -1.0, 4.0)] {
            let want = (tau - m * g * l * f64::sin(q)) / (i + m * l * l);
            let got = accelerate(&robot, &[q], &[dq], &[tau])?[0];
            assert!((got - want).abs() < 1e-12, "{got} for {want}");
        }
        Ok(())
    }

    #[test]
    fn two_link_arm_obeys_its_equations_in_either_frame() -> Result<()> {
        // Planar arm in a vertical plane: angles from the horizontal, centres of mass on the links.
        let samples::TwoLink { m1, m2, l1, c1, c2, i1, i2 } = samples::TWO_LINK;
        let g = 9.81;
        let (q, dq, tau) = ([0.4, -1.1], [1.5, -2.2], [3.0, -0.8]);
        let (s2, k2) = (f64::sin(q[1]), f64::cos(q[1]));
        let m11 = i1 + m1 * c1 * c1 + i2 + m2 * (l1 * l1 + c2 * c2 + 2.0 * l1 * c2 * k2);
        let m12 = i2 + m2 * (c2 * c2 + l1 * c2 * k2);
        let m22 = i2 + m2 * c2 * c2;
        let h = m2 * l1 * c2 * s2;
        let g2 = m2 * g * c2 * f64::cos(q[0] + q[1]);
        let g1 = (m1 * c1 + m2 * l1) * g * f64::cos(q[0]) + g2;
        let r1 = tau[0] + h * (2.0 * dq[0] * dq[1] + dq[1] * dq[1]) - g1;
        let r2 = tau[1] - h * dq[0] * dq[0] - g2;
        let det = m11 * m22 - m12 * m12;
        let want = [(m22 * r1 - m12 * r2) / det, (m11 * r2 - m12 * r1) / det];
        // Link frames at the near end (URDF, modified DH) and at the far end (standard DH).
        for robot in [samples::two_link(), samples::two_link_far_frames()] {
            let got = accelerate(&robot, &q, &dq, &tau)?;
            assert!((got[0] - want[0]).abs() < 1e-10 && (got[1] - want[1]).abs() < 1e-10, "{got:?} {want:?}");
        }
        Ok(())
    }

    #[test]
    fn cart_and_pole_obey_their_equations() -> Result<()> {
        let samples::CartPole { cart, pole, length, inertia } = samples::CART_POLE;
        let (q, dq, tau, g) = ([0.3, 0.7], [0.5, -1.9], [2.0, 0.4], 9.81);
        // Angle from hanging; x to the right: (M + m) x'' + m l (cos q2 q2'' - sin q2 q2'^2) = f, ...
        let (s, c) = (f64::sin(q[1]), f64::cos(q[1]));
        let (m11, m12, m22) = (cart + pole, pole * length * c, inertia + pole * length * length);
        let r1 = tau[0] + pole * length * s * dq[1] * dq[1];
        let r2 = tau[1] - pole * g * length * s;
        let det = m11 * m22 - m12 * m12;
        let want = [(m22 * r1 - m12 * r2) / det, (m11 * r2 - m12 * r1) / det];
        let got = accelerate(&samples::cart_pole(), &q, &dq, &tau)?;
        assert!((got[0] - want[0]).abs() < 1e-11 && (got[1] - want[1]).abs() < 1e-11, "{got:?} {want:?}");
        Ok(())
    }

    #[test]
    fn branches_push_each_other_only_through_their_trunk() -> Result<()> {
        let robot = samples::branched();
        let q = [0.3, -0.8, 1.2];
        // Joint 0 and joint 2 are the arms; joint 1, the trunk, carries them.
        let moved = |tau: [f64; 3]| accelerate(&robot, &q, &[0.0; 3], &tau);
        let (free, left, right) = (moved([0.0; 3])?, moved([1.0, 0.0, 0.0])?, moved([0.0, 0.0, 1.0])?);
        assert!(((left[2] - free[2]) - (right[0] - free[0])).abs() < 1e-12, "M^-1 is symmetric");
        assert!((left[2] - free[2]).abs() > 1e-3, "the trunk must carry the push over");
        // With a trunk too heavy to move they are two pendulums on their own.
        let mut heavy = dynamics(&robot)?;
        heavy.set_armature(&[0.0, 1e12, 0.0]);
        let mut right_arm = |tau: [f64; 3]| {
            let mut ddq = [0.0; 3];
            heavy.acceleration(&q, &[0.0; 3], &tau, &mut ddq);
            ddq[2]
        };
        assert!((right_arm([1.0, 0.0, 0.0]) - right_arm([0.0; 3])).abs() < 1e-9);
        Ok(())
    }

    #[test]
    fn armature_adds_to_the_inertia_of_a_joint() -> Result<()> {
        let robot = samples::pendulum(1.0, 0.5, 0.0);
        let mut heavy = dynamics(&robot)?;
        heavy.set_armature(&[0.75]);
        let mut ddq = [0.0];
        heavy.acceleration(&[0.0], &[0.0], &[2.0], &mut ddq);
        assert!((ddq[0] - 2.0).abs() < 1e-12, "{ddq:?}");
        Ok(())
    }

    #[test]
    fn parameters_of_another_robot_are_refused() {
        assert!(ForwardDynamics::new(&samples::two_link(), &[1.0; 10]).is_err());
        assert!(ForwardDynamics::new(&samples::two_link(), &[f64::NAN; 20]).is_err());
    }

    #[test]
    #[ignore = "a measurement: run with --release --ignored --nocapture"]
    fn time_of_one_evaluation() -> Result<()> {
        let mut seven = dynamics(&samples::seven_joint())?;
        let (q, dq, tau) = ([0.3; 7], [0.5; 7], [1.0; 7]);
        let mut ddq = [0.0; 7];
        let (rounds, start) = (200_000, Instant::now());
        (0..rounds).for_each(|_| seven.acceleration(std::hint::black_box(&q), &dq, &tau, &mut ddq));
        println!(
            "{:.3} us per evaluation of 7 joints",
            start.elapsed().as_secs_f64() * 1e6 / f64::from(rounds)
        );
        assert!(ddq.iter().all(|a| a.is_finite()));
        Ok(())
    }
}
