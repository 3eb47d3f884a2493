//! Simulated robots with their own code path: forward dynamics, joint physics, a controller, sensors.
//!
//! Measurements made here do not come from the equations that are later fitted to them: motion follows from
//! torques by articulated bodies ([`ForwardDynamics`]), friction is the plant's own ([`PlantEffect`]), and
//! the torque is what a controller applied to follow a [`Motion`].

mod articulated;
mod controller;
mod effect;
mod friction;
mod implicit;
mod integrate;
mod kinematics;
mod per_joint;
mod physics;
mod sensors;
mod simulation;
mod survey;
mod twin;
mod world;

pub use articulated::ForwardDynamics;
pub use controller::{Controller, Gains};
pub use effect::{Moment, Observed, OwnSlope, PlantEffect};
pub use friction::{CoulombFriction, RotorInertia, SigmoidFriction, TorqueOffset, ViscousFriction};
pub use integrate::RungeKutta4;
pub use kinematics::Kinematics;
pub use per_joint::PerJoint;
pub use physics::*;
pub use sensors::{Reader, Sensors};
pub use simulation::{Row, Simulation, Truth};
pub use twin::{Scope, TWINS, Twin};
pub use twin::{boxed, neighbour, phase};
pub use world::{Energy, WorldFrame};

use serde::{Deserialize, Serialize};

use lacuna_base::error::{Error, Result};
use lacuna_base::excitation::Motion;
use lacuna_base::robot::Robot;

/// Most rows times joints that simulations hold at a time; each is a dozen numbers, so 2 GB.
const MOST_CELLS: f64 = 2e7;

/// How the motion is integrated.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Method {
    /// The classical Runge-Kutta method of order four: accurate to many digits, with steps as small as the
    /// steepest friction asks for.
    #[default]
    RungeKutta,
    /// A Rosenbrock method of order two that takes friction, presliding and feedback implicitly: steps of an
    /// eighth of a millisecond whatever the friction, and positions right to some microradians.
    Implicit,
}

/// A robot as it "really" is, with everything an experiment needs.
#[derive(Debug)]
pub struct Plant {
    /// Its kinematics and gravity.
    pub robot: Robot,
    /// Its true inertial parameters, ten per link, link by link.
    pub parameters: Vec<f64>,
    /// What acts in its joints beside rigid bodies.
    pub effects: Vec<Box<dyn PlantEffect>>,
    /// What makes it move.
    pub controller: Controller,
    /// What is measured.
    pub sensors: Sensors,
    /// How the motion is integrated.
    pub method: Method,
    /// Integration steps between two samples; by default as many as method and plant ask for.
    pub sub_steps: Option<usize>,
}

impl Plant {
    /// `robot` with its own inertias, without friction, with the default controller and perfect sensors.
    ///
    /// # Errors
    /// When a link has no inertia.
    pub fn new(robot: Robot) -> Result<Self> {
        let parameters = robot.inertial_parameters()?;
        Ok(Self::with_parameters(robot, parameters))
    }

    /// `robot` with other inertial parameters (ten per link); otherwise like [`Plant::new`].
    pub fn with_parameters(robot: Robot, parameters: Vec<f64>) -> Self {
        let (controller, sensors) = (Controller::default(), Sensors::default());
        Self {
            robot,
            parameters,
            effects: vec![],
            controller,
            sensors,
            method: Method::default(),
            sub_steps: None,
        }
    }

    /// The same plant with one more effect.
    #[must_use]
    pub fn with_effect(mut self, effect: impl PlantEffect + 'static) -> Self {
        self.effects.push(Box::new(effect));
        self
    }

    /// The same plant with other sensors.
    #[must_use]
    pub fn with_sensors(mut self, sensors: Sensors) -> Self {
        self.sensors = sensors;
        self
    }

    /// Lets the controller follow the first `duration` seconds of `motion`, starting on it, and records.
    ///
    /// The same plant, motion and seed give the same bits; the seed decides on noise alone.
    ///
    /// # Errors
    /// When settings do not fit the robot, the plant is too stiff for its sampling time, or the simulation
    /// diverges (the message says when).
    pub fn simulate(&self, motion: &dyn Motion, duration: f64, seed: u64) -> Result<Simulation> {
        self.simulate_with(&[], motion, duration, seed)
    }

    /// As [`Plant::simulate`], with further effects in this run only.
    ///
    /// # Errors
    /// As [`Plant::simulate`].
    pub fn simulate_with(
        &self,
        more: &[Box<dyn PlantEffect>],
        motion: &dyn Motion,
        duration: f64,
        seed: u64,
    ) -> Result<Simulation> {
        let more: Vec<&dyn PlantEffect> = more.iter().map(AsRef::as_ref).collect();
        self.simulate_among(&more, motion, duration, seed)
    }

    /// As [`Plant::simulate_with`], with effects that lie elsewhere.
    ///
    /// # Errors
    /// As [`Plant::simulate`].
    pub fn simulate_among(
        &self,
        more: &[&dyn PlantEffect],
        motion: &dyn Motion,
        duration: f64,
        seed: u64,
    ) -> Result<Simulation> {
        let own = self.effects.iter().map(AsRef::as_ref);
        let effects: Vec<&dyn PlantEffect> = own.chain(more.iter().copied()).collect();
        self.check(&effects, motion, duration)?;
        simulation::run(self, &effects, motion, duration, seed)
    }

    fn check(&self, effects: &[&dyn PlantEffect], motion: &dyn Motion, duration: f64) -> Result<()> {
        let n = self.robot.dof();
        if motion.dof() != n {
            return Err(Error::new(format!("the `motion` is of {} joints, the robot has {n}", motion.dof()))
                .help("give a motion with one entry per movable joint"));
        }
        if !(duration.is_finite() && duration > 0.0) {
            return Err(Error::new(format!("a simulation of {duration} s")).help("give a positive duration"));
        }
        if self.sub_steps == Some(0) {
            return Err(Error::new("no integration steps between two samples")
                .help("give at least one in `sub_steps`, or leave it out"));
        }
        self.check_settings(effects)?;
        self.check_extent([duration])
    }

    /// Refuses simulations of these durations \[s\] that memory could not hold together.
    ///
    /// # Errors
    /// As said.
    pub fn check_extent(&self, durations: impl IntoIterator<Item = f64>) -> Result<()> {
        let rows: f64 = durations.into_iter().map(|duration| self.sensors.rows(duration)).sum();
        let joints = self.robot.dof();
        if rows * joints as f64 <= MOST_CELLS {
            return Ok(());
        }
        let what = format!("`duration_s` and `sampling_time_s` ask for {rows:.3e} rows of {joints} joints");
        Err(Error::new(what).help(format!(
            "at most {MOST_CELLS:.0e} rows times joints are simulated: shorten the motion, or sample less often"
        )))
    }

    /// Refuses settings of controller, sensors and `effects` that do not fit the robot.
    ///
    /// # Errors
    /// As said.
    pub fn check_settings(&self, effects: &[&dyn PlantEffect]) -> Result<()> {
        let n = self.robot.dof();
        effects.iter().try_for_each(|effect| effect.check(n))?;
        self.controller.check(n)?;
        self.sensors.check(n)
    }
}
