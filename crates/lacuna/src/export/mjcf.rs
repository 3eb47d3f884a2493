//! MJCF, the model format of MuJoCo.

use std::fmt::Write;

use nalgebra::{Rotation3, UnitQuaternion};

use super::Exported;
use super::parameters::{Friction, Parameters};
use super::xml::{escaped, in_comment, numbers};
use crate::error::Result;
use crate::robot::{JointKind, Pose, Robot};

/// Writes an MJCF model: nested bodies in the link frames of the robot (a joint's axis may pass anywhere),
/// gravity, limits, viscous friction as `damping`, Coulomb friction as `frictionloss`, named frames as sites.
///
/// # Errors
/// When a link cannot be written as a body.
pub fn mjcf(robot: &Robot, parameters: &Parameters) -> Result<Exported> {
    let mut notes = Vec::new();
    let friction = parameters.usable_friction(robot, &mut notes);
    let light: Vec<&str> = (robot.links.iter().zip(&parameters.links))
        .filter(|(_, p)| p.center_of_mass().is_none())
        .map(|(l, _)| l.name.as_str())
        .collect();
    if !light.is_empty() {
        notes.push(format!("MuJoCo wants mass in every moving body; these have none: {}", light.join(", ")));
    }
    let about = format!("written by lacuna {} from the robot `{}`", env!("CARGO_PKG_VERSION"), robot.name);
    let mut tree = Tree { robot, parameters, friction, text: format!("<!-- {} -->\n", in_comment(&about)) };
    let _ = writeln!(tree.text, "<mujoco model=\"{}\">", escaped(&robot.name));
    tree.text += "  <compiler angle=\"radian\" autolimits=\"true\"/>\n";
    let _ = writeln!(tree.text, "  <option gravity=\"{}\"/>\n  <worldbody>", numbers(&robot.gravity));
    tree.sites(None, 4);
    for root in (0..robot.dof()).filter(|&i| robot.joints[i].parent.is_none()) {
        tree.body(root, 4)?;
    }
    tree.text += "  </worldbody>\n</mujoco>\n";
    notes.extend(parameters.left_out_note("MJCF"));
    Ok(Exported { text: tree.text, notes })
}

struct Tree<'a> {
    robot: &'a Robot,
    parameters: &'a Parameters,
    friction: Vec<Friction>,
    text: String,
}

fn place(pose: &Pose) -> String {
    let rotation = Rotation3::from_matrix_unchecked(pose.rotation);
    let q = UnitQuaternion::from_rotation_matrix(&rotation);
    format!("pos=\"{}\" quat=\"{}\"", numbers(&pose.translation), numbers(&[q.w, q.i, q.j, q.k]))
}

impl Tree<'_> {
    /// The body that joint `i` moves, and all that hangs on it.
    fn body(&mut self, i: usize, depth: usize) -> Result<()> {
        let joint = &self.robot.joints[i];
        let indent = " ".repeat(depth);
        let at_zero = joint.before.then(&joint.after);
        let name = escaped(&self.robot.links[i].name);
        let _ = writeln!(self.text, "{indent}<body name=\"{name}\" {}>", place(&at_zero));
        let body = self.parameters.body(self.robot, i, &self.parameters.links[i])?;
        let m = &body.inertia;
        let full = [m[(0, 0)], m[(1, 1)], m[(2, 2)], m[(0, 1)], m[(0, 2)], m[(1, 2)]];
        let _ = writeln!(
            self.text,
            "{indent}  <inertial pos=\"{}\" mass=\"{:?}\" fullinertia=\"{}\"/>",
            numbers(&body.com),
            body.mass,
            numbers(&full)
        );
        self.joint(i, &indent);
        self.sites(Some(i), depth + 2);
        for child in (0..self.robot.dof()).filter(|&c| self.robot.joints[c].parent == Some(i)) {
            self.body(child, depth + 2)?;
        }
        let _ = writeln!(self.text, "{indent}</body>");
        Ok(())
    }

    /// The joint, in the frame of the body that it moves.
    fn joint(&mut self, i: usize, indent: &str) {
        let joint = &self.robot.joints[i];
        let back = joint.after.inverse();
        let kind = match joint.kind {
            JointKind::Revolute => "hinge",
            JointKind::Prismatic => "slide",
        };
        let mut attributes = format!(
            "name=\"{}\" type=\"{kind}\" pos=\"{}\" axis=\"{}\"",
            escaped(&joint.name),
            numbers(&back.translation),
            numbers(&(back.rotation * joint.axis))
        );
        if let (Some(lower), Some(upper)) = (joint.limits.lower, joint.limits.upper) {
            let _ = write!(attributes, " range=\"{}\"", numbers(&[lower, upper]));
        }
        if let Some(effort) = joint.limits.effort {
            let _ = write!(attributes, " actuatorfrcrange=\"{}\"", numbers(&[-effort, effort]));
        }
        let Friction { viscous, coulomb } = self.friction[i];
        for (name, value) in [("damping", viscous), ("frictionloss", coulomb)] {
            if let Some(value) = value {
                let _ = write!(attributes, " {name}=\"{value:?}\"");
            }
        }
        let _ = writeln!(self.text, "{indent}  <joint {attributes}/>");
    }

    /// Named frames of a link.
    fn sites(&mut self, link: Option<usize>, depth: usize) {
        let indent = " ".repeat(depth);
        for frame in self.robot.frames.iter().filter(|f| f.link == link) {
            let (name, place) = (escaped(&frame.name), place(&frame.pose));
            let _ = writeln!(self.text, "{indent}<site name=\"{name}\" {place}/>");
        }
    }
}
