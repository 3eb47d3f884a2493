//! Errors on logs that are never fitted.

use super::answer::Validation;
use super::data::Data;
use super::entry::Request;
use super::ladder::Ladder;
use super::parts::Parts;
use super::signals::Chosen;
use super::telling::Base;
use crate::effects::Effect;
use crate::error::Result;
use crate::identify::{Errors, Fit, Weighting, fit, settle, with_model_torque, with_robust_sd};
use crate::log::Log;
use crate::model::Model;
use crate::predict::{predict, prediction_errors};
use crate::report::finite;
use crate::signals::{Run, prepare};

/// Fits effects to the data as any other study would.
pub(super) fn fitted(data: &Data, effects: Vec<Box<dyn Effect>>) -> Result<(Model, Fit)> {
    let model = Model::new(&data.robot, effects)?;
    let mut runs = data.runs.clone();
    let settled = settle(&model, &mut runs, &data.folds, Weighting::Joint)?;
    let found = fit(&model, &settled.evidence, None, Weighting::Joint)?;
    let found = with_robust_sd(&model, &runs, &settled.evidence, found)?;
    Ok((model, found))
}

/// Errors on logs that are never fitted, of the start and of everything that was found.
pub(super) fn validate(
    ladder: &Ladder,
    base: &Base,
    chosen: &Chosen,
    request: &Request<'_>,
) -> Result<Option<Validation>> {
    if request.validate.is_empty() {
        return Ok(None);
    }
    let before = errors(&ladder.data, base.effects.clone(), &request.validate, chosen)?;
    let after = errors(&ladder.data, ladder.parts.shared_effects(), &request.validate, chosen)?;
    let names = ladder.data.robot.joints.iter().map(|j| j.name.clone());
    Ok(Some(Validation {
        before_relative_error_percent: finite(before.pooled_percent),
        after_relative_error_percent: finite(after.pooled_percent),
        rms: names.zip(before.rms.iter().zip(&after.rms).map(|(b, a)| [*b, *a])).collect(),
    }))
}

/// Error of the starting model on the logs to validate, by joint [N m, N], with the signal step chosen as for a
/// diagnosis; nothing is looked for.
///
/// # Errors
/// When logs or settings cannot be used.
pub fn unseen_error(request: &Request<'_>) -> Result<Vec<f64>> {
    let logs = request.all_logs();
    let chosen = request.choose(&logs, &mut |_| {})?;
    let data = request.data(&chosen, chosen.runs.clone())?;
    // The parts know the widths of signs that were chosen.
    let parts = Parts::new(&data, request.effects(&chosen), chosen.widths.clone())?;
    Ok(errors(&data, parts.shared_effects(), &request.validate, &chosen)?.rms)
}

/// Fits `effects` to the data and predicts logs that have no part in it.
fn errors(data: &Data, effects: Vec<Box<dyn Effect>>, logs: &[Log], chosen: &Chosen) -> Result<Errors> {
    let (model, found) = fitted(data, effects)?;
    let runs: Vec<Run> =
        logs.iter().map(|log| Ok(prepare(log, &chosen.settings)?.0)).collect::<Result<_>>()?;
    let runs = with_model_torque(&model, &found.x, &runs)?;
    Ok(prediction_errors(&runs, &predict(&model, &runs, &found.x)?))
}
