//! Scripts that are written in the page: checked while they are typed, kept in the folder, used at once.

use serde::Deserialize;
use serde_json::{Value, json};

use super::bench::Bench;
use super::constraints;
use super::folder;
use super::study::{ScriptFile, ScriptKind};
use crate::check::{self, Kind};
use crate::effects::{Joints, ScriptedEffect};
use crate::error::{Error, Result};
use crate::text::write_whole;

/// Longest script [bytes].
const LONGEST: usize = 1 << 17;
/// Scripts of a study at most.
const MOST: usize = 64;

/// Text to check or keep.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Draft {
    pub kind: ScriptKind,
    pub text: String,
    /// The file to write again.
    #[serde(default)]
    pub file: Option<String>,
}

/// Says what a script means and what is wrong with it.
///
/// # Errors
/// When it is too long, or cannot be put down to be read.
pub(super) fn check(bench: &Bench, draft: &Draft) -> Result<Value> {
    if draft.text.len() > LONGEST {
        return Err(Error::new(format!("the script is longer than {} KiB", LONGEST >> 10)));
    }
    let (output, robot, gravity) = {
        let study = bench.study();
        (study.output.clone(), study.robot.as_ref().map(|r| r.path.clone()), study.gravity)
    };
    // It is gone at the end of this, whatever happens.
    let draft_folder = output.temporary_folder("draft")?;
    let place = draft_folder.path();
    let name = draft.file.as_deref().filter(|f| is_name(f)).unwrap_or("script.rhai");
    let path = place.join(name);
    write_whole(&path, draft.text.as_bytes())?;
    let options = check::Options { robot, data: None, columns: None, gravity, stop: bench.draft() };
    let report = check::file(&path, &options);
    let mut problems: Vec<Value> = report
        .problems
        .iter()
        .map(|p| {
            let text = p.text.replace(&format!("{}/", place.display()), "");
            json!({"severity": "error", "text": message(&text, p.line, p.column, name), "help": help(&text),
                   "file": name, "line": p.line, "column": p.column})
        })
        .collect();
    let is_effect = report.kind == Some(Kind::EffectScript);
    if report.kind.is_some() && is_effect != (draft.kind == ScriptKind::Effect) {
        let (is, wanted) = match draft.kind {
            ScriptKind::Effect => ("states rules on link parameters", "an effect defines `fn columns`"),
            ScriptKind::Constraint => ("states an effect", "rules are stated by `fn constrain`"),
        };
        problems.push(json!({"severity": "error", "text": format!("this script {is}"), "help": wanted,
                             "file": name, "line": 1, "column": 1}));
    }
    let text = report.text().replace(&format!("{}/", place.display()), "");
    Ok(json!({"ok": problems.is_empty(), "problems": problems, "remarks": report.remarks,
              "sections": sections(&text)}))
}

/// The message alone, without the place that stands before it and the help behind it.
fn message(text: &str, line: Option<usize>, column: Option<usize>, name: &str) -> String {
    let mut lead = name.to_string();
    for number in [line, column].into_iter().flatten() {
        lead += &format!(":{number}");
    }
    let text = text.strip_prefix(&format!("{lead}: ")).unwrap_or(text);
    text.split("\n  help: ").next().unwrap_or(text).to_string()
}

fn help(text: &str) -> Option<&str> {
    text.split_once("\n  help: ").map(|(_, help)| help)
}

/// The facts of a check, by heading.
fn sections(text: &str) -> Vec<Value> {
    let mut all: Vec<(String, Vec<String>)> = Vec::new();
    for line in text.lines().skip(1).filter(|l| !l.is_empty()) {
        match (line.strip_prefix("  "), all.last_mut()) {
            (Some(inner), Some((_, lines))) => lines.push(inner.to_string()),
            _ => all.push((line.to_string(), Vec::new())),
        }
    }
    let told = |title: &str| !["problems", "next"].iter().any(|t| title.starts_with(t));
    all.into_iter()
        .filter(|(t, _)| told(t))
        .map(|(title, lines)| json!({"title": title, "lines": lines}))
        .collect()
}

/// Keeps a script; a script of constraints joins the list.
///
/// # Errors
/// When it is none, or the folder cannot be written to.
pub(super) fn save(bench: &Bench, draft: &Draft) -> Result<Result<String, Value>> {
    let checked = check(bench, draft)?;
    if checked["ok"] != json!(true) {
        return Ok(Err(checked));
    }
    let mut study = bench.study();
    let known =
        draft.file.as_ref().filter(|f| study.scripts.iter().any(|s| s.file == **f && s.kind == draft.kind));
    if known.is_none() && study.scripts.len() >= MOST {
        return Err(
            Error::new(format!("the study has {MOST} scripts already")).help("write one of them again")
        );
    }
    let stem = match draft.kind {
        ScriptKind::Effect => "effect",
        ScriptKind::Constraint => "constraint",
    };
    let free = || {
        let known = |file: &String| study.scripts.iter().any(|s| s.file == *file);
        let taken = |file: &String| known(file) || study.output.check(&[file]).is_err();
        (1..).map(|k| format!("{stem}_{k}.rhai")).find(|file| !taken(file)).unwrap_or_default()
    };
    let file = known.cloned().unwrap_or_else(free);
    if draft.kind == ScriptKind::Effect {
        ScriptedEffect::from_text(file.as_ref(), draft.text.clone(), Joints::All)?;
    }
    study.output.write(&file, draft.text.as_bytes())?;
    study.scripts.retain(|s| s.file != file);
    let (kind, text) = (draft.kind, draft.text.clone());
    study.scripts.push(ScriptFile { file: file.clone(), kind, text, proposed: false });
    if draft.kind == ScriptKind::Constraint {
        study.constraints = constraints::with_script(&study.constraints, &file);
    }
    folder::save(&study)?;
    Ok(Ok(file))
}

/// Whether a name is that of a script in the folder and nothing else.
pub(super) fn is_name(file: &str) -> bool {
    let fine = |c: char| c.is_ascii_alphanumeric() || "_-.".contains(c);
    file.ends_with(".rhai") && file.len() < 200 && !file.starts_with('.') && file.chars().all(fine)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn names_cannot_leave_the_folder() {
        assert!(is_name("effect_1.rhai") && is_name("my-friction.rhai"));
        for bad in ["../x.rhai", "a/b.rhai", ".x.rhai", "x.ron", "a\\b.rhai", "ä.rhai", "x.rhai\0"] {
            assert!(!is_name(bad), "{bad}");
        }
    }

    #[test]
    fn messages_stand_without_their_place() {
        let text = "script.rhai:3:7: no function `cosh`\n  help: known are sin, cos";
        assert_eq!(message(text, Some(3), Some(7), "script.rhai"), "no function `cosh`");
        assert_eq!(help(text), Some("known are sin, cos"));
    }
}
