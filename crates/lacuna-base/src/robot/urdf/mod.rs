//! URDF: a tree of links on fixed and movable joints, turned into one link per movable joint.

mod element;
mod parse;
mod tree;
mod xml;

pub use parse::with_document;

use std::collections::HashMap;

use nalgebra::Vector3;

use super::kinematics::base_outwards;
use super::plausibility::far_for;
use super::{Frame, InertialParameters, Joint, Link, Pose, Robot};
use crate::error::Result;
use tree::Tree;
use xml::{Element, Source, XACRO, shortened};

/// Gravity of a URDF, which cannot say it [m/s²].
const GRAVITY: f64 = 9.81;

pub(super) fn read(text: &str) -> Result<Robot> {
    parse::with_document(text, |document| {
        let source = Source::new(document);
        let mut robot = read_robot(source.root())?;
        robot.remarks.extend(source.take_remarks());
        robot.remarks.sort_by_key(|remark| remark.line);
        Ok(robot)
    })
}

fn read_robot(root: Element) -> Result<Robot> {
    if root.tag() != "robot" {
        let text = format!("the root element is <{}>, not <robot>", root.tag());
        return Err(root.error(text).help("only URDF is read; convert SDF, MJCF or USD to URDF first"));
    }
    root.remark_on_unknown_children(&["link", "joint", "material", "transmission", "gazebo", "ros2_control"]);
    for element in root.descendants() {
        refuse_macro(element)?;
        refuse_escaping_file(element)?;
    }
    let tree = Tree::read(root)?;
    let bodies = Bodies::of(&tree);
    if bodies.joints.is_empty() {
        return Err(root
            .error("the robot has no movable joint, so it has no dynamics")
            .help("give at least one joint the type revolute, continuous or prismatic"));
    }
    let joints = bodies.moving_joints(&tree);
    let parents: Vec<_> = joints.iter().map(|joint| joint.parent).collect();
    let mut robot = Robot {
        name: root.attribute("name").map_or("robot", |name| name.text).into(),
        gravity: Vector3::new(0.0, 0.0, -GRAVITY),
        links: bodies.moving_links(&tree),
        order: base_outwards(&parents),
        frames: bodies.frames(&tree),
        joints,
        remarks: Vec::new(),
    };
    remark_on_inertias(&mut robot, &tree);
    Ok(robot)
}

fn refuse_macro(element: Element) -> Result<()> {
    if element.has_prefix("xacro") {
        return Err(element
            .error(format!("the file has xacro elements: <xacro:{}>", element.tag()))
            .help(XACRO));
    }
    Ok(())
}

/// Meshes are not needed here, but a file that points out of its own folder is not to be trusted
/// by whatever opens them. `package://`, `file://` and absolute paths are other programs' business.
/// Public packages keep `urdf/` and `meshes/` side by side, so `../meshes/..` is common; a step into a
/// neighbouring folder passes, since no mesh is ever opened.
fn refuse_escaping_file(element: Element) -> Result<()> {
    let Some(path) = element.attribute("filename") else { return Ok(()) };
    if !matches!(element.tag(), "mesh" | "texture") || path.text.contains("://") {
        return Ok(());
    }
    let mut depth = 0_i64;
    for part in path.text.trim().split(['/', '\\']) {
        depth += match part {
            "" | "." => 0,
            ".." => -1,
            _ => 1,
        };
        if depth < 0 && is_neighbouring_folder(path.text) {
            return Ok(());
        }
        if depth < 0 {
            let text = format!("the path \"{}\" leaves the folder of this file", shortened(path.text));
            let help =
                "move the file into the folder of the URDF, or write package://...; meshes are never opened";
            return Err(path.error(text).help(help));
        }
    }
    Ok(())
}

/// `../folder/file`, without any other way up.
fn is_neighbouring_folder(path: &str) -> bool {
    let parts: Vec<&str> = path.trim().split(['/', '\\']).collect();
    let up = parts.iter().filter(|p| **p == "..").count();
    parts.first() == Some(&"..") && up == 1 && parts.len() >= 3
}

/// Which moving body each link of the file belongs to.
struct Bodies {
    /// The movable joints, as indices into the file's joints.
    joints: Vec<usize>,
    /// For each link of the file: its moving link (`None` is the base) and its pose in there.
    places: Vec<(Option<usize>, Pose)>,
}

impl Bodies {
    fn of(tree: &Tree) -> Self {
        let joints: Vec<usize> = (0..tree.joints.len()).filter(|&i| tree.joints[i].kind.is_some()).collect();
        let mut number = vec![None; tree.joints.len()];
        joints.iter().enumerate().for_each(|(i, &joint)| number[joint] = Some(i));
        let mut places = vec![(None, Pose::identity()); tree.links.len()];
        for &link in &tree.outwards {
            let Some(incoming) = tree.incoming[link] else { continue };
            let joint = &tree.joints[incoming];
            places[link] = match number[incoming] {
                Some(moving) => (Some(moving), Pose::identity()),
                None => {
                    let (body, pose) = places[joint.parent];
                    (body, pose.then(&joint.origin))
                }
            };
        }
        Self { joints, places }
    }

    fn moving_joints(&self, tree: &Tree) -> Vec<Joint> {
        let joint = |&i: &usize| {
            let joint = &tree.joints[i];
            let (parent, pose) = self.places[joint.parent];
            Some(Joint {
                name: joint.name.into(),
                kind: joint.kind?,
                parent,
                before: pose.then(&joint.origin),
                axis: joint.axis,
                after: Pose::identity(),
                limits: joint.limits,
            })
        };
        self.joints.iter().filter_map(joint).collect()
    }

    fn moving_links(&self, tree: &Tree) -> Vec<Link> {
        let name = |&i: &usize| tree.links[tree.joints[i].child].name.into();
        let mut links: Vec<_> = self.joints.iter().map(|i| Link { name: name(i), inertia: None }).collect();
        for (part, (body, pose)) in tree.links.iter().zip(&self.places) {
            let (Some(body), Some(inertial)) = (body, &part.inertial) else { continue };
            let own = InertialParameters::from_barycentric(inertial.mass, inertial.com, inertial.inertia);
            let moved = if *pose == Pose::identity() { own } else { own.moved(pose) };
            let total = links[*body].inertia.map_or(moved, |sum| sum.combined(&moved));
            links[*body].inertia = Some(total);
        }
        links
    }

    /// Every link of the file that is not itself moved by a joint.
    fn frames(&self, tree: &Tree) -> Vec<Frame> {
        let is_moved =
            |link: usize| tree.incoming[link].is_some_and(|joint| tree.joints[joint].kind.is_some());
        let frame = |link: usize| {
            let (body, pose) = self.places[link];
            Frame { name: tree.links[link].name.into(), link: body, pose }
        };
        (0..tree.links.len()).filter(|&link| !is_moved(link)).map(frame).collect()
    }
}

/// Judges each `<inertial>` as written, before merging hides it, and names what is missing.
fn remark_on_inertias(robot: &mut Robot, tree: &Tree) {
    let far = far_for(robot);
    for link in &tree.links {
        if let Some(inertial) = &link.inertial {
            let body = inertial.body(link.name);
            robot.remarks.extend(body.remark(far, Some(inertial.line)));
        }
    }
    let moved: HashMap<&str, &Link> = robot.links.iter().map(|link| (link.name.as_str(), link)).collect();
    for part in tree.links.iter().filter(|part| part.inertial.is_none()) {
        let Some(link) = moved.get(part.name) else { continue };
        part.element.remark(match link.inertia {
            None => format!("link `{}` has no inertia, nor has anything fixed to it", part.name),
            Some(_) => {
                format!("link `{}` has no inertia of its own, only what is fixed to it counts", part.name)
            }
        });
    }
}
