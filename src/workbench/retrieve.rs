//! Link parameters for the model on show: the scenario in the folder, run as the command line runs it.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex, PoisonError};
use std::time::{Duration, Instant};

use serde::Deserialize;
use serde_json::{Value, json};

use super::bench::{Bench, Place};
use super::folder;
use super::study::Retrieval;
use crate::diagnose::Diagnosis;
use crate::error::{Error, Result};
use crate::report::finite;
use crate::retrieval::catalogue::EngineAbout;
use crate::retrieval::checkpoint::Checkpoint;
use crate::retrieval::{RetrievalEngine, Step, catalogue};
use crate::stop::Stop;
use crate::study::{self, Outcome};
use crate::text;

/// What a study says before it starts an engine.
const LEAD: &str = "retrieving link parameters with ";
/// Folder of the checkpoints in that of the study.
const CHECKPOINTS: &str = "retrieval";
/// Points of a history at most; it is thinned where it grows longer.
const HISTORY: usize = 500;
/// Pause between two messages to the pages.
const PAUSE: Duration = Duration::from_millis(100);

/// What is asked of a retrieval.
#[derive(Debug, Clone, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Order {
    /// Names of engines.
    pub engines: Vec<String>,
    /// Independent runs of engines that make some.
    #[serde(default)]
    pub runs: Option<u32>,
    /// Stages of each run.
    #[serde(default)]
    pub stages: Option<u32>,
    /// Whether ranges of all parameters are wanted.
    #[serde(default)]
    pub intervals: bool,
}

impl Order {
    /// The engines as a scenario names them.
    ///
    /// # Errors
    /// When an engine is unknown, or its settings cannot be.
    pub fn written(&self) -> Result<Vec<String>> {
        if self.engines.is_empty() {
            return Err(Error::new("no engine is named").help("name `penalty`, `lmi` or both"));
        }
        let one = |name: &String| {
            catalogue::engine(name)?.available()?;
            let mut settings = Vec::new();
            if name.starts_with("penalty") {
                settings.extend(self.runs.map(|runs| format!("runs: {runs}")));
                settings.extend(self.stages.map(|stages| format!("stages: {stages}")));
            }
            let text = format!("{{\"{name}\": ({})}}", settings.join(", "));
            text::from_ron::<Box<dyn RetrievalEngine>>(&text).map(|_| text)
        };
        self.engines.iter().map(one).collect()
    }
}

/// Files that engines keep their finished runs in, told from the study's folder.
fn checkpoints(engines: &[String]) -> Result<Vec<String>> {
    let all = Checkpoint { folder: CHECKPOINTS.into(), resume: false };
    let file = |engine: &String| {
        let engine: Box<dyn RetrievalEngine> = text::from_ron(engine)?;
        Ok(all.file(engine.label()).display().to_string())
    };
    engines.iter().map(file).collect()
}

/// The engines of this build, with entries of a scenario to start from.
pub(super) fn kinds() -> Vec<Value> {
    let here =
        |about: &&EngineAbout| catalogue::engine(about.name).is_ok_and(|engine| engine.available().is_ok());
    let one = |about: &EngineAbout| {
        json!({"name": about.name, "title": about.title, "text": about.text, "takes": about.takes,
               "template": about.example})
    };
    catalogue::CATALOGUE.iter().filter(here).map(one).collect()
}

/// What is told while it runs.
struct Told {
    since: Instant,
    told: Instant,
    history: Vec<[Option<f64>; 3]>,
    /// Every so-many-th step is kept.
    every: usize,
    seen: usize,
}

/// Runs the engines; a stop keeps their best.
///
/// # Errors
/// When the scenario cannot be run; the message says why.
pub(super) fn run(bench: &Arc<Bench>, order: &Order) -> Result<()> {
    let engines = order.written()?;
    let (path, step) = {
        let mut study = bench.study();
        let step =
            study.on_show().map(|s| s.id).ok_or_else(|| Error::new("there is no model to retrieve from"))?;
        // Whatever is in the way of its results is said before it runs, and while none is said to run.
        study.output.check(&["report.json", "retrieved.ron"])?;
        study.output.reserve(&checkpoints(&engines)?)?;
        (study.engines, study.intervals) = (engines, order.intervals);
        study.retrieval = None;
        folder::save(&study)?;
        study.retrieval =
            Some(Retrieval { step, running: true, engines: order.engines.clone(), ..Retrieval::default() });
        (study.folder.join("scenario.ron"), step)
    };
    bench.changed();
    let result = solve(bench, &path);
    bench.tell_retrieval(Value::Null);
    let mut study = bench.study();
    if let Some(retrieval) = &mut study.retrieval {
        (retrieval.running, retrieval.engine) = (false, None);
    }
    let outcome = result?;
    let mut report =
        serde_json::to_value(&outcome.report).map_err(|e| Error::new(format!("cannot write JSON: {e}")))?;
    // What was found beside this model needs no second search.
    if let Some(scan) = study.step(step).and_then(|s| s.scan.as_ref()) {
        let found = Diagnosis { timing: Default::default(), ..scan.diagnosis.clone() };
        report["diagnosis"] = json!(found);
    }
    let json =
        serde_json::to_string_pretty(&report).map_err(|e| Error::new(format!("cannot write JSON: {e}")))?;
    study.output.write("report.json", (json + "\n").as_bytes())?;
    let feasible = outcome.report.retrievals.as_ref().is_some_and(|all| all.iter().any(|r| r.feasible));
    match &outcome.model {
        Some(model) if feasible => study.output.write("retrieved.ron", text::to_ron(model)?.as_bytes())?,
        // Parameters of an earlier retrieval are not those of this one.
        _ => {
            study.output.remove("retrieved.ron")?;
        }
    }
    if let Some(retrieval) = study.retrieval.as_mut().filter(|r| r.step == step) {
        (retrieval.report, retrieval.stopped) = (Some(Arc::new(report)), outcome.stopped);
    }
    folder::save(&study)
}

fn solve(bench: &Arc<Bench>, path: &std::path::Path) -> Result<Outcome> {
    let now = Instant::now();
    let told = Mutex::new(Told { since: now, told: now, history: Vec::new(), every: 1, seen: 0 });
    let watch = |step: &Step| {
        // Whoever finds another thread here has nothing to add.
        if let Ok(mut told) = told.try_lock() {
            told.note(bench, step);
        }
        if bench.is_stopped() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    };
    // Before the first engine there is nothing to keep; from then on its best is.
    let searching = Arc::new(AtomicBool::new(false));
    let (own, begun) = (Arc::clone(bench), Arc::clone(&searching));
    let stop = Stop::when(move || own.is_stopped() && !begun.load(Ordering::SeqCst));
    let mut progress = |what: &str| {
        let engine = what.strip_prefix(LEAD).map(str::to_string);
        if engine.is_some() {
            searching.store(true, Ordering::SeqCst);
            let mut told = told.lock().unwrap_or_else(PoisonError::into_inner);
            *told = Told { since: Instant::now(), told: told.told, history: Vec::new(), every: 1, seen: 0 };
        }
        if let Some(retrieval) = &mut bench.study().retrieval {
            (retrieval.engine, retrieval.history) = (engine, Vec::new());
        }
        bench.progress(Place::Foreground, |p| {
            if let Some(p) = p {
                p.say(what);
            }
        });
        bench.changed();
    };
    let folder = path.with_file_name(CHECKPOINTS);
    study::run(
        path,
        study::Options {
            data: Vec::new(),
            seed: None,
            progress: &mut progress,
            watch: &watch,
            checkpoint: Some(Checkpoint { folder, resume: false }),
            stop,
        },
    )
}

impl Told {
    fn note(&mut self, bench: &Bench, step: &Step) {
        self.seen += 1;
        if self.told.elapsed() < PAUSE {
            return;
        }
        self.told = Instant::now();
        let (objective, violation) = (finite(step.objective), finite(step.violation));
        if self.seen.is_multiple_of(self.every) || self.every == 1 {
            self.history.push([Some(self.since.elapsed().as_secs_f64()), objective, violation]);
        }
        if self.history.len() > HISTORY {
            let mut k = 0;
            self.history.retain(|_| {
                k += 1;
                k % 2 == 1
            });
            self.every *= 2;
        }
        let mut left = None;
        bench.progress(Place::Foreground, |p| {
            if let Some(p) = p {
                p.done(step.done);
                left = p.seconds_left();
            }
        });
        let mut engine = None;
        if let Some(retrieval) = &mut bench.study().retrieval {
            retrieval.history.clone_from(&self.history);
            engine.clone_from(&retrieval.engine);
        }
        bench.tell_retrieval(json!({
            "engine": engine, "fraction": step.done, "objective": objective, "violation": violation,
            "seconds_left": left,
        }));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn engines_are_offered_with_entries_that_are_read() -> Result<()> {
        let offered = kinds();
        assert!(offered.len() >= 3);
        for kind in &offered {
            let name = kind["name"].as_str().expect("a name");
            let engine: Box<dyn RetrievalEngine> =
                text::from_ron(kind["template"].as_str().expect("a text"))?;
            assert_eq!(engine.name(), name);
            let order = Order { engines: vec![name.into()], runs: None, stages: None, intervals: false };
            assert_eq!(order.written()?.len(), 1, "what is offered can be asked for");
        }
        Ok(())
    }

    #[test]
    fn an_order_becomes_engines_of_a_scenario() -> Result<()> {
        let order: Order =
            serde_json::from_str(r#"{"engines": ["penalty", "lmi"], "runs": 3}"#).expect("an order");
        assert_eq!(order.written()?, [r#"{"penalty": (runs: 3)}"#, r#"{"lmi": ()}"#]);
        let none = Order { engines: vec![], ..order.clone() };
        assert!(none.written().is_err());
        let wrong = Order { engines: vec!["simplex".into()], ..order };
        assert!(wrong.written().expect_err("no such engine").to_string().contains("known are"));
        Ok(())
    }
}
