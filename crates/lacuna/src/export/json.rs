//! All that a model says, as one JSON document.

use nalgebra::Matrix3;
use serde::Serialize;

use super::Exported;
use super::parameters::Parameters;
use crate::error::{Error, Result};
use crate::model_file::{ModelFile, ParameterValue};
use crate::robot::{InertialParameters, JointKind, PARAMETER_NAMES, Pose, Robot};

#[derive(Serialize)]
struct Document<'a> {
    lacuna: &'static str,
    robot: &'a str,
    origin: &'a str,
    /// m/s², base frame.
    gravity: [f64; 3],
    links: Vec<Link<'a>>,
    joints: Vec<Joint<'a>>,
    effects: Vec<&'static str>,
    /// Every parameter that is not a link's.
    parameters: Vec<&'a ParameterValue>,
}

/// Inertia about the centre of mass as `[xx, xy, xz, yy, yz, zz]`, `parameters` about the link origin; all
/// in the link frame.
#[derive(Serialize)]
struct Link<'a> {
    name: &'a str,
    mass: f64,
    com: Option<[f64; 3]>,
    inertia: Option<[f64; 6]>,
    parameters: serde_json::Map<String, serde_json::Value>,
}

/// Parent link frame, then `before`, motion along or about `axis`, then `after` leads to the link frame.
#[derive(Serialize)]
struct Joint<'a> {
    name: &'a str,
    kind: &'static str,
    parent: Option<&'a str>,
    link: &'a str,
    before: Place,
    axis: [f64; 3],
    after: Place,
    lower: Option<f64>,
    upper: Option<f64>,
    velocity: Option<f64>,
    effort: Option<f64>,
}

/// `rotation` by rows.
#[derive(Serialize)]
struct Place {
    rotation: [[f64; 3]; 3],
    translation: [f64; 3],
}

impl From<&Pose> for Place {
    fn from(pose: &Pose) -> Self {
        Self { rotation: rows(&pose.rotation), translation: pose.translation.into() }
    }
}

fn rows(m: &Matrix3<f64>) -> [[f64; 3]; 3] {
    std::array::from_fn(|i| std::array::from_fn(|k| m[(i, k)]))
}

/// Writes a JSON document with links, kinematics and every other parameter of the model.
///
/// # Errors
/// When a number cannot be written.
pub fn json(robot: &Robot, parameters: &Parameters, file: &ModelFile) -> Result<Exported> {
    let is_rigid = |p: &&ParameterValue| {
        (0..10 * robot.links.len()).any(|i| crate::identify::parameter_name(i) == p.symbol)
    };
    let document = Document {
        lacuna: env!("CARGO_PKG_VERSION"),
        robot: &robot.name,
        origin: &file.origin,
        gravity: robot.gravity.into(),
        links: robot.links.iter().zip(&parameters.links).map(|(about, p)| link(&about.name, p)).collect(),
        joints: (0..robot.dof()).map(|i| joint(robot, i)).collect(),
        effects: file.effects.iter().map(|e| e.about().name).collect(),
        parameters: file.parameters.iter().filter(|p| !is_rigid(p)).collect(),
    };
    let text =
        serde_json::to_string_pretty(&document).map_err(|e| Error::new(format!("cannot write JSON: {e}")))?;
    Ok(Exported { text: text + "\n", notes: Vec::new() })
}

fn link<'a>(name: &'a str, p: &InertialParameters) -> Link<'a> {
    let values = PARAMETER_NAMES.iter().zip(p.as_slice());
    Link {
        name,
        mass: p.mass(),
        com: p.center_of_mass().map(Into::into),
        inertia: p
            .inertia_at_center_of_mass()
            .map(|i| [i[(0, 0)], i[(0, 1)], i[(0, 2)], i[(1, 1)], i[(1, 2)], i[(2, 2)]]),
        parameters: values.map(|(name, value)| (name.to_string(), (*value).into())).collect(),
    }
}

fn joint(robot: &Robot, i: usize) -> Joint<'_> {
    let joint = &robot.joints[i];
    Joint {
        name: &joint.name,
        kind: match joint.kind {
            JointKind::Revolute => "revolute",
            JointKind::Prismatic => "prismatic",
        },
        parent: joint.parent.map(|p| robot.links[p].name.as_str()),
        link: &robot.links[i].name,
        before: (&joint.before).into(),
        axis: joint.axis.into(),
        after: (&joint.after).into(),
        lower: joint.limits.lower,
        upper: joint.limits.upper,
        velocity: joint.limits.velocity,
        effort: joint.limits.effort,
    }
}
