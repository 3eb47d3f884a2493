//! Retrieved link parameters as text.

use std::fmt::Write;

use super::{Comparison, Retrieval};

/// Active constraints that are listed per engine.
const LISTED: usize = 8;

/// Engine by engine: objective, bound, feasibility; then masses side by side and torque errors.
pub(super) fn retrieved(text: &mut String, all: &[Retrieval], comparison: Option<&Comparison>) {
    text.push_str("\nfeasible link parameters\n");
    if let Some(first) = all.first() {
        let _ = writeln!(text, "  objective: {}", first.objective_unit);
    }
    let width = all.iter().map(|r| r.label.chars().count()).max().unwrap_or(0).clamp(6, 20);
    let _ = writeln!(
        text,
        "  {:width$}  {:>12}  {:>12}  {:>9}  {:>9}",
        "engine", "objective", "lower bound", "gap", "feasible"
    );
    for r in all {
        let feasible = match (r.feasible, r.violation) {
            (true, _) => "yes".to_string(),
            (false, Some(v)) => format!("no {v:.0e}"),
            (false, None) => "no".to_string(),
        };
        let _ = writeln!(
            text,
            "  {:width$}  {:>12.6e}  {:>12}  {:>9}  {:>9}",
            r.label,
            r.objective,
            r.lower_bound.map_or("-".to_string(), |b| format!("{b:.6e}")),
            r.certified_gap_percent.map_or("-".to_string(), |g| format!("{g:.3} %")),
            feasible
        );
    }
    if all.iter().any(|r| r.bound_is.as_deref() == Some("relaxation")) {
        text.push_str("  the bound is that of the convex relaxation; what it leaves out is audited\n");
    }
    masses(text, all, width);
    for r in all {
        active(text, r);
    }
    if let Some(comparison) = comparison {
        errors(text, comparison, width);
    }
}

fn masses(text: &mut String, all: &[Retrieval], width: usize) {
    let Some(first) = all.first() else { return };
    let _ = write!(text, "\n  {:width$}", "mass [kg]");
    let shown = first.links.len().min(7);
    for link in &first.links[..shown] {
        let name: String = link.name.chars().take(8).collect();
        let _ = write!(text, " {name:>8}");
    }
    text.push('\n');
    for r in all {
        let _ = write!(text, "  {:width$}", r.label);
        for link in &r.links[..shown] {
            let _ = write!(text, " {:>8.3}", link.mass);
        }
        text.push('\n');
    }
    text.push_str("  many sets are equally good: data and constraints decide only in part\n");
}

fn active(text: &mut String, r: &Retrieval) {
    let held: Vec<&str> = r.constraints.iter().filter(|c| c.active).map(|c| c.label.as_str()).collect();
    let _ = writeln!(text, "  {}: {} of {} constraints active", r.label, held.len(), r.constraints.len());
    for label in held.iter().take(LISTED) {
        let _ = writeln!(text, "    {label}");
    }
    if held.len() > LISTED {
        let _ = writeln!(text, "    and {} more, in report.json", held.len() - LISTED);
    }
}

fn errors(text: &mut String, comparison: &Comparison, width: usize) {
    let _ = writeln!(text, "\n  mean squared torque error [(N m)^2] on {}", comparison.data);
    for (label, joints) in &comparison.validation_mse {
        let _ = write!(text, "  {label:width$}");
        for value in joints.values().take(7) {
            let _ = write!(text, " {value:>8.4}");
        }
        text.push('\n');
    }
}
