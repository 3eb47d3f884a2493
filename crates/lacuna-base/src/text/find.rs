//! Where a word stands in a RON text, so that trouble found after reading still has a line and column.

/// Line and column, from 1, of the first of `message`'s words in backticks that the text holds as a name or
/// as a text in quotes: messages quote what they are about.
pub(super) fn find_quoted(text: &str, message: &str) -> Option<(usize, usize)> {
    let quoted: Vec<&str> = message.split('`').skip(1).step_by(2).filter(|w| !w.is_empty()).collect();
    let words: Vec<(usize, &str)> = Words { text, at: 0 }.collect();
    let start = quoted.iter().find_map(|quoted| words.iter().find(|(_, word)| word == quoted))?.0;
    Some(position(text, start))
}

/// Line and column, from 1, where the value of the text begins, after comments.
pub(super) fn beginning(text: &str) -> (usize, usize) {
    let mut words = Words { text, at: 0 };
    words.skip_blanks_and_comments();
    position(text, words.at)
}

/// The place of what follows the blanks and comments at a line and column, if anything does.
pub(super) fn next_value(text: &str, line: usize, column: usize) -> Option<(usize, usize)> {
    let mut words = Words { text, at: before(text, line, column).len() };
    words.skip_blanks_and_comments();
    (!words.rest().is_empty()).then(|| position(text, words.at))
}

/// The text before a line and column.
pub(super) fn before(text: &str, line: usize, column: usize) -> &str {
    let line_start = text.split_inclusive('\n').take(line.saturating_sub(1)).map(str::len).sum::<usize>();
    let in_line = text[line_start..].char_indices().nth(column.saturating_sub(1));
    &text[..line_start + in_line.map_or(text.len() - line_start, |(i, _)| i)]
}

/// The same place, or the end of what stands before it where only blanks do on its line.
pub(super) fn last_value(text: &str, line: usize, column: usize) -> (usize, usize) {
    let all = before(text, line, column);
    let value = all.trim_end();
    let moves = all[value.len()..].contains('\n') && !value.is_empty();
    if moves {
        position(text, value.len() - value.chars().next_back().map_or(0, char::len_utf8))
    } else {
        (line, column)
    }
}

/// Line and column, from 1, of the byte `at`.
pub(super) fn position(text: &str, at: usize) -> (usize, usize) {
    let before = &text[..at];
    let line_start = before.rfind('\n').map_or(0, |i| i + 1);
    (1 + before.matches('\n').count(), 1 + before[line_start..].chars().count())
}

/// Names and quoted texts, each with its place in bytes; comments, numbers' signs and brackets are passed over.
struct Words<'a> {
    text: &'a str,
    at: usize,
}

impl<'a> Words<'a> {
    fn rest(&self) -> &'a str {
        &self.text[self.at..]
    }

    fn skip_blanks_and_comments(&mut self) {
        loop {
            let rest = self.rest();
            let end = match rest {
                r if r.starts_with("//") => r.find('\n').map_or(r.len(), |i| i + 1),
                r if r.starts_with("/*") => r.find("*/").map_or(r.len(), |i| i + 2),
                r => r.len() - r.trim_start().len(),
            };
            if end == 0 {
                return;
            }
            self.at += end;
        }
    }
}

impl<'a> Iterator for Words<'a> {
    type Item = (usize, &'a str);

    fn next(&mut self) -> Option<Self::Item> {
        loop {
            self.skip_blanks_and_comments();
            let rest = self.rest();
            let first = rest.chars().next()?;
            let in_word = |c: char| c.is_alphanumeric() || c == '_';
            if first == '"' {
                // An escaped quote ends the word too early, which at worst finds nothing.
                let end = rest[1..].find('"').map_or(rest.len(), |i| i + 1);
                let start = self.at;
                self.at += (end + 1).min(rest.len());
                return Some((start, &rest[1..end.max(1)]));
            }
            let length = rest.find(|c| !in_word(c)).unwrap_or(rest.len());
            if length > 0 {
                let start = self.at;
                self.at += length;
                return Some((start, &rest[..length]));
            }
            // A quote as a character would open a text.
            self.at += if rest.starts_with("'\"'") { 3 } else { first.len_utf8() };
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const TEXT: &str = "// `band` first\n(\n  robot: \"arm\", /* trim */ signals: (trim: 0.5, band: -3),\n  joints: [\"elbow\"])";

    #[test]
    fn the_first_quoted_word_that_stands_in_the_text_is_found() {
        assert_eq!(find_quoted(TEXT, "`band` is -3"), Some((3, 49)));
        assert_eq!(find_quoted(TEXT, "`trim` is odd"), Some((3, 38)));
        assert_eq!(find_quoted(TEXT, "no joint `elbow` on `arm`"), Some((4, 12)));
        assert_eq!(find_quoted(TEXT, "no `nothing`, but `arm`"), Some((3, 10)));
        assert_eq!(find_quoted(TEXT, "band is -3"), None);
        assert_eq!(find_quoted(TEXT, "`ban` is cut off"), None);
        assert_eq!(beginning(TEXT), (2, 1));
    }

    #[test]
    fn texts_that_are_cut_off_end() {
        for end in 0..TEXT.len() {
            let _ = find_quoted(&TEXT[..end], "`nothing`");
        }
        assert_eq!(find_quoted("(a: '\"', b: 1, é: \"", "`b`"), Some((1, 10)));
        assert_eq!(next_value("(é: /* x */\n  3)", 1, 4), Some((2, 3)));
        assert_eq!(next_value("(é ", 1, 3), None);
    }
}
