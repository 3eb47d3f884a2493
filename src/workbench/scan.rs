//! The search for what is missing beside a model, in the background: the whole diagnosis, which takes longer than
//! anybody wants to wait for.

use std::panic::{AssertUnwindSafe, catch_unwind, resume_unwind};
use std::path::PathBuf;
use std::sync::atomic::Ordering;
use std::sync::{Arc, PoisonError};

use super::bench::{Bench, Place};
use super::folder;
use super::inputs::Inputs;
use super::progress::Progress;
use super::study::{Addition, Root, Scan, ScriptFile, ScriptKind, Signals, Study};
use super::work::{Job, broken};
use crate::check;
use crate::diagnose::{Outcome, Proposed, Start, Stop, diagnose};
use crate::effects::RigidBody;
use crate::error::{Error, Result};
use crate::report::page::Page;

/// Why a search ended that the user stopped.
const ENDED: &str = "stopped before the search was done: more may be missing";

/// Unwinds a search that nobody waits for any more.
struct Stopped;

/// Starts a search beside a step, in the place of the one that may be running.
///
/// # Errors
/// When the system gives no thread.
pub(super) fn start(bench: &Arc<Bench>, step: usize) -> Result<()> {
    let number = bench.search.fetch_add(1, Ordering::SeqCst) + 1;
    let bench = Arc::clone(bench);
    let thread = std::thread::Builder::new().name("search".to_string());
    let search = move || Search { bench, number, step }.run();
    thread.spawn(search).map_err(|e| Error::new(format!("cannot start a thread: {e}"))).map(|_| ())
}

struct Search {
    bench: Arc<Bench>,
    number: u64,
    step: usize,
}

impl Search {
    fn is_stale(&self) -> bool {
        self.bench.search.load(Ordering::SeqCst) != self.number
    }

    /// Whether the user asked it to end.
    fn is_ended(&self) -> bool {
        self.bench.ended.load(Ordering::SeqCst) >= self.number
    }

    fn run(self) {
        let bench = Arc::clone(&self.bench);
        let _turn = bench.turn.lock().unwrap_or_else(PoisonError::into_inner);
        if self.is_stale() {
            return;
        }
        let text = "looking for what is missing";
        bench.progress(Place::Background, |p| *p = Some(Progress::new("scan", text, true)));
        let done = catch_unwind(AssertUnwindSafe(|| self.check_logs().and_then(|()| self.search())));
        let trouble = match done {
            Ok(Ok(())) => None,
            Ok(Err(error)) => Some(error),
            Err(cause) if cause.is::<Stopped>() => None,
            Err(cause) => Some(broken(cause.as_ref())),
        };
        bench.progress(Place::Background, |p| *p = None);
        if let Some(trouble) = trouble.filter(|_| !self.is_stale()) {
            bench.study().trouble = Some(trouble);
        }
        bench.changed();
    }

    fn say(&self, what: &str) {
        if self.is_stale() {
            resume_unwind(Box::new(Stopped));
        }
        self.bench.progress(Place::Background, |p| {
            if let Some(p) = p {
                p.say(what);
            }
        });
    }

    /// Tests units, signs and order of every log against the robot, once.
    fn check_logs(&self) -> Result<()> {
        let (logs, robot, gravity) = {
            let study = self.bench.study();
            let open = study.logs.iter().filter(|l| l.findings.is_none());
            let logs: Vec<_> = open.filter_map(|l| Some((l.id, l.name.clone(), l.log.clone()?))).collect();
            (logs, study.robot.as_ref().map(|r| r.path.clone()), study.gravity)
        };
        for (id, name, log) in logs {
            self.say(&format!("checking units, signs and order of {name}"));
            let against = |robot: &PathBuf| check::log_against_file(robot, gravity, &log);
            // A log that is too short or too slow for that has no findings.
            let findings = robot.as_ref().map(against).and_then(Result::ok).map(Arc::new);
            let mut study = self.bench.study();
            // Whoever gives other data ends this search while the study is theirs.
            if let Some(log) = study.logs.iter_mut().find(|l| l.id == id).filter(|_| !self.is_stale()) {
                log.findings = findings;
            }
            drop(study);
            self.bench.changed();
        }
        Ok(())
    }

    fn search(&self) -> Result<()> {
        let (inputs, start, is_root) = {
            let study = self.bench.study();
            let Some(step) = study.step(self.step) else { return Ok(()) };
            let start = match &step.root {
                Some(Root::Effects(_)) | None => Start::Effects(step.effects.clone()),
                Some(root) => root.start(),
            };
            (Inputs::of(&study)?, start, step.root.is_some())
        };
        let new_signals = !inputs.signals.chosen || inputs.signals.widths.is_empty();
        let mut outcome = inputs.request(start, |mut request| {
            request.auto = self.bench.auto.load(Ordering::SeqCst);
            let (bench, number) = (Arc::clone(&self.bench), self.number);
            request.limits.stop = Stop::when(move || {
                bench.ended.load(Ordering::SeqCst) >= number || bench.search.load(Ordering::SeqCst) != number
            });
            // The pages show errors on the logs that are never fitted step by step.
            request.validate.clear();
            diagnose(request, &mut |what| self.say(what))
        })?;
        if self.is_ended() {
            outcome.diagnosis.stop_reason = ENDED.to_string();
        }
        self.publish(outcome, new_signals, is_root)
    }

    fn publish(&self, outcome: Outcome, new_signals: bool, is_root: bool) -> Result<()> {
        let found: Vec<Addition> = self.additions(&outcome);
        let chosen = Signals {
            settings: outcome.model.signals.clone(),
            widths: outcome.diagnosis.signals.sign_width.clone(),
            chosen: true,
        };
        let mut study = self.bench.study();
        if self.is_stale() {
            return Ok(());
        }
        let scan = keep(&mut study, outcome)?;
        if new_signals {
            study.signals = chosen;
            // Whatever was found under other signals is found again.
            for step in &mut study.steps {
                (step.ranking, step.scan) = (None, None);
            }
        }
        if let Some(step) = study.step_mut(self.step).filter(|_| !new_signals || is_root) {
            step.ranking = Some(Arc::new(scan.ranking.clone()));
            step.scan = Some(Arc::new(scan));
        }
        let saved = folder::save(&study);
        drop(study);
        self.bench.changed();
        if new_signals {
            self.bench.ask(Job::Refit);
        }
        let (count, auto) = (found.len(), self.bench.auto.swap(false, Ordering::SeqCst));
        for (k, addition) in found.into_iter().enumerate().filter(|_| auto) {
            self.bench.ask(Job::Add(addition, k + 1 == count));
        }
        saved
    }

    /// What was found, as steps to take.
    fn additions(&self, outcome: &Outcome) -> Vec<Addition> {
        let d = &outcome.diagnosis;
        let named = d.missing.iter().chain(&d.minor).filter(|m| m.effect != RigidBody::ABOUT.name);
        named.map(|m| Addition { effect: m.effect.clone(), joints: m.joints.clone() }).collect()
    }
}

/// A name for a proposed script that no other script has which somebody took or wrote.
fn free_name(study: &Study, script: &Proposed) -> String {
    let taken =
        |file: &str| study.scripts.iter().any(|s| s.file == file && !(s.proposed || s.text == script.text));
    // What was worked on outside of the page is somebody's as well.
    let known = |file: &str, text: &str| study.scripts.iter().any(|s| s.file == file && s.text == text);
    let as_written = |file: &str| study.output.read(file).is_ok_and(|t| t == script.text || known(file, &t));
    let worked_on = |file: &str| study.output.is_taken(file) && !as_written(file);
    let taken = |file: &str| taken(file) || study.output.check(&[file]).is_err() || worked_on(file);
    let stem = script.file.trim_end_matches(".rhai");
    let numbered = (2..).map(|k| format!("{stem}_{k}.rhai"));
    std::iter::once(script.file.clone()).chain(numbered).find(|f| !taken(f)).unwrap_or_default()
}

/// The answer as the study keeps it; proposed scripts become files of the study.
fn keep(study: &mut Study, mut outcome: Outcome) -> Result<Scan> {
    let mut proposed = Vec::new();
    for (unknown, script) in outcome.diagnosis.unexplained.iter_mut().zip(outcome.scripts) {
        let kept = match script {
            Some(script) => {
                let file = free_name(study, &script);
                study.output.write(&file, script.text.as_bytes())?;
                study.scripts.retain(|s| s.file != file);
                let (kind, text) = (ScriptKind::Effect, script.text.clone());
                study.scripts.push(ScriptFile { file: file.clone(), kind, text, proposed: true });
                unknown.script = Some(file.clone());
                Some((file, script))
            }
            None => None,
        };
        proposed.push(kept);
    }
    let page = Page { title: &study.name, diagnosis: Some(&outcome.diagnosis), report: None, pictures: None };
    let verdict = page.verdict();
    let json = serde_json::to_string_pretty(&outcome.diagnosis)
        .map_err(|e| Error::new(format!("cannot write JSON: {e}")))?;
    study.output.write("diagnosis.json", (json + "\n").as_bytes())?;
    Ok(Scan { diagnosis: outcome.diagnosis, proposed, ranking: outcome.pictures.ranking, verdict })
}
