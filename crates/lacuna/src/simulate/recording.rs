//! Recording the logs of an experiment and writing them down.

use std::io::Write;
use std::path::{Path, PathBuf};

use flate2::{Compression, GzBuilder};
use rayon::prelude::*;
use serde::{Deserialize, Serialize};

use super::{Experiment, Recording, motion};
use crate::error::{Error, Result};
use crate::excitation::Ramped;
use crate::log::{Decimals, Log};
use crate::plant::{Plant, PlantEffect, Simulation, Truth};
use crate::robot::Robot;
use crate::text::{self, Output};

/// Folder for what measurements alone do not say.
const TRUTH: &str = "truth";

/// All logs of an experiment, and what was really so.
#[derive(Debug)]
pub struct Outcome {
    /// The experiment as it was run, seeds filled in; its effects stand in `plant`.
    pub experiment: Experiment,
    /// The plant, with the effects that all logs have.
    pub plant: Plant,
    /// The logs in the experiment's order.
    pub logs: Vec<Simulation>,
}

/// What was written, without what is hidden in it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Recorded {
    /// The log's file.
    pub file: PathBuf,
    /// Number of rows.
    pub rows: usize,
    /// From the first to the last row \[s\].
    pub duration_s: f64,
    /// Root mean square of every joint's torque [N m, N].
    pub torque_rms: Vec<f64>,
    /// Root mean square of every joint's tracking error [rad, m].
    pub tracking_rms: Vec<f64>,
}

/// What a truth file holds.
#[derive(Serialize)]
struct TruthFile<'a> {
    lacuna: &'static str,
    seed: u64,
    parameters: &'a [f64],
    effects: &'a [Box<dyn PlantEffect>],
    logs: Vec<TruthOfLog<'a>>,
}

#[derive(Serialize)]
struct TruthOfLog<'a> {
    name: &'a str,
    seed: u64,
    effects: &'a [Box<dyn PlantEffect>],
    /// Root mean square of what all effects but rigid links and rotors take, by joint [N m, N].
    load_rms: Vec<f64>,
}

impl<'a> TruthOfLog<'a> {
    fn new((recording, simulation): (&'a Recording, &Simulation)) -> Self {
        Self {
            name: &recording.name,
            seed: recording.seed.unwrap_or_default(),
            effects: &recording.effects,
            load_rms: simulation.truth.load.iter().map(|load| rms(load)).collect(),
        }
    }
}

/// Reads the experiment file at `path` and builds its plant, which takes the effects that all logs have; seeds
/// are filled in, `seed` replaces the file's.
///
/// # Errors
/// When a file cannot be read, or a setting does not fit the robot.
pub fn open(path: &Path, seed: Option<u64>) -> Result<(Experiment, Plant)> {
    let mut experiment = Experiment::open(path)?;
    experiment.seed = seed.unwrap_or(experiment.seed);
    for (i, log) in experiment.logs.iter_mut().enumerate() {
        log.seed = Some(log.seed.unwrap_or(experiment.seed.wrapping_add(i as u64)));
    }
    let folder = path.parent().unwrap_or(Path::new("."));
    let mut robot = Robot::open(folder.join(&experiment.robot))?;
    if let Some(gravity) = experiment.gravity {
        robot = robot.with_gravity(gravity.into());
    }
    let parameters = parameters(&experiment, &robot).map_err(|e| text::placed(e, path))?;
    let mut plant = Plant::with_parameters(robot, parameters);
    plant.effects = std::mem::take(&mut experiment.effects);
    plant.controller = experiment.controller.clone();
    plant.sensors = experiment.sensors.clone();
    plant.method = experiment.method;
    let all = plant.effects.iter().chain(experiment.logs.iter().flat_map(|log| &log.effects));
    let all: Vec<&dyn PlantEffect> = all.map(AsRef::as_ref).collect();
    plant.check_settings(&all).map_err(|e| text::placed(e, path))?;
    let durations = experiment.logs.iter().map(|log| log.duration_s + 2.0 * log.ramp_s);
    plant.check_extent(durations).map_err(|e| text::placed(e, path))?;
    Ok((experiment, plant))
}

/// Records all logs that the experiment file at `path` describes; `seed` replaces the file's. Logs are simulated
/// in parallel; the result does not depend on the number of threads.
///
/// # Errors
/// When a file cannot be used, or a simulation fails; the message names the log.
pub fn run(path: &Path, seed: Option<u64>) -> Result<Outcome> {
    let (experiment, plant) = open(path, seed)?;
    let simulate = |i: usize| {
        let name = &experiment.logs[i].name;
        record(&plant, &experiment.logs[i])
            .map_err(|e| text::placed(e.within(&format!("log `{name}`")), path))
    };
    let logs = (0..experiment.logs.len()).into_par_iter().map(simulate).collect::<Result<_>>()?;
    Ok(Outcome { experiment, plant, logs })
}

fn parameters(experiment: &Experiment, robot: &Robot) -> Result<Vec<f64>> {
    let Some(links) = &experiment.parameters else { return robot.inertial_parameters() };
    if links.len() == robot.dof() && links.iter().flatten().all(|p| p.is_finite()) {
        return Ok(links.concat());
    }
    Err(Error::new(format!("`parameters` has {} links for a robot of {}", links.len(), robot.dof()))
        .help("give ten finite numbers for every link, or leave `parameters` out"))
}

fn record(plant: &Plant, recording: &Recording) -> Result<Simulation> {
    let seed = recording.seed.unwrap_or_default();
    let motion = motion(&plant.robot, &recording.motion, seed)?;
    let ramped = Ramped::new(motion, recording.duration_s, recording.ramp_s)?;
    let mut simulation = plant.simulate_with(&recording.effects, &ramped, ramped.total_s(), seed)?;
    simulation.log.name = format!("{}.csv.gz", recording.name);
    Ok(simulation)
}

/// Names of the files that the experiment file at `path` will write, told from its output folder.
///
/// # Errors
/// When the file cannot be read.
pub fn files(path: &Path) -> Result<Vec<String>> {
    let experiment = Experiment::open(path)?;
    let mut files = vec![truth_file("plant.ron")];
    for log in &experiment.logs {
        files.push(log_file(&log.name));
        if experiment.exact_motion {
            files.push(truth_file(&log_file(&log.name)));
        }
    }
    Ok(files)
}

fn log_file(name: &str) -> String {
    format!("{name}.csv.gz")
}

fn truth_file(name: &str) -> String {
    format!("{TRUTH}/{name}")
}

impl Outcome {
    /// Takes `folder` (see [`Output::claim`]) and writes as [`Outcome::write_to`] does.
    ///
    /// # Errors
    /// When the folder cannot be had, or a file cannot be written.
    pub fn write(&self, folder: &Path) -> Result<Vec<Recorded>> {
        self.write_to(&Output::claim(folder, "simulate")?)
    }

    /// Writes `<name>.csv.gz` for every log into a folder, and the truth into a folder of its own below.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn write_to(&self, output: &Output) -> Result<Vec<Recorded>> {
        let mut written = Vec::new();
        for (recording, simulation) in self.experiment.logs.iter().zip(&self.logs) {
            let file = log_file(&recording.name);
            output.write(&file, &packed(&simulation.log, self.experiment.decimals)?)?;
            if self.experiment.exact_motion {
                let digits = Decimals { time: 9, position: 15, velocity: 15, torque: 15, channel: 15 };
                output.write(&truth_file(&file), &packed(&exact_log(&simulation.truth), digits)?)?;
            }
            written.push(Recorded {
                file: output.folder().join(file),
                rows: simulation.log.rows(),
                duration_s: simulation.log.t.last().map_or(0.0, |end| end - simulation.log.t[0]),
                torque_rms: simulation.log.tau.iter().map(|tau| rms(tau)).collect(),
                tracking_rms: simulation.tracking_rms.clone(),
            });
        }
        output.write(&truth_file("plant.ron"), text::to_ron(&self.truth())?.as_bytes())?;
        Ok(written)
    }

    fn truth(&self) -> TruthFile<'_> {
        TruthFile {
            lacuna: env!("CARGO_PKG_VERSION"),
            seed: self.experiment.seed,
            parameters: &self.plant.parameters,
            effects: &self.plant.effects,
            logs: self.experiment.logs.iter().zip(&self.logs).map(TruthOfLog::new).collect(),
        }
    }
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len().max(1) as f64).sqrt()
}

/// The motion without noise, as a log.
fn exact_log(truth: &Truth) -> Log {
    Log {
        name: "exact motion".into(),
        t: truth.t.clone(),
        q: truth.q.clone(),
        dq: Some(truth.dq.clone()),
        ddq: Some(truth.ddq.clone()),
        tau: truth.tau.clone(),
        channels: truth.channels.clone(),
        ..Log::default()
    }
}

/// A log as gzip-compressed CSV. Without name and date in its header, so that equal logs make equal files.
fn packed(log: &Log, decimals: Decimals) -> Result<Vec<u8>> {
    let trouble = |e: std::io::Error| Error::new(format!("cannot compress a log: {e}"));
    let mut packer = GzBuilder::new().mtime(0).write(Vec::new(), Compression::best());
    packer.write_all(log.to_csv(decimals).as_bytes()).map_err(trouble)?;
    packer.finish().map_err(trouble)
}
