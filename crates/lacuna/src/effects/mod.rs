//! Effects: what makes joint torque. A model is a list of them, and each is a plug-in.
//!
//! An effect says which linear parameters it has and fills one column per parameter: the torque that a
//! unit of the parameter makes at every sample. It takes part in fitting, prediction and reports like any
//! other. One file each; [`CATALOGUE`] names those that ship.

mod about;
mod asymmetric_friction;
mod backlash;
mod base_tilt;
mod catalogue;
mod contact_force;
mod coulomb_friction;
mod coupled_friction;
mod derivative;
mod formula;
mod formula_script;
mod friction_drift;
mod joint_elasticity;
mod joint_spring;
mod joint_zero_error;
mod joints;
mod load_dependent_friction;
mod nonlinear_viscous_friction;
mod parts;
mod payload;
mod position_dependent_friction;
mod presliding_hysteresis;
mod rigid_body;
mod rotor_inertia;
mod script;
mod script_columns;
mod sigmoid_friction;
mod stribeck_friction;
mod thermal_friction;
mod time_delay;
mod torque_drift;
mod torque_gain;
mod torque_offset;
mod torque_ripple;
mod viscous_friction;

pub use about::{
    About, Asks, AtRest, Bound, BuiltFrom, Exports, Imitation, OfJoint, Parameter, Reach, Separation,
    Special, Stage, Variable,
};
pub use asymmetric_friction::AsymmetricFriction;
pub use backlash::Backlash;
pub use base_tilt::BaseTilt;
pub use catalogue::{CATALOGUE, Entry};
pub use contact_force::ContactForce;
pub use coulomb_friction::CoulombFriction;
pub use coupled_friction::CoupledFriction;
pub use formula::{Curve, Formula, Own};
pub use friction_drift::{Course, FrictionDrift};
pub use joint_elasticity::JointElasticity;
pub use joint_spring::JointSpring;
pub use joint_zero_error::JointZeroError;
pub use joints::Joints;
pub use load_dependent_friction::LoadDependentFriction;
pub use nonlinear_viscous_friction::NonlinearViscousFriction;
pub use parts::FrictionPart;
pub use payload::Payload;
pub use position_dependent_friction::PositionDependentFriction;
pub use presliding_hysteresis::PreslidingHysteresis;
pub use rigid_body::RigidBody;
pub use rotor_inertia::RotorInertia;
pub use script::ScriptedEffect;
pub(crate) use sigmoid_friction::logistic;
pub use sigmoid_friction::{SigmoidFriction, SigmoidParameters};
pub use stribeck_friction::StribeckFriction;
pub use thermal_friction::{ThermalFriction, Warmth};
pub use time_delay::TimeDelay;
pub use torque_drift::TorqueDrift;
pub use torque_gain::TorqueGain;
pub use torque_offset::TorqueOffset;
pub use torque_ripple::TorqueRipple;
pub use viscous_friction::ViscousFriction;

use catalogue::per_joint;
use std::fmt::Debug;
use std::ops::Range;
use std::path::Path;

use nalgebra::DMatrix;

use crate::error::{Error, Result};
use crate::kernels::{Chain, RegressorBlock, Samples};
use crate::robot::Robot;
use crate::signals::{ModelTorque, Run};

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

    /// Velocities of joint `j` over the range for columns with a sign or a step at rest: less filtered than
    /// [`Stretch::dq`], because a low-pass blurs every reversal [rad/s, m/s].
    pub fn friction_dq(&self, j: usize) -> &[f64] {
        &self.run.friction_dq(j)[self.range.clone()]
    }

    /// What the model at hand makes of the run, for effects that are [`BuiltFrom`] it.
    ///
    /// # Errors
    /// When nobody has computed it yet.
    pub fn model_torque(&self) -> Result<&ModelTorque> {
        self.run.model.as_deref().ok_or_else(|| {
            Error::new("this effect depends on the torque of the model, which is not known here")
                .help("fit rigid_body together with it")
        })
    }

    /// Positions of joint `j` over the range [rad, m].
    pub fn q(&self, j: usize) -> &[f64] {
        &self.run.q[j][self.range.clone()]
    }

    /// Accelerations of joint `j` over the range [rad/s², m/s²].
    pub fn ddq(&self, j: usize) -> &[f64] {
        &self.run.ddq[j][self.range.clone()]
    }

    /// Time since the run began, over the range \[s\].
    pub fn elapsed(&self) -> impl Iterator<Item = f64> + '_ {
        self.range.clone().map(|k| k as f64 * self.run.dt)
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

    /// Reads the files it names, which are relative to `folder`, that of the scenario. Called once, before
    /// anything else is asked for.
    ///
    /// # Errors
    /// When a file is missing, damaged, or outside the scenario's repository.
    fn load(&mut self, _folder: &Path) -> Result<()> {
        Ok(())
    }

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

    /// The joint it belongs to where that is not the only one whose torque it changes: a gear that twists on one
    /// joint moves all links behind it.
    ///
    /// # Errors
    /// When the joint does not exist.
    fn belongs_to(&self, _robot: &Robot) -> Result<Option<usize>> {
        Ok(None)
    }

    /// Numbers that the columns depend on nonlinearly, with the values they have now.
    fn shapes(&self) -> Vec<Shape> {
        Vec::new()
    }

    /// The same effect with other shape values, in the order of [`Effect::shapes`].
    fn with_shapes(&self, _values: &[f64]) -> Box<dyn Effect> {
        self.boxed()
    }

    /// The joint whose velocity its smoothed sign is of, where that is not the joint it acts on.
    ///
    /// # Errors
    /// When the joint does not exist.
    fn sign_of(&self, _robot: &Robot) -> Result<Option<usize>> {
        Ok(None)
    }

    /// The same effect with this width of the smoothed sign [rad/s, m/s]; no change where it has no sign.
    fn with_width(&self, _width: f64) -> Box<dyn Effect> {
        self.boxed()
    }

    /// Why these values of the linear parameters cannot be physics, or `None` where they can: the bounds of
    /// [`About::parameters`], unless there is more to say.
    fn implausible(&self, robot: &Robot, values: &[f64]) -> Option<String> {
        let terms = self.terms(robot).ok()?;
        self.about().impossible(&terms, &self.shapes(), values).map(str::to_string)
    }

    /// What makes these values suspect although they are possible: they fit something, but probably not this. The
    /// bounds of [`About::parameters`] that are only odd, unless there is more to say.
    fn odd(&self, robot: &Robot, values: &[f64]) -> Option<String> {
        let terms = self.terms(robot).ok()?;
        self.about().suspect(&terms, &self.shapes(), values).map(str::to_string)
    }

    /// Why these runs cannot show the effect, whatever the fit says, or `None` where they can.
    fn undecidable(&self, _robot: &Robot, _runs: &[Run]) -> Option<String> {
        None
    }

    /// The times between which it acts \[s\], on the log's clock; `None` where it always does.
    fn interval(&self) -> Option<(f64, f64)> {
        None
    }

    /// The formula that it is, where it is one.
    fn formula(&self) -> Option<&Formula> {
        None
    }

    /// What a diagnosis tries of it on a robot: itself, or what it is on each joint alone.
    ///
    /// # Errors
    /// When it does not fit the robot.
    fn one_by_one(&self, _robot: &Robot) -> Result<Vec<Box<dyn Effect>>> {
        Ok(vec![self.boxed()])
    }

    /// What people are told: linear parameters and shapes with standard errors, from fitted values and
    /// their covariance. Effects whose physics hides in products (a payload's centre of mass) override it.
    ///
    /// # Errors
    /// When the effect does not fit the robot.
    fn describe(&self, robot: &Robot, values: &[f64], covariance: &DMatrix<f64>) -> Result<Vec<Described>> {
        let linear = self.terms(robot)?.into_iter().enumerate().map(|(i, term)| Described {
            name: term.symbol,
            value: values[i],
            unit: term.unit,
            standard_error: Some(covariance[(i, i)].sqrt()).filter(|e| e.is_finite()),
        });
        let shapes = self.shapes().into_iter().map(|shape| Described {
            name: shape.symbol.to_string(),
            value: shape.value,
            unit: shape.unit,
            standard_error: None,
        });
        Ok(linear.chain(shapes).collect())
    }
}

/// A number that an effect's columns depend on nonlinearly.
#[derive(Debug, Clone, PartialEq)]
pub struct Shape {
    /// Symbol, as in [`About::equation`].
    pub symbol: &'static str,
    /// Unit.
    pub unit: &'static str,
    /// The value now.
    pub value: f64,
    /// Least value that makes sense.
    pub low: f64,
    /// Largest value that makes sense.
    pub high: f64,
    /// Values a search starts from.
    pub trials: Vec<f64>,
}

/// One number of an effect as people are told it.
#[derive(Debug, Clone, PartialEq)]
pub struct Described {
    /// Name (`fc3`, `mass`).
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: &'static str,
    /// Standard error that allows for autocorrelation, where known.
    pub standard_error: Option<f64>,
}

impl dyn Effect + '_ {
    /// Whether columns are built from the model's own torque ([`Stretch::model_torque`]); such effects are
    /// fitted in turns with it until both agree.
    pub fn needs_torque(&self) -> bool {
        self.about().special.built_from != BuiltFrom::Motion
    }

    /// Whether it acts on what sensors say instead of on the joint (a gain, a delay). Such effects are not
    /// part of [`ModelTorque::total`], because they are built from it.
    pub fn alters_measurement(&self) -> bool {
        self.about().special.built_from == BuiltFrom::Measurement
    }

    /// Whether it is the rigid links, whose parameters are reduced to those that show.
    pub fn is_rigid_body(&self) -> bool {
        self.about().stage == Stage::InEveryModel
    }
}

impl Clone for Box<dyn Effect> {
    fn clone(&self) -> Self {
        self.boxed()
    }
}

/// Index of the link called `name` or numbered so, or of the last one of the arm.
fn find_link(robot: &Robot, name: Option<&str>) -> Result<usize> {
    let Some(name) = name else { return Ok(robot.order.last().copied().unwrap_or(0)) };
    let named = robot.links.iter().position(|link| link.name == name);
    named.or_else(|| robot.joint_index(name)).ok_or_else(|| {
        let known: Vec<&str> = robot.links.iter().map(|link| link.name.as_str()).collect();
        Error::new(format!("no link `{name}`")).help(format!(
            "`{}` has {}, or numbers 1 to {}",
            robot.name,
            known.join(", "),
            robot.dof()
        ))
    })
}

/// Rigid body, viscous and Coulomb friction and torque offset on every joint: eq. 24 of Gaz et al. 2019.
pub fn classic() -> Vec<Box<dyn Effect>> {
    vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(CoulombFriction::default()),
        Box::new(TorqueOffset::default()),
    ]
}
