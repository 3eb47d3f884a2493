use std::path::{Path, PathBuf};

use lacuna::diagnose::{Limits, Outcome, Request, Start, diagnose};
use lacuna::effects::{Effect, Joints, ScriptedEffect};
use lacuna::log::{ColumnMap, Log};
use lacuna::model_file::ModelFile;
use lacuna::robot::Robot;
use lacuna::scenario::{HoldOut, Logs, Scenario};
use lacuna::signals::{Mode, Run, Settings};
use lacuna::{Error, Result, report, text};

use super::console::Console;
use super::{Global, json, open_robot, print, print_json};

/// Flags of `lacuna diagnose`.
#[derive(Debug, clap::Args)]
pub(super) struct Diagnose {
    /// Scenario file (RON); or give --robot and --data.
    scenario: Option<PathBuf>,
    /// Robot file: URDF, or a Denavit-Hartenberg table in RON.
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Log to explain (CSV); repeat the flag for several.
    #[arg(long, value_name = "CSV")]
    data: Vec<PathBuf>,
    /// A log that is never fitted (CSV).
    #[arg(long, value_name = "CSV")]
    validate: Vec<PathBuf>,
    /// A log of the same robot before something changed (CSV): candidates exist in --data only, so that the answer is
    /// what changed (a payload with mass and centre of mass, friction, a sensor).
    #[arg(long, value_name = "CSV")]
    reference: Vec<PathBuf>,
    /// Model to start from: rigid, classic, given (the robot file's own inertias), or a model file.
    #[arg(long, value_name = "MODEL")]
    model: Option<String>,
    /// Add an effect first, on one joint or on all: a name of the catalogue or an effect script (.rhai); repeat
    /// the flag for several.
    #[arg(long, value_name = "EFFECT[:JOINT]")]
    add: Vec<String>,
    /// An effect script that takes part in the search beside the catalogue; repeat the flag for several.
    #[arg(long = "try", value_name = "FILE.rhai[:JOINT]")]
    tried: Vec<String>,
    /// Add what is found until nothing significant is left.
    #[arg(long)]
    auto: bool,
    /// Repeat the search on the data before this time [s], and score it on the rest.
    #[arg(long, value_name = "SECONDS")]
    nested: Option<f64>,
    /// Column map for a log with foreign headers: a file, or the name of a shipped one.
    #[arg(long, value_name = "MAP")]
    columns: Option<PathBuf>,
    /// Gravity in the base frame [m/s²], instead of the robot file's.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    gravity: Option<String>,
    /// Band in which model and measurement are compared [Hz].
    #[arg(long, value_name = "HZ")]
    band: Option<f64>,
}

/// What a scenario or the flags name.
struct Inputs {
    robot: Robot,
    robot_path: PathBuf,
    logs: Vec<Log>,
    validate: Vec<Log>,
    reference: Vec<Log>,
    start: Start,
    settings: Settings,
    choose: bool,
    hold_out: HoldOut,
    seed: u64,
    /// Candidates beside the catalogue.
    extra: Vec<Box<dyn Effect>>,
}

impl Diagnose {
    pub(super) fn run(&self, global: &Global, console: &Console) -> Result<bool> {
        let inputs = match (&self.scenario, &self.robot) {
            (Some(_), Some(_)) => {
                return Err(Error::new("both a scenario and --robot are given")
                    .help("give the scenario, or --robot and --data"));
            }
            (Some(file), None) => self.in_scenario(file)?,
            (None, Some(robot)) => self.in_flags(robot)?,
            (None, None) => {
                return Err(Error::new("nothing to diagnose")
                    .help("lacuna diagnose FILE.ron, or lacuna diagnose --robot R --data A.csv"));
            }
        };
        let folds = |runs: &[Run]| inputs.hold_out.folds(runs);
        let mut extra = inputs.extra;
        let add = self.wishes(&inputs.robot, &mut extra)?;
        let request = Request {
            robot: &inputs.robot,
            logs: inputs.logs,
            reference: inputs.reference,
            validate: inputs.validate,
            start: inputs.start,
            settings: inputs.settings,
            choose_signals: inputs.choose,
            folds: &folds,
            add,
            auto: self.auto,
            nested: self.nested,
            extra,
            limits: Limits::default(),
            seed: global.seed.unwrap_or(inputs.seed),
        };
        let mut outcome = diagnose(request, &mut |what| console.say(what))?;
        console.clear();
        let written = self.write(&mut outcome, global)?;
        if global.json {
            print_json(&outcome.diagnosis)?;
        } else {
            print(&report::diagnosis_text(&outcome.diagnosis))?;
            print(&self.next(&outcome, &inputs.robot_path, written.as_deref()))?;
        }
        Ok(outcome.diagnosis.verdict != lacuna::diagnose::Verdict::Undecided)
    }

    fn in_scenario(&self, file: &Path) -> Result<Inputs> {
        let mut scenario = Scenario::open(file)?;
        let folder = file.parent().unwrap_or(Path::new(".")).to_path_buf();
        for effect in scenario.effects.iter_mut().chain(&mut scenario.candidates) {
            effect.load(&folder).map_err(|e| text::placed(e, file))?;
        }
        let robot_path = plain(&folder.join(&scenario.robot));
        let mut robot = open_robot(&robot_path, self.gravity.as_deref())?;
        if let (Some(gravity), None) = (scenario.gravity, &self.gravity) {
            robot = robot.with_gravity(nalgebra::Vector3::from(gravity));
        }
        let Some(Logs::Files { fit, validate, columns, missing }) = &scenario.logs else {
            return Err(Error::new("the scenario names no log files to diagnose")
                .in_file(file)
                .help("give it `logs: Files(fit: [..])`"));
        };
        let columns = match (&self.columns, columns) {
            (Some(map), _) => Some(ColumnMap::open(map)?),
            (None, Some(map)) => Some(ColumnMap::open(folder.join(map))?),
            (None, None) => None,
        };
        let named = |files: &[PathBuf]| -> Result<Vec<PathBuf>> {
            files.iter().map(|f| find(&folder, f, missing.as_deref())).collect()
        };
        let pick = |given: &[PathBuf], files: &[PathBuf]| -> Result<Vec<Log>> {
            let files = if given.is_empty() { named(files)? } else { given.to_vec() };
            files.iter().map(|f| Log::open(f, &robot, columns.as_ref())).collect()
        };
        let (logs, validate) = (pick(&self.data, fit)?, pick(&self.validate, validate)?);
        let reference = pick(&self.reference, &[])?;
        let start = match &self.model {
            Some(model) => start(model)?,
            None => Start::Effects(scenario.effects.clone()),
        };
        let chosen = scenario.signals.mode == Mode::Parallel;
        Ok(Inputs {
            logs,
            validate,
            reference,
            start,
            settings: self.settings(scenario.signals.clone()),
            choose: !chosen,
            hold_out: scenario.hold_out,
            seed: scenario.seed,
            extra: scenario.candidates,
            robot,
            robot_path,
        })
    }

    fn in_flags(&self, path: &Path) -> Result<Inputs> {
        let robot = open_robot(path, self.gravity.as_deref())?;
        if self.data.is_empty() {
            return Err(Error::new("no log to explain").help("give --data A.csv"));
        }
        let columns = self.columns.as_ref().map(ColumnMap::open).transpose()?;
        let open = |files: &[PathBuf]| -> Result<Vec<Log>> {
            files.iter().map(|f| Log::open(f, &robot, columns.as_ref())).collect()
        };
        let (logs, validate, reference) = (open(&self.data)?, open(&self.validate)?, open(&self.reference)?);
        let usual = Settings { mode: Mode::Parallel, band_hz: 8.0, trim_s: 1.0, ..Settings::default() };
        Ok(Inputs {
            logs,
            validate,
            reference,
            start: start(self.model.as_deref().unwrap_or("classic"))?,
            settings: self.settings(usual),
            choose: true,
            hold_out: HoldOut::Auto,
            seed: 1,
            extra: Vec::new(),
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

    /// The effects to add by name; scripts become candidates, those to try as well.
    fn wishes(
        &self,
        robot: &Robot,
        extra: &mut Vec<Box<dyn Effect>>,
    ) -> Result<Vec<(String, Option<String>)>> {
        let mut add = Vec::new();
        for (text, wanted) in self.add.iter().map(|a| (a, true)).chain(self.tried.iter().map(|t| (t, false)))
        {
            let (name, joint) = wish(text);
            if !name.ends_with(".rhai") {
                if !wanted {
                    return Err(Error::new(format!("--try {text}: not an effect script"))
                        .help("the catalogue takes part anyway; give a file that ends in .rhai"));
                }
                add.push((name, joint));
                continue;
            }
            let listed = extra.iter().any(|other| other.about().name == name);
            if listed && wanted && !Path::new(&name).exists() {
                add.push((name, joint));
                continue;
            }
            let joints = joint.as_ref().map_or(Joints::All, |j| Joints::Only(vec![j.clone()]));
            let effect = ScriptedEffect::open(Path::new(&name), joints)?;
            effect.try_on(robot)?;
            let name = effect.about().name;
            extra.retain(|other| other.about().name != name);
            extra.push(effect.boxed());
            if wanted {
                add.push((name.to_string(), joint));
            }
        }
        Ok(add)
    }

    /// The effect as `--add` takes it: a script that was tried by its path.
    fn where_it_is(&self, effect: &str) -> String {
        let named = |path: &String| Path::new(path).file_name().is_some_and(|file| file == effect);
        self.tried.iter().map(|t| wish(t).0).find(named).unwrap_or_else(|| effect.to_string())
    }

    /// Name of the scenario, or of the first log.
    fn title(&self) -> String {
        let file = self.scenario.as_deref().or(self.data.first().map(PathBuf::as_path));
        file.and_then(Path::file_stem).map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    }

    /// Writes `diagnosis.json`, `model.ron`, `report.html` and proposed scripts where a folder was asked for.
    fn write(&self, outcome: &mut Outcome, global: &Global) -> Result<Option<PathBuf>> {
        let Some(out) = &global.out else { return Ok(None) };
        for (unknown, script) in outcome.diagnosis.unexplained.iter_mut().zip(&outcome.scripts) {
            if let Some(script) = script {
                text::write_whole(&out.join(&script.file), script.text.as_bytes())?;
                unknown.script = Some(script.file.clone());
            }
        }
        text::write_whole(&out.join("diagnosis.json"), (json(&outcome.diagnosis)? + "\n").as_bytes())?;
        outcome.model.write(&out.join("model.ron"))?;
        let page = report::page::Page {
            title: &self.title(),
            diagnosis: Some(&outcome.diagnosis),
            report: None,
            pictures: Some(&outcome.pictures),
        };
        text::write_whole(&out.join("report.html"), page.html()?.as_bytes())?;
        Ok(Some(out.clone()))
    }

    fn next(&self, outcome: &Outcome, robot: &Path, written: Option<&Path>) -> String {
        let mut text = String::from("\n");
        if let Some(out) = written {
            text += &format!(
                "written  {}, {}\n         {}   open it in a browser\n",
                out.join("diagnosis.json").display(),
                out.join("model.ron").display(),
                out.join("report.html").display()
            );
        }
        if written.is_some() && !self.auto && !outcome.diagnosis.missing.is_empty() {
            text += "         model.ron holds the starting model";
            text += if self.add.is_empty() { "; " } else { " and what --add named; " };
            text += "--auto adds what was found\n";
        }
        let what = match &self.scenario {
            Some(file) => file.display().to_string(),
            None => format!("--robot {} --data LOG.csv", robot.display()),
        };
        let auto = if self.auto { " --auto" } else { "" };
        let script = outcome.diagnosis.unexplained.iter().find_map(|u| u.script.as_ref()).zip(written);
        let step = match (outcome.diagnosis.missing.first(), script) {
            (None, Some((file, out))) => {
                format!("lacuna diagnose {what} --add {}", out.join(file).display())
            }
            (Some(m), _) if !self.auto && m.effect != "rigid_body" => {
                let joint = m.joints.first().map_or_else(String::new, |j| format!(":{j}"));
                format!("lacuna diagnose {what} --add {}{joint}   (or --auto)", self.where_it_is(&m.effect))
            }
            _ => match written {
                Some(out) => format!(
                    "lacuna compare {} --robot {} --data NEW.csv",
                    out.join("model.ron").display(),
                    robot.display()
                ),
                None => format!("lacuna diagnose {what}{auto} --out DIR   keeps the model"),
            },
        };
        text += &format!("next     {step}\n");
        text
    }
}

/// `EFFECT` or `EFFECT:JOINT`; colons inside the path of a script stay in it.
fn wish(text: &str) -> (String, Option<String>) {
    let split = match text.find(".rhai") {
        Some(end) => text[end..].find(':').map(|colon| end + colon),
        None => text.find(':'),
    };
    match split {
        Some(colon) => (text[..colon].to_string(), Some(text[colon + 1..].to_string())),
        None => (text.to_string(), None),
    }
}

fn start(model: &str) -> Result<Start> {
    Ok(match model {
        "rigid" => Start::Rigid,
        "classic" => Start::Classic,
        "given" => Start::Given,
        path => Start::Effects(ModelFile::open(Path::new(path))?.effects),
    })
}

fn find(folder: &Path, file: &Path, missing: Option<&str>) -> Result<PathBuf> {
    let beside = folder.join(file);
    let in_data = || std::env::var_os("LACUNA_DATA").map(|d| Path::new(&d).join(file));
    [Some(beside), in_data()].into_iter().flatten().find(|p| p.is_file()).ok_or_else(|| {
        let otherwise =
            "put it beside the scenario, into the folder that LACUNA_DATA names, or give --data CSV";
        let help = missing.map_or_else(|| otherwise.to_string(), |m| format!("{m}\n  {otherwise}"));
        Error::new("the log is not there").in_file(file).help(help)
    })
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
