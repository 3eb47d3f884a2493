//! Work that may be asked to end, and what scripts have used up in it.

use std::collections::BTreeMap;
use std::fmt;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use crate::error::{Error, Result};

/// Asked on the way whether a piece of work is to end there, with what is found by then; never, by default. Copies are
/// of the same piece of work.
#[derive(Clone, Default)]
pub struct Stop {
    work: Option<Arc<Work>>,
    /// Whether what is done with this copy is done to its end.
    deaf: bool,
}

struct Work {
    asked: Box<dyn Fn() -> bool + Send + Sync>,
    /// Whether anything was found by now.
    found: AtomicBool,
    /// Time that each script has used in this work \[ns\].
    scripts: Mutex<BTreeMap<u64, Arc<AtomicU64>>>,
}

impl Stop {
    /// Ends the work as soon as `asked` answers `true`; it must not take that back.
    pub fn when(asked: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        let (asked, found) = (Box::new(asked), AtomicBool::new(false));
        Self { work: Some(Arc::new(Work { asked, found, scripts: Mutex::default() })), deaf: false }
    }

    /// Whether the work is to end.
    pub fn asked(&self) -> bool {
        !self.deaf && self.work.as_ref().is_some_and(|work| (work.asked)())
    }

    /// A copy for what is to be done to its end although it belongs to the same work.
    #[must_use]
    pub fn to_the_end(&self) -> Self {
        Self { work: self.work.clone(), deaf: true }
    }

    /// Goes on unless the work is to end.
    ///
    /// # Errors
    /// When it is.
    pub fn check(&self) -> Result<()> {
        if self.asked() { Err(stopped()) } else { Ok(()) }
    }

    /// Whether there is something by now that is worth keeping.
    pub fn has_found(&self) -> bool {
        self.work.as_ref().is_some_and(|work| work.found.load(Ordering::SeqCst))
    }

    /// Something was found.
    pub fn found(&self) {
        if let Some(work) = &self.work {
            work.found.store(true, Ordering::SeqCst);
        }
    }

    /// The time that a script has used in this work \[ns\], to be added to.
    pub fn used_by(&self, script: u64) -> Option<Arc<AtomicU64>> {
        let work = self.work.as_ref()?;
        let mut scripts = work.scripts.lock().unwrap_or_else(PoisonError::into_inner);
        Some(scripts.entry(script).or_default().clone())
    }
}

/// The error of work that ended because it was asked to.
pub fn stopped() -> Error {
    Error::new("stopped before it was done")
        .help("what was there before is as it was; ask again to go on")
        .ending()
}

impl fmt::Debug for Stop {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(if self.work.is_some() { "Stop(when asked)" } else { "Stop(never)" })
    }
}

impl PartialEq for Stop {
    fn eq(&self, other: &Self) -> bool {
        match (&self.work, &other.work) {
            (Some(a), Some(b)) => Arc::ptr_eq(a, b),
            (a, b) => a.is_none() && b.is_none(),
        }
    }
}
