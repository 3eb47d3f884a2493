//! Adding what was chosen: refined, unless its numbers cannot be physics or stand for something else.

use std::sync::Arc;

use super::data::Column;
use super::doubts;
use super::ladder::{Addition, Ladder, Refusal, Rung};
use super::parts::{Part, upright};
use super::present::Present;
use super::refine;
use crate::effects::{AtRest, Effect, Variable};
use crate::error::Result;

/// A wave over the first joint with fewer periods per turn than this may be a leaning base's doing.
const LONG: f64 = 2.0;

/// Why what looks like a spring on the first joint is none beside a leaning base.
const OF_A_LEAN: &str = "where the first link has its mass, which a leaning base shows, looks the same";

impl Ladder {
    /// Takes a part out of the model, with what was refused because of it; nothing is fitted again.
    pub fn take_out(&mut self, part: usize) {
        self.rungs.retain(|r| r.part != part);
        self.parts.remove(part);
        if !self.parts.has_tilt() {
            self.refused.retain(|r| r.reason != OF_A_LEAN);
        }
    }

    pub(super) fn add_all(&mut self, steps: Vec<Addition>, say: &mut dyn FnMut(&str)) -> Result<()> {
        let before = self.rms();
        let mut added = Vec::new();
        for step in steps {
            if let Some(part) = self.try_add(step.candidate, step.alternative)? {
                added.push((part, step));
            }
        }
        if added.is_empty() {
            return Ok(());
        }
        self.refit()?;
        let after = self.rms();
        let together = added.len() > 1;
        self.limits.stop.found();
        for (part, step) in added {
            say(&format!("found {}", self.parts.title(part, &self.data.robot)));
            let (before, after) = (before.clone(), after.clone());
            let Addition { score, usefulness, also: also_possible, .. } = step;
            self.rungs.push(Rung { part, score, usefulness, before, after, together, also_possible });
        }
        Ok(())
    }

    /// Refines a candidate and adds it, unless its numbers cannot be physics.
    pub fn try_add(&mut self, candidate: usize, alternative: usize) -> Result<Option<usize>> {
        let chosen = &self.candidates[candidate];
        let (identity, joint) = (chosen.identity.clone(), chosen.joint);
        let start = chosen.alternatives[alternative].clone();
        let effect = refine::shapes(&self.data, &self.present, start)?;
        let values = self.values(effect.as_ref())?;
        let reason = (effect.undecidable(&self.data.robot, &self.data.runs))
            .or_else(|| effect.implausible(&self.data.robot, &values))
            .or_else(|| doubts::of_the_clock(effect.as_ref(), &values, &self.data));
        let reason = match reason {
            None => self.of_a_lean(effect.as_ref(), joint)?,
            some => some,
        };
        if let Some(reason) = reason {
            self.refused.push(Refusal { identity, reason });
            return Ok(None);
        }
        let part = Part::found(&self.data, effect, joint, &values)?;
        Ok(Some(self.parts.add(part)))
    }

    /// Why an effect on the first joint stands for something else: a leaning base shows where the first link has its
    /// mass, which nothing else does. From then on the model allows for that.
    fn of_a_lean(&mut self, effect: &dyn Effect, joint: Option<usize>) -> Result<Option<String>> {
        if joint.is_none() || joint != upright(&self.data) || !self.parts.has_tilt() {
            return Ok(None);
        }
        let about = effect.about();
        let follows_position = about.drawn_against == Variable::Position && about.at_rest == AtRest::Smooth;
        let alike = follows_position && effect.shapes().first().is_none_or(|k| k.value < LONG);
        if alike && self.parts.allow_for_lean(&self.data)? {
            self.refit()?;
        }
        Ok(alike.then(|| OF_A_LEAN.to_string()))
    }

    /// Linear parameters of `effect` fitted to all data together with the model at hand.
    pub fn values(&self, effect: &dyn Effect) -> Result<Vec<f64>> {
        let (count, together) = self.together_with(effect)?;
        Ok(together.fit(&self.data.tau)[..count].to_vec())
    }

    /// Number of columns of `effect`, and the model at hand with these before its own.
    pub fn together_with(&self, effect: &dyn Effect) -> Result<(usize, Present)> {
        let own: Vec<Arc<Column>> = self.data.candidate_columns(effect)?.into_iter().map(Arc::new).collect();
        let count = own.len();
        let mut columns = self.parts.columns();
        columns.columns.splice(0..0, own);
        Ok((count, Present::with_weights(&self.data, columns, &self.present.weights)))
    }
}
