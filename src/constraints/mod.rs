//! Constraints: what link parameters must satisfy. Each is a plug-in, one file each; [`CATALOGUE`] names
//! those that ship.
//!
//! A constraint is lowered once per study to [`Form`]s over the unknowns of [`LinkSpace`].

mod script;
mod space;

pub use script::{Explanation, FormExplanation, RuleExplanation, Scripted, explain};
pub use space::{Barycentric, COORDINATES, LinkSpace};

use std::fmt::Debug;
use std::path::Path;

use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// What a constraint says about itself; printed by `lacuna list constraints NAME`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About {
    /// Name in RON, JSON and on the command line.
    pub name: &'static str,
    /// One line for the catalogue.
    pub title: &'static str,
    /// What it means and when to use it.
    pub text: &'static str,
    /// The condition as a formula.
    pub condition: &'static str,
    /// Settings: name, unit, meaning.
    pub settings: &'static [(&'static str, &'static str, &'static str)],
    /// Which forms it lowers to, and so which engines take it.
    pub form: &'static str,
}

/// A condition on link parameters.
#[typetag::serde]
pub trait Constraint: Debug + Send + Sync {
    /// Name, text and condition.
    fn about(&self) -> About;

    /// Reads the files it names; `folder` is that of the scenario. Called once, before anything else.
    ///
    /// # Errors
    /// When a file is missing, lies outside the scenario's folder or repository, or is not usable.
    fn load(&mut self, folder: &Path) -> Result<()> {
        let _ = folder;
        Ok(())
    }

    /// The forms it stands for on this robot.
    ///
    /// # Errors
    /// When its settings do not fit the robot.
    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>>;
}

/// The constraints that ship.
pub const CATALOGUE: &[fn() -> About] = &[|| Scripted::ABOUT];
