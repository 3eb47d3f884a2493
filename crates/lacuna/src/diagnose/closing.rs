//! When a known effect does not close the case: the unknown beside it.

use super::answer::Unexplained;
use super::ladder::{Ladder, Rung, Scored};
use super::parts::{Part, upright};
use super::present::{Present, rms, square_sum};
use super::refine;
use super::score::Score;
use super::unknown::{Dependence, Proposal, Search};
use crate::effects::{Curve, Effect, Imitation, Own};
use crate::error::Result;

/// A named effect closes a case when it leaves less than this part of its joint's reducible error.
const CLOSED: f64 = 0.1;
/// Or less than this in units of the noise floor.
const SMALL: f64 = 0.3;
/// A variable must explain this part of its joint's held-out squared error, and this many times what chance does.
const LEAST_VARIABLE: f64 = 0.08;
const OVER_CHANCE: f64 = 1.5;
/// Two variables together are tried where a joint's reducible error is this many squared floors, and where one alone
/// explains less than this part of it; they must explain as much more.
const OF_TWO: f64 = 3.0;
const POOR: f64 = 0.6;
/// A joint whose squared error is this many squared floors when the search ends lacks something, whatever it follows.
const FAR: f64 = 15.0;
/// Unless it is less than this part of the joint's torque, where it follows a variable and where it follows none.
const MATTERS: f64 = 0.003;
const MATTERS_WITHOUT: f64 = 0.02;
/// Part of a formula's held-out gain on its joint that it has to have in sample.
const IN_SAMPLE: f64 = 0.5;
/// Replicates that show what chance does.
const REPLICATES: usize = 19;
/// A formula must leave less than this part of what the named effect leaves.
const CLEARLY_LESS: f64 = 0.5;

/// Structure on a joint that has no name.
#[derive(Debug, Clone)]
pub(super) struct Unknown {
    pub joint: usize,
    /// Variables it depends on.
    pub depends_on: Vec<String>,
    /// The formula's part of the model, where there is a formula.
    pub part: Option<usize>,
    pub z: f64,
    /// Part of the joint's held-out squared error that it explains.
    pub share: f64,
    /// The named effect that comes nearest, and what part of the error it leaves.
    pub nearest: Option<(String, f64)>,
    /// Error in units of the joint's noise floor, where it follows no variable.
    pub floors: Option<f64>,
}

impl Unknown {
    /// Variables without a formula.
    fn variable(joint: usize, found: &Dependence) -> Self {
        let depends_on = found.variables.clone();
        Self {
            joint,
            depends_on,
            part: None,
            z: found.score.z,
            share: found.part,
            nearest: None,
            floors: None,
        }
    }

    /// What follows no variable.
    fn without_variable(joint: usize, floors: f64) -> Self {
        let (depends_on, floors) = (Vec::new(), Some(floors));
        Self { joint, depends_on, part: None, z: 0.0, share: 0.0, nearest: None, floors }
    }
}

/// The proposal of a formula as an effect script.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Proposed {
    /// Name for its file.
    pub file: String,
    /// The script.
    pub text: String,
}

/// What may be said about an unknown.
pub(super) enum Found {
    Formula(Box<Proposal>, Option<(String, f64)>),
    Variable(Unknown),
}

impl Found {
    /// Index of its joint.
    fn joint(&self) -> usize {
        match self {
            Self::Formula(proposal, _) => proposal.joint,
            Self::Variable(unknown) => unknown.joint,
        }
    }
}

impl Ladder {
    /// Reducible squared error of each joint in units of its floor.
    pub fn excess(&self) -> Vec<f64> {
        let of = |(r, f): (&f64, &f64)| (r / f) * (r / f) - 1.0;
        let excess = self.rms().iter().zip(&self.floor.rms).map(of).collect();
        self.of_moving(excess)
    }

    /// The same numbers, none for joints that never move.
    pub fn of_moving(&self, mut of_joint: Vec<f64>) -> Vec<f64> {
        of_joint.iter_mut().zip(&self.data.still).filter(|(_, still)| **still).for_each(|(x, _)| *x = 0.0);
        of_joint
    }

    /// What is left of a joint's reducible error with a held-out effect added, in units of its floor.
    fn left_with(&self, joint: usize, score: &Score) -> f64 {
        let f = self.floor.rms[joint];
        let residual = &self.response.residual[joint];
        let left = 1.0 - score.gain_of_joint[joint] / square_sum(residual).max(1e-300);
        left * rms(residual).powi(2) / (f * f) - 1.0
    }

    /// The search for what a joint's error depends on, beside the model at hand.
    pub fn search_on(&self, joint: usize) -> Search<'_> {
        let there = |wave: Own| {
            let is_wave = |p: usize| self.parts.get(p).effect.about().special.wave == Some(wave);
            self.parts.numbers().into_iter().any(|p| self.parts.joint(p) == Some(joint) && is_wave(p))
        };
        Search {
            ripple_open: !there(Own::One),
            friction_open: !there(Own::Sign),
            data: &self.data,
            present: &self.present,
            response: &self.response,
            joint,
            width: self.parts.widths[joint],
        }
    }

    /// Looks for structure without a name on the worst joint, unless the chosen effect closes the case there.
    pub fn unknown_beside(&self, chosen: Option<&Scored>, passing: &[&Scored]) -> Result<Option<Found>> {
        let excess = self.excess();
        let Some(worst) = (0..excess.len()).max_by(|&a, &b| excess[a].total_cmp(&excess[b])) else {
            return Ok(None);
        };
        if excess[worst] < SMALL || self.closes(chosen, worst, &excess) {
            return Ok(None);
        }
        let search = self.search_on(worst);
        let groups = search.projections();
        let dependences = search.scored(&groups, &self.response);
        let own: Vec<&Scored> =
            passing.iter().copied().filter(|s| self.candidates[s.candidate].joint == Some(worst)).collect();
        let formula = search.formula(&dependences)?;
        let single =
            dependences.first().map_or(0.0, |d| d.part).max(formula.as_ref().map_or(0.0, |f| f.part));
        // Two variables together are only tried where none of them alone comes near.
        let known = self.unknown.iter().any(|u| u.joint == worst && u.part.is_none());
        let open = !known && own.is_empty() && excess[worst] >= OF_TWO && single < POOR;
        let two = if open { search.two() } else { None };
        let (z, part) = self.limits.variable;
        let two = two.filter(|d| d.score.z >= z && d.part >= part && single < POOR * d.part);
        if two.is_none()
            && let Some(proposal) = formula
            && self.formula_wins(&proposal, worst, &own)
        {
            if !self.shows_in_sample(&proposal, worst)? {
                return Ok(None);
            }
            let nearest = self.nearest(worst, &own);
            return Ok(Some(Found::Formula(Box::new(proposal), nearest)));
        }
        if known || !own.is_empty() {
            return Ok(None);
        }
        let single = dependences.first().filter(|d| {
            // The fixed bars are safe anywhere; below them chance is measured on these data, at the end only.
            let safe = d.score.z >= z && d.part >= part;
            safe || (chosen.is_none() && self.beyond_chance(d, worst, || search.chance(&groups, REPLICATES)))
        });
        Ok(two.as_ref().or(single).map(|d| Found::Variable(Unknown::variable(worst, d))))
    }

    /// Whether a variable explains clearly more than any does by chance, and enough to matter.
    fn beyond_chance(&self, found: &Dependence, joint: usize, chance: impl FnOnce() -> f64) -> bool {
        let matters = self.usefulness(Some(joint), &found.score) >= SMALL;
        let (z, without) = (self.limits.formula.0, self.limits.z_without_best);
        matters
            && found.score.z >= z
            && found.score.z_without_best >= without
            && found.part >= LEAST_VARIABLE
            && found.part >= OVER_CHANCE * chance()
    }

    /// Whether the chosen effect deals with the worst joint, and with its own.
    fn closes(&self, chosen: Option<&Scored>, worst: usize, excess: &[f64]) -> bool {
        let Some(chosen) = chosen else { return false };
        let on_worst = self.left_with(worst, &chosen.score) <= CLEARLY_LESS * excess[worst];
        let on_own = self.candidates[chosen.candidate].joint.is_none_or(|j| {
            let left = self.left_with(j, &chosen.score);
            left <= CLOSED * excess[j] || left <= SMALL
        });
        on_worst && on_own
    }

    fn formula_wins(&self, proposal: &Proposal, joint: usize, own: &[&Scored]) -> bool {
        let (z, part) = self.limits.formula;
        let score = &proposal.score;
        if score.z < z.max(self.gates.of(Some(joint)))
            || proposal.part < part
            || score.z_without_best < self.limits.z_without_best
        {
            return false;
        }
        let left = self.left_with(joint, score).max(0.0);
        own.iter().all(|named| {
            let tie = !self.clearly_better(score, &named.score);
            let left_by_named = self.left_with(joint, &named.score);
            // A drift is a curve over time as well, so of a drift and a wave the better one is taken.
            let same_kind = proposal.formula.variable == "time"
                && matches!(proposal.formula.shape, Curve::Wave { .. })
                && self.candidates[named.candidate].effect.about().is_imitated_by(Imitation::CourseOfTime);
            !tie && (same_kind || left < CLEARLY_LESS * left_by_named)
        })
    }

    /// Whether a formula explains the error of a fit to all data too. What only helps to predict held-out blocks makes up
    /// for a fit that says little where these lie.
    fn shows_in_sample(&self, proposal: &Proposal, joint: usize) -> Result<bool> {
        let effect = refine::shapes(&self.data, &self.present, proposal.formula.boxed())?;
        let left = |present: &Present| {
            let tau = &self.data.tau;
            square_sum(&present.residual_of(tau, &present.fit(tau))[joint])
        };
        let gain = left(&self.present) - left(&self.together_with(effect.as_ref())?.1);
        Ok(gain >= IN_SAMPLE * proposal.score.gain_of_joint[joint])
    }

    /// The named effect of the joint that explains most, and the part of the error it leaves.
    fn nearest(&self, joint: usize, own: &[&Scored]) -> Option<(String, f64)> {
        let best = own.iter().max_by(|a, b| a.usefulness.total_cmp(&b.usefulness))?;
        let left = self.left_with(joint, &best.score) / self.excess()[joint].max(1e-12);
        Some((self.candidates[best.candidate].name().to_string(), left.max(0.0)))
    }

    /// Adds a formula to the model, or notes a variable; answers whether anything changed.
    pub fn add_unknown(&mut self, found: Found, say: &mut dyn FnMut(&str)) -> Result<bool> {
        // A leaning base shows where the first link has its mass: that first, which has a name.
        if Some(found.joint()) == upright(&self.data)
            && self.parts.has_tilt()
            && self.parts.allow_for_lean(&self.data)?
        {
            self.refit()?;
            return Ok(true);
        }
        let (proposal, nearest) = match found {
            Found::Variable(unknown) => {
                let joint = self.data.robot.joints[unknown.joint].name.clone();
                self.limits.stop.found();
                say(&format!("unknown on {joint}, depends on {}", unknown.depends_on.join(", ")));
                self.unknown.push(unknown);
                return Ok(false);
            }
            Found::Formula(proposal, nearest) => (proposal, nearest),
        };
        let index = proposal.joint;
        let joint = self.data.robot.joints[index].name.clone();
        let before = self.rms();
        if proposal.formula.variable == "time" {
            self.retire_drifts(index)?;
        }
        let effect = refine::shapes(&self.data, &self.present, proposal.formula.boxed())?;
        let values = self.values(effect.as_ref())?;
        let part = Part::found(&self.data, effect, Some(index), &values)?;
        let part = self.parts.add(part);
        self.refit()?;
        self.limits.stop.found();
        say(&format!("unknown on {joint}, depends on {}: a formula fits", proposal.formula.variable));
        let usefulness = self.usefulness(Some(index), &proposal.score);
        self.unknown.push(Unknown {
            joint: index,
            depends_on: vec![proposal.formula.variable.clone()],
            part: Some(part),
            z: proposal.score.z,
            share: proposal.part,
            nearest,
            floors: None,
        });
        let after = self.rms();
        self.rungs.push(Rung {
            part,
            score: proposal.score,
            usefulness,
            before,
            after,
            together: false,
            also_possible: Vec::new(),
        });
        Ok(true)
    }

    /// Takes drifts of a joint away whose error follows time in another way as well: what is left of a drift beside that
    /// is a curve over time like any other, and not called a drift.
    fn retire_drifts(&mut self, joint: usize) -> Result<()> {
        let drift = |p: usize| {
            let part = self.parts.get(p);
            part.identity.joint == Some(joint) && part.effect.about().is_imitated_by(Imitation::CourseOfTime)
        };
        let drifts: Vec<usize> = self.rungs.iter().map(|r| r.part).filter(|&p| drift(p)).collect();
        for part in drifts {
            let identity = self.parts.get(part).identity.clone();
            self.dropped.extend([identity.clone(), identity]);
            self.take_out(part);
            self.refit()?;
        }
        Ok(())
    }

    /// Settles what has no name when the search ends: formulas that are gone and variables of joints that have come near
    /// their floor since are forgotten; a joint that nothing was found for and whose error is far above its floor all the
    /// same is told with the variable that it follows, or without one.
    pub fn settle_unknowns(&mut self) {
        let (live, excess) = (self.parts.numbers(), self.excess());
        self.unknown.retain(|u| match u.part {
            Some(part) => live.contains(&part),
            None => !u.depends_on.is_empty() && excess[u.joint] >= SMALL,
        });
        // What stands in both of two logs is no difference between them.
        if self.data.changed.iter().any(|changed| !changed) {
            return;
        }
        for joint in 0..self.data.dof() {
            let untold = self.unknown.iter().all(|u| u.joint != joint);
            if let Some((floors, of_torque)) = self.far_above_floor(joint).filter(|_| untold) {
                let (z, part) = self.limits.variable;
                let strongest = self.search_on(joint).dependences().into_iter().next();
                let strongest = strongest.filter(|d| d.score.z >= z && d.part >= part);
                match strongest {
                    Some(found) => self.unknown.push(Unknown::variable(joint, &found)),
                    None if of_torque >= MATTERS_WITHOUT => {
                        self.unknown.push(Unknown::without_variable(joint, floors));
                    }
                    None => {}
                }
            }
        }
    }

    /// How many times its floor a joint's error is, where that is much, and its part of the joint's torque. Rows near rest are
    /// left out: a sign that is a little too sharp or too soft leaves something there.
    fn far_above_floor(&self, joint: usize) -> Option<(f64, f64)> {
        if self.data.still[joint] || self.data.silent[joint] {
            return None;
        }
        let rows = self.response.residual[joint].iter().zip(&self.data.resting[joint]);
        let moving: Vec<f64> = rows.filter(|(_, resting)| !**resting).map(|(r, _)| *r).collect();
        let floors = rms(&moving) / self.floor.rms[joint];
        let of_torque = rms(&moving) / rms(&self.data.tau[joint]).max(1e-12);
        (floors * floors >= FAR && of_torque >= MATTERS).then_some((floors, of_torque))
    }

    /// Whether something is said of a joint that has no name.
    pub fn is_told(&self, joint: usize) -> bool {
        let live = self.parts.numbers();
        self.unknown.iter().any(|u| u.joint == joint && u.part.is_none_or(|p| live.contains(&p)))
    }

    /// Structure without a name that is left, each with the script of its formula, where there is one.
    pub fn unexplained(&self) -> Vec<(Unexplained, Option<Proposed>)> {
        let robot = &self.data.robot;
        let live = self.parts.numbers();
        let mut all: Vec<(Unexplained, Option<Proposed>)> = Vec::new();
        for u in self.unknown.iter().filter(|u| u.part.is_none_or(|p| live.contains(&p))) {
            let joint = robot.joints[u.joint].name.clone();
            let rank = all.iter().filter(|(other, script)| other.joint == joint && script.is_some()).count();
            let told = Unexplained {
                depends_on: u.depends_on.clone(),
                formula: u.part.and_then(|part| self.written(part)),
                script: None,
                z: u.z,
                gain_percent: 100.0 * u.share,
                floors: u.floors,
                nearest: u
                    .nearest
                    .as_ref()
                    .map(|(name, left)| format!("{name}, leaves {:.0} %", 100.0 * left)),
                joint,
            };
            all.push((told, u.part.and_then(|part| self.proposed(part, u.joint, rank))));
        }
        all
    }

    fn proposed(&self, part: usize, joint: usize, rank: usize) -> Option<Proposed> {
        let x = self.present.fit(&self.data.tau);
        let effect = &self.parts.get(part).effect;
        let formula = effect.formula()?;
        let text = formula.script(rank, &formula.written(&self.data.robot, &x[self.parts.place(part)]));
        let plain = |c: char| if c.is_ascii_alphanumeric() || c == '_' || c == '-' { c } else { '_' };
        let name: String = self.data.robot.joints[joint].name.chars().map(plain).collect();
        let number = if rank == 0 { String::new() } else { format!("_{}", rank + 1) };
        Some(Proposed { file: format!("unknown_{name}{number}.rhai"), text })
    }

    /// What a formula of the model says, with its numbers.
    pub fn written(&self, part: usize) -> Option<String> {
        let x = self.present.fit(&self.data.tau);
        let values = &x[self.parts.place(part)];
        Some(self.parts.get(part).effect.formula()?.written(&self.data.robot, values))
    }
}
