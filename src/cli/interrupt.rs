//! Ctrl-C: an engine that is searching is asked to stop and keep its best; anything else ends at once.

use std::ops::ControlFlow;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use lacuna::{Error, Result};

/// What shells expect of a process that was interrupted.
const INTERRUPTED: i32 = 130;

/// Whether the user has pressed Ctrl-C.
#[derive(Debug, Clone, Default)]
pub(super) struct Interrupt {
    /// Whether somebody listens.
    heard: Arc<AtomicBool>,
    asked: Arc<AtomicBool>,
}

impl Interrupt {
    /// Takes Ctrl-C over for the rest of the process.
    pub(super) fn install(quiet: bool) -> Result<Self> {
        let interrupt = Self::default();
        let own = interrupt.clone();
        let on_signal = move || {
            let again = own.asked.swap(true, Ordering::Relaxed);
            if again || !own.heard.load(Ordering::Relaxed) {
                std::process::exit(INTERRUPTED);
            }
            if !quiet {
                super::say("\ninterrupted: keeping the best so far (Ctrl-C again ends at once)");
            }
        };
        ctrlc::set_handler(on_signal)
            .map_err(|e| Error::new(format!("cannot listen for Ctrl-C: {e}")))
            .map(|()| interrupt)
    }

    /// Asked by an engine whether to go on.
    pub(super) fn flow(&self) -> ControlFlow<()> {
        self.heard.store(true, Ordering::Relaxed);
        if self.asked.load(Ordering::Relaxed) { ControlFlow::Break(()) } else { ControlFlow::Continue(()) }
    }

    /// Whether the user has asked to stop.
    pub(super) fn was_asked(&self) -> bool {
        self.asked.load(Ordering::Relaxed)
    }

    /// No engine is searching any more.
    pub(super) fn leave(&self) {
        self.heard.store(false, Ordering::Relaxed);
    }
}
