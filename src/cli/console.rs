//! What goes to stderr while work is going on.

use std::io::{IsTerminal, Write};
use std::sync::{Mutex, PoisonError};
use std::time::{Duration, Instant};

use lacuna::retrieval::Step;
use lacuna::text::one_line;

/// Progress for people: one line that is rewritten on a terminal, plain lines elsewhere.
pub(crate) struct Console {
    quiet: bool,
    terminal: bool,
    start: Instant,
    state: Mutex<State>,
}

struct State {
    /// Whether an unfinished line stands on the terminal.
    open: bool,
    /// What is being done, and since when.
    task: String,
    since: Instant,
    /// Share of the task that was done when it was first asked about (more than none after a resume).
    begun: Option<f64>,
    shown: Instant,
}

impl Console {
    pub(crate) fn new(quiet: bool) -> Self {
        let terminal = std::io::stderr().is_terminal();
        let start = Instant::now();
        let state = State { open: false, task: String::new(), since: start, begun: None, shown: start };
        Self { quiet, terminal, start, state: Mutex::new(state) }
    }

    /// Says what is being done.
    pub(crate) fn say(&self, what: &str) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        let now = Instant::now();
        (state.task, state.since, state.begun, state.shown) = (what.to_string(), now, None, now);
        self.show(&mut state, what);
    }

    /// Says how far the task is, now and then; called from several threads.
    pub(crate) fn step(&self, step: &Step) {
        let pause = Duration::from_millis(if self.terminal { 100 } else { 500 });
        // Whoever finds another thread here has nothing to add.
        let Ok(mut state) = self.state.try_lock() else { return };
        let begun = *state.begun.get_or_insert(step.done);
        if state.shown.elapsed() < pause {
            return;
        }
        state.shown = Instant::now();
        let seconds = state.since.elapsed().as_secs_f64();
        let line = format!("{}{}", state.task, progress(step, begun, seconds));
        self.show(&mut state, &line);
    }

    fn show(&self, state: &mut State, line: &str) {
        if self.quiet {
            return;
        }
        let seconds = self.start.elapsed().as_secs_f64();
        if self.terminal {
            put(&format!("\r\x1b[2K{seconds:6.1} s  {} ...", one_line(line)));
            state.open = true;
        } else {
            put(&format!("{seconds:6.1} s  {}\n", one_line(line)));
        }
    }

    /// Removes the progress line.
    pub(crate) fn clear(&self) {
        let mut state = self.state.lock().unwrap_or_else(PoisonError::into_inner);
        if std::mem::take(&mut state.open) {
            put("\r\x1b[2K");
        }
    }
}

/// Writes to stderr. That nobody listens is no reason to end.
fn put(text: &str) {
    let mut out = std::io::stderr().lock();
    let _ = out.write_all(text.as_bytes()).and_then(|()| out.flush());
}

/// `: 35 %, best 3.7262e-4, violation 0, 12 s left`, as far as it is known.
fn progress(step: &Step, begun: f64, seconds: f64) -> String {
    let mut text = format!(": {:.0} %", 100.0 * step.done);
    if step.objective.is_finite() {
        text += &format!(", best {:.4e}", step.objective);
    }
    if step.violation.is_finite() {
        let none = step.violation <= 0.0;
        text += &if none { ", violation 0".into() } else { format!(", violation {:.0e}", step.violation) };
    }
    let done = step.done - begun;
    if done > 0.0 {
        text += &format!(", {:.0} s left", (seconds * (1.0 - step.done) / done).ceil());
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn progress_names_what_is_known() {
        let step = Step { done: 0.75, objective: 3.7262e-4, violation: 0.0 };
        assert_eq!(progress(&step, 0.5, 10.0), ": 75 %, best 3.7262e-4, violation 0, 10 s left");
        let unknown = Step { done: 0.0, objective: f64::INFINITY, violation: f64::INFINITY };
        assert_eq!(progress(&unknown, 0.0, 10.0), ": 0 %");
    }
}
