//! Facts about a robot.

use serde::Serialize;

use super::report::{Section, number};
use crate::identify::BaseParameters;
use crate::report::finite;
use crate::robot::{JointKind, Robot};

/// What a robot file says.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RobotFacts {
    /// Name.
    pub name: String,
    /// Gravity in the base frame [m/s²].
    pub gravity: [f64; 3],
    /// Joints in the order of the file.
    pub joints: Vec<JointFacts>,
    /// Mass of all links that have one \[kg\].
    pub total_mass: f64,
    /// Links without inertia.
    pub without_inertia: Vec<String>,
    /// Frames kept by name, and the link that carries them (`base` for none).
    pub frames: Vec<(String, String)>,
    /// Identifiable combinations of link parameters.
    pub base_parameters: Vec<String>,
}

/// A joint and the link it moves.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct JointFacts {
    /// Name.
    pub name: String,
    /// `revolute` or `prismatic`.
    pub kind: &'static str,
    /// Name of the joint that carries it, or `base`.
    pub parent: String,
    /// Axis in the base frame at zero position.
    pub axis: [f64; 3],
    /// Smallest and largest position [rad, m].
    pub position: [Option<f64>; 2],
    /// Largest speed [rad/s, m/s].
    pub velocity: Option<f64>,
    /// Largest torque or force [N m, N].
    pub effort: Option<f64>,
    /// Mass of the link \[kg\].
    pub mass: Option<f64>,
}

impl RobotFacts {
    pub(super) fn new(robot: &Robot) -> Self {
        let zero = vec![0.0; robot.dof()];
        let name = |j: Option<usize>| j.map_or("base".to_string(), |j| robot.joints[j].name.clone());
        let joint = |j: usize| {
            let joint = &robot.joints[j];
            let turned = robot.link_pose(&zero, j).rotation * joint.after.rotation.transpose() * joint.axis;
            JointFacts {
                name: joint.name.clone(),
                kind: if joint.kind == JointKind::Revolute { "revolute" } else { "prismatic" },
                parent: name(joint.parent),
                axis: turned.into(),
                position: [joint.limits.lower, joint.limits.upper],
                velocity: joint.limits.velocity,
                effort: joint.limits.effort,
                mass: robot.links[j].inertia.and_then(|i| finite(i.mass())),
            }
        };
        let base = BaseParameters::new(robot);
        let carrier = |link: Option<usize>| link.map_or("base".to_string(), |l| robot.links[l].name.clone());
        Self {
            name: robot.name.clone(),
            gravity: robot.gravity.into(),
            joints: (0..robot.dof()).map(joint).collect(),
            total_mass: robot.links.iter().filter_map(|l| l.inertia.map(|i| i.mass())).sum(),
            without_inertia: robot
                .links
                .iter()
                .filter(|l| l.inertia.is_none())
                .map(|l| l.name.clone())
                .collect(),
            frames: robot.frames.iter().map(|f| (f.name.clone(), carrier(f.link))).collect(),
            base_parameters: (0..base.rank()).map(|i| base.expression(i)).collect(),
        }
    }

    pub(super) fn sections(&self) -> Vec<Section> {
        let mut lines = vec![format!(
            "`{}`, {} joints, gravity ({}) m/s2",
            self.name,
            self.joints.len(),
            self.gravity.map(|g| number(g, 6)).join(", ")
        )];
        match self.joints.len() - self.without_inertia.len() {
            0 => lines.push("no inertias in the file; an identification finds them".into()),
            _ => lines.push(format!("{:.3} kg moving", self.total_mass)),
        }
        if !self.without_inertia.is_empty() && self.without_inertia.len() < self.joints.len() {
            lines.push(format!("no inertia: {}", self.without_inertia.join(", ")));
        }
        let frames: Vec<String> = self.frames.iter().map(|(f, l)| format!("{f} on {l}")).collect();
        if !frames.is_empty() {
            lines.push(format!("frames kept: {}", frames.join(", ")));
        }
        let count = self.base_parameters.len();
        let title = format!("{count} base parameters (all that joint torque can reveal)");
        vec![
            Section::wrapped("robot", lines),
            Section::table("joints (on: carried by; axis in the base frame at zero position)", self.table()),
            Section::wrapped(title, self.base_parameters.clone()),
        ]
    }

    fn table(&self) -> Vec<String> {
        let width = self.joints.iter().map(|j| j.name.chars().count()).max().unwrap_or(0).clamp(5, 19);
        let mut lines = vec![format!(
            "    {:<width$}  kind  {:>4} {:>17} {:>15} {:>7}",
            "name", "on", "axis", "range rad, m", "kg"
        )];
        for (i, j) in self.joints.iter().enumerate() {
            let parent = self.joints.iter().position(|k| k.name == j.parent);
            let limit = |x: Option<f64>| x.map_or("-".to_string(), |x| number(x, 3));
            let range = match j.position {
                [None, None] => "no limits".to_string(),
                [low, high] => format!("{}..{}", limit(low), limit(high)),
            };
            lines.push(format!(
                "{:>2}  {:<width$}  {}  {:>4} {:>17} {:>15} {:>7}",
                i + 1,
                cut(&j.name, width),
                if j.kind == "revolute" { "turn" } else { "push" },
                parent.map_or("base".to_string(), |p| (p + 1).to_string()),
                cut(&j.axis.map(|a| number(a, 2)).join(" "), 17),
                cut(&range, 15),
                j.mass.map_or("-".to_string(), |m| format!("{m:.3}")),
            ));
        }
        lines
    }
}

fn cut(text: &str, width: usize) -> String {
    if text.chars().count() <= width {
        return text.to_string();
    }
    text.chars().take(width - 2).chain("..".chars()).collect()
}
