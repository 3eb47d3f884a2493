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
    let mut violation = 0.0_f64;
    let constraints = problem
        .forms
        .iter()
        .map(|form| {
            let margin = form.reported_margin(z);
            violation = violation.max(form.violation(z));
            ConstraintAudit {
                label: form.label.clone(),
                margin,
                unit: form.unit.clone(),
                active: margin / form.scale < ACTIVE,
            }
        })
        .collect();
    Audit { objective: problem.objective.value(z), violation, feasible: violation <= FEASIBLE, constraints }
}
