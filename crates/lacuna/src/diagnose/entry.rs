//! The line from logs to an answer.

use std::collections::BTreeMap;
use std::time::Instant;

use super::answer::{Diagnosis, Undecided, Verdict};
use super::base::Base;
use super::candidates;
use super::closing::Proposed;
use super::data::Data;
use super::floor::Floor;
use super::ladder::Ladder;
use super::late::Late;
use super::parts::Parts;
use super::present::Present;
use super::search::climb_honestly;
use super::sharpness::{self, sharpen};
use super::signals::{Choice, Chosen, plain};
use super::unseen::{Basis, fitted, validate};
use super::{Limits, asked, nested, pictures, poor, signals, telling};

use crate::effects::{Effect, RigidBody};
use crate::error::{Error, Result};
use crate::identify::refresh_model_torque;
use crate::log::Log;
use crate::model_file::ModelFile;
use crate::report::pictures::Pictures;
use crate::robot::Robot;
use crate::signals::{Folds, Run, Settings};

/// Times that a delay of the torque is mended.
const MENDINGS: usize = 2;

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

    /// The same, taken out of the request but for their names: of long logs there is no room for two copies.
    fn take_logs(&mut self) -> Vec<Log> {
        let take = |log: &mut Log| std::mem::replace(log, Log { name: log.name.clone(), ..Log::default() });
        self.reference.iter_mut().chain(&mut self.logs).map(take).collect()
    }

    /// Chooses the signal step.
    pub(super) fn choose(&self, logs: &[Log], say: &mut dyn FnMut(&str)) -> Result<Chosen> {
        let (settings, free) = (self.settings.clone(), self.choose_signals);
        let logged = logs.iter().chain(&self.validate).all(|log| log.dq.is_some());
        Choice { robot: self.robot, logs, settings, free, folds: self.folds, logged }.decide(say)
    }

    /// Prepared runs of all logs as rows; candidates exist in those of the logs to explain.
    pub(super) fn data(&self, chosen: &Chosen, runs: Vec<Run>) -> Result<Data> {
        let mut data = Data::new(self.robot, runs, chosen.folds.clone())?;
        data.runs.iter_mut().for_each(|run| run.stop.clone_from(&self.limits.stop));
        data.changed = (0..data.runs.len()).map(|k| k >= self.reference.len()).collect();
        Ok(data)
    }

    /// The model to start from, its signs as sharp as the data want them, fitted, without any candidate.
    pub(super) fn bare(&self, data: Data, chosen: &Chosen) -> Result<Ladder> {
        let mut ladder = bare(data, self.effects(chosen)?, chosen, &self.limits)?;
        // How sharp a sign is belongs to the signal step.
        if self.choose_signals && matches!(self.start, Start::Effects(_)) {
            sharpen(&mut ladder.parts, &ladder.data)?;
            ladder.refit()?;
        }
        Ok(ladder)
    }

    /// Effects of the model to start from.
    fn effects(&self, chosen: &Chosen) -> Result<Vec<Box<dyn Effect>>> {
        Ok(match &self.start {
            Start::Rigid => vec![Box::new(RigidBody::default())],
            // The residual of a given model is compared, then everything is fitted again to find out why.
            Start::Given => vec![Box::new(RigidBody::default())],
            Start::Classic => plain(self.robot, &chosen.widths),
            // How sharp a sign is belongs to the signal step.
            Start::Effects(effects) if self.choose_signals => sharpness::by_joint(self.robot, effects)?,
            Start::Effects(effects) => effects.clone(),
        })
    }
}

/// What comes out.
#[derive(Debug, Clone)]
pub struct Outcome {
    /// The answer.
    pub diagnosis: Diagnosis,
    /// The model, with what was added.
    pub model: ModelFile,
    /// Scripts of what is unexplained, in the order of [`Diagnosis::unexplained`].
    pub scripts: Vec<Option<Proposed>>,
    /// What pictures of it are drawn from.
    pub pictures: Pictures,
}

/// Compares model and measurement and says what is missing.
///
/// # Errors
/// When logs or settings cannot be used, or an effect to add does not exist.
pub fn diagnose(mut request: Request<'_>, say: &mut dyn FnMut(&str)) -> Result<Outcome> {
    let clock = Instant::now();
    let mut timing = BTreeMap::new();
    refuse_shared_rows(&request)?;
    let mut logs = request.take_logs();
    poor::silence(&mut logs);
    let mut look = Look::at(&request, &logs, &mut timing, say)?;
    // A delay of the whole robot is mended before anything that it may have imitated is believed.
    let (mut late, mut unmended): (Option<Late>, Option<Look>) = (None, None);
    for _ in 0..MENDINGS {
        if request.limits.stop.asked() {
            break;
        }
        // What was found is told from here on, so this is done to its end.
        look.ladder.data.work_on();
        if !Late::note(&mut late, &look.telling(&request, &look.base))? {
            break;
        }
        let Some(late) = &mut late else { break };
        let again = late.settle(&request, &look.chosen, &logs).and_then(|()| {
            say(&format!("the torque is {}: put in step, looking again", late.words()));
            Look::at(&request, &late.mended(&logs), &mut timing, say)
        });
        let again = match again {
            Err(_) if request.limits.stop.asked() => break,
            again => again?,
        };
        let before = std::mem::replace(&mut look, again);
        unmended.get_or_insert(before);
    }
    look.ladder.data.work_on();
    let first =
        unmended.as_ref().filter(|u| u.ladder.data.count() == look.ladder.data.count()).unwrap_or(&look);
    let telling = look.telling(&request, &first.base);
    let mut pictures = pictures::of(&look.ladder, &first.base, telling.climb());
    let mut diagnosis = telling.tell()?;
    let delayed = late.is_some();
    if let Some(late) = late {
        late.into_answer(&mut diagnosis, &telling, &look.base);
    }
    let model = model_file(first, &look, &request, delayed)?;
    if let Some(until) = request.nested.filter(|_| !request.limits.stop.asked()) {
        diagnosis.nested = match nested::run(&request, &first.chosen, until, say) {
            Err(_) if request.limits.stop.asked() => None,
            done => Some(done?),
        };
    }
    // Who adds effects one by one sees what these do; otherwise what everything that was found would.
    let one_by_one = !request.auto && !request.add.is_empty();
    let found = match one_by_one {
        true => taken(&look, &request, delayed),
        false if delayed => Late::among(look.ladder.parts.shared_effects()),
        false => look.ladder.parts.shared_effects(),
    };
    if let Some((validation, traces)) = validate(&request, &first.basis(), found)? {
        diagnosis.validation = Some(validation);
        pictures.traces.extend(traces);
    }
    timing.insert("total".to_string(), clock.elapsed().as_secs_f64());
    diagnosis.timing = timing;
    let scripts = look.ladder.unexplained().into_iter().map(|(_, script)| script).collect();
    Ok(Outcome { diagnosis, model, pictures, scripts })
}

/// One look at the logs: signals chosen, effects searched.
pub(super) struct Look {
    pub chosen: Chosen,
    pub ladder: Ladder,
    pub base: Base,
    added: Vec<telling::Added>,
    undecided: Vec<Undecided>,
}

impl Look {
    fn at(
        request: &Request<'_>,
        logs: &[Log],
        timing: &mut BTreeMap<String, f64>,
        say: &mut dyn FnMut(&str),
    ) -> Result<Self> {
        let clock = Instant::now();
        let mut chosen = request.choose(logs, say)?;
        *timing.entry("signals".to_string()).or_default() += clock.elapsed().as_secs_f64();
        // Only a nested search wants them again; of long logs there is no room for two copies.
        let keep = request.nested.is_some();
        let runs = if keep { chosen.runs.clone() } else { std::mem::take(&mut chosen.runs) };
        let data = request.data(&chosen, runs)?;
        let undecided = poor::judge(&data);
        let mut ladder = start(data, request, &chosen, say)?;
        let base = Base::of(&ladder, matches!(request.start, Start::Given))?;
        let added = asked::add(&mut ladder, &request.add)?;
        let clock = Instant::now();
        if undecided.iter().all(|(_, blocks)| !blocks) {
            match climb(request, &mut chosen, &mut ladder, logs, say) {
                // What was cut short is made whole again: the parts that were found by then are fitted as they are.
                Err(_) if request.limits.stop.asked() => {
                    ladder.data.work_on();
                    ladder.refit()?;
                }
                done => done?,
            }
        }
        *timing.entry("search".to_string()).or_default() += clock.elapsed().as_secs_f64();
        let undecided = undecided.into_iter().map(|(u, _)| u).collect();
        Ok(Self { chosen, ladder, base, added, undecided })
    }

    fn basis(&self) -> Basis<'_> {
        Basis { ladder: &self.ladder, chosen: &self.chosen, base: &self.base }
    }

    fn telling<'a>(&'a self, request: &Request<'_>, base: &'a Base) -> telling::Telling<'a> {
        telling::Telling {
            ladder: &self.ladder,
            chosen: &self.chosen,
            base,
            added: &self.added,
            auto: request.auto,
            x: self.ladder.present.fit(&self.ladder.data.tau),
            undecided: &self.undecided,
        }
    }
}

/// Searches, and once more where other signals serve the model that was found better.
fn climb(
    request: &Request<'_>,
    chosen: &mut Chosen,
    ladder: &mut Ladder,
    logs: &[Log],
    say: &mut dyn FnMut(&str),
) -> Result<()> {
    climb_honestly(request, chosen, ladder, logs, say)?;
    if !request.limits.stop.asked()
        && let Some(better) = signals::again(request, chosen, ladder, logs)?
    {
        say(&format!("again with positions filtered at {} Hz", better.settings.position_cutoff_hz));
        ladder.move_to(request.data(&better, better.runs.clone())?)?;
        *chosen = better;
        climb_honestly(request, chosen, ladder, logs, say)?;
    }
    Ok(())
}

pub(super) fn start(
    data: Data,
    request: &Request<'_>,
    chosen: &Chosen,
    say: &mut dyn FnMut(&str),
) -> Result<Ladder> {
    let mut ladder = request.bare(data, chosen)?;
    ladder.candidates = candidates::catalogue(&ladder.data, &ladder.parts.widths, &request.extra)?;
    say("computing the catalogue");
    ladder.refresh_torque()?;
    candidates::fill(&mut ladder.candidates, &ladder.data, false)?;
    Ok(ladder)
}

/// The model to start from, fitted, without any candidate.
pub(super) fn bare(
    mut data: Data,
    effects: Vec<Box<dyn Effect>>,
    chosen: &Chosen,
    limits: &Limits,
) -> Result<Ladder> {
    if !effects.iter().any(|e| e.is_rigid_body()) {
        return Err(Error::new("the model to start from has no rigid_body effect")
            .help(format!("add {} to its effects", RigidBody::ABOUT.example)));
    }
    if effects.iter().any(|e| e.needs_torque()) {
        let rigid = crate::model::Model::new(&data.robot, vec![Box::new(RigidBody::default())])?;
        let zero = vec![0.0; rigid.columns.len()];
        refresh_model_torque(&rigid, &zero, &mut data.runs)?;
    }
    let parts = Parts::new(&data, effects, chosen.widths.clone())?;
    let present = Present::new(&data, parts.columns());
    let response = present.respond(&data, data.tau.clone());
    let in_sample = present.residual_of(&data.tau, &present.fit(&data.tau));
    let floor = Floor::new(&data, &in_sample, chosen.settings.band_hz);
    let gates = super::gates::Gates::new(data.dof(), limits);
    let mut ladder = Ladder {
        data,
        parts,
        limits: limits.clone(),
        floor,
        gates,
        candidates: Vec::new(),
        present,
        response,
        rungs: Vec::new(),
        refused: Vec::new(),
        dropped: Vec::new(),
        unknown: Vec::new(),
        events: Vec::new(),
        at_reversals: 0.0,
        best_left: 0.0,
        ranking: Vec::new(),
    };
    ladder.refit()?;
    Ok(ladder)
}

/// A validation log must not be one of the fitted ones, in part or whole.
fn refuse_shared_rows(request: &Request<'_>) -> Result<()> {
    if request.validate.is_empty() {
        return Ok(());
    }
    let fitted = request.logs.iter().chain(&request.reference);
    let seen: std::collections::HashSet<u64> = fitted.flat_map(|log| log.row_keys().to_vec()).collect();
    for log in &request.validate {
        let keys = log.row_keys();
        let shared = keys.iter().filter(|key| seen.contains(key)).count();
        if shared > keys.len() / 100 {
            return Err(Error::new(format!(
                "{shared} of the {} rows of the validation log stand in the data as well",
                keys.len()
            ))
            .in_file(&log.name)
            .help("validate on a log that is not fitted"));
        }
    }
    Ok(())
}

/// The model people take away: the start, what was added, and with `--auto` what was found.
fn model_file(first: &Look, look: &Look, request: &Request<'_>, delayed: bool) -> Result<ModelFile> {
    let names: Vec<&str> = request.logs.iter().map(|log| log.name.as_str()).collect();
    let origin = format!("diagnosis of {}", names.join(", "));
    let effects = taken(look, request, delayed);
    let (model, fitted) = fitted(&first.ladder.data, effects)?;
    Ok(ModelFile::new(&model, &fitted.x, &fitted.robust_sd, first.chosen.settings.clone(), origin))
}

/// The effects that people take away.
fn taken(look: &Look, request: &Request<'_>, delayed: bool) -> Vec<Box<dyn Effect>> {
    let ladder = &look.ladder;
    let asked: Vec<usize> = look.added.iter().flat_map(|a| a.parts.clone()).collect();
    let effects: Vec<Box<dyn Effect>> = ladder
        .parts
        .numbers()
        .into_iter()
        .filter(|&k| {
            let found = ladder.parts.get(k).found;
            !found || (request.reference.is_empty() && (request.auto || asked.contains(&k)))
        })
        .map(|k| ladder.parts.get(k).effect.clone())
        .collect();
    if delayed && request.auto { Late::among(effects) } else { effects }
}

/// Whether a verdict can be given.
pub(super) fn verdict(missing: bool, undecided: &[Undecided]) -> Verdict {
    match (missing, undecided.is_empty()) {
        (true, _) => Verdict::Missing,
        (false, true) => Verdict::Nothing,
        (false, false) => Verdict::Undecided,
    }
}
