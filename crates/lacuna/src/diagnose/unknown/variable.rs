//! What a joint's error may depend on.

use crate::signals::{Run, correlation, detect_period, extremes};

/// A channel that goes with a joint's torque as closely as this is that torque.
const SAME: f64 = 0.98;

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
            Self::Column(c) => extremes(c),
            Self::Clock { dt, count } => (0.0, *count as f64 * dt),
        }
    }
}

impl Variable {
    /// Everything that these runs hold; nothing of joints that stand `still`, whose noise follows their load.
    pub fn all(runs: &[Run], still: &[bool]) -> Vec<Self> {
        let of_joint = |i| [Self::Position(i), Self::Speed(i), Self::Acceleration(i)];
        let mut all: Vec<Self> = (0..still.len()).filter(|&i| !still[i]).flat_map(of_joint).collect();
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

/// Channels that every run has and that vary; not those which are a joint's torque in other units, as the current of its
/// motor is: what depends on the torque depends on everything.
fn channels(runs: &[Run]) -> Vec<String> {
    let Some(first) = runs.first() else { return Vec::new() };
    let torque = |name: &str| {
        let alike = |run: &Run, tau: &Vec<f64>| {
            run.channels.get(name).is_some_and(|c| correlation(c, tau).abs() >= SAME)
        };
        (0..first.tau.len()).any(|j| runs.iter().all(|run| alike(run, &run.tau[j])))
    };
    let varies = |name: &&String| {
        runs.iter().all(|run| {
            let Some(c) = run.channels.get(*name) else { return false };
            let (low, high) = extremes(c);
            high - low > 1e-9 * low.abs().max(high.abs()).max(1e-9)
        })
    };
    first.channels.keys().filter(varies).filter(|name| !torque(name)).cloned().collect()
}

/// Whether a motion repeats itself, so that anything which follows it looks like a clock.
pub(super) fn periodic(runs: &[Run]) -> bool {
    runs.iter().any(|run| detect_period(run).is_some())
}

#[cfg(test)]
mod tests {
    use super::Variable;
    use crate::signals::Run;

    #[test]
    fn a_motor_current_is_no_variable_and_a_temperature_is() {
        let wave = |k: f64| -> Vec<f64> { (0..500).map(|i| libm::sin(k * f64::from(i))).collect() };
        let (tau, temperature) = (wave(0.05), wave(0.011));
        let current = tau.iter().map(|x| 0.08 * x + 0.3).collect();
        let channels = [("current1".to_string(), current), ("temp1".to_string(), temperature)].into();
        let run = Run { tau: vec![tau.clone()], channels, ..Run::default() };
        let names: Vec<String> =
            Variable::all(std::slice::from_ref(&run), &[]).iter().map(Variable::name).collect();
        assert_eq!(names, ["time", "temp1"]);
    }
}
