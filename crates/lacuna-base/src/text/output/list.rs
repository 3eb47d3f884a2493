//! What was made in a folder: a list that lies there, and how folders are known that versions before it wrote.

use std::collections::BTreeSet;
use std::path::{Component, Path};

use serde::{Deserialize, Serialize};

use super::super::{located, partial, read};
use super::lock;
use crate::error::{Error, Result};

/// The file of the list.
pub(super) const FILE: &str = ".lacuna.json";
/// What makes a folder nobody else's.
pub(super) const STUDY: &str = "workbench";
/// Names on a list at most.
const MOST: usize = 10_000;

/// The list.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct List {
    /// Version that wrote it.
    lacuna: String,
    /// What it is, for people.
    about: String,
    /// Commands that wrote here.
    pub by: BTreeSet<String>,
    /// Files that were made here, told from the folder.
    pub made: BTreeSet<String>,
    /// Files elsewhere that a study reads, as they were given on the command line; `None` where that was not noted.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub given: Option<BTreeSet<String>>,
}

/// What a folder is.
pub(super) enum State {
    /// It is not there, or nothing lies in it.
    Vacant,
    /// It has a list, or an earlier version wrote it.
    Ours(List),
    /// Something of somebody else's lies in it, and no list.
    Foreign(String),
}

impl List {
    pub fn new() -> Self {
        Self {
            lacuna: env!("CARGO_PKG_VERSION").to_string(),
            about: "what lacuna made in this folder; nothing else here is replaced or removed".to_string(),
            by: BTreeSet::new(),
            made: BTreeSet::new(),
            given: None,
        }
    }

    /// Whether the workbench wrote it.
    pub fn is_study(&self) -> bool {
        self.by.contains(STUDY)
    }

    pub fn text(&self) -> Result<String> {
        let json = serde_json::to_string_pretty(self);
        json.map(|t| t + "\n").map_err(|e| Error::new(format!("cannot write the list of files: {e}")))
    }

    /// The list of a folder that has one.
    fn open(path: &Path) -> Result<Self> {
        if !path.symlink_metadata().is_ok_and(|m| m.is_file()) {
            return Err(Error::new("this is no list of files, but has its name").in_file(path));
        }
        let text = read(path)?;
        let list: Self = serde_json::from_str(&text).map_err(|e| {
            Error::new(format!("the list of files is damaged: {e}")).at(e.line(), e.column()).in_file(path)
        })?;
        let wrong = if list.made.len() > MOST {
            Some(Error::new(format!("`made` names more than {MOST} files")))
        } else {
            let bad = list.made.iter().find(|name| !is_plain(name));
            bad.map(|name| Error::new(format!("`{name}` is no name of a file in this folder")))
        };
        wrong.map_or(Ok(list), |e| Err(located(e, &text).in_file(path)))
    }
}

/// Whether a name stays inside a folder and is one to show.
pub(super) fn is_plain(name: &str) -> bool {
    let fine = |part: Component<'_>| matches!(part, Component::Normal(_));
    !name.is_empty() && !name.chars().any(char::is_control) && Path::new(name).components().all(fine)
}

/// What lies in a folder.
pub(super) fn state(folder: &Path) -> Result<State> {
    let path = folder.join(FILE);
    if path.symlink_metadata().is_ok() {
        return List::open(&path).map(State::Ours);
    }
    let names = match names(folder) {
        Ok(names) => names,
        Err(e) if e.kind() == std::io::ErrorKind::NotFound => return Ok(State::Vacant),
        Err(e) => return Err(super::super::cannot_write(folder, &e)),
    };
    if let Some(list) = of_before(folder, &names) {
        return Ok(State::Ours(list));
    }
    // What a process left that was killed before it had written anything.
    let left = |name: &str| name == lock::FILE || partial::target(name) == Some(FILE);
    let mut others = names.into_iter().filter(|name| !left(name));
    Ok(others.next().map_or(State::Vacant, State::Foreign))
}

/// Names of what lies in a folder, in order.
pub(super) fn names(folder: &Path) -> std::io::Result<Vec<String>> {
    let folder = if folder.as_os_str().is_empty() { Path::new(".") } else { folder };
    let entries = std::fs::read_dir(folder)?.collect::<std::io::Result<Vec<_>>>()?;
    let mut names: Vec<_> = entries.iter().map(|e| e.file_name().to_string_lossy().into_owned()).collect();
    names.sort();
    Ok(names)
}

/// What tells a folder that a version without lists wrote, and the command that did.
const MARKS: [(&str, &str); 4] = [
    ("steps.json", STUDY),
    ("report.json", "scenario"),
    ("diagnosis.json", "diagnose"),
    ("benchmark.json", "benchmark"),
];
/// Names that such versions wrote under.
const WRITTEN: [&str; 6] =
    ["report.json", "report.html", "model.ron", "identified.ron", "diagnosis.json", "benchmark.json"];
/// The same in a study. What was dropped into it keeps its place: nobody can tell it from the user's own.
const OF_STUDIES: [&str; 5] =
    ["steps.json", "scenario.ron", "columns.ron", "constraints.ron", "retrieved.ron"];
const CHECKPOINT: &str = ".checkpoint.json";

/// The list of a folder that a version without lists wrote.
fn of_before(folder: &Path, names: &[String]) -> Option<List> {
    let is_marked = |name: &str| {
        let path = folder.join(name);
        path.symlink_metadata().is_ok_and(|m| m.is_file())
            && read(&path).is_ok_and(|t| t.contains("\"lacuna\""))
    };
    let mut list = List::new();
    for (name, by) in MARKS {
        if names.iter().any(|n| n == name) && is_marked(name) {
            list.by.insert(by.to_string());
        }
    }
    if list.by.is_empty() && names.iter().any(|name| name.ends_with(CHECKPOINT) && is_marked(name)) {
        list.by.insert("scenario".to_string());
    }
    if list.is_study() {
        list.by.retain(|by| by == STUDY);
    }
    if list.by.is_empty() {
        return None;
    }
    let study = list.is_study();
    let numbered = |name: &str, stem: &str| {
        let number = name.strip_prefix(stem).and_then(|n| n.strip_suffix(".rhai"));
        number.is_some_and(|n| !n.is_empty() && n.bytes().all(|b| b.is_ascii_digit()))
    };
    let is_ours = |name: &&String| {
        WRITTEN.contains(&name.as_str())
            || name.ends_with(CHECKPOINT)
            || (name.starts_with("unknown_") && name.ends_with(".rhai"))
            || study && OF_STUDIES.contains(&name.as_str())
            || study && (numbered(name, "effect_") || numbered(name, "constraint_"))
    };
    list.made = names.iter().filter(is_ours).cloned().collect();
    if study {
        let below = super::list::names(&folder.join("retrieval")).unwrap_or_default();
        let checkpoints = below.iter().filter(|n| n.ends_with(CHECKPOINT)).map(|n| format!("retrieval/{n}"));
        list.made.extend(checkpoints);
    }
    Some(list)
}
