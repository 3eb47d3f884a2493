//! What is written down of a simulated motion: sampling, noise, quantisation, and a reader with its own clock.

use serde::{Deserialize, Serialize};

use super::per_joint::PerJoint;
use super::{Observed, Truth, simulation::Row};
use lacuna_base::error::{Error, Result};
use lacuna_base::log::Log;
use lacuna_base::random::Stream;
use lacuna_base::text::bounds::{NotNegative, Seconds, Share};

/// The robot's sensors, sampled on one regular clock, and who reads them.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Sensors {
    /// Sampling time \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    pub sampling_time_s: f64,
    /// Standard deviation of white noise on positions [rad, m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub position_noise: PerJoint,
    /// Step of the position encoder, after noise [rad, m]; zero for none.
    #[serde(deserialize_with = "NotNegative::read")]
    pub position_step: PerJoint,
    /// Standard deviation of white noise on velocities [rad/s, m/s].
    #[serde(deserialize_with = "NotNegative::read")]
    pub velocity_noise: PerJoint,
    /// Standard deviation of white noise on torques [N m, N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub torque_noise: PerJoint,
    /// Standard deviation of slow noise on torques: a first-order process that forgets in `torque_wander_s`
    /// [N m, N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub torque_wander: PerJoint,
    /// How long slow noise on torques remembers \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    pub torque_wander_s: f64,
    /// Whether velocities are logged at all.
    pub log_velocity: bool,
    /// A reader with its own clock; without it every sample becomes one row with its exact time.
    pub reader: Option<Reader>,
}

/// A program that fetches the latest sample now and then and stamps it with its own time: where it is too
/// early the sample repeats, where it is late samples are skipped, and the stamp says when it read, not when
/// the robot measured.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Reader {
    /// Mean time between two readings, stalls aside \[s\].
    #[serde(deserialize_with = "Seconds::read")]
    pub period_s: f64,
    /// Standard deviation of that time, as a fraction of it.
    #[serde(deserialize_with = "Share::read")]
    pub jitter: f64,
    /// Chance that a reading stalls.
    #[serde(deserialize_with = "Share::read")]
    pub stall_chance: f64,
    /// Mean length of a stall \[s\]; lengths are exponentially distributed.
    #[serde(deserialize_with = "Seconds::read")]
    pub stall_s: f64,
}

impl Default for Sensors {
    fn default() -> Self {
        let none = PerJoint::default;
        Self {
            sampling_time_s: 1e-3,
            position_noise: none(),
            position_step: none(),
            velocity_noise: none(),
            torque_noise: none(),
            torque_wander: none(),
            torque_wander_s: 0.08,
            log_velocity: true,
            reader: None,
        }
    }
}

impl Default for Reader {
    /// About as many repeated (6 %) and skipped (8 %) samples of a 1 kHz clock as in the public log of Gaz et al. 2019.
    fn default() -> Self {
        Self { period_s: 1e-3, jitter: 0.17, stall_chance: 0.01, stall_s: 2.2e-3 }
    }
}

impl Sensors {
    /// Refuses settings that do not fit a robot of `dof` joints.
    ///
    /// # Errors
    /// When a time is not positive, a deviation negative, or a list has the wrong length.
    pub fn check(&self, dof: usize) -> Result<()> {
        let positive = |what: &str, value: f64| match value.is_finite() && value > 0.0 {
            true => Ok(()),
            false => Err(Error::new(format!("`{what}` is {value}")).help("give a positive time in seconds")),
        };
        positive("sampling_time_s", self.sampling_time_s)?;
        self.position_noise.check_not_negative("`position_noise`", dof)?;
        self.position_step.check_not_negative("`position_step`", dof)?;
        self.velocity_noise.check_not_negative("`velocity_noise`", dof)?;
        self.torque_noise.check_not_negative("`torque_noise`", dof)?;
        self.torque_wander.check_not_negative("`torque_wander`", dof)?;
        positive("torque_wander_s", self.torque_wander_s)?;
        let Some(reader) = &self.reader else { return Ok(()) };
        positive("period_s", reader.period_s)?;
        positive("stall_s", reader.stall_s)?;
        if (0.0..=0.5).contains(&reader.jitter) && (0.0..=1.0).contains(&reader.stall_chance) {
            return Ok(());
        }
        let what =
            format!("the reader has jitter {} and stall chance {}", reader.jitter, reader.stall_chance);
        Err(Error::new(what).help("give a jitter from 0 to 0.5 and a chance from 0 to 1"))
    }

    /// Rows that a motion of `duration` \[s\] takes: its samples or its readings, whichever are more.
    pub fn rows(&self, duration: f64) -> f64 {
        let reader = self.reader.as_ref().map_or(f64::INFINITY, |reader| reader.period_s);
        duration / self.sampling_time_s.min(reader) + 1.0
    }

    /// Writes down what the sensors say of what they see (`seen`) of `truth`, and which sample each row holds.
    ///
    /// Every channel and the reader draw from their own random stream of `seed`, so that noise on one
    /// channel does not change when another is switched on.
    pub(super) fn record(&self, name: &str, truth: &Truth, seen: &Observed, seed: u64) -> (Log, Vec<Row>) {
        let n = truth.q.len();
        let rows = match &self.reader {
            Some(reader) => reader.read(truth.t.len(), self.sampling_time_s, Stream::new(seed, 0)),
            None => truth.t.iter().enumerate().map(|(sample, &stamp)| Row { stamp, sample }).collect(),
        };
        let channels = |kind: usize, exact: &[Vec<f64>], noise: &PerJoint, step: &PerJoint| {
            let channel = |(j, exact): (usize, &Vec<f64>)| {
                let seen = measured(exact, noise.of(j), step.of(j), Stream::new(seed, 1 + kind + 3 * j));
                rows.iter().map(|row| seen[row.sample]).collect()
            };
            debug_assert_eq!(exact.len(), n);
            exact.iter().enumerate().map(channel).collect::<Vec<Vec<f64>>>()
        };
        let smooth = PerJoint::default();
        let tau: Vec<Vec<f64>> =
            seen.tau.iter().enumerate().map(|(j, tau)| self.wandering(j, n, tau, seed)).collect();
        let pick = |channel: &Vec<f64>| rows.iter().map(|row| channel[row.sample]).collect();
        let log = Log {
            name: name.into(),
            t: rows.iter().map(|row| row.stamp).collect(),
            q: channels(0, &seen.q, &self.position_noise, &self.position_step),
            dq: self.log_velocity.then(|| channels(1, &seen.dq, &self.velocity_noise, &smooth)),
            tau: channels(2, &tau, &self.torque_noise, &smooth),
            channels: truth.channels.iter().map(|(name, x)| (name.clone(), pick(x))).collect(),
            ..Log::default()
        };
        (log, rows)
    }

    /// The torque of joint `j` of `n` with slow noise, from a stream behind those of the white noises.
    fn wandering(&self, j: usize, n: usize, exact: &[f64], seed: u64) -> Vec<f64> {
        let deviation = self.torque_wander.of(j);
        if !(deviation > 0.0) {
            return exact.to_vec();
        }
        let mut stream = Stream::new(seed, 1 + 3 * n + j);
        let keep = libm::exp(-self.sampling_time_s / self.torque_wander_s);
        let fresh = deviation * (1.0 - keep * keep).sqrt();
        let mut noise = deviation * stream.normal();
        exact
            .iter()
            .map(|x| {
                let seen = x + noise;
                noise = keep * noise + fresh * stream.normal();
                seen
            })
            .collect()
    }
}

/// A channel with white noise of deviation `noise`, rounded to whole multiples of `step`.
fn measured(exact: &[f64], noise: f64, step: f64, mut stream: Stream) -> Vec<f64> {
    let mut seen = exact.to_vec();
    if noise > 0.0 {
        seen.iter_mut().for_each(|x| *x += noise * stream.normal());
    }
    if step > 0.0 {
        seen.iter_mut().for_each(|x| *x = (*x / step).round() * step);
    }
    seen
}

impl Reader {
    fn read(&self, samples: usize, sampling_time: f64, mut stream: Stream) -> Vec<Row> {
        let mut rows = Vec::with_capacity(samples);
        let mut stamp = 0.5 * sampling_time;
        loop {
            let sample = (stamp / sampling_time).floor() as usize;
            if sample >= samples {
                return rows;
            }
            rows.push(Row { stamp, sample });
            // A tenth of the period at least, so that time never stands still.
            stamp += self.period_s * (1.0 + self.jitter * stream.normal()).max(0.1);
            if stream.uniform() < self.stall_chance {
                stamp -= self.stall_s * libm::log(1.0 - stream.uniform());
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn still(n: usize, samples: usize) -> Truth {
        let columns = |value: f64| vec![vec![value; samples]; n];
        Truth {
            t: (0..samples).map(|k| k as f64 * 1e-3).collect(),
            q: columns(0.5),
            dq: columns(0.0),
            ddq: columns(0.0),
            tau: columns(3.0),
            load: columns(0.0),
            ..Truth::default()
        }
    }

    fn seen(truth: &Truth) -> Observed {
        let (q, dq, tau) = (truth.q.clone(), truth.dq.clone(), truth.tau.clone());
        Observed { dt: 1e-3, q, dq, transmitted: tau.clone(), tau }
    }

    fn deviation(x: &[f64]) -> (f64, f64) {
        let mean = x.iter().sum::<f64>() / x.len() as f64;
        (mean, (x.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / x.len() as f64).sqrt())
    }

    fn correlation(a: &[f64], b: &[f64]) -> f64 {
        let ((ma, sa), (mb, sb)) = (deviation(a), deviation(b));
        a.iter().zip(b).map(|(x, y)| (x - ma) * (y - mb)).sum::<f64>() / (a.len() as f64 * sa * sb)
    }

    #[test]
    fn noise_is_white_of_the_right_size_and_channels_are_independent() {
        let sensors = Sensors {
            position_noise: PerJoint::all(1e-4),
            velocity_noise: PerJoint::all(1e-3),
            torque_noise: [0.3, 0.05].into(),
            ..Sensors::default()
        };
        let truth = still(2, 50_000);
        let (log, _) = sensors.record("noise", &truth, &seen(&truth), 9);
        let dq = log.dq.as_ref().expect("velocities are logged");
        for (x, mean, sd) in [
            (&log.q[0], 0.5, 1e-4),
            (&log.q[1], 0.5, 1e-4),
            (&dq[1], 0.0, 1e-3),
            (&log.tau[0], 3.0, 0.3),
            (&log.tau[1], 3.0, 0.05),
        ] {
            // Four standard errors of mean, deviation and correlation.
            let (m, s) = deviation(x);
            assert!((m - mean).abs() < 4.0 * sd / 50_000_f64.sqrt(), "mean {m}");
            assert!((s / sd - 1.0).abs() < 4.0 / 100_000_f64.sqrt(), "deviation {s} for {sd}");
            assert!(correlation(&x[1..], &x[..49_999]).abs() < 0.018);
        }
        assert!(correlation(&log.q[0], &log.q[1]).abs() < 0.018);
        assert!(correlation(&log.q[0], &log.tau[0]).abs() < 0.018);
    }

    #[test]
    fn noise_of_one_channel_does_not_depend_on_the_others() {
        let truth = still(2, 100);
        let only_torque = Sensors { torque_noise: PerJoint::all(0.1), ..Sensors::default() };
        let both = Sensors { position_noise: PerJoint::all(0.1), ..only_torque.clone() };
        let (a, _) = only_torque.record("a", &truth, &seen(&truth), 4);
        let (b, _) = both.record("b", &truth, &seen(&truth), 4);
        assert_eq!(a.tau, b.tau);
        assert_ne!(a.q, b.q);
        assert_eq!(a.q, truth.q);
    }

    #[test]
    fn encoders_round_to_their_steps() {
        let sensors = Sensors {
            position_noise: PerJoint::all(1e-3),
            position_step: PerJoint::all(2.4e-4),
            log_velocity: false,
            ..Sensors::default()
        };
        let (log, _) = sensors.record("steps", &still(1, 5000), &seen(&still(1, 5000)), 2);
        assert!(log.dq.is_none());
        assert!(log.q[0].iter().all(|x| (x / 2.4e-4 - (x / 2.4e-4).round()).abs() < 1e-9));
        let (_, sd) = deviation(&log.q[0]);
        let want = (1e-6 + 2.4e-4_f64.powi(2) / 12.0).sqrt();
        assert!((sd / want - 1.0).abs() < 0.04, "{sd} for {want}");
    }

    #[test]
    fn a_reader_repeats_and_skips_and_never_reads_the_future() {
        let mut truth = still(1, 20_000);
        truth.q[0] = truth.t.clone();
        let sensors = Sensors { reader: Some(Reader::default()), ..Sensors::default() };
        let (log, rows) = sensors.record("reader", &truth, &seen(&truth), 3);
        assert!(log.t.windows(2).all(|w| w[0] < w[1]), "stamps go forwards");
        let lag = |k: usize| log.t[k] - log.q[0][k];
        assert!(
            (0..log.rows()).all(|k| (-1e-12..1e-3 + 1e-12).contains(&lag(k))),
            "the latest sample is read"
        );
        let steps = |p: fn(usize) -> bool| rows.windows(2).filter(|w| p(w[1].sample - w[0].sample)).count();
        let (repeats, skips) = (steps(|d| d == 0) as f64, steps(|d| d > 1) as f64);
        let n = rows.len() as f64;
        println!("{:.1} % repeats, {:.1} % skips", 100.0 * repeats / n, 100.0 * skips / n);
        assert!(
            (0.03..0.10).contains(&(repeats / n)) && (0.04..0.12).contains(&(skips / n)),
            "{repeats} {skips}"
        );
    }

    #[test]
    fn settings_without_meaning_are_refused_and_typos_named() {
        let base = Sensors::default();
        assert!(Sensors { sampling_time_s: 0.0, ..base.clone() }.check(2).is_err());
        assert!(Sensors { torque_noise: [0.1; 3].into(), ..base.clone() }.check(2).is_err());
        let jumpy = Reader { jitter: 2.0, ..Reader::default() };
        assert!(Sensors { reader: Some(jumpy), ..base.clone() }.check(2).is_err());
        let error = ron::from_str::<Sensors>("(torque_nose: [0.1])").expect_err("a typo");
        assert!(error.to_string().contains("torque_nose"), "{error}");
    }

    #[test]
    fn slow_noise_has_its_size_and_memory() {
        let sensors = Sensors { torque_wander: PerJoint::all(0.2), ..Sensors::default() };
        let truth = still(1, 200_000);
        let (log, _) = sensors.record("slow", &truth, &seen(&truth), 5);
        let (mean, sd) = deviation(&log.tau[0]);
        // 200 s hold about 1250 independent pieces of 0.16 s: four standard errors of each.
        assert!((mean - 3.0).abs() < 0.023 && (sd / 0.2 - 1.0).abs() < 0.08, "{mean} {sd}");
        let after = correlation(&log.tau[0][80..], &log.tau[0][..199_920]);
        assert!((after - (-1.0_f64).exp()).abs() < 0.09, "after 80 ms: {after}");
    }
}
