//! What the pictures of a diagnosis are drawn from.

use std::sync::Arc;

use super::answer::Step;
use super::base::Base;
use super::data::{Column, Data};
use super::ladder::{Ladder, Scored};
use super::present::rms;
use crate::report::pictures::{Compared, EffectShare, JointUnits, Pictures, Ranked, Role, Trace};

/// Candidates that are kept for the picture at most.
pub(super) const RANKED: usize = 60;
/// Parameters of a candidate that are named at most.
const SYMBOLS: usize = 4;
/// A joint is shown for an effect of the whole robot where it gets this part of the largest torque.
const NOTICED: f64 = 0.1;

/// Everything that a page draws, but for logs that are never fitted.
pub(super) fn of(ladder: &Ladder, base: &Base, climb: Vec<Step>) -> Pictures {
    let data = &ladder.data;
    let compared = |label: &str| Compared { label: label.to_string(), held_out: true };
    let mut traces = fitted_logs(data);
    let before = modelled(data, &base.residual);
    let after = modelled(data, &ladder.response.residual);
    for (trace, range) in traces.iter_mut().zip(data.run_ranges()) {
        for model in [&before, &after] {
            trace.add_model(model.iter().map(|rows| rows[range.clone()].to_vec()).collect());
        }
    }
    Pictures {
        joints: JointUnits::of(&data.robot),
        models: vec![compared("starting model"), compared("with what was found")],
        effects: effects(ladder, &traces),
        traces,
        ranking: ladder.ranking.clone(),
        climb,
    }
}

/// The fitted logs with the model at hand alone.
pub(super) fn of_one(ladder: &Ladder) -> Pictures {
    let data = &ladder.data;
    let mut traces = fitted_logs(data);
    let model = modelled(data, &ladder.response.residual);
    for (trace, range) in traces.iter_mut().zip(data.run_ranges()) {
        trace.add_model(model.iter().map(|rows| rows[range.clone()].to_vec()).collect());
    }
    Pictures {
        joints: JointUnits::of(&data.robot),
        models: vec![Compared { label: "model".to_string(), held_out: true }],
        effects: effects(ladder, &traces),
        traces,
        ..Pictures::default()
    }
}

fn fitted_logs(data: &Data) -> Vec<Trace> {
    let role = |changed: &bool| if *changed { Role::Fitted } else { Role::Reference };
    data.runs.iter().zip(&data.changed).map(|(run, changed)| Trace::of(run, role(changed))).collect()
}

fn modelled(data: &Data, residual: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let minus = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(a, b)| a - b).collect();
    data.tau.iter().zip(residual).map(minus).collect()
}

/// What every effect but the rigid body adds on every joint that it matters to.
fn effects(ladder: &Ladder, traces: &[Trace]) -> Vec<EffectShare> {
    let (data, parts) = (&ladder.data, &ladder.parts);
    let units = JointUnits::of(&data.robot);
    let x = ladder.present.fit(&data.tau);
    let residual = ladder.present.residual_of(&data.tau, &x);
    let mut all: Vec<EffectShare> = Vec::new();
    for part in parts.numbers() {
        let (effect, values) = (&parts.get(part).effect, &x[parts.place(part)]);
        if effect.is_rigid_body() {
            continue;
        }
        let about = effect.about();
        let torque = torque(data, &parts.own_columns(part), values);
        let largest = torque.iter().map(|t| rms(t)).fold(0.0, f64::max);
        let unknown = ladder.unknown.iter().find(|u| u.part == Some(part));
        let own = unknown.and_then(|u| u.depends_on.first()).map(String::as_str);
        for (joint, torque) in torque.iter().enumerate() {
            let size = rms(torque);
            if size > 0.0 && (parts.joint(part).is_some() || size >= NOTICED * largest) {
                let (found, left) = (parts.get(part).found, &residual[joint]);
                all.push(EffectShare::new(&about, found, joint, own, traces, &units, left, torque));
            }
        }
    }
    all
}

/// Torque of some columns with their values, joint by joint.
fn torque(data: &Data, columns: &[Arc<Column>], values: &[f64]) -> Vec<Vec<f64>> {
    let of_joint = |joint: usize| {
        let mut sum = vec![0.0; data.count()];
        for (column, value) in columns.iter().zip(values) {
            for (s, y) in sum.iter_mut().zip(column.part(joint).unwrap_or(&[])) {
                *s += value * y;
            }
        }
        sum
    };
    (0..data.dof()).map(of_joint).collect()
}

impl Ladder {
    /// Scores every candidate once, for the ranking alone.
    pub(super) fn rank(&mut self) {
        let scored = self.scan();
        self.note_ranking(&scored);
    }

    /// Notes what every candidate would bring beside the model at hand, for the picture of the ranking.
    pub(super) fn note_ranking(&mut self, scored: &[Scored]) {
        if !self.ranking.is_empty() {
            return;
        }
        let before = self.rms();
        let n = self.data.count() as f64;
        let name = |joint: usize| self.data.robot.joints[joint].name.clone();
        let one = |s: &Scored| {
            let candidate = &self.candidates[s.candidate];
            let terms = candidate.effect.terms(&self.data.robot).unwrap_or_default();
            let symbols = terms.into_iter().map(|term| term.symbol).take(SYMBOLS).collect();
            let gain = &s.score.gain_of_joint;
            let relative = |j: usize| gain[j] / (before[j] * before[j]).max(1e-300);
            let most = (0..gain.len()).max_by(|&a, &b| relative(a).total_cmp(&relative(b))).unwrap_or(0);
            let shown = candidate.joint.unwrap_or(most);
            Ranked {
                effect: candidate.name().to_string(),
                joint: candidate.joint.map(name),
                symbols,
                gain_percent: 100.0 * s.score.share,
                usefulness: s.usefulness,
                z: s.score.z,
                rms: [before[shown], (before[shown] * before[shown] - gain[shown] / n).max(0.0).sqrt()],
                rms_joint: name(shown),
                passes: self.passes(self.candidates[s.candidate].joint, s.usefulness, &s.score),
            }
        };
        self.ranking = scored.iter().take(RANKED).map(one).collect();
    }
}
