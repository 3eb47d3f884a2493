//! What a joint's error may depend on.

use crate::signals::{Run, detect_period};

/// A variable of a log.
#[derive(Debug, Clone)]
pub(super) enum Variable {
    Position(usize),
    Speed(usize),
    Acceleration(usize),
    Time,
    Channel(String),
}

/// A variable at every sample of a run.
pub(super) enum Values<'a> {
    Column(&'a [f64]),
    Clock { dt: f64, count: usize },
}

impl Values<'_> {
    pub fn at(&self, k: usize) -> f64 {
        match self {
            Self::Column(c) => c[k],
            Self::Clock { dt, .. } => k as f64 * dt,
        }
    }

    fn range(&self) -> (f64, f64) {
        match self {
            Self::Column(c) => range(c),
            Self::Clock { dt, count } => (0.0, *count as f64 * dt),
        }
    }
}

impl Variable {
    /// Everything that these runs hold, for joints by number.
    pub fn all(runs: &[Run], dof: usize) -> Vec<Self> {
        let of_joint = |i| [Self::Position(i), Self::Speed(i), Self::Acceleration(i)];
        let mut all: Vec<Self> = (0..dof).flat_map(of_joint).collect();
        all.push(Self::Time);
        all.extend(channels(runs).into_iter().map(Self::Channel));
        all
    }

    pub fn name(&self) -> String {
        match self {
            Self::Position(i) => format!("q{}", i + 1),
            Self::Speed(i) => format!("dq{}", i + 1),
            Self::Acceleration(i) => format!("ddq{}", i + 1),
            Self::Time => "time".to_string(),
            Self::Channel(name) => name.clone(),
        }
    }

    pub fn of<'a>(&self, run: &'a Run) -> Values<'a> {
        match self {
            Self::Position(i) => Values::Column(&run.q[*i]),
            Self::Speed(i) => Values::Column(run.friction_dq(*i)),
            Self::Acceleration(i) => Values::Column(&run.ddq[*i]),
            Self::Time => Values::Clock { dt: run.dt, count: run.samples() },
            Self::Channel(name) => Values::Column(run.channels.get(name).map_or(&[], Vec::as_slice)),
        }
    }

    /// Least and largest value in all runs.
    pub fn range(&self, runs: &[Run]) -> (f64, f64) {
        runs.iter()
            .map(|run| self.of(run).range())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (c, d)| (a.min(c), b.max(d)))
    }
}

/// Channels that every run has and that vary.
fn channels(runs: &[Run]) -> Vec<String> {
    let Some(first) = runs.first() else { return Vec::new() };
    let varies = |name: &&String| {
        runs.iter().all(|run| {
            let Some(c) = run.channels.get(*name) else { return false };
            let (low, high) = range(c);
            high - low > 1e-9 * low.abs().max(high.abs()).max(1e-9)
        })
    };
    first.channels.keys().filter(varies).cloned().collect()
}

/// Whether a motion repeats itself, so that anything which follows it looks like a clock.
pub(super) fn periodic(runs: &[Run]) -> bool {
    runs.iter().any(|run| detect_period(run).is_some())
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
}
