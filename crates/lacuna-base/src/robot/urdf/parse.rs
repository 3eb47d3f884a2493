//! XML as robot files have it: a few slips that every URDF tool forgives are forgiven here too.

use std::borrow::Cow;

use roxmltree::{Document, Error as XmlError, TextPos};

use super::xml::XACRO;
use crate::error::{Error, Result};

/// More kinds of slips than this are not a slip: each one costs another pass over the text.
const MOST_PASSES: usize = 32;

/// Parses `text` and hands the document on.
pub fn with_document<T>(text: &str, read: impl FnOnce(&Document) -> Result<T>) -> Result<T> {
    let mut text = Cow::Borrowed(text.strip_prefix('\u{feff}').unwrap_or(text));
    let mut passes = 1;
    loop {
        let error = match Document::parse(&text) {
            Ok(document) => return read(&document),
            Err(error) => error,
        };
        let better = forgiven(&text, &error).filter(|_| passes < MOST_PASSES);
        text = Cow::Owned(better.ok_or_else(|| explained(&text, &error))?);
        passes += 1;
    }
}

/// The text without the slip that `error` is about, every other byte in its place; `None` when it
/// is not to be forgiven.
fn forgiven(text: &str, error: &XmlError) -> Option<String> {
    let changed = match error {
        XmlError::UnknownNamespace(prefix, _) if prefix != "xacro" => joined_prefix(text, prefix),
        XmlError::InvalidComment(_) => quiet_comments(text),
        XmlError::UnexpectedDeclaration(_) => blank_declaration(text)?,
        _ => return None,
    };
    (changed != text).then_some(changed)
}

/// Many tools write elements of their own, such as `<drake:joint>`, without declaring the prefix:
/// spelt `drake_joint`, they are just elements that nobody knows.
fn joined_prefix(text: &str, prefix: &str) -> String {
    let mut changed = String::with_capacity(text.len());
    let mut rest = text;
    while let Some(i) = rest.find(prefix) {
        let end = i + prefix.len();
        let before = rest[..i].chars().next_back().or(changed.chars().next_back());
        let begins = before.is_some_and(|c| c == '<' || c == '/' || c.is_whitespace());
        changed.push_str(&rest[..end]);
        rest = &rest[end..];
        if begins && rest.starts_with(':') {
            changed.push('_');
            rest = &rest[1..];
        }
    }
    changed + rest
}

/// Comments with `--` inside, which XML forbids and people like as rulers.
fn quiet_comments(text: &str) -> String {
    let mut changed = String::with_capacity(text.len());
    let mut rest = text;
    while let Some((before, inside, after)) = next_comment(rest) {
        changed.push_str(before);
        changed.push_str(&inside.replace('-', " "));
        rest = after;
    }
    changed + rest
}

/// Splits into everything up to the inside of the next comment, the inside, and what follows.
fn next_comment(text: &str) -> Option<(&str, &str, &str)> {
    let start = text.find("<!--")? + "<!--".len();
    let end = start + text[start..].find("-->")?;
    Some((&text[..start], &text[start..end], &text[end..]))
}

/// An XML declaration that is not at the very start of the file.
fn blank_declaration(text: &str) -> Option<String> {
    // One at the start is in its place, a second one is what the parser met.
    let start = 1 + text.get(1..)?.find("<?xml ")?;
    let end = start + text[start..].find("?>")? + "?>".len();
    let blank: String = text[start..end].chars().map(|c| if c == '\n' { c } else { ' ' }).collect();
    Some([&text[..start], &blank, &text[end..]].concat())
}

fn explained(text: &str, error: &XmlError) -> Error {
    let at = |pos: TextPos, text: String| Error::new(text).at(pos.row as usize, pos.col as usize);
    match error {
        XmlError::UnknownNamespace(prefix, pos) if prefix == "xacro" => {
            at(*pos, "the file has xacro elements".into()).help(XACRO)
        }
        XmlError::DtdDetected => {
            let pos = place_of(text, text.find("<!DOCTYPE").unwrap_or(0));
            at(pos, "the file has a document type definition (DTD), which is not read".into())
                .help("remove <!DOCTYPE ...>: a robot needs none, and write out the entities it defines")
        }
        XmlError::NoRootNode => at(TextPos::new(1, 1), "the file holds no element".into())
            .help("a URDF is an XML file with the root <robot>"),
        XmlError::UnclosedRootNode | XmlError::UnexpectedEndOfStream => {
            at(place_of(text, text.len()), "the file ends before its elements are closed".into())
                .help("the file may be cut off: it must end with </robot>")
        }
        other => {
            let pos = other.pos();
            // The place is printed by our error, so it is cut out of the parser's text.
            let what = other.to_string().replace(&format!(" at {pos}"), "");
            at(pos, format!("this is not well-formed XML: {what}"))
                .help("a URDF is an XML file with the root <robot>")
        }
    }
}

fn place_of(text: &str, offset: usize) -> TextPos {
    let before = &text[..offset];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    let row = 1 + before.matches('\n').count();
    let column = 1 + before[line_start..].chars().count();
    TextPos::new(row as u32, column as u32)
}
