//! What the pictures of a diagnosis are drawn from.

use super::answer::Step;
use super::data::Data;
use super::ladder::{Ladder, Scored};
use super::present::rms;
use super::{regions, telling};
use crate::report::pictures::{
    Compared, EffectShare, JointUnits, Partial, Pictures, Ranked, Role, Trace, binned,
};

/// Candidates that are kept for the picture at most.
const RANKED: usize = 60;
/// A joint is shown for an effect of the whole robot where it gets this part of the largest torque.
const NOTICED: f64 = 0.1;

/// Everything that a page draws, but for logs that are never fitted.
pub(super) fn of(ladder: &Ladder, base: &telling::Base, climb: Vec<Step>) -> Pictures {
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
        traces,
        effects: effects(ladder),
        ranking: ladder.ranking.clone(),
        climb,
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
fn effects(ladder: &Ladder) -> Vec<EffectShare> {
    let (data, parts) = (&ladder.data, &ladder.parts);
    let x = ladder.present.fit(&data.tau);
    let residual = ladder.present.residual_of(&data.tau, &x);
    let mut all: Vec<EffectShare> = Vec::new();
    for part in parts.numbers() {
        let (effect, values) = (&parts.get(part).effect, &x[parts.place(part)]);
        if effect.about().name == "rigid_body" {
            continue;
        }
        let columns = parts.own_columns(part);
        let torque: Vec<Vec<f64>> = (0..data.dof())
            .map(|joint| {
                let mut sum = vec![0.0; data.count()];
                for (column, value) in columns.iter().zip(values) {
                    for (s, y) in sum.iter_mut().zip(column.part(joint).unwrap_or(&[])) {
                        *s += value * y;
                    }
                }
                sum
            })
            .collect();
        let largest = torque.iter().map(|t| rms(t)).fold(0.0, f64::max);
        for (joint, torque) in torque.into_iter().enumerate() {
            let size = rms(&torque);
            if size > 0.0 && (parts.joint(part).is_some() || size >= NOTICED * largest) {
                let depends_on = ladder.unknown.iter().find(|u| u.part == Some(part)).map(|u| &u.depends_on);
                let own = own_variable(effect.about().name, joint, depends_on);
                let partials = partials(data, joint, &own, &residual[joint], &torque);
                let torque = data.run_ranges().into_iter().map(|r| torque[r].to_vec()).collect();
                let (effect, found) = (effect.about().name.to_string(), parts.get(part).found);
                all.push(EffectShare { effect, found, joint, torque, partials });
            }
        }
    }
    all
}

/// The variable that an effect is made of, as far as it is one.
fn own_variable(effect: &str, joint: usize, depends_on: Option<&Vec<String>>) -> String {
    if let Some(variable) = depends_on.and_then(|d| d.first()) {
        return variable.clone();
    }
    let kind = match effect {
        "joint_spring"
        | "torque_ripple"
        | "base_tilt"
        | "joint_zero_error"
        | "position_dependent_friction" => "q",
        "rotor_inertia" | "joint_elasticity" => "ddq",
        "torque_gain" | "load_dependent_friction" | "payload" => return "load".to_string(),
        "torque_drift" | "friction_drift" | "thermal_friction" | "torque_offset" | "contact_force" => {
            return "time".to_string();
        }
        _ => "dq",
    };
    format!("{kind}{}", joint + 1)
}

/// Partial residuals against the effect's own variable, then against the others of its joint.
fn partials(data: &Data, joint: usize, own: &str, residual: &[f64], torque: &[f64]) -> Vec<Partial> {
    let mut variables = regions::variables(data, joint);
    if !variables.iter().any(|(name, _)| name == own) {
        variables
            .extend((0..data.dof()).flat_map(|j| regions::variables(data, j)).find(|(name, _)| name == own));
    }
    variables.sort_by_key(|(name, _)| name != own);
    let one = |(variable, values): (String, Vec<f64>)| {
        let unit = regions::unit(data, joint, &variable);
        Partial { bins: binned(&values, residual, torque), variable, unit }
    };
    variables.into_iter().map(one).collect()
}

impl Ladder {
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
            let gain = &s.score.gain_of_joint;
            let relative = |j: usize| gain[j] / (before[j] * before[j]).max(1e-300);
            let most = (0..gain.len()).max_by(|&a, &b| relative(a).total_cmp(&relative(b))).unwrap_or(0);
            let shown = candidate.joint.unwrap_or(most);
            Ranked {
                effect: candidate.name().to_string(),
                joint: candidate.joint.map(name),
                gain_percent: 100.0 * s.score.share,
                usefulness: s.usefulness,
                z: s.score.z,
                rms: [before[shown], (before[shown] * before[shown] - gain[shown] / n).max(0.0).sqrt()],
                rms_joint: name(shown),
                passes: self.passes(s.usefulness, &s.score),
            }
        };
        self.ranking = scored.iter().take(RANKED).map(one).collect();
    }
}
