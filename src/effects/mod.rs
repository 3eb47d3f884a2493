//! Effects: what makes joint torque. A model is a list of them, and each is a plug-in.
//!
//! An effect says which linear parameters it has and fills one column per parameter: the torque that a
//! unit of the parameter makes at every sample. It takes part in fitting, prediction and reports like any
//! other. One file each; [`CATALOGUE`] names those that ship.

mod coulomb_friction;
mod joints;
mod rigid_body;
mod sigmoid_friction;
mod torque_offset;
mod viscous_friction;

pub use coulomb_friction::CoulombFriction;
pub use joints::Joints;
pub use rigid_body::RigidBody;
pub(crate) use sigmoid_friction::logistic;
pub use sigmoid_friction::{SigmoidFriction, SigmoidParameters};
pub use torque_offset::TorqueOffset;
pub use viscous_friction::ViscousFriction;

use std::fmt::Debug;
use std::ops::Range;

use crate::error::Result;
use crate::kernels::{Chain, RegressorBlock, Samples};
use crate::robot::Robot;
use crate::signals::Run;

/// What an effect says about itself; printed by `lacuna list effects NAME`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About {
    /// Name in RON, JSON and on the command line.
    pub name: &'static str,
    /// One line for the catalogue.
    pub title: &'static str,
    /// What it is and how it shows in data.
    pub text: &'static str,
    /// Torque on joint j as a formula.
    pub equation: &'static str,
    /// Parameters: symbol, unit, meaning.
    pub parameters: &'static [(&'static str, &'static str, &'static str)],
    /// Effects it is easily mistaken for, and why.
    pub confused_with: &'static str,
}

/// One linear parameter of an effect.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Term {
    /// Short symbol, unique within the model (`fc3`).
    pub symbol: String,
    /// Unit.
    pub unit: &'static str,
    /// Joints whose torque it can change; all other rows of its column are zero.
    pub joints: Vec<usize>,
}

/// Where columns are asked for: a range of samples of one run.
#[derive(Debug, Clone)]
pub struct Stretch<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Its kernels' constants.
    pub chain: &'a Chain,
    /// The whole run, for effects that look back.
    pub run: &'a Run,
    /// The samples to fill.
    pub range: Range<usize>,
}

impl Stretch<'_> {
    /// Velocities of joint `j` over the range [rad/s, m/s].
    pub fn dq(&self, j: usize) -> &[f64] {
        &self.run.dq[j][self.range.clone()]
    }

    /// The whole motion, for kernels.
    pub fn samples(&self) -> Samples<'_> {
        Samples { q: &self.run.q, dq: &self.run.dq, ddq: &self.run.ddq }
    }
}

/// Calls back with the slice of a column (term, joint) when the model uses it.
pub(crate) type Wanted<'a> = dyn FnMut(usize, usize, &mut dyn FnMut(&mut [f64])) + 'a;

/// Receives the columns of one effect over one stretch.
pub struct Columns<'a> {
    pub(crate) wanted: &'a mut Wanted<'a>,
    pub(crate) scratch: &'a mut Option<RegressorBlock>,
}

impl Columns<'_> {
    /// Offers the column of parameter `term` in the rows of `joint`: `fill` is called with a zeroed slice,
    /// one entry per sample of the stretch, when the model uses that column.
    pub fn column(&mut self, term: usize, joint: usize, mut fill: impl FnMut(&mut [f64])) {
        (self.wanted)(term, joint, &mut fill);
    }
}

/// A cause of joint torque, linear in its parameters. What it cannot express: torque that depends on its
/// own parameters nonlinearly; shape parameters are fields of the effect and are fitted around it.
#[typetag::serde]
pub trait Effect: Debug + Send + Sync {
    /// Name, text and equation.
    fn about(&self) -> About;

    /// Linear parameters on this robot, in a fixed order.
    ///
    /// # Errors
    /// When the effect names a joint that the robot has not.
    fn terms(&self, robot: &Robot) -> Result<Vec<Term>>;

    /// Fills the columns, in the order of [`Effect::terms`].
    ///
    /// # Errors
    /// When the run lacks something the effect needs.
    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()>;

    /// A copy behind a new box.
    fn boxed(&self) -> Box<dyn Effect>;
}

impl Clone for Box<dyn Effect> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// The effects that ship, simplest first.
pub const CATALOGUE: &[fn() -> About] = &[
    || RigidBody::ABOUT,
    || ViscousFriction::ABOUT,
    || CoulombFriction::ABOUT,
    || TorqueOffset::ABOUT,
    || SigmoidFriction::ABOUT,
];

/// Rigid body, viscous and Coulomb friction and torque offset on every joint: eq. 24 of Gaz et al. 2019.
pub fn classic() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(CoulombFriction::default()),
        Box::new(TorqueOffset::default()),
    ]
}
