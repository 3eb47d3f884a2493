//! From the state of the climb to the answer.

use std::collections::BTreeMap;

use nalgebra::DMatrix;

use super::answer::{
    Baseline, Diagnosis, Event, Joint, Missing, Moved, Parameter, Refused, Signals, Step, Undecided,
    Unexplained,
};
use super::base::{Base, MOVED};
use super::ladder::{Ladder, Rung};
use super::present::rms;
use super::signals::Chosen;
use super::{entry, regions};
use crate::effects::RigidBody;
use crate::error::Result;
use crate::report::finite;

/// Effects that gain less than this part of what is still unexplained on a joint, or of the largest gain, are
/// minor.
const MINOR: [f64; 2] = [0.05, 0.01];
/// Unless this part of the whole robot's squared error, in N m, would come back without them.
const POOLED: f64 = 0.05;

/// An effect that the user asked to add.
pub(super) struct Added {
    pub name: String,
    /// The joint it was asked for.
    pub joint: Option<usize>,
    pub parts: Vec<usize>,
    pub rms: Vec<f64>,
}

impl Added {
    pub fn now(ladder: &Ladder, name: &str, joint: Option<usize>, parts: &[usize]) -> Self {
        Self { name: name.to_string(), joint, parts: parts.to_vec(), rms: ladder.rms() }
    }
}

/// Everything the answer is made of.
pub(super) struct Telling<'a> {
    pub ladder: &'a Ladder,
    pub chosen: &'a Chosen,
    pub base: &'a Base,
    pub added: &'a [Added],
    pub auto: bool,
    /// The parts' parameters, fitted to all data.
    pub x: Vec<f64>,
    pub undecided: &'a [Undecided],
}

impl Telling<'_> {
    pub fn tell(&self) -> Result<Diagnosis> {
        let (missing, minor) = self.missing()?;
        let unexplained: Vec<Unexplained> = self.ladder.unexplained().into_iter().map(|(u, _)| u).collect();
        let found = !missing.is_empty() || !minor.is_empty() || !unexplained.is_empty();
        Ok(Diagnosis {
            lacuna: env!("CARGO_PKG_VERSION").to_string(),
            verdict: entry::verdict(found, self.undecided),
            signals: self.signals(),
            joints: self.joints(),
            baseline: self.baseline(),
            first: if found { self.first() } else { None },
            missing,
            minor,
            unexplained,
            refused: self.refused(),
            inseparable: super::doubts::inseparable(self.ladder),
            regions: regions::find(&self.ladder.data, &self.base.residual),
            events: self.events()?,
            moved: self.moved()?,
            ladder: self.steps(self.auto),
            validation: None,
            nested: None,
            gate: [self.ladder.gates.range().1, self.ladder.gates.flips],
            stop_reason: self.stop_reason(),
            timing: BTreeMap::new(),
            undecided: self.undecided.to_vec(),
        })
    }

    pub fn name(&self, joint: usize) -> String {
        self.ladder.data.robot.joints[joint].name.clone()
    }

    fn signals(&self) -> Signals {
        let mut dropped: BTreeMap<String, usize> = BTreeMap::new();
        for (reason, count) in self.chosen.reports.iter().flat_map(|r| &r.rows_dropped) {
            *dropped.entry(reason.clone()).or_default() += count;
        }
        let data = &self.ladder.data;
        for (joint, counted) in data.robot.joints.iter().zip(&data.counted) {
            let unusable = data.count() - *counted as usize;
            if unusable > 0 {
                dropped.insert(format!("{} stands still or at a torque limit", joint.name), unusable);
            }
        }
        let report = self.chosen.reports.first();
        let thinned = self.chosen.reports.iter().filter_map(|r| Some((r.log.clone(), r.thinned.clone()?)));
        Signals {
            mode: "parallel",
            band_hz: self.chosen.settings.band_hz,
            source_of_velocity: report.map_or("position", |r| r.source_of_velocity),
            position_cutoff_hz: report.and_then(|r| r.position_cutoff_hz),
            friction_cutoff_hz: report.and_then(|r| r.friction_cutoff_hz),
            source_of_friction_velocity: report.and_then(|r| r.source_of_friction_velocity),
            sign_width: self.base.widths.clone(),
            trim_s: self.chosen.settings.trim_s,
            rows_used: self.ladder.data.count(),
            rows_dropped: dropped,
            thinned: thinned.collect(),
            folds: self.ladder.data.folds.description.clone(),
        }
    }

    fn joints(&self) -> Vec<Joint> {
        let data = &self.ladder.data;
        let after = self.ladder.rms();
        (0..data.dof())
            .map(|j| {
                let (torque, error) = (rms(&data.tau[j]), rms(&self.base.residual[j]));
                let mean = data.tau[j].iter().sum::<f64>() / data.count().max(1) as f64;
                Joint {
                    name: self.name(j),
                    torque_rms: torque,
                    held_out_rms: error,
                    relative_error_percent: finite(100.0 * error / torque),
                    repeat_floor_rms: self.ladder.floor.repeat.as_ref().map(|f| f[j]),
                    worse_than_constant: error * error > torque * torque - mean * mean,
                    held_out_rms_after: after[j],
                }
            })
            .collect()
    }

    pub fn pooled(&self, rms_of: &[f64]) -> Option<f64> {
        let squares: f64 = rms_of.iter().map(|r| r * r).sum();
        let torque: f64 = self.ladder.data.tau.iter().map(|t| rms(t) * rms(t)).sum();
        finite(100.0 * (squares / torque).sqrt())
    }

    fn baseline(&self) -> Baseline {
        let mut effects: Vec<String> = Vec::new();
        for effect in &self.base.effects {
            let name = effect.about().name.to_string();
            if !effects.contains(&name) {
                effects.push(name);
            }
        }
        let errors: Vec<f64> = self.base.residual.iter().map(|r| rms(r)).collect();
        let fitted = self.base.refit.is_none();
        Baseline { effects, fitted, held_out_relative_error_percent: self.pooled(&errors) }
    }

    /// Reducible squared error of each joint in units of its noise floor.
    pub fn excess(&self) -> Vec<f64> {
        let floor = &self.ladder.floor.rms;
        let of = |(r, f): (&Vec<f64>, &f64)| ((rms(r) / f) * (rms(r) / f) - 1.0).max(0.0);
        self.ladder.of_moving(self.base.residual.iter().zip(floor).map(of).collect())
    }

    /// What was found, by effect, most useful first; and what is small beside it.
    fn missing(&self) -> Result<(Vec<Missing>, Vec<Missing>)> {
        let largest = self.ladder.rungs.iter().map(|r| r.usefulness).fold(0.0, f64::max);
        let mut order: Vec<&Rung> = self.ladder.rungs.iter().collect();
        order.sort_by(|a, b| b.usefulness.total_cmp(&a.usefulness));
        let unexplained = self.ladder.excess().into_iter().fold(0.0, f64::max);
        let least = (MINOR[0] * unexplained).max(MINOR[1] * largest);
        let (mut missing, mut minor): (Vec<Missing>, Vec<Missing>) = (Vec::new(), Vec::new());
        let mut refit = self.base.missing(self.ladder, &self.x);
        for rung in order.into_iter().filter(|r| !self.is_formula(r.part)) {
            missing.extend(refit.take_if(|(useful, _)| *useful >= rung.usefulness).map(|(_, entry)| entry));
            let entry = self.entry(rung)?;
            let small = rung.usefulness < least && self.pooled_part(rung) < POOLED;
            let list = if small { &mut minor } else { &mut missing };
            match list.iter_mut().find(|m| m.effect == entry.effect && !m.joints.is_empty()) {
                Some(known) if !entry.joints.is_empty() => merge(known, entry),
                _ => list.push(entry),
            }
        }
        missing.extend(refit.map(|(_, entry)| entry));
        Ok((missing, minor))
    }

    /// Part of the squared held-out error of the whole robot that would come back without this effect.
    fn pooled_part(&self, rung: &Rung) -> f64 {
        let square = |rms: &[f64]| rms.iter().map(|r| r * r).sum::<f64>();
        let (with, without) = (square(&self.ladder.rms()), square(&self.ladder.rms_without(&[rung.part])));
        1.0 - with / without.max(1e-300)
    }

    pub fn entry(&self, rung: &Rung) -> Result<Missing> {
        let part = self.ladder.parts.get(rung.part);
        let about = part.effect.about();
        let changed = |j: &usize| {
            let moved = (rung.before[*j] - rung.after[*j]).abs() > 0.02 * rung.before[*j];
            part.joint == Some(*j) || (!rung.together && moved)
        };
        let joints: Vec<usize> = (0..self.ladder.data.dof()).filter(changed).collect();
        Ok(Missing {
            effect: about.name.to_string(),
            joints: part.identity.joint.map(|j| self.name(j)).into_iter().collect(),
            equation: about.equation.to_string(),
            parameters: self.parameters(rung.part)?,
            gain_percent: 100.0 * rung.score.share,
            z: rung.score.z,
            held_out_rms: joints.iter().map(|&j| (self.name(j), [rung.before[j], rung.after[j]])).collect(),
            also_possible: super::doubts::also_possible(self.ladder, rung),
            place: self.place(rung),
            caveat: (about.special.caveat.map(str::to_string)).or_else(|| {
                part.effect.odd(&self.ladder.data.robot, &self.x[self.ladder.parts.place(rung.part)])
            }),
            remainder: part.joint.and_then(|j| super::doubts::remainder(self.ladder, j)),
        })
    }

    /// Where in the data the effect helps most.
    fn place(&self, rung: &Rung) -> String {
        let data = &self.ladder.data;
        let Some(joint) = self.ladder.parts.joint(rung.part).filter(|_| !rung.score.effect.is_empty()) else {
            return "the whole robot".to_string();
        };
        let (f, r) = (&rung.score.effect[joint], &self.base.residual[joint]);
        let gains: Vec<f64> = f.iter().zip(r).map(|(f, r)| 2.0 * f * r - f * f).collect();
        let total: f64 = gains.iter().sum();
        let seconds = data.seconds();
        let mut of_second = vec![0.0; seconds.last().map_or(0, |s| s + 1)];
        for (gain, &second) in gains.iter().zip(&seconds) {
            of_second[second] += gain;
        }
        let helped = of_second.iter().filter(|g| **g > 0.0).count();
        let largest = of_second.iter().copied().fold(0.0, f64::max);
        if total <= largest {
            return format!("{}: helps in {helped} of {} seconds", self.name(joint), of_second.len());
        }
        format!(
            "{}: helps in {helped} of {} seconds, {:.0} % of the gain in the best one",
            self.name(joint),
            of_second.len(),
            100.0 * largest / total.max(1e-300)
        )
    }

    fn parameters(&self, part: usize) -> Result<Vec<Parameter>> {
        let place = self.ladder.parts.place(part);
        let covariance = self.ladder.present.covariance(&self.ladder.data, &self.x, place.clone());
        let effect = &self.ladder.parts.get(part).effect;
        let described = effect.describe(&self.ladder.data.robot, &self.x[place], &covariance)?;
        Ok(described
            .into_iter()
            .map(|d| Parameter {
                name: d.name,
                value: d.value,
                unit: d.unit.to_string(),
                standard_error: d.standard_error.and_then(finite),
            })
            .collect())
    }

    fn events(&self) -> Result<Vec<Event>> {
        let ladder = self.ladder;
        let mut all = Vec::new();
        for &part in &ladder.events {
            let effect = &ladder.parts.get(part).effect;
            let Some((from, to)) = effect.interval() else { continue };
            let x = ladder.present.fit(&ladder.data.tau);
            let force = &x[ladder.parts.place(part)];
            let force_n = [force[0], force[1], force[2]];
            all.push(Event { kind: effect.about().name, from_s: from, to_s: to, force_n });
        }
        Ok(all)
    }

    pub fn is_formula(&self, part: usize) -> bool {
        self.ladder.unknown.iter().any(|u| u.part == Some(part))
    }

    fn refused(&self) -> Vec<Refused> {
        let one = |r: &super::ladder::Refusal| Refused {
            effect: r.identity.name.to_string(),
            joints: r.identity.joint.map(|j| self.name(j)).into_iter().collect(),
            reason: r.reason.clone(),
        };
        self.ladder.refused.iter().map(one).collect()
    }

    fn moved(&self) -> Result<Vec<Moved>> {
        let after = &self.x;
        let count = self.base.x.len();
        let covariance: DMatrix<f64> = self.ladder.present.covariance(&self.ladder.data, after, 0..count);
        let mut all = Vec::new();
        for (i, (name, unit)) in self.base.names.iter().enumerate() {
            let error = covariance[(i, i)].sqrt();
            if (after[i] - self.base.x[i]).abs() > MOVED * error {
                all.push(Moved {
                    parameter: name.clone(),
                    before: self.base.x[i],
                    after: after[i],
                    standard_error: finite(error),
                    unit: (*unit).to_string(),
                });
            }
        }
        Ok(all)
    }

    /// The error with everything that was found, one effect after the other.
    pub fn climb(&self) -> Vec<Step> {
        self.steps(true)
    }

    fn steps(&self, found: bool) -> Vec<Step> {
        let step = |effect: &str, joints: Vec<String>, after: &[f64]| Step {
            effect: effect.to_string(),
            joints,
            held_out_relative_error_percent: self.pooled(after),
            rms: (0..after.len()).map(|j| (self.name(j), after[j])).collect(),
        };
        let joints = |parts: &[usize]| -> Vec<String> {
            let of = |p: &usize| self.ladder.parts.get(*p).identity.joint;
            let mut joints: Vec<usize> = parts.iter().filter_map(of).collect();
            joints.dedup();
            joints.into_iter().map(|j| self.name(j)).collect()
        };
        let refit = self.base.refit.as_ref().map(|r| step(RigidBody::ABOUT.name, Vec::new(), &r.after));
        let wanted = |a: &Added| match joints(&a.parts) {
            none if none.is_empty() => a.joint.map(|j| self.name(j)).into_iter().collect(),
            some => some,
        };
        let added = self.added.iter().map(|a| step(&a.name, wanted(a), &a.rms));
        let mut all: Vec<Step> = refit.into_iter().chain(added).collect();
        if found {
            let rungs: Vec<usize> = self.ladder.rungs.iter().map(|r| r.part).collect();
            for (k, &part) in rungs.iter().enumerate() {
                // Fitted again with what stayed in the end, so that the rungs belong to one ladder.
                let after = self.ladder.rms_without(&rungs[k + 1..]);
                let name = self.ladder.parts.get(part).effect.about().name;
                all.push(step(name, joints(&[part]), &after));
            }
        }
        all
    }

    fn stop_reason(&self) -> String {
        let ladder = self.ladder;
        if ladder.rungs.len() >= ladder.limits.steps {
            return format!("stopped after {} effects; more may be missing", ladder.limits.steps);
        }
        if ladder.ranking.is_empty() {
            return "nothing was looked for".to_string();
        }
        if ladder.limits.stop.asked() {
            return "stopped when asked to; more may be missing".to_string();
        }
        let (low, high) = ladder.gates.range();
        let from =
            if high - low < 0.05 { format!("{low:.1}") } else { format!("{low:.1} to {high:.1}, by joint") };
        let left = if ladder.best_left > 0.0 {
            format!("nothing else passes: the largest z left is {:.1}, needed is {from}", ladder.best_left)
        } else {
            format!("nothing else passes: nothing that is left matters (a z of {from} is needed as well)")
        };
        let turning = ladder.at_reversals;
        if turning < low {
            return left;
        }
        format!(
            "{left}; what shows only where joints turn round (z {turning:.1}) a sharper or softer sign would explain as \
             well"
        )
    }
}

/// One line for the same effect on several joints.
fn merge(known: &mut Missing, mut entry: Missing) {
    // A shape is called alike on every joint.
    let shared = |a: &Parameter, others: &[Parameter]| others.iter().any(|b| b.name == a.name);
    let called = |p: &mut Parameter, joint: Option<&String>| {
        p.name = joint.map_or(p.name.clone(), |joint| format!("{}_{joint}", p.name));
    };
    let first = entry.parameters.clone();
    for p in known.parameters.iter_mut().filter(|p| shared(p, &first)) {
        called(p, known.joints.first());
    }
    if !known.joints.is_empty() {
        let linear = |p: &Parameter| p.standard_error.is_some();
        for p in entry.parameters.iter_mut().filter(|p| !linear(p)) {
            called(p, entry.joints.first());
        }
    }
    for joint in entry.joints {
        if !known.joints.contains(&joint) {
            known.joints.push(joint);
        }
    }
    known.parameters.extend(entry.parameters);
    known.gain_percent += entry.gain_percent;
    known.z = known.z.max(entry.z);
    for (joint, rms) in entry.held_out_rms {
        known.held_out_rms.entry(joint).or_insert(rms);
    }
    for other in entry.also_possible {
        if !known.also_possible.contains(&other) {
            known.also_possible.push(other);
        }
    }
    known.place = format!("{}; {}", known.place, entry.place);
}
