//! The house rules that a compiler does not hold: who may use whom, and how long things may grow.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use lacuna::effects::{CATALOGUE, Stage};
use lacuna::plant::TWINS;

fn rust_files(folder: &str) -> Vec<PathBuf> {
    files(folder, &["rs"])
}

fn files(folder: &str, kinds: &[&str]) -> Vec<PathBuf> {
    let mut found = Vec::new();
    let mut open = vec![PathBuf::from(folder)];
    while let Some(path) = open.pop() {
        for entry in fs::read_dir(&path).expect("folders of the repository read") {
            let path = entry.expect("entries read").path();
            if path.is_dir() {
                open.push(path);
            } else if path.extension().is_some_and(|e| kinds.iter().any(|kind| e == *kind)) {
                found.push(path);
            }
        }
    }
    found.sort();
    found
}

/// Folders with the sources of the program and of every crate of the library.
const SOURCES: [&str; 6] = [
    "src",
    "crates/lacuna/src",
    "crates/lacuna-base/src",
    "crates/lacuna-nlopt/src",
    "crates/lacuna-plant/src",
    "crates/lacuna-retrieval/src",
];

fn all_rust_files() -> Vec<PathBuf> {
    SOURCES.iter().flat_map(|folder| rust_files(folder)).collect()
}

/// The room a source file belongs to: its first folder or its own name below `src`, or a crate that is a room itself.
fn room(path: &Path) -> String {
    let path = path.to_string_lossy().replace('\\', "/");
    for own in ["nlopt", "plant", "retrieval"] {
        let inside = path.strip_prefix(&format!("crates/lacuna-{own}/src/"));
        if let Some(file) = inside {
            let module = file.trim_end_matches(".rs");
            return if ["form", "space"].contains(&module) { module } else { own }.to_string();
        }
    }
    let (_, below) = path.split_once("src/").expect("a source file");
    let first = below.split('/').next().expect("a name");
    first.trim_end_matches(".rs").to_string()
}

/// The rooms that a line of code uses, in every path of it.
fn used(line: &str) -> Vec<String> {
    if line.trim_start().starts_with("//") {
        return Vec::new();
    }
    let crates = ["crate::", "lacuna_base::", "lacuna::"];
    let after = |prefix: &'static str| line.split(prefix).skip(1);
    let name = |rest: &str| rest.chars().take_while(|c| c.is_alphanumeric() || *c == '_').collect::<String>();
    crates.into_iter().flat_map(after).map(name).filter(|name| !name.is_empty()).collect()
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
        ("export", vec!["effects", "identify", "model_file", "robot"]),
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
    for path in all_rust_files() {
        let room = room(&path);
        // A crate's borders are held by its manifest.
        let of_crate = ["nlopt", "plant", "retrieval", "form", "space"].contains(&room.as_str());
        let Some(may) = rules.get(room.as_str()).filter(|_| !of_crate) else { continue };
        let text = fs::read_to_string(&path).expect("reads");
        let code = text.split("#[cfg(test)]").next().unwrap_or_default();
        for (number, line) in code.lines().enumerate() {
            for used in used(line) {
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
}

/// Names of our own crates that a manifest depends on.
fn own_crates(manifest: &str) -> Vec<String> {
    let text = fs::read_to_string(manifest).expect("reads");
    let (_, dependencies) = text.split_once("[dependencies]").expect("a list of dependencies");
    let lines = dependencies.lines().filter(|line| line.starts_with("lacuna"));
    lines.map(|line| line.split(['.', ' ', '=']).next().expect("a name").to_string()).collect()
}

#[test]
fn the_plant_shares_no_code_with_what_is_fitted() {
    assert_eq!(own_crates("crates/lacuna-plant/Cargo.toml"), ["lacuna-base"]);
    assert!(own_crates("crates/lacuna-base/Cargo.toml").is_empty());
    assert_eq!(own_crates("crates/lacuna-retrieval/Cargo.toml"), ["lacuna-base", "lacuna-lapack"]);
}

#[test]
fn the_library_knows_no_server_and_no_command_line() {
    for name in ["lacuna", "lacuna-base", "lacuna-plant", "lacuna-retrieval"] {
        let text = fs::read_to_string(format!("crates/{name}/Cargo.toml")).expect("reads");
        for foreign in ["axum", "hyper", "tokio", "clap", "ctrlc", "signal-hook"] {
            assert!(!text.contains(foreign), "{name} depends on {foreign}");
        }
    }
}

#[test]
fn only_the_simulation_knows_where_the_truth_lies() {
    for path in all_rust_files()
        .into_iter()
        .filter(|p| !p.starts_with("crates/lacuna/src/simulate") && !p.ends_with("tests.rs"))
    {
        let text = fs::read_to_string(&path).expect("reads");
        for word in ["\"truth\"", "\"truth/", "/truth\"", "/truth/", "plant.ron"] {
            assert!(!text.contains(word), "{} knows {word}", path.display());
        }
    }
}

#[test]
fn files_stay_short() {
    for folder in ["src", "crates", "tests", "benches"] {
        for path in rust_files(folder) {
            let lines = fs::read_to_string(&path).expect("reads").lines().count();
            assert!(lines <= 420, "{} has {lines} lines: split it", path.display());
        }
    }
}

#[test]
fn every_room_has_a_map_entry() {
    let map = fs::read_to_string("ARCHITECTURE.md").expect("the map is there");
    for path in all_rust_files() {
        let room = room(&path);
        if !["main", "lib"].contains(&room.as_str()) {
            assert!(map.contains(&format!("`{room}`")), "ARCHITECTURE.md does not know `{room}`");
        }
    }
}

/// Where an effect may be called by name all the same: file, name, reason.
const BY_NAME: [(&str, &str, &str); 3] = [
    (
        "crates/lacuna-base/src/text/explain.rs",
        "viscous_friction",
        "the example of every message about a list; `text` knows no effects",
    ),
    (
        "crates/lacuna/src/benchmark/answers.ron",
        "thermal_friction",
        "rules of published tables, fixed in one place before them",
    ),
    (
        "crates/lacuna/src/benchmark/answers.ron",
        "friction_drift",
        "rules of published tables, fixed in one place before them",
    ),
];

/// Lines of code with the name of an effect as a literal; comments and tests at the foot of a file do not count.
fn lines_that_name(code: &str, effect: &str) -> Vec<usize> {
    let code = code.split("#[cfg(test)]").next().unwrap_or_default();
    let literals = [format!("\"{effect}\""), format!("\\\"{effect}\\\"")];
    let names = |line: &str| {
        !line.trim_start().starts_with("//") && literals.iter().any(|literal| line.contains(literal.as_str()))
    };
    code.lines().enumerate().filter(|(_, line)| names(line)).map(|(number, _)| number + 1).collect()
}

/// What has to be known of an effect it says itself (`effects::About`); who asks for its name instead treats the next
/// effect wrongly without a word. Its own file and its twin in the plant bear the name, as RON does.
#[test]
fn nobody_asks_for_an_effect_by_its_name() {
    assert_eq!(lines_that_name("// \"backlash\"\nif name == \"backlash\" {", "backlash"), [2]);
    assert_eq!(lines_that_name(r#"help("add {\"backlash\": ()}")"#, "backlash"), [1]);
    let sources: Vec<(String, String)> = SOURCES
        .iter()
        .flat_map(|folder| files(folder, &["rs", "js", "ron", "json"]))
        .filter(|path| !path.ends_with("tests.rs"))
        .map(|path| (path.to_string_lossy().replace('\\', "/"), fs::read_to_string(&path).expect("reads")))
        .collect();
    // `script` is a word of constraints, pages and commands as well.
    let named = CATALOGUE.iter().filter(|entry| entry.about.stage != Stage::Given);
    for name in named.map(|entry| entry.about.name) {
        for (path, text) in &sources {
            let allowed = BY_NAME.iter().any(|(file, effect, _)| file == path && *effect == name);
            let bears_it = text.contains(&format!("typetag::serde(name = \"{name}\")"));
            let lines = lines_that_name(text, name);
            assert!(
                allowed || bears_it || lines.is_empty(),
                "{path}:{}: `{name}` by name; ask what `effects::About` says, and let it say more if it must",
                lines[0]
            );
            assert!(!allowed || !lines.is_empty(), "{path} no longer names `{name}`: take it off the list");
        }
    }
}

/// Files that a recipe of CONTRIBUTING names in backquotes, `<name>` standing for any name.
fn named_files(recipe: &str) -> Vec<String> {
    let text = fs::read_to_string("CONTRIBUTING.md").expect("the recipes are there");
    let (_, section) = text.split_once(&format!("## {recipe}\n")).expect("a recipe");
    let section = section.split("\n## ").next().unwrap_or_default();
    let quoted = section.split('`').skip(1).step_by(2);
    let is_file = |word: &&str| word.contains('/') && !word.contains(' ') && !word.contains(':');
    quoted.filter(is_file).map(str::to_string).collect()
}

#[test]
fn the_recipe_for_an_effect_is_true() {
    let named = named_files("Add an effect");
    assert!(named.len() >= 5, "{named:?}");
    for file in named.iter().filter(|file| !file.contains('<')) {
        assert!(Path::new(file).exists(), "CONTRIBUTING names {file}, which is not there");
    }
    let places: Vec<&String> = named.iter().filter(|file| file.contains('<')).collect();
    assert_eq!(places, ["crates/lacuna/src/effects/<name>.rs", "crates/lacuna-plant/src/physics/<name>.rs"]);
    let catalogue = fs::read_to_string("crates/lacuna/src/effects/catalogue.rs").expect("reads");
    let cases: String = ["hidden", "local", "recovered", "bodies", "built_from_torque"]
        .iter()
        .map(|file| fs::read_to_string(format!("tests/effects/{file}.rs")).expect("reads"))
        .collect();
    for about in CATALOGUE.iter().map(|entry| entry.about) {
        let own = fs::read_to_string(format!("crates/lacuna/src/effects/{}.rs", about.name))
            .expect("a file of its own");
        let kind =
            own.split("impl Effect for ").nth(1).and_then(|rest| rest.split(' ').next()).expect("a type");
        assert!(own.contains(&format!("name: \"{}\"", about.name)), "{} does not say its name", about.name);
        assert_eq!(
            catalogue.matches(&format!("about: {kind}::ABOUT")).count(),
            1,
            "{kind}: a line in the catalogue"
        );
        // A plant has rigid bodies anyway, and what a script says nobody knows; both have tests of their own.
        if matches!(about.stage, Stage::InEveryModel | Stage::Given) {
            continue;
        }
        assert_eq!(TWINS.iter().filter(|twin| twin.name == about.name).count(), 1, "{}: a twin", about.name);
        assert!(
            cases.contains(kind) || cases.contains(about.name),
            "{}: no case in tests/effects",
            about.name
        );
    }
}
