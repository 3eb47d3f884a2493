//! Retrieved link parameters as text.

use std::collections::BTreeMap;
use std::fmt::Write;

use super::layout::{cut, wrap};
use super::{Chosen, Comparison, Interval, Report, Retrieval};

/// Active constraints that are listed per engine.
const LISTED: usize = 8;
/// Widest joint name that is not cut.
const NAME: usize = 22;
/// Widest label that is not cut.
const WIDEST: usize = 13;

/// Engine by engine: objective, bound, feasibility; then link parameters side by side, what holds them back,
/// what is open, torque errors and joint wrenches.
pub(super) fn retrieved(text: &mut String, report: &Report) {
    let Some(engines) = &report.retrievals else { return };
    text.push_str("\nfeasible link parameters\n");
    if let Some(conflict) = &report.conflict {
        contradiction(text, conflict);
        return;
    }
    let chosen = report.chosen.as_ref().map(|c| &c.retrieval);
    let all: Vec<&Retrieval> =
        report.given.iter().chain(&report.beside).chain(engines).chain(chosen).collect();
    let width = all.iter().map(|r| r.label.chars().count()).max().unwrap_or(0).clamp(6, WIDEST);
    objectives(text, &all, &report.timing, width);
    if let Some(chosen) = &report.chosen {
        decided(text, chosen);
    }
    links(text, &all);
    all.iter().for_each(|r| active(text, r));
    if let Some(intervals) = &report.intervals {
        open(text, intervals);
    }
    if let Some(comparison) = &report.comparison {
        let labels: Vec<&str> = all.iter().map(|r| r.label.as_str()).collect();
        errors(text, comparison, &labels);
        wrenches(text, comparison, &labels);
    }
}

/// Whose parameters the finished model has, and why those.
pub fn whose(report: &Report) -> String {
    let Some(engines) = &report.retrievals else { return "identified coefficients".to_string() };
    if let Some(chosen) = &report.chosen {
        return format!("link parameters by choice: {}", chosen.rule);
    }
    let feasible: Vec<&Retrieval> = engines.iter().filter(|r| r.feasible).collect();
    let best = feasible.iter().min_by(|a, b| a.objective.total_cmp(&b.objective));
    match (best, feasible.len()) {
        (None, _) if report.conflict.is_some() => {
            "identified coefficients: the constraints contradict each other".to_string()
        }
        (None, _) => "identified coefficients: no engine found feasible link parameters".to_string(),
        (Some(best), 1) if engines.len() == 1 => format!("link parameters of `{}`", best.label),
        (Some(best), 1) => format!("link parameters of `{}`: the only ones that are feasible", best.label),
        (Some(best), count) => format!(
            "link parameters of `{}`: the smallest objective of {count} engines that found feasible ones",
            best.label
        ),
    }
}

fn contradiction(text: &mut String, conflict: &[String]) {
    text.push_str("  no parameters satisfy these constraints together:\n");
    for line in conflict.iter().flat_map(|label| wrap(label, 74)) {
        let _ = writeln!(text, "    {line}");
    }
    text.push_str("  dropping any one of them makes the others possible\n");
}

fn objectives(text: &mut String, all: &[&Retrieval], seconds: &BTreeMap<String, f64>, width: usize) {
    if let Some(first) = all.first() {
        let _ = writeln!(text, "  objective: {}", first.objective_unit);
    }
    let _ = writeln!(
        text,
        "  {:width$}  {:>12}  {:>12}  {:>9}  {:>12}  {:>7}",
        "engine", "objective", "lower bound", "gap", "feasible, by", "time"
    );
    for r in all {
        let feasible = if r.feasible { "yes" } else { "no" };
        // A point on a limit is as good as one beside it: nothing is written as 0, not as -0.
        let by = r.least_margin.map_or("-".to_string(), |m| format!("{:.0e}", m + 0.0));
        let _ = writeln!(
            text,
            "  {:width$.width$}  {:>12.6e}  {:>12}  {:>9}  {feasible:>3} {by:>8}  {:>7}",
            r.label,
            r.objective,
            r.lower_bound.map_or("-".to_string(), |b| format!("{b:.6e}")),
            r.certified_gap_percent.map_or("-".to_string(), gap),
            seconds.get(&r.label).map_or("-".to_string(), |s| format!("{s:.2} s"))
        );
    }
    if all.iter().any(|r| r.bound_is.as_deref() == Some("relaxation")) {
        text.push_str("  the bound is that of the convex relaxation: the optimum may lie above it\n");
    }
}

fn gap(percent: f64) -> String {
    if percent < 99_999.0 { format!("{} %", narrow(percent, 3)) } else { "> 1e5 %".to_string() }
}

fn decided(text: &mut String, chosen: &Chosen) {
    let open = match chosen.decided.len() {
        0 => String::new(),
        count => format!(": {count} parameters that data and constraints leave open"),
    };
    let rule = format!(
        "chosen: {}, among all with an objective up to {:.6e}. The choice decided, not the data{open}.",
        chosen.rule, chosen.largest_objective
    );
    for line in wrap(&rule, 76) {
        let _ = writeln!(text, "  {line}");
    }
}

/// Mass, centre of mass and inertia about it, link by link.
fn links(text: &mut String, all: &[&Retrieval]) {
    let Some(first) = all.first() else { return };
    text.push_str("\n  mass [kg], centre of mass [mm], inertia about it [1e-3 kg m^2]\n");
    for (i, link) in first.links.iter().enumerate() {
        let _ = write!(text, "  {:8}", cut(&link.name, 8));
        for name in ["m", "cx", "cy", "cz", "Ixx", "Ixy", "Ixz", "Iyy", "Iyz", "Izz"] {
            let _ = write!(text, "{name:>7}");
        }
        text.push('\n');
        for r in all {
            let link = &r.links[i];
            let _ = write!(text, "  {:8.8}{:>7}", r.label, narrow(link.mass, 3));
            for axis in 0..3 {
                let com = link.com.map_or("-".to_string(), |com| narrow(1e3 * com[axis], 1));
                let _ = write!(text, "{com:>7}");
            }
            for element in link.inertia {
                let _ = write!(text, "{:>7}", narrow(1e3 * element, 2));
            }
            text.push('\n');
        }
    }
    text.push('\n');
}

/// At most `digits` decimals, fewer where six characters would not do; nothing is written as 0, not as -0.
fn narrow(value: f64, digits: usize) -> String {
    let written = |digits: usize| {
        let text = format!("{value:.digits$}");
        match text.strip_prefix('-') {
            Some(plain) if plain.bytes().all(|b| b == b'0' || b == b'.') => plain.to_string(),
            _ => text,
        }
    };
    (0..=digits).rev().map(written).find(|text| text.len() <= 6).unwrap_or_else(|| written(0))
}

fn active(text: &mut String, r: &Retrieval) {
    let held: Vec<&str> = r.constraints.iter().filter(|c| c.active).map(|c| c.label.as_str()).collect();
    let _ = writeln!(text, "  {}: {} of {} constraints active", r.label, held.len(), r.constraints.len());
    for line in held.iter().take(LISTED).flat_map(|label| wrap(label, 74)) {
        let _ = writeln!(text, "    {line}");
    }
    if held.len() > LISTED {
        let _ = writeln!(text, "    and {} more, in report.json", held.len() - LISTED);
    }
}

/// Masses [kg] and centres of mass [mm], one line per link; inertias stand in the JSON.
fn open(text: &mut String, intervals: &[Interval]) {
    text.push_str("\n  what data and constraints allow (inertias: in report.json)\n");
    let end = |value: Option<f64>, factor: f64, digits: usize| {
        value.map_or("open".to_string(), |v| narrow(factor * v, digits))
    };
    let shown: Vec<&Interval> = intervals.iter().filter(|i| !i.parameter.starts_with('J')).collect();
    for link in shown.chunks(4) {
        let mut line = String::new();
        for (k, i) in link.iter().enumerate() {
            let (factor, digits) = if k == 0 { (1.0, 3) } else { (1e3, 0) };
            let (low, high) = (end(i.low, factor, digits), end(i.high, factor, digits));
            let _ = write!(line, "{} [{low}, {high}]{}", i.parameter, if k == 0 { " kg  " } else { " " });
        }
        for part in wrap(&(line + "mm"), 76) {
            let _ = writeln!(text, "  {part}");
        }
    }
}

/// Mean squared torque error, one line per joint, one column per set of parameters.
fn errors(text: &mut String, comparison: &Comparison, labels: &[&str]) {
    let how = if comparison.fitted { "fitted" } else { "never fitted" };
    text.push('\n');
    let title = format!("mean squared torque error [(N m)^2] on {} ({how})", comparison.data);
    for line in wrap(&title, 78) {
        let _ = writeln!(text, "  {line}");
    }
    let cell = |label: &str, joint: &str| Some(*comparison.validation_mse.get(label)?.get(joint)?);
    let pooled = |label: &str| *comparison.relative_error_percent.get(label)?;
    by_joint(text, &comparison.joints, labels, &cell, Some(("all [%]", &pooled)));
}

fn wrenches(text: &mut String, comparison: &Comparison, labels: &[&str]) {
    for (which, name) in ["force [N]", "moment [N m]"].into_iter().enumerate() {
        let _ = writeln!(text, "\n  mean {name} that each joint carries");
        let cell = |label: &str, joint: &str| Some(comparison.wrenches.get(label)?.get(joint)?[which]);
        by_joint(text, &comparison.joints, labels, &cell, None);
    }
}

/// A number of a set of parameters, where there is one.
type OfSet<'a> = &'a dyn Fn(&str) -> Option<f64>;

/// A line per joint, a column per set of parameters; below them a line for all joints, if any.
fn by_joint(
    text: &mut String,
    joints: &[String],
    labels: &[&str],
    cell: &dyn Fn(&str, &str) -> Option<f64>,
    all: Option<(&str, OfSet<'_>)>,
) {
    let names = joints.iter().map(String::as_str).chain(all.map(|(name, _)| name));
    let width = names.map(|n| n.chars().count()).max().unwrap_or(0).clamp(6, NAME);
    let values = || joints.iter().flat_map(|joint| labels.iter().filter_map(|label| cell(label, joint)));
    let largest = values().fold(0.0, |most: f64, value| most.max(value.abs()));
    let decimals = if largest < 10.0 { 4 } else { 2 };
    let written = |value: Option<f64>, decimals| value.map_or("-".to_string(), |v| short(v, decimals));
    for labels in labels.chunks(((80 - 2 - width) / (WIDEST + 1)).max(1)) {
        let mut line = |name: &str, value: &dyn Fn(&str) -> String| {
            let cells: String = labels.iter().map(|l| format!(" {:>WIDEST$.WIDEST$}", value(l))).collect();
            let _ = writeln!(text, "  {:width$}{cells}", cut(name, width));
        };
        line("joint", &str::to_string);
        joints.iter().for_each(|joint| line(joint, &|label| written(cell(label, joint), decimals)));
        if let Some((name, value)) = all {
            line(name, &|label| written(value(label), 3));
        }
    }
}

/// So many decimals where that says something.
fn short(value: f64, decimals: usize) -> String {
    if (1e-3..1e6).contains(&value.abs()) { format!("{value:.decimals$}") } else { format!("{value:.2e}") }
}
