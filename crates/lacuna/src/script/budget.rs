//! What a script may use up, counted wherever it is at work: read, traced, lowered, computed on the rows of a log.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use crate::error::Error;
use crate::stop::{Stop, stopped};

/// Memory that a script may need \[bytes\].
pub(crate) const MOST_BYTES: usize = 256 << 20;
/// How errors begin that say so.
pub(super) const TOO_LARGE: &str = "the script needs more than 256 MB";

/// Steps of a program between looks at the clock: far less than a hundredth of a second.
const LOOK_EVERY: usize = 16_384;

/// What a script has used up so far; copies count together.
#[derive(Debug, Clone, Default)]
pub struct Usage {
    nanoseconds: Arc<AtomicU64>,
    /// Bytes of lowered programs, which stay.
    bytes: Arc<AtomicUsize>,
}

impl Usage {
    /// Time so far, of all threads together.
    pub(super) fn time(&self) -> Duration {
        Duration::from_nanos(self.nanoseconds.load(Ordering::Relaxed))
    }

    pub(super) fn add_time(&self, more: Duration) {
        self.nanoseconds.fetch_add(nanoseconds(more), Ordering::Relaxed);
    }

    pub(super) fn bytes(&self) -> usize {
        self.bytes.load(Ordering::Relaxed)
    }

    pub(super) fn keep(&self, bytes: usize) {
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
    }
}

fn nanoseconds(time: Duration) -> u64 {
    u64::try_from(time.as_nanos()).unwrap_or(u64::MAX)
}

/// Why a script may not go on.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Halt {
    /// Its time is up.
    OutOfTime,
    /// Somebody stopped the work.
    Stopped,
}

/// Counts the time of one thread that works through a script's programs, and looks whether it may go on.
pub(crate) struct Clock<'a> {
    own: &'a Usage,
    /// The same of the piece of work at hand, where that counts by itself.
    work: Option<Arc<AtomicU64>>,
    stop: &'a Stop,
    allowed: Duration,
    since: Instant,
    steps: usize,
}

impl<'a> Clock<'a> {
    /// Begins to count for the script called `script` in the work that `stop` ends.
    pub(crate) fn start(own: &'a Usage, script: u64, seconds: f64, stop: &'a Stop) -> Self {
        let allowed = Duration::try_from_secs_f64(seconds).unwrap_or(Duration::MAX);
        Self { own, work: stop.used_by(script), stop, allowed, since: Instant::now(), steps: LOOK_EVERY }
    }

    /// So many more steps are to be done; says so where they may not.
    #[inline]
    pub(crate) fn tick(&mut self, steps: usize) -> Result<(), Halt> {
        self.steps += steps;
        if self.steps < LOOK_EVERY {
            return Ok(());
        }
        self.steps = 0;
        self.look()
    }

    /// Why `function` of the script may not go on, told at its place.
    pub(super) fn error(&self, halt: Halt, function: &str, (line, column): (usize, usize)) -> Error {
        match halt {
            Halt::Stopped => stopped(),
            Halt::OutOfTime => Error::new(format!(
                "the script took more than {} s, all it did counted together; `{function}` was at the samples of a log",
                self.allowed.as_secs_f64()
            ))
            .at(line, column)
            .help("compute less for every sample, give a shorter log, or allow more with `seconds`")
            .ending(),
        }
    }

    fn look(&mut self) -> Result<(), Halt> {
        self.count();
        let of_work = self.work.as_ref().map_or(0, |used| used.load(Ordering::Relaxed));
        if self.stop.asked() {
            return Err(Halt::Stopped);
        }
        let late = self.own.time() + Duration::from_nanos(of_work) > self.allowed;
        if late { Err(Halt::OutOfTime) } else { Ok(()) }
    }

    fn count(&mut self) {
        let now = Instant::now();
        let more = now.duration_since(std::mem::replace(&mut self.since, now));
        match &self.work {
            Some(used) => {
                used.fetch_add(nanoseconds(more), Ordering::Relaxed);
            }
            None => self.own.add_time(more),
        }
    }
}

impl Drop for Clock<'_> {
    fn drop(&mut self) {
        self.count();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn time_is_counted_over_all_that_a_script_does() {
        let (own, stop) = (Usage::default(), Stop::when(|| false));
        own.add_time(Duration::from_secs(6));
        assert_eq!(Clock::start(&own, 1, 10.0, &stop).tick(1), Ok(()));
        stop.used_by(1).expect("is counted").fetch_add(5_000_000_000, Ordering::Relaxed);
        assert_eq!(Clock::start(&own, 1, 10.0, &stop).tick(1), Err(Halt::OutOfTime));
        assert_eq!(Clock::start(&own, 2, 10.0, &stop).tick(1), Ok(()), "another script has its own time");
        let again = Stop::when(|| false);
        assert_eq!(Clock::start(&own, 1, 10.0, &again).tick(1), Ok(()), "other work begins anew");
        assert_eq!(Clock::start(&own, 1, 10.0, &Stop::when(|| true)).tick(1), Err(Halt::Stopped));
    }
}
