//! RON trouble in plain words, with what is known at that place.

use super::bounds::NAMELESS;
use super::names::{did_you_mean, list};
use super::{find, guard};
use crate::error::Error;

/// An error of reading `ron` as ours: message, line and column, and what to do.
///
/// Works on the reader's text and not on its kinds of error: what goes wrong inside an effect comes through
/// the plug-in as text only.
pub(super) fn explained(error: &ron::error::SpannedError, ron: &str) -> Error {
    // A comma is missing after what was read last, everything else is wrong where it begins.
    let span = &error.span;
    let at = if matches!(error.code, ron::Error::ExpectedComma) { &span.end } else { &span.start };
    let text = error.code.to_string();
    let unfinished = || {
        let wants_more = ["Expected colon", "Expected comma", "Expected closing"];
        wants_more.iter().any(|w| text.starts_with(w))
            && find::next_value(ron, span.end.line, span.end.col).is_none()
    };
    let cut_off = matches!(error.code, ron::Error::Eof) || unfinished();
    let Some((line, column)) = find::next_value(ron, at.line, at.col).filter(|_| !cut_off) else {
        let end = &error.span.end;
        return Error::new("the file ends in the middle")
            .at(end.line, end.col)
            .help("close every bracket and every quote");
    };
    let choice = || choice(&text, find::before(ron, line, column));
    let outside = || outside(&text, guard::name_at(ron, line, column));
    let (what, help) =
        named(&text).or_else(choice).or_else(outside).or_else(|| shape(&text)).unwrap_or_else(|| ours(&text));
    // Our own errors come once a value was read whole: when the reader is at the next line, it was on the one before.
    let own =
        matches!(error.code, ron::Error::Message(_)) && named(&text).is_none() && shape(&text).is_none();
    let (line, column) = if own { find::last_value(ron, line, column) } else { (line, column) };
    let explained = Error::new(what).at(line, column);
    if help.is_empty() { explained } else { explained.help(help) }
}

/// Errors of ours that went through the reader bring their own help.
fn ours(text: &str) -> (String, String) {
    let (what, help) = text.split_once("\n  help: ").unwrap_or((text, ""));
    (what.to_owned(), help.to_owned())
}

/// A number outside of its bounds, which the reader knows without its name.
fn outside(text: &str, name: Option<&str>) -> Option<(String, String)> {
    let (what, help) = ours(text.strip_prefix(NAMELESS)?);
    let name = name.map_or_else(|| "the number here".to_owned(), |name| format!("`{name}`"));
    Some((format!("{name} is {what}"), help))
}

/// Names that are unknown, missing or stand twice.
fn named(text: &str) -> Option<(String, String)> {
    let text = text.strip_prefix("Unexpected ")?;
    let (about, expected) = text.split_once(", expected ").unwrap_or((text, ""));
    let quoted = |text: &'_ str| text.split('`').skip(1).step_by(2).map(str::to_owned).collect::<Vec<_>>();
    let (found, expected) = (quoted(about), quoted(expected));
    let name = found.first()?;
    let of = found.get(1).map_or_else(String::new, |outer| format!(" of `{outer}`"));
    Some(match about.split(" named ").next()? {
        "field" => {
            (format!("there is no field `{name}` here"), known(name, &expected, &format!("fields{of}")))
        }
        "variant" | "enum variant" => {
            (format!("`{name}` is not known here"), known(name, &expected, "names"))
        }
        "missing field" => (format!("the field `{name}`{of} is missing"), format!("add `{name}: ...`")),
        "duplicate field" => (format!("the field `{name}` stands twice"), "keep one of them".to_owned()),
        _ => return None,
    })
}

fn known(found: &str, expected: &[String], what: &str) -> String {
    if expected.is_empty() {
        return "there are none: leave it out".to_owned();
    }
    let expected = || expected.iter().map(String::as_str);
    format!("{}known {what}: {}", did_you_mean(found, expected()), list(expected()))
}

/// A list, number or text where joints or links are chosen: the slip that everybody makes once.
fn choice(text: &str, before: &str) -> Option<(String, String)> {
    let field = ["joints", "links"].into_iter().find(|f| before.trim_end().ends_with(&format!("{f}:")))?;
    text.starts_with("Expected identifier").then(|| {
        let one = field.trim_end_matches('s');
        (
            format!("`{field}` takes `All` or `Only([..])`"),
            format!("write `{field}: All`, or `{field}: Only([\"{one}1\", \"{one}2\"])`"),
        )
    })
}

const WHOLE: (&str, &str) = ("a whole number is expected here", "write it plainly, as 3");

/// What the reader says of a backslash and what follows it in a text.
const ESCAPE: (&str, &str) =
    ("this text holds a `\\` that means nothing", "write `\\\\` for one, or a raw text: r\"...\"");

/// What is wrong with brackets, commas and literals: how the reader's message begins, ours, and help.
const SHAPES: [(&str, &str, &str); 39] = [
    (
        "Unexpected char",
        "a value is expected here",
        "a value is a number, a text in double quotes, a list [a, b] or a struct (field: value)",
    ),
    (
        "Exceeded recursion limit",
        "brackets are nested too deeply",
        "nothing that this program reads needs so many",
    ),
    (
        "Expected opening `(`",
        "an opening `(` is expected here",
        "this is RON: (field: value, field: value); a variant that holds a struct has two: Fourier((a: ...))",
    ),
    (
        "Expected struct",
        "an opening `(` is expected here",
        "this is RON: (field: value, field: value), with double quotes around texts",
    ),
    (
        "Expected closing `)`",
        "a closing `)` is expected here",
        "close the bracket, or separate what follows by a comma",
    ),
    (
        "Expected opening `{`",
        "an opening `{` is expected here",
        "an effect is written {\"name\": (field: value)}, as {\"viscous_friction\": (joints: All)}",
    ),
    (
        "Expected closing `}`",
        "a closing `}` is expected here",
        "every effect has its own braces: {\"a\": ()}, {\"b\": ()}",
    ),
    ("Expected opening `[`", "a list is expected here", "write it in brackets: [a, b]"),
    ("Expected closing `]`", "a closing `]` is expected here", "separate the entries of a list by commas"),
    ("Expected string", "a text in double quotes is expected here", "write it as \"...\""),
    ("Expected integer", WHOLE.0, WHOLE.1),
    ("Invalid digit", WHOLE.0, WHOLE.1),
    ("Unexpected leading underscore", "a number is expected here", "it may not begin with an underscore"),
    ("Unexpected underscore in float", "a number is expected here", "write it without underscores"),
    ("Expected option", "a value or None is expected here", "leave the field out where it has no value"),
    ("Expected unit", "an empty () is expected here", "write ()"),
    ("Expected end of string", "a text is not closed", "close it by a double quote"),
    ("Unclosed block comment", "a comment is not closed", "close it by */"),
    ("Expected an `#![enable", "an attribute is broken here", "leave it out: nothing here needs one"),
    ("Expected closing `)]` after", "an attribute is broken here", "leave it out: nothing here needs one"),
    ("No RON extension", "there is no such extension of RON", "leave it out: nothing here needs one"),
    ("Invalid identifier", "this cannot be a name", "names are letters, digits and _"),
    ("Found invalid std identifier", "this cannot be a name", "names are letters, digits and _"),
    ("Unknown escape", ESCAPE.0, ESCAPE.1),
    ("Non-hex digit found", ESCAPE.0, ESCAPE.1),
    ("Not a valid Unicode", ESCAPE.0, ESCAPE.1),
    ("Not a valid byte", ESCAPE.0, ESCAPE.1),
    ("Missing { in Unicode", ESCAPE.0, ESCAPE.1),
    ("No } at the end of Unicode", ESCAPE.0, ESCAPE.1),
    ("Expected 1-6 digits", ESCAPE.0, ESCAPE.1),
    ("Unexpected Unicode escape", ESCAPE.0, ESCAPE.1),
    ("Expected float", "a number is expected here", "write it plainly, as 0.5 or 1e-3"),
    ("Expected boolean", "a truth value is expected here", "write true or false"),
    ("Expected char", "a character is expected here", "write it in single quotes, as ';'"),
    (
        "Integer is out of bounds",
        "the whole number is out of range here",
        "most counts start at 0 or 1 and are never negative",
    ),
    ("Expected comma", "a comma is missing here", "separate fields and entries by commas"),
    ("Expected colon", "a colon is expected here", "fields are written `name: value`"),
    (
        "Expected identifier",
        "a name is expected here",
        "fields are written `name: value`, the name without quotes",
    ),
    (
        "Non-whitespace trailing characters",
        "something follows after the end",
        "the file is one value: remove what stands after its last bracket",
    ),
];

pub(super) fn shape(text: &str) -> Option<(String, String)> {
    let (_, what, help) = SHAPES.iter().find(|(begins, ..)| text.starts_with(begins))?;
    Some(((*what).to_owned(), (*help).to_owned()))
}
