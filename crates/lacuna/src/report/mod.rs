//! Results as plain data, in the layout of `report.json`; and as text for people.

mod diagnosis_text;
mod layout;
pub mod page;
pub mod pictures;
mod retrieval_text;
mod text;

pub use diagnosis_text::{diagnosis_text, verdict};
pub use layout::{command, cut, hanging, wrap};
pub use retrieval_text::whose;
pub use text::render;

use std::collections::BTreeMap;

use serde::Serialize;

use crate::diagnose::Diagnosis;
use crate::identify::Errors;
use crate::retrieval::ConstraintAudit;
use crate::robot::InertialParameters;

/// What a scenario found. Parts that were not asked for are `None`.
#[derive(Debug, Clone, Serialize)]
pub struct Report {
    /// Version.
    pub lacuna: String,
    /// Seed of every random draw.
    pub seed: u64,
    /// Name of the scenario.
    pub scenario: String,
    /// Name of the robot.
    pub robot: String,
    /// The main identification: from static poses when the scenario has them, else from logs.
    pub identification: Option<Identification>,
    /// All identifications, the main one first.
    pub identifications: Vec<Identification>,
    /// The friction path, joint by joint.
    pub friction: Vec<FrictionResult>,
    /// What is missing beside the scenario's effects, where it asks for that.
    pub diagnosis: Option<Diagnosis>,
    /// Retrieved link parameters, engine by engine; `None` when the study has no engine.
    pub retrievals: Option<Vec<Retrieval>>,
    /// The robot file's own inertias on the same problem, where it has them.
    pub given: Option<Retrieval>,
    /// The same for the inertias of other files, where the scenario names some.
    pub beside: Vec<Retrieval>,
    /// Constraints that cannot hold together, a smallest set; `None` when there is no contradiction.
    pub conflict: Option<Vec<String>>,
    /// What data and constraints determine.
    pub intervals: Option<Vec<Interval>>,
    /// Parameters that the user's rule took among equally good ones.
    pub chosen: Option<Chosen>,
    /// Retrieved parameters side by side.
    pub comparison: Option<Comparison>,
    /// What deserves attention.
    pub warnings: Vec<String>,
    /// Seconds per step; the only part that differs from run to run.
    pub timing: BTreeMap<String, f64>,
}

/// One identification.
#[derive(Debug, Clone, Serialize)]
pub struct Identification {
    /// What it is called in the study.
    pub label: String,
    /// `static`, `inputs` or `parallel`.
    pub mode: String,
    /// Where the data come from.
    pub data: Vec<String>,
    /// Signal step in words, one line each.
    pub signals: Vec<String>,
    /// How the data were held out, in words.
    pub split: Option<String>,
    /// `ordinary`, `joint` or `huber`.
    pub weighting: String,
    /// Number of scalar rows.
    pub rows: usize,
    /// Rank of the rigid-body part.
    pub rank: usize,
    /// Condition number of the whole regressor used, SI units, unscaled.
    pub condition_number: f64,
    /// In sample.
    pub relative_error_percent: f64,
    /// Pooled over all folds.
    pub held_out_relative_error_percent: Option<f64>,
    /// Per joint; empty for static poses.
    pub joints: Vec<JointError>,
    /// One per parameter.
    pub coefficients: Vec<Coefficient>,
    /// Symbols that the motion does not excite; they are left at zero.
    pub not_excited: Vec<String>,
    /// For read-outs of a known model: how often each coefficient was dropped over many noise draws.
    pub dropped_over_draws: Option<DropCounts>,
    /// Logs that were only predicted.
    pub validation: Vec<Validation>,
}

/// How often coefficients are dropped when the noise is drawn again.
#[derive(Debug, Clone, Serialize)]
pub struct DropCounts {
    /// Number of draws.
    pub draws: usize,
    /// Threshold [% standard deviation].
    pub above_percent: f64,
    /// `(expression, times dropped)`, only those dropped at least once.
    pub dropped: Vec<(String, usize)>,
}

/// A log that was predicted and not fitted.
#[derive(Debug, Clone, Serialize)]
pub struct Validation {
    /// File name.
    pub data: String,
    /// Over all rows.
    pub relative_error_percent: f64,
    /// Per joint.
    pub joints: Vec<JointError>,
}

/// Errors of one joint.
#[derive(Debug, Clone, Serialize)]
pub struct JointError {
    /// Joint.
    pub name: String,
    /// Root mean square of the torque [N m, N].
    pub torque_rms: f64,
    /// Root mean square of the residual [N m, N]; in sample for identifications.
    pub rms: f64,
    /// `100 |residual| / |torque|`.
    pub relative_error_percent: Option<f64>,
    /// The same, held out.
    pub held_out_relative_error_percent: Option<f64>,
    /// Whether a constant would have predicted the torque better.
    pub worse_than_constant: bool,
}

/// One identified parameter.
#[derive(Debug, Clone, Serialize)]
pub struct Coefficient {
    /// Grouped expression or symbol.
    pub expression: String,
    /// Leading symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// Value.
    pub value: Option<f64>,
    /// Standard deviation for white residuals, in per cent of the value.
    pub relative_sd_percent: Option<f64>,
    /// Standard deviation that allows for autocorrelation, in per cent of the value.
    pub robust_sd_percent: Option<f64>,
    /// Whether the value is certain enough to be used.
    pub kept: bool,
    /// Published value of the same coefficient, where the scenario has one.
    pub published: Option<f64>,
}

/// Friction of one joint from the friction path.
#[derive(Debug, Clone, Serialize)]
pub struct FrictionResult {
    /// Joint.
    pub joint: String,
    /// Effect's name.
    pub effect: String,
    /// Fitted parameters.
    pub parameters: Vec<NamedValue>,
    /// Residual rms without and with the friction [N m].
    pub rms: [f64; 2],
}

/// What one engine found, judged by the one audit.
#[derive(Debug, Clone, Serialize)]
pub struct Retrieval {
    /// Engine.
    pub engine: String,
    /// Unique in the study.
    pub label: String,
    /// Objective.
    pub objective: f64,
    /// Unit of the objective.
    pub objective_unit: String,
    /// Largest scaled violation; `None` when a margin is not a number.
    pub violation: Option<f64>,
    /// `violation <= 1e-9`.
    pub feasible: bool,
    /// The least scaled margin, negative where a constraint is violated; `None` without constraints.
    pub least_margin: Option<f64>,
    /// Certified: no feasible point has a smaller objective.
    pub lower_bound: Option<f64>,
    /// `100 (objective - lower bound) / lower bound`.
    pub certified_gap_percent: Option<f64>,
    /// `exact`, or `relaxation` where constraints had to be left out of the bound.
    pub bound_is: Option<String>,
    /// Independent runs; 0 for parameters that no engine found.
    pub runs: usize,
    /// Stages of each run.
    pub stages: usize,
    /// How it ended.
    pub status: String,
    /// Link parameters.
    pub links: Vec<LinkParameters>,
    /// Other parameters that were retrieved along (friction, in one step).
    pub others: Vec<NamedValue>,
    /// Every constraint.
    pub constraints: Vec<ConstraintAudit>,
}

/// Parameters of one link.
#[derive(Debug, Clone, Serialize)]
pub struct LinkParameters {
    /// Link.
    pub name: String,
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\]; `None` below 1e-6 kg.
    pub com: Option<[f64; 3]>,
    /// `xx, xy, xz, yy, yz, zz` about the centre of mass (about the origin where there is none) [kg m²].
    pub inertia: [f64; 6],
}

impl LinkParameters {
    /// From the parameters about the link origin.
    pub fn new(name: &str, link: &InertialParameters) -> Self {
        let i = link.inertia_at_center_of_mass().unwrap_or_else(|| link.inertia_at_origin());
        Self {
            name: name.to_string(),
            mass: link.mass(),
            com: link.center_of_mass().map(Into::into),
            inertia: [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)].map(|at| i[at]),
        }
    }
}

/// What data and constraints leave open of one parameter.
#[derive(Debug, Clone, Serialize)]
pub struct Interval {
    /// Parameter (`m1`, `c1x`, `J1xx`).
    pub parameter: String,
    /// Smallest value.
    pub low: Option<f64>,
    /// Largest value.
    pub high: Option<f64>,
    /// Unit.
    pub unit: String,
}

/// Width of an interval, in parts of its larger end, from which it counts as open.
const OPEN: f64 = 0.01;
/// Width that counts as none: 10 mg, 10 um, 0.1 kg cm^2.
const NARROW: f64 = 1e-5;

impl Interval {
    /// Whether data and constraints leave the parameter open: more than 1 % of its larger end, and more than
    /// 10 mg, 10 um or 0.1 kg cm².
    pub fn is_open(&self) -> bool {
        match (self.low, self.high) {
            (Some(low), Some(high)) => high - low > (OPEN * low.abs().max(high.abs())).max(NARROW),
            _ => true,
        }
    }
}

/// Parameters chosen among equally good ones.
#[derive(Debug, Clone, Serialize)]
pub struct Chosen {
    /// The rule, in words.
    pub rule: String,
    /// Objective up to which parameters count as equally good.
    pub largest_objective: f64,
    /// Parameters whose intervals are open: the rule decided them. Empty when no intervals were asked for.
    pub decided: Vec<String>,
    /// The parameters.
    pub retrieval: Retrieval,
}

/// Retrieved parameters side by side.
#[derive(Debug, Clone, Serialize)]
pub struct Comparison {
    /// The joints' names, in the robot's order.
    pub joints: Vec<String>,
    /// Mean squared torque error through Newton-Euler, friction added: label, then joint [(N m)²].
    pub validation_mse: BTreeMap<String, BTreeMap<String, f64>>,
    /// `100 |residual| / |torque|` over all joints: label.
    pub relative_error_percent: BTreeMap<String, Option<f64>>,
    /// Which data.
    pub data: String,
    /// Whether something was fitted to these data: the scenario names no others.
    pub fitted: bool,
    /// Mean size of the force and of the moment each joint carries: label, then joint [N, N m].
    pub wrenches: BTreeMap<String, BTreeMap<String, [f64; 2]>>,
}

/// A number with name and unit.
#[derive(Debug, Clone, Serialize)]
pub struct NamedValue {
    /// Symbol.
    pub name: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
}

/// A number for JSON, which knows no NaN and no infinity.
pub fn finite(x: f64) -> Option<f64> {
    x.is_finite().then_some(x)
}

/// Errors as rows of the report.
pub fn joint_errors(names: &[String], errors: &Errors, held_out: Option<&Errors>) -> Vec<JointError> {
    names
        .iter()
        .enumerate()
        .map(|(j, name)| JointError {
            name: name.clone(),
            torque_rms: errors.torque_rms[j],
            rms: errors.rms[j],
            relative_error_percent: finite(errors.relative_percent[j]),
            held_out_relative_error_percent: held_out.and_then(|h| finite(h.relative_percent[j])),
            worse_than_constant: errors.worse_than_constant.get(j).copied().unwrap_or(false),
        })
        .collect()
}
