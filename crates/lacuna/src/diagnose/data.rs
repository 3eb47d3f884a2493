//! The rows that a diagnosis works on: every joint's torque and any effect's columns, through one filter.

use std::ops::Range;

use super::pieces::{Piece, Queue};
use crate::effects::{Columns, Effect, Stretch};
use crate::error::{Error, Result};
use crate::kernels::Chain;
use crate::robot::{JointKind, Robot};
use crate::signals::{Folds, Rows, Run, extremes};

/// Slower than this a joint is about to turn round, or nearly rests.
const SLOW: Limit = Limit { rad: 0.02, m: 0.02 };
/// Part of a row's filter window at rest from which on the row counts as resting.
const TOUCHED: f64 = 0.1;
/// A joint that travels less does not move: what is seen is noise.
const STILL: Limit = Limit { rad: 2e-3, m: 2e-3 };

/// A limit on positions or speeds, by the kind of joint.
struct Limit {
    /// Of revolute joints \[rad\], or [rad/s] of speeds.
    rad: f64,
    /// Of prismatic joints \[m\], or [m/s] of speeds.
    m: f64,
}

impl Limit {
    fn of(&self, robot: &Robot, joint: usize) -> f64 {
        match robot.joints[joint].kind {
            JointKind::Revolute => self.rad,
            JointKind::Prismatic => self.m,
        }
    }
}

/// One linear parameter's torque per unit: the rows of every joint it reaches.
#[derive(Debug, Clone, Default)]
pub(super) struct Column {
    /// `(joint, rows)`, ascending by joint; rows of all runs one after the other.
    pub parts: Vec<(usize, Vec<f64>)>,
    /// Whether it acts between two times only, so that the fold in which these lie cannot be predicted by the others.
    pub in_interval: bool,
}

impl Column {
    /// Of one joint.
    pub fn of(joint: usize, rows: Vec<f64>) -> Self {
        Self { parts: vec![(joint, rows)], in_interval: false }
    }

    /// Rows of `joint`, where the column reaches it.
    pub fn part(&self, joint: usize) -> Option<&[f64]> {
        self.parts.iter().find(|(j, _)| *j == joint).map(|(_, rows)| rows.as_slice())
    }

    /// Sets the rows outside `keep` to zero.
    fn keep_only(&mut self, keep: &[Range<usize>]) {
        for (_, rows) in &mut self.parts {
            for (k, value) in rows.iter_mut().enumerate() {
                if !keep.iter().any(|range| range.contains(&k)) {
                    *value = 0.0;
                }
            }
        }
    }
}

/// Prepared logs with their folds.
#[derive(Debug, Clone)]
pub(super) struct Data {
    pub robot: Robot,
    pub chain: Chain,
    pub runs: Vec<Run>,
    /// Where the rows of each run lie in time.
    pub rows: Vec<Rows>,
    /// What is computed of each run at once.
    pieces: Vec<Vec<Piece>>,
    pub folds: Folds,
    /// Rows of each fold, as contiguous ranges.
    pub fold_ranges: Vec<Vec<Range<usize>>>,
    /// Torque rows of each joint; those that are left out are zero.
    pub tau: Vec<Vec<f64>>,
    /// Rows of each joint that are not left out.
    pub counted: Vec<f64>,
    /// Runs in which candidates exist; the others are the reference (two-log mode).
    pub changed: Vec<bool>,
    /// Joints that never move.
    pub still: Vec<bool>,
    /// Joints whose torque is no measurement: zero throughout.
    pub silent: Vec<bool>,
    /// Rows in which a joint nearly rests: there the smoothing of signs says what friction is.
    pub resting: Vec<Vec<bool>>,
}

impl Data {
    pub fn new(robot: &Robot, runs: Vec<Run>, folds: Folds) -> Result<Self> {
        let rows: Vec<Rows> = runs.iter().map(Run::rows).collect();
        let joined = |joint: usize| -> Vec<f64> {
            let of = |run: &Run| {
                let mut rows = run.to_rows(&run.tau[joint]).into_owned();
                run.leave_out(joint, 0, &mut rows);
                rows
            };
            runs.iter().flat_map(of).collect()
        };
        if let Some(run) = runs.iter().find(|run| run.tau.is_empty()) {
            return Err(Error::new(format!("{}: the log has no torque to explain", run.name))
                .help("log tau1..taun, or map currents to torque with a column map"));
        }
        let tau: Vec<Vec<f64>> = (0..robot.dof()).map(joined).collect();
        let travel = |q: &[f64]| {
            let (low, high) = extremes(q);
            high - low
        };
        let rests = |joint: usize| {
            let least = STILL.of(robot, joint);
            runs.iter().all(|run| travel(&run.q[joint]) < least)
        };
        let still = (0..robot.dof()).map(rests).collect();
        let silent = tau.iter().map(|rows| rows.iter().all(|x| x.abs() <= 0.0)).collect();
        let left_out = |run: &Run, joint: usize| {
            let unusable = run.unusable.get(joint).filter(|_| run.leaves_out);
            unusable.map_or(0, |s| s.iter().filter(|out| **out).count())
        };
        let all: usize = rows.iter().map(|r| r.count).sum();
        let counted = |joint| all - runs.iter().map(|run| left_out(run, joint)).sum::<usize>();
        let counted = (0..robot.dof()).map(|joint| counted(joint).max(1) as f64).collect();
        let fold_ranges = (0..folds.count).map(|fold| ranges_of(&folds.fold, fold)).collect();
        let changed = vec![true; runs.len()];
        let mut data = Self {
            robot: robot.clone(),
            chain: Chain::new(robot),
            pieces: runs.iter().map(Piece::of).collect(),
            runs,
            rows,
            folds,
            fold_ranges,
            tau,
            counted,
            changed,
            still,
            silent,
            resting: Vec::new(),
        };
        data.resting = (0..robot.dof()).map(|joint| data.at_rest(joint)).collect();
        Ok(data)
    }

    /// Rows in which a joint nearly rests.
    fn at_rest(&self, joint: usize) -> Vec<bool> {
        let slow = SLOW.of(&self.robot, joint);
        let rows = self.rows_of(|run, out| {
            for (y, v) in out.iter_mut().zip(run.friction_dq(joint)) {
                *y = if v.abs() < slow { 1.0 } else { 0.0 };
            }
        });
        rows.into_iter().map(|part| part > TOUCHED).collect()
    }

    /// Number of joints.
    pub fn dof(&self) -> usize {
        self.robot.dof()
    }

    /// Rows of one joint, all runs together.
    pub fn count(&self) -> usize {
        self.rows.iter().map(|r| r.count).sum()
    }

    /// The rows of each run.
    pub fn run_ranges(&self) -> Vec<Range<usize>> {
        let mut next = 0;
        self.rows
            .iter()
            .map(|r| {
                let first = next;
                next += r.count;
                first..next
            })
            .collect()
    }

    /// Number of the whole second that each row lies in, counted over all runs.
    pub fn seconds(&self) -> Vec<usize> {
        let (mut all, mut first) = (Vec::new(), 0);
        for rows in &self.rows {
            let per = per_second(rows);
            all.extend((0..rows.count).map(|k| first + k / per));
            first += rows.count.div_ceil(per);
        }
        all
    }

    /// What is still to be done is done to its end, whoever stops the work.
    pub fn work_on(&mut self) {
        self.runs.iter_mut().for_each(|run| run.stop = run.stop.to_the_end());
    }

    /// Columns of an effect.
    pub fn columns(&self, effect: &dyn Effect) -> Result<Vec<Column>> {
        self.columns_of(effect, None)
    }

    /// Columns of some terms of an effect; those of the others stay empty.
    pub fn columns_of(&self, effect: &dyn Effect, wanted: Option<&[usize]>) -> Result<Vec<Column>> {
        Ok(self.lowered(&[effect], wanted)?.pop().unwrap_or_default())
    }

    /// Columns of several effects, filtered side by side.
    pub fn columns_of_each(&self, effects: &[&dyn Effect]) -> Result<Vec<Vec<Column>>> {
        self.lowered(effects, None)
    }

    fn lowered(&self, effects: &[&dyn Effect], wanted: Option<&[usize]>) -> Result<Vec<Vec<Column>>> {
        let empty = |effect: &&dyn Effect| -> Result<Vec<Column>> {
            let column = |(number, mut joints): (usize, Vec<usize>)| {
                if wanted.is_some_and(|w| !w.contains(&number)) {
                    joints.clear();
                }
                joints.sort_unstable();
                let parts = joints.into_iter().map(|j| (j, Vec::with_capacity(self.count()))).collect();
                Column { parts, in_interval: effect.interval().is_some() }
            };
            let terms = effect.terms(&self.robot)?;
            Ok(terms.into_iter().map(|term| term.joints).enumerate().map(column).collect())
        };
        let mut columns: Vec<Vec<Column>> = effects.iter().map(empty).collect::<Result<_>>()?;
        let mut done = 0;
        for (run, pieces) in self.runs.iter().zip(&self.pieces) {
            let (mut scratch, mut first) = (None, 0);
            for piece in pieces {
                run.stop.check()?;
                let range = piece.samples.clone();
                let at = Stretch { robot: &self.robot, chain: &self.chain, run, range };
                let mut queue = Queue::new(run, piece);
                for (number, effect) in effects.iter().enumerate() {
                    let mut wanted = |term: usize, joint: usize, fill: &mut dyn FnMut(&mut [f64])| {
                        let parts = &columns[number][term].parts;
                        let Some(place) = parts.iter().position(|(j, _)| *j == joint) else { return };
                        queue.push((number, term, place), fill, &mut columns);
                    };
                    effect.columns(&at, &mut Columns { wanted: &mut wanted, scratch: &mut scratch })?;
                }
                queue.let_through(&mut columns);
                done += piece.rows;
                // What an effect says nothing of is zero, and so are rows that are left out.
                for (joint, y) in columns.iter_mut().flatten().flat_map(|c| &mut c.parts) {
                    y.resize(done, 0.0);
                    run.leave_out(*joint, first, &mut y[done - piece.rows..]);
                }
                first += piece.rows;
            }
        }
        Ok(columns)
    }

    /// Columns of an effect that exists only in the runs where something changed.
    pub fn candidate_columns(&self, effect: &dyn Effect) -> Result<Vec<Column>> {
        Ok(self.candidate_columns_of_each(&[effect])?.pop().unwrap_or_default())
    }

    /// The same of several effects.
    pub fn candidate_columns_of_each(&self, effects: &[&dyn Effect]) -> Result<Vec<Vec<Column>>> {
        let mut columns = self.columns_of_each(effects)?;
        if self.changed.iter().any(|c| !c) {
            let keep: Vec<Range<usize>> = self
                .run_ranges()
                .into_iter()
                .zip(&self.changed)
                .filter_map(|(range, changed)| changed.then_some(range))
                .collect();
            columns.iter_mut().flatten().for_each(|column| column.keep_only(&keep));
        }
        Ok(columns)
    }

    /// A column of one joint that a function fills at every sample of each run.
    pub fn column_of(&self, joint: usize, fill: impl Fn(&Run, &mut [f64])) -> Column {
        let mut rows = self.rows_of(fill);
        for (run, range) in self.runs.iter().zip(self.run_ranges()) {
            run.leave_out(joint, 0, &mut rows[range]);
        }
        Column::of(joint, rows)
    }

    /// Rows of a column that a function fills at every sample of each run.
    pub fn rows_of(&self, fill: impl Fn(&Run, &mut [f64])) -> Vec<f64> {
        let mut all = Vec::with_capacity(self.count());
        for run in &self.runs {
            let mut column = vec![0.0; run.samples()];
            fill(run, &mut column);
            all.extend_from_slice(&run.to_rows(&column));
        }
        all
    }

    /// The same rows of a quantity that needs no filter (position, time, a channel).
    pub fn picked<'a>(&'a self, of: impl Fn(&'a Run) -> Option<&'a [f64]>) -> Option<Vec<f64>> {
        let mut all = Vec::with_capacity(self.count());
        for run in &self.runs {
            let column = of(run)?;
            match &run.row_filter {
                None => all.extend_from_slice(column),
                Some(rows) => all.extend(rows.pick(column)),
            }
        }
        Some(all)
    }
}

/// Rows per second, at least one.
pub(super) fn per_second(rows: &Rows) -> usize {
    (libm::round(1.0 / rows.dt) as usize).max(1)
}

fn ranges_of(fold: &[u16], wanted: u16) -> Vec<Range<usize>> {
    let mut ranges = Vec::new();
    let mut from = None;
    for k in 0..=fold.len() {
        let inside = k < fold.len() && fold[k] == wanted;
        match (inside, from) {
            (true, None) => from = Some(k),
            (false, Some(start)) => {
                ranges.push(start..k);
                from = None;
            }
            _ => {}
        }
    }
    ranges
}
