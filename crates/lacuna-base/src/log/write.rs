//! Logs as CSV text, in the columns that [`Log::open`] reads.

use std::fmt::Write;

use serde::{Deserialize, Serialize};

use super::Log;

use crate::text::bounds::Digits;

/// Digits after the point in a written log.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Decimals {
    /// Of times \[s\].
    #[serde(deserialize_with = "Digits::read")]
    pub time: usize,
    /// Of positions [rad, m].
    #[serde(deserialize_with = "Digits::read")]
    pub position: usize,
    /// Of velocities [rad/s, m/s] and accelerations [rad/s², m/s²].
    #[serde(deserialize_with = "Digits::read")]
    pub velocity: usize,
    /// Of torques [N m, N].
    #[serde(deserialize_with = "Digits::read")]
    pub torque: usize,
    /// Of other channels.
    #[serde(deserialize_with = "Digits::read")]
    pub channel: usize,
}

impl Default for Decimals {
    /// Finer than any sensor.
    fn default() -> Self {
        Self { time: 6, position: 8, velocity: 7, torque: 6, channel: 4 }
    }
}

impl Log {
    /// The log as CSV: `t, q1.., dq1.., ddq1.., tau1..`, then the other channels by name.
    pub fn to_csv(&self, decimals: Decimals) -> String {
        let joints = [
            ("q", Some(&self.q), decimals.position),
            ("dq", self.dq.as_ref(), decimals.velocity),
            ("ddq", self.ddq.as_ref(), decimals.velocity),
            ("tau", Some(&self.tau), decimals.torque),
        ];
        let mut columns: Vec<(String, &[f64], usize)> = vec![("t".into(), &self.t, decimals.time)];
        for (symbol, all, digits) in joints {
            for (j, column) in all.into_iter().flatten().enumerate() {
                columns.push((format!("{symbol}{}", j + 1), column, digits));
            }
        }
        for (name, channel) in &self.channels {
            columns.push((name.clone(), channel, decimals.channel));
        }
        let names: Vec<&str> = columns.iter().map(|(name, ..)| name.as_str()).collect();
        let mut text = names.join(",") + "\n";
        for row in 0..self.rows() {
            for (i, (_, column, digits)) in columns.iter().enumerate() {
                let end = if i + 1 < columns.len() { ',' } else { '\n' };
                // Writing to a string cannot fail.
                let _ = write!(text, "{:.digits$}{end}", column[row]);
            }
        }
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::error::Result;
    use crate::robot::Robot;

    #[test]
    fn what_is_written_is_read_back() -> Result<()> {
        let robot = Robot::open("../../robots/two_link.ron")?;
        let log = Log {
            name: "two.csv".into(),
            t: vec![0.0, 0.001, 0.002],
            q: vec![vec![0.125, -0.25, 3.0], vec![1e-8, 2.0, -1.5]],
            dq: Some(vec![vec![1.0, 2.0, 3.0], vec![-0.5, 0.0, 1e-7]]),
            tau: vec![vec![0.5, -7.25, 100.0], vec![0.0, 1e-6, -2.0]],
            channels: [("temperature1".to_string(), vec![22.0, 22.5, 23.0625])].into(),
            ..Log::default()
        };
        let text = log.to_csv(Decimals::default());
        let back = Log::from_reader(text.as_bytes(), "two.csv", &robot, None)?;
        assert_eq!(back, log);
        assert_eq!(text.lines().next(), Some("t,q1,q2,dq1,dq2,tau1,tau2,temperature1"));
        Ok(())
    }
}
