use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use lacuna::log::{ColumnMap, Log};
use lacuna::model_file::ModelFile;
use lacuna::predict::{predict, prediction_errors};
use lacuna::report::{JointError, finite, joint_errors};
use lacuna::signals::prepare;
use lacuna::{Error, Result, text};
use serde::Serialize;

use super::{Global, open_robot, print, print_json};

#[derive(Serialize)]
struct Comparison {
    lacuna: &'static str,
    robot: String,
    data: String,
    signals: Vec<String>,
    models: BTreeMap<String, Compared>,
}

#[derive(Serialize)]
struct Compared {
    effects: Vec<&'static str>,
    relative_error_percent: Option<f64>,
    joints: Vec<JointError>,
}

/// `lacuna compare MODEL.ron ... --robot R --data A.csv`: all models on one signal step, that of the first.
pub(super) fn run(
    models: &[PathBuf],
    robot: &Path,
    data: &Path,
    columns: Option<&Path>,
    gravity: Option<&str>,
    global: &Global,
) -> Result<bool> {
    let robot = open_robot(robot, gravity)?;
    let files: Vec<ModelFile> = models.iter().map(|m| ModelFile::open(m)).collect::<Result<_>>()?;
    let columns = columns.map(ColumnMap::open).transpose()?;
    let log = Log::open(data, &robot, columns.as_ref())?;
    let (run, signals) = prepare(&log, &files[0].signals)?;
    let runs = [run];
    let names: Vec<String> = robot.joints.iter().map(|j| j.name.clone()).collect();
    let mut compared = BTreeMap::new();
    let labels = labels(models);
    for ((path, file), label) in models.iter().zip(&files).zip(labels) {
        let (model, x) = file.on(&robot).map_err(|e| text::placed(e, path))?;
        let errors = prediction_errors(&runs, &predict(&model, &runs, &x)?);
        let entry = Compared {
            effects: model.effects.iter().map(|e| e.about().name).collect(),
            relative_error_percent: finite(errors.pooled_percent),
            joints: joint_errors(&names, &errors, None),
        };
        if compared.insert(label, entry).is_some() {
            return Err(Error::new("the same model is given twice").in_file(path).help("name it once"));
        }
    }
    let comparison = Comparison {
        lacuna: env!("CARGO_PKG_VERSION"),
        robot: robot.name.clone(),
        data: log.name.clone(),
        signals: signals.lines(),
        models: compared,
    };
    if global.json {
        print_json(&comparison)?
    } else {
        print(&table(&comparison, &names))?
    }
    Ok(true)
}

/// What models are called in results: their paths as given, but for absolute ones only as many of the last
/// parts as tell them apart, since results name no place of this machine.
fn labels(models: &[PathBuf]) -> Vec<String> {
    let tail = |path: &Path, parts: usize| -> PathBuf {
        let all: Vec<_> = path.iter().collect();
        all[all.len().saturating_sub(parts)..].iter().collect()
    };
    let label = |path: &PathBuf| {
        let deepest = path.iter().count() - usize::from(path.has_root());
        let alone =
            |parts: &usize| models.iter().filter(|m| tail(m, *parts) == tail(path, *parts)).count() == 1;
        let parts = (1..deepest).find(alone).unwrap_or(deepest);
        if path.is_absolute() { tail(path, parts) } else { path.clone() }.display().to_string()
    };
    models.iter().map(label).collect()
}

fn table(comparison: &Comparison, names: &[String]) -> String {
    let mut text = String::from("torque error, nothing fitted (rms in N m or N, then % of the torque)\n\n");
    for line in &comparison.signals {
        text += &format!("{line}\n");
    }
    let width = names.iter().map(String::len).max().unwrap_or(0).max(6);
    for (path, model) in &comparison.models {
        text += &format!("\n{path}\n  {}\n", model.effects.join(" + "));
        for joint in &model.joints {
            let percent = joint.relative_error_percent.map_or("-".to_string(), |p| format!("{p:.2} %"));
            let flag = if joint.worse_than_constant { "  worse than a constant" } else { "" };
            text += &format!("  {:width$}  {:10.4}  {percent:>10}{flag}\n", joint.name, joint.rms);
        }
        let pooled = model.relative_error_percent.map_or("-".to_string(), |p| format!("{p:.3} %"));
        text += &format!("  {:width$}  {:10}  {pooled:>10}\n", "pooled", "");
    }
    text
}
