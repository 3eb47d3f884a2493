//! The house rules that a compiler does not hold: who may use whom, and how long things may grow.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

fn rust_files(folder: &str) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::from(folder)];
    while let Some(path) = open.pop() {
        for entry in fs::read_dir(&path).expect("folders of the repository read") {
            let path = entry.expect("entries read").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| e == "rs") {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// The room a source file belongs to: its first folder or its own name below `src`.
fn room(path: &Path) -> String {
    let below = path.strip_prefix("src").expect("a source file");
    let first = below.components().next().expect("a name").as_os_str().to_string_lossy().into_owned();
    first.trim_end_matches(".rs").to_string()
}

/// What each room may use, besides itself, `error`, `text` and `stop`; as drawn in ARCHITECTURE.md.
fn allowed() -> BTreeMap<&'static str, Vec<&'static str>> {
    BTreeMap::from([
        ("error", vec![]),
        ("text", vec![]),
        ("random", vec![]),
        ("stop", vec![]),
        ("linalg", vec![]),
        ("robot", vec![]),
        ("log", vec!["robot"]),
        ("signals", vec!["log"]),
        ("kernels", vec!["robot", "linalg"]),
        ("excitation", vec!["robot", "random"]),
        ("plant", vec!["robot", "random", "excitation", "log"]),
        (
            "simulate",
            vec![
                "robot",
                "log",
                "excitation",
                "random",
                "plant",
                "scenario",
                "signals",
                "effects",
                "identify",
                "model",
            ],
        ),
        ("effects", vec!["robot", "kernels", "signals", "script"]),
        ("model", vec!["robot", "kernels", "signals", "effects", "identify"]),
        ("identify", vec!["robot", "kernels", "linalg", "log", "signals", "effects", "model"]),
        ("predict", vec!["identify", "model", "signals"]),
        (
            "check",
            vec![
                "effects",
                "excitation",
                "identify",
                "kernels",
                "linalg",
                "log",
                "model",
                "model_file",
                "plant",
                "predict",
                "report",
                "robot",
                "scenario",
                "signals",
                "simulate",
                "study",
                "constraints",
                "random",
                "script",
                "space",
            ],
        ),
        (
            "workbench",
            vec![
                "check",
                "constraints",
                "diagnose",
                "effects",
                "export",
                "log",
                "model_file",
                "report",
                "retrieval",
                "robot",
                "scenario",
                "signals",
                "study",
            ],
        ),
        ("model_file", vec!["effects", "identify", "model", "robot", "signals"]),
        ("space", vec![]),
        ("form", vec![]),
        ("retrieval", vec!["space", "form", "random"]),
        ("constraints", vec!["space", "form", "retrieval", "robot", "script"]),
        ("script", vec!["space", "form"]),
        ("export", vec!["identify", "model_file", "robot"]),
        (
            "diagnose",
            vec![
                "effects",
                "identify",
                "kernels",
                "linalg",
                "log",
                "model",
                "model_file",
                "predict",
                "random",
                "report",
                "robot",
                "signals",
            ],
        ),
        ("benchmark", vec!["diagnose", "log", "random", "robot", "scenario", "signals", "simulate"]),
        ("report", vec!["diagnose", "effects", "identify", "retrieval", "robot", "signals"]),
        (
            "scenario",
            vec!["constraints", "effects", "excitation", "identify", "plant", "retrieval", "signals"],
        ),
    ])
}

#[test]
fn rooms_use_only_what_they_may() {
    let rules = allowed();
    for path in rust_files("src") {
        let room = room(&path);
        let Some(may) = rules.get(room.as_str()) else { continue };
        let text = fs::read_to_string(&path).expect("reads");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for (number, line) in code.lines().enumerate() {
            let Some(used) = line.split("crate::").nth(1).filter(|_| !line.trim_start().starts_with("//"))
            else {
                continue;
            };
            let used: String = used.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect();
            let free = [room.as_str(), "error", "text", "stop", "Error", "Result"];
            assert!(
                free.contains(&used.as_str()) || may.contains(&used.as_str()),
                "{}:{}: `{room}` may not use `{used}`",
                path.display(),
                number + 1
            );
        }
    }
}

#[test]
fn the_plant_shares_no_code_with_what_is_fitted() {
    for path in rust_files("src/plant").into_iter().chain(rust_files("src/excitation")) {
        let text = fs::read_to_string(&path).expect("reads");
        for forbidden in ["crate::kernels", "crate::effects", "crate::model", "crate::identify"] {
            assert!(!text.contains(forbidden), "{} uses {forbidden}", path.display());
        }
    }
}

#[test]
fn only_the_simulation_knows_where_the_truth_lies() {
    for path in rust_files("src").into_iter().filter(|p| !p.starts_with("src/simulate")) {
        let text = fs::read_to_string(&path).expect("reads");
        for word in ["\"truth\"", "\"truth/", "/truth\"", "/truth/", "plant.ron"] {
            assert!(!text.contains(word), "{} knows {word}", path.display());
        }
    }
}

#[test]
fn files_stay_short() {
    for folder in ["src", "tests", "benches"] {
        for path in rust_files(folder) {
            let lines = fs::read_to_string(&path).expect("reads").lines().count();
            assert!(lines <= 420, "{} has {lines} lines: split it", path.display());
        }
    }
}

#[test]
fn every_room_has_a_map_entry() {
    let map = fs::read_to_string("ARCHITECTURE.md").expect("the map is there");
    for path in rust_files("src") {
        let room = room(&path);
        if !["main", "lib"].contains(&room.as_str()) {
            assert!(map.contains(&format!("`{room}`")), "ARCHITECTURE.md does not know `{room}`");
        }
    }
}
