//! A new URDF from a robot's joints.

use std::fmt::Write;

use nalgebra::Vector3;

use super::Exported;
use super::parameters::{Body, Friction, Parameters};
use super::xml::{escaped, in_comment, numbers, roll_pitch_yaw};
use crate::error::Result;
use crate::robot::{Joint, JointKind, Pose, Robot};

/// Written where URDF demands a limit that nobody knows.
const NO_LIMIT: f64 = 1e9;

pub(super) fn urdf(robot: &Robot, parameters: &Parameters) -> Result<Exported> {
    let mut notes = Vec::new();
    let base = base_name(robot);
    let mut text = String::from("<?xml version=\"1.0\" encoding=\"UTF-8\"?>\n");
    let about = format!("written by lacuna {} from the robot `{}`", env!("CARGO_PKG_VERSION"), robot.name);
    let _ = writeln!(text, "<!-- {} -->", in_comment(&about));
    let _ = writeln!(text, "<robot name=\"{}\">\n  <link name=\"{base}\"/>", escaped(&robot.name));
    let friction = parameters.usable_friction(robot, &mut notes);
    for (i, joint) in robot.joints.iter().enumerate() {
        let parent = joint.parent.map_or(base.as_str(), |p| &robot.links[p].name);
        let before = joint.parent.map_or(joint.before, |p| robot.joints[p].after.then(&joint.before));
        let child = &robot.links[i].name;
        text += &movable(joint, parent, child, &before, &friction[i], &mut notes);
        let in_joint_frame = parameters.links[i].moved(&joint.after);
        let moved = if joint.after == Pose::identity() { parameters.links[i] } else { in_joint_frame };
        let body = parameters.body(robot, i, &moved)?;
        let _ = writeln!(text, "  <link name=\"{}\">\n{}  </link>", escaped(child), inertial(&body, "    "));
    }
    for frame in &robot.frames {
        let parent = frame.link.map_or(base.as_str(), |l| &robot.links[l].name);
        let pose = frame.link.map_or(frame.pose, |l| robot.joints[l].after.then(&frame.pose));
        text += &fixed(&frame.name, parent, &pose);
    }
    text += "</robot>\n";
    if robot.joints.iter().any(|j| j.after != Pose::identity()) {
        notes.push(
            "URDF puts each link frame on its joint's axis, so link frames are not those of the table; inertias \
             are given in the new frames"
                .into(),
        );
    }
    Ok(Exported { text, notes })
}

/// `base`, or that with as many underscores as make it unique.
fn base_name(robot: &Robot) -> String {
    let mut name = String::from("base");
    while robot.links.iter().any(|l| l.name == name) || robot.frames.iter().any(|f| f.name == name) {
        name.push('_');
    }
    name
}

fn origin(pose: &Pose) -> String {
    let rpy = roll_pitch_yaw(&pose.rotation);
    format!("<origin xyz=\"{}\" rpy=\"{}\"/>", numbers(&pose.translation), numbers(&rpy))
}

fn movable(
    joint: &Joint,
    parent: &str,
    child: &str,
    before: &Pose,
    friction: &Friction,
    notes: &mut Vec<String>,
) -> String {
    let bounded = joint.limits.lower.is_some() && joint.limits.upper.is_some();
    let kind = match joint.kind {
        JointKind::Revolute if bounded => "revolute",
        JointKind::Revolute => "continuous",
        JointKind::Prismatic => "prismatic",
    };
    let name = escaped(&joint.name);
    let mut text = format!("  <joint name=\"{name}\" type=\"{kind}\">\n    {}\n", origin(before));
    let _ = writeln!(
        text,
        "    <parent link=\"{}\"/>\n    <child link=\"{}\"/>",
        escaped(parent),
        escaped(child)
    );
    let _ = writeln!(text, "    <axis xyz=\"{}\"/>", numbers(&joint.axis));
    text += &limit(joint, kind, notes);
    text += &dynamics(friction).map_or(String::new(), |d| format!("    {d}\n"));
    text + "  </joint>\n"
}

/// URDF demands effort and velocity of every joint with a position limit, and one of every prismatic joint.
fn limit(joint: &Joint, kind: &str, notes: &mut Vec<String>) -> String {
    let limits = &joint.limits;
    let demanded = kind != "continuous";
    let mut attributes = String::new();
    let mut missing = Vec::new();
    for (name, value, substitute) in [
        ("lower", limits.lower, -NO_LIMIT),
        ("upper", limits.upper, NO_LIMIT),
        ("effort", limits.effort, NO_LIMIT),
        ("velocity", limits.velocity, NO_LIMIT),
    ] {
        let known = value.filter(|_| demanded || !["lower", "upper"].contains(&name));
        if known.is_none() && demanded {
            missing.push(name);
        }
        if let Some(value) = known.or(demanded.then_some(substitute)) {
            let _ = write!(attributes, " {name}=\"{value:?}\"");
        }
    }
    if !missing.is_empty() {
        let name = &joint.name;
        notes.push(format!("joint `{name}`: {} not known, {NO_LIMIT:e} written", missing.join(", ")));
    }
    if attributes.is_empty() { String::new() } else { format!("    <limit{attributes}/>\n") }
}

/// The `<dynamics>` element, where anything is known.
pub(super) fn dynamics(friction: &Friction) -> Option<String> {
    let attribute = |name: &str, value: Option<f64>| value.map(|v| format!(" {name}=\"{v:?}\""));
    let both = [attribute("damping", friction.viscous), attribute("friction", friction.coulomb)];
    let attributes: String = both.into_iter().flatten().collect();
    (!attributes.is_empty()).then(|| format!("<dynamics{attributes}/>"))
}

/// The `<inertial>` element, every line after the first `indent`.
pub(super) fn inertial(body: &Body, indent: &str) -> String {
    let i = &body.inertia;
    let tensor = [
        ("ixx", (0, 0)),
        ("ixy", (0, 1)),
        ("ixz", (0, 2)),
        ("iyy", (1, 1)),
        ("iyz", (1, 2)),
        ("izz", (2, 2)),
    ];
    let elements: String =
        tensor.iter().map(|(name, at)| format!(" {name}=\"{:?}\"", i[*at] + 0.0)).collect();
    format!(
        "{indent}<inertial>\n{indent}  <origin xyz=\"{}\" rpy=\"0 0 0\"/>\n{indent}  <mass value=\"{:?}\"/>\n{indent}  \
         <inertia{elements}/>\n{indent}</inertial>\n",
        numbers(&Vector3::from(body.com)),
        body.mass
    )
}

fn fixed(name: &str, parent: &str, pose: &Pose) -> String {
    let (name, parent) = (escaped(name), escaped(parent));
    format!(
        "  <joint name=\"{name}_fixed\" type=\"fixed\">\n    {}\n    <parent link=\"{parent}\"/>\n    \
         <child link=\"{name}\"/>\n  </joint>\n  <link name=\"{name}\"/>\n",
        origin(pose)
    )
}
