use std::path::{Path, PathBuf};

use lacuna::log::ColumnMap;
use lacuna::model_file::ModelFile;
use lacuna::predict::{predict, prediction_errors};
use lacuna::report::{JointError, cut, finite, hanging, joint_errors};
use lacuna::signals::{prepare, thinned};
use lacuna::{Error, Result, text};
use serde::{Serialize, Serializer};

use super::{Global, open_log, open_model, open_robot, print, print_json};

/// Models side by side in one table.
const ABREAST: usize = 3;
/// Widest joint name that is not cut.
const NAME: usize = 12;

#[derive(Serialize)]
struct Comparison {
    lacuna: &'static str,
    robot: String,
    data: String,
    signals: Vec<String>,
    /// By label, in the order given.
    #[serde(serialize_with = "by_label")]
    models: Vec<(String, Compared)>,
}

fn by_label<S: Serializer>(models: &[(String, Compared)], to: S) -> Result<S::Ok, S::Error> {
    to.collect_map(models.iter().map(|(label, model)| (label, model)))
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
    let files: Vec<ModelFile> = models.iter().map(|m| open_model(m)).collect::<Result<_>>()?;
    let columns = columns.map(ColumnMap::open).transpose()?;
    let log = thinned(open_log(data, &robot, columns.as_ref())?, &files[0].signals)?;
    let (run, signals) = prepare(&log, &files[0].signals)?;
    let runs = [run];
    let names: Vec<String> = robot.joints.iter().map(|j| j.name.clone()).collect();
    let mut compared: Vec<(String, Compared)> = Vec::new();
    let labels = labels(models);
    for ((path, file), label) in models.iter().zip(&files).zip(labels) {
        let (model, x) = file.on(&robot).map_err(|e| text::placed(e, path))?;
        let errors = prediction_errors(&runs, &predict(&model, &runs, &x)?);
        if compared.iter().any(|(other, _)| *other == label) {
            return Err(Error::new("the same model is given twice").in_file(path).help("name it once"));
        }
        let entry = Compared {
            effects: model.effects.iter().map(|e| e.about().name).collect(),
            relative_error_percent: finite(errors.pooled_percent),
            joints: joint_errors(&names, &errors, None),
        };
        compared.push((label, entry));
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
        print(&shown(&comparison, &names))?
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

/// What a model is called in the tables.
fn number(model: usize) -> String {
    format!("model {}", model + 1)
}

fn shown(comparison: &Comparison, names: &[String]) -> String {
    let mut text = hanging("", &format!("torque error on {}, nothing fitted", comparison.data), 4);
    if comparison.models.len() > 1 {
        text += "signal step of model 1 for all:\n";
    }
    for line in &comparison.signals {
        let indent = 2 + line.chars().take_while(|c| *c == ' ').count();
        text += &hanging(&" ".repeat(indent), line, indent + 2);
    }
    for (k, (label, model)) in comparison.models.iter().enumerate() {
        text += &format!("\n{}  {label}\n", number(k));
        text += &hanging("         ", &model.effects.join(" + "), 9);
    }
    let models: Vec<&Compared> = comparison.models.iter().map(|(_, model)| model).collect();
    let rms = |joint: usize| least(models.iter().map(|m| Some(m.joints[joint].rms)));
    let rows: Vec<Option<usize>> = (0..names.len()).map(rms).collect();
    let pooled = least(models.iter().map(|m| m.relative_error_percent));
    for first in (0..models.len()).step_by(ABREAST) {
        let group = &models[first..(first + ABREAST).min(models.len())];
        text += &table(group, first, names, &rows, pooled);
    }
    if models.len() > 1 {
        text += "* the smallest error of all models\n";
    }
    if models.iter().flat_map(|m| &m.joints).any(|j| j.worse_than_constant) {
        text += "! worse than a constant\n";
    }
    text
}

/// Errors of some models, the first of which has the number `first`, with the best of all marked.
fn table(
    group: &[&Compared],
    first: usize,
    names: &[String],
    best: &[Option<usize>],
    pooled: Option<usize>,
) -> String {
    let width = names.iter().map(|n| n.chars().count()).max().unwrap_or(0).clamp(6, NAME);
    let mut text = format!("\n{:width$}", "joint");
    (0..group.len()).for_each(|k| text += &format!("  {:>18}  ", number(first + k)));
    text = format!("{}\n{:width$}", text.trim_end(), "");
    group.iter().for_each(|_| text += &format!("  {:>9} {:>8}  ", "N m, N", "%"));
    text = text.trim_end().to_string() + "\n";
    for (j, name) in names.iter().enumerate() {
        let mut line = format!("{:width$}", cut(name, width));
        for (k, model) in group.iter().enumerate() {
            let joint = &model.joints[j];
            let percent = joint.relative_error_percent.map_or("-".to_string(), |p| format!("{p:.2}"));
            let star = if best[j] == Some(first + k) { '*' } else { ' ' };
            let worse = if joint.worse_than_constant { '!' } else { ' ' };
            line += &format!("  {:>9.4} {percent:>8}{star}{worse}", joint.rms);
        }
        text += &format!("{}\n", line.trim_end());
    }
    let mut line = format!("{:width$}", "pooled");
    for (k, model) in group.iter().enumerate() {
        let percent = model.relative_error_percent.map_or("-".to_string(), |p| format!("{p:.3}"));
        let star = if pooled == Some(first + k) { "* " } else { "  " };
        line += &format!("  {:>9} {percent:>8}{star}", "");
    }
    text + line.trim_end() + "\n"
}

/// Which of several numbers is the smallest; none where there is nothing to choose from.
fn least(values: impl ExactSizeIterator<Item = Option<f64>>) -> Option<usize> {
    let several = values.len() > 1;
    let numbers = values.enumerate().filter_map(|(k, value)| Some((k, value?)));
    numbers.min_by(|a, b| a.1.total_cmp(&b.1)).map(|(k, _)| k).filter(|_| several)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn compared(percent: f64, rms: [f64; 2]) -> Compared {
        let joint = |rms: f64| JointError {
            name: String::new(),
            torque_rms: 1.0,
            rms,
            relative_error_percent: Some(100.0 * rms),
            held_out_relative_error_percent: None,
            worse_than_constant: rms > 1.0,
        };
        Compared {
            effects: vec!["rigid_body"; 8],
            relative_error_percent: Some(percent),
            joints: rms.map(joint).into(),
        }
    }

    #[test]
    fn models_stand_in_their_order_and_the_best_of_every_line_is_marked() {
        let models =
            [("z", 3.0, [0.3, 1.5]), ("y", 1.0, [0.4, 0.1]), ("b", 2.0, [0.5, 0.2]), ("a", 5.0, [0.2, 0.3])];
        let models = models.map(|(label, percent, rms)| (label.to_string(), compared(percent, rms)));
        let comparison = Comparison {
            lacuna: "0",
            robot: "arm".into(),
            data: "log.csv".into(),
            signals: vec!["word ".repeat(30)],
            models: models.into(),
        };
        let names = ["joint1".to_string(), "a_long_name_of_joint_2".to_string()];
        let text = shown(&comparison, &names);
        assert!(text.lines().all(|line| line.chars().count() <= 80), "{text}");
        let lines: Vec<&str> = text.lines().filter(|l| l.starts_with("joint1")).collect();
        assert_eq!(lines.len(), 2, "{text}");
        assert!(!lines[0].contains('*') && lines[1].contains("0.2000    20.00*"), "{text}");
        assert!(text.contains("1.5000   150.00 !"), "{text}");
        let pooled: Vec<&str> = text.lines().filter(|l| l.starts_with("pooled")).collect();
        assert!(pooled[0].contains("1.000*") && !pooled[1].contains('*'), "{text}");
        let json = serde_json::to_string(&comparison).expect("JSON");
        let order: Vec<usize> =
            ["\"z\"", "\"y\"", "\"b\"", "\"a\""].map(|l| json.find(l).expect("is there")).into();
        assert!(order.is_sorted(), "{json}");
    }
}
