//! The robot's own sample clock, rebuilt from positions and logged velocities.
//!
//! A reader that polls a robot stamps rows when it *reads* them; the state in them belongs to the last
//! tick of the robot's clock. How many ticks lie between two rows follows from the motion itself: the
//! least-squares solution of `diff(q) = n h mean(dq)` over all joints. Where the robot moves this is a
//! whole number up to a few per cent, and the stamps are not needed. Where it hardly moves, the stamps
//! decide, held against how late they were while it moved.

use super::clock::{Motion, snap};
use super::median;

/// Steps whose standard error is below this many ticks are sure.
const SURE: f64 = 0.15;
/// Steps up to this length have a prior of their own.
const LENGTHS: usize = 12;
/// Share by which the usual lateness of the stamps follows the present one, row by row.
const FOLLOW: f64 = 0.02;

/// A rebuilt clock.
pub(super) struct Rebuilt {
    /// Tick length \[s\].
    pub period: f64,
    /// Rows it keeps.
    pub rows: Vec<usize>,
    /// Tick of each of them, from 0.
    pub at: Vec<f64>,
    /// Rows left out because their position was older than their velocity.
    pub torn: usize,
    /// Root mean square of `diff(q) / diff(t) - dq` on this clock.
    pub mismatch: f64,
    /// Whether it stays near the stamps to the end.
    pub keeps_up: bool,
}

/// Time between two rows by the motion and by the stamps.
struct Step {
    /// By the motion \[s\].
    elapsed: f64,
    /// Standard error of that \[s\].
    error: f64,
    /// By the stamps \[s\].
    stamps: f64,
}

/// Rebuilds the clock; `None` where the motion does not show one.
pub(super) fn rebuild(motion: &Motion) -> Option<Rebuilt> {
    let stamped: Vec<f64> = motion.rows.windows(2).map(|w| motion.t[w[1]] - motion.t[w[0]]).collect();
    let usual = median(stamped)?;
    let first = steps(motion, motion.rows, &weights(motion, motion.rows, |_| usual)?);
    let tick = tick_length(&first, usual)?;
    let rows = without_torn(motion.rows, &first, tick);
    let torn = motion.rows.len() - rows.len();

    // The noise was judged with equal steps; with the steps now known it comes out smaller.
    let rough = count(&steps(motion, &rows, &weights(motion, &rows, |_| usual)?), tick);
    let steps = steps(motion, &rows, &weights(motion, &rows, |i| rough[i] * tick)?);
    let period = period(&steps, &count(&steps, tick), tick);
    let mut at = vec![0.0];
    at.extend(count(&steps, period).iter().scan(0.0, |tick, n| {
        *tick += n;
        Some(*tick)
    }));
    let mismatch = Motion { rows: &rows, ..*motion }.mismatch(&at, period);
    let stamped = motion.t[*rows.last()?] - motion.t[rows[0]];
    let keeps_up = (at[at.len() - 1] * period - stamped).abs() <= 0.1 + 0.005 * stamped;
    Some(Rebuilt { period, at, torn, mismatch, keeps_up, rows })
}

/// Inverse variances of a step of each joint, `elapsed(i)` being the time of step `i`; zero for joints
/// that do not move above their noise.
fn weights(motion: &Motion, rows: &[usize], elapsed: impl Fn(usize) -> f64) -> Option<Vec<f64>> {
    let usual = median((1..rows.len()).map(|i| elapsed(i - 1)).collect())?;
    let weight = |(q, dq): (&Vec<f64>, &Vec<f64>)| {
        let error =
            |(i, w): (usize, &[usize])| (q[w[1]] - q[w[0]] - 0.5 * (dq[w[0]] + dq[w[1]]) * elapsed(i)).abs();
        let noise = 1.4826 * median(rows.windows(2).enumerate().map(error).collect())?;
        let power = rows.iter().map(|&k| dq[k] * dq[k]).sum::<f64>() / rows.len() as f64;
        let moves = libm::sqrt(power) * usual;
        let noise = noise.max(1e-9 * moves);
        Some(if moves > 3.0 * noise { 1.0 / (noise * noise) } else { 0.0 })
    };
    motion.q.iter().zip(motion.dq).map(weight).collect()
}

fn steps(motion: &Motion, rows: &[usize], weights: &[f64]) -> Vec<Step> {
    let step = |w: &[usize]| {
        let (mut cross, mut square) = (0.0, 0.0);
        for ((q, dq), weight) in motion.q.iter().zip(motion.dq).zip(weights) {
            let velocity = 0.5 * (dq[w[0]] + dq[w[1]]);
            cross += weight * velocity * (q[w[1]] - q[w[0]]);
            square += weight * velocity * velocity;
        }
        let square = square.max(1e-12);
        let stamps = motion.t[w[1]] - motion.t[w[0]];
        Step { elapsed: cross / square, error: 1.0 / libm::sqrt(square), stamps }
    };
    rows.windows(2).map(step).collect()
}

/// The commonest step of the moving robot, refined by all sure steps as multiples of it.
fn tick_length(steps: &[Step], usual: f64) -> Option<f64> {
    let moving: Vec<f64> = steps.iter().filter(|s| s.error < SURE * usual).map(|s| s.elapsed).collect();
    if moving.len() < 100 || 4 * moving.len() < steps.len() {
        return None;
    }
    let mut tick = median(moving.clone()).filter(|&h| h > 0.0)?;
    for _ in 0..3 {
        let (mut cross, mut square) = (0.0, 0.0);
        for elapsed in &moving {
            let n = libm::round(elapsed / tick);
            cross += n * elapsed;
            square += n * n;
        }
        tick = cross / square.max(1.0);
    }
    (tick > 0.0).then_some(tick)
}

/// Leaves out rows whose position stood still although the robot moves: they were read while they
/// were written.
fn without_torn(rows: &[usize], steps: &[Step], tick: f64) -> Vec<usize> {
    let torn = |s: &Step| s.error < SURE * tick && s.elapsed < 0.4 * tick;
    let later = rows[1..].iter().zip(steps).filter(|(_, s)| !torn(s)).map(|(&row, _)| row);
    std::iter::once(rows[0]).chain(later).collect()
}

/// The nominal period next to the tick of the motion; where there is none, the mean tick by the stamps
/// if both tell the same story (logged velocities may be off by a gain).
fn period(steps: &[Step], counts: &[f64], tick: f64) -> f64 {
    let nominal = snap(tick, 5e-4);
    if (nominal - tick).abs() > 0.0 {
        return nominal;
    }
    let mean = steps.iter().map(|s| s.stamps).sum::<f64>() / counts.iter().sum::<f64>();
    if (mean - tick).abs() < 0.01 * tick { mean } else { tick }
}

/// Ticks of each step.
fn count(steps: &[Step], tick: f64) -> Vec<f64> {
    let tracker = Tracker::new(steps, tick);
    let mut counts = vec![0.0; steps.len()];
    // The start is counted backwards, from where the lateness of the stamps is known.
    let start = steps.iter().position(|s| s.error < SURE * tick).unwrap_or(0);
    let settled = (start + 200).min(steps.len());
    tracker.follow(0.0, steps[..settled].iter().zip(&mut counts).rev());
    tracker.follow(0.0, steps[start..].iter().zip(&mut counts[start..]));
    counts
}

/// Counts ticks step by step: sure steps by the motion alone, others by motion, stamps and experience.
struct Tracker {
    tick: f64,
    /// Scatter of the stamps \[ticks\].
    scatter: f64,
    /// Minus twice the logarithm of how often each number of ticks occurs among the sure steps.
    rarity: [f64; LENGTHS],
}

impl Tracker {
    fn new(steps: &[Step], tick: f64) -> Self {
        let mut seen = [0.5; LENGTHS];
        let mut late = Vec::new();
        for step in steps.iter().filter(|s| s.error < SURE * tick) {
            let n = libm::round(step.elapsed / tick).max(1.0);
            seen[LENGTHS.min(n as usize) - 1] += 1.0;
            late.push((step.stamps / tick - n).abs());
        }
        let total: f64 = seen.iter().sum();
        let scatter = (1.4826 * median(late).unwrap_or(1.0)).max(0.2);
        Self { tick, scatter, rarity: seen.map(|n| -2.0 * libm::log(n / total)) }
    }

    /// Counts the steps in turn, `late` being how much later than usual the last stamp was \[ticks\].
    fn follow<'a>(&self, mut late: f64, steps: impl Iterator<Item = (&'a Step, &'a mut f64)>) {
        for (step, count) in steps {
            let expected = late + step.stamps / self.tick;
            *count = self.likeliest(step, expected);
            late = (expected - *count) * (1.0 - FOLLOW);
        }
    }

    fn likeliest(&self, step: &Step, expected: f64) -> f64 {
        let nearest = libm::round(step.elapsed / self.tick).max(1.0);
        if step.error < SURE * self.tick {
            return nearest;
        }
        let cost = |n: f64| {
            let by_motion = (n * self.tick - step.elapsed) / step.error;
            let by_stamps = (n - expected) / self.scatter;
            by_motion * by_motion + by_stamps * by_stamps + self.rarity[LENGTHS.min(n as usize) - 1]
        };
        let by_stamps = libm::round(expected).max(1.0);
        let numbers = (1..=LENGTHS).map(|n| n as f64).chain([nearest, by_stamps]);
        numbers.min_by(|&a, &b| cost(a).total_cmp(&cost(b))).unwrap_or(nearest)
    }
}
