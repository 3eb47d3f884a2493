//! Errors on logs that are never fitted.

use std::borrow::Cow;

use super::answer::Validation;
use super::base::Base;
use super::data::Data;
use super::entry::Request;
use super::ladder::Ladder;
use super::signals::Chosen;

use crate::effects::Effect;
use crate::error::Result;
use crate::identify::{Errors, Evidence, Fit, Weighting, fit, settle, with_model_torque, with_robust_sd};
use crate::log::Log;
use crate::model::Model;
use crate::predict::{Prediction, predict, prediction_errors};
use crate::report::finite;
use crate::report::pictures::{Role, Trace};
use crate::signals::{Run, prepare};

/// Fits effects to the data as any other study would.
pub(super) fn fitted(data: &Data, effects: Vec<Box<dyn Effect>>) -> Result<(Model, Fit)> {
    let model = Model::new(&data.robot, effects)?;
    // Of long logs there is no room for a copy that nothing changes.
    let mut runs = Cow::Borrowed(data.runs.as_slice());
    let evidence = match model.needs_torque() {
        true => settle(&model, runs.to_mut(), &data.folds, Weighting::Joint)?.evidence,
        false => Evidence::collect(&model, &runs, &data.folds)?,
    };
    let found = fit(&model, &evidence, None, Weighting::Joint)?;
    let found = with_robust_sd(&model, &runs, &evidence, found)?;
    Ok((model, found))
}

/// The data that everything is fitted to, with how they were prepared and the model to start from.
pub(super) struct Basis<'a> {
    pub ladder: &'a Ladder,
    pub chosen: &'a Chosen,
    pub base: &'a Base,
}

/// Errors on logs that are never fitted, of the start and of `found`, fitted to the same data; with the series.
pub(super) fn validate(
    request: &Request<'_>,
    basis: &Basis<'_>,
    found: Vec<Box<dyn Effect>>,
) -> Result<Option<(Validation, Vec<Trace>)>> {
    if request.validate.is_empty() {
        return Ok(None);
    }
    let data = &basis.ladder.data;
    let runs = unseen_runs(data, &request.validate, basis.chosen)?;
    let (before, torque_before) =
        basis.base.predicted(basis.ladder, &runs, |effects| predicted(data, effects, &runs))?;
    let (after, torque_after) = predicted(data, found, &runs)?;
    let mut traces: Vec<Trace> = runs.iter().map(|run| Trace::of(run, Role::NeverFitted)).collect();
    for torque in [torque_before, torque_after] {
        for (trace, torque) in traces.iter_mut().zip(torque) {
            trace.add_model(torque);
        }
    }
    let names = data.robot.joints.iter().map(|j| j.name.clone());
    let validation = Validation {
        before_relative_error_percent: finite(before.pooled_percent),
        after_relative_error_percent: finite(after.pooled_percent),
        rms: names.zip(before.rms.iter().zip(&after.rms).map(|(b, a)| [*b, *a])).collect(),
    };
    Ok(Some((validation, traces)))
}

/// Error of the starting model on the logs to validate, by joint [N m, N], with the signal step chosen as for a
/// diagnosis; nothing is looked for.
///
/// # Errors
/// When logs or settings cannot be used.
pub fn unseen_error(request: &Request<'_>) -> Result<Vec<f64>> {
    let logs = request.all_logs();
    let mut chosen = request.choose(&logs, &mut |_| {})?;
    let runs = std::mem::take(&mut chosen.runs);
    let Ladder { data, parts, .. } = request.bare(request.data(&chosen, runs)?, &chosen)?;
    let runs = unseen_runs(&data, &request.validate, &chosen)?;
    Ok(predicted(&data, parts.shared_effects(), &runs)?.0.rms)
}

/// Runs of the logs to validate; joints whose torque the data do not have count as measured zero.
pub(super) fn unseen_runs(data: &Data, logs: &[Log], chosen: &Chosen) -> Result<Vec<Run>> {
    let run = |log: &Log| -> Result<Run> {
        let mut run = prepare(log, &chosen.settings)?.0;
        for (tau, _) in run.tau.iter_mut().zip(&data.silent).filter(|(_, silent)| **silent) {
            tau.fill(0.0);
        }
        Ok(run)
    };
    logs.iter().map(run).collect()
}

/// Fits `effects` to the data and predicts runs that have no part in it.
fn predicted(data: &Data, effects: Vec<Box<dyn Effect>>, runs: &[Run]) -> Result<(Errors, Prediction)> {
    let (model, found) = fitted(data, effects)?;
    let x = without_events(&model, found.x);
    let runs = with_model_torque(&model, &x, runs)?;
    let torque = measured(data, predict(&model, &runs, &x)?);
    Ok((prediction_errors(&runs, &torque), torque))
}

/// Parameters for another log: what happened between two times of the fitted ones did not happen there.
pub(super) fn without_events(model: &Model, mut x: Vec<f64>) -> Vec<f64> {
    for (x, column) in x.iter_mut().zip(&model.columns) {
        if model.effects[column.effect].interval().is_some() {
            *x = 0.0;
        }
    }
    x
}

/// A prediction without joints whose torque was not measured.
pub(super) fn measured(data: &Data, mut all: Prediction) -> Prediction {
    for joints in &mut all {
        for (rows, _) in joints.iter_mut().zip(&data.silent).filter(|(_, silent)| **silent) {
            rows.fill(0.0);
        }
    }
    all
}
