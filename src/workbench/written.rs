//! What lies in the folder for the command line: a scenario that repeats what was done, the model, the column map
//! and the constraints.

use std::path::PathBuf;

use super::folder::beside;
use super::study::{Role, ScriptKind, Study};
use crate::effects::{Effect, Joints, ScriptedEffect};
use crate::error::Result;
use crate::text::to_ron;

/// Writes everything that can be written by now.
///
/// # Errors
/// When the folder cannot be written to.
pub(super) fn all(study: &Study) -> Result<()> {
    let output = &study.output;
    if let Some(map) = &study.columns {
        output.write("columns.ron", map.as_bytes())?;
    }
    output.write("constraints.ron", study.constraints.as_bytes())?;
    if let Some(text) = scenario(study)? {
        output.write("scenario.ron", text.as_bytes())?;
    }
    let shown = study.shown.and_then(|id| study.step(id)).and_then(|s| s.fitted.as_ref());
    shown.map_or(Ok(()), |fitted| output.write("model.ron", to_ron(&fitted.model)?.as_bytes()))
}

/// The commands that repeat what was done.
pub(super) fn commands(study: &Study) -> Vec<String> {
    let scenario = study.folder.join("scenario.ron");
    if study.on_show().is_none() || study.robot.is_none() {
        return Vec::new();
    }
    ["diagnose", "scenario"]
        .iter()
        .map(|command| format!("lacuna {command} {}", scenario.display()))
        .collect()
}

/// The scenario of the model on show; `None` while there is nothing to fit.
///
/// # Errors
/// When something cannot be written as RON.
pub(super) fn scenario(study: &Study) -> Result<Option<String>> {
    let Some(robot) = &study.robot else { return Ok(None) };
    let Some(step) = study.on_show() else { return Ok(None) };
    let files = |role: Role| -> Vec<PathBuf> {
        study.usable(role).map(|log| beside(&study.folder, &log.path)).collect()
    };
    let mut text =
        format!("// `{}`, written by lacuna workbench {}.\n", study.name, env!("CARGO_PKG_VERSION"));
    for command in commands(study) {
        text += &format!("//     {command}\n");
    }
    text += "// The errors below are those of the workbench and of `lacuna diagnose`, which leave the widths of signs some\n\
             // slack; `lacuna scenario` fits the effects as they stand, and its figure may be a few per cent of it higher.\n";
    for log in study.usable(Role::Fit).chain(study.usable(Role::Validate)) {
        if let Some(thinned) = log.log.as_ref().and_then(|l| l.thinned.as_ref()) {
            text += &format!("// {} is very long: every {}. sample of it is used\n", log.name, thinned.every);
        }
    }
    for id in study.path(step.id) {
        let Some(step) = study.step(id) else { continue };
        let error =
            step.numbers.held_out_percent.map_or_else(String::new, |e| format!("   {e:.3} % held out"));
        text += &format!("// {}{error}\n", step.label());
    }
    text += "(\n";
    let mut field = |name: &str, value: String| {
        let value = value.trim_end().replace('\n', "\n    ");
        text += &format!("    {name}: {value},\n");
    };
    field("robot", to_ron(&beside(&study.folder, &robot.path))?);
    if let Some(gravity) = study.gravity {
        field("gravity", to_ron(&gravity)?);
    }
    field("seed", study.seed.to_string());
    let columns = if study.columns.is_some() { ", columns: \"columns.ron\"" } else { "" };
    let (fit, validate) = (to_ron(&files(Role::Fit))?, to_ron(&files(Role::Validate))?);
    field("logs", format!("Files(fit: {}, validate: {}{columns})", fit.trim_end(), validate.trim_end()));
    field("signals", to_ron(&study.signals.settings)?);
    field("weighting", "Joint".to_string());
    field("hold_out", to_ron(&study.hold_out)?);
    field("effects", to_ron(&step.effects)?);
    field("candidates", to_ron(&candidates(study)?)?);
    if !study.engines.is_empty() {
        field("presets", "[\"constraints.ron\"]".to_string());
        field("engines", format!("[{}]", study.engines.join(", ")));
        if study.intervals {
            field("intervals", "()".to_string());
        }
    }
    Ok(Some(text + ")\n"))
}

/// Effect scripts of the study, which take part in every search.
///
/// # Errors
/// When one of them is no longer a script.
pub(super) fn candidates(study: &Study) -> Result<Vec<Box<dyn Effect>>> {
    let effects = study.scripts.iter().filter(|s| s.kind == ScriptKind::Effect && !s.proposed);
    effects
        .map(|s| Ok(ScriptedEffect::from_text(s.file.as_ref(), s.text.clone(), Joints::All)?.boxed()))
        .collect()
}

/// A RON text that names files, for another folder: every quoted path that is there is told from the new one.
pub(super) fn relocated(text: &str, from: &std::path::Path, to: &std::path::Path) -> String {
    let parts = text.split('"').enumerate().map(|(k, part)| {
        let is_path = k % 2 == 1 && part.contains('.') && from.join(part).is_file();
        if is_path { beside(to, &from.join(part)).display().to_string() } else { part.to_string() }
    });
    parts.collect::<Vec<_>>().join("\"")
}
