//! Replacing every number of a text in turn, and what must hold of each.

use std::panic::{AssertUnwindSafe, catch_unwind};
use std::time::{Duration, Instant};

use lacuna::Error;

/// What every number is replaced by.
pub const VALUES: [&str; 8] =
    ["0", "-1", "1e-12", "1e18", "4294967296", "NaN", "inf", "18446744073709551615"];

/// Longest that reading and the first step of use may take, on a machine that is busy with other things.
const LONGEST: Duration = Duration::from_secs(5);

/// How a text was not taken.
pub enum Refused {
    /// By its reader, which knows the place.
    Read(Error),
    /// By the first step of use, long after reading.
    Use(Error),
    /// Not at all, although what came of it is no use.
    Broken(String),
}

/// Takes a text as its reader does.
pub type Take = Box<dyn Fn(&str) -> Result<(), Refused>>;

pub struct Input {
    /// Room of the types.
    pub room: &'static str,
    /// Name for people.
    pub name: String,
    /// What stands before and after the part that is walked through.
    pub around: (String, String),
    /// The part with the numbers.
    pub text: String,
    /// Whether numbers stand in quotes, as attributes of XML do.
    pub quoted: bool,
    /// Reads the whole text and makes the first step of use, as far as it is cheap.
    pub take: Take,
}

impl Input {
    pub fn new(
        room: &'static str,
        name: &str,
        text: String,
        take: impl Fn(&str) -> Result<(), Refused> + 'static,
    ) -> Self {
        let around = (String::new(), String::new());
        Self { room, name: name.into(), around, text, quoted: false, take: Box::new(take) }
    }
}

/// What is broken, for people. Says where it is before each step.
pub fn walk(input: &Input) -> Vec<String> {
    let whole = |part: &str| format!("{}{part}{}", input.around.0, input.around.1);
    let mut broken = Vec::new();
    match (input.take)(&whole(&input.text)) {
        Ok(()) => {}
        Err(Refused::Read(e) | Refused::Use(e)) => broken.push(format!("{}: the example: {e}", input.name)),
        Err(Refused::Broken(what)) => broken.push(format!("{}: the example: {what}", input.name)),
    }
    let tokens = numbers(&input.text, input.quoted);
    for token in tokens {
        for value in VALUES {
            let (before, after) = (&input.text[..token.start], &input.text[token.end..]);
            let line = 1 + whole(before).matches('\n').count() - input.around.1.matches('\n').count();
            let start = input.text[..token.start].rfind('\n').map_or(0, |i| i + 1);
            let end = input.text[token.end..].find('\n').map_or(input.text.len(), |i| token.end + i);
            let at = format!("{}: {} -> {value}", input.name, input.text[start..end].trim());
            println!("at {at}");
            let changed = whole(&format!("{before}{value}{after}"));
            let begun = Instant::now();
            let taken = catch_unwind(AssertUnwindSafe(|| (input.take)(&changed)));
            if begun.elapsed() > LONGEST {
                broken.push(format!("{at}: takes {:?}", begun.elapsed()));
            }
            broken.extend(
                fault(taken.unwrap_or_else(|_| broken_by_panic()), line, value).map(|f| format!("{at}: {f}")),
            );
        }
    }
    broken
}

fn broken_by_panic() -> Result<(), Refused> {
    Err(Refused::Broken("panics".into()))
}

/// What is wrong with an answer to a value in this line. What is none by itself is refused where it stands; what
/// only contradicts another number may be refused there.
fn fault(taken: Result<(), Refused>, line: usize, value: &str) -> Option<String> {
    let (error, placed) = match taken {
        Ok(()) => return None,
        Err(Refused::Broken(what)) => return Some(what),
        Err(Refused::Read(error)) => (error, true),
        Err(Refused::Use(error)) => (error, false),
    };
    let text = error.to_string();
    if !text.contains("\n  help: ") {
        return Some(format!("refused without help: {text}"));
    }
    // An infinite limit is a limit; where it contradicts the other one, it may be refused there.
    let is_limit =
        value == "inf" && ["the lower limit inf", "no number lies between"].iter().any(|t| text.contains(t));
    let place = error.place().and_then(|p| Some((p.line?, p.column?)));
    match place {
        None if placed => Some(format!("refused without place: {text}")),
        Some((found, _))
            if placed && found != line && !is_limit && matches!(value, "NaN" | "inf" | "1e18") =>
        {
            Some(format!("is in line {line}: {text}"))
        }
        _ => None,
    }
}

/// Where numbers stand, and `None`, in whose place a number may stand too.
fn numbers(text: &str, quoted: bool) -> Vec<std::ops::Range<usize>> {
    let mut found = Vec::new();
    let (mut at, mut in_quotes) = (0, false);
    while at < text.len() {
        let rest = &text[at..];
        let first = rest.chars().next().expect("not at the end");
        let in_word = |c: char| c.is_alphanumeric() || matches!(c, '_' | '.' | '+' | '-');
        let length = rest.find(|c| !in_word(c)).unwrap_or(rest.len());
        let word = &rest[..length];
        if first == '"' && !quoted {
            in_quotes = !in_quotes;
        } else if rest.starts_with("//") && !in_quotes && !quoted {
            at += rest.find('\n').unwrap_or(rest.len());
            continue;
        } else if length > 0 && !in_quotes {
            if word.parse::<f64>().is_ok() || word == "None" {
                found.push(at..at + length);
            }
            at += length;
            continue;
        }
        at += first.len_utf8();
    }
    found
}
