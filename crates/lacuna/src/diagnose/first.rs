//! Where most of the reducible error is, and why: what an answer opens with.

use super::answer::First;
use super::present::rms;
use super::score::Score;
use super::telling::Telling;
use crate::effects::RigidBody;

/// A cause must explain this part of the worst joint's reducible error.
const CAUSE: f64 = 0.25;

impl Telling<'_> {
    /// Where most of the reducible error is, and why. A joint that nothing is said of does not come first: how much of
    /// its error could be explained nobody knows, since most floors are lower bounds.
    pub fn first(&self) -> Option<First> {
        let excess = self.excess();
        let total: f64 = excess.iter().sum();
        let causes: Vec<Option<String>> = (0..excess.len()).map(|j| self.cause(j, excess[j])).collect();
        let worst_of =
            |joints: &mut dyn Iterator<Item = usize>| joints.max_by(|&a, &b| excess[a].total_cmp(&excess[b]));
        let answered = |&j: &usize| causes[j].is_some() || self.ladder.is_told(j);
        let worst =
            worst_of(&mut (0..excess.len()).filter(answered)).or_else(|| worst_of(&mut (0..excess.len())))?;
        Some(First {
            joint: self.name(worst),
            share_of_reducible_percent: 100.0 * excess[worst] / total.max(1e-300),
            cause: causes[worst].clone().unwrap_or_else(|| "unknown".to_string()),
        })
    }

    /// The effect that explains most of a joint's reducible error, where it explains enough of it.
    fn cause(&self, joint: usize, excess: f64) -> Option<String> {
        let floor = self.ladder.floor.rms[joint];
        let n = self.ladder.data.counted[joint];
        let of = |score: &Score| score.gain_of_joint[joint] / (floor * floor * n);
        let found =
            self.ladder.rungs.iter().filter(|r| self.ladder.parts.joint(r.part).is_none_or(|j| j == joint));
        let found = found.map(|rung| {
            let name = self.ladder.parts.get(rung.part).effect.about().name;
            ((!self.is_formula(rung.part)).then(|| name.to_string()), of(&rung.score))
        });
        let refit = self.base.missing(self.ladder, &self.x).and(self.base.refit.as_ref());
        let refit = refit.map(|r| (Some(RigidBody::ABOUT.name.to_string()), of(&r.score)));
        // What the user added explains a part of the same error.
        let added = self.added_most(joint).map(|(name, part)| (Some(name.to_string()), part));
        let all = found.chain(refit).chain(added).filter(|(_, part)| *part >= CAUSE * excess);
        all.max_by(|a, b| a.1.total_cmp(&b.1)).and_then(|(name, _)| name)
    }

    /// The effect that the user added which took most of the squared error of a joint, in units of its noise floor.
    fn added_most(&self, joint: usize) -> Option<(&str, f64)> {
        let floor = self.ladder.floor.rms[joint];
        let mut before = rms(&self.base.residual[joint]);
        let parts = self.added.iter().map(|added| {
            let gain = before * before - added.rms[joint] * added.rms[joint];
            before = added.rms[joint];
            (added.name.as_str(), gain / (floor * floor))
        });
        parts.max_by(|a, b| a.1.total_cmp(&b.1))
    }
}
