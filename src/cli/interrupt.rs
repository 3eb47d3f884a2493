//! Ctrl-C, and what else asks a process to end: a search that has something to keep is asked to stop and keeps it;
//! anything else ends at once.

use std::ops::ControlFlow;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, OnceLock};
use std::time::Duration;

use lacuna::diagnose::Stop;
use lacuna::{Error, Result};

/// What shells expect of a process that was interrupted.
const INTERRUPTED: i32 = 130;
/// Whoever has not looked up by then works on something long, and the user is told.
const PATIENCE: Duration = Duration::from_millis(1500);

/// Whether the user has pressed Ctrl-C, or the system asked the process to end (SIGTERM).
#[derive(Debug, Clone, Default)]
pub(super) struct Interrupt {
    asked: Arc<AtomicBool>,
    /// Whether an engine is at work, which keeps its best.
    engine: Arc<AtomicBool>,
    /// Whether somebody has seen that the user asked.
    seen: Arc<AtomicBool>,
    /// The search, which knows whether it has found something.
    search: Arc<OnceLock<Stop>>,
}

impl Interrupt {
    /// Takes Ctrl-C and SIGTERM over for the rest of the process.
    pub(super) fn install(quiet: bool) -> Result<Self> {
        let interrupt = Self::default();
        let own = interrupt.clone();
        listen(move || own.act(quiet))
            .map_err(|e| Error::new(format!("cannot listen for Ctrl-C: {e}")))
            .map(|()| interrupt)
    }

    fn act(&self, quiet: bool) {
        let again = self.asked.swap(true, Ordering::SeqCst);
        if again || !self.has_something() {
            std::process::exit(INTERRUPTED);
        }
        if quiet {
            return;
        }
        super::say("\ninterrupted: keeping the best so far (Ctrl-C again ends at once)");
        let own = self.clone();
        std::thread::spawn(move || {
            std::thread::sleep(PATIENCE);
            if !own.seen.load(Ordering::SeqCst) {
                super::say(
                    "a long step is under way; what was found is kept after it (Ctrl-C again ends at once)",
                );
            }
        });
    }

    /// Whether there is anything to keep.
    fn has_something(&self) -> bool {
        self.engine.load(Ordering::SeqCst) || self.search.get().is_some_and(Stop::has_found)
    }

    /// The flag of a search: asked to stop with Ctrl-C, and where nothing was found by then nothing is lost.
    pub(super) fn search(&self) -> Stop {
        let own = self.clone();
        self.search.get_or_init(|| Stop::when(move || own.look())).clone()
    }

    fn look(&self) -> bool {
        let asked = self.was_asked();
        if asked {
            self.seen.store(true, Ordering::SeqCst);
        }
        asked
    }

    /// Asked by an engine whether to go on.
    pub(super) fn flow(&self) -> ControlFlow<()> {
        self.engine.store(true, Ordering::SeqCst);
        if self.look() { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Whether the user has asked to stop.
    pub(super) fn was_asked(&self) -> bool {
        self.asked.load(Ordering::SeqCst)
    }

    /// No engine is searching any more.
    pub(super) fn leave(&self) {
        self.engine.store(false, Ordering::SeqCst);
    }
}

/// Calls `act` on Ctrl-C and SIGTERM, in a thread of its own.
///
/// A closed terminal (SIGHUP) is left alone: it ends the process unless that was started with `nohup`, which a handler
/// would undo.
#[cfg(unix)]
fn listen(act: impl Fn() + Send + 'static) -> std::io::Result<()> {
    use signal_hook::consts::{SIGINT, SIGTERM};
    let mut signals = signal_hook::iterator::Signals::new([SIGINT, SIGTERM])?;
    let each = move || signals.forever().for_each(|_| act());
    std::thread::Builder::new().name("signals".to_string()).spawn(each).map(|_| ())
}

/// Calls `act` on Ctrl-C, and where the console or the session is closed.
#[cfg(not(unix))]
fn listen(act: impl Fn() + Send + 'static) -> Result<(), ctrlc::Error> {
    ctrlc::set_handler(act)
}
