//! What can be taken away.

use super::bench::Bench;
use super::pictures::{Pair, Shown};
use super::study::Study;
use crate::error::{Error, Result};
use crate::export::{Parameters, mjcf, urdf};
use crate::model_file::ModelFile;
use crate::text;

/// Files that lie in the folder as they are.
const KEPT: [&str; 9] = [
    "scenario.ron",
    "model.ron",
    "retrieved.ron",
    "constraints.ron",
    "columns.ron",
    "diagnosis.json",
    "report.json",
    "steps.json",
    "identified.ron",
];

/// Names of the files that there are now.
pub(super) fn names(study: &Study) -> Vec<String> {
    let mut all: Vec<String> = Vec::new();
    let has_fit = study.shown.and_then(|id| study.step(id)).is_some_and(|s| s.fitted.is_some());
    if has_fit {
        all.push("report.html".to_string());
    }
    all.extend(KEPT.iter().filter(|name| study.output.has(name)).map(ToString::to_string));
    if study.output.has("retrieved.ron") {
        all.extend(["robot.urdf".to_string(), "robot.mjcf".to_string()]);
    }
    all.extend(study.scripts.iter().map(|s| s.file.clone()));
    all
}

/// A file as its type and content.
///
/// # Errors
/// When there is no such file, or not yet.
pub(super) fn take(bench: &Bench, name: &str) -> Result<(&'static str, Vec<u8>)> {
    let known = names(&bench.study());
    if !known.iter().any(|n| n == name) {
        return Err(Error::new(format!("there is no file `{name}` to take away"))
            .help(format!("there are now: {}", known.join(", "))));
    }
    match name {
        "report.html" => {
            Ok(("text/html; charset=utf-8", Shown::of(bench, Pair::default())?.html()?.into_bytes()))
        }
        "robot.urdf" | "robot.mjcf" => Ok(("application/xml", robot(bench, name)?.into_bytes())),
        _ => {
            let kind = if name.ends_with(".json") { "application/json" } else { "text/plain; charset=utf-8" };
            Ok((kind, bench.output().read(name)?.into_bytes()))
        }
    }
}

/// The robot with the link parameters that were retrieved.
fn robot(bench: &Bench, name: &str) -> Result<String> {
    let (model, file, robot) = {
        let study = bench.study();
        let robot = study.robot().cloned().ok_or_else(|| Error::new("there is no robot"))?;
        (study.output.read("retrieved.ron")?, study.robot.as_ref().map(|r| r.path.clone()), robot)
    };
    let parameters =
        Parameters::read(&ModelFile::parse(&model).map_err(|e| e.in_file("retrieved.ron"))?, &robot)?;
    if name == "robot.mjcf" {
        return Ok(mjcf(&robot, &parameters)?.text);
    }
    let original = file.filter(|f| !f.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron")));
    let original = original.map(|f| text::read(&f)).transpose()?;
    Ok(urdf(&robot, &parameters, original.as_deref())?.text)
}
