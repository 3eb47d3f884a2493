//! Checks that the author of a plug-in calls from a test: does a constraint, an effect or an engine keep its
//! promises?
//!
//! They use the public interface only, as a study would, and their errors say what to mend.
//!
//! ```
//! use lacuna::{conformance, robot::Robot};
//! let robot = Robot::open("../../robots/two_link.ron")?;
//! let folder = std::path::Path::new(".");
//! conformance::constraint(r#"{"total_mass": (min: 5.0, max: 20.0)}"#, &robot, folder, &[])?;
//! # Ok::<(), lacuna::Error>(())
//! ```
//!
//! A plug-in in a crate of its own is found by name only if that crate is linked: a program or test that
//! mentions no item of it must say `use my_plugins as _;`, or reading a scenario answers that the name is
//! unknown.

mod constraint;
mod effect;
mod engine;

pub use constraint::constraint;
pub use effect::effect;
pub use engine::engine;

use crate::error::{Error, Result};

/// Fails with `text` unless `holds`.
fn must(holds: bool, text: impl FnOnce() -> String) -> Result<()> {
    if holds { Ok(()) } else { Err(Error::new(text())) }
}
