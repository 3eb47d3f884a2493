use std::path::{Path, PathBuf};

use lacuna::study::{self, Options};
use lacuna::{Result, report, text};

use super::console::Console;
use super::{Global, json, print, print_json};

/// `lacuna scenario FILE.ron`.
pub(super) fn run(file: &Path, data: Vec<PathBuf>, global: &Global, console: &Console) -> Result<bool> {
    if let Some(out) = &global.out {
        text::check_writable(out)?;
    }
    let mut progress = |what: &str| console.say(what);
    let options = Options { data, seed: global.seed, progress: &mut progress };
    let outcome = study::run(file, options)?;
    console.clear();
    let out = global.out.clone().unwrap_or_else(|| Path::new("out").join(&outcome.report.scenario));
    text::write_whole(&out.join("report.json"), (json(&outcome.report)? + "\n").as_bytes())?;
    if let Some(model) = &outcome.model {
        model.write(&out.join("model.ron"))?;
    }
    if global.json {
        print_json(&outcome.report)?;
    } else {
        print(&report::render(&outcome.report))?;
        print(&next_steps(file, &out, outcome.model.is_some()))?;
    }
    Ok(true)
}

fn next_steps(scenario: &Path, out: &Path, has_model: bool) -> String {
    let report = out.join("report.json");
    let mut text = format!("\nwritten  {}", report.display());
    if has_model {
        text += &format!(", {}", out.join("model.ron").display());
        text += &format!(
            "\nnext     lacuna compare {} --robot {} --data LOG.csv\n         predicts another log; nothing is \
             fitted",
            out.join("model.ron").display(),
            robot_of(scenario).display()
        );
    }
    text + "\n"
}

/// Where the scenario's robot is, as seen from here.
fn robot_of(scenario: &Path) -> PathBuf {
    let Ok(study) = lacuna::scenario::Scenario::open(scenario) else { return PathBuf::from("ROBOT") };
    let mut path = PathBuf::new();
    for part in scenario.parent().unwrap_or(Path::new("")).join(study.robot).components() {
        // `scenarios/../robots` is `robots`; a folder that is a link elsewhere is not worth the detour here.
        let goes_back = part == std::path::Component::ParentDir;
        if !(goes_back && path.file_name().is_some() && path.pop()) {
            path.push(part);
        }
    }
    path
}
