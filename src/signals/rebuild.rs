//! The robot's own sample clock, rebuilt from positions and logged velocities.
//!
//! A reader that polls a robot stamps rows when it *reads* them; the state in them belongs to the last
//! tick of the robot's clock. How many ticks lie between two rows follows from the motion itself: the
//! least-squares solution of `diff(q) = n h mean(dq)` over all joints. Where the robot moves this is a
//! whole number up to a few per cent. Where it hardly moves, the steps seen elsewhere are the prior,
//! and the stamps bound the sum.

use super::clock::{Motion, snap};
use super::median;

/// Steps whose standard error is below this many ticks are sure.
const SURE: f64 = 0.15;
/// Steps up to this length have a prior of their own.
const LENGTHS: usize = 12;
/// Over a stretch of unsure steps the clock may leave the stamps by this much [s]: nothing in the
/// motion decides there, and stamps of a buffered link wander by as much.
const LEEWAY: f64 = 0.025;

/// A rebuilt clock.
pub(super) struct Rebuilt {
    /// Tick length [s].
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
    /// By the motion [s].
    elapsed: f64,
    /// Standard error of that [s].
    error: f64,
    /// By the stamps [s].
    stamps: f64,
}

/// Rebuilds the clock; `None` where the motion does not show one.
pub(super) fn rebuild(motion: &Motion) -> Option<Rebuilt> {
    let weights = weights(motion)?;
    let first = steps(motion, motion.rows, &weights);
    let tick = tick_length(&first)?;
    let rows = without_torn(motion.rows, &first, tick);
    let torn = motion.rows.len() - rows.len();
    let steps = steps(motion, &rows, &weights);
    let period = snap(by_stamps(motion, &rows, &count(&steps, tick), tick));
    let counts = count(&steps, period);
    let mut at = Vec::with_capacity(rows.len());
    at.push(0.0);
    for n in &counts {
        at.push(at[at.len() - 1] + n);
    }
    let motion = Motion { rows: &rows, ..*motion };
    let mismatch = motion.mismatch(&at, period);
    let stamped = motion.t[*rows.last()?] - motion.t[rows[0]];
    let drift = (at[at.len() - 1] * period - stamped).abs();
    let keeps_up = drift <= 0.1 + 0.005 * stamped;
    Some(Rebuilt { period, at, torn, mismatch, keeps_up, rows })
}

/// Inverse variances of a step of each joint; zero for joints that do not move above their noise.
fn weights(motion: &Motion) -> Option<Vec<f64>> {
    let dt = median(motion.rows.windows(2).map(|w| motion.t[w[1]] - motion.t[w[0]]).collect())?;
    let weight = |(q, dq): (&Vec<f64>, &Vec<f64>)| {
        let error = |w: &[usize]| (q[w[1]] - q[w[0]] - 0.5 * (dq[w[0]] + dq[w[1]]) * dt).abs();
        let noise = 1.4826 * median(motion.rows.windows(2).map(error).collect())?;
        let power = motion.rows.iter().map(|&k| dq[k] * dq[k]).sum::<f64>() / motion.rows.len() as f64;
        let moves = libm::sqrt(power) * dt;
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
fn tick_length(steps: &[Step]) -> Option<f64> {
    let usual = median(steps.iter().map(|s| s.stamps).collect())?;
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

/// Tick length by the stamps between the first and the last sure step.
fn by_stamps(motion: &Motion, rows: &[usize], counts: &[f64], tick: f64) -> f64 {
    let ticks: f64 = counts.iter().sum();
    let stamped = motion.t[rows[rows.len() - 1]] - motion.t[rows[0]];
    // Both estimates must tell the same story, or the stamps say nothing about the tick.
    let period = stamped / ticks;
    if (period - tick).abs() < 0.01 * tick { period } else { tick }
}

/// Ticks of each step: the likeliest whole number, then stretches of unsure steps held near the stamps.
fn count(steps: &[Step], tick: f64) -> Vec<f64> {
    let cost = cost_of_lengths(steps, tick);
    let mut counts: Vec<f64> = steps.iter().map(|step| likeliest(step, tick, &cost)).collect();
    let mut first = 0;
    while first < steps.len() {
        let end = (first..steps.len()).find(|&i| steps[i].error < SURE * tick).unwrap_or(steps.len());
        if end > first {
            hold(&steps[first..end], &mut counts[first..end], tick);
        }
        first = end + 1;
    }
    counts
}

/// Minus twice the logarithm of how often each length occurs among the sure steps.
fn cost_of_lengths(steps: &[Step], tick: f64) -> [f64; LENGTHS] {
    let mut seen = [0.5; LENGTHS];
    for step in steps.iter().filter(|s| s.error < SURE * tick) {
        let n = libm::round(step.elapsed / tick).max(1.0) as usize;
        seen[n.min(LENGTHS) - 1] += 1.0;
    }
    let total: f64 = seen.iter().sum();
    seen.map(|n| -2.0 * libm::log(n / total))
}

fn likeliest(step: &Step, tick: f64, cost: &[f64; LENGTHS]) -> f64 {
    let nearest = libm::round(step.elapsed / tick).max(1.0);
    if step.error < SURE * tick || nearest > LENGTHS as f64 {
        return nearest;
    }
    let total = |n: usize| {
        let off = (n as f64 * tick - step.elapsed) / step.error;
        off * off + cost[n - 1]
    };
    (1..=LENGTHS).min_by(|&a, &b| total(a).total_cmp(&total(b))).map_or(nearest, |n| n as f64)
}

/// Spreads whole ticks evenly over a stretch of unsure steps where its sum has left the stamps by
/// more than [`LEEWAY`].
fn hold(steps: &[Step], counts: &mut [f64], tick: f64) {
    let stamped: f64 = steps.iter().map(|s| s.stamps).sum();
    let sum: f64 = counts.iter().sum();
    let excess = sum - sum.clamp((stamped - LEEWAY) / tick, (stamped + LEEWAY) / tick);
    let (mut due, mut done) = (0.0, 0.0);
    let share = excess / steps.len() as f64;
    for n in counts {
        due += share;
        let change = libm::round(due - done).min(*n - 1.0);
        *n -= change;
        done += change;
    }
}
