//! Choosing among explanations that the data cannot tell apart.

use super::ladder::{Ladder, Scored};
use super::present::Response;
use super::score::{Score, long_run_variance};
use crate::effects::Effect;
use crate::error::Result;

/// The same effect is added on other joints at once when it is at least this useful beside the first.
const FAMILY: f64 = 0.1;

/// One cause for the whole robot comes first when it explains this part of what the best explanation does.
const ONE_FOR_ALL: f64 = 0.85;
/// And when no joint has more than this part of what it explains.
const SPREAD: f64 = 0.8;

impl Ladder {
    /// A cause that acts on the whole robot and explains about as much of the weighted error as anything on one joint:
    /// what looks like a spring here and a gain there is one tilted base.
    pub fn one_for_all<'s>(&self, passing: &[&'s Scored]) -> Option<&'s Scored> {
        let share = |s: &&&Scored| s.score.share;
        let largest = passing.iter().map(|s| s.score.share).fold(0.0, f64::max);
        let whole = |s: &&&Scored| {
            let weighted = |(gain, w): (&f64, &f64)| gain * w * w;
            let gains = s.score.gain_of_joint.iter().zip(&self.present.weights).map(weighted);
            let most = gains.fold(0.0, f64::max);
            self.candidates[s.candidate].identity.joint.is_none()
                && s.score.share >= ONE_FOR_ALL * largest
                && most <= SPREAD * s.score.gain
        };
        passing.iter().filter(whole).max_by(|a, b| share(a).total_cmp(&share(b))).copied()
    }

    /// The simplest of the explanations that are as good as the best one on the same joint.
    pub fn simplest_tie<'s>(&self, best: &'s Scored, passing: &[&'s Scored]) -> &'s Scored {
        let mut chosen = best;
        for other in passing {
            let simpler = self.candidates[other.candidate].order < self.candidates[chosen.candidate].order;
            if simpler && self.ties(best, other) {
                chosen = other;
            }
        }
        chosen
    }

    /// The simplest of the explanations that are as good as the best one, if possible one whose numbers are not odd for
    /// what it is.
    pub fn likeliest_tie<'s>(&self, best: &'s Scored, passing: &[&'s Scored]) -> Result<&'s Scored> {
        let simplest = self.simplest_tie(best, passing);
        if !self.is_odd(simplest)? {
            return Ok(simplest);
        }
        let mut ties: Vec<&Scored> = passing.iter().copied().filter(|s| self.ties(best, s)).collect();
        ties.sort_by_key(|s| self.candidates[s.candidate].order);
        for tie in ties {
            if !self.is_odd(tie)? {
                return Ok(tie);
            }
        }
        Ok(simplest)
    }

    /// The effect of a candidate with the numbers that it would get.
    fn numbers_of(&self, scored: &Scored) -> Result<(&dyn Effect, Vec<f64>)> {
        let effect = self.candidates[scored.candidate].alternatives[scored.score.alternative].as_ref();
        Ok((effect, self.values(effect)?))
    }

    /// Whether the numbers that a candidate would get are odd for what it is, or impossible.
    fn is_odd(&self, scored: &Scored) -> Result<bool> {
        let (effect, values) = self.numbers_of(scored)?;
        let robot = &self.data.robot;
        Ok(effect.odd(robot, &values).or_else(|| effect.implausible(robot, &values)).is_some())
    }

    /// Whether the numbers that a candidate would get cannot be.
    fn is_impossible(&self, scored: &Scored) -> bool {
        self.numbers_of(scored)
            .is_ok_and(|(effect, values)| effect.implausible(&self.data.robot, &values).is_some())
    }

    /// Whether data cannot tell `other` from `best`: same joint, nearly the gain, and a difference of
    /// losses within two standard errors (Diebold and Mariano 1995).
    pub fn ties(&self, best: &Scored, other: &Scored) -> bool {
        self.candidates[best.candidate].joint == self.candidates[other.candidate].joint
            && self.as_good(&best.score, &other.score, &self.response)
    }

    /// Whether the second of two explanations of a response gains nearly what the first does.
    fn as_good(&self, best: &Score, other: &Score, response: &Response) -> bool {
        other.gain >= self.limits.tie_gain * best.gain && !self.better_in(response, best, other)
    }

    /// Whether the losses of one explanation are lower than another's by more than two standard errors.
    pub fn clearly_better(&self, one: &Score, other: &Score) -> bool {
        self.better_in(&self.response, one, other)
    }

    fn better_in(&self, response: &Response, one: &Score, other: &Score) -> bool {
        let mut difference = vec![0.0; self.data.count()];
        for (joint, residual) in response.residual.iter().enumerate() {
            let w = self.present.weights[joint] * self.present.weights[joint];
            let (a, b) = (&one.effect[joint], &other.effect[joint]);
            for (k, d) in difference.iter_mut().enumerate() {
                let (ra, rb) = (residual[k] - a[k], residual[k] - b[k]);
                *d += w * (rb * rb - ra * ra);
            }
        }
        let mean: f64 = difference.iter().sum::<f64>() / difference.len() as f64;
        let centred: Vec<f64> = difference.iter().map(|d| d - mean).collect();
        let deviation = long_run_variance(&self.data, &centred).sqrt();
        difference.iter().sum::<f64>() > 2.0 * deviation
    }

    /// Explanations that tie with the chosen one as the model stands.
    pub fn also_possible(&self, chosen: &Scored, passing: &[&Scored]) -> Vec<usize> {
        let others = passing.iter().filter(|s| s.candidate != chosen.candidate);
        let tied = others.filter(|s| self.ties(chosen, s) || self.ties(s, chosen));
        tied.filter(|s| !self.is_impossible(s)).map(|s| s.candidate).collect()
    }

    /// What tied with each finding when it was found and still does, now that all the others are in the model: much that
    /// looks alike in a poor model does not in a good one.
    pub fn settle_ties(&mut self) {
        for place in 0..self.rungs.len() {
            let rung = &self.rungs[place];
            if rung.also_possible.is_empty() {
                continue;
            }
            let beside = self.beside(rung.part);
            let Some(own) = beside.score(&self.data, vec![self.parts.own_columns(rung.part)]) else {
                continue;
            };
            let ties = |&other: &usize| {
                let columns = self.candidates[other].columns.clone();
                let score = beside.score(&self.data, columns);
                score.is_some_and(|s| self.as_good(&own, &s, &beside.response))
            };
            self.rungs[place].also_possible = rung.also_possible.iter().copied().filter(ties).collect();
        }
    }

    /// The same effect on other joints, where it is the best explanation there. Plain friction that shows on half of
    /// the joints is what all of them have: nobody leaves it out on the others.
    pub fn family<'s>(
        &self,
        chosen: &Scored,
        passing: &[&'s Scored],
        scored: &'s [Scored],
    ) -> Vec<&'s Scored> {
        let own = &self.candidates[chosen.candidate];
        let Some(own_joint) = own.joint else { return Vec::new() };
        let same = |s: &&Scored| {
            let other = &self.candidates[s.candidate];
            other.name() == own.name() && other.joint.is_some_and(|j| j != own_joint)
        };
        if own.is_plain() && 2 * (1 + passing.iter().copied().filter(same).count()) >= self.data.dof() {
            return scored.iter().filter(same).collect();
        }
        let best_of =
            |joint: usize| passing.iter().find(|s| self.candidates[s.candidate].joint == Some(joint));
        (0..self.data.dof())
            .filter(|&j| j != own_joint)
            .filter_map(best_of)
            .map(|best| self.simplest_tie(best, passing))
            .filter(|s| self.candidates[s.candidate].name() == own.name())
            .filter(|s| s.usefulness >= FAMILY * chosen.usefulness)
            .collect()
    }
}
