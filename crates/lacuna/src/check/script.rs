//! What a script of constraints means for a robot.

use std::path::Path;

use super::file::{Options, open_robot};
use super::report::{Report, Section, number};
use crate::constraints::{Explanation, FormExplanation, explain_until};
use crate::error::Result;
use crate::script::Script;

pub(super) fn examine(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let Some(robot) = &options.robot else {
        let settings = Script::open(path)?.settings()?;
        let lines = settings.iter().map(|(name, value)| format!("{name} = {value}")).collect();
        report.sections.push(Section::wrapped("settings, which a scenario changes by `with`", lines));
        report.remarks.push("read, but not run: its rules are about the links of a robot".into());
        report.next = vec![
            format!("lacuna check {} --robot ROBOT", path.display()),
            "shows its rules, their form and which engines take them".into(),
        ];
        return Ok(());
    };
    let explanation = explain_until(path, &open_robot(robot, options.gravity)?.0, &options.stop)?;
    report.remarks.extend(remark(&explanation));
    report.script = Some(explanation);
    report.next = vec![
        "in a scenario:".into(),
        format!("constraints: [{{\"script\": (path: \"{}\")}}]", path.display()),
        "with the path from there, and `links: Only([..])`, `with: {..}` as needed".into(),
    ];
    Ok(())
}

fn remark(e: &Explanation) -> Option<String> {
    let forms = || e.rules.iter().flat_map(|r| &r.forms);
    let (all, broken) = (forms().count(), forms().filter(|f| !f.holds).count());
    (broken > 0).then(|| format!("{broken} of {all} conditions do not hold at {}: is that meant?", e.sample))
}

/// Facts of the script, then its rules.
pub(super) fn sections(e: &Explanation) -> Vec<Section> {
    let count = match e.rules.len() {
        1 => "1 rule".to_string(),
        n => format!("{n} rules"),
    };
    let mut facts = vec![format!("{count} on {} of `{}`", e.links.join(", "), e.robot)];
    let settings: Vec<String> = e.settings.iter().map(|(name, value)| format!("{name} = {value}")).collect();
    if !settings.is_empty() {
        facts.push(format!("settings: {}", settings.join("; ")));
    }
    let ways = match e.runs {
        1 => "ran once; engines evaluate what it stated and never run it again".to_string(),
        n => format!(
            "ran {n} times, once for every link and way through its comparisons of unknowns; engines evaluate \
             what it stated and never run it again"
        ),
    };
    facts.push(ways);
    let mut rules = Vec::new();
    for (rule, form) in e.rules.iter().flat_map(|r| r.forms.iter().map(move |form| (r, form))) {
        rules.push(form.label.clone());
        rules.push(format!("  line {}: {}, {}", rule.line, form.kind, state(form)));
        rules.push(format!("  {}", taken(form)));
    }
    let title = format!("rules, with their margins at {}", e.sample);
    vec![Section::wrapped("script", facts), Section::wrapped(title, rules)]
}

fn state(form: &FormExplanation) -> String {
    let word = if form.holds { "holds by" } else { "VIOLATED by" };
    format!("{word} {} {}", number(form.margin.abs(), 6), form.unit)
}

fn taken(form: &FormExplanation) -> String {
    match &form.why {
        None => "every engine takes it".into(),
        Some(why) => format!(
            "{} take it; `lmi` leaves it out, and its bound is that of the relaxation: {why}",
            form.engines.join(", ")
        ),
    }
}
