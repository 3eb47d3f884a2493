//! Link parameters side by side: torque error and joint wrenches through Newton-Euler.

use std::collections::BTreeMap;

use crate::effects::SigmoidParameters;
use crate::error::Result;
use crate::identify::{ErrorSums, Errors};
use crate::kernels::{Chain, Samples, State, Workspace, inverse_dynamics, inverse_dynamics_batch, wrench};
use crate::model::Model;
use crate::predict::{Prediction, predict};
use crate::report::{Comparison, FrictionResult, finite};
use crate::signals::Run;

use super::Study;
use super::moving::Gathered;
use super::retrieval::{Candidate, FromEngines, rigid_first};

/// Wrenches are averaged over about this many samples.
const WRENCH_SAMPLES: usize = 500;

impl Study<'_> {
    /// Torque error of all candidates, on the logs that were never fitted where there are such; `None`
    /// without logs.
    ///
    /// Friction is that which was retrieved along, else that of the friction path, else that of the fitted
    /// model.
    pub(super) fn compare(
        &self,
        engines: &FromEngines,
        logs: &Gathered,
        friction: &[FrictionResult],
    ) -> Result<Option<Comparison>> {
        let (runs, fitted) = logs.to_compare();
        if runs.is_empty() || engines.candidates.is_empty() {
            return Ok(None);
        }
        let chain = Chain::new(&self.robot);
        let names: Vec<String> = self.robot.joints.iter().map(|j| j.name.clone()).collect();
        let named = |values: Vec<f64>| names.iter().cloned().zip(values).collect();
        let data: Vec<&str> = runs.iter().map(|r| r.name.as_str()).collect();
        let mut all = Comparison {
            validation_mse: BTreeMap::new(),
            relative_error_percent: BTreeMap::new(),
            data: data.join(", "),
            fitted,
            wrenches: BTreeMap::new(),
        };
        for Candidate { label, links, others } in &engines.candidates {
            let friction = self.friction_torque(runs, logs, friction, others)?;
            let errors = errors(&chain, runs, links, &friction);
            let squares = errors.rms.iter().map(|rms| rms * rms).collect();
            all.validation_mse.insert(label.clone(), named(squares));
            all.relative_error_percent.insert(label.clone(), finite(errors.pooled_percent));
            let sizes = mean_wrenches(&chain, runs, links);
            all.wrenches.insert(label.clone(), names.iter().cloned().zip(sizes).collect());
        }
        Ok(Some(all))
    }

    /// Torque of everything but the rigid links, as rows.
    fn friction_torque(
        &self,
        runs: &[Run],
        logs: &Gathered,
        path: &[FrictionResult],
        others: &[f64],
    ) -> Result<Prediction> {
        match &logs.fitted {
            Some(fitted) if !others.is_empty() => beside_links(&fitted.fitted, runs, others),
            Some(fitted) if path.is_empty() => {
                let (order, rank) = rigid_first(&fitted.fitted);
                let others: Vec<f64> = order[rank..].iter().map(|&c| fitted.x[c]).collect();
                beside_links(&fitted.fitted, runs, &others)
            }
            _ => {
                let joint = |run: &Run, j: usize| {
                    let friction = sigmoid(path, &self.robot.joints[j].name);
                    let torque: Vec<f64> = run.dq[j].iter().map(|&v| friction.torque(v)).collect();
                    run.to_rows(&torque).into_owned()
                };
                Ok(runs.iter().map(|run| (0..self.robot.dof()).map(|j| joint(run, j)).collect()).collect())
            }
        }
    }
}

/// Torque of the columns that are not the rigid body's, with these parameters.
fn beside_links(model: &Model, runs: &[Run], others: &[f64]) -> Result<Prediction> {
    let (order, rank) = rigid_first(model);
    let mut x = vec![0.0; model.columns.len()];
    order[rank..].iter().zip(others).for_each(|(&c, &value)| x[c] = value);
    predict(model, runs, &x)
}

/// Friction of a joint from the friction path; none where it has none.
fn sigmoid(path: &[FrictionResult], joint: &str) -> SigmoidParameters {
    let found = path.iter().find(|f| f.joint == joint);
    let value = |name: &str| {
        found.and_then(|f| f.parameters.iter().find(|p| p.name == name)).map_or(0.0, |p| p.value)
    };
    SigmoidParameters { phi1: value("phi1"), phi2: value("phi2"), phi3: value("phi3") }
}

/// Torque error of links and friction.
fn errors(chain: &Chain, runs: &[Run], links: &[f64], friction: &Prediction) -> Errors {
    let mut sums = vec![ErrorSums::default(); chain.dof()];
    for (run, friction) in runs.iter().zip(friction) {
        let samples = Samples { q: &run.q, dq: &run.dq, ddq: &run.ddq };
        let rigid = inverse_dynamics_batch(chain, samples, links);
        for (j, sum) in sums.iter_mut().enumerate() {
            let (measured, rigid) = (run.to_rows(&run.tau[j]), run.to_rows(&rigid[j]));
            for ((measured, rigid), friction) in measured.iter().zip(rigid.iter()).zip(&friction[j]) {
                sum.add(measured - rigid - friction, *measured);
            }
        }
    }
    Errors::from_sums(&sums)
}

/// Mean size of force and moment that each joint carries [N, N m].
fn mean_wrenches(chain: &Chain, runs: &[Run], links: &[f64]) -> Vec<[f64; 2]> {
    let n = chain.dof();
    let mut ws = Workspace::new(chain, 0.0);
    let (mut sums, mut count) = (vec![[0.0; 2]; n], 0_usize);
    let mut tau = vec![0.0; n];
    for run in runs {
        for k in (0..run.samples()).step_by((run.samples() / WRENCH_SAMPLES).max(1)) {
            let at = |columns: &[Vec<f64>]| -> Vec<f64> { columns.iter().map(|c| c[k]).collect() };
            let (q, dq, ddq) = (at(&run.q), at(&run.dq), at(&run.ddq));
            inverse_dynamics(chain, &mut ws, State::new(&q, &dq, &ddq), links, &mut tau);
            for (j, sum) in sums.iter_mut().enumerate() {
                let (force, moment) = wrench(&ws, j);
                let size = |v: [f64; 3]| v.iter().map(|x| x * x).sum::<f64>().sqrt();
                sum[0] += size(force);
                sum[1] += size(moment);
            }
            count += 1;
        }
    }
    sums.into_iter().map(|s| s.map(|x| x / count.max(1) as f64)).collect()
}
