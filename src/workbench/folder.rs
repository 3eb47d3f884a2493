//! The study on disk: written whole after every step, read again after whatever ended the process.

use std::path::{Component, Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::study::{
    Addition, LogFile, Numbers, Retrieval, RobotFile, Role, Root, ScriptFile, Signals, Step, Study,
};
use super::written;
use crate::effects::Effect;
use crate::error::{Error, Result};
use crate::scenario::HoldOut;
use crate::text;

/// Everything that a killed process may not lose.
const STEPS: &str = "steps.json";

#[derive(Serialize, Deserialize)]
struct Saved {
    lacuna: String,
    name: String,
    robot: Option<PathBuf>,
    gravity: Option<[f64; 3]>,
    logs: Vec<SavedLog>,
    columns: Option<String>,
    signals: Signals,
    hold_out: HoldOut,
    seed: u64,
    steps: Vec<SavedStep>,
    shown: Option<usize>,
    against: Option<usize>,
    constraints: String,
    scripts: Vec<ScriptFile>,
    engines: Vec<String>,
    intervals: bool,
    /// The step that link parameters were retrieved for; the results stand in `report.json`.
    retrieved: Option<usize>,
}

#[derive(Serialize, Deserialize)]
struct SavedLog {
    name: String,
    path: PathBuf,
    role: Role,
}

#[derive(Serialize, Deserialize)]
struct SavedStep {
    id: usize,
    parent: Option<usize>,
    root: Option<Root>,
    added: Option<Addition>,
    effects: Vec<Box<dyn Effect>>,
    numbers: Numbers,
}

/// Makes the folder of a study, closed to everybody else.
///
/// # Errors
/// When it cannot be made or written to.
pub(super) fn make(folder: &Path) -> Result<()> {
    let trouble = |e: std::io::Error| {
        Error::new(format!("cannot make the study's folder: {e}"))
            .in_file(folder)
            .help("give another --out DIR")
    };
    std::fs::create_dir_all(folder).map_err(trouble)?;
    #[cfg(unix)]
    {
        use std::os::unix::fs::PermissionsExt;
        std::fs::set_permissions(folder, std::fs::Permissions::from_mode(0o700)).map_err(trouble)?;
    }
    text::check_writable(folder)
}

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
    text::write_whole(&folder.join(STEPS), (json + "\n").as_bytes())?;
    written::all(study)
}

/// Reads the study that lies in a folder.
///
/// # Errors
/// When there is none, or it is damaged.
pub(super) fn load(folder: &Path) -> Result<Study> {
    let path = folder.join(STEPS);
    let help = "give the folder that `lacuna workbench` wrote to, or start without --resume";
    let content = text::read(&path).map_err(|e| e.help(help))?;
    let saved: Saved = serde_json::from_str(&content).map_err(|e| {
        Error::new(format!("the study is damaged: {e}")).at(e.line(), e.column()).in_file(&path).help(help)
    })?;
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
    Ok(Study {
        name: saved.name,
        folder: folder.to_path_buf(),
        robot: saved.robot.map(|path| RobotFile { path: there(path), robot: None, problem: None }),
        gravity: saved.gravity,
        logs: saved.logs.into_iter().enumerate().map(log).collect(),
        columns: saved.columns,
        signals: saved.signals,
        hold_out: saved.hold_out,
        seed: saved.seed,
        steps: saved.steps.into_iter().map(step).collect(),
        shown: saved.shown,
        against: saved.against,
        constraints: saved.constraints,
        scripts: saved.scripts,
        engines: saved.engines.clone(),
        intervals: saved.intervals,
        retrieval: saved.retrieved.and_then(|step| retrieved(folder, step, saved.engines)),
        trouble: None,
    })
}

/// The results of a finished retrieval.
fn retrieved(folder: &Path, step: usize, engines: Vec<String>) -> Option<Retrieval> {
    let report = text::read(&folder.join("report.json")).ok()?;
    let report = serde_json::from_str(&report).ok()?;
    Some(Retrieval { step, engines, report: Some(std::sync::Arc::new(report)), ..Retrieval::default() })
}

/// `path` as seen from `folder`; absolute where they have nothing in common.
pub(super) fn beside(folder: &Path, path: &Path) -> PathBuf {
    let (Ok(folder), Ok(path)) = (folder.canonicalize(), path.canonicalize()) else {
        return path.to_path_buf();
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
