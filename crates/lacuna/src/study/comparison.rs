//! Link parameters side by side: torque error and joint wrenches through Newton-Euler.

use std::collections::BTreeMap;

use crate::effects::SigmoidParameters;
use crate::error::Result;
use crate::identify::Errors;
use crate::kernels::{Chain, Samples, State, Workspace, inverse_dynamics, inverse_dynamics_batch, wrench};
use crate::model::Model;
use crate::predict::{predict, prediction_errors};
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
            joints: names.clone(),
            validation_mse: BTreeMap::new(),
            relative_error_percent: BTreeMap::new(),
            data: data.join(", "),
            fitted,
            wrenches: BTreeMap::new(),
        };
        for candidate in &engines.candidates {
            let Candidate { label, links, .. } = candidate;
            let errors = match &logs.fitted {
                Some(fitted) if friction.is_empty() || !candidate.others.is_empty() => {
                    let x = parameters(&fitted.fitted, &fitted.x, candidate);
                    prediction_errors(runs, &predict(&fitted.fitted, runs, &x)?)
                }
                _ => errors(&chain, runs, links, |j, v| sigmoid(friction, &names[j]).torque(v)),
            };
            let squares = errors.rms.iter().map(|rms| rms * rms).collect();
            all.validation_mse.insert(label.clone(), named(squares));
            all.relative_error_percent.insert(label.clone(), finite(errors.pooled_percent));
            let sizes = mean_wrenches(&chain, runs, links);
            all.wrenches.insert(label.clone(), names.iter().cloned().zip(sizes).collect());
        }
        Ok(Some(all))
    }
}

/// The columns of a fitted model for a candidate: its links, and what was retrieved along or else fitted.
fn parameters(model: &Model, fitted: &[f64], candidate: &Candidate) -> Vec<f64> {
    let (order, rank) = rigid_first(model);
    let mut x = fitted.to_vec();
    let coefficients = model.base.as_ref().map_or(Vec::new(), |base| base.coefficients(&candidate.links));
    let columns = order[..rank].iter().zip(&coefficients).chain(order[rank..].iter().zip(&candidate.others));
    columns.for_each(|(&column, &value)| x[column] = value);
    x
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
fn errors(chain: &Chain, runs: &[Run], links: &[f64], friction: impl Fn(usize, f64) -> f64) -> Errors {
    let torque = |run: &Run| -> Vec<Vec<f64>> {
        let samples = Samples { q: &run.q, dq: &run.dq, ddq: &run.ddq };
        let rigid = inverse_dynamics_batch(chain, samples, links).into_iter().enumerate();
        let joint = |(j, rigid): (usize, Vec<f64>)| {
            let all: Vec<f64> = rigid.iter().zip(&run.dq[j]).map(|(t, &v)| t + friction(j, v)).collect();
            run.to_rows(&all).into_owned()
        };
        rigid.map(joint).collect()
    };
    prediction_errors(runs, &runs.iter().map(torque).collect())
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
