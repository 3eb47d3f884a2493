//! The answer as plain data, in the layout of `diagnosis.json`.

use std::collections::BTreeMap;

use serde::Serialize;

use crate::signals::ThinnedReport;

/// What comparing model and measurement found.
#[derive(Debug, Clone, Serialize)]
pub struct Diagnosis {
    /// Version.
    pub lacuna: String,
    /// Whether something is missing.
    pub verdict: Verdict,
    /// How the signals were prepared.
    pub signals: Signals,
    /// Errors of the starting model, joint by joint.
    pub joints: Vec<Joint>,
    /// The starting model.
    pub baseline: Baseline,
    /// Where most of the reducible error lies, and why.
    pub first: Option<First>,
    /// What is missing, most important first.
    pub missing: Vec<Missing>,
    /// Significant, but small beside what else there is.
    pub minor: Vec<Missing>,
    /// Structure that no known effect explains.
    pub unexplained: Vec<Unexplained>,
    /// What fits but cannot be.
    pub refused: Vec<Refused>,
    /// What this motion cannot tell apart.
    pub inseparable: Vec<Inseparable>,
    /// Where the starting model fails.
    pub regions: Vec<Region>,
    /// What happened in an interval only.
    pub events: Vec<Event>,
    /// Parameters that changed when the missing effects came in.
    pub moved: Vec<Moved>,
    /// One entry per effect that was added on request.
    pub ladder: Vec<Step>,
    /// What could not be decided, and what to record.
    pub undecided: Vec<Undecided>,
    /// Errors on a log that is never fitted.
    pub validation: Option<Validation>,
    /// The same search on the first part of the data, scored on the rest.
    pub nested: Option<Nested>,
    /// Threshold of z, and how high sign flips of these data reach.
    pub gate: [f64; 2],
    /// Why the search ended.
    pub stop_reason: String,
    /// Seconds per step; the only part that differs from run to run.
    pub timing: BTreeMap<String, f64>,
}

/// The answer in one word.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Verdict {
    /// The model lacks something.
    Missing,
    /// Nothing significant is missing.
    Nothing,
    /// These data cannot tell.
    Undecided,
}

/// Settings of the signal step, as chosen or given.
#[derive(Debug, Clone, Serialize)]
pub struct Signals {
    /// Always `parallel`: one filter on torque and on every column.
    pub mode: &'static str,
    /// Band of all errors \[Hz\].
    pub band_hz: f64,
    /// `logged` or `position`.
    pub source_of_velocity: &'static str,
    /// Cut-off before differentiation \[Hz\].
    pub position_cutoff_hz: Option<f64>,
    /// Cut-off of velocities inside a sign \[Hz\].
    pub friction_cutoff_hz: Option<f64>,
    /// Source of the velocities in signs, `logged` or `position`, where they have their own cut-off.
    pub source_of_friction_velocity: Option<&'static str>,
    /// Width of the smoothed sign of each joint [rad/s, m/s].
    pub sign_width: Vec<f64>,
    /// Cut from both ends \[s\].
    pub trim_s: f64,
    /// Rows per joint.
    pub rows_used: usize,
    /// Rows of the logs that were left out, by reason.
    pub rows_dropped: BTreeMap<String, usize>,
    /// Very long logs of which only every so-many-th sample was kept, by name.
    pub thinned: BTreeMap<String, ThinnedReport>,
    /// How data were held out.
    pub folds: String,
}

/// Errors of the starting model on one joint.
#[derive(Debug, Clone, Serialize)]
pub struct Joint {
    /// Joint.
    pub name: String,
    /// Root mean square of the torque in the band [N m, N].
    pub torque_rms: f64,
    /// Root mean square of the held-out residual [N m, N].
    pub held_out_rms: f64,
    /// `100 |residual| / |torque|`, held out.
    pub relative_error_percent: Option<f64>,
    /// What repetitions of the same motion differ by [N m, N].
    pub repeat_floor_rms: Option<f64>,
    /// Whether a constant would have predicted the torque better.
    pub worse_than_constant: bool,
    /// Held-out residual with everything that was found [N m, N].
    pub held_out_rms_after: f64,
}

/// The starting model.
#[derive(Debug, Clone, Serialize)]
pub struct Baseline {
    /// Its effects.
    pub effects: Vec<String>,
    /// Whether its numbers were fitted to the data; `false` when those of the robot file were compared as they are.
    pub fitted: bool,
    /// Pooled over all joints.
    pub held_out_relative_error_percent: Option<f64>,
}

/// Where most of the reducible error lies.
#[derive(Debug, Clone, Serialize)]
pub struct First {
    /// Joint.
    pub joint: String,
    /// Its part of all reducible error, joints measured by their own noise floor.
    pub share_of_reducible_percent: f64,
    /// Name of the effect, or `unknown`.
    pub cause: String,
}

/// A number of an effect.
#[derive(Debug, Clone, Serialize)]
pub struct Parameter {
    /// Name.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard error that allows for autocorrelation.
    pub standard_error: Option<f64>,
}

/// An effect that is missing.
#[derive(Debug, Clone, Serialize)]
pub struct Missing {
    /// Name of the effect.
    pub effect: String,
    /// Joints it acts on; empty for the whole robot.
    pub joints: Vec<String>,
    /// Torque as a formula.
    pub equation: String,
    /// Its numbers.
    pub parameters: Vec<Parameter>,
    /// Part of the held-out weighted squared error that it removed.
    pub gain_percent: f64,
    /// Significance; 5 and more is believed.
    pub z: f64,
    /// Held-out rms before and after, joint by joint.
    pub held_out_rms: BTreeMap<String, [f64; 2]>,
    /// Explanations that these data cannot tell from it.
    pub also_possible: Vec<String>,
    /// Where in the data it acts.
    #[serde(rename = "where")]
    pub place: String,
    /// Structure that is left on its own variable.
    pub remainder: Option<String>,
    /// What everybody who reads its numbers must know.
    pub caveat: Option<String>,
}

/// Structure that no known effect explains.
#[derive(Debug, Clone, Serialize)]
pub struct Unexplained {
    /// Joint.
    pub joint: String,
    /// Variables it depends on (`q3`).
    pub depends_on: Vec<String>,
    /// A formula that fits.
    pub formula: Option<String>,
    /// File of an effect script that can be added, in the folder that results are written to.
    pub script: Option<String>,
    /// Significance.
    pub z: f64,
    /// Part of the joint's held-out squared error that it explains.
    pub gain_percent: f64,
    /// The known effect that comes nearest.
    pub nearest: Option<String>,
    /// Error in units of the joint's noise floor, where it follows no variable of the log.
    pub floors: Option<f64>,
}

impl Unexplained {
    /// What is known of it: the variables it depends on, or that it follows none.
    pub fn clue(&self) -> String {
        match (self.depends_on.as_slice(), self.floors) {
            ([], Some(floors)) => format!("{floors:.1} times its floor, and follows no variable of the log"),
            ([], None) => "follows no variable of the log".to_string(),
            (names, _) => format!("depends on {}", names.join(", ")),
        }
    }
}

/// What fits but cannot be.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Refused {
    /// Name of the effect.
    pub effect: String,
    /// Joints; empty for the whole robot.
    pub joints: Vec<String>,
    /// Why.
    pub reason: String,
}

/// Effects that this motion cannot tell apart.
#[derive(Debug, Clone, Serialize)]
pub struct Inseparable {
    /// Names, with their joint.
    pub effects: Vec<String>,
    /// A motion that would tell.
    pub separating_motion: String,
}

/// Where the starting model fails.
#[derive(Debug, Clone, Serialize)]
pub struct Region {
    /// Joint whose torque is off.
    pub joint: String,
    /// Variable (`q3`, `dq3`, `ddq3`, `load`, `time`, a channel).
    pub variable: String,
    /// Lower end of the region.
    pub from: f64,
    /// Upper end.
    pub to: f64,
    /// Root mean square of the residual there [N m, N].
    pub rms: f64,
    /// Number of rows.
    pub rows: usize,
    /// How far it stands out from the joint's other rows.
    pub z: f64,
}

/// What happened in an interval.
#[derive(Debug, Clone, Serialize)]
pub struct Event {
    /// `contact_force`.
    pub kind: &'static str,
    /// Start \[s\].
    pub from_s: f64,
    /// End \[s\].
    pub to_s: f64,
    /// Force in the base frame \[N\].
    pub force_n: [f64; 3],
}

/// A parameter that changed.
#[derive(Debug, Clone, Serialize)]
pub struct Moved {
    /// What it stands for.
    pub parameter: String,
    /// In the starting model.
    pub before: f64,
    /// With everything that was found.
    pub after: f64,
    /// Of the value after.
    pub standard_error: Option<f64>,
    /// Unit.
    pub unit: String,
}

/// One step of the ladder.
#[derive(Debug, Clone, Serialize)]
pub struct Step {
    /// Effect that was added.
    pub effect: String,
    /// Joints.
    pub joints: Vec<String>,
    /// Pooled held-out error with it.
    pub held_out_relative_error_percent: Option<f64>,
    /// Held-out rms of each joint with it.
    pub rms: BTreeMap<String, f64>,
}

/// What could not be decided.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Undecided {
    /// Why.
    pub reason: String,
    /// What to record.
    pub record: String,
}

/// Errors on a log that is never fitted.
#[derive(Debug, Clone, Serialize)]
pub struct Validation {
    /// Of the starting model.
    pub before_relative_error_percent: Option<f64>,
    /// With everything that was found.
    pub after_relative_error_percent: Option<f64>,
    /// Before and after, joint by joint [N m, N].
    pub rms: BTreeMap<String, [f64; 2]>,
}

/// Effects chosen and fitted on the first part of the data, scored on the rest: the error nobody has tuned to.
#[derive(Debug, Clone, Serialize)]
pub struct Nested {
    /// End of the first part \[s\].
    pub until_s: f64,
    /// What was found in it.
    pub effects: Vec<String>,
    /// Error of the starting model on the rest.
    pub before_relative_error_percent: Option<f64>,
    /// Error with what was found on the rest.
    pub after_relative_error_percent: Option<f64>,
}
