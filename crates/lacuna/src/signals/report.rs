//! What the signal step did, for people and programs.

use std::collections::BTreeMap;

use serde::Serialize;

use super::clean::Segment;
use super::clock::ClockReport;
use crate::log::Thinned;

/// Everything the signal step did to one log; printed with every figure that rests on it.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct SignalReport {
    /// Name of the log.
    pub log: String,
    /// Rows the file had, those left out while reading included.
    pub rows_read: usize,
    /// Rows left out, by reason.
    pub rows_dropped: BTreeMap<String, usize>,
    /// Stretches between gaps, and which was kept.
    pub segments: Vec<Segment>,
    /// The clock and the evidence for it.
    pub clock: ClockReport,
    /// Samples on the uniform clock, before trimming.
    pub samples: usize,
    /// Samples among them that stand in gaps and were filled linearly.
    pub samples_filled: usize,
    /// Longest distance between neighbouring rows \[s\].
    pub longest_gap_s: f64,
    /// How a very long log was thinned before anything else.
    pub thinned: Option<ThinnedReport>,
    /// `inputs` or `parallel`.
    pub mode: &'static str,
    /// Cut-off of the band \[Hz\].
    pub band_hz: f64,
    /// Order of each of the two filter passes.
    pub order: usize,
    /// `logged` or `position`.
    pub source_of_velocity: &'static str,
    /// Cut-off before differentiation \[Hz\]; only in `parallel`.
    pub position_cutoff_hz: Option<f64>,
    /// Cut-off for the velocities of columns with a sign \[Hz\], where they have their own.
    pub friction_cutoff_hz: Option<f64>,
    /// Source of the velocities in signs, `logged` or `position`, where they have their own cut-off.
    pub source_of_friction_velocity: Option<&'static str>,
    /// Cut from both ends \[s\].
    pub trim_s: f64,
    /// Every so-many-th sample was kept.
    pub decimate: usize,
    /// Rows that came out.
    pub rows_used: usize,
}

/// What was kept of a very long log.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ThinnedReport {
    /// Every so-many-th sample, after a low-pass; 1 where every one was.
    pub every: usize,
    /// Rate of the log \[Hz\].
    pub from_hz: f64,
    /// Rate that was kept \[Hz\].
    pub to_hz: f64,
    /// Rows of the fit per second \[Hz\].
    pub rows_hz: f64,
}

impl ThinnedReport {
    /// Of a log with this sampling time now \[s\], of which every so-many-th sample is a row.
    pub(super) fn of(thinned: Option<&Thinned>, dt: f64, row_every: usize) -> Self {
        let every = thinned.map_or(1, |t| t.every);
        Self { every, from_hz: every as f64 / dt, to_hz: 1.0 / dt, rows_hz: 1.0 / (dt * row_every as f64) }
    }

    /// In words.
    pub fn text(&self) -> String {
        let kept = match self.every {
            1 => "every sample".to_string(),
            n => format!("every {} sample ({:.0} Hz of {:.0} Hz)", ordinal(n), self.to_hz, self.from_hz),
        };
        format!("very long: {kept} kept, {:.1} rows per second", self.rows_hz)
    }
}

impl SignalReport {
    /// The report for people: a few lines of at most 80 characters.
    pub fn lines(&self) -> Vec<String> {
        let mut lines = vec![fit(format!(
            "{}: {} rows read, {} left out{}",
            self.log,
            self.rows_read,
            self.rows_dropped.values().sum::<usize>(),
            if self.rows_dropped.is_empty() { "" } else { ":" },
        ))];
        if !self.rows_dropped.is_empty() {
            let reasons: Vec<String> =
                self.rows_dropped.iter().map(|(why, n)| format!("{n} {why}")).collect();
            lines.extend(wrap(&reasons));
        }
        if let Some(kept) = self.segments.iter().find(|s| s.used).filter(|_| self.segments.len() > 1) {
            let (from, to, all) = (kept.from_s, kept.to_s, self.segments.len());
            lines.push(fit(format!("  kept {from:.2} s to {to:.2} s, the longest of {all} stretches")));
        }
        lines.extend(self.clock_lines());
        lines.push(fit(format!(
            "  {} samples, {} filled in gaps (longest {:.1} ms)",
            self.samples,
            self.samples_filled,
            1e3 * self.longest_gap_s
        )));
        lines.extend(self.thinned.iter().map(|t| fit(format!("  {}", t.text()))));
        let motion = self.position_cutoff_hz.map_or_else(String::new, |hz| format!(", motion {hz} Hz"));
        let friction = self.friction_cutoff_hz.map_or_else(String::new, |hz| {
            let source = self.source_of_friction_velocity.unwrap_or(self.source_of_velocity);
            format!(", friction {hz} Hz from {source}")
        });
        lines.push(fit(format!(
            "  mode {}: band {} Hz{motion}{friction}, Butterworth order {} both ways",
            self.mode, self.band_hz, self.order
        )));
        lines.push(fit(format!(
            "  velocity {}, {} s trimmed at both ends, every {} sample: {} rows",
            self.source_of_velocity,
            self.trim_s,
            ordinal(self.decimate),
            self.rows_used
        )));
        lines
    }

    fn clock_lines(&self) -> Vec<String> {
        let clock = &self.clock;
        let rate = 1.0 / clock.period_s;
        let mut lines = vec![fit(match clock.used {
            "rebuilt" => {
                format!(
                    "  clock rebuilt at {rate:.6} Hz, {} samples missing in the log",
                    clock.skipped_samples
                )
            }
            "even" => format!("  clock even at {rate:.6} Hz, as the time stamps say"),
            _ => format!("  clock by the time stamps, resampled at {rate:.6} Hz"),
        })];
        if let (Some(stamps), Some(used)) = (clock.velocity_mismatch_stamps, clock.velocity_mismatch_used) {
            lines.push(fit(format!(
                "  diff(q) against dq: rms {stamps:.4} rad/s by stamps, {used:.4} as used"
            )));
        }
        lines
    }
}

/// `1st`, `2nd`, `3rd`, `40th`.
fn ordinal(n: usize) -> String {
    let ending = match (n % 10, n % 100) {
        (1, tens) if tens != 11 => "st",
        (2, tens) if tens != 12 => "nd",
        (3, tens) if tens != 13 => "rd",
        _ => "th",
    };
    format!("{n}{ending}")
}

/// Items separated by commas on as few indented lines as they need.
fn wrap(items: &[String]) -> Vec<String> {
    let mut lines: Vec<String> = Vec::new();
    for item in items {
        match lines.last_mut() {
            Some(line) if line.len() + item.len() < 76 => *line += &format!(", {item}"),
            _ => lines.push(format!("  {item}")),
        }
    }
    lines.into_iter().map(fit).collect()
}

/// Cuts a line that a very long name has made too long.
fn fit(line: String) -> String {
    if line.chars().count() <= 80 { line } else { line.chars().take(77).chain("...".chars()).collect() }
}
