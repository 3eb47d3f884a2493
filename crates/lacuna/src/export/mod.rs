//! Identified link parameters for other tools: URDF, MJCF (MuJoCo) and JSON.
//!
//! What a format cannot say comes back as a note, never silently: gravity in a URDF, friction beyond
//! viscous and Coulomb, links without mass.

mod fresh;
mod json;
mod mjcf;
mod parameters;
mod patch;
mod xml;

pub use json::json;
pub use mjcf::mjcf;
pub use parameters::{Body, Friction, Parameters};

use crate::error::Result;
use crate::robot::Robot;

/// A written document and what to know about it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Exported {
    /// The document.
    pub text: String,
    /// What the format could not say, or says differently.
    pub notes: Vec<String>,
}

/// Writes a URDF.
///
/// With the text of the URDF that `robot` was read from, that text with new inertias: links, frames,
/// geometry and comments stay as they are. The inertia of a moving link includes all that is fixed to it, so
/// the `<inertial>` elements of fixed attachments are taken out. Without it, a new URDF with the robot's
/// joints, whose link frames sit on the joint axes as URDF demands: for standard Denavit-Hartenberg tables
/// these are not the table's frames, and inertias are moved accordingly.
///
/// # Errors
/// When `original` is not the URDF of this robot, or a link cannot be written as a body.
pub fn urdf(robot: &Robot, parameters: &Parameters, original: Option<&str>) -> Result<Exported> {
    let mut exported = match original {
        Some(text) => patch::urdf(robot, parameters, text)?,
        None => fresh::urdf(robot, parameters)?,
    };
    let gravity = robot.gravity;
    exported.notes.push(format!(
        "a URDF cannot say gravity: here it is ({:?}, {:?}, {:?}) m/s²",
        gravity.x, gravity.y, gravity.z
    ));
    exported.notes.extend(parameters.left_out_note("URDF"));
    Ok(exported)
}
