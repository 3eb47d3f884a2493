mod inputs;
mod progress;
mod wishes;

use std::path::{Path, PathBuf};

use lacuna::check::{Kind, misplaced};
use lacuna::diagnose::{Limits, Outcome, Request, Verdict, diagnose};
use lacuna::signals::Run;
use lacuna::text::Output;
use lacuna::{Error, Result, report, text};

use super::console::Console;
use super::interrupt::Interrupt;
use super::sources::Sources;
use super::{Global, claim, elsewhere, json, print, print_json};

/// What a diagnosis writes, beside the scripts that it proposes.
const RESULTS: [&str; 3] = ["diagnosis.json", "model.ron", "report.html"];

/// Flags of `lacuna diagnose`.
#[derive(Debug, clap::Args)]
pub(super) struct Diagnose {
    #[command(flatten)]
    from: Sources,
    /// A log of the same robot before something changed (CSV): candidates exist in --data only, so that the answer is
    /// what changed (a payload with mass and centre of mass, friction, a sensor).
    #[arg(long, value_name = "CSV")]
    reference: Vec<PathBuf>,
    /// Model to start from: rigid, classic (rigid body, viscous and Coulomb friction, offset; the usual one without a
    /// scenario), given (the robot file's own inertias), or a model file (its effects, fitted again).
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
    /// Band in which model and measurement are compared [Hz].
    #[arg(long, value_name = "HZ")]
    band: Option<f64>,
}

impl Diagnose {
    pub(super) fn run(&self, global: &Global, console: &Console) -> Result<bool> {
        let output = global.out.as_deref().map(|out| claim(out, "diagnose", &RESULTS)).transpose()?;
        let inputs = self.inputs()?;
        let interrupt = Interrupt::install(global.quiet)?;
        let folds = |runs: &[Run]| inputs.hold_out.folds(runs);
        let request = Request {
            robot: &inputs.robot,
            logs: inputs.logs,
            reference: inputs.reference,
            validate: inputs.validate,
            start: inputs.start,
            settings: inputs.settings,
            choose_signals: inputs.choose,
            folds: &folds,
            add: inputs.add,
            auto: self.auto,
            nested: self.nested,
            extra: inputs.extra,
            limits: Limits { stop: interrupt.search(), ..Limits::default() },
            seed: global.seed.unwrap_or(inputs.seed),
        };
        let mut told = progress::Told::default();
        let mut outcome =
            diagnose(request, &mut |what| told.lines(what).iter().for_each(|line| console.say(line)))
                .map_err(|e| self.placed(e))?;
        told.rest().iter().for_each(|line| console.say(line));
        console.clear();
        if interrupt.was_asked() {
            outcome.diagnosis.stop_reason =
                "interrupted: this is what was found by then, not looked back at; more may be missing"
                    .to_string();
        }
        let written = output.as_ref().map(|output| self.write(&mut outcome, output).map_err(elsewhere));
        let written = written.transpose()?;
        if global.json {
            print_json(&outcome.diagnosis)?;
        } else {
            print(&report::diagnosis_text(&outcome.diagnosis))?;
            print(&self.next(&outcome, &inputs.robot_path, written.as_deref()))?;
        }
        Ok(outcome.diagnosis.verdict != Verdict::Undecided && !interrupt.was_asked())
    }

    fn inputs(&self) -> Result<inputs::Inputs> {
        match (&self.from.scenario, &self.from.robot) {
            (Some(file), Some(_)) => {
                let both = Error::new("both a scenario and --robot are given")
                    .help("give the scenario, or --robot and --data");
                Err(misplaced(both, file, &[Kind::Scenario]))
            }
            (Some(file), None) => self.in_scenario(file),
            (None, Some(robot)) => self.in_flags(robot),
            (None, None) => Err(Error::new("nothing to diagnose")
                .help("lacuna diagnose FILE.ron, or lacuna diagnose --robot R --data A.csv")),
        }
    }

    /// Trouble with data and settings as a whole stands in the scenario, or in the first log.
    fn placed(&self, error: Error) -> Error {
        match (&self.from.scenario, self.from.data.first()) {
            (Some(file), _) => text::placed(error, file),
            (None, Some(log)) if error.place().is_none() => error.in_file(log),
            _ => error,
        }
    }

    /// Name of the scenario, or of the first log.
    fn title(&self) -> String {
        let file = self.from.scenario.as_deref().or(self.from.data.first().map(PathBuf::as_path));
        file.and_then(Path::file_stem).map_or_else(String::new, |s| s.to_string_lossy().into_owned())
    }

    /// Writes `diagnosis.json`, `model.ron`, `report.html` and proposed scripts; answers the folder.
    fn write(&self, outcome: &mut Outcome, output: &Output) -> Result<PathBuf> {
        let mut written: Vec<String> = Vec::new();
        for (unknown, script) in outcome.diagnosis.unexplained.iter_mut().zip(&outcome.scripts) {
            if let Some(script) = script {
                // A file of that name may be the user's, or a proposal that was worked on: then it gets another one.
                let stem = script.file.trim_end_matches(".rhai");
                let numbered = (2..).map(|k| format!("{stem}_{k}.rhai"));
                let names = std::iter::once(script.file.clone()).chain(numbered);
                let untouched = |name: &String| {
                    !output.is_taken(name) || output.read(name).is_ok_and(|t| t == script.text)
                };
                let file = output.first_free(names.filter(untouched), &written);
                output.write(&file, script.text.as_bytes())?;
                unknown.script = Some(file.clone());
                written.push(file);
            }
        }
        output.write("diagnosis.json", (json(&outcome.diagnosis)? + "\n").as_bytes())?;
        output.write("model.ron", text::to_ron(&outcome.model)?.as_bytes())?;
        let page = report::page::Page {
            title: &self.title(),
            diagnosis: Some(&outcome.diagnosis),
            report: None,
            pictures: Some(&outcome.pictures),
        };
        output.write("report.html", page.html()?.as_bytes())?;
        Ok(output.folder().to_path_buf())
    }

    fn next(&self, outcome: &Outcome, robot: &Path, written: Option<&Path>) -> String {
        let mut text = String::from("\n");
        if let Some(out) = written {
            text += &format!(
                "written  {}\n         {}\n         {}   open it in a browser\n",
                out.join("diagnosis.json").display(),
                out.join("model.ron").display(),
                out.join("report.html").display()
            );
        }
        if written.is_some() && !self.auto && !outcome.diagnosis.missing.is_empty() {
            let and = if self.add.is_empty() { "; " } else { " and what --add named; " };
            let line = format!("model.ron holds the starting model{and}--auto adds what was found");
            text += &report::hanging("         ", &line, 9);
        }
        let so_far = self.so_far(robot);
        let script = outcome.diagnosis.unexplained.iter().find_map(|u| u.script.as_ref()).zip(written);
        let found = outcome.diagnosis.missing.iter().find(|m| wishes::can_be_added(&m.effect));
        let step = match (found, script) {
            (None, Some((file, out))) => format!("{so_far} --add {}", out.join(file).display()),
            (Some(m), _) if !self.auto => {
                let joint = m.joints.first().map_or_else(String::new, |j| format!(":{j}"));
                format!("{so_far} --add {}{joint}", self.where_it_is(&m.effect))
            }
            _ => match written {
                Some(out) => format!(
                    "lacuna compare {} --robot {} --data NEW.csv",
                    out.join("model.ron").display(),
                    robot.display()
                ),
                None => format!("{so_far} --out DIR"),
            },
        };
        text += &report::command("next     ", &step, 13);
        text += match (found.is_some() && !self.auto, step.ends_with("--out DIR")) {
            (true, _) => "         adds it; --auto adds all that is found\n",
            (_, true) => "         keeps the model\n",
            _ => "",
        };
        text
    }

    /// The command, with what was added up to now.
    fn so_far(&self, robot: &Path) -> String {
        let mut command = String::from("lacuna diagnose");
        match &self.from.scenario {
            Some(file) => command += &format!(" {}", file.display()),
            None => command += &format!(" --robot {}", robot.display()),
        }
        let files = [
            ("--data", &self.from.data),
            ("--validate", &self.from.validate),
            ("--reference", &self.reference),
        ];
        for (flag, file) in files.iter().flat_map(|(flag, all)| all.iter().map(move |file| (flag, file))) {
            command += &format!(" {flag} {}", file.display());
        }
        if let Some(map) = &self.from.columns {
            command += &format!(" --columns {}", map.display());
        }
        let texts = [("--model", &self.model), ("--gravity", &self.from.gravity)];
        for (flag, text) in texts.iter().filter_map(|(flag, text)| Some((flag, text.as_ref()?))) {
            command += &format!(" {flag} {text}");
        }
        if let Some(band) = self.band {
            command += &format!(" --band {band}");
        }
        self.add.iter().for_each(|add| command += &format!(" --add {add}"));
        command + if self.auto { " --auto" } else { "" }
    }
}
