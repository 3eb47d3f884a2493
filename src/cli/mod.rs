//! The command line: parses, calls the library, prints. No mathematics.

mod benchmark;
mod check;
mod compare;
mod console;
mod diagnose;
mod dynamics;
mod export;
mod interrupt;
mod list;
mod offered;
mod scenario;
mod screen;
mod simulate;
mod sources;
mod workbench;

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand};
use lacuna::check::{Kind, misplaced};
use lacuna::error::Part;
use lacuna::log::{ColumnMap, Log};
use lacuna::model_file::ModelFile;
use lacuna::robot::Robot;
use lacuna::scenario::Scenario;
use lacuna::text::Output;
use lacuna::{Error, Result};

use console::Console;
use screen::{json, print, print_document, print_json, say};

/// Identify robot arms from their logs, and find the physics the model is missing.
#[derive(Debug, Parser)]
#[command(name = "lacuna", version, propagate_version = true, max_term_width = 80)]
struct Arguments {
    #[command(subcommand)]
    command: Command,
    #[command(flatten)]
    global: Global,
}

/// Flags that every command takes.
#[derive(Debug, clap::Args)]
struct Global {
    /// Print one JSON document on stdout and nothing else there.
    #[arg(long, global = true, help_heading = offered::HEADING)]
    json: bool,
    /// Seed of every random draw, instead of the scenario's.
    #[arg(long, global = true, help_heading = offered::HEADING, value_name = "N")]
    seed: Option<u64>,
    /// Number of threads; results do not depend on it.
    #[arg(long, global = true, help_heading = offered::HEADING, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=1024))]
    jobs: Option<u16>,
    /// Folder for results: new, empty, or one that has some of lacuna already.
    #[arg(long, global = true, help_heading = offered::HEADING, value_name = "DIR")]
    out: Option<PathBuf>,
    /// Folder of an interrupted study, to go on where it was to the same result.
    #[arg(long, global = true, help_heading = offered::HEADING, value_name = "DIR")]
    resume: Option<PathBuf>,
    /// No progress on stderr.
    #[arg(long, global = true, help_heading = offered::HEADING)]
    quiet: bool,
}

#[derive(Debug, Subcommand)]
enum Command {
    /// Run a whole study; writes report.json, report.html and model.ron.
    Scenario {
        /// Scenario file (RON).
        file: PathBuf,
        /// Logs to use instead of the scenario's; repeat the flag for several.
        #[arg(long, value_name = "CSV")]
        data: Vec<PathBuf>,
    },
    /// Compare finished models on one log, side by side; nothing is fitted.
    Compare {
        /// Model files (RON), as studies write them; shown in this order.
        #[arg(required = true)]
        models: Vec<PathBuf>,
        /// Robot file: URDF, or a Denavit-Hartenberg table in RON.
        #[arg(long, value_name = "FILE")]
        robot: PathBuf,
        /// The log (CSV).
        #[arg(long, value_name = "CSV")]
        data: PathBuf,
        /// Column map for a log with foreign headers: a file, or the name of a shipped one.
        #[arg(long, value_name = "MAP")]
        columns: Option<PathBuf>,
        /// Gravity in the base frame [m/s²], instead of the robot file's.
        #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
        gravity: Option<String>,
    },
    /// Examine the diagnosis itself: hide effects in simulated logs and count the answers.
    Benchmark(benchmark::Benchmark),
    /// Check a file of any kind, and a log against a robot.
    Check(check::Check),
    /// Compare model and measurement: where the model fails, and what is missing.
    Diagnose(diagnose::Diagnose),
    /// List what there is: effects, constraints, engines; with a name, explain it.
    List {
        /// `effects`, `constraints` or `engines`.
        what: String,
        /// One of them, to explain.
        name: Option<String>,
    },
    /// Write identified parameters for other tools: URDF, MJCF, JSON.
    Export(export::Export),
    /// Inverse dynamics with the inertias of the robot file or of a model, as CSV on stdout.
    Dynamics(dynamics::Dynamics),
    /// Open a local page to work on a study: see, add, undo, compare, retrieve. Files may also be dropped into it.
    Workbench(workbench::Workbench),
    /// Make measurements of a described plant: hidden effects, controller, sensors, noise.
    Simulate {
        /// Description of plant and logs (RON).
        file: PathBuf,
    },
}

/// Runs the command line; the result is the process's exit code: 0 done, 1 the answer is negative,
/// 2 unusable input.
pub(crate) fn run() -> ExitCode {
    let matches =
        offered::adjust(Arguments::command()).try_get_matches().unwrap_or_else(|e| screen::leave(e));
    let name = matches.subcommand_name().unwrap_or_default().to_string();
    let arguments = Arguments::from_arg_matches(&matches).unwrap_or_else(|e| screen::leave(e));
    offered::note_idle(&name, &arguments.global);
    let console = Console::new(arguments.global.quiet);
    let answer = prepare(&arguments).and_then(|()| dispatch(arguments, &console));
    console.clear();
    match answer {
        Ok(code) => ExitCode::from(code),
        Err(error) => {
            say(&format!("error: {}", in_flags(error)));
            ExitCode::from(2)
        }
    }
}

/// Does what was asked for.
fn dispatch(arguments: Arguments, console: &Console) -> Result<u8> {
    let global = &arguments.global;
    let positive = match arguments.command {
        Command::Scenario { file, data } => scenario::run(&file, data, global, console),
        Command::Compare { models, robot, data, columns, gravity } => {
            compare::run(&models, &robot, &data, columns.as_deref(), gravity.as_deref(), global)
        }
        Command::Benchmark(benchmark) => benchmark.run(global, console),
        Command::Diagnose(diagnose) => diagnose.run(global, console),
        Command::Check(check) => return check.run(global),
        Command::List { what, name } => list::run(&what, name.as_deref(), global),
        Command::Export(export) => export.run(global),
        Command::Dynamics(dynamics) => dynamics.run(global),
        Command::Workbench(workbench) => workbench.run(global),
        Command::Simulate { file } => simulate::run(&file, global, console),
    };
    positive.map(|positive| u8::from(!positive))
}

/// Takes a folder for what the command `by` writes, before any work is done; `names` are what it will write.
fn claim<S: AsRef<str>>(folder: &Path, by: &str, names: &[S]) -> Result<Output> {
    let output = Output::claim(folder, by).map_err(elsewhere)?;
    output.check(names).map_err(elsewhere)?;
    Ok(output)
}

/// The same error, with what can be done where a folder cannot be written to.
fn elsewhere(error: Error) -> Error {
    error.or_help("give another --out DIR, or an empty one")
}

/// Opens a scenario; a file of another kind is answered with what takes it.
fn open_scenario(path: &Path) -> Result<Scenario> {
    Scenario::open(path).map_err(|e| misplaced(e, path, &[Kind::Scenario]))
}

/// Opens a model; a file of another kind is answered with what takes it.
fn open_model(path: &Path) -> Result<ModelFile> {
    ModelFile::open(path).map_err(|e| misplaced(e, path, &[Kind::Model]))
}

/// Opens a log; a file of another kind is answered with what takes it.
fn open_log(path: &Path, robot: &Robot, columns: Option<&ColumnMap>) -> Result<Log> {
    Log::open(path, robot, columns).map_err(|e| misplaced(e, path, &[Kind::Log]))
}

/// An error of the library with the flag that it is about.
fn in_flags(error: Error) -> Error {
    match error.part() {
        Some(Part::Add) => error.about("--add"),
        Some(Part::Nested) => error.about("--nested"),
        Some(Part::Columns) => error.with_hint("`--columns MAP.ron`"),
        None => error,
    }
}

fn prepare(arguments: &Arguments) -> Result<()> {
    let resumable =
        matches!(arguments.command, Command::Scenario { .. } | Command::Benchmark(_) | Command::Workbench(_));
    if arguments.global.resume.is_some() && !resumable {
        let which = "`lacuna scenario`, `lacuna benchmark` and `lacuna workbench`";
        return Err(Error::new(format!("--resume: only {which} can be resumed")).help("leave --resume away"));
    }
    if let Some(jobs) = arguments.global.jobs {
        rayon::ThreadPoolBuilder::new().num_threads(usize::from(jobs)).build_global().map_err(|e| {
            Error::new(format!("cannot start {jobs} threads: {e}")).help("give --jobs fewer, or leave it out")
        })?;
    }
    Ok(())
}

/// Opens a robot, under another gravity when one is given.
fn open_robot(path: &Path, gravity: Option<&str>) -> Result<Robot> {
    let robot = Robot::open(path).map_err(|e| misplaced(e, path, &[Kind::Urdf, Kind::DenavitHartenberg]))?;
    let Some(text) = gravity else { return Ok(robot) };
    let numbers: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    match numbers.as_slice() {
        [x, y, z] if text.split(',').count() == 3 && numbers.iter().all(|g: &f64| g.abs() <= 1e6) => {
            Ok(robot.with_gravity(nalgebra::Vector3::new(*x, *y, *z)))
        }
        _ => Err(Error::new(format!("--gravity \"{text}\" is not three usable numbers"))
            .help("write for example --gravity 0,0,-9.81 [m/s², base frame]")),
    }
}
