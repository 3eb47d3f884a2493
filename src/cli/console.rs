//! What goes to stderr while work is going on.

use std::cell::Cell;
use std::io::{IsTerminal, Write};
use std::time::Instant;

/// Progress for people: one line that is rewritten on a terminal, plain lines elsewhere.
pub(crate) struct Console {
    quiet: bool,
    terminal: bool,
    start: Instant,
    open: Cell<bool>,
}

impl Console {
    pub(crate) fn new(quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        Self { quiet, terminal, start: Instant::now(), open: Cell::new(false) }
    }

    /// Says what is being done.
    pub(crate) fn say(&self, what: &str) {
        if self.quiet {
            return;
        }
        let seconds = self.start.elapsed().as_secs_f64();
        if self.terminal {
            eprint!("\r\x1b[2K{seconds:6.1} s  {what} ...");
            let _ = std::io::stderr().flush();
            self.open.set(true);
        } else {
            eprintln!("{seconds:6.1} s  {what}");
        }
    }

    /// Removes the progress line.
    pub(crate) fn clear(&self) {
        if self.open.replace(false) {
            eprint!("\r\x1b[2K");
        }
    }
}
