//! Names in messages: the nearest one to a typo, and long lists kept short.

/// The name of `known` that differs least from `wanted`, if one is near enough to be meant: letters may
/// differ, but `q3` is never meant by `q4`. Failing that, one that the typo begins or that begins it.
pub fn nearest<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> Option<&'a str> {
    let limit = 1 + wanted.chars().count() / 4;
    let digits = |name: &str| name.chars().filter(char::is_ascii_digit).collect::<String>();
    let known: Vec<&str> = known.into_iter().filter(|name| digits(name) == digits(wanted)).collect();
    let similar = known
        .iter()
        .map(|name| (distance(&wanted.to_lowercase(), &name.to_lowercase()), *name))
        .filter(|(d, _)| *d <= limit)
        .min_by_key(|(d, _)| *d);
    let begins = |a: &str, b: &str| b.len() >= 3 && a.starts_with(b);
    let cut = || known.iter().find(|name| begins(name, wanted) || begins(wanted, name)).copied();
    similar.map(|(_, name)| name).or_else(cut)
}

/// `did you mean .. ? ` where a name is near enough to be meant, else nothing.
pub fn did_you_mean<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    nearest(wanted, known).map_or_else(String::new, |near| format!("did you mean `{near}`? "))
}

/// What to say of a name that is not known: the nearest one, where one is near enough to be meant, and all that are.
pub fn suggestion<'a>(wanted: &str, known: impl IntoIterator<Item = &'a str>) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    format!("{}known are {}", did_you_mean(wanted, known.iter().copied()), list(known))
}

/// Levenshtein distance in characters.
fn distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, x) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, y) in b.iter().enumerate() {
            let substituted = diagonal + usize::from(x != *y);
            diagonal = row[j + 1];
            row[j + 1] = substituted.min(row[j] + 1).min(diagonal + 1);
        }
    }
    row[b.len()]
}

/// `a, b, c`, cut after some thirty names.
pub fn list<'a>(names: impl IntoIterator<Item = &'a str>) -> String {
    const MOST: usize = 30;
    let mut names = names.into_iter();
    let mut text = names.by_ref().take(MOST).map(shorten).collect::<Vec<_>>().join(", ");
    let more = names.count();
    if more > 0 {
        text += &format!(" and {more} more");
    }
    text
}

/// A text from a file, made fit to be quoted in a message.
pub fn shorten(text: &str) -> String {
    const MOST: usize = 40;
    let mut short: String = text.chars().take(MOST).flat_map(char::escape_debug).collect();
    if text.chars().nth(MOST).is_some() {
        short.push_str("...");
    }
    short
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn distances_are_those_of_the_textbook() {
        assert_eq!(distance("kitten", "sitting"), 3);
        assert_eq!(distance("", "abc"), 3);
        assert_eq!(distance("q1", "q1"), 0);
    }

    #[test]
    fn a_typo_finds_its_name_and_nonsense_finds_none() {
        assert_eq!(nearest("tau3", ["t", "q3", "Tau3"]), Some("Tau3"));
        assert_eq!(nearest("tau3", ["temperature", "q_d", "tau4"]), None);
        assert_eq!(nearest("band", ["mode", "band_hz"]), Some("band_hz"));
        assert_eq!(nearest("minimum", ["max", "min"]), Some("min"));
        assert_eq!(nearest("q", ["q_d"]), None);
    }

    #[test]
    fn a_suggestion_names_the_nearest_first_and_then_all() {
        assert_eq!(suggestion("lmy", ["penalty", "lmi"]), "did you mean `lmi`? known are penalty, lmi");
        assert_eq!(suggestion("magic", ["penalty", "lmi"]), "known are penalty, lmi");
    }

    #[test]
    fn long_lists_and_long_names_are_cut() {
        let names: Vec<String> = (0..100).map(|i| format!("c{i}")).collect();
        assert!(list(names.iter().map(String::as_str)).ends_with("c29 and 70 more"));
        assert_eq!(shorten(&"x".repeat(50)).len(), 43);
        assert_eq!(shorten("a\u{1b}b"), "a\\u{1b}b");
    }
}
