//! New inertias in the text of the URDF that a robot came from; everything else stays byte for byte.

use std::ops::Range;

use roxmltree::{Document, Node};

use super::Exported;
use super::fresh::{dynamics, inertial};
use super::parameters::{Friction, Parameters};
use super::xml::in_comment;
use crate::error::{Error, Result};
use crate::robot::{Robot, with_urdf_document};

/// A piece of the text and what stands there instead.
type Edit = (Range<usize>, String);

pub(super) fn urdf(robot: &Robot, parameters: &Parameters, original: &str) -> Result<Exported> {
    let original = original.strip_prefix('\u{feff}').unwrap_or(original);
    let mut notes = Vec::new();
    let mut edits = with_urdf_document(original, |document| {
        if document.input_text().len() != original.len() {
            return Err(Error::new("the URDF has slips that were mended while reading")
                .help("save it as well-formed XML first"));
        }
        let mut writer = Writer { robot, parameters, original, edits: Vec::new(), notes: &mut notes };
        writer.all(document)?;
        Ok(writer.edits)
    })?;
    edits.sort_by_key(|(range, _)| range.start);
    let mut text = String::with_capacity(original.len() + 4096);
    let mut done = 0;
    for (range, new) in &edits {
        text.push_str(&original[done..range.start]);
        text.push_str(new);
        done = range.end;
    }
    text.push_str(&original[done..]);
    notes.push("paths of meshes are as in the original: keep the new file in its folder".into());
    Ok(Exported { text, notes })
}

struct Writer<'a> {
    robot: &'a Robot,
    parameters: &'a Parameters,
    original: &'a str,
    edits: Vec<Edit>,
    notes: &'a mut Vec<String>,
}

impl Writer<'_> {
    fn all(&mut self, document: &Document) -> Result<()> {
        let root = document.root_element();
        let about = format!(
            "inertias (and friction, where it was identified) by lacuna {}; moving links include what is fixed to them",
            env!("CARGO_PKG_VERSION")
        );
        let start = root.range().start;
        self.edits.push((start..start, format!("<!-- {} -->\n", in_comment(&about))));
        let named = |tag: &'static str| {
            root.children()
                .filter(move |n| n.tag_name().name() == tag)
                .filter_map(|n| Some((n.attribute("name")?, n)))
        };
        let mut merged = Vec::new();
        for (index, link) in self.robot.links.iter().enumerate() {
            let Some((_, node)) = named("link").find(|(name, _)| *name == link.name) else {
                return Err(Error::new(format!("the URDF has no link `{}`", link.name))
                    .help("give the file that the robot was read from"));
            };
            self.moving_link(node, index)?;
        }
        for frame in self.robot.frames.iter().filter(|f| f.link.is_some()) {
            let node = named("link").find(|(name, _)| *name == frame.name).map(|(_, node)| node);
            let own = node.and_then(|node| node.children().find(|n| n.tag_name().name() == "inertial"));
            if let (Some(own), Some(link)) = (own, frame.link) {
                let host = &self.robot.links[link].name;
                let comment = format!("<!-- inertia is part of link `{}` -->", in_comment(host));
                self.edits.push((own.range(), comment));
                merged.push(frame.name.as_str());
            }
        }
        if !merged.is_empty() {
            let list = merged.join(", ");
            self.notes.push(format!("their inertia is part of the moving link they are fixed to: {list}"));
        }
        let friction = self.parameters.usable_friction(self.robot, self.notes);
        for (joint, friction) in self.robot.joints.iter().zip(friction) {
            if let Some((_, node)) = named("joint").find(|(name, _)| *name == joint.name) {
                self.joint(node, friction);
            }
        }
        Ok(())
    }

    fn moving_link(&mut self, node: Node, index: usize) -> Result<()> {
        let body = self.parameters.body(self.robot, index, &self.parameters.links[index])?;
        match node.children().find(|n| n.tag_name().name() == "inertial") {
            Some(old) => {
                let indent = self.indent(old.range().start);
                let new = inertial(&body, &indent);
                self.edits.push((old.range(), new.trim().to_string()));
            }
            None => {
                let indent = self.indent(node.range().start);
                let new = inertial(&body, &format!("{indent}  "));
                self.insert(node, new.trim_end(), &indent);
            }
        }
        Ok(())
    }

    /// Damping and friction, other attributes kept.
    fn joint(&mut self, node: Node, friction: Friction) {
        let old = node.children().find(|n| n.tag_name().name() == "dynamics");
        let kept = |name: &str| old?.attribute(name)?.trim().parse::<f64>().ok().filter(|x| x.is_finite());
        if friction == Friction::default() {
            return;
        }
        let all = Friction {
            viscous: friction.viscous.or_else(|| kept("damping")),
            coulomb: friction.coulomb.or_else(|| kept("friction")),
        };
        let Some(new) = dynamics(&all) else { return };
        match old {
            Some(old) => self.edits.push((old.range(), new)),
            None => {
                let indent = self.indent(node.range().start);
                self.insert(node, &format!("{indent}  {new}"), &indent);
            }
        }
    }

    /// Lines as the last child of an element.
    fn insert(&mut self, node: Node, lines: &str, indent: &str) {
        let range = node.range();
        let element = &self.original[range.clone()];
        if element.ends_with("/>") {
            let tag = node.tag_name().name();
            self.edits.push((range.end - 2..range.end, format!(">\n{lines}\n{indent}</{tag}>")));
        } else if let Some(closing) = element.rfind("</") {
            // Before the white space that the closing tag is indented with.
            let at = range.start + element[..closing].trim_end().len();
            self.edits.push((at..range.start + closing, format!("\n{lines}\n{indent}")));
        }
    }

    /// The white space that the line of a position begins with.
    fn indent(&self, position: usize) -> String {
        let line = self.original[..position].rfind('\n').map_or(0, |i| i + 1);
        self.original[line..position].chars().take_while(|c| c.is_whitespace()).collect()
    }
}
