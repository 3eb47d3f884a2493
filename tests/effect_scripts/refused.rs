//! Effect scripts that are refused, with place and remedy.

use super::{columns, motion, one, robot, scripted};

/// What the script is refused with: when it is read, or when its columns are asked for.
fn refusal(text: &str) -> lacuna::Error {
    let arm = robot("two_link.ron");
    match scripted(text) {
        Err(error) => error,
        Ok(effect) => columns(&effect, &arm, &motion(400), 400).expect_err(text),
    }
}

#[track_caller]
fn refused(text: &str, place: (usize, usize), words: &[&str]) {
    let error = refusal(text);
    let told = error.to_string();
    let found = error.place().unwrap_or_else(|| panic!("no place: {told}"));
    assert_eq!((found.line, found.column), (Some(place.0), Some(place.1)), "{told}");
    assert!(told.contains("test.rhai") && told.contains("help:"), "{told}");
    for word in words {
        assert!(told.contains(word), "`{word}` is missing: {told}");
    }
}

#[test]
fn columns_must_be_one_number_per_parameter() {
    refused(&one("[now.dq, 1.0]"), (2, 4), &["2 numbers for 1 parameters", "for each of k"]);
    refused(&one("[]"), (2, 4), &["0 numbers"]);
    refused(&one("let x = 1;"), (2, 4), &["returns nothing among"]);
    refused(&one("[now.dq > 0.0]"), (3, 9), &["decides nothing", "after `if`"]);
    refused(&one("[true]"), (2, 4), &["true or false", "sign(x)"]);
    refused(&one("\"k\""), (2, 4), &["a text"]);
    refused(&one("if now.dq > 0.0 { [1.0] }"), (2, 4), &["returns nothing"]);
    refused(&one("if now.dq > 0.0 { [1.0] } else { [1.0, 2.0] }"), (2, 4), &["2 numbers"]);
}

#[test]
fn names_are_checked() {
    refused(&one("[now.dq_shrp]"), (3, 6), &["did you mean `dq_sharp`", "ddq", "load"]);
    refused(&one("[noww.dq]"), (3, 2), &["did you mean `now`"]);
    refused(&one("[joint.dq]"), (3, 8), &["a joint has no `dq`", "number"]);
    refused(&one("[now.joint(\"elbow\").q]"), (3, 6), &["joint1, joint2"]);
    refused(&one("[now.joint(3).q]"), (3, 6), &["no joint 3", "1 to 2"]);
    refused(&one("[squar(now.dq)]"), (3, 2), &["no function `squar"]);
    refused(&one("[memory.heat]"), (3, 9), &["heat"]);
    let told = refusal(&one("[now.channel(\"humidity\")]")).to_string();
    assert!(told.contains("no channel `humidity` or `humidity1`") && told.contains("no channels"), "{told}");
}

#[test]
fn what_never_ends_or_reaches_outside_is_stopped() {
    refused(&one("loop { let x = 1; }"), (3, 1), &["come to an end"]);
    refused(&one("let x = now.dq; while x > 0.0 { x -= 1.0; }\n[x]"), (3, 25), &["64 times"]);
    refused(&one("import \"x\" as y; [1.0]"), (3, 1), &["import"]);
    refused(&one("[open_file(\"x\")]"), (3, 2), &["no function"]);
}

#[test]
fn what_is_no_number_is_refused_when_it_meets_the_data() {
    let told = refusal(&one("[sqrt(now.dq)]")).to_string();
    for part in ["test.rhai", "column of `k`", "joint1", "t = ", "guard it"] {
        assert!(told.contains(part), "`{part}` is missing: {told}");
    }
    refused(&one("[sqrt(-1.0)]"), (3, 2), &["not a finite number"]);
    refused(&one("[now.dq / 0.0]"), (3, 9), &["division by zero"]);
}

#[test]
fn about_is_checked() {
    let about = |inside: &str| {
        format!("fn about() {{ #{{ {inside} }} }}\nfn columns(joint, now, memory, with) {{ [1.0] }}")
    };
    let words = "title: \"t\", text: \"t\", equation: \"e\"";
    let fine = "parameters: [#{ symbol: \"k\", unit: \"N m\", meaning: \"m\" }]";
    assert!(scripted(&about(&format!("{words}, {fine}"))).is_ok());
    for (inside, words) in [
        (fine.to_string(), "`title` is missing"),
        (format!("{words}, {fine}, author: \"me\""), "`author` is unknown"),
        (words.to_string(), "no parameters"),
        (format!("{words}, parameters: 3"), "is a list"),
        (
            format!("{words}, parameters: [#{{ symbol: \"k1\", unit: \"1\", meaning: \"m\" }}]"),
            "ends in a digit",
        ),
        (format!("{words}, parameters: [#{{ symbol: \"k\", meaning: \"m\" }}]"), "`unit` is missing"),
        (
            format!(
                "{words}, parameters: [#{{ symbol: \"k\", unit: \"1\", meaning: \"m\", min: 2.0, max: 1.0 }}]"
            ),
            "min 2 is larger than max 1",
        ),
        (
            format!("{words}, {fine}, shapes: [#{{ symbol: \"s\", unit: \"s\", meaning: \"m\" }}]"),
            "`value` is missing",
        ),
        (
            format!(
                "{words}, {fine}, shapes: [#{{ symbol: \"s\", unit: \"s\", meaning: \"m\", value: 3, min: 0, max: 1 }}]"
            ),
            "outside of 0 to 1",
        ),
        (
            format!(
                "{words}, {fine}, shapes: [#{{ symbol: \"k\", unit: \"s\", meaning: \"m\", value: 1, min: 0, max: 1 }}]"
            ),
            "stands twice",
        ),
        (format!("{words}, {fine}, memory: #{{ heat: \"hot\" }}"), "map of plain numbers"),
        (format!("{words}, {fine}, memory: #{{ heat: 0.0 }}"), "there is no `remember`"),
    ] {
        let error = scripted(&about(&inside)).expect_err(&inside);
        let told = error.to_string();
        assert!(told.contains(words) && told.contains("help:"), "{inside}: {told}");
        assert_eq!(error.place().and_then(|p| p.line), Some(1), "{told}");
    }
    refused("fn about() { #{} }", (1, 1), &["no `columns`", "fn columns(joint, now, memory, with)"]);
    refused(&one("[1.0]").replace("memory, with", "with"), (2, 4), &["4 arguments"]);
}

#[test]
fn memory_must_be_kept_whole() {
    let with = |remember: &str| {
        let text =
            one("[memory.a + memory.b]").replace("parameters:", "memory: #{ a: 0.0, b: 1.0 }, parameters:");
        format!("{text}\nfn remember(joint, now, memory, with) {{ {remember} }}")
    };
    assert!(scripted(&with("#{ a: memory.b, b: now.q }")).is_ok());
    refused(&with("#{ a: memory.a }"), (5, 4), &["forgets `b`", "a, b"]);
    refused(&with("#{ a: memory.a, b: memory.b, c: 1.0 }"), (5, 4), &["`c`"]);
    refused(&with("[1.0]"), (5, 4), &["returns a list"]);
    let growing = refusal(&with("#{ a: 1e200 * (memory.a + 1.0) * 1e200, b: memory.b }")).to_string();
    assert!(growing.contains("not a finite number"), "{growing}");
    let idle = one("[1.0]") + "\nfn remember(joint, now, memory, with) { #{} }";
    refused(&idle, (5, 4), &["lists no memory"]);
}
