//! Torque that is out of step with the motion: a causal filter or a bus on one side of the equation. It is a fault of
//! the pipeline that imitates much else, so it is mended first and everything is looked at again.

use super::answer::{Diagnosis, First, Missing, Refused, Step, Verdict};
use super::base::Base;
use super::entry::Request;
use super::ladder::{Ladder, Rung};
use super::present::rms;
use super::signals::{Chosen, prepared};
use super::telling::Telling;
use crate::effects::{Effect, Imitation, Joints, TimeDelay};
use crate::error::Result;
use crate::log::Log;

/// A delay below this part of a sampling time is the clock's doing, not worth a word beside physics.
pub(super) const OF_A_SAMPLE: f64 = 0.5;

/// A joint's own delay below this part of the whole robot's is what putting the torque in step leaves of that.
const OF_THE_WHOLE: f64 = 0.3;

/// Times that a delay is measured again at most, and the change that no longer matters \[s\].
const SETTLINGS: usize = 4;
const SETTLED: f64 = 2e-4;

/// A delay of the whole robot, with what was known of it when it was found.
pub(super) struct Late {
    /// Altogether \[s\].
    pub seconds: f64,
    /// As it was told the first time.
    told: Missing,
}

/// The delay of all joints that the ladder found.
fn rung(ladder: &Ladder) -> Option<&Rung> {
    ladder.rungs.iter().find(|r| {
        ladder.parts.joint(r.part).is_none()
            && ladder.parts.get(r.part).effect.about().is_imitated_by(Imitation::Clock)
    })
}

impl Late {
    /// Takes note of a delay that was found, or of what was left of it; answers whether there was any.
    pub fn note(known: &mut Option<Self>, telling: &Telling<'_>) -> Result<bool> {
        let ladder = telling.ladder;
        let Some(rung) = rung(ladder) else { return Ok(false) };
        let seconds = telling.x[ladder.parts.place(rung.part)][0];
        match known {
            Some(late) => late.seconds += seconds,
            None => *known = Some(Self { seconds, told: telling.entry(rung)? }),
        }
        Ok(true)
    }

    /// Measures the delay again on logs that are put in step, until nothing is left of it: the first measure is only
    /// good to first order.
    pub fn settle(&mut self, request: &Request<'_>, chosen: &Chosen, logs: &[Log]) -> Result<()> {
        let whole = TimeDelay { joints: Joints::All };
        for _ in 0..SETTLINGS {
            let (runs, _) = prepared(&self.mended(logs), &chosen.settings)?;
            let mut ladder = request.bare(request.data(chosen, runs)?, chosen)?;
            ladder.refresh_torque()?;
            let left = ladder.values(&whole)?[0];
            self.seconds += left;
            if left.abs() < SETTLED {
                break;
            }
        }
        Ok(())
    }

    /// `12.3 ms late`.
    pub fn words(&self) -> String {
        format!("{:.1} ms {}", 1e3 * self.seconds.abs(), if self.seconds < 0.0 { "early" } else { "late" })
    }

    /// The logs with their torque put in step.
    pub fn mended(&self, logs: &[Log]) -> Vec<Log> {
        logs.iter().map(|log| shifted(log, self.seconds)).collect()
    }

    /// These effects, for models of the logs as they are: the delay stands among them once.
    pub fn among(effects: Vec<Box<dyn Effect>>) -> Vec<Box<dyn Effect>> {
        let own: Box<dyn Effect> = Box::new(TimeDelay { joints: Joints::All });
        let others = effects.into_iter().filter(|e| e.about().name != own.about().name);
        let mut all: Vec<Box<dyn Effect>> = others.collect();
        all.push(own);
        all
    }

    /// Puts it before everything else, or aside where it is less than the clock can tell. `mended` is the starting
    /// model on the logs that were put in step.
    pub fn into_answer(self, d: &mut Diagnosis, telling: &Telling<'_>, mended: &Base) {
        let words = self.words();
        let Self { seconds, mut told } = self;
        // What is left of it is part of the whole; a filter holds fast torque back less than slow torque, so on some
        // joints a little is always left.
        let little = |m: &Missing| m.parameters.iter().all(|p| p.value.abs() < OF_THE_WHOLE * seconds.abs());
        let other = |m: &Missing| m.effect != told.effect || (!m.joints.is_empty() && !little(m));
        d.missing.retain(other);
        d.minor.retain(other);
        let milliseconds = 1e3 * seconds;
        if seconds.abs() < OF_A_SAMPLE * telling.ladder.data.runs.first().map_or(0.0, |run| run.dt) {
            let reason = format!(
                "{milliseconds:.2} ms is a small part of the sampling time: the clock's doing, not the arm's; the torque \
                 was put in step"
            );
            d.refused.push(Refused { effect: told.effect, joints: Vec::new(), reason });
            return;
        }
        if let Some(delay) = told.parameters.first_mut() {
            delay.value = seconds;
        }
        let names = telling.ladder.data.robot.joints.iter().map(|j| j.name.clone());
        let after: Vec<f64> = mended.residual.iter().map(|r| rms(r)).collect();
        let before = telling.base.residual.iter().map(|r| rms(r));
        told.held_out_rms = names.clone().zip(before.zip(&after).map(|(b, a)| [b, *a])).collect();
        told.place = format!(
            "the whole robot: the torque is {words}, as a causal filter or a bus makes it; it was put in step before \
             anything else was looked for. Filter torque and motion alike, or log both in one place"
        );
        if let Some(first) = self::first(telling, &after) {
            d.first = Some(first);
        }
        if telling.auto {
            let step = Step {
                effect: told.effect.clone(),
                joints: Vec::new(),
                held_out_relative_error_percent: telling.pooled(&after),
                rms: names.zip(after).collect(),
            };
            d.ladder.insert(telling.added.len().min(d.ladder.len()), step);
        }
        d.missing.insert(0, told);
        d.verdict = Verdict::Missing;
    }
}

/// Where most of the reducible error was, if being out of step is most of it.
fn first(telling: &Telling<'_>, after: &[f64]) -> Option<First> {
    let excess = telling.excess();
    let worst = (0..excess.len()).max_by(|&a, &b| excess[a].total_cmp(&excess[b]))?;
    let floor = telling.ladder.floor.rms[worst];
    let left = (after[worst] / floor) * (after[worst] / floor) - 1.0;
    (left < 0.5 * excess[worst]).then(|| First {
        joint: telling.ladder.data.robot.joints[worst].name.clone(),
        share_of_reducible_percent: 100.0 * excess[worst] / excess.iter().sum::<f64>().max(1e-300),
        cause: TimeDelay::ABOUT.name.to_string(),
    })
}

/// The torque as it was `seconds` later, between samples in proportion.
fn shifted(log: &Log, seconds: f64) -> Log {
    let mut log = log.clone();
    if !log.t.is_sorted() {
        return log;
    }
    let last = log.t.len().saturating_sub(1);
    let places: Vec<(usize, f64)> = log
        .t
        .iter()
        .map(|t| {
            let wanted = t + seconds;
            let next = log.t.partition_point(|t| *t <= wanted).clamp(1.min(last), last);
            let before = next.saturating_sub(1);
            let width = log.t[next] - log.t[before];
            let part = if width > 0.0 { ((wanted - log.t[before]) / width).clamp(0.0, 1.0) } else { 0.0 };
            (before, part)
        })
        .collect();
    for column in &mut log.tau {
        let at = |&(k, part): &(usize, f64)| column[k] * (1.0 - part) + column[(k + 1).min(last)] * part;
        *column = places.iter().map(at).collect();
    }
    log
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn torque_comes_back_in_step() {
        let t: Vec<f64> = (0..200).map(|k| 0.01 * f64::from(k)).collect();
        let late: Vec<f64> = t.iter().map(|t| libm::sin(3.0 * (t - 0.023))).collect();
        let log = Log { tau: vec![late], t: t.clone(), ..Log::default() };
        for (k, tau) in shifted(&log, 0.023).tau[0].iter().enumerate().take(190).skip(5) {
            assert!((tau - libm::sin(3.0 * t[k])).abs() < 2e-4, "{k}: {tau}");
        }
    }
}
