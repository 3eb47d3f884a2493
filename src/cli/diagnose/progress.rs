//! Progress of a diagnosis: effects come and go many times before the search ends; each is told once.

use std::collections::BTreeSet;

/// What was told so far.
#[derive(Debug, Default)]
pub(super) struct Told {
    found: BTreeSet<String>,
    dropped: BTreeSet<String>,
    /// Dropped since the last line.
    waiting: Vec<String>,
}

/// Longest list of what was dropped, in characters.
const LIST: usize = 50;

impl Told {
    /// The lines to show when the search says `what`.
    pub fn lines(&mut self, what: &str) -> Vec<String> {
        if let Some(title) = what.strip_prefix("no longer needed: ") {
            if self.dropped.insert(title.to_string()) {
                self.waiting.push(title.to_string());
            }
            return Vec::new();
        }
        if let Some(title) = what.strip_prefix("found ")
            && !self.found.insert(title.to_string())
        {
            return Vec::new();
        }
        self.rest().into_iter().chain([what.to_string()]).collect()
    }

    /// What was dropped and is not told yet.
    pub fn rest(&mut self) -> Option<String> {
        let titles = std::mem::take(&mut self.waiting);
        let (mut list, mut shown) = (titles.first()?.clone(), 1);
        for title in &titles[1..] {
            if list.chars().count() + 2 + title.chars().count() > LIST {
                break;
            }
            list += &format!(", {title}");
            shown += 1;
        }
        let more = titles.len() - shown;
        let more = if more > 0 { format!(" and {more} more") } else { String::new() };
        Some(format!("no longer needed: {list}{more}"))
    }
}

#[cfg(test)]
mod tests {
    use super::Told;

    #[test]
    fn every_effect_is_told_once_and_those_that_go_together_on_one_line() {
        let mut told = Told::default();
        let said = ["found a", "found b", "found a", "no longer needed: a", "no longer needed: b", "found a"];
        let mut lines: Vec<String> = said.iter().flat_map(|what| told.lines(what)).collect();
        lines.extend(told.lines("no longer needed: a"));
        lines.extend(told.lines("calibrating"));
        assert_eq!(lines, ["found a", "found b", "no longer needed: a, b", "calibrating"]);
        assert_eq!(told.rest(), None);
        for k in 10..30 {
            assert!(told.lines(&format!("no longer needed: effect {k}")).is_empty());
        }
        let rest = told.rest().expect("there are");
        assert!(
            rest.starts_with("no longer needed: effect 10, effect 11") && rest.ends_with(" 16 more"),
            "{rest}"
        );
    }
}
