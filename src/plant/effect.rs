//! What acts in the plant's joints beside rigid bodies.

use std::fmt::Debug;

use crate::error::Result;

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
}

/// Physics in the joints of a plant: a load that the drives have to overcome.
///
/// One effect is one struct in one file; its RON name is that of the same effect in identification:
/// `{"viscous_friction": (coefficients: [1.0])}`. Effects with memory keep it in states that are integrated
/// together with the motion. Inertia that needs the acceleration goes into [`PlantEffect::add_armature`]; an
/// effect cannot depend on the acceleration otherwise, nor act on what sensors see.
#[typetag::serde]
pub trait PlantEffect: Debug + Send + Sync {
    /// Refuses settings that do not fit a robot of `dof` joints.
    ///
    /// # Errors
    /// When a setting has the wrong length or a value without meaning.
    fn check(&self, dof: usize) -> Result<()>;

    /// Adds the torques [N m, N] that this effect takes from the drives.
    fn add_load(&self, now: &Moment, load: &mut [f64]);

    /// Adds the steepest slope of each joint's load over its velocity [N m s/rad, N s/m]; it decides how
    /// small the steps of the simulation must be.
    fn add_steepest_slope(&self, _slope: &mut [f64]) {}

    /// Adds inertia that joints feel without moving a link [kg m², kg].
    fn add_armature(&self, _armature: &mut [f64]) {}

    /// Number of own states for a robot of `dof` joints; they start at zero.
    fn states(&self, _dof: usize) -> usize {
        0
    }

    /// Writes the time derivatives of the own states.
    fn rates(&self, _now: &Moment, _rates: &mut [f64]) {}
}
