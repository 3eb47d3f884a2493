//! The result of a check, as data and as text of at most 80 columns.

use serde::Serialize;

use super::{Findings, Kind, LogFacts, RobotFacts, Severity};
use crate::constraints::Explanation;
use crate::error::Error;
use crate::report::wrap;
use crate::text::one_line;

/// Everything a check found out.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Report {
    /// Version.
    pub lacuna: &'static str,
    /// The file, as it was named.
    pub file: String,
    /// What it is, where that could be told.
    pub kind: Option<Kind>,
    /// What makes it unusable, or will.
    pub problems: Vec<Problem>,
    /// What to know.
    pub remarks: Vec<String>,
    /// Facts of the file's robot.
    pub robot: Option<RobotFacts>,
    /// Facts of the logs.
    pub logs: Vec<LogFacts>,
    /// What a script of constraints means for a robot.
    pub script: Option<Explanation>,
    /// Other facts and what the file will do, by heading.
    pub sections: Vec<Section>,
    /// Each log against the robot, by the log's name.
    pub against_robot: Vec<(String, Findings)>,
    /// What to do next.
    pub next: Vec<String>,
}

/// Something wrong in a file.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Problem {
    /// File as it was named.
    pub file: Option<String>,
    /// Line, from 1.
    pub line: Option<usize>,
    /// Column, from 1.
    pub column: Option<usize>,
    /// What is wrong and what to do.
    pub text: String,
    /// Whether the checked file itself cannot be used (rather than something it names).
    pub unusable: bool,
    #[serde(skip)]
    error: Error,
}

impl Problem {
    pub(super) fn new(error: Error, unusable: bool) -> Self {
        let place = error.place();
        Self {
            file: place.map(|p| p.file.clone()),
            line: place.and_then(|p| p.line),
            column: place.and_then(|p| p.column),
            text: error.to_string(),
            unusable,
            error,
        }
    }
}

/// Lines under a heading.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
pub struct Section {
    /// Heading.
    pub title: String,
    /// Lines of at most 78 characters.
    pub lines: Vec<String>,
}

impl Section {
    /// Long lines are wrapped.
    pub(super) fn wrapped(title: impl Into<String>, lines: Vec<String>) -> Self {
        let hang = |line: String| {
            let parts = wrap(&line, 74).into_iter().enumerate();
            parts.map(|(i, part)| if i == 0 { part } else { format!("    {part}") }).collect::<Vec<_>>()
        };
        Self { title: title.into(), lines: lines.into_iter().flat_map(hang).collect() }
    }

    /// Lines as they are.
    pub(super) fn table(title: impl Into<String>, lines: Vec<String>) -> Self {
        Self { title: title.into(), lines }
    }
}

impl Report {
    pub(super) fn new(file: &std::path::Path) -> Self {
        Self {
            lacuna: env!("CARGO_PKG_VERSION"),
            file: file.display().to_string(),
            kind: None,
            problems: Vec::new(),
            remarks: Vec::new(),
            robot: None,
            logs: Vec::new(),
            script: None,
            sections: Vec::new(),
            against_robot: Vec::new(),
            next: Vec::new(),
        }
    }

    /// The first problem that makes the file itself unusable.
    pub fn unusable(&self) -> Option<&Error> {
        self.problems.iter().find(|p| p.unusable).map(|p| &p.error)
    }

    /// Whether nothing worse than remarks and warnings came up.
    pub fn is_sound(&self) -> bool {
        self.problems.is_empty() && self.against_robot.iter().all(|(_, f)| f.is_sound())
    }

    /// For people.
    pub fn text(&self) -> String {
        let mut text = match self.kind {
            Some(kind) => format!("{}: {}\n", one_line(&self.file), kind.text()),
            None => format!("{}: not recognised\n", one_line(&self.file)),
        };
        let mut sections: Vec<Section> = self.robot.iter().flat_map(RobotFacts::sections).collect();
        if self.kind == Some(Kind::Scenario) {
            // The robot's own check lists its base parameters.
            sections.truncate(1);
        }
        sections.extend(self.script.iter().flat_map(super::script::sections));
        sections.extend(self.sections.iter().cloned());
        sections.extend(self.logs.iter().map(LogFacts::section));
        sections.extend(self.against_robot.iter().map(|(name, f)| against(name, f)));
        for section in sections.iter().filter(|s| !s.lines.is_empty()) {
            text += &format!("\n{}\n", section.title);
            section.lines.iter().for_each(|line| text += &format!("  {}\n", line.trim_end()));
        }
        list(&mut text, "remarks", "!", self.remarks.iter().map(String::as_str));
        list(&mut text, "problems", "x", self.problems.iter().map(|p| p.text.as_str()));
        for (i, step) in self.next.iter().enumerate() {
            text += &format!("{}{step}\n", if i == 0 { "\nnext  " } else { "      " });
        }
        text
    }
}

fn list<'a>(text: &mut String, title: &str, mark: &str, items: impl Iterator<Item = &'a str>) {
    for (i, item) in items.enumerate() {
        if i == 0 {
            *text += &format!("\n{title}\n");
        }
        for (k, line) in item.lines().flat_map(|line| wrap(line, 74)).enumerate() {
            *text += &format!("  {} {line}\n", if k == 0 { mark } else { " " });
        }
    }
}

/// A log against the robot.
fn against(name: &str, f: &Findings) -> Section {
    let error = format!(
        "relative error {:.2} % as it is, {:.2} % held out (classical model refitted, {} rows, {}; joints count \
         alike)",
        f.relative_error_percent, f.held_out_relative_error_percent, f.rows, f.folds
    );
    let mut lines = wrap(&error, 76);
    if let Some(own) = f.own_inertias_error_percent {
        lines.push(format!("{own:.2} % with the robot file's own inertias, friction and offset fitted"));
    }
    for finding in &f.findings {
        let mark = if finding.severity == Severity::Defect { "x" } else { "!" };
        let mut sentence = finding.text.clone();
        if let Some([before, after]) = finding.error_percent {
            sentence += &format!(" (relative error {before:.3} % as it is, {after:.3} % put right");
            if let Some([before, after]) = finding.held_out_error_percent {
                sentence += &format!("; held out {before:.3} -> {after:.3} %");
            }
            sentence += ")";
        }
        let mut all = vec![sentence];
        all.extend(finding.also_possible.iter().map(|other| format!("or: {other}")));
        all.push(format!("help: {}", finding.remedy));
        for (k, line) in all.iter().flat_map(|line| wrap(line, 74)).enumerate() {
            lines.push(format!("{} {line}", if k == 0 { mark } else { " " }));
        }
    }
    if f.findings.is_empty() {
        lines.push("units, signs, order of joints and mounting agree".into());
    }
    if !f.not_told_apart.is_empty() {
        let text = format!("these data cannot exclude: {}", f.not_told_apart.join("; "));
        lines.extend(wrap(&text, 76));
    }
    if let Some(map) = &f.column_map {
        lines.push("column map to put it right (--columns MAP.ron):".into());
        lines.extend(map.lines().flat_map(|line| wrap(line, 76)));
    }
    Section::table(format!("{name} against the robot"), lines)
}

/// A number with so many significant digits and no idle zeros.
pub(super) fn number(x: f64, digits: usize) -> String {
    if x.abs() < 1e-9 {
        return "0".into();
    }
    if !x.is_finite() {
        return x.to_string();
    }
    let whole = libm::floor(libm::log10(x.abs())) as i32 + 1;
    let decimals = (digits as i32 - whole).clamp(0, 12) as usize;
    let text = format!("{x:.decimals$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}
