//! Changes of the structure of a text, and how long they are tried; for every reader, and for the steps that a workbench
//! goes on from.

use std::time::{Duration, Instant};

use proptest::prelude::*;
use proptest::sample::Index;
use proptest::test_runner::{TestError, TestRunner};

/// Cases between two looks at the clock.
const PORTION: u32 = 50;

/// A change of structure: what is done, where, how often, and with what.
pub(crate) type Change = (u8, Index, Index, usize, usize);

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let change = (0..9_u8, any::<Index>(), any::<Index>(), 0..TOKENS.len(), 0..8_usize);
    prop::collection::vec(change, 1..5)
}

/// What stands in the place of a value.
const TOKENS: [&str; 40] = [
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "-1",
    "0",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "inf",
    "-inf",
    "1_000",
    "0x10",
    "1e3",
    "()",
    "[]",
    "{}",
    "[[]]",
    "(())",
    "\"\"",
    "\"text\"",
    "All",
    "None",
    "Some(1)",
    "true",
    "'c'",
    "\"\\u{1b}[31m\"",
    "\"\\q\"",
    "\"\u{1b}[2J\u{202e}\"",
    "\u{0}",
    "\u{feff}",
    "/*",
    "//",
    "r#\"",
    ",",
    "Only([])",
    "LONG",
    "\"LONG\"",
    "\"../../../etc/passwd\"",
];

/// Words, texts in quotes, and single characters.
fn lexed(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = text;
    let is_word = |c: char| c.is_alphanumeric() || "_.+-".contains(c);
    while let Some(first) = rest.chars().next() {
        let length = if first == '"' {
            rest[1..].find('"').map_or(rest.len(), |end| end + 2)
        } else if is_word(first) {
            rest.find(|c| !is_word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        tokens.push(rest[..length].to_string());
        rest = &rest[length..];
    }
    tokens
}

/// Places of what holds a value: words and texts.
fn values(tokens: &[String]) -> Vec<usize> {
    let holds =
        |t: &String| t.starts_with('"') || t.starts_with(|c: char| c.is_alphanumeric() || "_.+-".contains(c));
    (0..tokens.len()).filter(|&i| holds(&tokens[i])).collect()
}

/// The end of the bracket that opens at `start`.
fn closing(tokens: &[String], start: usize) -> usize {
    let mut depth = 0_i32;
    for (i, token) in tokens.iter().enumerate().skip(start) {
        match token.as_str() {
            "(" | "[" | "{" | "<" => depth += 1,
            ")" | "]" | "}" | ">" => depth -= 1,
            _ => {}
        }
        if depth <= 0 {
            return i;
        }
    }
    tokens.len() - 1
}

pub(crate) fn changed(text: &str, most_copies: usize, changes: &[Change]) -> String {
    let mut tokens = lexed(text);
    for (kind, place, other, token, size) in changes {
        let all = values(&tokens);
        if all.is_empty() {
            break;
        }
        let (i, j) = (all[place.index(all.len())], all[other.index(all.len())]);
        let token = TOKENS[*token].replace("LONG", &"x1".repeat(2048));
        let brackets: Vec<usize> =
            (0..tokens.len()).filter(|&i| ["(", "[", "{", "<"].contains(&tokens[i].as_str())).collect();
        let group = (!brackets.is_empty()).then(|| brackets[place.index(brackets.len())]);
        match (kind, group) {
            (0..=3, _) => tokens[i] = token,
            (4, _) => tokens.swap(i, j),
            (5, Some(start)) => drop(tokens.drain(start..=closing(&tokens, start))),
            (6, Some(start)) => {
                let copy = tokens[start..=closing(&tokens, start)].join("");
                tokens.insert(
                    start,
                    format!("{copy},").repeat([1, 2, 3, 10, 50, 100, 200, 400][*size].min(most_copies)),
                );
            }
            (7, _) => {
                let opened = ["(", "[", "{\"a\":", "Some(", "-", "!", "fn(x){", "<a>"][*size];
                tokens.insert(i, opened.repeat([1, 3, 20, 130, 300, 2000, 10_000, 60_000][other.index(8)]));
            }
            _ => tokens.insert(i, token),
        }
    }
    tokens.concat()
}

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok().and_then(|n| n.parse().ok())
}

/// Time to look for, where one is given.
fn budget() -> Option<Duration> {
    let slow = std::env::var("LACUNA_SLOW").is_ok_and(|v| v == "1").then_some(1200);
    number("LACUNA_FUZZ_SECONDS").or(slow).map(Duration::from_secs)
}

/// Tries changed texts until the cases, or the time, are used up; answers how many it were.
pub(crate) fn attack(
    name: &str,
    usual: u32,
    share: u32,
    test: impl Fn(&[Change]) -> Result<(), TestCaseError>,
) -> u32 {
    let wanted = number("PROPTEST_CASES").map_or(usual, |n| n as u32);
    let until = budget().map(|all| Instant::now() + all / share);
    let mut done = 0;
    while until.map_or(done < wanted, |end| Instant::now() < end) {
        let cases = if until.is_some() { PORTION } else { PORTION.min(wanted - done) };
        let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
        match TestRunner::new(config).run(&changes(), |changes| test(&changes)) {
            Ok(()) => done += cases,
            Err(TestError::Fail(why, changes)) => panic!("{name}: {why}\n{changes:?}"),
            Err(TestError::Abort(why)) => panic!("{name}: {why}"),
        }
    }
    println!("{name}: {done} cases");
    done
}
