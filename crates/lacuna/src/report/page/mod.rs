//! The report as one self-contained page: data as JSON, style and script in the file, nothing fetched.
//!
//! The script only draws. It is made of small modules (`*.js`) that a page served by a program can import as
//! they are; here they are joined into one script.

mod data;

use crate::diagnose::{Diagnosis, Verdict};
use crate::error::Result;
use crate::report::diagnosis_text::{additions, asked, left};
use crate::report::pictures::Pictures;
use crate::report::{Report, verdict};

/// The page's frame.
const FRAME: &str = include_str!("page.html");
/// Its style.
const STYLE: &str = include_str!("page.css");
/// Terms explained on hover and at the end.
const GLOSSARY: &str = include_str!("glossary.json");
/// Effects that the first sentence names at most.
const MOST_NAMED: usize = 3;
/// Its script, in the order of use.
const SCRIPTS: [(&str, &str); 14] = [
    ("dom.js", include_str!("dom.js")),
    ("numbers.js", include_str!("numbers.js")),
    ("pyramid.js", include_str!("pyramid.js")),
    ("canvas.js", include_str!("canvas.js")),
    ("time_axis.js", include_str!("time_axis.js")),
    ("plot.js", include_str!("plot.js")),
    ("heat.js", include_str!("heat.js")),
    ("partial.js", include_str!("partial.js")),
    ("bars.js", include_str!("bars.js")),
    ("answer.js", include_str!("answer.js")),
    ("curves.js", include_str!("curves.js")),
    ("study.js", include_str!("study.js")),
    ("explain.js", include_str!("explain.js")),
    ("page.js", include_str!("page.js")),
];

/// What a page shows.
#[derive(Debug, Clone, Copy)]
pub struct Page<'a> {
    /// Name of the study or log.
    pub title: &'a str,
    /// An answer to what is missing.
    pub diagnosis: Option<&'a Diagnosis>,
    /// Results of a scenario.
    pub report: Option<&'a Report>,
    /// Series and curves.
    pub pictures: Option<&'a Pictures>,
}

impl Page<'_> {
    /// The page as HTML. Nothing of what it shows can become markup or script.
    ///
    /// # Errors
    /// When a number cannot be written as JSON.
    pub fn html(&self) -> Result<String> {
        let data = data::Data::of(self)?.text()?;
        let script: String = SCRIPTS.iter().map(|(name, text)| joined(name, text)).collect();
        // One pass over the frame: whatever the data say is not searched for places to fill.
        let mut html = String::with_capacity(data.len() + script.len() + STYLE.len() + FRAME.len());
        let mut rest = FRAME;
        while let Some((before, after)) = rest.split_once("{{") {
            let (place, after) = after.split_once("}}").unwrap_or((after, ""));
            html += before;
            html += match place {
                "style" => STYLE,
                "data" => &data,
                "script" => &script,
                _ => "",
            };
            if place == "title" {
                html += &escaped(&format!("{} - lacuna", self.title));
            }
            rest = after;
        }
        Ok(html + rest)
    }

    /// What the page's script reads, for a program that serves the scripts as they are ([`modules`]).
    ///
    /// # Errors
    /// When a number cannot be written as JSON.
    pub fn data(&self) -> Result<serde_json::Value> {
        data::Data::of(self)?.value()
    }

    /// The answer: one sentence, then what supports it.
    pub fn verdict(&self) -> Vec<String> {
        match (self.diagnosis, self.report) {
            (Some(diagnosis), None) => answer(diagnosis),
            (Some(diagnosis), Some(report)) => {
                std::iter::once(study_verdict(report)).chain(answer(diagnosis)).collect()
            }
            (None, Some(report)) => vec![study_verdict(report)],
            (None, None) => vec![self.title.to_string()],
        }
    }
}

/// The page's modules and its style sheet, by file name.
pub fn modules() -> impl Iterator<Item = (&'static str, &'static str)> {
    SCRIPTS.into_iter().chain([("page.css", STYLE)])
}

/// What is missing, in one sentence; where, and why the search ended.
fn answer(d: &Diagnosis) -> Vec<String> {
    let asked = asked(d);
    if !asked.is_empty() {
        let done = additions(d, &asked, spoken).join("; ");
        return vec![done, left(d, spoken), d.stop_reason.clone()];
    }
    let on = |joints: &[String]| match joints {
        [] => String::new(),
        joints => format!(" on {}", joints.join(", ")),
    };
    let named = d.missing.iter().map(|m| format!("{}{}", spoken(&m.effect), on(&m.joints)));
    let unnamed = d.unexplained.iter().map(|u| {
        let that = if u.depends_on.is_empty() { ":" } else { " that" };
        format!("something without a name on {}{that} {}", u.joint, u.clue())
    });
    let found: Vec<String> = named.chain(unnamed).collect();
    let mut lines = Vec::new();
    if d.verdict == Verdict::Missing && !found.is_empty() {
        let more = found.len().saturating_sub(MOST_NAMED);
        let rest = if more > 0 { format!("; and {more} more") } else { String::new() };
        lines.push(format!("missing: {}{rest}", found[..found.len() - more].join("; ")));
    }
    // Names of joints stay as they are.
    let cause = d.first.as_ref().map_or("", |f| f.cause.as_str());
    let place = match verdict(d).strip_suffix(cause) {
        Some(before) => format!("{before}{}", spoken(cause)),
        None => verdict(d),
    };
    lines.extend([place, d.stop_reason.clone()]);
    lines
}

/// An effect's name for people.
fn spoken(effect: &str) -> String {
    effect.replace('_', " ")
}

/// What a scenario came to, in one sentence.
fn study_verdict(report: &Report) -> String {
    let mut parts = Vec::new();
    if let Some(main) = &report.identification {
        let percent = main.held_out_relative_error_percent.unwrap_or(main.relative_error_percent);
        let how = if main.held_out_relative_error_percent.is_some() { "held out" } else { "in sample" };
        parts.push(format!("the model leaves {percent:.3} % of the torque unexplained, {how}"));
    }
    if let Some(all) = &report.retrievals {
        let feasible = all.iter().filter(|r| r.feasible).count();
        parts.push(match feasible {
            _ if report.conflict.is_some() => {
                "no link parameters satisfy these constraints together".to_string()
            }
            0 => "no engine found feasible link parameters".to_string(),
            1 if all.len() == 1 => "the engine found feasible link parameters".to_string(),
            n if n == all.len() => format!("all {n} engines found feasible link parameters"),
            n => format!("{n} of {} engines found feasible link parameters", all.len()),
        });
    }
    parts.join("; ")
}

/// A module's text without what makes it one.
fn joined(name: &str, text: &str) -> String {
    let mut script = format!("// {name}\n");
    for line in text.lines().filter(|line| !line.starts_with("import ")) {
        script += line.strip_prefix("export ").unwrap_or(line);
        script.push('\n');
    }
    script
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests;
