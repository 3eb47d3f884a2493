//! Errors on logs that are never fitted.

use super::answer::Validation;
use super::entry::{Look, Request, fitted, measured};
use super::late::Late;
use crate::effects::Effect;
use crate::error::Result;
use crate::identify::{Errors, with_model_torque};
use crate::predict::{Prediction, predict, prediction_errors};
use crate::report::finite;
use crate::report::pictures::{Role, Trace};
use crate::signals::{Run, prepare};

/// Errors on logs that are never fitted, of the start and of everything that was found; with the series.
pub(super) fn validate(
    first: &Look,
    look: &Look,
    request: &Request<'_>,
    delayed: bool,
) -> Result<Option<(Validation, Vec<Trace>)>> {
    if request.validate.is_empty() {
        return Ok(None);
    }
    let ladder = &first.ladder;
    let mut runs: Vec<Run> = Vec::new();
    for log in &request.validate {
        let mut run = prepare(log, &first.chosen.settings)?.0;
        for (tau, _) in run.tau.iter_mut().zip(&ladder.data.silent).filter(|(_, silent)| **silent) {
            tau.fill(0.0);
        }
        runs.push(run);
    }
    let mut traces: Vec<Trace> = runs.iter().map(|run| Trace::of(run, Role::NeverFitted)).collect();
    let predicted = |effects: Vec<Box<dyn Effect>>| -> Result<(Errors, Prediction)> {
        let (model, found) = fitted(&ladder.data, effects)?;
        let runs = with_model_torque(&model, &found.x, &runs)?;
        let torque = measured(ladder, predict(&model, &runs, &found.x)?);
        Ok((prediction_errors(&runs, &torque), torque))
    };
    let (before, torque_before) = first.base.errors(ladder, &runs, predicted)?;
    let found = look.ladder.parts.shared_effects();
    let (after, torque_after) = predicted(if delayed { Late::among(found) } else { found })?;
    for torque in [torque_before, torque_after] {
        for (trace, torque) in traces.iter_mut().zip(torque) {
            trace.add_model(torque);
        }
    }
    let names = ladder.data.robot.joints.iter().map(|j| j.name.clone());
    let validation = Validation {
        before_relative_error_percent: finite(before.pooled_percent),
        after_relative_error_percent: finite(after.pooled_percent),
        rms: names.zip(before.rms.iter().zip(&after.rms).map(|(b, a)| [*b, *a])).collect(),
    };
    Ok(Some((validation, traces)))
}
