//! The outermost fields of a RON text, found without knowing what it describes.

/// A field `name: value` right inside the outermost brackets.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Field<'a> {
    pub name: &'a str,
    /// Where its value begins, in bytes.
    pub value: usize,
}

/// All of them, in order; comments, strings and inner brackets are passed over.
pub(super) fn outer_fields(text: &str) -> Vec<Field<'_>> {
    let bytes = text.as_bytes();
    let (mut fields, mut depth, mut i) = (Vec::new(), 0_usize, 0);
    let mut word: Option<(usize, usize)> = None;
    while i < bytes.len() {
        let rest = &bytes[i..];
        match bytes[i] {
            b'/' if rest.starts_with(b"//") => {
                i += rest.iter().position(|b| *b == b'\n').unwrap_or(rest.len())
            }
            b'/' if rest.starts_with(b"/*") => {
                i += rest.windows(2).position(|w| w == b"*/").map_or(rest.len(), |end| end + 2);
            }
            b'"' => i += string(rest),
            b'(' | b'[' | b'{' => {
                (depth, word) = (depth + 1, None);
                i += 1;
            }
            b')' | b']' | b'}' => {
                (depth, word) = (depth.saturating_sub(1), None);
                i += 1;
            }
            b':' => {
                if let (1, Some((from, to))) = (depth, word.take()) {
                    fields.push(Field { name: &text[from..to], value: i + 1 });
                }
                i += 1;
            }
            b if b.is_ascii_alphabetic() || b == b'_' => {
                let end = rest.iter().position(|b| !(b.is_ascii_alphanumeric() || *b == b'_'));
                let to = i + end.unwrap_or(rest.len());
                word = Some((i, to));
                i = to;
            }
            b if b.is_ascii_whitespace() => i += 1,
            _ => {
                word = None;
                i += 1;
            }
        }
    }
    fields
}

/// Length of the string that `rest` begins with.
fn string(rest: &[u8]) -> usize {
    let mut i = 1;
    while i < rest.len() && rest[i] != b'"' {
        i += if rest[i] == b'\\' { 2 } else { 1 };
    }
    (i + 1).min(rest.len())
}

/// A Denavit-Hartenberg table with the other convention written in it; `None` for anything else.
pub(super) fn other_convention(text: &str) -> Option<String> {
    let fields = outer_fields(text);
    let at = fields.iter().find(|f| f.name == "convention")?.value;
    let value = text[at..].trim_start();
    let from = text.len() - value.len();
    let swapped = [("Modified", "Standard"), ("Standard", "Modified")];
    let (old, new) = swapped.into_iter().find(|(old, _)| value.starts_with(old))?;
    Some(format!("{}{new}{}", &text[..from], &text[from + old.len()..]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_outer_fields_count() {
        let text = "// rows: no\n(robot: \"a: b \\\" c: d\", /* x: y */ logs: Files(fit: [\"x\"]), seed : 3)";
        let names: Vec<&str> = outer_fields(text).iter().map(|f| f.name).collect();
        assert_eq!(names, ["robot", "logs", "seed"]);
    }

    #[test]
    fn conventions_are_exchanged_where_they_are_meant() {
        let table =
            "// convention: Standard\n(name: \"convention: Modified\", convention: Modified, rows: [])";
        let other = other_convention(table).expect("it is a table");
        assert!(other.ends_with("convention: Standard, rows: [])"), "{other}");
        assert_eq!(other_convention(&other).as_deref(), Some(table));
        assert_eq!(other_convention("(robot: \"x\")"), None);
    }
}
