//! The search for the reading of a log that its robot explains best.

use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use nalgebra::Vector3;
use rayon::prelude::*;

use super::case::{Case, held_out};
use super::reading::{Change, Reading};
use crate::effects::classic;
use crate::error::Result;
use crate::model::Model;
use crate::robot::Robot;
use crate::signals::{Folds, Run};

/// A step of the search must lower the objective by this much (a factor of 0.85 in the error).
const WORTHWHILE: f64 = 0.16;
/// Readings this close to the best cannot be told from it.
const TIE: f64 = 0.1;
/// Steps at most.
const MOST_STEPS: usize = 6;
/// Robots with more joints are not searched for exchanged ones: pairs grow with the square.
const MOST_SWAPPED: usize = 12;

/// What is searched on.
pub(super) struct Ground<'a> {
    pub robot: &'a Robot,
    /// The same table read in the other Denavit-Hartenberg convention.
    pub other: Option<&'a Robot>,
    /// The recorded motion, as it stands.
    pub run: &'a Run,
    pub folds: &'a Folds,
    /// Whether angles may still be in degrees.
    pub degrees_open: bool,
    /// The search comes back to the same readings.
    pub memo: Mutex<Memo>,
}

/// What was computed already. It saves time and changes no result.
#[derive(Default)]
pub(super) struct Memo {
    /// Models by gravity and convention; base parameters are dear.
    models: Vec<(Vector3<f64>, bool, Arc<Model>)>,
    /// Readings one change away from a reading, scored.
    neighbours: Vec<(Reading, Vec<Scored>)>,
}

/// How well a reading is explained.
#[derive(Debug, Clone)]
pub(super) struct Scored {
    pub reading: Reading,
    /// What was changed last to get here.
    pub change: Option<Change>,
    /// Relative error of the classical model, refitted.
    pub error: f64,
    /// The same, friction that drives the motion counted as error.
    pub physical: f64,
    /// Relative error of the robot file's own inertias.
    pub given: Option<f64>,
}

impl Scored {
    /// What the search makes small: both errors count, the file's own model half and never beyond a constant's.
    pub fn objective(&self) -> f64 {
        let given = self.given.unwrap_or(1.0).clamp(0.02, 1.0);
        libm::log(self.physical.max(1e-5)) + 0.5 * libm::log(given)
    }

    /// Whether this explains so much more than `before` that nobody can doubt it.
    pub fn decisive(&self, before: &Scored) -> bool {
        let refit = self.physical < 0.72 * before.physical && self.physical < 0.7;
        let given = match (self.given, before.given) {
            (Some(after), Some(before)) => (after < 0.5 * before && after < 0.5, after < 1.3 * before),
            _ => (false, true),
        };
        (refit && given.1) || (given.0 && self.physical < 1.1 * before.physical)
    }
}

/// What the search found.
pub(super) struct Found {
    pub as_is: Scored,
    pub best: Scored,
    /// The steps from one to the other.
    pub steps: Vec<Change>,
}

impl Ground<'_> {
    fn memo(&self) -> MutexGuard<'_, Memo> {
        self.memo.lock().unwrap_or_else(PoisonError::into_inner)
    }

    fn model(&self, reading: &Reading) -> Result<(Arc<Model>, Option<Vec<f64>>)> {
        let robot = match (reading.other_convention, self.other) {
            (true, Some(other)) => other,
            _ => self.robot,
        };
        let given = robot.links.iter().any(|l| l.inertia.is_some());
        let given = given.then(|| robot.inertial_parameters_or_zero());
        let (gravity, other) = (reading.gravity, reading.other_convention);
        let known = self.memo().models.iter().find(|m| m.0 == gravity && m.1 == other).map(|m| m.2.clone());
        if let Some(model) = known {
            return Ok((model, given));
        }
        let model = Arc::new(Model::new(&robot.clone().with_gravity(gravity), classic())?);
        self.memo().models.push((gravity, other, model.clone()));
        Ok((model, given))
    }

    /// Fits one reading.
    pub fn case(&self, reading: &Reading) -> Result<(Case, Arc<Model>, Run)> {
        let (model, given) = self.model(reading)?;
        let run = reading.apply(self.run, self.robot);
        Ok((Case::new(&model, &run, given.as_deref())?, model, run))
    }

    /// Scores one reading.
    pub fn score(&self, reading: Reading, change: Option<Change>) -> Result<Scored> {
        let (case, ..) = self.case(&reading)?;
        Ok(scored(&case, reading, change))
    }

    /// Held-out relative error of one reading.
    pub fn held_out(&self, reading: &Reading) -> Result<f64> {
        let (model, _) = self.model(reading)?;
        held_out(&model, &reading.apply(self.run, self.robot), self.folds)
    }

    /// From the log as it is to the reading that explains it best, step by step; then every step has to
    /// show that it is needed.
    pub fn search(&self) -> Result<Found> {
        let as_is = self.score(Reading::as_is(self.robot), None)?;
        let (mut best, mut steps) = (as_is.clone(), Vec::new());
        for _ in 0..MOST_STEPS {
            let Some(next) = simplest_of_best(self.neighbours(&best.reading)?) else { break };
            if next.objective() > best.objective() - WORTHWHILE {
                break;
            }
            let next = self.refined(next)?;
            match next.change.clone() {
                Some(Change::FlipTorques(joints)) if joints.len() < self.robot.dof() => {
                    steps.extend(joints.into_iter().map(|j| Change::FlipTorques(vec![j])));
                }
                change => steps.extend(change),
            }
            best = next;
        }
        self.without_idle_steps(&as_is, &mut best, &mut steps)?;
        Ok(Found { as_is, best, steps })
    }

    /// The reading after `steps`.
    pub fn after<'s>(&self, steps: impl IntoIterator<Item = &'s Change>) -> Reading {
        steps.into_iter().fold(Reading::as_is(self.robot), |reading, step| reading.with(step))
    }

    fn without_idle_steps(&self, as_is: &Scored, best: &mut Scored, steps: &mut Vec<Change>) -> Result<()> {
        let mut i = 0;
        while i < steps.len() {
            let others = steps.iter().enumerate().filter(|(k, _)| *k != i).map(|(_, step)| step);
            let without = self.score(self.after(others), None)?;
            if without.objective() < best.objective() + WORTHWHILE {
                steps.remove(i);
                *best = without;
                i = 0;
            } else {
                i += 1;
            }
        }
        if steps.is_empty() {
            *best = as_is.clone();
        }
        Ok(())
    }

    /// Changes that explain as much as `step` does where the other `steps` are made.
    pub fn as_good_as(&self, step: &Change, steps: &[Change], best: &Scored) -> Result<Vec<Change>> {
        let base = self.after(steps.iter().filter(|s| *s != step));
        let near = |s: &Scored| s.objective() < best.objective() + TIE;
        let all = self.neighbours(&base)?.into_iter().filter(near).filter_map(|s| s.change);
        Ok(all
            .filter(|c| c != step && self.after(steps.iter().filter(|s| *s != step)).with(c) != best.reading)
            .collect())
    }

    /// Changes that the data do not speak for or against: the best reading with them is as good.
    pub fn undecided(&self, best: &Scored) -> Result<Vec<Change>> {
        let near = |s: &Scored| s.objective() < best.objective() + TIE;
        Ok(self.neighbours(&best.reading)?.into_iter().filter(near).filter_map(|s| s.change).collect())
    }

    /// Every reading one change away.
    fn neighbours(&self, from: &Reading) -> Result<Vec<Scored>> {
        if let Some((_, known)) = self.memo().neighbours.iter().find(|(reading, _)| reading == from) {
            return Ok(known.clone());
        }
        let parts: Vec<Vec<Scored>> = self
            .changes(from)
            .into_par_iter()
            .map(|change| match change {
                None => self.torque_signs(from),
                Some(Change::FlipPosition(j)) => self.position_signs(from, j),
                Some(change) => Ok(vec![self.score(from.with(&change), Some(change))?]),
            })
            .collect::<Result<_>>()?;
        let all: Vec<Scored> = parts.into_iter().flatten().collect();
        self.memo().neighbours.push((from.clone(), all.clone()));
        Ok(all)
    }

    /// The signs of torques that explain most, under the common sign that physics allows.
    fn torque_signs(&self, from: &Reading) -> Result<Vec<Scored>> {
        let (case, model, run) = self.case(from)?;
        let mut signs = case.best_signs();
        let negative = |signs: &[f64]| signs.iter().filter(|s| **s < 0.0).count();
        let sense = case.orientation(&model, &run, &signs);
        let few = sense.abs() < 0.34 && 2 * negative(&signs) > signs.len();
        if sense <= -0.34 || few {
            signs.iter_mut().for_each(|s| *s = -*s);
        }
        let joints: Vec<usize> = (0..signs.len()).filter(|&j| signs[j] < 0.0).collect();
        if joints.is_empty() {
            return Ok(Vec::new());
        }
        let mut all = vec![joints.clone()];
        if joints.len() > 1 && joints.len() < signs.len() {
            all.extend(joints.into_iter().map(|j| vec![j]));
        }
        let one = |joints: Vec<usize>| {
            let change = Change::FlipTorques(joints);
            self.score(from.with(&change), Some(change))
        };
        all.into_iter().map(one).collect()
    }

    /// Position of joint `j` with the other sign, its torque as it is or with it.
    fn position_signs(&self, from: &Reading, j: usize) -> Result<Vec<Scored>> {
        let position = Change::FlipPosition(j);
        let (case, ..) = self.case(&from.with(&position))?;
        let mut signs = vec![1.0; from.torque.len()];
        let alone = scored(&case, from.with(&position), Some(position));
        signs[j] = -1.0;
        let joint = Change::FlipJoint(j);
        let both = Scored {
            reading: from.with(&joint),
            change: Some(joint),
            error: case.error(&signs),
            physical: case.physical_error(&signs),
            given: case.given_error(&signs),
        };
        Ok(vec![alone, both])
    }

    /// What may be changed; `None` stands for the signs of the torques.
    fn changes(&self, from: &Reading) -> Vec<Option<Change>> {
        let n = self.robot.dof();
        let mut all = vec![None];
        if self.degrees_open && !from.degrees {
            all.push(Some(Change::Degrees));
        }
        all.extend((0..n).map(|j| Some(Change::FlipPosition(j))));
        if n > 2 {
            all.extend([Change::ReverseJoints, Change::ReversePositions, Change::ReverseTorques].map(Some));
        }
        if n <= MOST_SWAPPED {
            for (a, b) in (0..n).flat_map(|a| (a + 1..n).map(move |b| (a, b))) {
                let swaps =
                    [Change::SwapJoints(a, b), Change::SwapPositions(a, b), Change::SwapTorques(a, b)];
                all.extend(swaps.map(Some));
            }
        }
        if from.gravity.norm() > 0.0 {
            all.extend(directions(&from.gravity).into_iter().map(|g| Some(Change::Gravity(g))));
            all.push(Some(Change::NoGravity));
        }
        if self.other.is_some() && !from.other_convention {
            all.push(Some(Change::Convention));
        }
        all
    }

    /// A new direction of gravity, made more precise.
    fn refined(&self, mut best: Scored) -> Result<Scored> {
        if !matches!(best.change, Some(Change::Gravity(_))) {
            return Ok(best);
        }
        let coarse = best.clone();
        for degrees in [20.0, 10.0, 5.0, 2.0, 1.0_f64] {
            for _ in 0..5 {
                let near = tilted(&best.reading.gravity, degrees);
                let all: Vec<Scored> = near
                    .into_par_iter()
                    .map(|g| {
                        let change = Change::Gravity(g);
                        self.score(best.reading.with(&change), Some(change))
                    })
                    .collect::<Result<_>>()?;
                match all.into_iter().min_by(by_objective).filter(|s| s.objective() < best.objective()) {
                    Some(better) => best = better,
                    None => break,
                }
            }
        }
        // Robots are mostly mounted squarely: a direction next to the axis is the axis.
        Ok(if coarse.objective() < best.objective() + TIE { coarse } else { best })
    }
}

fn scored(case: &Case, reading: Reading, change: Option<Change>) -> Scored {
    let signs = vec![1.0; reading.torque.len()];
    let (error, physical) = (case.error(&signs), case.physical_error(&signs));
    Scored { error, physical, given: case.given_error(&signs), reading, change }
}

/// The best; of several as good, the one that is most likely to happen to somebody.
fn simplest_of_best(all: Vec<Scored>) -> Option<Scored> {
    let least = all.iter().map(Scored::objective).fold(f64::INFINITY, f64::min);
    let rank = |scored: &Scored| match &scored.change {
        Some(Change::FlipTorques(joints)) => 1 + joints.len(),
        Some(Change::FlipPosition(_)) => 100,
        Some(Change::FlipJoint(_)) => 300,
        Some(Change::SwapJoints(..) | Change::SwapPositions(..) | Change::SwapTorques(..)) => 200,
        _ => 0,
    };
    let near = all.into_iter().filter(|s| s.objective() <= least + 0.02);
    near.min_by(|a, b| rank(a).cmp(&rank(b)).then_with(|| by_objective(a, b)))
}

fn by_objective(a: &Scored, b: &Scored) -> std::cmp::Ordering {
    a.objective().total_cmp(&b.objective())
}

/// Gravity along the other axes, and tilted a little.
fn directions(gravity: &Vector3<f64>) -> Vec<Vector3<f64>> {
    let (size, now) = (gravity.norm(), gravity.normalize());
    let axes = [Vector3::x(), Vector3::y(), Vector3::z()].into_iter().flat_map(|a| [a, -a]);
    let mut all: Vec<Vector3<f64>> = axes.filter(|a| a.dot(&now) < 0.999).map(|a| a * size).collect();
    all.extend(tilted(gravity, 8.0));
    all.extend(tilted(gravity, 30.0));
    all
}

/// Gravity turned by an angle in four directions.
fn tilted(gravity: &Vector3<f64>, degrees: f64) -> [Vector3<f64>; 4] {
    let now = gravity.normalize();
    let least = if now.x.abs() < 0.6 { Vector3::x() } else { Vector3::y() };
    let side = now.cross(&least).normalize();
    let other = now.cross(&side);
    let (sin, cos) = libm::sincos(degrees.to_radians());
    [side, -side, other, -other].map(|to| (now * cos + to * sin) * gravity.norm())
}
