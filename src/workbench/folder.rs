//! The study on disk: written whole after every step, read again after whatever ended the process.

use std::path::{Component, Path, PathBuf};

use super::saved::{Saved, SavedLog, SavedStep};
use super::study::{LogFile, Retrieval, RobotFile, Step, Study};
use super::written;
use crate::error::{Error, Result};
use crate::text::bounds::NAMELESS;
use crate::text::{Output, located};

/// Everything that a killed process may not lose.
const STEPS: &str = "steps.json";
/// What to do where no study can be gone on with.
const HELP: &str = "give the folder that `lacuna workbench` wrote to, or start without --resume";

/// Whether a study lies in a folder.
pub(super) fn holds_study(folder: &Path) -> bool {
    folder.join(STEPS).is_file()
}

/// Writes the study: steps, model, and the scenario that repeats them.
///
/// # Errors
/// When the folder cannot be written to.
pub(super) fn save(study: &Study) -> Result<()> {
    let folder = &study.folder;
    let inside = |path: &Path| beside(folder, path);
    let step = |s: &Step| SavedStep {
        id: s.id,
        parent: s.parent,
        root: s.root.clone(),
        added: s.added.clone(),
        effects: s.effects.clone(),
        numbers: s.numbers.clone(),
    };
    let log = |l: &LogFile| SavedLog { name: l.name.clone(), path: inside(&l.path), role: l.role };
    let saved = Saved {
        lacuna: env!("CARGO_PKG_VERSION").to_string(),
        name: study.name.clone(),
        robot: study.robot.as_ref().map(|r| inside(&r.path)),
        gravity: study.gravity,
        logs: study.logs.iter().map(log).collect(),
        columns: study.columns.clone(),
        signals: study.signals.clone(),
        hold_out: study.hold_out,
        seed: study.seed,
        steps: study.steps.iter().map(step).collect(),
        shown: study.shown,
        against: study.against,
        constraints: study.constraints.clone(),
        scripts: study.scripts.clone(),
        engines: study.engines.clone(),
        intervals: study.intervals,
        retrieved: study.retrieval.as_ref().filter(|r| r.report.is_some()).map(|r| r.step),
    };
    let json = serde_json::to_string_pretty(&saved)
        .map_err(|e| Error::new(format!("the steps cannot be written: {e}")))?;
    study.output.write(STEPS, (json + "\n").as_bytes())?;
    written::all(study)
}

/// Takes the folder that a study lies in.
///
/// # Errors
/// When no study lies there, or another process has it.
pub(super) fn open(folder: &Path) -> Result<Output> {
    if !holds_study(folder) {
        return Err(Error::new("no study lies in this folder").in_file(folder).help(HELP));
    }
    Output::claim_study(folder).map_err(|e| e.or_help(HELP))
}

/// Reads the study that lies in a folder.
///
/// # Errors
/// When it is damaged, or names what it cannot have; with line and column.
pub(super) fn load(output: Output) -> Result<Study> {
    let folder = output.folder().to_path_buf();
    let path = folder.join(STEPS);
    let content = output.read(STEPS).map_err(|e| e.or_help(HELP))?;
    let saved: Saved = serde_json::from_str(&content).map_err(|e| damaged(&e, &content).in_file(&path))?;
    let wrong = |e: Error| located(e, &content).in_file(&path).or_help(HELP);
    saved.check().map_err(wrong)?;
    let outside = outside(&output, &saved).map_err(wrong)?;
    output.give(outside)?;
    let there = |path: PathBuf| folder.join(path);
    let log = |(id, l): (usize, SavedLog)| LogFile {
        id,
        name: l.name,
        path: there(l.path),
        role: l.role,
        log: None,
        seen: None,
        findings: None,
    };
    let step = |s: SavedStep| Step {
        id: s.id,
        parent: s.parent,
        root: s.root,
        added: s.added,
        effects: s.effects,
        fitted: None,
        ranking: None,
        scan: None,
        numbers: s.numbers,
    };
    let known: Vec<usize> = saved.steps.iter().map(|s| s.id).collect();
    let known = |id: &usize| known.contains(id);
    let retrieval = saved.retrieved.and_then(|step| retrieved(&output, step, saved.engines.clone()));
    Ok(Study {
        name: saved.name,
        folder: folder.clone(),
        output,
        robot: saved.robot.map(|path| RobotFile { path: there(path), robot: None, problem: None }),
        gravity: saved.gravity,
        logs: saved.logs.into_iter().enumerate().map(log).collect(),
        columns: saved.columns,
        signals: saved.signals,
        hold_out: saved.hold_out,
        seed: saved.seed,
        steps: saved.steps.into_iter().map(step).collect(),
        // A process that was killed while it fitted anew may have shown what is gone.
        shown: saved.shown.filter(known),
        against: saved.against.filter(known),
        constraints: saved.constraints,
        scripts: saved.scripts,
        engines: saved.engines,
        intervals: saved.intervals,
        retrieval,
        trouble: None,
    })
}

/// Files outside of the folder that a study reads, as it names them.
///
/// # Errors
/// When one of them was not given on the command line.
fn outside(output: &Output, saved: &Saved) -> Result<Vec<String>> {
    let files = saved.robot.iter().chain(saved.logs.iter().map(|l| &l.path));
    let mut all = Vec::new();
    for file in files.filter(|f| !is_inside(output.folder(), &output.folder().join(f))) {
        let name = file.display().to_string();
        // Versions before this did not note what they were given.
        if output.was_given(&name) == Some(false) {
            let what = format!("`{name}` lies outside of the study, which was not started with it");
            return Err(Error::new(what).help("start a new study with it, by --robot or --data"));
        }
        all.push(name);
    }
    Ok(all)
}

/// Whether a file lies in a folder, links followed; one that is not there, by its path alone.
pub(super) fn is_inside(folder: &Path, file: &Path) -> bool {
    match (folder.canonicalize(), file.canonicalize()) {
        (Ok(folder), Ok(file)) => file.starts_with(folder),
        _ => file
            .strip_prefix(folder)
            .is_ok_and(|rest| rest.components().all(|part| matches!(part, Component::Normal(_)))),
    }
}

/// Files outside of the folder that a study reads.
pub(super) fn reads(study: &Study) -> Vec<PathBuf> {
    let files = study.robot.iter().map(|r| &r.path).chain(study.logs.iter().map(|l| &l.path));
    let outside = files.filter(|file| !is_inside(&study.folder, file));
    outside.map(|file| file.canonicalize().unwrap_or_else(|_| file.clone())).collect()
}

/// Removes the file of a log that is no longer in the study, if it was dropped into it: then the study has a copy
/// of its own. Every other file is the user's.
pub(super) fn discard(study: &Study, gone: &Path) {
    let number = |name: &str| {
        let rest = name.strip_prefix("log_")?;
        let digits = rest.strip_suffix(".csv.gz").or_else(|| rest.strip_suffix(".csv"))?;
        (!digits.is_empty() && digits.bytes().all(|b| b.is_ascii_digit())).then_some(())
    };
    let lies_here = || {
        let parent = gone.parent().and_then(|p| p.canonicalize().ok());
        parent.is_some() && parent == study.folder.canonicalize().ok()
    };
    let name = gone.file_name().and_then(|n| n.to_str()).filter(|name| number(name).is_some());
    let used = study.logs.iter().any(|log| log.path == gone);
    if let Some(name) = name.filter(|_| !used && lies_here()) {
        // What cannot be removed now is in nobody's way.
        let _ = study.output.remove(name);
    }
}

/// What is wrong with the JSON of a study. The reader knows a number that is out of bounds without its name, which
/// stands on the same line.
fn damaged(error: &serde_json::Error, content: &str) -> Error {
    let said = error.to_string();
    let said = said.rsplit_once(" at line ").map_or(said.as_str(), |(what, _)| what);
    let (what, help) = said.split_once("\n  help: ").unwrap_or((said, HELP));
    let line = content.lines().nth(error.line().saturating_sub(1));
    let field = line.and_then(|line| line.split('"').nth(1)).unwrap_or("a number");
    let what =
        what.strip_prefix(NAMELESS).map_or_else(|| what.to_string(), |is| format!("`{field}` is {is}"));
    Error::new(format!("the study is damaged: {what}")).at(error.line(), error.column()).help(help)
}

/// The results of a finished retrieval.
fn retrieved(output: &Output, step: usize, engines: Vec<String>) -> Option<Retrieval> {
    let report = output.read("report.json").ok()?;
    let report = serde_json::from_str(&report).ok()?;
    Some(Retrieval { step, engines, report: Some(std::sync::Arc::new(report)), ..Retrieval::default() })
}

/// `path` as seen from `folder`; absolute where they have nothing in common.
pub(super) fn beside(folder: &Path, path: &Path) -> PathBuf {
    let (Ok(folder), Ok(path)) = (folder.canonicalize(), path.canonicalize()) else {
        // A file that is gone keeps the name that it has in the study.
        return path.strip_prefix(folder).unwrap_or(path).to_path_buf();
    };
    let (here, there): (Vec<Component<'_>>, Vec<Component<'_>>) =
        (folder.components().collect(), path.components().collect());
    let common = here.iter().zip(&there).take_while(|(a, b)| a == b).count();
    if common <= 1 && !path.starts_with(&folder) {
        return path;
    }
    let up = std::iter::repeat_n(Component::ParentDir, here.len() - common);
    up.chain(there[common..].iter().copied()).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_are_told_from_the_folder() -> std::io::Result<()> {
        let root = std::env::temp_dir().join(format!("lacuna-beside-{}", std::process::id()));
        std::fs::create_dir_all(root.join("a/b"))?;
        std::fs::write(root.join("log.csv"), "t")?;
        std::fs::write(root.join("a/b/own.csv"), "t")?;
        let from = root.join("a/b");
        assert_eq!(beside(&from, &root.join("log.csv")), Path::new("../../log.csv"));
        assert_eq!(beside(&from, &from.join("own.csv")), Path::new("own.csv"));
        assert_eq!(beside(&from, Path::new("not/there")), Path::new("not/there"));
        std::fs::remove_dir_all(&root)
    }
}
