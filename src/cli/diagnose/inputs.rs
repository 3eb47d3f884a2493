use std::path::{Path, PathBuf};

use lacuna::diagnose::Start;
use lacuna::effects::Effect;
use lacuna::log::{ColumnMap, Log};
use lacuna::robot::Robot;
use lacuna::scenario::{HoldOut, Logs, find_log};
use lacuna::signals::{Mode, Settings, thinned};
use lacuna::{Error, Result, text};

use super::super::{open_log, open_model, open_robot, open_scenario};
use super::Diagnose;

/// Models that have a name.
const MODELS: [&str; 3] = ["rigid", "classic", "given"];

/// What a scenario or the flags name.
pub(super) struct Inputs {
    pub robot: Robot,
    pub robot_path: PathBuf,
    pub logs: Vec<Log>,
    pub validate: Vec<Log>,
    pub reference: Vec<Log>,
    pub start: Start,
    pub settings: Settings,
    pub choose: bool,
    pub hold_out: HoldOut,
    pub seed: u64,
    /// Effects to add first, by name and joint.
    pub add: Vec<(String, Option<String>)>,
    /// Candidates beside the catalogue.
    pub extra: Vec<Box<dyn Effect>>,
}

impl Diagnose {
    pub(super) fn in_scenario(&self, file: &Path) -> Result<Inputs> {
        let mut scenario = open_scenario(file)?;
        let folder = file.parent().unwrap_or(Path::new(".")).to_path_buf();
        for effect in scenario.effects.iter_mut().chain(&mut scenario.candidates) {
            effect.load(&folder).map_err(|e| text::placed(e, file))?;
        }
        let robot_path = plain(&folder.join(&scenario.robot));
        let mut robot = open_robot(&robot_path, self.from.gravity.as_deref())?;
        if let (Some(gravity), None) = (scenario.gravity, &self.from.gravity) {
            robot = robot.with_gravity(nalgebra::Vector3::from(gravity));
        }
        let add = self.wishes(&robot, &mut scenario.candidates)?;
        let start = match &self.model {
            Some(model) => start(model)?,
            None => Start::Effects(scenario.effects.clone()),
        };
        let Some(Logs::Files { fit, validate, columns, missing }) = &scenario.logs else {
            return Err(Error::new("the scenario names no log files to diagnose")
                .in_file(file)
                .help("give it `logs: Files(fit: [..])`"));
        };
        let columns = match (&self.from.columns, columns) {
            (Some(map), _) => Some(ColumnMap::open(map)?),
            (None, Some(map)) => Some(ColumnMap::open(folder.join(map))?),
            (None, None) => None,
        };
        let named = |files: &[PathBuf]| -> Result<Vec<PathBuf>> {
            let found = |f: &PathBuf| find_log(&folder, f, missing.as_deref());
            files.iter().map(|f| found(f).map_err(|e| text::placed(e, file))).collect()
        };
        let settings = self.settings(scenario.signals.clone());
        let pick = |given: &[PathBuf], files: &[PathBuf]| -> Result<Vec<Log>> {
            let files = if given.is_empty() { named(files)? } else { given.to_vec() };
            files.iter().map(|f| thinned(open_log(f, &robot, columns.as_ref())?, &settings)).collect()
        };
        let (logs, validate) = (pick(&self.from.data, fit)?, pick(&self.from.validate, validate)?);
        let reference = pick(&self.reference, &[])?;
        let chosen = scenario.signals.mode == Mode::Parallel;
        Ok(Inputs {
            logs,
            validate,
            reference,
            start,
            settings,
            choose: !chosen,
            hold_out: scenario.hold_out,
            seed: scenario.seed,
            add,
            extra: scenario.candidates,
            robot,
            robot_path,
        })
    }

    pub(super) fn in_flags(&self, path: &Path) -> Result<Inputs> {
        let robot = open_robot(path, self.from.gravity.as_deref())?;
        if self.from.data.is_empty() {
            return Err(Error::new("no log to explain").help("give --data A.csv"));
        }
        let mut extra = Vec::new();
        let add = self.wishes(&robot, &mut extra)?;
        let start = start(self.model.as_deref().unwrap_or("classic"))?;
        let columns = self.from.columns.as_ref().map(ColumnMap::open).transpose()?;
        let settings = self.settings(Settings::for_diagnosis());
        let open = |files: &[PathBuf]| -> Result<Vec<Log>> {
            files.iter().map(|f| thinned(open_log(f, &robot, columns.as_ref())?, &settings)).collect()
        };
        let (logs, validate, reference) =
            (open(&self.from.data)?, open(&self.from.validate)?, open(&self.reference)?);
        Ok(Inputs {
            logs,
            validate,
            reference,
            start,
            settings,
            choose: true,
            hold_out: HoldOut::Auto,
            seed: 1,
            add,
            extra,
            robot_path: path.to_path_buf(),
            robot,
        })
    }

    fn settings(&self, mut settings: Settings) -> Settings {
        settings.mode = Mode::Parallel;
        if let Some(band) = self.band {
            settings.band_hz = band;
        }
        settings
    }
}

fn start(model: &str) -> Result<Start> {
    Ok(match model {
        "rigid" => Start::Rigid,
        "classic" => Start::Classic,
        "given" => Start::Given,
        path => Start::Effects(model_effects(path)?),
    })
}

/// The effects of a model file; a word that is no file may be a slip for one of the models that have a name.
fn model_effects(path: &str) -> Result<Vec<Box<dyn Effect>>> {
    let file = Path::new(path);
    if !file.exists() && !path.contains(['.', '/']) {
        let help = format!("{}, or a file: model.ron of a study", text::suggestion(path, MODELS));
        return Err(Error::new(format!("--model: no model called `{path}`")).help(help));
    }
    Ok(open_model(file)?.effects)
}

/// A path for people: without `name/..`.
fn plain(path: &Path) -> PathBuf {
    let mut short = PathBuf::new();
    for part in path.components() {
        let back = part == std::path::Component::ParentDir
            && matches!(short.components().next_back(), Some(std::path::Component::Normal(_)));
        if back {
            short.pop();
        } else {
            short.push(part);
        }
    }
    short
}
