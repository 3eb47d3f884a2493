//! What users ask for, one thing after the other: reading, fitting, adding, retrieving.

use std::any::Any;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::sync::mpsc::Receiver;
use std::sync::{Arc, MutexGuard};

use super::bench::{Bench, Place};
use super::inputs::{Inputs, first, is_classic, open_robot};
use super::progress::Progress;
use super::retrieve::{self, Order};
use super::study::{Addition, Numbers, Root, Step, Study};
use super::{folder, logs, scan, written};
use crate::diagnose::{Fitted, Fitting};
use crate::error::{Error, Result};
use crate::log::ColumnMap;
use crate::stop::Stop;

/// Rows times joints beyond which logs are not kept beside a search.
const LARGE: usize = 1_500_000;

/// Something to do.
#[derive(Debug)]
pub(super) enum Job {
    /// Read robot and logs, fit every step; with shapes searched again where data or column map are others.
    Open { again: bool },
    /// The signal step is another one: fit every step again.
    Refit,
    /// Add an effect to the model on show; look for what is missing beside it if so.
    Add(Addition, bool),
    /// Look for what is missing beside a model.
    Look(usize),
    /// Begin with another model.
    Begin(Root),
    /// Retrieve link parameters for the model on show.
    Retrieve(Order),
}

/// Does what comes until the process ends.
pub(super) fn run(bench: &Arc<Bench>, jobs: &Receiver<(u64, Job)>) {
    let mut worker = Worker { bench: Arc::clone(bench), at: None, data: 0, stop: Stop::default() };
    while let Ok((asked_for, job)) = jobs.recv() {
        worker.data = bench.data();
        let due = asked_for == worker.data || !job.is_of_its_data();
        let done = catch_unwind(AssertUnwindSafe(|| if due { worker.act(job) } else { Ok(()) }));
        let trouble = match done {
            Ok(Ok(())) => None,
            Ok(Err(error)) => Some(error),
            Err(cause) => {
                worker.at = None;
                Some(broken(cause.as_ref()))
            }
        };
        if let (Some(trouble), Some(mut study)) = (trouble, worker.study()) {
            study.trouble = Some(trouble);
        }
        bench.finished();
        bench.progress(Place::Foreground, |p| *p = None);
        bench.changed();
    }
}

/// An error of ours, not of the user's.
pub(super) fn broken(cause: &(dyn Any + Send)) -> Error {
    let text = cause.downcast_ref::<&str>().map(ToString::to_string);
    let text = text.or_else(|| cause.downcast_ref::<String>().cloned()).unwrap_or_default();
    Error::new(format!("something in the program broke down: {text}"))
        .help("the study is as it was before; please report it with the log, if you can share that")
}

struct Worker {
    bench: Arc<Bench>,
    /// The prepared logs with the model of a step.
    at: Option<(usize, Fitting)>,
    /// Number of the data that the job at hand works on.
    data: u64,
    /// Ends the job at hand.
    stop: Stop,
}

impl Job {
    /// Whether it is done again anyway, or makes no sense, where the study has other data by now.
    fn is_of_its_data(&self) -> bool {
        matches!(self, Self::Open { .. } | Self::Refit | Self::Add(..) | Self::Look(_))
    }
}

impl Worker {
    /// The study, unless it has other data by now: then nothing of the job at hand belongs into it.
    fn study(&self) -> Option<MutexGuard<'_, Study>> {
        Some(self.bench.study()).filter(|_| self.bench.data() == self.data)
    }

    fn act(&mut self, job: Job) -> Result<()> {
        let bench = Arc::clone(&self.bench);
        self.stop = Stop::when(move || bench.is_stopped());
        if let Some((_, fitting)) = &mut self.at {
            fitting.work_for(&self.stop);
        }
        match job {
            Job::Open { again } => self.open(again),
            Job::Refit => {
                self.at = None;
                self.fit_all(true)
            }
            Job::Add(addition, search) => self.add(addition, search),
            Job::Look(step) => {
                self.fit_what_was_stopped(step)?;
                self.look(step)
            }
            Job::Begin(root) => self.begin(root),
            Job::Retrieve(order) => {
                self.say("retrieve", "retrieving link parameters", true);
                retrieve::run(&self.bench, &order)
            }
        }
    }

    fn say(&self, kind: &'static str, text: &str, stoppable: bool) {
        self.bench.progress(Place::Foreground, |p| *p = Some(Progress::new(kind, text, stoppable)));
    }

    /// Reads robot and logs, then fits whatever steps there are.
    fn open(&mut self, again: bool) -> Result<()> {
        self.at = None;
        self.say("read", "reading robot and logs", false);
        let (robot, gravity, logs, columns, settings) = {
            let study = self.bench.study();
            let settings = study.signals.settings.clone();
            (study.robot.clone(), study.gravity, study.logs.clone(), study.columns.clone(), settings)
        };
        let robot = robot.map(|file| open_robot(&file, gravity));
        let map = columns.as_deref().map(ColumnMap::parse).transpose()?;
        let known = robot.as_ref().and_then(|r| r.robot.clone());
        let Some(mut study) = self.study() else { return Ok(()) };
        study.robot = robot;
        drop(study);
        for log in logs {
            let (seen, read) = logs::look(&log.path, &log.name, known.as_deref(), map.as_ref(), &settings);
            let Some(mut study) = self.study() else { return Ok(()) };
            if let Some(own) = study.logs.iter_mut().find(|l| l.id == log.id) {
                (own.seen, own.log) = (Some(seen), read.map(Arc::new));
            }
        }
        self.bench.changed();
        if !self.bench.study().is_ready() {
            return Ok(());
        }
        self.fit_all(again)
    }

    /// Fits every step; their shapes are searched `again` where data or signal step are others.
    fn fit_all(&mut self, again: bool) -> Result<()> {
        let ids: Vec<usize> = self.bench.study().steps.iter().map(|s| s.id).collect();
        let mut trouble = None;
        for id in ids {
            self.say("fit", "fitting", true);
            if let Err(error) = self.fit_step(id, again) {
                if self.stop.asked() {
                    return Err(not_fitted(error));
                }
                // What cannot be added in other data is gone, and with it what stood on it.
                self.forget(id);
                trouble.get_or_insert(error);
            }
        }
        let shown = self.bench.study().shown;
        let looked = shown.map_or(Ok(()), |id| self.look(id));
        trouble.map_or(looked, Err)
    }

    /// Fits a step whose fit was stopped, and is wanted after all.
    fn fit_what_was_stopped(&mut self, id: usize) -> Result<()> {
        let is_open = {
            let Some(study) = self.study() else { return Ok(()) };
            study.is_ready() && study.step(id).is_some_and(|s| !s.is_there())
        };
        if is_open {
            self.say("fit", "fitting", true);
            self.fit_step(id, true)?;
        }
        Ok(())
    }

    /// Takes a step that was added out of the study; first steps stay for other data.
    fn forget(&self, id: usize) {
        let Some(mut study) = self.study() else { return };
        let Some(step) = study.step(id).filter(|s| s.root.is_none()) else { return };
        let parent = step.parent;
        study.steps.retain(|s| s.id != id);
        if study.shown == Some(id) {
            study.shown = parent;
        }
        if study.against == Some(id) {
            study.against = None;
        }
    }

    fn step(&self, id: usize) -> Result<Step> {
        self.bench.study().step(id).cloned().ok_or_else(|| Error::new(format!("there is no step {id}")))
    }

    fn fit_step(&mut self, id: usize, again: bool) -> Result<()> {
        let step = self.step(id)?;
        if step.root.is_none() && step.parent.is_none_or(|p| self.bench.study().step(p).is_none()) {
            return Err(Error::new(format!("`{}` was added to a model that is gone", step.label())));
        }
        let fitting = match (&step.root, &step.added, step.parent) {
            (Some(root), _, _) if again || step.effects.is_empty() => self.start(root)?,
            (None, Some(added), Some(parent)) if again || step.effects.is_empty() => {
                let mut fitting = self.at(parent)?;
                match fitting.with_added(&added.effect, &added.joints) {
                    Ok(effects) => fitting.with(effects)?,
                    Err(error) => {
                        self.at = Some((parent, fitting));
                        return Err(error);
                    }
                }
            }
            _ => self.at(id)?,
        };
        self.publish(step, fitting, None)
    }

    /// Prepares the logs and fits a model to begin with.
    fn start(&mut self, root: &Root) -> Result<Fitting> {
        self.at = None;
        let inputs = Inputs::of(&self.bench.study())?;
        inputs.request(root.start(), |mut request| {
            request.limits.stop.clone_from(&self.stop);
            Fitting::start(request, inputs.widths())
        })
    }

    /// The prepared logs with the model of a step.
    fn at(&mut self, id: usize) -> Result<Fitting> {
        let effects = self.step(id)?.effects;
        match self.at.take() {
            Some((there, fitting)) if there == id => Ok(fitting),
            Some((_, fitting)) => fitting.with(effects),
            None => self.start(&Root::Effects(effects)),
        }
    }

    /// Makes a fit known and keeps it in the folder; `beside` is for one that goes on show, beside another or alone.
    fn publish(&mut self, step: Step, fitting: Fitting, beside: Option<Option<usize>>) -> Result<()> {
        let fitted: Arc<Fitted> = Arc::new(fitting.fitted()?);
        let (id, numbers) = (step.id, Numbers::of(&fitted));
        let effects = fitted.effects.clone();
        self.at = Some((id, fitting));
        let step = Step { fitted: Some(fitted), numbers, effects, ..step };
        let Some(mut study) = self.study() else { return Ok(()) };
        match study.step_mut(id) {
            Some(own) => *own = step,
            None => study.steps.push(step),
        }
        study.shown.get_or_insert(id);
        if let Some(against) = beside {
            (study.shown, study.against) = (Some(id), against);
        }
        let saved = folder::save(&study);
        drop(study);
        self.bench.changed();
        saved
    }

    fn add(&mut self, added: Addition, search: bool) -> Result<()> {
        let shown = self.bench.study().on_show().map(|s| s.id);
        let parent = shown.ok_or_else(|| {
            Error::new("there is no model to add an effect to").help("give a robot and a log first")
        })?;
        self.say("add", &format!("adding {}", added.effect.replace('_', " ")), true);
        let mut fitting = self.at(parent)?;
        let candidates = {
            let mut study = self.bench.study();
            study.scripts.iter_mut().filter(|s| s.file == added.effect).for_each(|s| s.proposed = false);
            written::candidates(&study)?
        };
        fitting.consider(candidates);
        let effects = match fitting.with_added(&added.effect, &added.joints) {
            Ok(effects) => effects,
            Err(error) => {
                self.at = Some((parent, fitting));
                return Err(error);
            }
        };
        let fitting = fitting.with(effects)?;
        let id = self.bench.study().next_id();
        let step = Step { id, parent: Some(parent), root: None, added: Some(added), ..first(Root::Classic) };
        self.publish(step, fitting, Some(Some(parent)))?;
        if search { self.look(id) } else { Ok(()) }
    }

    /// Scores the catalogue beside a model, unless more urgent things wait, then searches in the background.
    fn look(&mut self, id: usize) -> Result<()> {
        let Some(step) = self.study().and_then(|s| s.step(id).cloned()).filter(Step::is_there) else {
            return Ok(());
        };
        if step.ranking.is_none() && !self.bench.is_awaited() {
            self.say("scan", "scoring every candidate once", true);
            let mut fitting = self.at(id)?;
            let extra = written::candidates(&self.bench.study())?;
            fitting.consider(extra);
            let ranking = fitting.ranking();
            self.at = Some((id, fitting));
            let ranking = Some(Arc::new(ranking?));
            let Some(mut study) = self.study() else { return Ok(()) };
            if let Some(step) = study.step_mut(id) {
                step.ranking = ranking;
            }
            drop(study);
            self.bench.changed();
        }
        if step.scan.is_none() && !self.bench.is_awaited() {
            if self.is_large() {
                // The search has its own copy of the logs; there is no room for two.
                self.at = None;
            }
            scan::start(&self.bench, id)?;
        }
        Ok(())
    }

    /// Whether the logs are so long that they are read again rather than kept.
    fn is_large(&self) -> bool {
        let study = self.bench.study();
        let rows: usize = study.logs.iter().filter_map(|l| l.seen.as_ref()).map(|s| s.rows).sum();
        rows * study.robot().map_or(0, |r| r.dof()) > LARGE
    }

    fn begin(&mut self, root: Root) -> Result<()> {
        self.say("fit", &format!("fitting the {}", root.label()), true);
        let fitting = self.start(&root)?;
        let id = self.bench.study().next_id();
        self.publish(Step { id, ..first(root) }, fitting, Some(None))?;
        self.look(id)
    }
}

/// The error where models of the study were not fitted because somebody stopped that.
fn not_fitted(error: Error) -> Error {
    Error::new(error.message()).help("models without figures are fitted when they are shown")
}

/// What to call a first step of given effects.
pub(super) fn label(step: &Step) -> String {
    match &step.root {
        Some(Root::Effects(effects)) if is_classic(effects) => "classic model".to_string(),
        _ => step.label(),
    }
}
