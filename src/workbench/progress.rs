//! How far the work is.

use std::time::Instant;

use serde_json::{Value, json};

/// A piece of work that is going on.
#[derive(Debug, Clone)]
pub(super) struct Progress {
    pub kind: &'static str,
    pub text: String,
    /// Share that is done, where known.
    pub fraction: Option<f64>,
    /// The share at the beginning of this part, more than none after a resume, and when that was.
    begun: Option<(f64, Instant)>,
    since: Instant,
    pub stoppable: bool,
}

impl Progress {
    pub fn new(kind: &'static str, text: &str, stoppable: bool) -> Self {
        Self { kind, text: text.to_string(), fraction: None, begun: None, since: Instant::now(), stoppable }
    }

    /// Another part of the same work.
    pub fn say(&mut self, text: &str) {
        (self.text, self.fraction, self.begun) = (text.to_string(), None, None);
    }

    /// So much of it is done.
    pub fn done(&mut self, fraction: f64) {
        self.begun.get_or_insert_with(|| (fraction, Instant::now()));
        self.fraction = Some(fraction);
    }

    /// Time that is left of this part, by its pace so far \[s\].
    pub fn seconds_left(&self) -> Option<f64> {
        let (fraction, (begun, since)) = (self.fraction?, self.begun?);
        let done = fraction - begun;
        (done > 0.0).then(|| (since.elapsed().as_secs_f64() * (1.0 - fraction) / done).ceil())
    }

    pub fn json(&self) -> Value {
        json!({
            "kind": self.kind,
            "text": self.text,
            "fraction": self.fraction,
            "seconds": self.since.elapsed().as_secs_f64(),
            "seconds_left": self.seconds_left(),
            "stoppable": self.stoppable,
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::time::Duration;

    #[test]
    fn time_left_follows_the_pace_since_the_work_began_here() {
        let mut work = Progress::new("retrieve", "penalty", true);
        assert_eq!(work.seconds_left(), None);
        work.done(0.5);
        let earlier = Instant::now().checked_sub(Duration::from_secs(10)).expect("the clock runs");
        work.begun = Some((0.5, earlier));
        assert_eq!(work.seconds_left(), None, "half was done before");
        work.done(0.75);
        assert_eq!(work.seconds_left(), Some(11.0), "a quarter took ten seconds and a bit");
        work.say("lmi");
        assert_eq!((work.fraction, work.seconds_left()), (None, None));
        work.done(0.1);
        work.done(0.2);
        assert_eq!(work.seconds_left(), Some(1.0), "the new part has a pace of its own");
    }
}
