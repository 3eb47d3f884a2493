//! Text for a screen of 80 columns, wherever it goes.

/// Columns of a screen.
const WIDTH: usize = 80;

/// Words on lines of at most `width` characters; the indentation of the text is kept.
pub fn wrap(text: &str, width: usize) -> Vec<String> {
    let indent: String = text.chars().take_while(|c| *c == ' ').collect();
    let mut lines = vec![indent.clone()];
    for word in text.split_whitespace() {
        let Some(last) = lines.last_mut() else { break };
        if last.trim().is_empty() {
            last.push_str(word);
        } else if last.chars().count() + 1 + word.chars().count() <= width {
            last.push(' ');
            last.push_str(word);
        } else {
            lines.push(format!("{indent}{word}"));
        }
    }
    lines
}

/// Words behind a lead-in, on lines of at most 80 columns that begin with `indent` blanks from the second on; ends
/// with a line break.
pub fn hanging(lead: &str, text: &str, indent: usize) -> String {
    broken(lead, text.split_whitespace(), indent, "")
}

/// A command of a shell behind a lead-in, on lines of at most 80 columns: what is continued ends in a backslash, so
/// that it can be copied as it stands. A flag stays with its value.
pub fn command(lead: &str, text: &str, indent: usize) -> String {
    let mut chunks: Vec<String> = Vec::new();
    for word in text.split_whitespace() {
        match chunks.last_mut().filter(|last| last.starts_with("--") && !last.contains(' ')) {
            Some(flag) if !word.starts_with("--") => *flag += &format!(" {word}"),
            _ => chunks.push(word.to_string()),
        }
    }
    broken(lead, chunks.iter().map(String::as_str), indent, " \\")
}

fn broken<'a>(lead: &str, chunks: impl Iterator<Item = &'a str>, indent: usize, end: &str) -> String {
    let (mut done, mut line) = (String::new(), lead.to_string());
    for chunk in chunks {
        let gap = usize::from(!line.is_empty() && !line.ends_with(' '));
        let long = line.chars().count() + gap + chunk.chars().count() + end.chars().count() > WIDTH;
        // A line that holds nothing yet gets no better by an empty one before it.
        if long && line.trim_end().chars().count() > indent {
            done += &format!("{}{end}\n", line.trim_end());
            line = " ".repeat(indent);
        } else if gap > 0 {
            line.push(' ');
        }
        line.push_str(chunk);
    }
    format!("{done}{}\n", line.trim_end())
}

/// A name made fit for a column: the beginning of a long one gives way, for its end tells it from the others.
pub fn cut(name: &str, width: usize) -> String {
    let count = name.chars().count();
    if count <= width {
        return name.to_string();
    }
    let end: String = name.chars().skip(count + 2 - width.max(2)).collect();
    format!("..{end}")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lines_hang_and_stay_within_the_screen() {
        let text = hanging("name  ", &"word ".repeat(40), 6);
        let lines: Vec<&str> = text.lines().collect();
        assert_eq!(lines.len(), 3);
        assert!(lines.iter().all(|l| l.chars().count() <= 80));
        assert!(lines[0].starts_with("name  word") && lines[1].starts_with("      word"));
        assert_eq!(hanging("  ", "", 4), "\n");
        let long = "x".repeat(100);
        assert_eq!(hanging("  ", &long, 2), format!("  {long}\n"), "what cannot be broken is left whole");
    }

    #[test]
    fn a_command_can_be_copied() {
        let paths = ["a".repeat(30), "b".repeat(30), "c".repeat(30)];
        let text = format!("lacuna compare {} {} --robot {}", paths[0], paths[1], paths[2]);
        let shown = command("next     ", &text, 13);
        assert!(shown.lines().all(|l| l.chars().count() <= 80), "{shown}");
        let joined = shown.trim_start_matches("next").replace("\\\n", " ");
        let words = |text: &str| text.split_whitespace().map(str::to_owned).collect::<Vec<_>>();
        assert_eq!(words(&joined), words(&text));
        assert!(shown.contains(&format!("--robot {}", paths[2])), "{shown}");
    }

    #[test]
    fn long_names_keep_their_ends() {
        assert_eq!(cut("joint1", 6), "joint1");
        assert_eq!(cut("left_arm_shoulder_1", 12), "..shoulder_1");
    }
}
