//! A diagnosis for people: tables of at most 80 columns.

use crate::diagnose::{Diagnosis, Missing, Parameter, Verdict};

use super::wrap;

/// The whole answer as text.
pub fn diagnosis_text(d: &Diagnosis) -> String {
    let mut text = headline(d);
    text += &joints(d);
    for (title, list) in [("missing", &d.missing), ("small beside it", &d.minor)] {
        if !list.is_empty() {
            text += &format!("\n{title}\n");
            text += &list.iter().map(missing).collect::<String>();
        }
    }
    text += &unexplained(d);
    text += &ladder(d);
    text += &validation(d);
    text += &nested(d);
    text += &where_it_fails(d);
    text += &also(d);
    text += &format!("\n{}\n", signals(d));
    text
}

/// The answer in one sentence.
pub fn verdict(d: &Diagnosis) -> String {
    match (d.verdict, &d.first) {
        (Verdict::Nothing, _) => "nothing significant is missing".to_string(),
        (Verdict::Undecided, _) => "undecided: these data cannot tell".to_string(),
        (Verdict::Missing, None) => "something is missing".to_string(),
        (Verdict::Missing, Some(first)) => format!(
            "{:.0} % of the reducible error is on {}: {}",
            first.share_of_reducible_percent, first.joint, first.cause
        ),
    }
}

fn headline(d: &Diagnosis) -> String {
    let mut text = format!("{}\n", verdict(d));
    for line in wrap(&d.stop_reason, 78) {
        text += &format!("  {line}\n");
    }
    for u in &d.undecided {
        for line in wrap(&format!("{}; record {}", u.reason, u.record), 76) {
            text += &format!("  {line}\n");
        }
    }
    text
}

fn joints(d: &Diagnosis) -> String {
    let width = d.joints.iter().map(|j| j.name.len()).max().unwrap_or(0).max(6);
    let mut text = format!(
        "\ntorque error, held out [N m or N]: {}\n  {:width$} {:>9} {:>9} {:>9} {:>9} {:>9}\n",
        d.signals.folds, "", "torque", "model", "of it", "explained", "repeats"
    );
    for j in &d.joints {
        let percent = j.relative_error_percent.map_or("-".to_string(), |p| format!("{p:.1} %"));
        let floor = j.repeat_floor_rms.map_or("-".to_string(), |f| format!("{f:.4}"));
        let flag = if j.worse_than_constant { "  worse than a constant" } else { "" };
        text += &format!(
            "  {:width$} {:9.3} {:9.4} {percent:>9} {:9.4} {floor:>9}{flag}\n",
            j.name, j.torque_rms, j.held_out_rms, j.held_out_rms_after
        );
    }
    let pooled = d.baseline.held_out_relative_error_percent.map_or("-".to_string(), |p| format!("{p:.3} %"));
    let how = if d.baseline.fitted { "" } else { ", with the numbers of the robot file, nothing fitted" };
    for line in wrap(&format!("pooled {pooled} with {}{how}", d.baseline.effects.join(" + ")), 76) {
        text += &format!("  {line}\n");
    }
    text
}

fn missing(m: &Missing) -> String {
    let joints = if m.joints.is_empty() { "the whole robot".to_string() } else { m.joints.join(", ") };
    let mut text = format!("  {} on {joints}   z {:.1}, gain {:.1} %\n", m.effect, m.z, m.gain_percent);
    text += &format!("      {}\n", m.equation);
    for p in &m.parameters {
        text += &format!("      {}\n", number(p));
    }
    for (joint, [before, after]) in &m.held_out_rms {
        text += &format!("      {joint}: {before:.4} -> {after:.4} held out\n");
    }
    if !m.also_possible.is_empty() {
        text += &format!("      also possible: {}\n", m.also_possible.join(", "));
    }
    if let Some(remainder) = &m.remainder {
        text += &format!("      left: {remainder}\n");
    }
    text
}

fn number(p: &Parameter) -> String {
    let error = p.standard_error.map_or_else(String::new, |e| format!(" +- {e:.2e}"));
    format!("{} = {:.5}{error} {}", p.name, p.value, p.unit)
}

fn unexplained(d: &Diagnosis) -> String {
    let mut text = String::new();
    for u in &d.unexplained {
        text += &format!(
            "\nunknown on {}, depends on {}   z {:.1}, {:.0} % of the joint's error\n",
            u.joint,
            u.depends_on.join(", "),
            u.z,
            u.gain_percent
        );
        if let Some(formula) = &u.formula {
            text += &format!("      a shape that fits: {formula}\n");
            text += &match &u.script {
                Some(file) => format!("      written as an effect script: {file}\n"),
                None => "      --out DIR writes it as an effect script, ready for --add\n".to_string(),
            };
        }
        if let Some(nearest) = &u.nearest {
            text += &format!("      nearest known effect: {nearest}\n");
        }
    }
    text
}

fn ladder(d: &Diagnosis) -> String {
    if d.ladder.is_empty() {
        return String::new();
    }
    let mut text = String::from("\nladder, pooled held-out error\n");
    let percent = |p: Option<f64>| p.map_or("-".to_string(), |p| format!("{p:.3} %"));
    text += &format!("  {:>9}  start\n", percent(d.baseline.held_out_relative_error_percent));
    for step in &d.ladder {
        let joints = step.joints.join(", ");
        text +=
            &format!("  {:>9}  + {} {joints}\n", percent(step.held_out_relative_error_percent), step.effect);
    }
    text
}

fn validation(d: &Diagnosis) -> String {
    let Some(v) = &d.validation else { return String::new() };
    let percent = |p: Option<f64>| p.map_or("-".to_string(), |p| format!("{p:.3} %"));
    let mut text = format!(
        "\nvalidation log, never fitted: {} -> {}{}\n",
        percent(v.before_relative_error_percent),
        percent(v.after_relative_error_percent),
        if d.ladder.is_empty() { " with all of this added" } else { "" }
    );
    for (joint, [before, after]) in &v.rms {
        text += &format!("      {joint}: {before:.4} -> {after:.4}\n");
    }
    text
}

fn nested(d: &Diagnosis) -> String {
    let Some(n) = &d.nested else { return String::new() };
    let percent = |p: Option<f64>| p.map_or("-".to_string(), |p| format!("{p:.3} %"));
    let mut text = format!(
        "\neffects chosen before {} s, scored on the rest: {} -> {}\n",
        n.until_s,
        percent(n.before_relative_error_percent),
        percent(n.after_relative_error_percent)
    );
    for line in wrap(&n.effects.join(", "), 72) {
        text += &format!("      {line}\n");
    }
    text
}

fn where_it_fails(d: &Diagnosis) -> String {
    if d.regions.is_empty() {
        return String::new();
    }
    let mut text = String::from("\nwhere the starting model fails (rms held out)\n");
    for r in d.regions.iter().take(8) {
        text += &format!(
            "  {:12} {:>8} in {:9.3} .. {:9.3}  rms {:8.4}  z {:5.1}\n",
            r.joint, r.variable, r.from, r.to, r.rms, r.z
        );
    }
    text
}

fn also(d: &Diagnosis) -> String {
    let mut text = String::new();
    for r in &d.refused {
        let joints = if r.joints.is_empty() { "the robot".to_string() } else { r.joints.join(", ") };
        text += &format!("\nfits but refused: {} on {joints}: {}\n", r.effect, r.reason);
    }
    for i in &d.inseparable {
        text += &format!("\ncannot be told apart: {}\n", i.effects.join(" and "));
        for line in wrap(&i.separating_motion, 72) {
            text += &format!("      {line}\n");
        }
    }
    text
}

fn signals(d: &Diagnosis) -> String {
    let s = &d.signals;
    let hz = |x: Option<f64>| x.map_or("-".to_string(), |x| format!("{x}"));
    format!(
        "signals: band {} Hz, velocity {}, motion {} Hz, signs {} Hz, {} rows",
        s.band_hz,
        s.source_of_velocity,
        hz(s.position_cutoff_hz),
        hz(s.friction_cutoff_hz),
        s.rows_used
    )
}
