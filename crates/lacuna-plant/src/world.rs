//! Energy and gravity torque from positions and velocities of centres of mass in the base frame.
//!
//! A second way to the physics of [`super::ForwardDynamics`], with nothing in common but where the joints are.

use nalgebra::Vector3;

use super::kinematics::{Kinematics, bodies};
use lacuna_base::error::Result;
use lacuna_base::robot::{InertialParameters, JointKind, Pose, Robot};

/// Mechanical energy of a robot \[J\].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Energy {
    /// Of motion.
    pub kinetic: f64,
    /// In the field of gravity, zero when all mass sits at the base origin.
    pub potential: f64,
}

impl Energy {
    /// Both together.
    pub fn total(&self) -> f64 {
        self.kinetic + self.potential
    }
}

/// One link in the base frame.
#[derive(Debug, Clone, Copy)]
struct Body {
    parameters: InertialParameters,
    pose: Pose,
    /// Joint axis, and a point on it.
    axis: Vector3<f64>,
    pivot: Vector3<f64>,
    angular: Vector3<f64>,
    linear: Vector3<f64>,
    /// Mass and first moment of this link and all it carries, about the base origin.
    carried_mass: f64,
    carried_moment: Vector3<f64>,
}

/// A robot seen from its base, with its workspace.
#[derive(Debug, Clone)]
pub struct WorldFrame {
    kinematics: Kinematics,
    bodies: Vec<Body>,
    gravity: Vector3<f64>,
    armature: Vec<f64>,
}

impl WorldFrame {
    /// For `robot` with the stacked inertial parameters `parameters` (ten per link).
    ///
    /// # Errors
    /// When the parameters do not fit the robot or are not finite, or its tree of joints is not one.
    pub fn new(robot: &Robot, parameters: &[f64]) -> Result<Self> {
        let zero = Vector3::zeros();
        let body = |parameters: InertialParameters| Body {
            parameters,
            pose: Pose::identity(),
            axis: zero,
            pivot: zero,
            angular: zero,
            linear: zero,
            carried_mass: 0.0,
            carried_moment: zero,
        };
        let bodies = bodies(robot, parameters)?.into_iter().map(body).collect();
        let armature = vec![0.0; robot.dof()];
        Ok(Self { kinematics: Kinematics::new(robot)?, bodies, gravity: robot.gravity, armature })
    }

    /// Sets inertia that a joint feels without moving a link [kg m², kg]; it counts as `1/2 a dq²`.
    ///
    /// # Panics
    /// When the slice is not one number per joint.
    pub fn set_armature(&mut self, armature: &[f64]) {
        self.armature.copy_from_slice(armature);
    }

    /// Energy at positions `q` [rad, m] and velocities `dq` [rad/s, m/s].
    ///
    /// # Panics
    /// When a slice is shorter than the number of joints.
    pub fn energy(&mut self, q: &[f64], dq: &[f64]) -> Energy {
        self.place(q);
        self.move_along(dq);
        let links: f64 = self.bodies.iter().map(Body::kinetic_energy).sum();
        let rotors: f64 = self.armature.iter().zip(dq).map(|(a, v)| 0.5 * a * v * v).sum();
        let potential = -self.bodies.iter().map(|b| self.gravity.dot(&b.first_moment())).sum::<f64>();
        Energy { kinetic: links + rotors, potential }
    }

    /// Inertia that each joint moves when the others stand still at `q`: the mass matrix's diagonal.
    ///
    /// # Panics
    /// When `q` is shorter than the number of joints.
    pub fn joint_inertia(&mut self, q: &[f64]) -> Vec<f64> {
        let mut dq = vec![0.0; self.bodies.len()];
        (0..dq.len())
            .map(|j| {
                dq[j] = 1.0;
                let inertia = 2.0 * self.energy(q, &dq).kinetic;
                dq[j] = 0.0;
                inertia
            })
            .collect()
    }

    /// Writes the torques [N m, N] that hold the robot still at `q` [rad, m].
    ///
    /// # Panics
    /// When a slice is shorter than the number of joints.
    pub fn gravity_torque(&mut self, q: &[f64], tau: &mut [f64]) {
        self.place(q);
        for body in &mut self.bodies {
            body.carried_mass = body.parameters.mass();
            body.carried_moment = body.first_moment();
        }
        for &i in self.kinematics.order.iter().rev() {
            let body = self.bodies[i];
            let joint = &self.kinematics.joints[i];
            // What a small motion of the joint lifts: mass times the way of its centre.
            let way = match joint.kind {
                JointKind::Revolute => {
                    body.axis.cross(&(body.carried_moment - body.pivot * body.carried_mass))
                }
                JointKind::Prismatic => body.axis * body.carried_mass,
            };
            tau[i] = -self.gravity.dot(&way);
            if let Some(parent) = joint.parent {
                self.bodies[parent].carried_mass += body.carried_mass;
                self.bodies[parent].carried_moment += body.carried_moment;
            }
        }
    }

    fn place(&mut self, q: &[f64]) {
        for &i in &self.kinematics.order {
            let joint = &self.kinematics.joints[i];
            let base = joint.parent.map_or_else(Pose::identity, |p| self.bodies[p].pose);
            let foot = base.then(&joint.before);
            let body = &mut self.bodies[i];
            body.axis = foot.rotation * joint.axis;
            body.pivot = foot.translation;
            body.pose = base.then(&joint.pose(q[i]));
        }
    }

    fn move_along(&mut self, dq: &[f64]) {
        for &i in &self.kinematics.order {
            let joint = &self.kinematics.joints[i];
            let resting = (Vector3::zeros(), Vector3::zeros(), Vector3::zeros());
            let carrier = joint.parent.map(|p| &self.bodies[p]);
            let (turning, moving, at) =
                carrier.map_or(resting, |b| (b.angular, b.linear, b.pose.translation));
            let body = &mut self.bodies[i];
            let own = body.axis * dq[i];
            let here = body.pose.translation;
            let (angular, linear) = match joint.kind {
                JointKind::Revolute => (turning + own, own.cross(&(here - body.pivot))),
                JointKind::Prismatic => (turning, own),
            };
            body.angular = angular;
            body.linear = moving + turning.cross(&(here - at)) + linear;
        }
    }
}

impl Body {
    /// First moment about the base origin [kg m].
    fn first_moment(&self) -> Vector3<f64> {
        self.pose.rotation * self.parameters.first_moment() + self.pose.translation * self.parameters.mass()
    }

    /// Koenig's theorem; for a body too light to have a centre of mass, the same about its frame's origin.
    fn kinetic_energy(&self) -> f64 {
        let p = &self.parameters;
        let spin = self.pose.rotation.transpose() * self.angular;
        if let (Some(center), Some(inertia)) = (p.center_of_mass(), p.inertia_at_center_of_mass()) {
            let velocity = self.linear + self.angular.cross(&(self.pose.rotation * center));
            return 0.5 * (p.mass() * velocity.norm_squared() + spin.dot(&(inertia * spin)));
        }
        let moment = self.pose.rotation * p.first_moment();
        0.5 * (p.mass() * self.linear.norm_squared() + spin.dot(&(p.inertia_at_origin() * spin)))
            + self.linear.dot(&self.angular.cross(&moment))
    }
}

#[cfg(test)]
mod tests {
    use super::super::ForwardDynamics;
    use super::*;
    use lacuna_base::robot::samples;

    fn small_robots() -> Vec<Robot> {
        vec![
            samples::pendulum(1.3, 0.4, 0.02),
            samples::two_link(),
            samples::two_link_far_frames(),
            samples::cart_pole(),
            samples::branched(),
            samples::seven_joint(),
        ]
    }

    fn state(n: usize) -> (Vec<f64>, Vec<f64>) {
        (0..n).map(|j| (0.4 + 0.9 * j as f64, 1.3 - 0.7 * j as f64)).unzip()
    }

    #[test]
    fn pendulum_energy_is_the_textbook_one() -> Result<()> {
        let (m, l, i) = (1.3, 0.4, 0.02);
        let robot = samples::pendulum(m, l, i);
        let energy = WorldFrame::new(&robot, &robot.inertial_parameters()?)?.energy(&[0.8], &[2.0]);
        assert!((energy.kinetic - 0.5 * (i + m * l * l) * 4.0).abs() < 1e-14);
        assert!((energy.potential + m * 9.81 * l * f64::cos(0.8)).abs() < 1e-13);
        Ok(())
    }

    #[test]
    fn gravity_torque_is_the_slope_of_the_potential_and_keeps_the_robot_still() -> Result<()> {
        for robot in small_robots() {
            let parameters = robot.inertial_parameters()?;
            let mut world = WorldFrame::new(&robot, &parameters)?;
            let n = robot.dof();
            let ((q, _), rest) = (state(n), vec![0.0; n]);
            let (mut tau, mut ddq) = (vec![0.0; n], vec![0.0; n]);
            world.gravity_torque(&q, &mut tau);
            ForwardDynamics::new(&robot, &parameters)?.acceleration(&q, &rest, &tau, &mut ddq);
            assert!(ddq.iter().all(|a| a.abs() < 1e-10), "{}: {ddq:?}", robot.name);
            for j in 0..n {
                let mut potential = |h: f64| {
                    let mut q = q.clone();
                    q[j] += h;
                    world.energy(&q, &rest).potential
                };
                let slope = (potential(1e-5) - potential(-1e-5)) / 2e-5;
                assert!((slope - tau[j]).abs() < 1e-7, "{} joint {j}: {slope} {}", robot.name, tau[j]);
            }
        }
        Ok(())
    }

    #[test]
    fn power_of_the_torques_is_the_rate_of_the_energy() -> Result<()> {
        for robot in small_robots() {
            let parameters = robot.inertial_parameters()?;
            let mut world = WorldFrame::new(&robot, &parameters)?;
            let n = robot.dof();
            let (q, dq) = state(n);
            let tau: Vec<f64> = (0..n).map(|j| 2.0 - j as f64).collect();
            let mut ddq = vec![0.0; n];
            ForwardDynamics::new(&robot, &parameters)?.acceleration(&q, &dq, &tau, &mut ddq);
            let mut total = |h: f64| {
                let q: Vec<f64> = (0..n).map(|j| q[j] + h * dq[j] + 0.5 * h * h * ddq[j]).collect();
                let dq: Vec<f64> = (0..n).map(|j| dq[j] + h * ddq[j]).collect();
                world.energy(&q, &dq).total()
            };
            let rate = (total(1e-5) - total(-1e-5)) / 2e-5;
            let power: f64 = tau.iter().zip(&dq).map(|(t, v)| t * v).sum();
            assert!((rate - power).abs() < 1e-6 * power.abs().max(1.0), "{}: {rate} {power}", robot.name);
        }
        Ok(())
    }

    #[test]
    fn velocities_are_the_rates_of_the_poses() -> Result<()> {
        for robot in small_robots() {
            let mut world = WorldFrame::new(&robot, &robot.inertial_parameters()?)?;
            let (q, dq) = state(robot.dof());
            world.energy(&q, &dq);
            let shifted = |h: f64| -> Vec<f64> { q.iter().zip(&dq).map(|(x, v)| x + h * v).collect() };
            let before = world.kinematics.poses(&shifted(-1e-6));
            let after = world.kinematics.poses(&shifted(1e-6));
            for (i, body) in world.bodies.iter().enumerate() {
                let rate = (after[i].translation - before[i].translation) / 2e-6;
                assert!((rate - body.linear).norm() < 1e-7, "{} link {i}", robot.name);
                let turn = (after[i].rotation - before[i].rotation) / 2e-6;
                let spin = body.angular.cross_matrix() * body.pose.rotation;
                assert!((turn - spin).norm() < 1e-7, "{} link {i}", robot.name);
            }
        }
        Ok(())
    }

    #[test]
    fn joint_inertia_is_what_an_armed_robot_feels() -> Result<()> {
        // With all other joints locked by enormous rotors, the mobility of one is its inverse inertia.
        let robot = samples::seven_joint();
        let parameters = robot.inertial_parameters()?;
        let (q, _) = state(7);
        let inertia = WorldFrame::new(&robot, &parameters)?.joint_inertia(&q);
        let mut dynamics = ForwardDynamics::new(&robot, &parameters)?;
        for j in 0..7 {
            let mut locked = [1e9; 7];
            locked[j] = 0.0;
            dynamics.set_armature(&locked);
            let felt = 1.0 / dynamics.mobility(&q)[j];
            assert!((felt / inertia[j] - 1.0).abs() < 1e-5, "joint {j}: {felt} {}", inertia[j]);
        }
        Ok(())
    }
}
