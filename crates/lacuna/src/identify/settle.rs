//! Effects that are built from the torque of the model they belong to: fitted in turns with it.

use std::borrow::Cow;
use std::sync::Arc;

use crate::effects::{Effect, RigidBody};
use crate::error::{Error, Result};
use crate::kernels::{Samples, inverse_dynamics_batch};
use crate::model::Model;
use crate::signals::{Folds, ModelTorque, Run};

use super::evidence::Evidence;
use super::fit::{Weighting, fit};

/// Rounds of fitting and rebuilding columns at most.
const ROUNDS: usize = 12;
/// The rounds end when the model's torque changes by less than this part of itself.
const SETTLED: f64 = 1e-7;

/// Evidence whose columns agree with the model that it gives.
#[derive(Debug, Clone)]
pub struct Settled {
    /// What least squares needs to know.
    pub evidence: Evidence,
    /// Last relative change of the model's torque; 0 where no effect is built from it.
    pub change: f64,
}

impl Settled {
    /// Whether another round would still have changed the model noticeably (a part in a thousand).
    pub fn wanders(&self) -> bool {
        !(self.change < 1e-3)
    }
}

/// Collects the evidence for `model`. Where effects are built from the model's own torque, fits and
/// rebuilds their columns until both agree; the runs then carry that torque. Starts from the torque that
/// the runs carry, or from none.
///
/// # Errors
/// When a run lacks something that an effect needs, or a fit on the way fails.
pub fn settle(model: &Model, runs: &mut [Run], folds: &Folds, weighting: Weighting) -> Result<Settled> {
    if !model.needs_torque() {
        return Ok(Settled { evidence: Evidence::collect(model, runs, folds)?, change: 0.0 });
    }
    if runs.iter().any(|run| run.model.is_none()) {
        refresh_model_torque(model, &vec![0.0; model.columns.len()], runs)?;
    }
    let rounds = if weighting == Weighting::Huber { Weighting::Joint } else { weighting };
    let mut change = f64::INFINITY;
    for _ in 0..ROUNDS {
        let evidence = Evidence::collect(model, runs, folds)?;
        if change < SETTLED {
            return Ok(Settled { evidence, change });
        }
        let x = fit(model, &evidence, None, rounds)?.x;
        let before: Vec<_> = runs.iter().map(|run| run.model.clone()).collect();
        refresh_model_torque(model, &x, runs)?;
        change = relative_change(&before, runs);
    }
    Ok(Settled { evidence: Evidence::collect(model, runs, folds)?, change })
}

/// Puts into every run what `model` with the values `x` makes of it ([`Run::model`]): link parameters with
/// the base coefficients on their pivots, torque of the rigid links, and torque of all effects together.
/// Effects that act on the measurement instead of the joint ([`crate::effects::BuiltFrom::Measurement`]) are left out
/// of the latter, since that is what they are built from.
///
/// # Errors
/// When the model has no rigid body, or a run lacks something that an effect needs.
pub fn refresh_model_torque(model: &Model, x: &[f64], runs: &mut [Run]) -> Result<()> {
    let links = link_parameters(model, x)?;
    for run in runs {
        let samples = Samples { q: &run.q, dq: &run.dq, ddq: &run.ddq };
        let rigid = inverse_dynamics_batch(&model.chain, samples, &links);
        let mut total = rigid.clone();
        model.add_torque(x, run, &mut total, |effect| !effect.is_rigid_body() && !effect.needs_torque())?;
        let first = ModelTorque { links: links.clone(), rigid, total: total.clone() };
        run.model = Some(Arc::new(first.clone()));
        let built = |effect: &dyn Effect| effect.needs_torque() && !effect.alters_measurement();
        if model.effects.iter().any(|effect| built(effect.as_ref())) {
            model.add_torque(x, run, &mut total, built)?;
            run.model = Some(Arc::new(ModelTorque { total, ..first }));
        }
    }
    Ok(())
}

/// The runs as `model` with the values `x` sees them: copies with its torque where an effect is built from
/// it, else the runs themselves.
///
/// # Errors
/// As [`refresh_model_torque`].
pub fn with_model_torque<'a>(model: &Model, x: &[f64], runs: &'a [Run]) -> Result<Cow<'a, [Run]>> {
    if !model.needs_torque() {
        return Ok(Cow::Borrowed(runs));
    }
    let mut own = runs.to_vec();
    refresh_model_torque(model, x, &mut own)?;
    Ok(Cow::Owned(own))
}

fn link_parameters(model: &Model, x: &[f64]) -> Result<Vec<f64>> {
    let Some(base) = &model.base else {
        let needy = model.effects.iter().find(|e| e.needs_torque()).map_or("an effect", |e| e.about().name);
        return Err(Error::new(format!("`{needy}` is built from the torque of rigid links"))
            .help(format!("add {} to the effects", RigidBody::ABOUT.example)));
    };
    let first = model.columns.iter().position(|c| model.effects[c.effect].is_rigid_body()).unwrap_or(0);
    Ok(base.lift(&x[first..first + base.rank()]))
}

/// Largest change of a joint's torque over all runs, relative to its size.
fn relative_change(before: &[Option<Arc<ModelTorque>>], runs: &[Run]) -> f64 {
    let joints = runs.first().map_or(0, |run| run.q.len());
    let mut worst = 0.0_f64;
    for joint in 0..joints {
        let (mut moved, mut size) = (0.0, 0.0);
        for (old, run) in before.iter().zip(runs) {
            let (Some(old), Some(new)) = (old, &run.model) else { return f64::INFINITY };
            for (a, b) in [(&old.rigid, &new.rigid), (&old.total, &new.total)] {
                for (a, b) in a[joint].iter().zip(&b[joint]) {
                    moved += (a - b) * (a - b);
                    size += b * b;
                }
            }
        }
        if moved > 0.0 {
            worst = worst.max((moved / size).sqrt());
        }
    }
    worst
}
