//! Looking back: whether everything that was found is still needed, and whether one cause explains several findings.

use std::sync::Arc;

use super::data::{Column, Data};
use super::events;
use super::ladder::{Ladder, Rung};
use super::present::{Present, Response};
use super::score::{Projection, Ridge, Score};
use crate::error::Result;

/// One cause takes the place of several findings when the mean logarithm of held-out rms grows by no more than this.
const WORSE: f64 = 0.01;

/// What gains less than this part of the largest reducible error that is left is not told: a model that misses so much on
/// one joint cannot tell so little on another.
const BESIDE: f64 = 0.005;

/// Least size of a single parameter in units of its standard error.
const MEASURED: f64 = 3.5;

/// A model with its fits, for what is tried beside it.
pub(super) struct Beside {
    pub present: Present,
    pub response: Response,
}

impl Beside {
    /// What columns, or the best of their alternatives, would bring.
    pub fn score(&self, data: &Data, alternatives: Vec<Vec<Arc<Column>>>) -> Option<Score> {
        Projection::new(data, &self.present, alternatives, Ridge::None).score(
            data,
            &self.present,
            &self.response,
        )
    }
}

impl Ladder {
    /// Drops effects that have become needless since others came in; answers whether there were any.
    pub fn look_back(&mut self, say: &mut dyn FnMut(&str)) -> Result<bool> {
        let mut dropped = self.drop_contacts(say)?;
        while !self.limits.stop.asked() {
            let Some(rung) = self.weakest()? else { break };
            let part = self.rungs[rung].part;
            say(&format!("no longer needed: {}", self.parts.title(part, &self.data.robot)));
            self.dropped.push(self.parts.get(part).identity.clone());
            self.take_out(part);
            self.refit()?;
            dropped = true;
        }
        Ok(dropped)
    }

    /// Drops contacts that nobody would see any more, since what looked like one has another cause.
    fn drop_contacts(&mut self, say: &mut dyn FnMut(&str)) -> Result<bool> {
        let mut dropped = false;
        for part in self.events.clone() {
            if self.rungs.len() == self.events.len() {
                break;
            }
            let beside = self.beside(part);
            let own = self.parts.get(part).effect.interval();
            let seen = events::contact(&self.data, &beside.present, &self.floor)?;
            let again = |c: &events::Contact| {
                own.is_none_or(|(from, to)| c.effect.from_s < to && c.effect.to_s > from)
            };
            if !seen.as_ref().is_some_and(again) {
                say(&format!("no longer needed: {}", self.parts.title(part, &self.data.robot)));
                self.events.retain(|p| *p != part);
                self.take_out(part);
                self.refit()?;
                dropped = true;
            }
        }
        Ok(dropped)
    }

    /// The finding that is needed least among those that are not needed.
    fn weakest(&self) -> Result<Option<usize>> {
        let mut weakest: Option<(usize, f64)> = None;
        let x = self.present.fit(&self.data.tau);
        let least = BESIDE * self.excess().into_iter().fold(0.0, f64::max);
        for (place, rung) in self.rungs.iter().enumerate() {
            let part = rung.part;
            if self.events.contains(&part) || self.is_common(part) {
                continue;
            }
            let (score, usefulness) = self.without(part)?;
            let passes = |s: &Score| self.passes(self.parts.joint(part), usefulness, s);
            let needed =
                score.as_ref().is_some_and(passes) && usefulness >= least && self.is_measured(part, &x);
            let z = score.map_or(0.0, |s| s.z);
            if !needed && weakest.is_none_or(|(_, least)| z < least) {
                weakest = Some((place, z));
            }
        }
        Ok(weakest.map(|(place, _)| place))
    }

    /// Whether a part with a single parameter has it well away from zero, by its own standard error.
    fn is_measured(&self, part: usize, x: &[f64]) -> bool {
        let place = self.parts.place(part);
        if place.len() != 1 {
            return true;
        }
        let error = self.present.covariance(&self.data, x, place.clone())[(0, 0)].sqrt();
        x[place.start].abs() >= MEASURED * error
    }

    /// Puts one cause that acts on the whole robot into the place of several findings, where it makes them needless:
    /// a tilted base, say, is a spring here and a gain there until somebody thinks of it. Answers whether it did.
    pub fn gather(&mut self, say: &mut dyn FnMut(&str)) -> Result<bool> {
        let mut gathered = false;
        for candidate in 0..self.candidates.len() {
            let whole = &self.candidates[candidate];
            let open = whole.joint.is_none() && whole.identity.joint.is_none() && !whole.columns.is_empty();
            if self.limits.stop.asked()
                || self.rungs.len() < 2
                || !open
                || self.parts.has(whole)
                || self.is_refused(whole)
            {
                continue;
            }
            if let Some(better) = self.with_cause(candidate)? {
                let part = better.rungs.last().map(|r| r.part);
                *self = better;
                if let Some(part) = part {
                    say(&format!("one cause for several: {}", self.parts.title(part, &self.data.robot)));
                }
                gathered = true;
            }
        }
        Ok(gathered)
    }

    /// The ladder with this candidate in it and without what it makes needless; `None` unless that is simpler and as
    /// good.
    fn with_cause(&self, candidate: usize) -> Result<Option<Self>> {
        let columns = self.candidates[candidate].columns.clone();
        let projection = Projection::new(&self.data, &self.present, columns, Ridge::None);
        let Some(score) = projection.score(&self.data, &self.present, &self.response) else {
            return Ok(None);
        };
        let mut trial = self.clone();
        let Some(part) = trial.try_add(candidate, score.alternative)? else { return Ok(None) };
        trial.refit()?;
        trial.look_back(&mut |_| {})?;
        let (now, usefulness) = trial.without(part)?;
        let Some(now) = now.filter(|s| trial.passes(trial.parts.joint(part), usefulness, s)) else {
            return Ok(None);
        };
        let spread = |ladder: &Self| ladder.rms().iter().map(|r| libm::log(r.max(1e-12))).sum::<f64>();
        let as_good = spread(&trial) <= spread(self) + WORSE * self.data.dof() as f64;
        if trial.rungs.len() + 1 >= self.rungs.len() || !as_good {
            return Ok(None);
        }
        let (before, after) = (trial.rms_without(&[part]), trial.rms());
        let also_possible = Vec::new();
        trial.rungs.push(Rung {
            part,
            score: now,
            usefulness,
            before,
            after,
            together: false,
            also_possible,
        });
        Ok(Some(trial))
    }

    /// Whether a part is plain friction that most joints have: then no joint has to need it.
    fn is_common(&self, part: usize) -> bool {
        let name = self.parts.get(part).identity.name;
        let plain = self.candidates.iter().any(|c| c.is_plain() && c.name() == name);
        let rungs = self.rungs.iter().filter(|r| self.parts.get(r.part).identity.name == name).count();
        plain && 2 * rungs > self.data.dof()
    }

    /// The model at hand without one of its parts.
    pub fn beside(&self, part: usize) -> Beside {
        let present =
            Present::with_weights(&self.data, self.parts.columns_without(&[part]), &self.present.weights);
        let response = present.respond(&self.data, self.data.tau.clone());
        Beside { present, response }
    }

    /// What a part is worth now: its score beside all the others.
    pub fn without(&self, part: usize) -> Result<(Option<Score>, f64)> {
        let score = self.beside(part).score(&self.data, vec![self.parts.own_columns(part)]);
        let usefulness = score.as_ref().map_or(0.0, |s| self.usefulness(self.parts.joint(part), s));
        Ok((score, usefulness))
    }
}
