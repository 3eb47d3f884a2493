//! The study with its guards: who changes it, who is told, who may be stopped.

use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, mpsc};

use serde_json::Value;
use tokio::sync::watch;

use super::folder;
use super::progress::Progress;
use super::study::Study;
use super::work::{self, Job};
use crate::error::{Error, Result};
use crate::stop::Stop;
use crate::text::Output;

/// What all requests and both threads share.
pub(super) struct Bench {
    study: Mutex<Study>,
    /// Counts changes of the study.
    version: watch::Sender<u64>,
    /// Work of the foreground and of the background.
    progress: Mutex<[Option<Progress>; 2]>,
    job: watch::Sender<Value>,
    retrieval: watch::Sender<Value>,
    jobs: Mutex<mpsc::Sender<(u64, Job)>>,
    /// Counts changes of robot, logs and column map.
    data: AtomicU64,
    /// Jobs that wait or run in the foreground.
    pending: AtomicU64,
    /// Whether the foreground is asked to stop.
    stop: AtomicBool,
    /// How often somebody has stopped what runs.
    stops: Arc<AtomicU64>,
    /// Number of the search in the background; older ones end when they see it.
    pub search: AtomicU64,
    /// The search that is asked to end with what it has found.
    pub ended: AtomicU64,
    /// Whether what the next finished search finds is added at once.
    pub auto: AtomicBool,
    /// One search at a time.
    pub turn: Mutex<()>,
}

/// Which thread works.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Place {
    Foreground = 0,
    Background = 1,
}

impl Bench {
    /// Starts the thread that does what is asked for; nothing is yet.
    pub fn start(study: Study) -> Result<Arc<Self>> {
        let (sender, receiver) = mpsc::channel();
        let bench = Arc::new(Self {
            study: Mutex::new(study),
            version: watch::Sender::new(1),
            progress: Mutex::new([None, None]),
            job: watch::Sender::new(Value::Null),
            retrieval: watch::Sender::new(Value::Null),
            jobs: Mutex::new(sender),
            data: AtomicU64::new(0),
            pending: AtomicU64::new(0),
            stop: AtomicBool::new(false),
            stops: Arc::default(),
            search: AtomicU64::new(0),
            ended: AtomicU64::new(0),
            auto: AtomicBool::new(false),
            turn: Mutex::new(()),
        });
        let own = Arc::clone(&bench);
        std::thread::Builder::new()
            .name("work".to_string())
            .spawn(move || work::run(&own, &receiver))
            .map_err(|e| Error::new(format!("cannot start a thread: {e}")))?;
        Ok(bench)
    }

    /// The study, to read or to change; whoever changes it calls [`Bench::changed`] afterwards.
    pub fn study(&self) -> MutexGuard<'_, Study> {
        self.study.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub fn folder(&self) -> PathBuf {
        self.study().folder.clone()
    }

    /// The folder for writing.
    pub fn output(&self) -> Output {
        self.study().output.clone()
    }

    /// Tells all tabs that the study is another one; answers its version.
    pub fn changed(&self) -> u64 {
        self.version.send_modify(|version| *version += 1);
        *self.version.borrow()
    }

    pub fn version(&self) -> u64 {
        *self.version.borrow()
    }

    pub fn versions(&self) -> watch::Receiver<u64> {
        self.version.subscribe()
    }

    pub fn job_events(&self) -> watch::Receiver<Value> {
        self.job.subscribe()
    }

    pub fn retrieval_events(&self) -> watch::Receiver<Value> {
        self.retrieval.subscribe()
    }

    pub fn tell_retrieval(&self, what: Value) {
        self.retrieval.send_replace(what);
    }

    /// Asks the foreground for something.
    pub fn ask(&self, job: Job) {
        self.pending.fetch_add(1, Ordering::SeqCst);
        let jobs = self.jobs.lock().unwrap_or_else(PoisonError::into_inner);
        if jobs.send((self.data(), job)).is_err() {
            self.pending.fetch_sub(1, Ordering::SeqCst);
        }
    }

    /// Number of the data that the study has now: what was made of others is of no use.
    pub fn data(&self) -> u64 {
        self.data.load(Ordering::SeqCst)
    }

    /// Whatever was found was found in other data; `study` has the new ones.
    pub fn renew(&self, mut study: MutexGuard<'_, Study>) {
        self.stop_search();
        self.data.fetch_add(1, Ordering::SeqCst);
        for log in &mut study.logs {
            (log.findings, log.log) = (None, None);
        }
        for step in &mut study.steps {
            step.effects.clear();
            (step.fitted, step.ranking, step.scan) = (None, None, None);
        }
        study.trouble = None;
        // What cannot be written now is written with the next step, which says so.
        let _ = folder::save(&study);
        drop(study);
        self.ask(Job::Open { again: true });
    }

    /// A job of the foreground is over.
    pub fn finished(&self) {
        self.pending.fetch_sub(1, Ordering::SeqCst);
        self.stop.store(false, Ordering::SeqCst);
    }

    /// Whether more is waiting than the job at hand.
    pub fn is_awaited(&self) -> bool {
        self.pending.load(Ordering::SeqCst) > 1
    }

    /// Asks whatever runs to stop and keep what it has found.
    pub fn stop(&self) {
        self.stops.fetch_add(1, Ordering::SeqCst);
        if self.pending.load(Ordering::SeqCst) > 0 {
            self.stop.store(true, Ordering::SeqCst);
        }
        self.auto.store(false, Ordering::SeqCst);
        self.ended.store(self.search.load(Ordering::SeqCst), Ordering::SeqCst);
        for place in [Place::Foreground, Place::Background] {
            self.progress(place, |p| {
                if let Some(p) = p.as_mut().filter(|p| p.stoppable) {
                    p.say("stopping");
                }
            });
        }
    }

    /// Ends what is done at once for a request (a script that is checked) when somebody stops what runs.
    pub fn draft(&self) -> Stop {
        let (stops, before) = (Arc::clone(&self.stops), self.stops.load(Ordering::SeqCst));
        Stop::when(move || stops.load(Ordering::SeqCst) != before)
    }

    /// Lets go of the search in the background: nobody waits for it any more.
    pub fn stop_search(&self) {
        self.search.fetch_add(1, Ordering::SeqCst);
    }

    /// Whether the job at hand is asked to stop.
    pub fn is_stopped(&self) -> bool {
        self.stop.load(Ordering::SeqCst)
    }

    /// Changes what is said of the work in one place, and says it.
    pub fn progress(&self, place: Place, change: impl FnOnce(&mut Option<Progress>)) {
        let mut both = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        change(&mut both[place as usize]);
        let shown = both.iter().flatten().next().map_or(Value::Null, Progress::json);
        self.job.send_replace(shown);
    }

    /// The work that is going on: what was asked for first.
    pub fn job(&self) -> Value {
        let both = self.progress.lock().unwrap_or_else(PoisonError::into_inner);
        both.iter().flatten().next().map_or(Value::Null, Progress::json)
    }

    /// Whether a retrieval is running: what it works on must not change.
    pub fn is_retrieving(&self) -> bool {
        self.study().retrieval.as_ref().is_some_and(|r| r.running)
    }
}
