//! What the pictures of a study are drawn from.

use crate::error::Result;
use crate::identify::with_model_torque;
use crate::model::Model;
use crate::model_file::ModelFile;
use crate::predict::predict;
use crate::report::pictures::{Compared, EffectShare, JointUnits, Pictures, Role, Trace};
use crate::signals::Run;

use super::Study;
use super::moving::{FromLogs, Gathered};

impl Study<'_> {
    /// Series of the logs with the torque of the identified model, and of the retrieved one where there is
    /// one; `None` without logs.
    pub(super) fn pictures(
        &self,
        logs: &Gathered,
        retrieved: Option<&ModelFile>,
    ) -> Result<Option<Pictures>> {
        let identified = logs.fitted.as_ref().map(|f| (f.fitted.clone(), f.x.clone()));
        let retrieved = retrieved.map(|file| file.on(&self.robot)).transpose()?;
        let models: Vec<(&str, (Model, Vec<f64>))> = [("identified", identified), ("retrieved", retrieved)]
            .into_iter()
            .filter_map(|(label, model)| Some((label, model?)))
            .collect();
        let fitted = logs.fitted.as_ref().map_or(&[][..], |f| &f.runs);
        if models.is_empty() || (fitted.is_empty() && logs.held.is_empty()) {
            return Ok(None);
        }
        let mut traces = Vec::new();
        for (runs, role) in [(fitted, Role::Fitted), (&logs.held, Role::NeverFitted)] {
            traces.extend(compared(runs, role, &models)?);
        }
        let compared = |label: &str| Compared { label: label.to_string(), held_out: false };
        Ok(Some(Pictures {
            joints: JointUnits::of(&self.robot),
            models: models.iter().map(|(label, _)| compared(label)).collect(),
            effects: logs.fitted.as_ref().map_or_else(|| Ok(Vec::new()), |f| effects(f, &traces))?,
            traces,
            ..Pictures::default()
        }))
    }
}

fn compared(runs: &[Run], role: Role, models: &[(&str, (Model, Vec<f64>))]) -> Result<Vec<Trace>> {
    let mut traces: Vec<Trace> = runs.iter().map(|run| Trace::of(run, role)).collect();
    for (_, (model, x)) in models {
        for (trace, torque) in traces.iter_mut().zip(predict(model, runs, x)?) {
            trace.add_model(torque);
        }
    }
    Ok(traces)
}

/// What every effect of the identified model but the rigid body adds on every joint.
fn effects(from: &FromLogs, traces: &[Trace]) -> Result<Vec<EffectShare>> {
    let units = JointUnits::of(&from.fitted.robot);
    // Effects that are built from the model's torque get that of the whole model, not of themselves alone.
    let runs = with_model_torque(&from.fitted, &from.x, &from.runs)?;
    let residual = joined(traces.iter().filter(|t| t.role == Role::Fitted).map(|t| t.residual(0)));
    let mut all = Vec::new();
    for (number, effect) in from.fitted.effects.iter().enumerate() {
        if effect.is_rigid_body() || effect.needs_torque() {
            continue;
        }
        let own = |c: usize| if from.fitted.columns[c].effect == number { from.x[c] } else { 0.0 };
        let alone: Vec<f64> = (0..from.x.len()).map(own).collect();
        let torque = joined(predict(&from.fitted, &runs, &alone)?.into_iter());
        for (joint, (torque, residual)) in torque.iter().zip(&residual).enumerate() {
            if torque.iter().any(|t| t.abs() > 0.0) {
                all.push(EffectShare::new(
                    &effect.about(),
                    false,
                    joint,
                    None,
                    traces,
                    &units,
                    residual,
                    torque,
                ));
            }
        }
    }
    Ok(all)
}

/// Rows of every joint, all logs one after the other.
fn joined(logs: impl Iterator<Item = Vec<Vec<f64>>>) -> Vec<Vec<f64>> {
    let mut all: Vec<Vec<f64>> = Vec::new();
    for log in logs {
        all.resize(log.len(), Vec::new());
        for (all, rows) in all.iter_mut().zip(log) {
            all.extend(rows);
        }
    }
    all
}
