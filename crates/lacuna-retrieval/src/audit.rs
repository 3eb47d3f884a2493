//! One judge for all engines: no engine marks its own work.

use serde::Serialize;

use super::Problem;

/// Largest scaled violation that counts as feasible.
pub const FEASIBLE: f64 = 1e-9;
/// A constraint is active when its scaled margin is below this.
const ACTIVE: f64 = 1e-5;

/// What a point is worth.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Audit {
    /// Value of the objective.
    pub objective: f64,
    /// Largest scaled violation; 0 when everything holds.
    pub violation: f64,
    /// Whether `violation <= 1e-9`.
    pub feasible: bool,
    /// The least scaled margin: what is left before the first constraint breaks, negative where one does;
    /// infinite without constraints.
    pub least_margin: f64,
    /// Every constraint, in the order of the problem.
    pub constraints: Vec<ConstraintAudit>,
}

/// One constraint at a point.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct ConstraintAudit {
    /// Label of the form.
    pub label: String,
    /// Margin in the constraint's own unit; not negative when it holds.
    pub margin: f64,
    /// Unit of the margin.
    pub unit: String,
    /// Whether the constraint holds the point back.
    pub active: bool,
}

/// Measures objective and every constraint at `z`, the same way for all engines.
pub fn audit(problem: &Problem, z: &[f64]) -> Audit {
    let (mut violation, mut least_margin) = (0.0_f64, f64::INFINITY);
    let constraints = problem
        .forms
        .iter()
        .map(|form| {
            let margin = form.reported_margin(z);
            violation = violation.max(form.violation(z));
            let scaled = margin / form.scale;
            least_margin = least_margin.min(if scaled.is_nan() { f64::NEG_INFINITY } else { scaled });
            ConstraintAudit {
                label: form.label.clone(),
                margin,
                unit: form.unit.clone(),
                active: margin / form.scale < ACTIVE,
            }
        })
        .collect();
    let (objective, feasible) = (problem.objective.value(z), violation <= FEASIBLE);
    Audit { objective, violation, feasible, least_margin, constraints }
}
