//! What acts in the plant's joints beside rigid bodies.

use std::fmt::Debug;

use nalgebra::Vector3;

use super::Kinematics;
use lacuna_base::error::Result;
use lacuna_base::robot::InertialParameters;

/// The plant at one instant. Slices have one entry per joint.
#[derive(Debug, Clone, Copy)]
pub struct Moment<'a> {
    /// Time \[s\].
    pub t: f64,
    /// Positions [rad, m].
    pub q: &'a [f64],
    /// Velocities [rad/s, m/s].
    pub dq: &'a [f64],
    /// Torques that the controller applies [N m, N].
    pub tau: &'a [f64],
    /// The effect's own states, [`PlantEffect::states`] of them.
    pub own: &'a [f64],
    /// Where the links are.
    pub arm: &'a Kinematics,
}

/// How an own state hangs together with its joint, for steps that are longer than its memory.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct OwnSlope {
    /// Index of the joint it belongs to.
    pub joint: usize,
    /// Slope of its rate over itself \[1/s\].
    pub rate_per_own: f64,
    /// Slope of its rate over the joint's velocity.
    pub rate_per_velocity: f64,
    /// Slope of the joint's load over it.
    pub load_per_own: f64,
}

/// What sensors are about to see of a motion, before noise: joint by joint on the sensors' clock. The
/// robot's motion is over when this is made; changes here are errors of measurement.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Observed {
    /// Sampling time \[s\].
    pub dt: f64,
    /// Positions [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Velocities [rad/s, m/s].
    pub dq: Vec<Vec<f64>>,
    /// Torques of the drives [N m, N].
    pub tau: Vec<Vec<f64>>,
    /// What passes through the joints: torques of the drives less the loads of all effects [N m, N].
    pub transmitted: Vec<Vec<f64>>,
}

/// Physics in the joints of a plant: a load that the drives have to overcome.
///
/// One effect is one struct in one file; its RON name is that of the same effect in identification:
/// `{"viscous_friction": (coefficients: [1.0])}`. Effects with memory keep it in states that are integrated
/// together with the motion. Inertia that needs the acceleration goes into [`PlantEffect::add_armature`], bodies
/// and gravity that the controller does not know into [`PlantEffect::change_robot`], errors of measurement into
/// [`PlantEffect::observe`].
#[typetag::serde]
pub trait PlantEffect: Debug + Send + Sync {
    /// Refuses settings that do not fit a robot of `dof` joints.
    ///
    /// # Errors
    /// When a setting has the wrong length or a value without meaning.
    fn check(&self, dof: usize) -> Result<()>;

    /// Adds the torques [N m, N] that this effect takes from the drives. `load` holds what the effects before
    /// it take.
    fn add_load(&self, now: &Moment, load: &mut [f64]);

    /// Adds the steepest slope of each joint's load over its velocity [N m s/rad, N s/m]; it decides how
    /// small the steps of the simulation must be.
    fn add_steepest_slope(&self, _slope: &mut [f64]) {}

    /// Adds the steepest slope of each joint's load over its position [N m/rad, N/m], where it is steep.
    fn add_stiffness(&self, _stiffness: &mut [f64]) {}

    /// How fast own states forget \[1/s\].
    fn fastest_own_rate(&self) -> f64 {
        0.0
    }

    /// Whether it must be evaluated after all effects that answer `false`, because it depends on them.
    fn comes_last(&self) -> bool {
        false
    }

    /// Adds inertia that joints feel without moving a link [kg m², kg].
    fn add_armature(&self, _armature: &mut [f64]) {}

    /// Changes gravity [m/s², base frame] and links against what the controller and the robot file know.
    fn change_robot(&self, _gravity: &mut Vector3<f64>, _links: &mut [InertialParameters]) {}

    /// Start and end \[s\], for what happens in an interval only.
    fn interval(&self) -> Option<(f64, f64)> {
        None
    }

    /// Number of own states for a robot of `dof` joints; they start at zero.
    fn states(&self, _dof: usize) -> usize {
        0
    }

    /// Writes the time derivatives of the own states.
    fn rates(&self, _now: &Moment, _rates: &mut [f64]) {}

    /// Writes how own states hang together with joints; states left alone are integrated explicitly.
    fn own_slopes(&self, _now: &Moment, _slopes: &mut [OwnSlope]) {}

    /// Notes what else a log has of it, as channels with name and value.
    fn measure(&self, _now: &Moment, _note: &mut dyn FnMut(&str, f64)) {}

    /// Changes what sensors see of the finished motion.
    fn observe(&self, _seen: &mut Observed) {}
}
