//! Retrieved parameters side by side: torque error and joint wrenches through Newton-Euler.

use std::collections::BTreeMap;

use crate::effects::SigmoidParameters;
use crate::kernels::{Chain, Samples, State, Workspace, inverse_dynamics, inverse_dynamics_batch, wrench};
use crate::report::{Comparison, FrictionResult};
use crate::signals::Run;

use super::Study;
use super::moving::FromLogs;
use super::retrieval::FromEngines;

/// Wrenches are averaged over about this many samples.
const WRENCH_SAMPLES: usize = 500;

impl Study<'_> {
    /// Torque error of every engine's parameters on the logs of the study; `None` without logs.
    ///
    /// Friction is that of the friction path where the study has it, else that of the fitted model.
    pub(super) fn compare(
        &self,
        engines: &FromEngines,
        moving: Option<&FromLogs>,
        friction: &[FrictionResult],
    ) -> Option<Comparison> {
        let moving = moving?;
        let chain = Chain::new(&self.robot);
        let names: Vec<String> = self.robot.joints.iter().map(|j| j.name.clone()).collect();
        let links = 10 * engines.space.links;
        let (mut mse, mut wrenches) = (BTreeMap::new(), BTreeMap::new());
        for (label, z) in &engines.found {
            let squares =
                mean_squares(&chain, moving, &z[..links], |j, v| joint_friction(friction, &names[j], v));
            mse.insert(label.clone(), names.iter().cloned().zip(squares).collect());
            let sizes = mean_wrenches(&chain, &moving.runs, &z[..links]);
            wrenches.insert(label.clone(), names.iter().cloned().zip(sizes).collect());
        }
        let data: Vec<&str> = moving.runs.iter().map(|r| r.name.as_str()).collect();
        Some(Comparison { validation_mse: mse, data: format!("{} (fitted)", data.join(", ")), wrenches })
    }
}

fn joint_friction(friction: &[FrictionResult], joint: &str, velocity: f64) -> f64 {
    let Some(found) = friction.iter().find(|f| f.joint == joint) else { return 0.0 };
    let value = |name: &str| found.parameters.iter().find(|p| p.name == name).map_or(0.0, |p| p.value);
    SigmoidParameters { phi1: value("phi1"), phi2: value("phi2"), phi3: value("phi3") }.torque(velocity)
}

/// Mean squared torque error of each joint [(N m)²].
fn mean_squares(
    chain: &Chain,
    moving: &FromLogs,
    links: &[f64],
    friction: impl Fn(usize, f64) -> f64,
) -> Vec<f64> {
    let mut sums = vec![(0.0, 0_usize); chain.dof()];
    for run in &moving.runs {
        let samples = Samples { q: &run.q, dq: &run.dq, ddq: &run.ddq };
        let rigid = inverse_dynamics_batch(chain, samples, links);
        for (j, (sum, torque)) in sums.iter_mut().zip(rigid).enumerate() {
            let model: Vec<f64> = torque.iter().zip(&run.dq[j]).map(|(t, &v)| t + friction(j, v)).collect();
            for (measured, model) in run.to_rows(&run.tau[j]).iter().zip(run.to_rows(&model).iter()) {
                sum.0 += (measured - model) * (measured - model);
                sum.1 += 1;
            }
        }
    }
    sums.into_iter().map(|(squares, rows)| squares / rows.max(1) as f64).collect()
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
