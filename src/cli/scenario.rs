use std::path::{Path, PathBuf};

use lacuna::report::Report;
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
    if let Some(identified) = &outcome.identified {
        identified.write(&out.join("identified.ron"))?;
    }
    if global.json {
        print_json(&outcome.report)?;
    } else {
        print(&report::render(&outcome.report))?;
        print(&next_steps(&out, outcome.model.is_some()))?;
    }
    Ok(feasible(&outcome.report))
}

/// Whether some engine found feasible parameters, where one was asked to.
fn feasible(report: &Report) -> bool {
    report.retrievals.as_ref().is_none_or(|all| all.iter().any(|r| r.feasible))
}

fn next_steps(out: &Path, has_model: bool) -> String {
    let report = out.join("report.json");
    let mut text = format!("\nwritten  {}", report.display());
    if has_model {
        text += &format!(", {}", out.join("model.ron").display());
        text += &format!(
            "\nnext     lacuna compare {} --robot R --data LOG.csv",
            out.join("model.ron").display()
        );
    }
    text + "\n"
}
