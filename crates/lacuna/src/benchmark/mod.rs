//! A self-examination of the diagnosis: effects are hidden in simulated logs, one after the other, and the
//! answers are counted.
//!
//! What counts as right stands in `answers.ron`, fixed before the run. Draws that cannot be hidden (their
//! strength would need an impossible size, or no motion shows them) are excluded, counted and printed with
//! their reason. The seeds of a published table come from the hash of the commit that made it
//! ([`seed_of_commit`]), so that nothing can be tuned to them.
//!
//! Plant and diagnosis share no code for friction, dynamics or sensors, but for most effects of the catalogue
//! they share the functional form; "outside" hides what the catalogue has not.

mod examine;
mod judge;
mod plan;
mod run;
mod table;

pub use examine::{Examination, examine};
pub use judge::{Answer, Mark, Marks};
pub use plan::{Item, PARTS, Part, plan};
pub use run::{Record, run};
pub use table::{Table, tables};

use crate::error::{Error, Result};

/// Seed from a commit's hash: its first eight hexadecimal digits.
///
/// # Errors
/// When that is not eight hexadecimal digits.
pub fn seed_of_commit(hash: &str) -> Result<u64> {
    let digits = hash.get(..8).unwrap_or(hash);
    let seed = u64::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 8);
    seed.ok_or_else(|| {
        Error::new(format!("`{hash}` is not the hash of a commit"))
            .help("give at least its first eight hexadecimal digits")
    })
}

#[cfg(test)]
mod tests {
    use super::seed_of_commit;

    #[test]
    fn a_hash_is_a_seed() {
        assert_eq!(seed_of_commit("000000ffabc").ok(), Some(255));
        assert!(seed_of_commit("12345").is_err() && seed_of_commit("zzzzzzzz").is_err());
    }
}
