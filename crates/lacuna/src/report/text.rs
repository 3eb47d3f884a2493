//! The report as text: what a person reads in half a minute, in at most 80 columns.

use std::fmt::Write;

use super::diagnosis_text::diagnosis_text;
use super::layout::{cut, hanging, wrap};
use super::retrieval_text::retrieved;
use super::{Coefficient, FrictionResult, Identification, JointError, Report, Validation};

/// Uncertain coefficients that are listed.
const LISTED: usize = 6;

/// The whole report.
pub fn render(report: &Report) -> String {
    let mut text = format!(
        "{}: robot {}, seed {}, lacuna {}\n",
        report.scenario, report.robot, report.seed, report.lacuna
    );
    for identification in &report.identifications {
        identified(&mut text, identification);
    }
    if !report.friction.is_empty() {
        friction(&mut text, &report.friction);
    }
    if let Some(diagnosis) = &report.diagnosis {
        text += &format!("\nwhat is missing beside these effects\n{}", diagnosis_text(diagnosis));
    }
    retrieved(&mut text, report);
    if !report.warnings.is_empty() {
        text += "\nwarnings\n";
        for warning in &report.warnings {
            for (i, line) in wrap(warning, 74).into_iter().enumerate() {
                let _ = writeln!(text, "  {} {line}", if i == 0 { "!" } else { " " });
            }
        }
    }
    text
}

fn identified(text: &mut String, id: &Identification) {
    let _ =
        writeln!(text, "\nidentification from {} ({}, {} least squares)", id.label, id.mode, id.weighting);
    if id.signals.is_empty() || id.mode == "static" {
        for data in &id.data {
            for line in wrap(data, 78) {
                let _ = writeln!(text, "  {line}");
            }
        }
    }
    for line in id.signals.iter().flat_map(|l| wrap(l, 78)) {
        let _ = writeln!(text, "  {}", line);
    }
    let others = id.coefficients.len() - id.rank;
    let line = format!(
        "{} rows, {} base parameters{}, condition number {:.2} (SI, unscaled)",
        id.rows,
        id.rank,
        if others > 0 { format!(" + {others} others") } else { String::new() },
        id.condition_number
    );
    wrap(&line, 78).iter().for_each(|line| *text += &format!("  {line}\n"));
    let _ = write!(text, "  relative error {} in sample", percent(id.relative_error_percent));
    match (id.held_out_relative_error_percent, &id.split) {
        (Some(error), Some(split)) => {
            let _ = writeln!(text, ", {} held out", percent(error));
            *text += &hanging("  ", &format!("({split})"), 3);
        }
        _ => text.push('\n'),
    }
    if !id.joints.is_empty() {
        joints(text, &id.joints);
    }
    published(text, &id.coefficients);
    uncertain(text, id);
    for validation in &id.validation {
        validated(text, validation);
    }
}

fn joints(text: &mut String, joints: &[JointError]) {
    let width = name_width(joints);
    let _ = writeln!(
        text,
        "\n  {:width$}  {:>10}  {:>10}  {:>9}  {:>9}",
        "joint", "torque rms", "error rms", "in sample", "held out"
    );
    let _ = writeln!(text, "  {:width$}  {:>10}  {:>10}", "", "N m, N", "N m, N");
    for j in joints {
        let _ = writeln!(
            text,
            "  {:width$}  {:>10.3}  {:>10.4}  {:>9}  {:>9}{}",
            cut(&j.name, width),
            j.torque_rms,
            j.rms,
            optional(j.relative_error_percent),
            optional(j.held_out_relative_error_percent),
            if j.worse_than_constant { " *" } else { "" }
        );
    }
    worse(text, joints);
    text.push('\n');
}

/// What a star behind a joint means, where one has it.
fn worse(text: &mut String, joints: &[JointError]) {
    if joints.iter().any(|j| j.worse_than_constant) {
        text.push_str("  * worse than a constant\n");
    }
}

fn validated(text: &mut String, validation: &Validation) {
    let (data, error) = (&validation.data, percent(validation.relative_error_percent));
    text.push('\n');
    *text += &hanging("  ", &format!("predicted, never fitted: {data}, {error} pooled"), 4);
    let width = name_width(&validation.joints);
    for j in &validation.joints {
        let _ = writeln!(
            text,
            "  {:width$}  {:>10.3}  {:>10.4}  {:>9}{}",
            cut(&j.name, width),
            j.torque_rms,
            j.rms,
            optional(j.relative_error_percent),
            if j.worse_than_constant { " *" } else { "" }
        );
    }
    worse(text, &validation.joints);
}

fn name_width(joints: &[JointError]) -> usize {
    joints.iter().map(|j| j.name.chars().count()).max().unwrap_or(0).clamp(6, 28)
}

/// How far the coefficients are from published ones.
fn published(text: &mut String, coefficients: &[Coefficient]) {
    let pairs = coefficients.iter().filter_map(|c| Some((c, (c.value? - c.published?).abs())));
    let Some((worst, distance)) = pairs.max_by(|a, b| a.1.total_cmp(&b.1)) else { return };
    let line = format!("largest distance to a published coefficient {distance:.1e} ({})", worst.symbol);
    *text += &hanging("  ", &line, 4);
}

/// The coefficients that are known least, and what was dropped.
fn uncertain(text: &mut String, id: &Identification) {
    let robust = id.coefficients.iter().any(|c| c.robust_sd_percent.is_some());
    let sd = |c: &Coefficient| if robust { c.robust_sd_percent } else { c.relative_sd_percent };
    let mut sorted: Vec<&Coefficient> = id.coefficients.iter().filter(|c| sd(c).is_some()).collect();
    sorted.sort_by(|a, b| sd(b).unwrap_or(0.0).total_cmp(&sd(a).unwrap_or(0.0)));
    let kind = if robust { "autocorrelation-robust" } else { "white residuals" };
    let _ = writeln!(text, "  least certain (standard deviation, {kind}):");
    for c in sorted.iter().take(LISTED) {
        let dropped = if c.kept { "" } else { "  dropped" };
        let value = c.value.unwrap_or(f64::NAN);
        let deviation = sd(c).unwrap_or(f64::NAN);
        let name: String = c.expression.chars().take(40 - dropped.len()).collect();
        let _ = writeln!(text, "    {value:>11.4e} {:<8} {deviation:>8.1} %  {name}{dropped}", c.unit);
    }
    if let Some(counts) = &id.dropped_over_draws {
        let _ = writeln!(text, "  above {} % in {} draws of the noise:", counts.above_percent, counts.draws);
        for (expression, count) in &counts.dropped {
            *text += &hanging(&format!("    {count:>4} times  "), expression, 17);
        }
    }
}

fn friction(text: &mut String, results: &[FrictionResult]) {
    let _ = writeln!(text, "\nfriction path: rigid part frozen, sigmoid fitted to the rest (eq. 25)");
    let _ =
        writeln!(text, "  {:<12} {:>9} {:>10} {:>9}   rms without -> with", "joint", "phi1", "phi2", "phi3");
    let _ = writeln!(text, "  {:<12} {:>9} {:>10} {:>9}   N m", "", "N m", "s/rad", "rad/s");
    for r in results {
        let p: Vec<f64> = r.parameters.iter().map(|p| p.value).collect();
        let _ = writeln!(
            text,
            "  {:<12} {:>9.4} {:>10.3} {:>9.4}   {:.3} -> {:.3}",
            cut(&r.joint, 12),
            p[0],
            p[1],
            p[2],
            r.rms[0],
            r.rms[1]
        );
    }
}

fn percent(x: f64) -> String {
    if x < 0.1 { format!("{x:.6} %") } else { format!("{x:.3} %") }
}

fn optional(x: Option<f64>) -> String {
    x.map_or_else(|| "-".to_string(), |x| format!("{x:.2} %"))
}
