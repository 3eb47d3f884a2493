//! Scripts that must be refused, with place and remedy; nothing may hang, crash or drop a rule in silence.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;
use std::time::Instant;

use lacuna::constraints::{Constraint, Scripted};
use lacuna::script::{Script, Setting, Settings};

use super::{forms, link_rules, two_link};

/// The script is refused at `place` (line, column) and the message has all `words`.
#[track_caller]
fn refused(text: &str, place: (usize, usize), words: &[&str]) {
    let error = forms(text).expect_err("must be refused");
    let told = error.to_string();
    let found = error.place().unwrap_or_else(|| panic!("no place: {told}"));
    assert_eq!(found.file, "test.rhai", "{told}");
    assert_eq!((found.line, found.column), (Some(place.0), Some(place.1)), "{told}");
    assert!(told.contains("help:"), "no remedy: {told}");
    for word in words {
        assert!(told.contains(word), "`{word}` is missing: {told}");
    }
}

fn constrain(body: &str) -> String {
    format!("fn constrain(robot, links, with) {{\n{body}\n}}")
}

#[test]
fn what_never_ends_is_stopped() {
    let start = Instant::now();
    refused(&constrain("loop { let x = 1; }"), (2, 1), &["come to an end"]);
    refused(&constrain("let a = [1]; loop { a += a; }\n[]"), (2, 23), &["grows too large"]);
    refused(&constrain("let s = \"a\"; loop { s += s; }\n[]"), (2, 23), &["grows too large"]);
    refused(&constrain("let a = []; loop { a.push(1); }\n[]"), (2, 22), &["grows too large"]);
    let nested = constrain("let a = []; loop { a = [a]; }\n[]");
    let error = forms(&nested).expect_err("nested").to_string();
    assert!(error.contains("test.rhai:"), "{error}");
    let recursion = "fn f(x) { f(x) }\nfn constrain(robot, links, with) { f(1) }";
    refused(recursion, (1, 11), &["without end"]);
    assert!(start.elapsed().as_secs() < 20, "stopping took {:?}", start.elapsed());
}

#[test]
fn the_wall_clock_and_a_flag_stop_a_script() {
    let (robot, space) = two_link();
    let slow = constrain("let x = 0.0; for i in 0..400000 { x += 1.0; }\n[links[0].mass >= x]");
    let script = Script::new("test.rhai", slow);
    let mut short = Scripted::from_script(script.clone(), Settings::new());
    short.seconds = 1e-6;
    let error = short.forms(&robot, &space).expect_err("out of time").to_string();
    assert!(error.contains("took more than") && error.contains("test.rhai:2:14"), "{error}");
    let flag = Arc::new(AtomicBool::new(true));
    let stopped = Scripted::from_script(script, Settings::new()).cancelled_by(flag);
    let error = stopped.forms(&robot, &space).expect_err("cancelled").to_string();
    assert!(error.contains("stopped from outside"), "{error}");
}

#[test]
fn what_reaches_outside_is_no_part_of_the_language() {
    for (body, word) in [
        ("import \"x\" as y; []", "import"),
        ("eval(\"1\"); []", "eval"),
        ("print(\"x\"); []", "print"),
        ("debug(1); []", "debug"),
        ("try { } catch { } []", "try"),
        ("switch 1 { 1 => 2 } []", "switch"),
    ] {
        let error = forms(&constrain(body)).expect_err(word).to_string();
        assert!(error.contains(word) && error.contains("test.rhai:2:1"), "{error}");
    }
    for call in ["sleep(1)", "timestamp()", "open_file(\"x\")", "exit()"] {
        let error = forms(&constrain(&format!("{call}; []"))).expect_err(call).to_string();
        assert!(error.contains("no function"), "{error}");
    }
}

#[test]
fn what_is_no_list_of_rules_is_refused() {
    assert!(forms(&constrain("links[0].mass >= 1.0;")).is_ok(), "in rhai the last value counts even so");
    refused(&constrain(""), (1, 4), &["returns nothing"]);
    refused(&constrain("let x = 1;"), (1, 4), &["returns nothing", "list of rules"]);
    refused(&constrain("[]"), (1, 4), &["no rule"]);
    refused(&constrain("[links[0].mass]"), (1, 4), &["a number", "psd"]);
    refused(&constrain("\"heavy\""), (1, 4), &["a text"]);
    refused(&constrain("[links[0].mass >= 1.0,\n 2.0 >= 1.0]"), (3, 6), &["true or false"]);
    refused(&constrain("[true]"), (1, 4), &["true or false"]);
    refused(&constrain("[links[0].mass - links[0].mass >= -1.0]"), (2, 32), &["without unknowns"]);
    refused("let a = 1;\nfn constrain(robot, links, with) { [] }", (1, 1), &["outside of all functions"]);
    refused("fn other() { [] }", (1, 1), &["constrain(robot, links, with)", "only other"]);
    refused("fn constrain(links) { [] }", (1, 4), &["3 arguments"]);
    refused("", (1, 1), &["no function", "constrain_link"]);
}

#[test]
fn a_rule_that_would_be_lost_is_refused() {
    // Stated in a loop and forgotten.
    let body = "for link in links {\n link.mass >= 0.1;\n}\n[links[0].mass <= 5.0]";
    refused(&constrain(body), (3, 12), &["stated but not returned"]);
    refused(&constrain("let a = links[0].mass >= 1.0 && links[1].mass >= 1.0;\n[]"), (2, 23), &["holds"]);
    refused(&constrain("let heavy = links[0].mass > 2.0;\nif heavy { [] } else { [] }"), (3, 4), &["holds"]);
    refused(&constrain("[1.0 <= links[0].mass <= 2.0]"), (2, 23), &["two rules"]);
}

#[test]
fn comparisons_without_meaning_are_refused_for_every_pair_of_kinds() {
    let all = [
        "links[0].mass",
        "1.0",
        "1",
        "\"a\"",
        "true",
        "()",
        "links[0]",
        "robot",
        "links",
        "links[0].com",
        "links[0].inertia",
        "(links[0].mass >= 0.1)",
        "#{a: 1}",
    ];
    for op in ["<", "<=", ">", ">=", "==", "!="] {
        for (i, a) in all.iter().enumerate() {
            for (j, b) in all.iter().enumerate() {
                let numbers = i < 3 && j < 3;
                let same = (i == j && (3..5).contains(&i)) && matches!(op, "==" | "!=");
                if numbers || same {
                    continue;
                }
                let asked = format!("if {a} {op} {b} {{ [] }} else {{ [] }}");
                // After `if` the relation in brackets is true or false.
                let flags = [4, 11];
                let fine = flags.contains(&i) && flags.contains(&j) && matches!(op, "==" | "!=");
                for body in [format!("[{a} {op} {b}]"), asked].into_iter().take(if fine { 1 } else { 2 }) {
                    let error = forms(&constrain(&body)).expect_err(&body).to_string();
                    assert!(error.contains("test.rhai:2:"), "{body}: {error}");
                    assert!(error.contains("compare") || error.contains("comparison"), "{body}: {error}");
                }
            }
        }
    }
}

#[test]
fn comparisons_with_whole_numbers_are_rules_like_any_other() {
    let with_float = link_rules("[link.mass <= 4.0, link.mass > 1.0]").expect("rules");
    let with_whole = link_rules("[link.mass <= 4, 1 < link.mass]").expect("rules");
    assert_eq!((with_float.len(), with_whole.len()), (4, 4));
    let (robot, _) = two_link();
    let z = robot.inertial_parameters().expect("known");
    for (a, b) in with_float.iter().zip(&with_whole) {
        assert!((a.margin(&z) - b.margin(&z)).abs() < 1e-15);
    }
    assert!((with_whole[0].margin(&z) + 4.0).abs() < 1e-15, "8 kg are 4 kg too many");
}

#[test]
fn misspelled_names_come_with_what_is_known() {
    refused(&constrain("[links[0].mas >= 1.0]"), (2, 11), &["did you mean `mass`", "pseudo_inertia"]);
    refused(&constrain("[link.mass >= 1.0]"), (2, 2), &["did you mean `links`", "robot"]);
    refused(&constrain("[totalmass(links) >= 1.0]"), (2, 2), &["did you mean `total_mass`", "norm("]);
    refused(&constrain("[links[0].com.w >= 1.0]"), (2, 15), &["vector", "x, y, z"]);
    refused(&constrain("[named(links, \"elbow\").mass >= 1.0]"), (2, 2), &["link1, link2"]);
    refused(&constrain("[links[7].mass >= 1.0]"), (2, 8), &["7"]);
    refused(&constrain("[links[0].mass >= with.max]"), (2, 24), &["max"]);
    refused("const A = 1.0;\nfn constrain(robot, links, with) { [links[0].mass >= A] }", (2, 54), &["`A`"]);
}

#[test]
fn numbers_that_are_none_are_refused() {
    refused(&constrain("[links[0].mass >= sqrt(-1.0)]"), (2, 19), &["not a finite number"]);
    refused(&constrain("[links[0].mass >= 1.0 / 0.0]"), (2, 23), &["division by zero"]);
    refused(&constrain("[links[0].mass >= 1 / 0]"), (2, 21), &["division by zero"]);
    refused(&constrain("[links[0].mass / 0.0 >= 1]"), (2, 16), &["division by zero"]);
    refused(&constrain("[links[0].mass >= 1e308 * 10.0]"), (2, 16), &["not a finite number"]);
    refused(&constrain("[sqrt(links[0].com.x - 9.0) >= 1.0]"), (2, 29), &["not a number"]);
    let half = link_rules("[link.mass >= 1 / 2]").expect("1 / 2 is 0.5");
    assert!((half[0].scale - 0.5).abs() < 1e-15);
}

#[test]
fn units_that_do_not_fit_are_refused() {
    refused(&constrain("[links[0].mass + links[0].com.x >= 1.0]"), (2, 16), &["kg", "m"]);
    refused(&constrain("[links[0].first_moment.x >= links[0].mass]"), (2, 26), &["kg m"]);
    refused(&constrain("[sin(links[0].mass) >= 0.0]"), (2, 2), &["sin"]);
    assert!(link_rules("[link.first_moment.x <= 0.1 * link.mass]").is_ok(), "0.1 may be a length");
}

#[test]
fn syntax_errors_have_a_place() {
    refused("fn constrain(robot, links, with) {\n  [ links[0].mass >= ]\n}", (2, 22), &[]);
    refused("fn constrain(robot, links, with {\n}", (1, 33), &[]);
    let deep = format!("fn constrain(robot, links, with) {{ {}1{} }}", "(".repeat(200), ")".repeat(200));
    assert!(forms(&deep).expect_err("too deep").to_string().contains("nested"));
}

#[test]
fn settings_are_checked_against_the_script() {
    let (robot, space) = two_link();
    let text = "fn settings() { #{ most: 4.0 } }\n\
                fn constrain_link(robot, link, with) { [ link.mass <= with.most ] }";
    let with = |name: &str, value: Setting| {
        let settings = Settings::from([(name.to_string(), value)]);
        Scripted::from_script(Script::new("test.rhai", text), settings).forms(&robot, &space)
    };
    let forms = with("most", Setting::Whole(3)).expect("a whole number is a number");
    assert!((forms[0].scale - 3.0).abs() < 1e-15);
    let error = with("mots", Setting::Number(3.0)).expect_err("unknown").to_string();
    assert!(error.contains("`mots`") && error.contains("known are most"), "{error}");
    let error = with("most", Setting::Text("3".into())).expect_err("text").to_string();
    assert!(error.contains("is a number, not a text"), "{error}");
}

#[test]
fn too_many_ways_through_are_refused() {
    let body = "let x = 0.0;\nfor i in 0..20 {\n if links[0].mass > i { x += 1.0; }\n}\n[links[1].mass >= x]";
    refused(&constrain(body), (1, 4), &["combinations", "constrain_link"]);
    let endless = "let x = links[0].mass;\nwhile x > 0.0 { x -= 0.001; }\n[x >= 0.0]";
    refused(&constrain(endless), (3, 9), &["64 times"]);
}
