//! What the elements of a URDF mean: origins, inertias, joints.

use nalgebra::{Matrix3, Vector3};

use super::xml::{Attribute, Element};
use crate::error::Result;
use crate::robot::kinematics::from_roll_pitch_yaw;
use crate::robot::plausibility::Body;
use crate::robot::{JointKind, Limits, Pose};

/// An `<inertial>`: mass, and inertia about the centre of mass in the axes of the link frame.
pub struct Inertial {
    pub mass: f64,
    pub com: Vector3<f64>,
    pub inertia: Matrix3<f64>,
    pub line: usize,
}

impl Inertial {
    pub fn read(element: Element) -> Result<Self> {
        element.remark_on_unknown_children(&["origin", "mass", "inertia"]);
        let origin = origin(element)?;
        let remedy = "complete it, or remove the whole <inertial> when nothing is known";
        let mass = element.required_child("mass").map_err(|e| e.help(remedy))?;
        let mass = mass.required("value")?.number()?;
        let tensor = element.required_child("inertia").map_err(|e| e.help(remedy))?;
        let [xx, xy, xz, yy, yz, zz] =
            ["ixx", "ixy", "ixz", "iyy", "iyz", "izz"].map(|name| tensor.required(name)?.number());
        let (xy, xz, yz) = (xy?, xz?, yz?);
        let local = Matrix3::new(xx?, xy, xz, xy, yy?, yz, xz, yz, zz?);
        let inertia = if origin.rotation == Matrix3::identity() {
            local
        } else {
            origin.rotation * local * origin.rotation.transpose()
        };
        Ok(Self { mass, com: origin.translation, inertia, line: element.line() })
    }

    pub fn body<'a>(&self, name: &'a str) -> Body<'a> {
        Body { name, mass: self.mass, com: self.com, inertia: self.inertia }
    }
}

/// The pose in an element's `<origin xyz rpy>`; identity where there is none.
pub fn origin(element: Element) -> Result<Pose> {
    let Some(origin) = element.child("origin") else { return Ok(Pose::identity()) };
    if let Some(quaternion) = origin.attribute("quat_xyzw") {
        return Err(quaternion
            .error("orientations as quaternions are not read")
            .help("write it as rpy=\"roll pitch yaw\""));
    }
    origin.remark_on_unknown_attributes(&["xyz", "rpy"]);
    let triple = |name| origin.attribute(name).map_or(Ok(Vector3::zeros()), |a: Attribute| a.triple());
    Ok(Pose { translation: triple("xyz")?, rotation: from_roll_pitch_yaw(&triple("rpy")?) })
}

/// The kind of a joint; `None` is a fixed one.
pub fn kind(joint: Element) -> Result<Option<JointKind>> {
    let kind = joint.required("type")?;
    match kind.text {
        "revolute" | "continuous" => Ok(Some(JointKind::Revolute)),
        "prismatic" => Ok(Some(JointKind::Prismatic)),
        "fixed" => Ok(None),
        "floating" | "planar" => Err(kind
            .error(format!(
                "a {} joint has more than one degree of freedom, which is not supported",
                kind.text
            ))
            .help("describe a robot on a fixed base with revolute, continuous, prismatic and fixed joints")),
        other => Err(kind
            .error(format!("`{other}` is not a type of joint"))
            .help("the types are revolute, continuous, prismatic and fixed")),
    }
}

/// The unit axis of a movable joint, in the joint frame; x where the file says nothing.
pub fn axis(joint: Element) -> Result<Vector3<f64>> {
    let Some(axis) = joint.child("axis") else { return Ok(Vector3::x()) };
    axis.remark_on_unknown_attributes(&["xyz"]);
    let xyz = axis.required("xyz")?;
    let direction = xyz.triple()?;
    let size = direction.amax();
    if size < 1e-9 {
        let text = format!("the axis of a joint has no direction: \"{}\"", xyz.text);
        return Err(xyz.error(text).help("write a direction, such as 0 0 1"));
    }
    // Scaled first, so that squares neither over- nor underflow; a unit axis stays what it was.
    let unit = direction / size;
    Ok(unit / unit.norm())
}

/// Limits of a movable joint. `continuous` joints have no position limits, whatever the file says.
pub fn limits(joint: Element) -> Result<Limits> {
    let Some(limit) = joint.child("limit") else { return Ok(Limits::default()) };
    let value = |name| limit.attribute(name).map_or(Ok(None), |a: Attribute| a.limit());
    let mut limits = Limits {
        lower: value("lower")?,
        upper: value("upper")?,
        velocity: value("velocity")?,
        effort: value("effort")?,
    };
    if joint.required("type")?.text == "continuous" {
        (limits.lower, limits.upper) = (None, None);
    }
    if let (Some(lower), Some(upper)) = (limits.lower, limits.upper)
        && lower > upper
    {
        let text = format!("the lower limit {lower} is above the upper limit {upper}");
        return Err(limit.required("lower")?.error(text).help("swap them"));
    }
    Ok(limits)
}

/// Refuses `<mimic>`: two joints that share one motor are not two degrees of freedom.
pub fn refuse_mimic(joint: Element) -> Result<()> {
    let Some(mimic) = joint.child("mimic") else { return Ok(()) };
    let name = joint.required("name")?.text;
    Err(mimic
        .error(format!("joint `{name}` mimics another one, which is not supported"))
        .help("make it fixed to treat it as rigid, or remove the <mimic> to treat it as a joint of its own"))
}

/// Says that `<dynamics>` is not used: friction is identified, not taken from a file.
pub fn remark_on_dynamics(joint: Element) -> Result<()> {
    let Some(dynamics) = joint.child("dynamics") else { return Ok(()) };
    let mut given = Vec::new();
    for name in ["damping", "friction"] {
        let Some(attribute) = dynamics.attribute(name) else { continue };
        if attribute.number()? != 0.0 {
            given.push(format!("{name}={}", attribute.text.trim()));
        }
    }
    if !given.is_empty() {
        let name = joint.required("name")?.text;
        dynamics.remark(format!("joint `{name}`: {} not added to the dynamics", given.join(" and ")));
    }
    Ok(())
}
