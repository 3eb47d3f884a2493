//! One model fitted at once and grown effect by effect: what a face shows between two searches.

use std::collections::BTreeMap;

use super::candidates::{self, Candidate};
use super::data::Data;
use super::entry::{Request, bare};
use super::ladder::Ladder;
use super::pictures::{self, RANKED};
use super::present::rms;
use super::signals::{Chosen, WIDTHS, one_prepared};
use super::unseen::{fitted, unseen_runs};
use super::{asked, poor};

use crate::effects::Effect;
use crate::error::{Error, Result};
use crate::identify::with_model_torque;
use crate::model_file::ModelFile;
use crate::predict::{predict, prediction_errors};
use crate::report::finite;
use crate::report::pictures::{Pictures, Ranked, Role, Trace};
use crate::signals::{Run, Settings};
use crate::stop::Stop;

/// Candidates whose columns are held at the same time for a ranking.
const AT_ONCE: usize = 32;

/// Prepared logs with the model that is fitted to them. Nothing is searched and no signal step is chosen, so
/// that it answers at once; a [`diagnose`](super::diagnose) of the same model on the same settings starts from the
/// same numbers.
pub struct Fitting {
    chosen: Chosen,
    ladder: Ladder,
    /// Logs that are never fitted.
    unseen: Vec<Run>,
    extra: Vec<Box<dyn Effect>>,
}

/// What a model makes of the logs.
#[derive(Debug, Clone)]
pub struct Fitted {
    /// The effects, with the shapes that were found.
    pub effects: Vec<Box<dyn Effect>>,
    /// The model as a file, fitted to all data.
    pub model: ModelFile,
    /// Error of all joints together, held out, as in [`Diagnosis`](super::Diagnosis) \[%\].
    pub held_out_percent: Option<f64>,
    /// Joint by joint.
    pub joints: Vec<JointFit>,
    /// Error on logs that are never fitted \[%\], and its rms joint by joint [N m, N].
    pub unseen: Option<(Option<f64>, BTreeMap<String, f64>)>,
    /// How data were held out.
    pub folds: String,
    /// Series of the logs with the torque of this one model, held out, and what its effects add.
    pub pictures: Pictures,
}

/// How well a joint is explained.
#[derive(Debug, Clone, PartialEq)]
pub struct JointFit {
    /// Joint.
    pub name: String,
    /// Root mean square of the torque in the band [N m, N].
    pub torque_rms: f64,
    /// Root mean square of the held-out residual [N m, N].
    pub held_out_rms: f64,
    /// What repetitions of the same motion differ by [N m, N].
    pub repeat_floor_rms: Option<f64>,
}

impl Fitting {
    /// Prepares the logs with the request's settings as they are and fits its starting model; logs of an earlier state
    /// and effects to add take no part. `widths` are those of the smoothed sign of each joint [rad/s], as an earlier
    /// diagnosis chose them.
    ///
    /// # Errors
    /// When logs or settings cannot be used, or the model does not fit the robot.
    pub fn start(mut request: Request<'_>, widths: Option<&[f64]>) -> Result<Self> {
        let mut logs = std::mem::take(&mut request.logs);
        poor::silence(&mut logs);
        // One log after the other is let go: of long ones there is no room for two copies.
        let prepared = logs.into_iter().map(|log| one_prepared(&log, &request.settings));
        let (runs, reports): (Vec<Run>, Vec<_>) = prepared.collect::<Result<Vec<_>>>()?.into_iter().unzip();
        let folds = (request.folds)(&runs)?;
        let usual = || vec![WIDTHS[0]; request.robot.dof()];
        let widths = widths.map_or_else(usual, <[f64]>::to_vec);
        let (settings, extra) = (request.settings.clone(), std::mem::take(&mut request.extra));
        let chosen = Chosen { settings, runs: Vec::new(), reports, folds, widths };
        request.reference.clear();
        let data = request.data(&chosen, runs)?;
        let ladder = request.bare(data, &chosen)?;
        let unseen = unseen_runs(&ladder.data, &request.validate, &chosen)?;
        let mut fitting = Self { chosen, ladder, unseen, extra };
        fitting.work_for(&request.limits.stop);
        Ok(fitting)
    }

    /// What it does from now on belongs to the work that `stop` ends.
    pub fn work_for(&mut self, stop: &Stop) {
        self.ladder.limits.stop.clone_from(stop);
        let runs = self.ladder.data.runs.iter_mut().chain(&mut self.unseen);
        runs.for_each(|run| run.stop.clone_from(stop));
    }

    /// The settings of the signal step.
    pub fn settings(&self) -> &Settings {
        &self.chosen.settings
    }

    /// The same data with other effects in the place of the model.
    ///
    /// # Errors
    /// When they do not fit the robot or the logs.
    pub fn with(self, effects: Vec<Box<dyn Effect>>) -> Result<Self> {
        let ladder = bare(self.ladder.data, effects, &self.chosen, &self.ladder.limits)?;
        Ok(Self { ladder, ..self })
    }

    /// What may be added from now on, beside the catalogue.
    pub fn consider(&mut self, extra: Vec<Box<dyn Effect>>) {
        self.extra = extra;
    }

    /// The model's effects and one more: on each of `joints`, or wherever it fits when none is named, with the
    /// shapes that explain most. The fit itself stays as it is.
    ///
    /// # Errors
    /// When there is no such effect or joint, the data cannot show it, it is part of the model already, or the
    /// numbers that fit cannot be physics.
    pub fn with_added(&mut self, effect: &str, joints: &[String]) -> Result<Vec<Box<dyn Effect>>> {
        let ladder = &self.ladder;
        let kept = (ladder.parts.clone(), ladder.present.clone(), ladder.response.clone());
        let added = self.added(effect, joints);
        (self.ladder.parts, self.ladder.present, self.ladder.response) = kept;
        self.ladder.candidates.clear();
        self.ladder.refused.clear();
        added
    }

    fn added(&mut self, effect: &str, joints: &[String]) -> Result<Vec<Box<dyn Effect>>> {
        let before = self.ladder.parts.numbers().len();
        let wanted: Vec<(String, Option<String>)> = match joints {
            [] => vec![(effect.to_string(), None)],
            some => some.iter().map(|j| (effect.to_string(), Some(j.clone()))).collect(),
        };
        self.ladder.candidates = candidates::catalogue(&self.ladder.data, &self.chosen.widths, &self.extra)?;
        let own = |c: &&Candidate| c.name() == effect;
        if self.ladder.candidates.iter().filter(own).any(|c| c.effect.needs_torque()) {
            self.ladder.refresh_torque()?;
        }
        // Columns of this effect alone: the others only tell what names are known.
        for candidate in self.ladder.candidates.iter_mut().filter(|c| c.name() == effect) {
            candidates::fill(std::slice::from_mut(candidate), &self.ladder.data, false)?;
        }
        asked::add(&mut self.ladder, &wanted)?;
        if self.ladder.parts.numbers().len() == before {
            return Err(self.refusal(effect));
        }
        Ok(self.ladder.parts.effects())
    }

    /// What every candidate of the catalogue would bring beside the model, most useful first.
    ///
    /// # Errors
    /// When a column cannot be computed.
    pub fn ranking(&mut self) -> Result<Vec<Ranked>> {
        let ladder = &mut self.ladder;
        ladder.refresh_torque()?;
        let mut open = candidates::catalogue(&ladder.data, &self.chosen.widths, &self.extra)?;
        let mut all = Vec::new();
        // A few at a time: the columns of a whole catalogue take more room than the logs.
        while !open.is_empty() {
            ladder.candidates = open.drain(..open.len().min(AT_ONCE)).collect();
            candidates::fill(&mut ladder.candidates, &ladder.data, false)?;
            ladder.rank();
            all.append(&mut ladder.ranking);
        }
        ladder.candidates.clear();
        all.sort_by(|a, b| b.usefulness.total_cmp(&a.usefulness));
        all.truncate(RANKED);
        Ok(all)
    }

    fn refusal(&self, effect: &str) -> Error {
        let ladder = &self.ladder;
        let there = ladder.candidates.iter().any(|c| c.name() == effect && ladder.parts.has(c));
        match (ladder.refused.first().map(|r| &r.reason), there) {
            (Some(reason), _) => Error::new(format!("`{effect}` was not added: {reason}")),
            (None, true) => Error::new(format!("`{effect}` is part of the model already")),
            (None, false) => {
                Error::new(format!("`{effect}` was not added: these data cannot tell it from the model"))
            }
        }
        .help(format!("lacuna list effects {effect} explains it"))
    }

    /// What the model makes of the logs.
    ///
    /// # Errors
    /// When a fit fails.
    pub fn fitted(&self) -> Result<Fitted> {
        let data = &self.ladder.data;
        let effects = self.ladder.parts.effects();
        let (model, found) = fitted(data, effects.clone())?;
        let mut pictures = pictures::of_one(&self.ladder);
        let unseen = match self.unseen.as_slice() {
            [] => None,
            runs => {
                let x = super::unseen::without_events(&model, found.x.clone());
                let seen = with_model_torque(&model, &x, runs)?;
                let torque = super::unseen::measured(data, predict(&model, &seen, &x)?);
                let errors = prediction_errors(&seen, &torque);
                for (run, torque) in runs.iter().zip(torque) {
                    let mut trace = Trace::of(run, Role::NeverFitted);
                    trace.add_model(torque);
                    pictures.traces.push(trace);
                }
                let names = data.robot.joints.iter().map(|j| j.name.clone());
                let rms = names.zip(errors.rms.iter().copied()).collect();
                Some((finite(errors.pooled_percent), rms))
            }
        };
        let names: Vec<&str> = data.runs.iter().map(|run| run.name.as_str()).collect();
        let origin = format!("fitted to {}", names.join(", "));
        let settings = self.chosen.settings.clone();
        Ok(Fitted {
            model: ModelFile::new(&model, &found.x, &found.robust_sd, settings, origin),
            effects,
            held_out_percent: self.pooled(),
            joints: self.joints(),
            unseen,
            folds: data.folds.description.clone(),
            pictures,
        })
    }

    fn joints(&self) -> Vec<JointFit> {
        let (data, left) = (&self.ladder.data, self.ladder.rms());
        let one = |(j, joint): (usize, &crate::robot::Joint)| JointFit {
            name: joint.name.clone(),
            torque_rms: rms(&data.tau[j]),
            held_out_rms: left[j],
            repeat_floor_rms: self.ladder.floor.repeat.as_ref().map(|floor| floor[j]),
        };
        data.robot.joints.iter().enumerate().map(one).collect()
    }

    fn pooled(&self) -> Option<f64> {
        let data: &Data = &self.ladder.data;
        let square = |rms: f64| rms * rms;
        let error: f64 = self.ladder.rms().into_iter().map(square).sum();
        let torque: f64 = data.tau.iter().map(|t| square(rms(t))).sum();
        finite(100.0 * (error / torque).sqrt())
    }
}
