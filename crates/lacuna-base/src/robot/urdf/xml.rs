//! Elements, attributes and numbers of an XML text, each of which can say where it stands.

use std::cell::RefCell;
use std::collections::BTreeSet;

use nalgebra::Vector3;
use roxmltree::{Document, Node};

use crate::error::{Error, Result};
use crate::robot::{LARGEST_NUMBER, Remark};

/// A parsed document, the places of its lines, and the remarks made while reading it.
pub struct Source<'a> {
    document: &'a Document<'a>,
    line_starts: Vec<usize>,
    remarks: RefCell<Vec<Remark>>,
    ignored: RefCell<BTreeSet<(&'a str, &'a str)>>,
}

impl<'a> Source<'a> {
    pub fn new(document: &'a Document<'a>) -> Self {
        let ends = document.input_text().match_indices('\n');
        let line_starts = std::iter::once(0).chain(ends.map(|(i, _)| i + 1)).collect();
        Self { document, line_starts, remarks: RefCell::default(), ignored: RefCell::default() }
    }

    pub fn root(&'a self) -> Element<'a> {
        Element { node: self.document.root_element(), source: self }
    }

    pub fn take_remarks(&self) -> Vec<Remark> {
        self.remarks.take()
    }

    fn line(&self, offset: usize) -> usize {
        self.line_starts.partition_point(|&start| start <= offset)
    }

    fn error(&self, offset: usize, text: String) -> Error {
        let line = self.line(offset);
        let before = &self.document.input_text()[self.line_starts[line - 1]..offset];
        Error::new(text).at(line, 1 + before.chars().count())
    }
}

/// An element and the document it is from.
#[derive(Clone, Copy)]
pub struct Element<'a> {
    node: Node<'a, 'a>,
    source: &'a Source<'a>,
}

impl<'a> Element<'a> {
    pub fn tag(&self) -> &'a str {
        self.node.tag_name().name()
    }

    pub fn line(&self) -> usize {
        self.source.line(self.node.range().start)
    }

    pub fn error(&self, text: impl Into<String>) -> Error {
        self.source.error(self.node.range().start, text.into())
    }

    pub fn remark(&self, text: impl Into<String>) {
        self.source.remarks.borrow_mut().push(Remark { line: Some(self.line()), text: text.into() });
    }

    /// Everything below this element, this element included, whatever its namespace.
    pub fn descendants(&self) -> impl Iterator<Item = Element<'a>> + use<'a> {
        let source = self.source;
        self.node.descendants().filter(Node::is_element).map(move |node| Element { node, source })
    }

    /// Is this element in the namespace called or declared for `prefix`?
    pub fn has_prefix(&self, prefix: &str) -> bool {
        let namespace = self.node.tag_name().namespace();
        namespace.is_some_and(|uri| self.node.lookup_prefix(uri) == Some(prefix))
    }

    /// The children in the root's own namespace: foreign ones are extensions of other tools.
    fn own_children(&self) -> impl Iterator<Item = Element<'a>> + use<'a> {
        let source = self.source;
        let namespace = source.document.root_element().tag_name().namespace();
        let own = move |node: &Node| node.is_element() && node.tag_name().namespace() == namespace;
        self.node.children().filter(own).map(move |node| Element { node, source })
    }

    pub fn children(&self, tag: &'static str) -> impl Iterator<Item = Element<'a>> + use<'a> {
        self.own_children().filter(move |child| child.tag() == tag)
    }

    /// The first child of this name; further ones are ignored, with a remark.
    pub fn child(&self, tag: &'static str) -> Option<Element<'a>> {
        let mut all = self.children(tag);
        let first = all.next();
        if let Some(second) = all.next() {
            second.remark(format!("a second <{tag}> in one <{}> is ignored", self.tag()));
        }
        first
    }

    pub fn required_child(&self, tag: &'static str) -> Result<Element<'a>> {
        let missing = || self.error(format!("{} has no <{tag}>", self.described()));
        self.child(tag).ok_or_else(missing).map_err(|e| e.help(format!("add a <{tag}> element to it")))
    }

    /// Remarks once on each kind of child that is not in `known`: it might be a slip of the pen.
    pub fn remark_on_unknown_children(&self, known: &[&str]) {
        for child in self.own_children().filter(|c| !known.contains(&c.tag())) {
            if self.source.ignored.borrow_mut().insert((self.tag(), child.tag())) {
                child.remark(format!("<{}> in a <{}> is not read by this program", child.tag(), self.tag()));
            }
        }
    }

    /// Remarks once on each kind of attribute that is not in `known`.
    pub fn remark_on_unknown_attributes(&self, known: &[&str]) {
        let foreign = |a: &roxmltree::Attribute| a.namespace().is_none() && !known.contains(&a.name());
        for attribute in self.node.attributes().filter(foreign) {
            if self.source.ignored.borrow_mut().insert((self.tag(), attribute.name())) {
                self.remark(format!(
                    "attribute `{}` of <{}> is not read by this program",
                    attribute.name(),
                    self.tag()
                ));
            }
        }
    }

    pub fn attribute(&self, name: &'static str) -> Option<Attribute<'a>> {
        let attribute = self.node.attribute_node(name)?;
        Some(Attribute { name, text: attribute.value(), offset: attribute.range().start, element: *self })
    }

    pub fn required(&self, name: &'static str) -> Result<Attribute<'a>> {
        self.attribute(name).ok_or_else(|| {
            let help = format!("write <{} {name}=\"...\">", self.tag());
            self.error(format!("{} has no attribute `{name}`", self.described())).help(help)
        })
    }

    /// The tag, with the name where there is one.
    fn described(&self) -> String {
        let name = self.node.attribute("name").map(|name| format!(" `{name}`"));
        format!("<{}>{}", self.tag(), name.unwrap_or_default())
    }
}

/// An attribute and the element it is from.
#[derive(Clone, Copy)]
pub struct Attribute<'a> {
    name: &'static str,
    pub text: &'a str,
    offset: usize,
    element: Element<'a>,
}

impl Attribute<'_> {
    pub fn error(&self, text: impl Into<String>) -> Error {
        self.element.source.error(self.offset, text.into())
    }

    fn not(&self, what: &str) -> Error {
        let text =
            format!("{}=\"{}\" in <{}> is not {what}", self.name, shortened(self.text), self.element.tag());
        let help = if self.text.contains("${") || self.text.contains("$(") {
            XACRO
        } else if self.text.contains(',') {
            "write decimals with a point and separate numbers by spaces: 0.5 0 1.2"
        } else {
            "write plain finite decimal numbers separated by spaces, such as 0.5 or 1e-3, in SI units"
        };
        self.error(text).help(help)
    }

    /// A finite number.
    pub fn number(&self) -> Result<f64> {
        let x = self.text.trim().parse::<f64>().ok();
        x.filter(|x| x.abs() <= LARGEST_NUMBER).ok_or_else(|| self.not("a finite number"))
    }

    /// A number, or nothing where infinity says that there is no limit.
    pub fn limit(&self) -> Result<Option<f64>> {
        let x = self.text.trim().parse::<f64>().ok().filter(|x| !x.is_nan());
        x.map(|x| Some(x).filter(|x| x.is_finite())).ok_or_else(|| self.not("a number"))
    }

    /// Three finite numbers.
    pub fn triple(&self) -> Result<Vector3<f64>> {
        let parse = |word: &str| word.parse::<f64>().ok().filter(|x| x.abs() <= LARGEST_NUMBER);
        let numbers: Option<Vec<f64>> = self.text.split_whitespace().map(parse).collect();
        match numbers.as_deref() {
            Some(&[x, y, z]) => Ok(Vector3::new(x, y, z)),
            _ => Err(self.not("three finite numbers")),
        }
    }
}

pub const XACRO: &str =
    "this is xacro, a macro language; expand it first: xacro robot.urdf.xacro > robot.urdf";

/// Enough of a text to recognise it by.
pub fn shortened(text: &str) -> String {
    let mut short: String = text.chars().take(60).collect();
    if short.len() < text.len() {
        short.push_str("...");
    }
    short
}
