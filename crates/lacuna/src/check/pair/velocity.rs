//! Time stamps, positions and velocities against each other, before any torque is looked at.

use std::f64::consts::PI;

use super::reading::Signed;
use crate::log::{Log, TimeUnit};
use crate::robot::{JointKind, Robot};

/// Length of the differences that are compared with velocities \[s\]: long beside the jitter of stamps.
const SPAN_S: f64 = 0.03;
/// Correlation from which two signals follow each other.
const FOLLOWS: f64 = 0.85;
/// Slower than this many rows per second, stamps are hardly in seconds \[Hz\].
const SLOWEST_HZ: f64 = 4.0;

/// What time, position and velocity say of each other, and the log with that put right.
#[derive(Debug)]
pub(super) struct Kinematics {
    /// The log with time in seconds, and velocities that follow the positions as they are recorded.
    pub log: Log,
    /// Unit of the stamps, where it is not the second.
    pub time: Option<TimeUnit>,
    /// Angles of positions are in degrees, those of velocities are not.
    pub position_degrees: bool,
    /// Angles of velocities are in degrees, those of positions are not.
    pub velocity_degrees: bool,
    /// Column of the velocity that follows each recorded position.
    pub velocity: Vec<Signed>,
    /// Joints whose velocity is another multiple of the position's change: joint and factor.
    pub scaled: Vec<(usize, f64)>,
    /// Joints whose velocity follows no position.
    pub lost: Vec<usize>,
    /// Slope of diff(q) over dq of every joint that moves, in the log as it stands.
    pub slopes: Vec<Option<f64>>,
    /// Rows per second by the stamps as they stand.
    pub rows_per_second: f64,
}

/// Compares them.
pub(super) fn examine(log: &Log, robot: &Robot) -> Kinematics {
    let n = log.q.len();
    let step = usual_step(&log.t);
    let turning: Vec<bool> = robot.joints.iter().map(|j| j.kind == JointKind::Revolute).collect();
    let mut found = Kinematics {
        log: log.clone(),
        time: None,
        position_degrees: false,
        velocity_degrees: false,
        velocity: Signed::identity(n),
        scaled: Vec::new(),
        lost: Vec::new(),
        slopes: vec![None; n],
        rows_per_second: if step > 0.0 { 1.0 / step } else { 0.0 },
    };
    let pairs = log.dq.as_ref().map(|dq| Pairs::new(log, dq, step));
    found.slopes = pairs.as_ref().map_or(vec![None; n], |p| (0..n).map(|j| p.slope(j, j)).collect());
    let usual = usual_size(&found.slopes, &turning);
    found.time = time_unit(step, usual);
    let per_second = found.time.map_or(1.0, ticks);
    found.log.t.iter_mut().for_each(|t| *t /= per_second);
    let Some(pairs) = pairs else { return found };
    match usual.map(|slope| slope * per_second) {
        Some(slope) if (40.0..80.0).contains(&slope) => found.position_degrees = true,
        Some(slope) if (1.0 / 80.0..1.0 / 40.0).contains(&slope) => found.velocity_degrees = true,
        _ => {}
    }
    let radians = |columns: &mut [Vec<f64>]| {
        for (column, _) in columns.iter_mut().zip(&turning).filter(|(_, turns)| **turns) {
            column.iter_mut().for_each(|x| *x *= PI / 180.0);
        }
    };
    if found.position_degrees {
        radians(&mut found.log.q);
    }
    if let Some(dq) = found.log.dq.as_mut().filter(|_| found.velocity_degrees) {
        radians(dq);
    }
    found.assign(&pairs, &turning, per_second);
    found
}

impl Kinematics {
    /// Finds the velocity of every position, and gives the log velocities that follow its positions.
    fn assign(&mut self, pairs: &Pairs, turning: &[bool], per_second: f64) {
        let n = self.velocity.len();
        let follows = |i: usize, j: usize| pairs.correlation(i, j).abs() > FOLLOWS;
        for i in 0..n {
            if !pairs.moves(i, 1e-6) || follows(i, i) {
                continue;
            }
            let other = (0..n).find(|&j| j != i && follows(i, j) && !follows(j, j));
            match other {
                Some(column) => self.velocity[i].column = column,
                None if pairs.moves(i, 1e-3) && pairs.correlation(i, i).abs() < 0.5 => self.lost.push(i),
                None => {}
            }
        }
        let mut factors = vec![1.0; n];
        for i in 0..n {
            let column = self.velocity[i].column;
            let Some(slope) = pairs.slope(i, column) else { continue };
            let unit = match turning[i] {
                true if self.position_degrees => PI / 180.0,
                true if self.velocity_degrees => 180.0 / PI,
                _ => 1.0,
            };
            let slope = slope * per_second * unit;
            self.velocity[i].sign = slope.signum();
            if !(0.7..1.4).contains(&slope.abs()) && pairs.correlation(i, column).abs() > FOLLOWS {
                self.scaled.push((i, slope.abs()));
                factors[i] = slope.abs();
            }
        }
        let mut columns: Vec<usize> = self.velocity.iter().map(|v| v.column).collect();
        columns.sort_unstable();
        columns.dedup();
        if columns.len() < n {
            // Two positions claim one velocity: rather none is exchanged.
            self.velocity.iter_mut().enumerate().for_each(|(j, v)| v.column = j);
        }
        let lost = !self.lost.is_empty();
        self.log.dq = self.log.dq.take().filter(|_| !lost).map(|dq| {
            let mut dq = Signed::pick(&self.velocity, &dq);
            for (column, factor) in dq.iter_mut().zip(factors) {
                column.iter_mut().for_each(|x| *x *= factor);
            }
            dq
        });
    }
}

fn usual_step(t: &[f64]) -> f64 {
    let mut steps: Vec<f64> = t.windows(2).map(|w| w[1] - w[0]).filter(|s| *s > 0.0).collect();
    let middle = steps.len() / 2;
    if steps.is_empty() { 0.0 } else { *steps.select_nth_unstable_by(middle, f64::total_cmp).1 }
}

/// Median size of the slopes of turning joints (of all, where none turns).
fn usual_size(slopes: &[Option<f64>], turning: &[bool]) -> Option<f64> {
    let sizes = |of: bool| -> Vec<f64> {
        let wanted = slopes.iter().zip(turning).filter(|(_, turns)| **turns || !of);
        wanted.filter_map(|(s, _)| s.map(f64::abs)).collect()
    };
    let mut all = sizes(true);
    if all.is_empty() {
        all = sizes(false);
    }
    let middle = all.len() / 2;
    (!all.is_empty()).then(|| *all.select_nth_unstable_by(middle, f64::total_cmp).1)
}

/// Unit of the stamps by the velocities, or by the number of rows per unit where there are none.
fn time_unit(step: f64, slope: Option<f64>) -> Option<TimeUnit> {
    let units = [TimeUnit::Milliseconds, TimeUnit::Microseconds, TimeUnit::Nanoseconds];
    if let Some(slope) = slope {
        // A unit of angle may be wrong as well, a factor of 57 either way.
        let fits = |unit: &TimeUnit| {
            let whole = slope * ticks(*unit);
            [1.0, 180.0 / PI, PI / 180.0].iter().any(|f| (0.5..2.0).contains(&(whole * f)))
        };
        let as_is = [1.0, 180.0 / PI, PI / 180.0].iter().any(|f| (0.5..2.0).contains(&(slope * f)));
        return units.into_iter().find(|unit| !as_is && fits(unit));
    }
    let plausible = |unit: &TimeUnit| (SLOWEST_HZ..=20e3).contains(&(ticks(*unit) / step));
    (step > 1.0 / SLOWEST_HZ).then(|| units.into_iter().find(plausible)).flatten()
}

fn ticks(unit: TimeUnit) -> f64 {
    match unit {
        TimeUnit::Seconds => 1.0,
        TimeUnit::Milliseconds => 1e3,
        TimeUnit::Microseconds => 1e6,
        TimeUnit::Nanoseconds => 1e9,
    }
}

/// Products of differences of positions and means of velocities over the same spans.
struct Pairs {
    /// `differences[i]`, `velocities[j]`: squares; `cross[i][j]`: products.
    differences: Vec<f64>,
    velocities: Vec<f64>,
    cross: Vec<Vec<f64>>,
    fastest: f64,
}

impl Pairs {
    fn new(log: &Log, dq: &[Vec<f64>], step: f64) -> Self {
        let n = log.q.len();
        // Whatever the unit of the stamps is, thirty milliseconds are a few rows of any usual log.
        let guess = match step {
            s if s > 1.0 / SLOWEST_HZ => 1e-3 * s,
            s => s,
        };
        let span = ((SPAN_S / guess.max(1e-9)) as usize).clamp(1, 30);
        let mut sums = Self {
            differences: vec![0.0; n],
            velocities: vec![0.0; n],
            cross: vec![vec![0.0; n]; n],
            fastest: 0.0,
        };
        let longest = 3.0 * step * span as f64;
        let (mut d, mut v) = (vec![0.0; n], vec![0.0; n]);
        for k in (0..log.t.len().saturating_sub(span)).step_by(span.div_ceil(2)) {
            let time = log.t[k + span] - log.t[k];
            if !(time > 0.0 && time <= longest) {
                continue;
            }
            for j in 0..n {
                d[j] = (log.q[j][k + span] - log.q[j][k]) / time;
                v[j] = dq[j][k..=k + span].iter().sum::<f64>() / (span + 1) as f64;
            }
            if d.iter().chain(&v).all(|x| x.is_finite()) {
                sums.add(&d, &v);
            }
        }
        sums.fastest = sums.differences.iter().copied().fold(0.0, f64::max);
        sums
    }

    fn add(&mut self, d: &[f64], v: &[f64]) {
        let squares = |sums: &mut [f64], x: &[f64]| sums.iter_mut().zip(x).for_each(|(s, x)| *s += x * x);
        squares(&mut self.differences, d);
        squares(&mut self.velocities, v);
        for (row, d) in self.cross.iter_mut().zip(d) {
            row.iter_mut().zip(v).for_each(|(sum, v)| *sum += d * v);
        }
    }

    /// Whether position `i` moves enough to be judged: by its share of the fastest joint's squares.
    fn moves(&self, i: usize, share: f64) -> bool {
        self.differences[i] > share * self.fastest
    }

    fn correlation(&self, i: usize, j: usize) -> f64 {
        let sizes = (self.differences[i] * self.velocities[j]).sqrt();
        if sizes > 0.0 { self.cross[i][j] / sizes } else { 0.0 }
    }

    /// Change of position `i` per velocity `j`, where they follow each other.
    fn slope(&self, i: usize, j: usize) -> Option<f64> {
        let follows = self.moves(i, 1e-6) && self.correlation(i, j).abs() > 0.5;
        // The larger the noise, the smaller a plain slope; the ratio of sizes has no such bias.
        let size = (self.differences[i] / self.velocities[j].max(1e-300)).sqrt();
        follows.then(|| size * self.cross[i][j].signum())
    }
}
