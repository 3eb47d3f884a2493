//! The climb: name the effect that explains most in unseen data, add it, fit everything again, until nothing
//! significant is left; then look back whether all of it is still needed.

use rayon::prelude::*;

use super::candidates::{self, Candidate, Identity};
use super::closing::Unknown;
use super::data::Data;
use super::floor::Floor;
use super::gates::Gates;
use super::parts::{Part, Parts};
use super::present::{Present, Response, rms};
use super::score::{Projection, Ridge, Score};
use super::{Limits, events, refine};
use crate::effects::Effect;
use crate::error::Result;
use crate::report::pictures::Ranked;

/// An effect that was no longer needed this often is not tried again.
const RETURNS: usize = 2;

/// One effect that was added, with what it brought.
#[derive(Debug, Clone)]
pub(super) struct Rung {
    /// Number of the part it became.
    pub part: usize,
    /// Score at the time it was added.
    pub score: Score,
    /// Gain in units of the noise floor, per sample.
    pub usefulness: f64,
    /// Held-out rms of each joint before and after.
    pub before: Vec<f64>,
    pub after: Vec<f64>,
    /// Whether others came in at the same time.
    pub together: bool,
    /// Candidates that the data cannot tell from this one.
    pub also_possible: Vec<usize>,
}

/// Something that fits but cannot be.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Refusal {
    pub identity: Identity,
    pub reason: String,
}

/// The state of the climb.
#[derive(Clone)]
pub(super) struct Ladder {
    pub data: Data,
    pub parts: Parts,
    pub limits: Limits,
    pub floor: Floor,
    /// Least z of anything that is believed.
    pub gates: Gates,
    pub candidates: Vec<Candidate>,
    pub present: Present,
    pub response: Response,
    pub rungs: Vec<Rung>,
    pub refused: Vec<Refusal>,
    /// What was found and no longer needed later, as often as that happened.
    pub dropped: Vec<Identity>,
    /// Structure without a name.
    pub unknown: Vec<Unknown>,
    /// Parts that act in an interval only.
    pub events: Vec<usize>,
    /// Largest z at the last look of what shows only where joints turn round.
    pub at_reversals: f64,
    /// Largest z of anything at the last look, with what it belongs to.
    pub best_left: f64,
    /// What every candidate would bring beside the starting model, for the picture of the ranking.
    pub ranking: Vec<Ranked>,
}

/// A candidate that is about to be added.
pub(super) struct Addition {
    pub candidate: usize,
    pub alternative: usize,
    pub score: Score,
    pub usefulness: f64,
    pub also: Vec<usize>,
}

/// A candidate with its score.
pub(super) struct Scored {
    pub candidate: usize,
    pub score: Score,
    /// Gain in units of the noise floor, per sample: on its own joint, or summed.
    pub usefulness: f64,
}

impl Ladder {
    /// Held-out rms of each joint now.
    pub fn rms(&self) -> Vec<f64> {
        self.response.residual.iter().map(|r| rms(r)).collect()
    }

    /// The same parts, fitted to other data.
    pub fn on(&self, data: Data) -> Result<Self> {
        let mut parts = self.parts.clone();
        let mut data = data;
        if parts.need_torque() {
            for (new, old) in data.runs.iter_mut().zip(&self.data.runs) {
                new.model.clone_from(&old.model);
            }
        }
        parts.rebuild(&data, false)?;
        let mut again = Self {
            data,
            parts,
            limits: self.limits.clone(),
            floor: self.floor.clone(),
            gates: self.gates.clone(),
            candidates: Vec::new(),
            present: self.present.clone(),
            response: self.response.clone(),
            rungs: self.rungs.clone(),
            refused: Vec::new(),
            dropped: Vec::new(),
            unknown: Vec::new(),
            events: self.events.clone(),
            at_reversals: 0.0,
            best_left: 0.0,
            ranking: Vec::new(),
        };
        again.refit()?;
        Ok(again)
    }

    /// Goes on with the same data prepared in another way: what was found is fitted again, its nonlinear parameters
    /// too, and whatever was refused may be tried again.
    pub fn move_to(&mut self, data: Data) -> Result<()> {
        let moved = self.on(data)?;
        (self.data, self.parts, self.present, self.response) =
            (moved.data, moved.parts, moved.present, moved.response);
        self.refused.clear();
        self.unknown.retain(|u| u.part.is_some());
        for part in self.rungs.iter().map(|r| r.part).collect::<Vec<_>>() {
            let present =
                Present::with_weights(&self.data, self.parts.columns_without(&[part]), &self.present.weights);
            let effect = refine::shapes(&self.data, &present, self.parts.get(part).effect.clone())?;
            self.parts.replace(part, &self.data, effect)?;
        }
        self.refit()?;
        candidates::fill(&mut self.candidates, &self.data, false)?;
        self.refresh_candidates()
    }

    /// Held-out rms of each joint when some parts are left out.
    pub fn rms_without(&self, parts: &[usize]) -> Vec<f64> {
        let present = Present::new(&self.data, self.parts.columns_without(parts));
        let response = present.respond(&self.data, self.data.tau.clone());
        response.residual.iter().map(|r| rms(r)).collect()
    }

    /// Fits the parts as they are now; effects that depend on the model's torque are rebuilt with it.
    pub fn refit(&mut self) -> Result<()> {
        let rounds = if self.parts.need_torque() { 3 } else { 1 };
        for round in 0..rounds {
            self.present = Present::new(&self.data, self.parts.columns());
            if round + 1 < rounds {
                self.refresh_torque()?;
                self.parts.rebuild(&self.data, true)?;
            }
        }
        self.response = self.present.respond(&self.data, self.data.tau.clone());
        Ok(())
    }

    /// Puts the torque of the model at hand into the runs.
    pub fn refresh_torque(&mut self) -> Result<()> {
        let x = self.present.fit(&self.data.tau);
        let (model, values) = self.parts.model(&self.data.robot, &x)?;
        crate::identify::refresh_model_torque(&model, &values, &mut self.data.runs)
    }

    /// Columns of the candidates that depend on the model's torque, from the model at hand.
    pub fn refresh_candidates(&mut self) -> Result<()> {
        self.refresh_torque()?;
        candidates::fill(&mut self.candidates, &self.data, true)?;
        Ok(())
    }

    /// Looks for a contact before anything else: held-out blocks cannot see what lies inside one of them.
    pub fn look_for_contact(&mut self, say: &mut dyn FnMut(&str)) -> Result<()> {
        if !self.events.is_empty() {
            return Ok(());
        }
        say("looking for contacts");
        let Some(contact) = events::contact(&self.data, &self.present, &self.floor)? else { return Ok(()) };
        self.limits.stop.found();
        say(&format!("contact from {:.2} s to {:.2} s", contact.effect.from_s, contact.effect.to_s));
        let before = self.rms();
        let part = Part::found(&self.data, contact.effect.boxed(), None, &contact.force)?;
        let part = self.parts.add(part);
        self.refit()?;
        let after = self.rms();
        let n = &self.data.counted;
        let gained = |j: usize| (before[j] * before[j] - after[j] * after[j]) * n[j];
        let gain_of_joint: Vec<f64> = (0..self.data.dof()).map(gained).collect();
        let mut score = Score::of_gain(gain_of_joint, contact.f.sqrt());
        let square: f64 = before.iter().zip(n).map(|(r, n)| r * r * n).sum();
        score.share = score.gain_of_joint.iter().sum::<f64>() / square.max(1e-300);
        let usefulness = self.usefulness(None, &score);
        self.events.push(part);
        self.rungs.push(Rung {
            part,
            score,
            usefulness,
            before,
            after,
            together: false,
            also_possible: Vec::new(),
        });
        Ok(())
    }

    pub fn projections(&self) -> Vec<Option<Projection>> {
        self.candidates
            .par_iter()
            .map(|candidate| {
                if candidate.columns.is_empty() || self.parts.has(candidate) || self.is_refused(candidate) {
                    return None;
                }
                Some(Projection::new(&self.data, &self.present, candidate.columns.clone(), Ridge::None))
            })
            .collect()
    }

    /// Scores everything that is not yet part of the model, best first.
    pub(super) fn scan(&self) -> Vec<Scored> {
        let mut all: Vec<Scored> = self
            .projections()
            .par_iter()
            .enumerate()
            .filter_map(|(candidate, projection)| {
                let mut score = projection.as_ref()?.score(&self.data, &self.present, &self.response)?;
                let own = &self.candidates[candidate];
                let usefulness = self.usefulness(own.joint, &score);
                // Rows of what cannot be chosen are compared with nothing; those of a long log fill the memory.
                if !own.is_plain() && !self.passes(own.joint, usefulness, &score) {
                    score.effect = Vec::new();
                }
                Some(Scored { candidate, score, usefulness })
            })
            .collect();
        all.sort_by(|a, b| b.usefulness.total_cmp(&a.usefulness));
        all
    }

    /// Gain in units of the noise floor, per sample: on the candidate's own joint, or over all joints.
    pub fn usefulness(&self, joint: Option<usize>, score: &Score) -> f64 {
        let n = &self.data.counted;
        let of = |j: usize| score.gain_of_joint[j] / (self.floor.rms[j] * self.floor.rms[j] * n[j]);
        joint.map_or_else(|| (0..self.data.dof()).map(of).sum(), of)
    }

    /// Whether a candidate cannot be, or came and went before.
    pub fn is_refused(&self, candidate: &Candidate) -> bool {
        self.refused.iter().any(|r| r.identity == candidate.identity)
            || self.dropped.iter().filter(|d| **d == candidate.identity).count() >= RETURNS
    }

    /// Adds what explains most until nothing passes, or the limit of steps is reached.
    pub fn climb(&mut self, say: &mut dyn FnMut(&str)) -> Result<()> {
        while self.rungs.len() < self.limits.steps && !self.limits.stop.asked() {
            let before = (self.parts.clone(), self.present.clone(), self.response.clone());
            let known = (self.rungs.len(), self.unknown.clone());
            match self.step(say) {
                Ok(true) => {}
                Ok(false) => return Ok(()),
                // A step that was cut short leaves no trace.
                Err(_) if self.limits.stop.asked() => {
                    (self.parts, self.present, self.response) = before;
                    self.rungs.truncate(known.0);
                    self.unknown = known.1;
                }
                Err(error) => return Err(error),
            }
        }
        Ok(())
    }

    /// Adds what explains most; whether there was something.
    fn step(&mut self, say: &mut dyn FnMut(&str)) -> Result<bool> {
        self.refresh_candidates()?;
        let scored = self.scan();
        self.note_ranking(&scored);
        self.note_left(&scored);
        let passes = |s: &&Scored| {
            let candidate = &self.candidates[s.candidate];
            self.passes(candidate.joint, s.usefulness, &s.score) && self.beyond_reversals(candidate, &s.score)
        };
        let passing: Vec<&Scored> = scored.iter().filter(passes).collect();
        let chosen = match (self.one_for_all(&passing), passing.first()) {
            (Some(whole), _) => Some(whole),
            (None, Some(best)) => Some(self.likeliest_tie(best, &passing)?),
            (None, None) => None,
        };
        // Plain friction first: while that is missing, everything else looks strange.
        let plain = passing.iter().any(|s| self.candidates[s.candidate].is_plain());
        if !plain
            && let Some(unknown) = self.unknown_beside(chosen, &passing)?
            && self.add_unknown(unknown, say)?
        {
            return Ok(true);
        }
        let Some(chosen) = chosen else { return Ok(false) };
        let first = (chosen, self.also_possible(chosen, &passing));
        let others = self.family(chosen, &passing, &scored).into_iter().map(|s| (s, Vec::new()));
        let steps: Vec<Addition> = std::iter::once(first)
            .chain(others)
            .map(|(s, also)| Addition {
                candidate: s.candidate,
                alternative: s.score.alternative,
                score: s.score.clone(),
                usefulness: s.usefulness,
                also,
            })
            .collect();
        self.add_all(steps, say)?;
        Ok(true)
    }

    /// Notes how significant what is left at most is.
    fn note_left(&mut self, scored: &[Scored]) {
        let worthwhile = scored.iter().filter(|s| self.worthwhile(s.usefulness, &s.score));
        let (mut anywhere, mut turning) = (0.0_f64, 0.0_f64);
        for s in worthwhile {
            let beyond = self.beyond_reversals(&self.candidates[s.candidate], &s.score);
            let most = if beyond { &mut anywhere } else { &mut turning };
            *most = most.max(s.score.z);
        }
        (self.best_left, self.at_reversals) = (anywhere, turning);
    }
}
