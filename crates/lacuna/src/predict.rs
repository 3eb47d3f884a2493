//! Torque that a model predicts, and how far it is from what was measured.

use crate::error::Result;
use crate::identify::{ErrorSums, Errors, over_rows, with_model_torque};
use crate::model::Model;
use crate::signals::Run;

/// Torque of every run as rows of a fit: `[run][joint][row]` [N m, N].
pub type Prediction = Vec<Vec<Vec<f64>>>;

/// Predicts the torque of `runs` with one parameter value per column of the model. Effects that are built
/// from the model's own torque get that of these very values.
///
/// # Errors
/// When a run lacks something an effect needs.
pub fn predict(model: &Model, runs: &[Run], x: &[f64]) -> Result<Prediction> {
    let n = model.robot.dof();
    let seen = with_model_torque(model, x, runs)?;
    let parts = over_rows(model, &seen, Vec::new, |parts, view| {
        let mut torque = vec![vec![0.0; view.rows.len()]; n];
        for (joint, tau) in torque.iter_mut().enumerate() {
            for (local, &column) in model.active[joint].iter().enumerate() {
                let factor = x[column];
                for (t, y) in tau.iter_mut().zip(view.column(joint, local)) {
                    *t += factor * y;
                }
            }
        }
        parts.push((view.run, torque));
        Ok(())
    })?;
    let mut all: Prediction = vec![vec![Vec::new(); n]; runs.len()];
    for (run, torque) in parts.into_iter().flatten() {
        for (joint, part) in torque.into_iter().enumerate() {
            all[run][joint].extend(part);
        }
    }
    Ok(all)
}

/// Errors of a prediction against the measured torque, in the rows' own band.
pub fn prediction_errors(runs: &[Run], prediction: &Prediction) -> Errors {
    let joints = prediction.first().map_or(0, Vec::len);
    let mut sums = vec![ErrorSums::default(); joints];
    for (run, predicted) in runs.iter().zip(prediction) {
        for (joint, sum) in sums.iter_mut().enumerate() {
            for (measured, model) in run.to_rows(&run.tau[joint]).iter().zip(&predicted[joint]) {
                sum.add(measured - model, *measured);
            }
        }
    }
    Errors::from_sums(&sums)
}
