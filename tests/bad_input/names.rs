//! Names that steer a terminal, and names that fill the screen: of robots, joints, columns, models and files, in scripts
//! and on the command line.

use super::folder::{ARM, Answer, Folder, MODEL, SIMULATED};

/// Colours, clears the screen, sets the window's title, goes back in the line, and turns the direction of reading.
const BAD: &str = "x\u{1b}[31m\u{1b}[2J\u{1b}]0;owned\u{7}\r\u{8}\u{9b}2J\u{7f}\u{202e}\u{2066}y";

fn steers(c: char) -> bool {
    c.is_control() && c != '\n' || matches!(c, '\u{202a}'..='\u{202e}' | '\u{2066}'..='\u{2069}')
}

#[track_caller]
fn harmless(folder: &Folder, arguments: &[&str]) -> Answer {
    let answer = folder.run(arguments);
    for (stream, text) in [("stdout", &answer.out), ("stderr", &answer.err)] {
        let bad = text.lines().find(|line| line.chars().any(steers));
        assert!(bad.is_none(), "{arguments:?}: {stream} has {bad:?}");
    }
    assert!(!answer.out.is_empty() || !answer.err.is_empty(), "{arguments:?} said nothing");
    answer
}

/// The text as RON or Rust writes it between quotes.
fn quoted(text: &str) -> String {
    text.chars().map(|c| if steers(c) { c.escape_unicode().to_string() } else { c.to_string() }).collect()
}

#[test]
fn no_name_steers_the_terminal() {
    let folder = Folder::new();
    let arm = ARM.replacen("\"arm\"", &format!("\"{}\"", quoted(BAD)), 1);
    let named = arm.replacen("(a: 0.5", &format!("(name: \"{}\", a: 0.5", quoted(BAD)), 1);
    folder.write("named.ron", &named);
    folder.write("bad.ron", &arm);
    folder.write("study.ron", format!("(robot: \"bad.ron\", logs: {SIMULATED})"));
    folder.write("model_of.ron", MODEL.replacen("\"arm\"", &format!("\"{}\"", quoted(BAD)), 1));
    folder.write("joint.ron", MODEL.replacen("\"joint2\"", &format!("\"{}\"", quoted(BAD)), 1));
    folder.write("unit.ron", MODEL.replacen("\"fo2\"", &format!("\"{}\"", quoted(BAD)), 1));
    folder.write("raw.ron", MODEL.replacen("\"fo2\"", &format!("\"{BAD}\""), 1));
    folder.write("head.csv", format!("t,q1,q2,tau1,tau2,{BAD}\n0,0,0,0,0,0\n"));
    folder.write("field.csv", format!("t,q1,q2,tau1,tau2\n0,0,0,0,{BAD}\n"));
    folder.write(
        "bad.urdf",
        format!("<robot name='{}'><link name='a'/><link name='{}'/></robot>", "&#x9b;2J&#x202e;", "&#x7f;"),
    );
    folder.write(
        "rule.rhai",
        format!("fn about() {{ throw \"{}\" }}\nfn holds(links) {{ [] }}\n", quoted(BAD)),
    );
    folder.write("raw.rhai", format!("fn about() {{ {BAD} }}\n"));
    folder
        .write("error.rhai", format!("fn about() {{ #{{\"{}\": 1}} }}\nfn holds(l) {{ [] }}\n", quoted(BAD)));
    let log = ["--data", "log.csv"];
    for file in ["bad.ron", "named.ron", "study.ron", "model_of.ron", "unit.ron", "raw.ron", "bad.urdf"] {
        harmless(&folder, &["check", file]);
        harmless(&folder, &["check", file, "--json"]);
    }
    for file in ["head.csv", "field.csv", "rule.rhai", "raw.rhai", "error.rhai"] {
        harmless(&folder, &["check", file]);
        harmless(&folder, &["check", file, "--robot", "arm.ron"]);
        harmless(&folder, &["check", file, "--robot", "arm.ron", "--json"]);
    }
    for model in ["model_of.ron", "joint.ron", "unit.ron", "raw.ron"] {
        harmless(&folder, &[&["compare", model, "--robot", "arm.ron"], &log[..]].concat());
        harmless(&folder, &["export", model, "--robot", "arm.ron", "--format", "urdf"]);
    }
    let study = harmless(&folder, &["scenario", "study.ron", "--out", "out"]);
    assert_eq!(study.code, Some(0), "{}", study.err);
    let json = harmless(&folder, &["scenario", "study.ron", "--out", "out", "--json"]);
    assert!(json.out.contains("\\u009b") && serde_json::from_str::<serde_json::Value>(&json.out).is_ok());
    harmless(&folder, &["dynamics", "--robot", "named.ron", "--states", "states.csv"]);
    harmless(&folder, &[&["diagnose", "--robot", "named.ron"], &log[..]].concat());
}

#[test]
fn no_argument_steers_the_terminal() {
    let folder = Folder::new();
    for arguments in arguments(BAD) {
        let arguments: Vec<&str> = arguments.iter().map(String::as_str).collect();
        let answer = harmless(&folder, &arguments);
        assert_eq!(answer.code, Some(2), "{arguments:?}: {}", answer.err);
    }
}

/// Every flag and place of every command, with this word.
fn arguments(word: &str) -> Vec<Vec<String>> {
    let commands: [&[&str]; 25] = [
        &["WORD"],
        &["--WORD"],
        &["scenario", "WORD"],
        &["scenario", "files.ron", "--data", "WORD"],
        &["scenario", "good.ron", "--seed", "WORD"],
        &["scenario", "good.ron", "--jobs", "WORD"],
        &["check", "WORD"],
        &["check", "log.csv", "--robot", "WORD"],
        &["check", "log.csv", "--robot", "arm.ron", "--gravity", "WORD"],
        &["compare", "WORD", "--robot", "arm.ron", "--data", "log.csv"],
        &["compare", "model.ron", "--robot", "arm.ron", "--data", "log.csv", "--columns", "WORD"],
        &["compare", "model.ron", "--robot", "arm.ron", "--data", "log.csv", "--gravity", "WORD"],
        &["diagnose", "--robot", "arm.ron", "--data", "log.csv", "--add", "WORD"],
        &["diagnose", "--robot", "arm.ron", "--data", "log.csv", "--add", "backlash:WORD"],
        &["diagnose", "--robot", "arm.ron", "--data", "log.csv", "--try", "WORD"],
        &["diagnose", "--robot", "arm.ron", "--data", "log.csv", "--model", "WORD"],
        &["diagnose", "--robot", "arm.ron", "--data", "log.csv", "--band", "WORD"],
        &["list", "WORD"],
        &["list", "effects", "WORD"],
        &["list", "engines", "WORD"],
        &["list", "constraints", "WORD"],
        &["benchmark", "--part", "WORD"],
        &["export", "model.ron", "--robot", "arm.ron", "--format", "WORD"],
        &["workbench", "--port", "WORD"],
        &["simulate", "WORD"],
    ];
    commands.iter().map(|c| c.iter().map(|part| part.replace("WORD", word)).collect()).collect()
}

#[test]
fn no_argument_fills_the_screen() {
    let folder = Folder::new();
    for word in ["x".repeat(4096), "x y ".repeat(1024), "é".repeat(2000)] {
        for arguments in arguments(&word) {
            let answer = folder.run(&arguments);
            let said = (arguments[0].chars().take(9).collect::<String>(), arguments.len());
            let all = format!("{}{}", answer.out, answer.err);
            assert_eq!(answer.code, Some(2), "{said:?}: {all}");
            assert!(all.len() < 1400, "{said:?}: {all}");
        }
    }
}

/// What reads a file prints what is wrong with it once.
#[test]
fn an_unusable_file_is_told_once() {
    let folder = Folder::new();
    folder.write("bad.ron", "(robot: \"arm.ron\", sead: 3)");
    let answer = folder.run(&["check", "bad.ron"]);
    assert_eq!((answer.code, answer.err.as_str()), (Some(2), ""));
    assert_eq!(answer.out.matches("no field `sead`").count(), 1, "{}", answer.out);
    let json = folder.run(&["check", "bad.ron", "--json"]);
    assert!(
        json.code == Some(2) && json.err.contains("no field `sead`"),
        "one stream for programs, one for people"
    );
    folder.refused(&["check", "nothing.ron"], "nothing.ron: ", &["cannot read"]);
}

/// Every word of every kind of file, made very long: whatever is said of it can be read.
#[test]
fn no_word_of_a_file_fills_the_screen() {
    let folder = Folder::new();
    let shipped = |file: &str| std::fs::read_to_string(file).expect("it is shipped");
    let files = [
        ("arm.ron", ARM.to_string()),
        (
            "study.ron",
            format!(
                "(robot: \"arm.ron\", logs: {SIMULATED}, effects: [{{\"rigid_body\": ()}}, {{\"torque_offset\": (joints: Only([\"1\"]))}}], engines: [{{\"penalty\": (runs: 2, label: \"a\")}}], constraints: [{{\"mass_range\": (links: Only([\"link1\"]), min: 0, max: 9)}}])"
            ),
        ),
        ("map.ron", shipped("tests/fixtures/logs/degrees.ron")),
        ("log.csv", shipped("tests/fixtures/logs/named.csv").lines().take(3).collect::<Vec<_>>().join("\n")),
        ("good.urdf", shipped("tests/fixtures/robots/good.urdf")),
        ("table.ron", shipped("scenarios/panda_table3.ron").chars().take(1500).collect::<String>() + "]"),
        ("model.ron", MODEL.to_string()),
        ("rule.rhai", shipped("constraints/total_mass.rhai")),
        ("effect.rhai", shipped("effects/quadratic_friction.rhai")),
        (
            "list.ron",
            "[{\"mass_range\": (links: Only([\"link1\"]), min: 0, max: 9)}, {\"positive_mass\": ()}]"
                .to_string(),
        ),
    ];
    let options = lacuna::check::Options { robot: Some("robots/two_link.ron".into()), ..Default::default() };
    let mut said = 0;
    for (name, text) in &files {
        for (number, spoiled) in spoiled(text).enumerate() {
            folder.write(name, &spoiled);
            for options in [&options, &lacuna::check::Options::default()] {
                let report = lacuna::check::file(&folder.path(name), options);
                for problem in &report.problems {
                    assert!(problem.text.len() < 2000, "{name}, word {number}: {}", problem.text);
                    said += 1;
                }
                let long = report.remarks.iter().find(|r| r.len() > 2000);
                assert!(long.is_none(), "{name}, word {number}: {long:?}");
            }
        }
    }
    assert!(said > 300, "only {said} problems");
}

/// The text with one word after the other made very long.
fn spoiled(text: &str) -> impl Iterator<Item = String> + '_ {
    let is_word = |c: char| c.is_alphanumeric() || "_.-".contains(c);
    let starts = text.char_indices().filter(move |(i, c)| is_word(*c) && !text[..*i].ends_with(is_word));
    starts.map(move |(start, _)| {
        let rest = &text[start..];
        let end = start + rest.find(|c| !is_word(c)).unwrap_or(rest.len());
        format!("{}{}{}", &text[..start], "x1".repeat(2048), &text[end..])
    })
}
