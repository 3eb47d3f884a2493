//! What pictures are drawn from: series at the rows that were fitted, and what is made of them. No picture is
//! drawn here, and nothing that draws computes anything of this again.

mod envelope;
mod partial;
mod share;

pub use envelope::{Envelope, envelope};
pub use partial::{Bin, Partial, binned};
pub use share::EffectShare;

use std::collections::BTreeMap;

use crate::diagnose::Step;
use crate::robot::{JointKind, Robot};
use crate::signals::{Rows, Run};

/// Everything a page draws beside the numbers of the answer.
#[derive(Debug, Clone, Default)]
pub struct Pictures {
    /// The joints, in the order of every list of joints below.
    pub joints: Vec<JointUnits>,
    /// The models that are compared with the measurement, in the order of [`Trace::models`].
    pub models: Vec<Compared>,
    /// One per log.
    pub traces: Vec<Trace>,
    /// What each effect of the last model adds.
    pub effects: Vec<EffectShare>,
    /// Every candidate beside the starting model, most useful first.
    pub ranking: Vec<Ranked>,
    /// The error with one effect after the other, in the order in which they were found.
    pub climb: Vec<Step>,
}

/// Name and units of a joint.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct JointUnits {
    /// Joint.
    pub name: String,
    /// Unit of its position, without time (`rad`, `m`).
    pub position: &'static str,
    /// Unit of its torque (`N m`, `N`).
    pub torque: &'static str,
}

/// A model that is compared with the measurement.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Compared {
    /// What to call it.
    pub label: String,
    /// Whether its torque in fitted logs is held out: every fold predicted by a fit of the others.
    pub held_out: bool,
}

/// What a log was used for.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// It was fitted.
    Fitted,
    /// It was fitted, as the state before something changed.
    Reference,
    /// It was only predicted.
    NeverFitted,
}

/// Series of one log, joint by joint, at the rows of the fit: filtered, decimated.
#[derive(Debug, Clone)]
pub struct Trace {
    /// Name of the log.
    pub name: String,
    /// What it was used for.
    pub role: Role,
    /// Where the rows lie in time.
    pub rows: Rows,
    /// Positions [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Velocities [rad/s, m/s].
    pub dq: Vec<Vec<f64>>,
    /// Accelerations [rad/s², m/s²].
    pub ddq: Vec<Vec<f64>>,
    /// Every other column of the log, in its own unit.
    pub channels: BTreeMap<String, Vec<f64>>,
    /// Measured torque in the band [N m, N].
    pub measured: Vec<Vec<f64>>,
    /// Torque of each model [N m, N]: `models[model][joint][row]`.
    pub models: Vec<Vec<Vec<f64>>>,
}

/// A candidate beside the starting model.
#[derive(Debug, Clone, PartialEq)]
pub struct Ranked {
    /// Name of the effect.
    pub effect: String,
    /// Its joint; `None` for the whole robot.
    pub joint: Option<String>,
    /// Symbols of its parameters, which tell candidates of one effect apart.
    pub symbols: Vec<String>,
    /// Part of the held-out weighted squared error that it removes \[%\].
    pub gain_percent: f64,
    /// Its gain in units of the noise floor, per sample: what candidates are ranked by.
    pub usefulness: f64,
    /// Significance in held-out data.
    pub z: f64,
    /// Held-out rms of the joint it helps most, without and with it [N m, N].
    pub rms: [f64; 2],
    /// The joint that `rms` is of.
    pub rms_joint: String,
    /// Whether it passed everything that is asked of a missing effect.
    pub passes: bool,
}

impl JointUnits {
    /// Of every joint of a robot.
    pub fn of(robot: &Robot) -> Vec<Self> {
        let one = |joint: &crate::robot::Joint| {
            let (position, torque) = match joint.kind {
                JointKind::Revolute => ("rad", "N m"),
                JointKind::Prismatic => ("m", "N"),
            };
            Self { name: joint.name.clone(), position, torque }
        };
        robot.joints.iter().map(one).collect()
    }
}

impl Trace {
    /// Motion and measured torque of a prepared log, without any model.
    pub fn of(run: &Run, role: Role) -> Self {
        let pick = |column: &Vec<f64>| match &run.row_filter {
            None => column.clone(),
            Some(rows) => rows.pick(column),
        };
        let all = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> { columns.iter().map(pick).collect() };
        Self {
            name: run.name.clone(),
            role,
            rows: run.rows(),
            q: all(&run.q),
            dq: all(&run.dq),
            ddq: all(&run.ddq),
            channels: run.channels.iter().map(|(name, column)| (name.clone(), pick(column))).collect(),
            measured: run.tau.iter().map(|tau| run.to_rows(tau).into_owned()).collect(),
            models: Vec::new(),
        }
    }

    /// Adds the torque of a model: rows of each joint.
    pub fn add_model(&mut self, torque: Vec<Vec<f64>>) {
        self.models.push(torque);
    }

    /// Measured minus the torque of `model`, joint by joint.
    pub fn residual(&self, model: usize) -> Vec<Vec<f64>> {
        let minus = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
        self.measured.iter().zip(&self.models[model]).map(minus).collect()
    }
}
