//! Texts from files and arguments on their way to a screen: nothing in them may steer a terminal, turn the direction of
//! reading round, or fill the screen.

use std::borrow::Cow;

/// Longest name in quotes that is shown whole, in characters.
const LONGEST_NAME: usize = 60;
/// Longest text of several words in quotes, and longest word outside of quotes, that is shown whole.
const LONGEST_TEXT: usize = 240;

/// The same text, with every character escaped that would steer a terminal: control characters other than the newline,
/// and those that turn the direction of reading.
///
/// ```
/// assert_eq!(lacuna_base::text::harmless("red \u{1b}[31m\n"), "red \\u{1b}[31m\n");
/// ```
pub fn harmless(text: &str) -> Cow<'_, str> {
    escaped(text, |c| steers(c) && c != '\n', |c| c.escape_unicode().to_string())
}

/// The same JSON document, with the characters escaped that [`harmless`] escapes and JSON need not.
pub fn harmless_json(text: &str) -> Cow<'_, str> {
    // Inside of texts the writer has escaped newlines and the like already; what is left of them stands between texts.
    let beyond = |c: char| steers(c) && !matches!(c, '\n' | '\r' | '\t');
    escaped(text, beyond, |c| format!("\\u{:04x}", u32::from(c)))
}

/// One line of it: newlines are escaped too.
pub fn one_line(text: &str) -> Cow<'_, str> {
    escaped(text, steers, |c| c.escape_default().to_string())
}

/// Control characters, and the marks, overrides and isolates of bidirectional text.
fn steers(c: char) -> bool {
    c.is_control()
        || matches!(c, '\u{61c}' | '\u{200e}' | '\u{200f}' | '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

fn escaped(text: &str, which: impl Fn(char) -> bool, how: impl Fn(char) -> String) -> Cow<'_, str> {
    if !text.chars().any(&which) {
        return Cow::Borrowed(text);
    }
    text.chars().map(|c| if which(c) { how(c) } else { c.to_string() }).collect::<String>().into()
}

/// A message with what it quotes cut to a length that can be read: whole programs and logs end up in quotes otherwise.
pub fn cut_quotes(message: &str) -> String {
    let mut text = String::with_capacity(message.len());
    let mut rest = message;
    while let Some(start) = rest.find(['`', '"']) {
        let mark = &rest[start..=start];
        let Some(length) = rest[start + 1..].find(mark) else { break };
        let (before, quoted) = (&rest[..start], &rest[start + 1..start + 1 + length]);
        text += &cut_words(before);
        let quoted = if mark == "`" { one_line(quoted) } else { Cow::Borrowed(quoted) };
        text += mark;
        text += &cut(&quoted, if quoted.contains(char::is_whitespace) { LONGEST_TEXT } else { LONGEST_NAME });
        text += mark;
        rest = &rest[start + 2 + length..];
    }
    text += &cut_words(rest);
    text
}

/// [`cut_quotes`], and no more than fills half a screen.
pub fn cut_message(message: &str) -> String {
    const LONGEST: usize = 1000;
    cut(&cut_quotes(message), LONGEST).into_owned()
}

fn cut_words(text: &str) -> String {
    text.split_inclusive(char::is_whitespace)
        .map(|word| {
            let bare = word.trim_end();
            format!("{}{}", cut(bare, LONGEST_TEXT), &word[bare.len()..])
        })
        .collect()
}

/// The path, its middle left out where it is very long.
pub fn cut_path(path: &str) -> String {
    let path = one_line(path);
    let count = path.chars().count();
    if count <= LONGEST_TEXT {
        return path.into_owned();
    }
    let half = LONGEST_TEXT / 3;
    let head: String = path.chars().take(half).collect();
    let tail: String = path.chars().skip(count - half).collect();
    format!("{head}...{tail}")
}

/// The first two thirds of what is longer than `most` characters.
fn cut(text: &str, most: usize) -> Cow<'_, str> {
    match text.char_indices().nth(most) {
        None => Cow::Borrowed(text),
        Some(_) => (text.chars().take(2 * most / 3).collect::<String>() + "...").into(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nothing_that_steers_a_terminal_is_left() {
        let bad = "a\u{1b}[2J\r\u{7f}\u{9b}31m\u{202e}\u{2066}\u{200f}\u{0}\tb\nc é 漢";
        let shown = harmless(bad);
        assert!(shown.chars().all(|c| c == '\n' || !steers(c)), "{shown}");
        assert!(shown.starts_with("a\\u{1b}[2J\\u{d}\\u{7f}\\u{9b}31m") && shown.ends_with("b\nc é 漢"));
        assert_eq!(one_line("a\nb\u{1b}"), "a\\nb\\u{1b}");
        assert!(matches!(harmless("as it is\n"), Cow::Borrowed(_)));
        let json = serde_json::to_string(&[bad]).expect("texts become JSON");
        let shown = harmless_json(&json);
        assert!(!shown.chars().any(steers), "{shown}");
        assert_eq!(serde_json::from_str::<Vec<String>>(&shown).expect("JSON"), [bad]);
    }

    #[test]
    fn long_quotes_are_cut_and_short_ones_stay() {
        let short =
            "no joint `elbow` in `lacuna check a.csv --robot arm.ron --columns columns/ur_rtde.ron --data b`";
        assert_eq!(cut_quotes(short), short);
        let long = "x".repeat(4096);
        assert_eq!(cut_quotes(&format!("no `{long}` here")), format!("no `{}...` here", "x".repeat(40)));
        assert_eq!(cut_quotes(&format!("x=\"{long}\" \"y\"")), format!("x=\"{}...\" \"y\"", "x".repeat(40)));
        assert_eq!(cut_quotes(&format!("no {long}\nhere")), format!("no {}...\nhere", "x".repeat(160)));
        assert_eq!(cut_quotes(&format!("no {long}` \"")).len(), 168);
        assert!(cut_quotes(&format!("`{}`", "a b ".repeat(1024))).len() < 180);
        assert_eq!(cut_quotes("`a\nb` c\nd `"), "`a\\nb` c\nd `");
        assert_eq!(cut_path(&long).len(), 163);
        assert_eq!(cut_path("logs/a\n.csv"), "logs/a\\n.csv");
    }
}
