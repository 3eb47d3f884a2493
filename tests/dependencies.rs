//! What the program depends on is what deny.toml allows: licences, and crates that stand in the lock file more than
//! once. cargo-deny checks the same and more, where it is installed.

use std::collections::{BTreeMap, BTreeSet};
use std::process::Command;

use serde_json::Value;

fn read(file: &str) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{file}: {e}"))
}

/// The lines of the list `name = [ .. ]` of a section, without comments.
fn list(text: &str, section: &str, name: &str) -> Vec<String> {
    let head = format!("[{section}]");
    let lines =
        text.lines().skip_while(|line| *line != head).skip(1).take_while(|line| !line.starts_with('['));
    let list =
        lines.skip_while(|line| *line != format!("{name} = [")).skip(1).take_while(|line| *line != "]");
    list.map(|line| line.trim().to_string()).filter(|line| !line.starts_with('#')).collect()
}

/// The texts in double quotes.
fn quoted(line: &str) -> Vec<String> {
    line.split('"').skip(1).step_by(2).map(str::to_string).collect()
}

/// Whether an SPDX expression can be met with the licences that are allowed; `/` is how `OR` was written before.
fn is_met(expression: &str, allowed: &dyn Fn(&str) -> bool) -> bool {
    let spaced = expression.replace('(', " ( ").replace(')', " ) ").replace('/', " OR ");
    let tokens: Vec<&str> = spaced.split_whitespace().collect();
    let mut rest = tokens.as_slice();
    let met = alternatives(&mut rest, allowed);
    assert!(rest.is_empty(), "`{expression}` is no licence expression");
    met
}

fn alternatives(rest: &mut &[&str], allowed: &dyn Fn(&str) -> bool) -> bool {
    let mut met = all(rest, allowed);
    while let Some(after) = rest.strip_prefix(&["OR"]) {
        *rest = after;
        met |= all(rest, allowed);
    }
    met
}

fn all(rest: &mut &[&str], allowed: &dyn Fn(&str) -> bool) -> bool {
    let mut met = one(rest, allowed);
    while let Some(after) = rest.strip_prefix(&["AND"]) {
        *rest = after;
        met &= one(rest, allowed);
    }
    met
}

fn one(rest: &mut &[&str], allowed: &dyn Fn(&str) -> bool) -> bool {
    let (first, after) = rest.split_first().expect("a licence");
    *rest = after;
    if *first == "(" {
        let met = alternatives(rest, allowed);
        *rest = rest.strip_prefix(&[")"]).expect("a closing bracket");
        return met;
    }
    if let Some([_, after @ ..]) = rest.strip_prefix(&["WITH"]) {
        // An exception only adds permissions.
        *rest = after;
    }
    allowed(first.trim_end_matches('+'))
}

#[test]
fn expressions_of_licences_are_read() {
    let allowed = |name: &str| ["MIT", "Zlib"].contains(&name);
    for met in ["MIT", "MIT/Apache-2.0", "X OR MIT", "(X OR MIT) AND Zlib", "MIT+", "X WITH Y OR MIT"] {
        assert!(is_met(met, &allowed), "{met}");
    }
    for unmet in ["X", "MIT AND X", "(MIT OR X) AND X", "X OR Y", "X OR MIT AND X"] {
        assert!(!is_met(unmet, &allowed), "{unmet}");
    }
}

/// All packages that are built for this machine.
fn packages() -> Vec<Value> {
    let version = Command::new("rustc").arg("-vV").output().expect("there is a compiler");
    let version = String::from_utf8(version.stdout).expect("text");
    let host = version.lines().find_map(|line| line.strip_prefix("host: ")).expect("it names its host");
    let told = ["metadata", "--offline", "--locked", "--format-version", "1", "--filter-platform", host];
    let output = Command::new(env!("CARGO")).args(told).output().expect("there is cargo");
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let metadata: Value = serde_json::from_slice(&output.stdout).expect("JSON");
    metadata["packages"].as_array().expect("a list").clone()
}

#[test]
fn every_licence_is_allowed_and_every_allowance_is_used() {
    let deny = read("deny.toml");
    let allowed: BTreeSet<String> = list(&deny, "licenses", "allow").iter().flat_map(|l| quoted(l)).collect();
    let exceptions: BTreeMap<String, Vec<String>> = list(&deny, "licenses", "exceptions")
        .iter()
        .map(|l| (quoted(l)[0].clone(), quoted(l)[1..].to_vec()))
        .collect();
    let packages = packages();
    assert!(allowed.len() > 3 && exceptions.len() == 1 && packages.len() > 100, "deny.toml is not read");
    for package in &packages {
        let name = package["name"].as_str().expect("a name");
        let licence = package["license"].as_str().unwrap_or_else(|| panic!("{name} names no licence"));
        let own = exceptions.get(name).cloned().unwrap_or_default();
        let fine = |licence: &str| allowed.contains(licence) || own.iter().any(|l| l == licence);
        assert!(is_met(licence, &fine), "{name} is under {licence}, which deny.toml does not allow");
    }
    for licence in &allowed {
        let named = |p: &&Value| p["license"].as_str().is_some_and(|l| l.contains(licence.as_str()));
        assert!(
            packages.iter().find(named).is_some(),
            "nothing is under {licence}: take it out of deny.toml"
        );
    }
}

#[test]
fn no_crate_stands_twice_without_a_reason() {
    let mut versions: BTreeMap<String, Vec<String>> = BTreeMap::new();
    for package in read("Cargo.lock").split("[[package]]\n").skip(1) {
        let words: Vec<String> = package.lines().take(2).flat_map(quoted).collect();
        versions.entry(words[0].clone()).or_default().push(words[1].clone());
    }
    let mut skipped: BTreeMap<String, bool> = BTreeMap::new();
    for line in list(&read("deny.toml"), "bans", "skip") {
        let words = quoted(&line);
        assert!(words.len() == 2 && line.contains("reason = "), "no reason: {line}");
        skipped.insert(words[0].clone(), false);
    }
    let several = versions.iter().filter(|(_, all)| all.len() > 1);
    for (name, all) in several {
        let reasons = |version: &String| {
            let begins =
                |entry: &str| entry.split_once('@').is_some_and(|(n, v)| n == name && under(version, v));
            skipped.keys().find(|entry| begins(entry)).cloned()
        };
        let explained: Vec<String> = all.iter().filter_map(reasons).collect();
        assert!(
            explained.len() + 1 >= all.len(),
            "{name} stands in versions {all:?}; deny.toml explains {explained:?}"
        );
        skipped.extend(explained.into_iter().map(|entry| (entry, true)));
    }
    let idle: Vec<_> = skipped.iter().filter(|(_, used)| !**used).collect();
    assert!(idle.is_empty(), "deny.toml explains what stands there once: {idle:?}");
}

/// Whether `version` is `wanted` or a release of it.
fn under(version: &str, wanted: &str) -> bool {
    version == wanted || version.strip_prefix(wanted).is_some_and(|rest| rest.starts_with('.'))
}
