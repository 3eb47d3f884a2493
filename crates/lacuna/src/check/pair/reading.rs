//! Ways to read a log: which column is which joint, with which sign, under which gravity.

use std::f64::consts::PI;

use nalgebra::Vector3;

use crate::robot::{JointKind, Robot};
use crate::signals::Run;

/// A recorded column and the sign to give it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Signed {
    /// Which recorded joint.
    pub column: usize,
    /// 1 or -1.
    pub sign: f64,
}

impl Signed {
    /// Every joint is its own column.
    pub fn identity(joints: usize) -> Vec<Self> {
        (0..joints).map(|column| Self { column, sign: 1.0 }).collect()
    }

    /// The columns that `map` picks, with its signs.
    pub fn pick(map: &[Self], columns: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let one = |from: &Self| match from.sign < 0.0 {
            true => columns[from.column].iter().map(|x| -x).collect(),
            false => columns[from.column].clone(),
        };
        map.iter().map(one).collect()
    }
}

/// What one may be mistaken about.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Change {
    /// Positions (and velocities) are in degrees.
    Degrees,
    /// Torques of these joints have the other sign.
    FlipTorques(Vec<usize>),
    /// Position and velocity of a joint have the other sign.
    FlipPosition(usize),
    /// Position, velocity and torque of a joint have the other sign: its axis is turned.
    FlipJoint(usize),
    /// Two joints, positions and torques, stand in each other's place.
    SwapJoints(usize, usize),
    /// The positions of two joints stand in each other's place.
    SwapPositions(usize, usize),
    /// The torques of two joints stand in each other's place.
    SwapTorques(usize, usize),
    /// All joints stand in reversed order.
    ReverseJoints,
    /// All positions stand in reversed order.
    ReversePositions,
    /// All torques stand in reversed order.
    ReverseTorques,
    /// The robot is mounted so that gravity points here [m/s², base frame].
    Gravity(Vector3<f64>),
    /// The torque has no gravity in it.
    NoGravity,
    /// The Denavit-Hartenberg table is meant in the other convention.
    Convention,
}

/// One way to read a log against a robot.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Reading {
    /// Column of each joint's position, velocity and acceleration.
    pub position: Vec<Signed>,
    /// Column of each joint's torque.
    pub torque: Vec<Signed>,
    /// Whether angles are in degrees.
    pub degrees: bool,
    /// Gravity in the base frame [m/s²]; zero where the torque has none in it.
    pub gravity: Vector3<f64>,
    /// Whether the robot's table is read in the other convention.
    pub other_convention: bool,
}

impl Reading {
    /// As the files say.
    pub fn as_is(robot: &Robot) -> Self {
        let own = Signed::identity(robot.dof());
        Self {
            position: own.clone(),
            torque: own,
            degrees: false,
            gravity: robot.gravity,
            other_convention: false,
        }
    }

    /// The reading after one more change.
    pub fn with(&self, change: &Change) -> Self {
        let mut next = self.clone();
        let flip = |of: &mut Signed| of.sign = -of.sign;
        match change {
            Change::Degrees => next.degrees = !next.degrees,
            Change::FlipTorques(joints) => joints.iter().for_each(|&j| flip(&mut next.torque[j])),
            Change::FlipPosition(j) => flip(&mut next.position[*j]),
            Change::FlipJoint(j) => {
                flip(&mut next.position[*j]);
                flip(&mut next.torque[*j]);
            }
            Change::SwapJoints(a, b) => {
                next.position.swap(*a, *b);
                next.torque.swap(*a, *b);
            }
            Change::SwapPositions(a, b) => next.position.swap(*a, *b),
            Change::SwapTorques(a, b) => next.torque.swap(*a, *b),
            Change::ReverseJoints => {
                next.position.reverse();
                next.torque.reverse();
            }
            Change::ReversePositions => next.position.reverse(),
            Change::ReverseTorques => next.torque.reverse(),
            Change::Gravity(gravity) => next.gravity = *gravity,
            Change::NoGravity => next.gravity = Vector3::zeros(),
            Change::Convention => next.other_convention = !next.other_convention,
        }
        next
    }

    /// The motion as this reading has it.
    pub fn apply(&self, run: &Run, robot: &Robot) -> Run {
        let motion = |columns: &[Vec<f64>]| {
            let mut columns = Signed::pick(&self.position, columns);
            if self.degrees {
                let turning = robot.joints.iter().map(|j| j.kind == JointKind::Revolute);
                for (column, _) in columns.iter_mut().zip(turning).filter(|(_, turns)| *turns) {
                    column.iter_mut().for_each(|x| *x *= PI / 180.0);
                }
            }
            columns
        };
        Run {
            q: motion(&run.q),
            dq: motion(&run.dq),
            ddq: motion(&run.ddq),
            tau: Signed::pick(&self.torque, &run.tau),
            name: run.name.clone(),
            dt: run.dt,
            start: run.start,
            ..Run::default()
        }
    }
}
