use std::path::{Path, PathBuf};

use lacuna::check::{Kind, misplaced};
use lacuna::report::Report;
use lacuna::retrieval::Step;
use lacuna::retrieval::checkpoint::Checkpoint;
use lacuna::scenario::Scenario;
use lacuna::study::{self, Options, Outcome};
use lacuna::text::Output;
use lacuna::{Error, Result, report, text};

use super::console::Console;
use super::interrupt::Interrupt;
use super::{Global, claim, elsewhere, json, open_scenario, print, print_json, say};

/// What a study writes, beside the checkpoints of its engines.
const RESULTS: [&str; 4] = ["report.json", "report.html", "model.ron", "identified.ron"];

/// `lacuna scenario FILE.ron`: `false` when no engine found feasible parameters, or when interrupted.
pub(super) fn run(file: &Path, data: Vec<PathBuf>, global: &Global, console: &Console) -> Result<bool> {
    let scenario = open_scenario(file)?;
    let out = folder(file, global)?;
    let output = claim(&out, "scenario", &RESULTS)?;
    let checkpoint = Checkpoint { folder: out.clone(), resume: global.resume.is_some() };
    output.reserve(&checkpoints(&scenario, &checkpoint)).map_err(elsewhere)?;
    let again = again(file, &data, global, &out);
    let logs = data.clone();
    let interrupt = Interrupt::install(global.quiet)?;
    let watch = |step: &Step| {
        console.step(step);
        interrupt.flow()
    };
    let options = Options {
        data,
        seed: global.seed,
        progress: &mut |what: &str| {
            interrupt.leave();
            console.say(what);
        },
        watch: &watch,
        checkpoint: Some(checkpoint),
        stop: Default::default(),
    };
    let outcome = study::run(file, options)
        .map_err(|e| logs.iter().fold(e, |error, log| misplaced(error, log, &[Kind::Log])))?;
    interrupt.leave();
    console.clear();
    write(&outcome, &output).map_err(elsewhere)?;
    let next = next_steps(file, &out, &outcome, &again);
    if global.json {
        print_json(&outcome.report)?;
        if outcome.stopped && !global.quiet {
            say(next.trim_end());
        }
    } else {
        print(&report::render(&outcome.report))?;
        print(&next)?;
    }
    Ok(!outcome.stopped && feasible(&outcome.report))
}

/// Files that the engines of a scenario keep their finished runs in.
fn checkpoints(scenario: &Scenario, checkpoint: &Checkpoint) -> Vec<String> {
    let files = scenario.engines.iter().map(|engine| checkpoint.file(engine.label()));
    files.filter_map(|file| Some(file.file_name()?.to_string_lossy().into_owned())).collect()
}

/// Report, models, and the report to look at.
fn write(outcome: &Outcome, output: &Output) -> Result<()> {
    output.write("report.json", (json(&outcome.report)? + "\n").as_bytes())?;
    let models = [("model.ron", &outcome.model), ("identified.ron", &outcome.identified)];
    for (name, model) in models.iter().filter_map(|(name, model)| Some((name, model.as_ref()?))) {
        output.write(name, text::to_ron(model)?.as_bytes())?;
    }
    let page = report::page::Page {
        title: &outcome.report.scenario,
        diagnosis: outcome.report.diagnosis.as_ref(),
        report: Some(&outcome.report),
        pictures: outcome.pictures.as_ref(),
    };
    output.write("report.html", page.html()?.as_bytes())
}

/// Whether some engine found feasible parameters, where one was asked to.
fn feasible(report: &Report) -> bool {
    report.retrievals.as_ref().is_none_or(|all| all.iter().any(|r| r.feasible))
}

/// Where results go: a resumed study goes on in its own folder.
fn folder(file: &Path, global: &Global) -> Result<PathBuf> {
    match (&global.out, &global.resume) {
        (Some(out), Some(resume)) if out != resume => {
            Err(Error::new("--out and --resume name different folders")
                .help("a resumed study goes on in its own folder: leave --out away"))
        }
        (_, Some(resume)) if !resume.is_dir() => {
            Err(Error::new("there is nothing to go on with, and no checkpoint, for the folder is not there")
                .in_file(resume)
                .help("name the folder of the interrupted study, or leave --resume away to start anew"))
        }
        (Some(folder), _) | (None, Some(folder)) => Ok(folder.clone()),
        (None, None) => Ok(Path::new("out").join(file.file_stem().unwrap_or_default())),
    }
}

/// The command that goes on after an interruption.
fn again(file: &Path, data: &[PathBuf], global: &Global, out: &Path) -> String {
    let mut command = format!("lacuna scenario {} --resume {}", file.display(), out.display());
    for log in data {
        command += &format!(" --data {}", log.display());
    }
    if let Some(seed) = global.seed {
        command += &format!(" --seed {seed}");
    }
    command
}

fn next_steps(scenario: &Path, out: &Path, outcome: &Outcome, again: &str) -> String {
    let file = |name: &str| out.join(name).display().to_string();
    let mut text = format!("\nwritten  {}\n", file("report.json"));
    if outcome.model.is_some() {
        text += &format!("         {}\n", file("model.ron"));
        text += &report::hanging("             ", &report::whose(&outcome.report), 13);
    }
    if outcome.identified.is_some() {
        text += &format!("         {}\n             identified coefficients\n", file("identified.ron"));
    }
    text += &format!("         {}   open it in a browser\n", file("report.html"));
    if outcome.stopped {
        text += &format!("stopped  to go on where it was:\n{}", report::command("         ", again, 13));
    } else if outcome.model.is_some() {
        let robot = robot_of(scenario);
        let compare =
            format!("lacuna compare {} --robot {} --data LOG.csv", file("model.ron"), robot.display());
        text += &report::command("next     ", &compare, 13);
        text += "         predicts another log; nothing is fitted\n";
    }
    text
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
