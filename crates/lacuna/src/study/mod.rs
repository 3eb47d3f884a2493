//! From a scenario to a report: the only place that knows the order of the steps.

mod comparison;
mod diagnosis;
mod finished;
mod friction;
mod leeway;
mod moving;
mod pictures;
mod retrieval;
mod rivals;
mod statics;

use std::collections::BTreeMap;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};
use std::time::Instant;

use nalgebra::Vector3;

use crate::error::{Error, Result};
use crate::identify::BaseParameters;
use crate::model_file::ModelFile;
use crate::report::Report;
use crate::report::pictures::Pictures;
use crate::retrieval::checkpoint::Checkpoint;
use crate::retrieval::{Step, Watch};
use crate::robot::Robot;
use crate::scenario::{Logs, Published, Scenario};
use crate::stop::Stop;
use crate::text;

use leeway::Leeway;

/// What the caller may add to a scenario.
pub struct Options<'a> {
    /// Logs to use instead of the scenario's.
    pub data: Vec<PathBuf>,
    /// Seed to use instead of the scenario's.
    pub seed: Option<u64>,
    /// Told what is being done.
    pub progress: &'a mut dyn FnMut(&str),
    /// Told how far an engine is; may ask it to stop and keep its best.
    pub watch: &'a Watch<'a>,
    /// Where engines keep finished runs while they work; removed when the study is done.
    pub checkpoint: Option<Checkpoint>,
    /// When what is no engine (a script) ends, with nothing kept.
    pub stop: Stop,
}

impl<'a> Options<'a> {
    /// The scenario as it stands, never stopped, without checkpoints.
    pub fn new(progress: &'a mut dyn FnMut(&str)) -> Self {
        Self {
            data: Vec::new(),
            seed: None,
            progress,
            watch: &go_on,
            checkpoint: None,
            stop: Stop::default(),
        }
    }
}

fn go_on(_: &Step) -> ControlFlow<()> {
    ControlFlow::Continue(())
}

/// What a study gives.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The results.
    pub report: Report,
    /// The finished model: retrieved link parameters where the study retrieved feasible ones, else the
    /// identified coefficients.
    pub model: Option<ModelFile>,
    /// The identified coefficients, where `model` has retrieved ones.
    pub identified: Option<ModelFile>,
    /// What pictures of it are drawn from, where the study has logs.
    pub pictures: Option<Pictures>,
    /// Whether an engine was asked to stop; what it had found by then stands in the report.
    pub stopped: bool,
}

/// A study on its way.
struct Study<'a> {
    folder: PathBuf,
    scenario: Scenario,
    robot: Robot,
    seed: u64,
    data: Vec<PathBuf>,
    progress: &'a mut dyn FnMut(&str),
    watch: &'a Watch<'a>,
    checkpoint: Option<Checkpoint>,
    stop: Stop,
    stopped: bool,
    timing: BTreeMap<String, f64>,
    warnings: Vec<String>,
}

/// Runs the scenario in `path`.
///
/// # Errors
/// When the scenario or something it names cannot be used; the message says where and what to do.
pub fn run(path: &Path, options: Options<'_>) -> Result<Outcome> {
    let scenario = Scenario::open(path)?;
    if !options.data.is_empty() && !matches!(scenario.logs, Some(Logs::Files { .. })) {
        let what = "--data was given, but the scenario takes no log files (`logs`)";
        let help = "leave out --data, or give the scenario `logs: Files(fit: [\"log.csv\"])`";
        return Err(text::placed(Error::new(what).help(help), path));
    }
    // Whatever has no place of its own was asked for by the scenario.
    Study::new(path, scenario, options)
        .and_then(|study| study.all(name(path)))
        .map_err(|e| text::placed(e, path))
}

/// Name of a study: that of its file.
fn name(path: &Path) -> String {
    path.file_stem().map_or_else(|| "study".into(), |s| s.to_string_lossy().into_owned())
}

/// A file that a scenario names, relative to the scenario's folder.
fn named(folder: &Path, file: &Path) -> Result<PathBuf> {
    let path = folder.join(file);
    if path.exists() {
        return Ok(path);
    }
    Err(Error::new(format!("there is no file `{}`", file.display()))
        .help("files are looked for from the folder that the scenario is in"))
}

impl<'a> Study<'a> {
    fn new(path: &Path, mut scenario: Scenario, options: Options<'a>) -> Result<Self> {
        let folder = path.parent().unwrap_or(Path::new(".")).to_path_buf();
        for effect in &mut scenario.effects {
            effect.load(&folder)?;
        }
        for candidate in &mut scenario.candidates {
            candidate.load(&folder)?;
        }
        for constraint in &mut scenario.constraints {
            constraint.load(&folder)?;
            constraint.ends_with(&options.stop);
        }
        for preset in &scenario.presets {
            scenario.constraints.extend(crate::constraints::open(&named(&folder, preset)?)?);
        }
        let mut robot = Robot::open(named(&folder, &scenario.robot)?)?;
        if let Some(gravity) = scenario.gravity {
            robot = robot.with_gravity(Vector3::from(gravity));
        }
        let mut study = Self {
            folder,
            robot,
            seed: options.seed.unwrap_or(scenario.seed),
            scenario,
            data: options.data,
            progress: options.progress,
            watch: options.watch,
            checkpoint: options.checkpoint,
            stop: options.stop,
            stopped: false,
            timing: BTreeMap::new(),
            warnings: Vec::new(),
        };
        study.warn_of_robot();
        Ok(study)
    }
}

impl Study<'_> {
    fn all(mut self, name: String) -> Result<Outcome> {
        let poses = self.timed("static identification", Self::identify_from_poses)?;
        let mut logs = self.timed("identification from logs", Self::identify_from_logs)?;
        let to_diagnose = logs.to_diagnose.take();
        let diagnosis = self.timed("diagnosis", |s| s.diagnosis(to_diagnose))?;
        let friction = self.timed("friction path", |s| s.friction_path(logs.to_fit(), poses.as_ref()))?;
        let moving = logs.fitted.as_ref();
        let mut engines = self.timed("retrieval", |s| s.retrieve(poses.as_ref(), moving))?;
        let leeway = match &mut engines {
            Some(engines) if !self.stopped => self.timed("leeway", |s| s.leeway(engines))?,
            _ => Leeway::default(),
        };
        let comparison = match &engines {
            Some(engines) => self.compare(engines, &logs, &friction)?,
            None => None,
        };
        let retrieved = match &engines {
            Some(engines) => self.retrieved_model(engines, moving, poses.as_ref(), &friction)?,
            None => None,
        };
        let pictures = self.pictures(&logs, retrieved.as_ref())?;
        let identified = moving.map(|m| &m.model).or(poses.as_ref().map(|p| &p.model)).cloned();
        let (model, identified) = match retrieved {
            Some(model) => (Some(model), identified),
            None => (identified, None),
        };
        let identifications: Vec<_> =
            poses.into_iter().map(|p| p.report).chain(logs.fitted.map(|m| m.report)).collect();
        let conflict = engines.as_ref().and_then(|e| e.conflict.clone());
        let given = engines.as_ref().map_or(Vec::new(), |e| e.given.clone());
        let (given, beside) = given.into_iter().partition::<Vec<_>, _>(|r| r.label == retrieval::GIVEN);
        let report = Report {
            lacuna: env!("CARGO_PKG_VERSION").to_string(),
            seed: self.seed,
            scenario: name,
            robot: self.robot.name.clone(),
            identification: identifications.first().cloned(),
            identifications,
            friction,
            diagnosis,
            retrievals: engines.map(|e| e.reports),
            given: given.into_iter().next(),
            beside,
            conflict: conflict.map(|c| c.constraints),
            intervals: leeway.intervals,
            chosen: leeway.chosen,
            comparison,
            warnings: self.warnings,
            timing: self.timing,
        };
        Ok(Outcome { report, model, identified, pictures, stopped: self.stopped })
    }

    fn timed<T>(&mut self, step: &str, work: impl FnOnce(&mut Self) -> Result<T>) -> Result<T> {
        let start = Instant::now();
        let result = work(self);
        self.timing.insert(step.to_string(), start.elapsed().as_secs_f64());
        result
    }

    fn say(&mut self, what: &str) {
        (self.progress)(what);
    }

    fn warn(&mut self, what: impl Into<String>) {
        self.warnings.push(what.into());
    }

    fn warn_of_robot(&mut self) {
        for remark in self.robot.remarks.clone() {
            let line = remark.line.map_or_else(String::new, |l| format!("line {l}: "));
            self.warn(format!("{}: {line}{}", self.scenario.robot.display(), remark.text));
        }
    }
}

/// Published coefficients in a file that a scenario names, and their values in the order of `base`.
fn published(folder: &Path, file: &Path, base: &BaseParameters) -> Result<(Published, Vec<f64>)> {
    let path = named(folder, file)?;
    let published = Published::open(&path)?;
    let values = published.values(base).map_err(|e| text::placed(e, &path))?;
    Ok((published, values))
}

/// A warning when rows do not far outnumber unknowns (eq. 18 of Gaz et al. 2019).
fn too_few_rows(rows: usize, unknowns: usize) -> Option<String> {
    (rows < 10 * unknowns)
        .then(|| format!("{rows} rows for {unknowns} unknowns: rows should far outnumber unknowns (eq. 18)"))
}
