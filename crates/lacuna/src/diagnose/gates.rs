//! From which z on something is believed, calibrated on the very data that are diagnosed.

use rayon::prelude::*;

use super::Limits;
use super::candidates::Candidate;
use super::ladder::Ladder;
use super::present::square_sum;
use super::score::Score;
use crate::effects::Imitation;
use crate::random::Stream;

/// Most that rows at rest may bring of the gain of a joint's delay, unless it takes at least so much of the joint's
/// held-out squared error: what is late by its Coulomb friction mostly shows where that turns round.
const OF_A_DELAY: f64 = 0.5;
const MOST_OF_A_JOINT: f64 = 0.5;
/// And of anything else, unless it passes its threshold this many times.
const MOST_AT_REST: f64 = 0.75;
const BEYOND_DOUBT: f64 = 1.4;
/// Part of the replicates that a threshold lies above.
const QUANTILE: f64 = 0.95;

/// Thresholds of z: one for what acts on each joint, and one for what acts on the whole robot. Structure that is
/// left on one joint makes chance agreements likely there, and says nothing about the others.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Gates {
    joints: Vec<f64>,
    whole: f64,
    /// How high sign flips of these data reach anywhere.
    pub flips: f64,
}

impl Gates {
    /// Before anything is calibrated.
    pub fn new(joints: usize, limits: &Limits) -> Self {
        Self { joints: vec![limits.least_z; joints], whole: limits.least_z, flips: 0.0 }
    }

    /// Least z on this joint, or for the whole robot.
    pub fn of(&self, joint: Option<usize>) -> f64 {
        joint.map_or(self.whole, |j| self.joints[j])
    }

    /// The lowest and the highest of them.
    pub fn range(&self) -> (f64, f64) {
        self.joints.iter().fold((self.whole, self.whole), |(a, b), g| (a.min(*g), b.max(*g)))
    }
}

impl Ladder {
    /// Whether the score of something on a joint, or on the whole robot, is believed.
    pub fn passes(&self, joint: Option<usize>, usefulness: f64, score: &Score) -> bool {
        score.z >= self.gates.of(joint) && self.worthwhile(usefulness, score)
    }

    /// The largest part of a joint's held-out squared error that a score removes.
    fn part_of_joint(&self, score: &Score) -> f64 {
        let part = |(gain, r): (&f64, &Vec<f64>)| gain / square_sum(r).max(1e-300);
        score.gain_of_joint.iter().zip(&self.response.residual).map(part).fold(0.0, f64::max)
    }

    /// Whether what acts on one joint, or a delay of all of them, shows elsewhere than where joints turn round or rest:
    /// there a sign a little too sharp, too soft, early or late says the same.
    pub fn beyond_reversals(&self, candidate: &Candidate, score: &Score) -> bool {
        let delay = candidate.effect.about().is_imitated_by(Imitation::Clock);
        if candidate.joint.is_none() && !delay {
            return true;
        }
        let beyond_doubt = score.z >= BEYOND_DOUBT * self.gates.of(candidate.joint);
        if candidate.joint.is_some() && delay {
            return score.at_rest <= OF_A_DELAY
                || (beyond_doubt && self.part_of_joint(score) >= MOST_OF_A_JOINT);
        }
        score.at_rest <= MOST_AT_REST || beyond_doubt
    }

    /// Everything that is asked of a score beside its significance.
    pub fn worthwhile(&self, usefulness: f64, score: &Score) -> bool {
        score.share >= self.limits.least_share
            && self.part_of_joint(score) >= self.limits.least_of_joint
            && usefulness >= self.limits.least_usefulness
            && score.z_without_best >= self.limits.z_without_best
            && (score.in_one_second <= self.limits.most_in_one_second
                || score.z_without_best >= self.limits.least_z)
    }

    /// Calibrates the thresholds: present residuals with random signs have nothing to find, and what is found in
    /// them all the same is chance. Signs change every second, joint by joint.
    pub fn calibrate(&mut self, seed: u64, say: &mut dyn FnMut(&str)) {
        say("calibrating the threshold by sign flips");
        let projections = self.projections();
        let seconds = self.data.seconds();
        let replicate = |number: usize| -> Vec<f64> {
            let mut stream = Stream::new(seed ^ 0x7369_676e, number);
            let flipped = self.response.residual.iter().map(|r| flipped(r, &seconds, &mut stream)).collect();
            let response = self.present.respond(&self.data, flipped);
            let mut highest = vec![0.0_f64; self.data.dof() + 1];
            for (candidate, projection) in self.candidates.iter().zip(&projections) {
                let Some(score) =
                    projection.as_ref().and_then(|p| p.score(&self.data, &self.present, &response))
                else {
                    continue;
                };
                if self.worthwhile(self.usefulness(candidate.joint, &score), &score) {
                    let group = &mut highest[candidate.joint.unwrap_or(self.data.dof())];
                    *group = group.max(score.z);
                }
            }
            highest
        };
        let found: Vec<Vec<f64>> = (0..self.limits.sign_flips).into_par_iter().map(replicate).collect();
        let reached = |group: usize| quantile(found.iter().map(|f| f[group]).collect());
        let clamped = |z: f64| z.clamp(self.limits.least_z, self.limits.most_z.max(self.limits.least_z));
        let dof = self.data.dof();
        self.gates = Gates {
            joints: (0..dof).map(|j| clamped(reached(j))).collect(),
            whole: clamped(reached(dof)),
            flips: quantile(found.iter().map(|f| f.iter().copied().fold(0.0, f64::max)).collect()),
        };
    }
}

/// A residual with a random sign in every second.
pub(super) fn flipped(residual: &[f64], seconds: &[usize], stream: &mut Stream) -> Vec<f64> {
    let count = seconds.last().copied().unwrap_or(0) + 1;
    let signs: Vec<f64> = (0..count).map(|_| if stream.uniform() < 0.5 { -1.0 } else { 1.0 }).collect();
    residual.iter().zip(seconds).map(|(r, &s)| r * signs[s]).collect()
}

fn quantile(mut values: Vec<f64>) -> f64 {
    values.sort_by(f64::total_cmp);
    let place = (QUANTILE * values.len() as f64) as usize;
    values.get(place.min(values.len().saturating_sub(1))).copied().unwrap_or(0.0)
}
