//! Every number of a RON text is finite and of a size that a robot can have, whatever reads it.

use super::find;
use crate::error::{Error, Result};

/// No quantity of a robot is larger in SI units, and squares and products of larger ones overflow sooner or later.
pub(super) const LARGEST: f64 = 1e12;

/// Refuses numbers that are not finite or larger than [`LARGEST`], with their place. Seeds (fields whose name ends
/// in `seed`) are any whole number, and the limits of a name in quotes (`"m1": (0.0, inf)`) may be open.
pub(super) fn check(text: &str) -> Result<()> {
    let mut scan = Scan { text, at: 0, levels: vec![Level::default()] };
    while let Some(number) = scan.next_number() {
        let Some((what, help)) = trouble(&number) else { continue };
        let (line, column) = find::position(text, number.at);
        let name = number.name.map_or_else(|| "the number here".to_owned(), |name| format!("`{name}`"));
        return Err(Error::new(format!("{name} is {what}")).at(line, column).help(help));
    }
    Ok(())
}

/// The name of what a number at line and column belongs to, as far as the text before says.
pub(super) fn name_at(text: &str, line: usize, column: usize) -> Option<&str> {
    let end = find::before(text, line, column).len();
    let mut scan = Scan { text, at: 0, levels: vec![Level::default()] };
    while scan.at < end {
        scan.step()?;
    }
    scan.name().map(|(name, _)| name)
}

fn trouble(number: &Number<'_>) -> Option<(String, &'static str)> {
    let plain = number.token.trim_start_matches(['+', '-']);
    match plain {
        "NaN" => return Some(("NaN, which is no number".into(), "give a finite number")),
        "inf" if number.of_text => return None,
        "inf" => {
            return Some(("infinite".into(), "give a finite number, or leave the field out for no limit"));
        }
        _ => {}
    }
    let whole = plain.bytes().all(|b| b.is_ascii_digit() || b == b'_');
    if whole && number.name.is_some_and(|name| name.ends_with("seed")) {
        return None;
    }
    // What is no number after all is for the reader to say.
    let value: f64 = plain.replace('_', "").parse().ok()?;
    (value > LARGEST).then(|| {
        (
            format!("{}, too large for a robot", number.token),
            "give it in SI units: nothing exceeds 1e12 there",
        )
    })
}

struct Number<'a> {
    at: usize,
    token: &'a str,
    name: Option<&'a str>,
    /// Whether it stands in brackets that belong to a name in quotes.
    of_text: bool,
}

/// What stands before a place within one pair of brackets.
#[derive(Default)]
struct Level<'a> {
    /// The field that is being given.
    field: Option<&'a str>,
    /// The last text in quotes, and whether a colon follows it.
    text: Option<(&'a str, bool)>,
}

/// Walks through a text, past comments, texts and characters.
struct Scan<'a> {
    text: &'a str,
    at: usize,
    levels: Vec<Level<'a>>,
}

impl<'a> Scan<'a> {
    fn next_number(&mut self) -> Option<Number<'a>> {
        loop {
            let at = self.at;
            if let Some(token) = self.step()? {
                let name = self.name();
                let direct = self.levels.last().is_some_and(|level| level.text.is_some());
                let of_text = name.is_some_and(|n| n.1) && !direct;
                return Some(Number { at, token, name: name.map(|n| n.0), of_text });
            }
        }
    }

    /// The name that what stands here belongs to, and whether it is one in quotes.
    fn name(&self) -> Option<(&'a str, bool)> {
        let of = |level: &Level<'a>| level.field.map(|field| (field, false)).or(level.text);
        self.levels.iter().rev().find_map(of)
    }

    /// One token further: `Some(Some(..))` for a number, `None` at the end.
    fn step(&mut self) -> Option<Option<&'a str>> {
        let rest = &self.text[self.at..];
        let first = rest.chars().next()?;
        let mut number = None;
        let length = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some((inner, length)) = quoted(rest) {
            self.level().text = Some((inner, colon_follows(&rest[length..])));
            length
        } else if first == '\'' {
            character(rest)
        } else if first.is_alphanumeric() || matches!(first, '_' | '+' | '-' | '.') {
            let in_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '+' | '-' | '.');
            let length = rest.find(|c| !in_word(c)).unwrap_or(rest.len());
            let word = &rest[..length];
            let plain = word.trim_start_matches(['+', '-']);
            if colon_follows(&rest[length..]) {
                self.level().field = Some(word);
            } else if plain.starts_with(|c: char| c.is_ascii_digit() || c == '.')
                || matches!(plain, "inf" | "NaN")
            {
                number = Some(word);
            }
            length
        } else {
            self.bracket(first);
            first.len_utf8()
        };
        self.at += length;
        Some(number)
    }

    fn level(&mut self) -> &mut Level<'a> {
        if self.levels.is_empty() {
            self.levels.push(Level::default());
        }
        let last = self.levels.len() - 1;
        &mut self.levels[last]
    }

    fn bracket(&mut self, c: char) {
        match c {
            '(' | '[' | '{' => self.levels.push(Level::default()),
            ')' | ']' | '}' => {
                self.levels.pop();
            }
            ',' => self.level().field = None,
            _ => {}
        }
    }
}

fn colon_follows(rest: &str) -> bool {
    rest.trim_start().starts_with(':')
}

/// The text in quotes, plain or raw, that `rest` begins with, and its length with them.
fn quoted(rest: &str) -> Option<(&str, usize)> {
    if let Some(inside) = rest.strip_prefix('"') {
        let mut escaped = false;
        let end = inside.find(|c| {
            let ends = c == '"' && !escaped;
            escaped = c == '\\' && !escaped;
            ends
        });
        let end = end.unwrap_or(inside.len());
        return Some((&inside[..end], (end + 2).min(rest.len())));
    }
    let raw = rest.strip_prefix('r')?;
    let hashes = raw.len() - raw.trim_start_matches('#').len();
    let inside = raw[hashes..].strip_prefix('"')?;
    let closing = format!("\"{}", "#".repeat(hashes));
    let end = inside.find(&closing).unwrap_or(inside.len());
    Some((&inside[..end], (1 + hashes + 1 + end + closing.len()).min(rest.len())))
}

/// Length of the character in single quotes that `rest` begins with.
fn character(rest: &str) -> usize {
    let inside = &rest[1..];
    let escape = usize::from(inside.starts_with('\\'));
    let of = inside.chars().nth(escape).map_or(0, char::len_utf8);
    if inside[escape + of..].starts_with('\'') { 2 + escape + of } else { 1 }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[track_caller]
    fn refused(text: &str, at: (usize, usize), word: &str) {
        let error = check(text).expect_err(text);
        let place = error.place().and_then(|p| Some((p.line?, p.column?)));
        assert_eq!(place, Some(at), "{error}");
        assert!(error.message().contains(word), "{error}");
    }

    #[test]
    fn numbers_that_no_robot_has_are_refused_with_name_and_place() {
        refused("(\n  a: 1.0, b: -1e13)", (2, 14), "`b` is -1e13, too large");
        refused("(a: (x: [1, 2], y: [0.5, NaN]), b: 2)", (1, 26), "`y` is NaN");
        refused("(a: [(\"Jxx1\", 1.0), (\"m2\", 1_000_000_000_000_000)])", (1, 28), "`m2` is 1_0");
        refused("(a: One(k: inf))", (1, 12), "`k` is infinite");
        refused("{\"high\": inf}", (1, 10), "`high` is infinite");
        refused("[1, -inf]", (1, 5), "the number here is infinite");
        refused("(seed: 1e300)", (1, 8), "`seed` is 1e300");
        refused("(a: \"\\\"\", b: '\"', c: r#\"\"#, d: '\\'', e: 1e99)", (1, 41), "`e` is 1e99");
    }

    #[test]
    fn everything_else_passes() {
        for text in [
            "(seed: 18446744073709551615, a: -1e12, b: 0x10, c: -3, d: +.5e-300)",
            "(/* 1e99 */ a: \"1e99\", // NaN\n b: 'é', inf: 3, NaN: 4)",
            "{\"fv1\": (0.0, inf), \"fc1\": (-inf, 1e3)}",
            "(a: r\"1e99, \", b: 1",
            ")))] 1",
            "",
        ] {
            assert_eq!(check(text), Ok(()), "{text}");
        }
    }

    #[test]
    fn texts_that_are_cut_off_anywhere_end() {
        let text = "(a: \"\\\"é\", b: '\"', c: r#\"x\"#, d: [1.0, 'é'], /* é */ e: 5) // é";
        for (end, _) in text.char_indices() {
            let _ = check(&text[..end]);
        }
        assert_eq!(name_at(text, 1, 35), Some("d"));
    }
}
