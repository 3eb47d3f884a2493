//! A diagnosis for people: tables of at most 80 columns.

use crate::diagnose::{Diagnosis, Missing, Parameter, Step, Verdict};

use super::layout::{cut, hanging, wrap};

/// Widest joint name in the table of joints.
const NAME: usize = 18;

/// The whole answer as text.
pub fn diagnosis_text(d: &Diagnosis) -> String {
    let mut text = headline(d);
    text += &joints(d);
    let missing_title = if asked(d).is_empty() { "missing" } else { "still missing" };
    for (title, list) in [(missing_title, &d.missing), ("small beside it", &d.minor)] {
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
    text += &format!("\n{}", signals(d));
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
    let asked = asked(d);
    let mut text = if asked.is_empty() { format!("{}\n", verdict(d)) } else { added(d, &asked) };
    text += &hanging("  ", &d.stop_reason, 2);
    for u in &d.undecided {
        text += &hanging("  ", &format!("{}; record {}", u.reason, u.record), 2);
    }
    text
}

/// The steps of the ladder that somebody asked for; the others are found.
pub(super) fn asked(d: &Diagnosis) -> Vec<&Step> {
    let found = |step: &Step| {
        let mut all = d.missing.iter().chain(&d.minor).filter(|m| m.effect == step.effect);
        step.effect == "formula" || all.any(|m| step.joints.iter().all(|j| m.joints.contains(j)))
    };
    d.ladder.iter().filter(|step| !found(step)).collect()
}

/// What was added and what it did; then what is left.
fn added(d: &Diagnosis, asked: &[&Step]) -> String {
    let as_it_is = |effect: &str| effect.to_string();
    let mut text: String = additions(d, asked, as_it_is).iter().map(|line| hanging("", line, 2)).collect();
    if let Some(v) = &d.validation {
        let (before, after) = (v.before_relative_error_percent, v.after_relative_error_percent);
        text += &format!("  validation log, never fitted: {} -> {}\n", percent(before), percent(after));
    }
    text += &hanging("", &left(d, as_it_is), 2);
    text
}

/// What every addition did to the error; effects are called what `name` makes of them.
pub(super) fn additions(d: &Diagnosis, asked: &[&Step], name: impl Fn(&str) -> String) -> Vec<String> {
    let mut before = d.baseline.held_out_relative_error_percent;
    let line = |step: &&Step| {
        let after = step.held_out_relative_error_percent;
        let refused = d.refused.iter().find(|r| r.effect == step.effect && r.joints == step.joints);
        let title = effect_on(&name(&step.effect), &step.joints);
        let line = match refused {
            Some(refused) => format!("not added: {title}: {}", refused.reason),
            None => format!("added {title}: held-out error {} -> {}", percent(before), percent(after)),
        };
        before = after;
        line
    };
    asked.iter().map(line).collect()
}

/// What is missing beside what was added.
pub(super) fn left(d: &Diagnosis, name: impl Fn(&str) -> String) -> String {
    let left = d.missing.iter().map(|m| effect_on(&name(&m.effect), &m.joints));
    let left: Vec<String> =
        left.chain(d.unexplained.iter().map(|u| format!("unknown on {}", u.joint))).collect();
    match d.verdict {
        Verdict::Undecided => verdict(d),
        _ if left.is_empty() => "nothing else of weight is missing".to_string(),
        _ => format!("still missing: {}", left.join("; ")),
    }
}

/// `friction on joint1, joint2`, or the effect alone where it is the whole robot's.
fn effect_on(effect: &str, joints: &[String]) -> String {
    if joints.is_empty() { effect.to_string() } else { format!("{effect} on {}", joints.join(", ")) }
}

fn percent(x: Option<f64>) -> String {
    x.map_or("-".to_string(), |p| format!("{p:.3} %"))
}

fn joints(d: &Diagnosis) -> String {
    let width = d.joints.iter().map(|j| j.name.chars().count()).max().unwrap_or(0).clamp(6, NAME);
    let added = asked(d).last().copied();
    let mut text = String::from("\n");
    text += &hanging("", &format!("torque error, held out [N m or N]: {}", d.signals.folds), 2);
    let title = |with: &str| if with.is_empty() { String::new() } else { format!(" {with:>9}") };
    text += &format!(
        "  {:width$} {:>9} {:>9} {:>9}{} {:>9} {:>9}\n",
        "",
        "torque",
        "model",
        "of it",
        title(added.map_or("", |_| "added")),
        "explained",
        "repeats"
    );
    for j in &d.joints {
        let percent = j.relative_error_percent.map_or("-".to_string(), |p| format!("{p:.1} %"));
        let floor = j.repeat_floor_rms.map_or("-".to_string(), |f| format!("{f:.4}"));
        let flag = if j.worse_than_constant { "*" } else { " " };
        let with = added.and_then(|step| step.rms.get(&j.name)).map(|rms| format!("{rms:.4}"));
        text += &format!(
            "{flag} {:width$} {:9.3} {:9.4} {percent:>9}{} {:9.4} {floor:>9}\n",
            cut(&j.name, width),
            j.torque_rms,
            j.held_out_rms,
            title(&with.unwrap_or_default()),
            j.held_out_rms_after
        );
    }
    if d.joints.iter().any(|j| j.worse_than_constant) {
        text += "* the model is worse than a constant\n";
    }
    let pooled = percent(d.baseline.held_out_relative_error_percent);
    let how = if d.baseline.fitted { "" } else { ", with the numbers of the robot file, nothing fitted" };
    text += &hanging("  ", &format!("pooled {pooled} with {}{how}", d.baseline.effects.join(" + ")), 2);
    text
}

fn missing(m: &Missing) -> String {
    let joints = if m.joints.is_empty() { "the whole robot".to_string() } else { m.joints.join(", ") };
    let mut text =
        spaced(&format!("{} on {joints}", m.effect), &format!("z {:.1}, gain {:.1} %", m.z, m.gain_percent));
    text += &hanging("      ", &m.equation, 8);
    for p in &m.parameters {
        text += &format!("      {}\n", number(p));
    }
    for (joint, [before, after]) in &m.held_out_rms {
        text += &format!("      {joint}: {before:.4} -> {after:.4} held out\n");
    }
    if !m.also_possible.is_empty() {
        text += &hanging("      ", &format!("also possible: {}", m.also_possible.join(", ")), 8);
    }
    if let Some(caveat) = &m.caveat {
        text += &hanging("      ", &format!("mind: {caveat}"), 8);
    }
    if let Some(remainder) = &m.remainder {
        text += &hanging("      ", &format!("left: {remainder}"), 8);
    }
    text
}

/// A title with its figures behind three blanks, or on the next line where both are too long for one.
fn spaced(title: &str, figures: &str) -> String {
    if title.chars().count() + figures.chars().count() <= 75 {
        return format!("  {title}   {figures}\n");
    }
    format!("{}      {figures}\n", hanging("  ", title, 6))
}

fn number(p: &Parameter) -> String {
    let error = p.standard_error.map_or_else(String::new, |e| format!(" +- {e:.2e}"));
    let unit = if p.unit == "1" { String::new() } else { format!(" {}", p.unit) };
    format!("{} = {:.5}{error}{unit}", p.name, p.value)
}

fn unexplained(d: &Diagnosis) -> String {
    let mut text = String::new();
    for u in &d.unexplained {
        let mut title = format!("unknown on {}, {}", u.joint, u.clue());
        if !u.depends_on.is_empty() {
            title += &format!("   z {:.1}, {:.0} % of the joint's error", u.z, u.gain_percent);
        }
        text.push('\n');
        text += &if title.chars().count() <= 80 { title + "\n" } else { hanging("", &title, 4) };
        if let Some(formula) = &u.formula {
            text += &hanging("      ", &format!("a shape that fits: {formula}"), 8);
            text += &match &u.script {
                Some(file) => hanging("      ", &format!("written as an effect script: {file}"), 8),
                None => "      --out DIR writes it as an effect script, ready for --add\n".to_string(),
            };
        }
        if let Some(nearest) = &u.nearest {
            text += &hanging("      ", &format!("nearest known effect: {nearest}"), 8);
        }
    }
    text
}

fn ladder(d: &Diagnosis) -> String {
    if d.ladder.is_empty() {
        return String::new();
    }
    let mut text = String::from("\nladder, pooled held-out error\n");
    text += &format!("  {:>9}  start\n", percent(d.baseline.held_out_relative_error_percent));
    for step in &d.ladder {
        let lead = format!("  {:>9}  + ", percent(step.held_out_relative_error_percent));
        text += &hanging(&lead, &effect_on(&step.effect, &step.joints), 15);
    }
    text
}

fn validation(d: &Diagnosis) -> String {
    let Some(v) = &d.validation else { return String::new() };
    if d.missing.is_empty() && d.minor.is_empty() && d.unexplained.is_empty() && d.ladder.is_empty() {
        return format!("\nvalidation log, never fitted: {}\n", percent(v.before_relative_error_percent));
    }
    let mut text = format!(
        "\nvalidation log, never fitted: {} -> {}{}\n",
        percent(v.before_relative_error_percent),
        percent(v.after_relative_error_percent),
        match (d.ladder.is_empty(), asked(d).len() == d.ladder.len()) {
            (true, _) => " with all of this added",
            (false, true) => " with what was asked for",
            (false, false) => "",
        }
    );
    let same = v.rms.values().all(|[before, after]| before.to_bits() == after.to_bits());
    if same && !(d.missing.is_empty() && d.minor.is_empty()) {
        return text + "      what was found is not in it: it acts in the data alone\n";
    }
    for (joint, [before, after]) in &v.rms {
        text += &format!("      {joint}: {before:.4} -> {after:.4}\n");
    }
    text
}

fn nested(d: &Diagnosis) -> String {
    let Some(n) = &d.nested else { return String::new() };
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
            "  {:12} {:>10} in {:9.3} .. {:9.3}  rms {:8.4}  z {:5.1}\n",
            cut(&r.joint, 12),
            cut(&r.variable, 10),
            r.from,
            r.to,
            r.rms,
            r.z
        );
    }
    text
}

fn also(d: &Diagnosis) -> String {
    let mut text = String::new();
    for r in &d.refused {
        let joints = if r.joints.is_empty() { "the robot".to_string() } else { r.joints.join(", ") };
        text.push('\n');
        text += &hanging("", &format!("fits but refused: {} on {joints}: {}", r.effect, r.reason), 6);
    }
    for i in &d.inseparable {
        text.push('\n');
        text += &hanging("", &format!("cannot be told apart: {}", apart(&i.effects)), 6);
        for line in wrap(&i.separating_motion, 72) {
            text += &format!("      {line}\n");
        }
    }
    text
}

/// A finding, and everything that looks like it.
fn apart(effects: &[String]) -> String {
    effects
        .split_first()
        .map_or_else(String::new, |(one, others)| format!("{one} and {}", others.join(" or ")))
}

fn signals(d: &Diagnosis) -> String {
    let s = &d.signals;
    let hz = |x: Option<f64>, none: &str| x.map_or(none.to_string(), |x| format!("{x} Hz"));
    let line = format!(
        "signals: band {} Hz, velocity {}, motion {}, signs {}{}, {} rows",
        s.band_hz,
        s.source_of_velocity,
        hz(s.position_cutoff_hz, "as it is"),
        hz(s.friction_cutoff_hz, "as motion"),
        s.source_of_friction_velocity.map_or_else(String::new, |from| format!(" {from}")),
        s.rows_used
    );
    let mut text = hanging("", &line, 9);
    for (log, thinned) in &s.thinned {
        text += &hanging("         ", &format!("{log}: {}", thinned.text()), 11);
    }
    text
}
