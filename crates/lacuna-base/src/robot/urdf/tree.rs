//! Links and joints of a URDF as a tree, checked to be one.

use std::collections::HashMap;

use nalgebra::Vector3;

use super::element::{self, Inertial};
use super::xml::{Attribute, Element};
use crate::error::{Error, Result};
use crate::robot::{JointKind, Limits, Pose};

/// A `<link>` as written.
pub struct FileLink<'a> {
    pub name: &'a str,
    pub inertial: Option<Inertial>,
    pub element: Element<'a>,
}

/// A `<joint>` as written, its links by index.
pub struct FileJoint<'a> {
    pub name: &'a str,
    /// `None` is a fixed joint.
    pub kind: Option<JointKind>,
    pub parent: usize,
    pub child: usize,
    pub origin: Pose,
    pub axis: Vector3<f64>,
    pub limits: Limits,
    element: Element<'a>,
}

/// All links and joints of a file, known to form one tree.
pub struct Tree<'a> {
    pub links: Vec<FileLink<'a>>,
    pub joints: Vec<FileJoint<'a>>,
    /// The joint that each link hangs on; `None` for the root.
    pub incoming: Vec<Option<usize>>,
    /// Link indices from the root outwards.
    pub outwards: Vec<usize>,
}

impl<'a> Tree<'a> {
    pub fn read(robot: Element<'a>) -> Result<Self> {
        let links = robot.children("link").map(read_link).collect::<Result<Vec<_>>>()?;
        if links.is_empty() {
            return Err(robot
                .error("the robot has no <link>")
                .help("a URDF lists <link> and <joint> elements directly in <robot> (an SRDF does not)"));
        }
        let index = by_name(links.iter().map(|link| (link.name, link.element)))?;
        let joints = robot.children("joint").map(|e| read_joint(e, &index)).collect::<Result<Vec<_>>>()?;
        by_name(joints.iter().map(|joint| (joint.name, joint.element)))?;
        let incoming = incoming_joints(&links, &joints)?;
        let outwards = outwards(&links, &joints, &incoming)?;
        Ok(Self { links, joints, incoming, outwards })
    }
}

fn read_link(element: Element<'_>) -> Result<FileLink<'_>> {
    const KNOWN: [&str; 6] =
        ["inertial", "visual", "collision", "collision_checking", "self_collision_checking", "contact"];
    element.remark_on_unknown_children(&KNOWN);
    let inertial = element.child("inertial").map(Inertial::read).transpose()?;
    Ok(FileLink { name: name(element)?, inertial, element })
}

fn read_joint<'a>(element: Element<'a>, links: &HashMap<&str, usize>) -> Result<FileJoint<'a>> {
    const KNOWN: [&str; 9] = [
        "origin",
        "parent",
        "child",
        "axis",
        "limit",
        "dynamics",
        "mimic",
        "calibration",
        "safety_controller",
    ];
    element.remark_on_unknown_children(&KNOWN);
    let name = name(element)?;
    let kind = element::kind(element)?;
    let end = |tag| find_link(element.required_child(tag)?.required("link")?, links);
    let (parent, child) = (end("parent")?, end("child")?);
    let origin = element::origin(element)?;
    // A fixed joint has no motion; exporters still write axes (often 0 0 0), limits and the like.
    let (mut axis, mut limits) = (Vector3::x(), Limits::default());
    if kind.is_some() {
        element::refuse_mimic(element)?;
        element::remark_on_dynamics(element)?;
        (axis, limits) = (element::axis(element)?, element::limits(element)?);
    }
    Ok(FileJoint { name, kind, parent, child, origin, axis, limits, element })
}

fn name(element: Element<'_>) -> Result<&str> {
    let name = element.required("name")?;
    if name.text.trim().is_empty() {
        return Err(name.error(format!("a <{}> has an empty name", element.tag())).help("give it a name"));
    }
    Ok(name.text)
}

/// Index by name, which must be unique.
fn by_name<'a>(all: impl Iterator<Item = (&'a str, Element<'a>)>) -> Result<HashMap<&'a str, usize>> {
    let mut index = HashMap::new();
    let mut lines = Vec::new();
    for (i, (name, element)) in all.enumerate() {
        lines.push(element.line());
        if let Some(first) = index.insert(name, i) {
            let text =
                format!("two {}s are called `{name}`, the first in line {}", element.tag(), lines[first]);
            let help = "rename one of them and what refers to it";
            return Err(element.required("name")?.error(text).help(help));
        }
    }
    Ok(index)
}

fn find_link(reference: Attribute, links: &HashMap<&str, usize>) -> Result<usize> {
    links.get(reference.text).copied().ok_or_else(|| {
        let mut known: Vec<_> = links.iter().map(|(name, &i)| (i, *name)).collect();
        known.sort_unstable();
        let more = if known.len() > 12 { ", ..." } else { "" };
        let names: Vec<_> = known.iter().take(12).map(|(_, name)| *name).collect();
        reference
            .error(format!("there is no link called `{}`", reference.text))
            .help(format!("the links of this file are {}{more}", names.join(", ")))
    })
}

fn incoming_joints(links: &[FileLink], joints: &[FileJoint]) -> Result<Vec<Option<usize>>> {
    let mut incoming = vec![None; links.len()];
    for (i, joint) in joints.iter().enumerate() {
        if let Some(first) = incoming[joint.child].replace(i) {
            let first: &FileJoint = &joints[first];
            let text = format!(
                "link `{}` hangs on two joints, `{}` (line {}) and `{}`",
                links[joint.child].name,
                first.name,
                first.element.line(),
                joint.name
            );
            let place = joint.element.required_child("child")?.required("link")?;
            let help = "a tree has one joint per link; closed kinematic chains are not supported";
            return Err(place.error(text).help(help));
        }
    }
    Ok(incoming)
}

/// Links from the root outwards; an error where they are no tree.
fn outwards(links: &[FileLink], joints: &[FileJoint], incoming: &[Option<usize>]) -> Result<Vec<usize>> {
    let mut children = vec![Vec::new(); links.len()];
    joints.iter().for_each(|joint| children[joint.parent].push(joint.child));
    let mut roots = (0..links.len()).filter(|&i| incoming[i].is_none());
    let root = roots.next();
    if let (Some(root), Some(second)) = (root, roots.next()) {
        let text = format!("links `{}` and `{}` both hang on no joint", links[root].name, links[second].name);
        let help =
            "a robot has one root: add the missing joint, or move the other parts to a file of their own";
        return Err(links[second].element.error(text).help(help));
    }
    let mut order = Vec::from_iter(root);
    let mut done = 0;
    while let Some(&link) = order.get(done) {
        order.extend(&children[link]);
        done += 1;
    }
    if order.len() < links.len() {
        return Err(loop_error(&order, joints, incoming));
    }
    Ok(order)
}

/// Names a joint on the loop that keeps some links from the root.
fn loop_error(reached: &[usize], joints: &[FileJoint], incoming: &[Option<usize>]) -> Error {
    let mut lost = vec![true; incoming.len()];
    reached.iter().for_each(|&link| lost[link] = false);
    let up = |link: usize| incoming[link].map_or(link, |joint| joints[joint].parent);
    // Whoever climbs long enough from a link that the root does not reach ends up on the loop.
    let start = lost.iter().position(|&lost| lost).unwrap_or(0);
    let on_loop = (0..incoming.len()).fold(start, |link, _| up(link));
    let round = std::iter::successors(Some(on_loop), |&link| Some(up(link)).filter(|&next| next != on_loop));
    let mut names: Vec<usize> = round.filter_map(|link| incoming[link]).collect();
    names.sort_unstable();
    let list: Vec<_> = names.iter().take(6).map(|&joint| format!("`{}`", joints[joint].name)).collect();
    let text = format!("the joints {} form a loop", list.join(", "));
    let help = "a robot is a tree that hangs on one base link: check parent and child of these joints";
    joints[names[0]].element.error(text).help(help)
}
