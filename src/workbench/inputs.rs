//! What a study is made from: files that were named on the command line, a scenario, or an earlier study; and
//! what a fit or search of it is given.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use nalgebra::Vector3;

use super::study::{LogFile, RobotFile, Role, Root, Signals, Step, Study};
use super::{Options, constraints, folder, written};
use crate::check::{Kind, misplaced};
use crate::diagnose::{Limits, Request, Start};
use crate::effects::{Effect, classic};
use crate::error::{Error, Result};
use crate::log::{ColumnMap, Log};
use crate::robot::Robot;
use crate::scenario::{HoldOut, Logs, Scenario, find_log};
use crate::signals::{Mode, Run, Settings, thinned};
use crate::text::{self, Output, output::is_vacant};

/// The study that the command line asks for; nothing is read yet but scenario and robot.
///
/// # Errors
/// When a file that was named is not there or wrong, or the folder cannot be written to.
pub(super) fn study(options: &Options) -> Result<Study> {
    let name = name(options);
    let folder = options.folder.clone().unwrap_or_else(|| free(&Path::new("out/workbench").join(&name)));
    if options.resume {
        return folder::load(folder::open(&folder)?);
    }
    if folder::holds_study(&folder) {
        return Err(Error::new("a study lies in this folder already")
            .in_file(&folder)
            .help("go on with it by --resume DIR, or give another --out DIR"));
    }
    let output =
        Output::claim_study(&folder).map_err(|e| e.or_help("give another --out DIR, or an empty one"))?;
    let mut study = empty(name, output);
    study.seed = options.seed.unwrap_or(1);
    match &options.scenario {
        Some(file) => of_scenario(&mut study, file)?,
        None => of_files(&mut study, options)?,
    }
    if let Some(gravity) = options.gravity {
        study.gravity = Some(gravity);
    }
    if let Some(map) = &options.columns {
        study.columns = Some(map_text(map)?);
    }
    let files = study.robot.iter().map(|r| &r.path).chain(study.logs.iter().map(|l| &l.path));
    let told = files.map(|file| folder::beside(&study.folder, file).display().to_string());
    study.output.give(told)?;
    folder::save(&study)?;
    Ok(study)
}

fn name(options: &Options) -> String {
    let first = options.scenario.as_deref().or(options.data.first().map(PathBuf::as_path));
    let file = first.and_then(Path::file_name).map(|f| f.to_string_lossy().into_owned());
    let file = file.unwrap_or_else(|| "study".to_string());
    let short = file.trim_end_matches(".gz").trim_end_matches(".csv").trim_end_matches(".ron");
    short.to_string()
}

/// The folder, or one beside it with a number where something lies there.
fn free(folder: &Path) -> PathBuf {
    let numbered = |k: usize| PathBuf::from(format!("{}_{k}", folder.display()));
    if is_vacant(folder) {
        return folder.to_path_buf();
    }
    (2..).map(numbered).find(|f| is_vacant(f)).unwrap_or_else(|| folder.to_path_buf())
}

fn empty(name: String, output: Output) -> Study {
    Study {
        name,
        folder: output.folder().to_path_buf(),
        output,
        robot: None,
        gravity: None,
        logs: Vec::new(),
        columns: None,
        signals: Signals { settings: Settings::for_diagnosis(), widths: Vec::new(), chosen: false },
        hold_out: HoldOut::Auto,
        seed: 1,
        steps: vec![first(Root::Classic)],
        shown: None,
        against: None,
        constraints: constraints::USUAL.to_string(),
        scripts: Vec::new(),
        engines: Vec::new(),
        intervals: false,
        retrieval: None,
        trouble: None,
    }
}

/// A step that nothing comes before.
pub(super) fn first(root: Root) -> Step {
    Step {
        id: 0,
        parent: None,
        root: Some(root),
        added: None,
        effects: Vec::new(),
        fitted: None,
        ranking: None,
        scan: None,
        numbers: Default::default(),
    }
}

fn of_files(study: &mut Study, options: &Options) -> Result<()> {
    if let Some(path) = &options.robot {
        Robot::open(path).map_err(|e| misplaced(e, path, &[Kind::Urdf, Kind::DenavitHartenberg]))?;
        study.robot = Some(RobotFile { path: path.clone(), robot: None, problem: None });
    }
    for (files, role) in [(&options.data, Role::Fit), (&options.validate, Role::Validate)] {
        for path in files {
            add_log(study, path.clone(), None, role)?;
        }
    }
    Ok(())
}

/// Takes a log into the study under the name that its user knows it by.
///
/// # Errors
/// When it is not there.
pub(super) fn add_log(study: &mut Study, path: PathBuf, name: Option<String>, role: Role) -> Result<()> {
    if !path.is_file() {
        return Err(Error::new("the log is not there").in_file(&path).help("check the path"));
    }
    let own = || path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
    let id = study.logs.iter().map(|l| l.id + 1).max().unwrap_or(0);
    let name = name.unwrap_or_else(own);
    study.logs.push(LogFile { id, name, path, role, log: None, seen: None, findings: None });
    Ok(())
}

fn of_scenario(study: &mut Study, file: &Path) -> Result<()> {
    let mut scenario = Scenario::open(file).map_err(|e| misplaced(e, file, &[Kind::Scenario]))?;
    let folder = file.parent().unwrap_or(Path::new(".")).to_path_buf();
    for effect in scenario.effects.iter_mut().chain(&mut scenario.candidates) {
        effect.load(&folder).map_err(|e| text::placed(e, file))?;
    }
    let Some(Logs::Files { fit, validate, columns, missing }) = &scenario.logs else {
        return Err(Error::new("the scenario names no log files to work on")
            .in_file(file)
            .help("give it `logs: Files(fit: [..])`"));
    };
    let robot = folder.join(&scenario.robot);
    Robot::open(&robot)?;
    study.robot = Some(RobotFile { path: robot, robot: None, problem: None });
    study.gravity = scenario.gravity;
    for (files, role) in [(fit, Role::Fit), (validate, Role::Validate)] {
        for log in files {
            add_log(study, find_log(&folder, log, missing.as_deref())?, None, role)?;
        }
    }
    if let Some(map) = columns {
        study.columns = Some(map_text(&folder.join(map))?);
    }
    let own = scenario.signals.mode == Mode::Parallel;
    let settings = scenario.signals.clone().in_parallel();
    study.signals = Signals { settings, widths: Vec::new(), chosen: own };
    (study.hold_out, study.seed) = (scenario.hold_out, scenario.seed);
    study.constraints = list(&scenario, &folder, &study.folder)?;
    let engines = scenario.engines.iter().map(|e| Ok(text::to_ron(e)?.trim_end().to_string()));
    study.engines = engines.collect::<Result<_>>()?;
    study.intervals = scenario.intervals.is_some();
    // Where the scenario leaves the usual model as it is, its signs get the widths that suit the data.
    let usual = text::to_ron(&scenario.effects)? == text::to_ron(&classic())?;
    study.steps = vec![first(if usual { Root::Classic } else { Root::Effects(scenario.effects) })];
    Ok(())
}

/// The constraints of a scenario and its presets as one list, its files told from the study's folder.
fn list(scenario: &Scenario, from: &Path, to: &Path) -> Result<String> {
    let mut parts: Vec<String> = Vec::new();
    let mut take = |all: &[Box<dyn crate::constraints::Constraint>], from: &Path| -> Result<()> {
        for constraint in all {
            parts.push(written::relocated(text::to_ron(constraint)?.trim_end(), from, to));
        }
        Ok(())
    };
    for preset in &scenario.presets {
        let path = from.join(preset);
        take(&crate::constraints::open(&path)?, path.parent().unwrap_or(from))?;
    }
    take(&scenario.constraints, from)?;
    if parts.is_empty() {
        return Ok(constraints::USUAL.to_string());
    }
    let entries: String = parts.iter().map(|p| format!("    {},\n", p.replace('\n', "\n    "))).collect();
    Ok(format!("// What the link parameters must satisfy.\n[\n{entries}]\n"))
}

fn map_text(path: &Path) -> Result<String> {
    let map = ColumnMap::open(path)?;
    if path.is_file() { text::read(path) } else { text::to_ron(&map) }
}

/// What a fit or a search is given, apart from its model.
pub(super) struct Inputs {
    pub robot: Arc<Robot>,
    pub fit: Vec<LogFile>,
    pub validate: Vec<LogFile>,
    pub map: Option<ColumnMap>,
    pub signals: Signals,
    pub hold_out: HoldOut,
    pub extra: Vec<Box<dyn Effect>>,
    pub seed: u64,
}

impl Inputs {
    /// Of the study as it is now.
    ///
    /// # Errors
    /// When there is nothing to fit yet.
    pub fn of(study: &Study) -> Result<Self> {
        let robot = study.robot().cloned().ok_or_else(|| {
            Error::new("there is no robot to work with")
                .help("give one: URDF, or a Denavit-Hartenberg table in RON")
        })?;
        let files = |role: Role| study.usable(role).cloned().collect::<Vec<_>>();
        let (fit, validate) = (files(Role::Fit), files(Role::Validate));
        if fit.is_empty() {
            return Err(Error::new("there is no log to fit").help("give one that can be used"));
        }
        Ok(Self {
            robot,
            fit,
            validate,
            map: study.columns.as_deref().map(ColumnMap::parse).transpose()?,
            signals: study.signals.clone(),
            hold_out: study.hold_out,
            extra: written::candidates(study)?,
            seed: study.seed,
        })
    }

    fn read(&self, files: &[LogFile]) -> Result<Vec<Log>> {
        let one = |file: &LogFile| {
            let log = match &file.log {
                Some(log) => log.as_ref().clone(),
                None => {
                    thinned(Log::open(&file.path, &self.robot, self.map.as_ref())?, &self.signals.settings)?
                }
            };
            Ok(Log { name: file.name.clone(), ..log })
        };
        files.iter().map(one).collect()
    }

    /// Reads the logs and does something with what a diagnosis is given.
    ///
    /// # Errors
    /// When a log cannot be read, or that of what is done.
    pub fn request<T>(&self, start: Start, act: impl FnOnce(Request<'_>) -> Result<T>) -> Result<T> {
        let folds = |runs: &[Run]| self.hold_out.folds(runs);
        act(Request {
            robot: &self.robot,
            logs: self.read(&self.fit)?,
            reference: Vec::new(),
            validate: self.read(&self.validate)?,
            start,
            settings: self.signals.settings.clone(),
            choose_signals: !self.signals.chosen,
            folds: &folds,
            add: Vec::new(),
            auto: false,
            nested: None,
            extra: self.extra.clone(),
            limits: Limits::default(),
            seed: self.seed,
        })
    }

    /// Widths of the smoothed signs, where they were chosen.
    pub fn widths(&self) -> Option<&[f64]> {
        Some(self.signals.widths.as_slice()).filter(|w| w.len() == self.robot.dof())
    }
}

/// Reads the robot of a study.
pub(super) fn open_robot(file: &RobotFile, gravity: Option<[f64; 3]>) -> RobotFile {
    let under = |robot: Robot| match gravity {
        Some(g) => robot.with_gravity(Vector3::from(g)),
        None => robot,
    };
    match Robot::open(&file.path) {
        Ok(robot) => RobotFile { robot: Some(Arc::new(under(robot))), problem: None, ..file.clone() },
        Err(error) => RobotFile { robot: None, problem: Some(error), ..file.clone() },
    }
}

/// Whether effects are the classical model's, whatever widths their signs have.
pub(super) fn is_classic(effects: &[Box<dyn Effect>]) -> bool {
    let names = |all: &[Box<dyn Effect>]| -> std::collections::BTreeSet<&str> {
        all.iter().map(|e| e.about().name).collect()
    };
    names(effects) == names(&classic())
}
