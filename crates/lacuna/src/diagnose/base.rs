//! The starting model: how well it did, and what fitting it again changes where the user gave its numbers.

use super::answer::{Missing, Parameter};
use super::ladder::Ladder;
use super::present::rms;
use super::score::{Score, judge};
use super::unseen::measured;
use crate::effects::{Effect, RigidBody};
use crate::error::Result;
use crate::identify::Errors;
use crate::model::Model;
use crate::predict::{Prediction, predict, prediction_errors};
use crate::report::finite;
use crate::signals::Run;

/// Parameters that moved by more standard errors than this are listed.
pub(super) const MOVED: f64 = 3.0;

/// The starting model and how well it did.
pub(super) struct Base {
    pub effects: Vec<Box<dyn Effect>>,
    pub x: Vec<f64>,
    pub residual: Vec<Vec<f64>>,
    /// Expression and unit of each parameter.
    pub names: Vec<(String, &'static str)>,
    /// What fitting the numbers of the robot file again explains in held-out data, when they were compared as
    /// they are.
    pub refit: Option<Refit>,
    /// Width of the smoothed sign of each joint [rad/s].
    pub widths: Vec<f64>,
}

/// The given numbers, fitted again.
pub(super) struct Refit {
    pub score: Score,
    pub usefulness: f64,
    /// Held-out rms of each joint before and after.
    pub before: Vec<f64>,
    pub after: Vec<f64>,
}

impl Base {
    /// Of the model at hand; with the robot file's own inertias, unfitted, when `given`.
    pub fn of(ladder: &Ladder, given: bool) -> Result<Self> {
        let effects = ladder.parts.effects();
        let x = ladder.present.fit(&ladder.data.tau);
        let (model, x) = ladder.parts.model(&ladder.data.robot, &x)?;
        let names = model.columns.iter().map(|c| (c.expression.clone(), c.about.unit)).collect();
        let mut base = Self {
            effects,
            x,
            residual: ladder.response.residual.clone(),
            names,
            widths: ladder.parts.widths.clone(),
            refit: None,
        };
        if given && let Some(numbers) = &model.base {
            base.x = numbers.coefficients(&ladder.data.robot.inertial_parameters()?);
            base.residual = unfitted(ladder, &base.x);
            base.refit = Some(Refit::new(ladder, &base.residual));
        }
        Ok(base)
    }

    /// Errors and torque of the starting model on runs that were not fitted; `fit` fits effects to the data.
    pub fn predicted(
        &self,
        ladder: &Ladder,
        runs: &[Run],
        fit: impl Fn(Vec<Box<dyn Effect>>) -> Result<(Errors, Prediction)>,
    ) -> Result<(Errors, Prediction)> {
        if self.refit.is_none() {
            return fit(self.effects.clone());
        }
        let model = Model::new(&ladder.data.robot, self.effects.clone())?;
        let torque = measured(&ladder.data, predict(&model, runs, &self.x)?);
        Ok((prediction_errors(runs, &torque), torque))
    }

    /// What is told of the given numbers when fitting them again explains more than chance would.
    pub fn missing(&self, ladder: &Ladder, after: &[f64]) -> Option<(f64, Missing)> {
        let refit = self.refit.as_ref().filter(|r| ladder.passes(None, r.usefulness, &r.score))?;
        let about = RigidBody::ABOUT;
        let name = |j: usize| ladder.data.robot.joints[j].name.clone();
        let covariance = ladder.present.covariance(&ladder.data, after, 0..self.x.len());
        let parameters = (0..self.x.len())
            .map(|i| (i, covariance[(i, i)].sqrt()))
            .filter(|&(i, error)| (after[i] - self.x[i]).abs() > MOVED * error)
            .map(|(i, error)| Parameter {
                name: self.names[i].0.clone(),
                value: after[i],
                unit: self.names[i].1.to_string(),
                standard_error: finite(error),
            });
        let changed = |j: &usize| (refit.before[*j] - refit.after[*j]).abs() > 0.02 * refit.before[*j];
        let joints = (0..ladder.data.dof()).filter(changed);
        let missing = Missing {
            effect: about.name.to_string(),
            joints: Vec::new(),
            equation: about.equation.to_string(),
            parameters: parameters.collect(),
            gain_percent: 100.0 * refit.score.share,
            z: refit.score.z,
            held_out_rms: joints.map(|j| (name(j), [refit.before[j], refit.after[j]])).collect(),
            also_possible: Vec::new(),
            place: "the whole robot: the numbers of the robot file, fitted again".to_string(),
            remainder: None,
            caveat: None,
        };
        Some((refit.usefulness, missing))
    }
}

/// Residual of given parameters, nothing fitted; none where nothing was measured.
fn unfitted(ladder: &Ladder, x: &[f64]) -> Vec<Vec<f64>> {
    let mut full = x.to_vec();
    full.resize(ladder.present.width(), 0.0);
    let mut residual = ladder.present.residual_of(&ladder.data.tau, &full);
    for (rest, _) in residual.iter_mut().zip(&ladder.data.silent).filter(|(_, silent)| **silent) {
        rest.fill(0.0);
    }
    residual
}

impl Refit {
    fn new(ladder: &Ladder, given: &[Vec<f64>]) -> Self {
        let fitted = &ladder.response.residual;
        let change = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
        let effect = given.iter().zip(fitted).map(change).collect();
        let score = judge(&ladder.data, &ladder.present, given, effect);
        let usefulness = ladder.usefulness(None, &score);
        let all = |residual: &[Vec<f64>]| residual.iter().map(|r| rms(r)).collect();
        Self { score, usefulness, before: all(given), after: all(fitted) }
    }
}
