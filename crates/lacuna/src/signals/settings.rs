//! What the signal step may be told.

use serde::{Deserialize, Serialize};

use crate::error::Result;
use crate::text::bounds::{Every, Hertz, Order, Seconds, SecondsOrNone};

/// Where filters stand in the way from log to regressor.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Mode {
    /// The paper's way: positions, velocities and torques are filtered, then differentiated, and the
    /// regressor is built from what comes out (Gaz et al. 2019, section IV).
    #[default]
    Inputs,
    /// The same filter on the torque and on every regressor column, which are built from lightly
    /// filtered motion; nothing is distorted between the two sides of the equation.
    Parallel,
}

impl Mode {
    /// Its name in reports: `inputs` or `parallel`.
    pub fn name(self) -> &'static str {
        match self {
            Self::Inputs => "inputs",
            Self::Parallel => "parallel",
        }
    }
}

/// Where velocities (and with them accelerations) come from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum VelocityFrom {
    /// The logged velocity where the log has one, otherwise the position.
    #[default]
    Auto,
    /// Central differences of the filtered position.
    Position,
    /// The logged velocity, filtered.
    Velocity,
}

/// Which clock the samples get.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum ClockChoice {
    /// The rebuilt sample clock where the data prove it, otherwise the time stamps.
    #[default]
    Auto,
    /// The time stamps, whatever the data say.
    Stamps,
    /// The clock rebuilt from positions and logged velocities, proven or not.
    Rebuilt,
}

/// What is kept of a log with gaps.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Keep {
    /// The stretch with most rows.
    #[default]
    LongestSegment,
}

/// Settings of the signal step; every one is repeated in its report.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Settings {
    /// What is filtered: the inputs of the regressor, or its columns.
    pub mode: Mode,
    /// Cut-off of the band in which the model is fitted \[Hz\].
    #[serde(deserialize_with = "Hertz::read")]
    pub band_hz: f64,
    /// Order of the Butterworth low-pass of each pass; it runs forwards and backwards.
    #[serde(deserialize_with = "Order::read")]
    pub order: usize,
    /// Cut-off for positions and velocities before they are differentiated \[Hz\]; `Parallel` only.
    #[serde(deserialize_with = "Hertz::read")]
    pub position_cutoff_hz: f64,
    /// Cut-off for the velocities of columns with a sign or a step at rest \[Hz\], `Parallel` only; a
    /// low-pass blurs every reversal. As `position_cutoff_hz` when not given.
    #[serde(deserialize_with = "Hertz::read")]
    pub friction_cutoff_hz: Option<f64>,
    /// Source of velocities.
    pub velocity_from: VelocityFrom,
    /// Source of the velocities that `friction_cutoff_hz` is for; `Auto` is that of the others.
    pub friction_velocity_from: VelocityFrom,
    /// Cut from both ends after filtering \[s\].
    #[serde(deserialize_with = "SecondsOrNone::read")]
    pub trim_s: f64,
    /// Keep every so-many-th sample after filtering. Not given: all in `Inputs`, about five samples
    /// per period of the band in `Parallel`, and two or, beyond ten thousand rows, one of very long logs.
    #[serde(deserialize_with = "Every::read")]
    pub decimate: Option<usize>,
    /// Rate that logs are thinned to before anything else \[Hz\], `Parallel` only: every so-many-th sample after a low-pass,
    /// never less. Not given: 125 Hz for very long logs (two million rows times joints), every sample of others. A rate
    /// above half the log's keeps every sample of any log.
    #[serde(deserialize_with = "Hertz::read")]
    pub thin_to_hz: Option<f64>,
    /// Which clock the samples get.
    pub clock: ClockChoice,
    /// What is kept of a log with gaps.
    pub keep: Keep,
    /// Longest gap that is filled linearly \[s\]; where the clock jumps further the log is split. Never
    /// less than three sampling times.
    #[serde(deserialize_with = "Seconds::read")]
    pub max_gap_s: f64,
}

impl Default for Settings {
    fn default() -> Self {
        Self {
            mode: Mode::Inputs,
            band_hz: 5.0,
            order: 4,
            position_cutoff_hz: 6.0,
            friction_cutoff_hz: None,
            velocity_from: VelocityFrom::Auto,
            friction_velocity_from: VelocityFrom::Auto,
            trim_s: 0.5,
            decimate: None,
            thin_to_hz: None,
            clock: ClockChoice::Auto,
            keep: Keep::LongestSegment,
            max_gap_s: 0.25,
        }
    }
}

/// Rows that a very long log need not have more of.
const ENOUGH_ROWS: usize = 10_000;

impl Settings {
    /// What a diagnosis starts from where nobody says otherwise: a wider band than an identification, since friction
    /// at reversals lies above 5 Hz, and nothing that a filter's ends could spoil.
    pub fn for_diagnosis() -> Self {
        Self { band_hz: 8.0, trim_s: 1.0, ..Self::default() }.in_parallel()
    }

    /// The same through one filter for torque and columns, as a diagnosis needs it.
    #[must_use]
    pub fn in_parallel(self) -> Self {
        Self { mode: Mode::Parallel, ..self }
    }

    /// Checks what can be checked without a log.
    ///
    /// # Errors
    /// Names the first setting that cannot work and what to write instead.
    pub fn check(&self) -> Result<()> {
        Hertz::check("band_hz", self.band_hz)?;
        Hertz::check("position_cutoff_hz", self.position_cutoff_hz)?;
        self.friction_cutoff_hz.map_or(Ok(()), |hz| Hertz::check("friction_cutoff_hz", hz))?;
        self.thin_to_hz.map_or(Ok(()), |hz| Hertz::check("thin_to_hz", hz))?;
        Seconds::check("max_gap_s", self.max_gap_s)?;
        SecondsOrNone::check("trim_s", self.trim_s)?;
        Order::check("order", self.order)?;
        self.decimate.map_or(Ok(()), |every| Every::check("decimate", every))
    }

    /// Every so-many-th sample is kept at the sampling time `dt` \[s\]; of a very long log, so many there are.
    pub(super) fn decimation(&self, dt: f64, very_long: Option<usize>) -> usize {
        let every = |per_period: f64| (1.0 / (per_period * self.band_hz * dt)) as usize;
        let automatic = match (self.mode, very_long) {
            (Mode::Inputs, _) => 1,
            (Mode::Parallel, None) => every(5.0),
            // All columns lose the same rows, so that fewer of them bias nothing, and enough are left.
            (Mode::Parallel, Some(samples)) => (samples / ENOUGH_ROWS).clamp(every(2.0), every(1.0)),
        };
        self.decimate.unwrap_or(automatic).max(1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ron_takes_some_fields_and_refuses_unknown_ones() {
        let some: Settings = ron::from_str("(mode: Parallel, band_hz: 8.0)").expect("fields may be left out");
        assert_eq!(some.mode, Mode::Parallel);
        assert_eq!(some.order, Settings::default().order);
        let typo = ron::from_str::<Settings>("(band: 8.0)").expect_err("a typo must not pass");
        assert!(typo.to_string().contains("band_hz"), "{typo}");
    }

    #[test]
    fn a_diagnosis_starts_from_the_documented_band_in_one_filter() {
        let usual = Settings::for_diagnosis();
        assert_eq!(usual.mode, Mode::Parallel);
        assert!((usual.band_hz - 8.0).abs() < 1e-12 && (usual.trim_s - 1.0).abs() < 1e-12);
        assert_eq!(Settings { mode: Mode::Inputs, ..usual.clone() }.in_parallel(), usual);
        usual.check().expect("they can work");
    }

    #[test]
    fn senseless_settings_are_named() {
        let name = |settings: Settings| settings.check().expect_err("must be refused").to_string();
        assert!(name(Settings { band_hz: 0.0, ..Settings::default() }).contains("band_hz"));
        assert!(name(Settings { trim_s: f64::NAN, ..Settings::default() }).contains("trim_s"));
        assert!(name(Settings { decimate: Some(0), ..Settings::default() }).contains("decimate"));
    }

    #[test]
    fn decimation_leaves_five_samples_per_period_of_the_band() {
        let parallel = Settings { mode: Mode::Parallel, ..Settings::default() };
        assert_eq!(parallel.decimation(0.001, None), 40);
        let long = [100_000, 1_500_000, 9_000_000].map(|samples| parallel.decimation(0.001, Some(samples)));
        assert_eq!(long, [100, 150, 200]);
        assert_eq!(parallel.decimation(0.1, None), 1);
        assert_eq!(Settings::default().decimation(0.001, Some(1_500_000)), 1);
    }
}
