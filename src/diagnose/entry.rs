//! The line from logs to an answer.

use std::collections::BTreeMap;
use std::time::Instant;

use super::answer::{Diagnosis, Undecided, Verdict};
use super::candidates::{self, Candidate};
use super::data::Data;
use super::floor::Floor;
use super::ladder::Ladder;
use super::parts::Parts;
use super::present::Present;
use super::signals::{Choice, Chosen, plain};
use super::unseen::{fitted, validate};
use super::{Limits, doubts, nested, signals, telling};

use crate::effects::{Effect, RigidBody};
use crate::error::{Error, Result};
use crate::identify::refresh_model_torque;
use crate::log::Log;
use crate::model_file::ModelFile;
use crate::robot::Robot;
use crate::signals::{Folds, Run, Settings, prepare};

/// Rounds of climbing and looking back at most.
const ROUNDS: usize = 3;

/// The model that is compared with the measurement.
#[derive(Debug, Clone)]
pub enum Start {
    /// Rigid body alone.
    Rigid,
    /// Rigid body, viscous and Coulomb friction and torque offset on every joint.
    Classic,
    /// The robot file's own inertias, nothing fitted before the comparison.
    Given,
    /// These effects, fitted again.
    Effects(Vec<Box<dyn Effect>>),
}

/// What is asked.
pub struct Request<'a> {
    /// The robot.
    pub robot: &'a Robot,
    /// Logs to explain.
    pub logs: Vec<Log>,
    /// Logs of the same robot before something changed; candidates do not exist in them.
    pub reference: Vec<Log>,
    /// Logs that are never fitted.
    pub validate: Vec<Log>,
    /// The model to start from.
    pub start: Start,
    /// Signal step; its mode is always parallel.
    pub settings: Settings,
    /// Whether cut-offs and source of velocities are chosen by held-out error, or taken from the settings.
    pub choose_signals: bool,
    /// How data are held out.
    pub folds: &'a dyn Fn(&[Run]) -> Result<Folds>,
    /// Effects to add first: `(name, joint)`; every joint when none is named.
    pub add: Vec<(String, Option<String>)>,
    /// Whether what is found becomes part of the model.
    pub auto: bool,
    /// Repeat the search on the data before this time \[s\] and score it on the rest.
    pub nested: Option<f64>,
    /// Candidates beside the catalogue.
    pub extra: Vec<Box<dyn Effect>>,
    /// When something is believed.
    pub limits: Limits,
    /// Seed of the sign flips.
    pub seed: u64,
}

impl Request<'_> {
    /// Reference logs, then the logs to explain.
    pub(super) fn all_logs(&self) -> Vec<Log> {
        self.reference.iter().chain(&self.logs).cloned().collect()
    }

    /// Chooses the signal step.
    pub(super) fn choose(&self, logs: &[Log], say: &mut dyn FnMut(&str)) -> Result<Chosen> {
        let (settings, free) = (self.settings.clone(), self.choose_signals);
        Choice { robot: self.robot, logs, settings, free, folds: self.folds }.decide(say)
    }

    /// Prepared runs of all logs as rows; candidates exist in those of the logs to explain.
    pub(super) fn data(&self, chosen: &Chosen, runs: Vec<Run>) -> Result<Data> {
        let mut data = Data::new(self.robot, runs, chosen.folds.clone())?;
        data.changed = (0..data.runs.len()).map(|k| k >= self.reference.len()).collect();
        Ok(data)
    }

    /// Effects of the model to start from.
    pub(super) fn effects(&self, chosen: &Chosen) -> Vec<Box<dyn Effect>> {
        match &self.start {
            Start::Rigid => vec![Box::new(RigidBody::default())],
            // The residual of a given model is compared, then everything is fitted again to find out why.
            Start::Given => vec![Box::new(RigidBody::default())],
            Start::Classic => plain(self.robot, &chosen.widths),
            Start::Effects(effects) => effects.clone(),
        }
    }
}

/// What comes out.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The answer.
    pub diagnosis: Diagnosis,
    /// The model, with what was added.
    pub model: ModelFile,
}

/// Compares model and measurement and says what is missing.
///
/// # Errors
/// When logs or settings cannot be used, or an effect to add does not exist.
pub fn diagnose(request: Request<'_>, say: &mut dyn FnMut(&str)) -> Result<Outcome> {
    let clock = Instant::now();
    let mut timing = BTreeMap::new();
    refuse_shared_rows(&request)?;
    let logs = request.all_logs();
    let mut chosen = request.choose(&logs, say)?;
    timing.insert("signals".to_string(), clock.elapsed().as_secs_f64());
    let data = request.data(&chosen, chosen.runs.clone())?;
    let undecided = poor_data(&data);
    let mut ladder = start(data, &request, &chosen, say)?;
    let base = telling::Base::of(&ladder, matches!(request.start, Start::Given))?;
    let added = add_requested(&mut ladder, &request.add)?;
    let step = Instant::now();
    if undecided.iter().all(|(_, blocks)| !blocks) {
        search(&mut ladder, request.seed, say)?;
        if let Some(better) = signals::again(&request, &chosen, &ladder, &logs)? {
            say(&format!("again with positions filtered at {} Hz", better.settings.position_cutoff_hz));
            ladder.move_to(request.data(&better, better.runs.clone())?)?;
            chosen = better;
            search(&mut ladder, request.seed, say)?;
        }
        if doubts::drop_artefacts(&mut ladder, smoother(&request, &chosen, &logs)?)? {
            ladder.look_back(say)?;
        }
    }
    timing.insert("search".to_string(), step.elapsed().as_secs_f64());
    let diagnosis = telling::Telling {
        ladder: &ladder,
        chosen: &chosen,
        base: &base,
        added: &added,
        auto: request.auto,
        undecided: undecided.into_iter().map(|(u, _)| u).collect(),
    };
    let mut diagnosis = diagnosis.tell()?;
    let model = model_file(&ladder, &chosen, &request, &added)?;
    if let Some(until) = request.nested {
        diagnosis.nested = Some(nested::run(&request, &chosen, until, say)?);
    }
    diagnosis.validation = validate(&ladder, &base, &chosen, &request)?;
    timing.insert("total".to_string(), clock.elapsed().as_secs_f64());
    diagnosis.timing = timing;
    Ok(Outcome { diagnosis, model })
}

/// Contacts first; then forward, backward, forward again, until neither changes anything. The threshold is
/// calibrated where the residual holds least structure: at the end; what then fails it is dropped again.
pub(super) fn search(ladder: &mut Ladder, seed: u64, say: &mut dyn FnMut(&str)) -> Result<()> {
    ladder.look_for_contact(say)?;
    for _ in 0..ROUNDS {
        ladder.climb(say)?;
        if !ladder.look_back(say)? {
            break;
        }
    }
    ladder.calibrate(seed, say);
    if ladder.gates.range().1 > ladder.limits.least_z {
        ladder.look_back(say)?;
        ladder.climb(say)?;
        ladder.look_back(say)?;
    }
    Ok(())
}

/// The same data with the position filter at half its cut-off.
fn smoother(request: &Request<'_>, chosen: &Chosen, logs: &[Log]) -> Result<Data> {
    let settings =
        Settings { position_cutoff_hz: 0.5 * chosen.settings.position_cutoff_hz, ..chosen.settings.clone() };
    let runs: Vec<Run> = logs.iter().map(|log| Ok(prepare(log, &settings)?.0)).collect::<Result<_>>()?;
    request.data(chosen, runs)
}

pub(super) fn start(
    mut data: Data,
    request: &Request<'_>,
    chosen: &Chosen,
    say: &mut dyn FnMut(&str),
) -> Result<Ladder> {
    let effects = request.effects(chosen);
    if !effects.iter().any(|e| e.about().name == "rigid_body") {
        return Err(Error::new("the model to start from has no rigid_body effect")
            .help("add {\"rigid_body\": ()} to its effects"));
    }
    if effects.iter().any(|e| e.needs_torque()) {
        let rigid = crate::model::Model::new(request.robot, vec![Box::new(RigidBody::default())])?;
        let zero = vec![0.0; rigid.columns.len()];
        refresh_model_torque(&rigid, &zero, &mut data.runs)?;
    }
    let parts = Parts::new(&data, effects, chosen.widths.clone())?;
    let present = Present::new(&data, parts.columns());
    let response = present.respond(&data, data.tau.clone());
    let in_sample = present.residual_of(&data.tau, &present.fit(&data.tau));
    let floor = Floor::new(&data, &in_sample, chosen.settings.band_hz);
    let candidates = candidates::catalogue(&data, &chosen.widths, &request.extra)?;
    let mut ladder = Ladder {
        data,
        parts,
        limits: request.limits.clone(),
        floor,
        gates: super::gates::Gates::new(request.robot.dof(), &request.limits),
        candidates,
        present,
        response,
        rungs: Vec::new(),
        refused: Vec::new(),
        unknown: Vec::new(),
        events: Vec::new(),
        best_left: 0.0,
    };
    ladder.refit()?;
    say("computing the catalogue");
    ladder.refresh_torque()?;
    candidates::fill(&mut ladder.candidates, &ladder.data, false);
    Ok(ladder)
}

/// Adds effects that the user asked for, without asking whether they help.
fn add_requested(ladder: &mut Ladder, wanted: &[(String, Option<String>)]) -> Result<Vec<telling::Added>> {
    let mut added = Vec::new();
    for (name, joint) in wanted {
        let index = joint.as_ref().map(|j| joint_number(ladder, j)).transpose()?;
        let fitting: Vec<usize> = (0..ladder.candidates.len())
            .filter(|&k| {
                let c: &Candidate = &ladder.candidates[k];
                c.name() == name && (index.is_none() || c.joint == index) && !c.columns.is_empty()
            })
            .collect();
        if fitting.is_empty() {
            return Err(unknown_effect(name, joint.as_deref(), ladder));
        }
        let mut parts = Vec::new();
        for candidate in fitting {
            if ladder.parts.has(&ladder.candidates[candidate]) {
                continue;
            }
            let projection = super::score::Projection::new(
                &ladder.data,
                &ladder.present,
                ladder.candidates[candidate].columns.clone(),
                0.0,
            );
            let best = projection.score(&ladder.data, &ladder.present, &ladder.response);
            let Some(score) = best else { continue };
            parts.extend(ladder.try_add(candidate, score.alternative)?);
        }
        ladder.refit()?;
        added.push(telling::Added::now(ladder, name, &parts));
    }
    Ok(added)
}

fn joint_number(ladder: &Ladder, joint: &str) -> Result<usize> {
    let robot = &ladder.data.robot;
    robot.joint_index(joint).ok_or_else(|| {
        let known: Vec<&str> = robot.joints.iter().map(|j| j.name.as_str()).collect();
        Error::new(format!("--add: no joint `{joint}`")).help(format!("known are {}", known.join(", ")))
    })
}

fn unknown_effect(name: &str, joint: Option<&str>, ladder: &Ladder) -> Error {
    let mut known: Vec<&str> = ladder.candidates.iter().map(Candidate::name).collect();
    known.dedup();
    if known.contains(&name) {
        let where_ = joint.map_or_else(String::new, |j| format!(" on `{j}`"));
        return Error::new(format!("--add: `{name}` cannot be added{where_}: these data cannot show it"))
            .help(format!("lacuna list effects {name} explains it"));
    }
    Error::new(format!("--add: no effect called `{name}`")).help(format!("known are {}", known.join(", ")))
}

/// What makes an answer impossible (`true`) or partial.
fn poor_data(data: &Data) -> Vec<(Undecided, bool)> {
    let mut all = Vec::new();
    let seconds: f64 = data.rows.iter().map(|r| r.count as f64 * r.dt).sum();
    let unknowns = crate::identify::BaseParameters::new(&data.robot).rank() + 3 * data.dof();
    if data.count() * data.dof() < 10 * unknowns || seconds < 8.0 {
        let reason = format!(
            "{seconds:.1} s of motion give {} rows for {unknowns} unknowns: too little to hold anything out",
            data.count() * data.dof()
        );
        let record = "a motion of all joints of at least 20 s, better twice the same one".to_string();
        all.push((Undecided { reason, record }, true));
    }
    for (j, joint) in data.robot.joints.iter().enumerate() {
        let moves = data.runs.iter().any(|run| {
            let (low, high) =
                run.q[j].iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)));
            high - low > 1e-3
        });
        if !moves {
            let reason = format!("{} never moves: nothing that depends on its motion can show", joint.name);
            let record = format!("a motion in which {} moves too", joint.name);
            all.push((Undecided { reason, record }, false));
        }
    }
    all
}

/// A validation log must not be one of the fitted ones, in part or whole.
fn refuse_shared_rows(request: &Request<'_>) -> Result<()> {
    let key =
        |log: &Log, k: usize| -> Vec<u64> { log.q.iter().chain(&log.tau).map(|c| c[k].to_bits()).collect() };
    let mut seen = std::collections::HashSet::new();
    for log in request.logs.iter().chain(&request.reference) {
        seen.extend((0..log.rows()).map(|k| key(log, k)));
    }
    for log in &request.validate {
        let shared = (0..log.rows()).filter(|&k| seen.contains(&key(log, k))).count();
        if shared > log.rows() / 100 {
            return Err(Error::new(format!(
                "{shared} of the {} rows of the validation log stand in the data as well",
                log.rows()
            ))
            .in_file(&log.name)
            .help("validate on a log that is not fitted"));
        }
    }
    Ok(())
}

/// The model people take away: the start, what was added, and with `--auto` what was found.
fn model_file(
    ladder: &Ladder,
    chosen: &Chosen,
    request: &Request<'_>,
    added: &[telling::Added],
) -> Result<ModelFile> {
    let asked: Vec<usize> = added.iter().flat_map(|a| a.parts.clone()).collect();
    let effects = ladder
        .parts
        .numbers()
        .into_iter()
        .filter(|&k| {
            let found = ladder.parts.get(k).found;
            !found || (request.reference.is_empty() && (request.auto || asked.contains(&k)))
        })
        .map(|k| ladder.parts.get(k).effect.clone())
        .collect();
    let names: Vec<&str> = request.logs.iter().map(|log| log.name.as_str()).collect();
    let origin = format!("diagnosis of {}", names.join(", "));
    let (model, fitted) = fitted(&ladder.data, effects)?;
    Ok(ModelFile::new(&model, &fitted.x, &fitted.robust_sd, chosen.settings.clone(), origin))
}

/// Whether a verdict can be given.
pub(super) fn verdict(missing: bool, undecided: &[Undecided]) -> Verdict {
    match (missing, undecided.is_empty()) {
        (true, _) => Verdict::Missing,
        (false, true) => Verdict::Nothing,
        (false, false) => Verdict::Undecided,
    }
}
