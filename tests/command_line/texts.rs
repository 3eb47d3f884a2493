//! What is printed fits a screen of 80 columns, and wrong files, typos and idle flags are answered with what to do.

use super::folder::{Answer, Folder};

/// Lines wider than the screen.
fn wide(answer: &Answer) -> Vec<&str> {
    answer.out.lines().filter(|line| line.chars().count() > 80).collect()
}

#[track_caller]
fn narrow(folder: &Folder, arguments: &[&str]) -> String {
    let answer = folder.run(arguments);
    assert!(answer.code == Some(0) || answer.code == Some(1), "{arguments:?}: {}", answer.err);
    assert_eq!(wide(&answer), [""; 0], "{arguments:?}");
    answer.out
}

#[test]
fn lists_and_everything_in_them_fit_the_screen() {
    let folder = Folder::new();
    for what in ["effects", "constraints", "engines"] {
        let all = narrow(&folder, &["list", what]);
        // Names begin lines; what is wrapped is indented, the last line says how to go on.
        let names = all.lines().take_while(|line| !line.is_empty()).filter(|line| !line.starts_with(' '));
        let names: Vec<&str> = names.filter_map(|line| line.split_whitespace().next()).collect();
        assert!(names.len() >= 4, "{all}");
        for name in names {
            let one = narrow(&folder, &["list", what, name]);
            assert!(one.starts_with(&format!("{name}: ")));
            if what != "effects" {
                shows_how_to_write_it(&folder, what, name, &one);
            }
        }
    }
    for command in ["scenario", "diagnose", "compare", "check", "list", "export", "dynamics", "simulate"] {
        narrow(&folder, &[command, "--help"]);
    }
}

/// What stands under "in a scenario" is a part of one, and names what was asked for.
#[track_caller]
fn shows_how_to_write_it(folder: &Folder, what: &str, name: &str, printed: &str) {
    let (_, example) = printed.split_once("\nin a scenario\n").expect("an example");
    let scenario = format!("(robot: \"r\", {example})");
    let read: lacuna::scenario::Scenario = lacuna::text::from_ron(&scenario).expect(&scenario);
    let names = match what {
        "engines" => read.engines.iter().map(|engine| engine.name()).collect::<Vec<_>>(),
        _ => read.constraints.iter().map(|constraint| constraint.about().name).collect(),
    };
    assert_eq!(names, [name]);
    let json = folder.run(&["list", what, name, "--json"]);
    let json: serde_json::Value = serde_json::from_str(&json.out).expect("JSON");
    let without_blanks = |text: &str| text.split_whitespace().collect::<String>();
    let entry = without_blanks(json["example"].as_str().expect("a text"));
    assert!(without_blanks(example).contains(&entry), "{example}");
}

#[test]
fn studies_comparisons_and_diagnoses_fit_the_screen() {
    let folder = Folder::new();
    let study = narrow(&folder, &["scenario", "good.ron", "--quiet"]);
    assert!(study.contains("out/good/report.html") && study.contains("identified coefficients"), "{study}");
    let model = "out/good/model.ron";
    let compare = ["compare", model, "model.ron", "--robot", "arm.ron", "--data", "log.csv"];
    let table = narrow(&folder, &compare);
    let place = |label: &str| table.find(label).unwrap_or_else(|| panic!("{label} is not in {table}"));
    assert!(place(model) < place("model 2  model.ron") && table.contains("\npooled "), "{table}");
    assert_eq!(table.lines().filter(|line| line.starts_with("joint") && line.contains('*')).count(), 2);
    let flags = ["--robot", "arm.ron", "--data", "log.csv", "--quiet"];
    let found = narrow(&folder, &[&["diagnose"], &flags[..]].concat());
    assert!(found.contains("\nnext     lacuna "), "{found}");
    let added = narrow(&folder, &[&["diagnose", "--add", "joint_spring"], &flags[..]].concat());
    assert!(added.starts_with("added joint_spring on joint"), "{added}");
    assert!(
        added.lines().any(|line| line.ends_with("of it     added explained   repeats")),
        "no column of what was added: {added}"
    );
}

#[test]
fn files_of_the_wrong_kind_are_told_what_takes_them() {
    let folder = Folder::new();
    folder.write("rule.rhai", "fn about() { #{} }\nfn holds(links) { [] }\n");
    folder.write("arm.urdf", "<robot name=\"r\"></robot>");
    for (file, words) in [
        ("log.csv", ["a log of a moving robot (CSV)", "--data log.csv"]),
        ("arm.ron", ["a robot (Denavit-Hartenberg table)", "--robot arm.ron"]),
        ("arm.urdf", ["a robot (URDF)", "--robot arm.urdf"]),
        ("model.ron", ["a finished model", "lacuna compare model.ron"]),
        ("rule.rhai", ["a script of constraints", "lacuna check rule.rhai"]),
    ] {
        for command in ["scenario", "diagnose"] {
            folder.refused(
                &[command, file],
                &format!("{file}: this is {}, not a scenario", words[0]),
                &words,
            );
        }
    }
    let model = ["compare", "good.ron", "--robot", "arm.ron", "--data", "log.csv"];
    folder.refused(
        &model,
        "good.ron: this is a scenario, not a finished model",
        &["lacuna scenario good.ron"],
    );
    let robot = ["compare", "model.ron", "--robot", "log.csv", "--data", "log.csv"];
    folder.refused(
        &robot,
        "log.csv: this is a log of a moving robot (CSV), not a robot",
        &["--data log.csv"],
    );
    let data = ["diagnose", "--robot", "arm.ron", "--data", "model.ron"];
    folder.refused(&data, "model.ron: this is a finished model, not a log", &["--model model.ron"]);
    let both = ["diagnose", "log.csv", "--robot", "arm.ron"];
    folder.refused(&both, "log.csv: this is a log", &["--data log.csv"]);
    let again = ["scenario", "files.ron", "--data", "arm.ron"];
    folder.refused(&again, "arm.ron: this is a robot", &["not a log"]);
}

/// The log is not there: whoever reads it first complains of that instead.
#[test]
fn typos_are_answered_before_the_log_is_read() {
    let folder = Folder::new();
    let flags = ["diagnose", "--robot", "arm.ron", "--data", "absent.csv"];
    let refused = |more: &[&str], what: &str, words: &[&str]| {
        folder.refused(&[&flags[..], more].concat(), what, words);
    };
    let known = "did you mean `stribeck_friction`? known are rigid_body, ";
    refused(&["--add", "stribek_friction"], "--add: no effect called `stribek_friction`", &[known]);
    refused(
        &["--add", "backlash:jiont2"],
        "--add: no joint `jiont2`",
        &["did you mean `joint2`? known are joint1, "],
    );
    refused(&["--add", "rigid_body"], "--add: `rigid_body` cannot", &["every model has it"]);
    refused(&["--try", "backlash"], "--try backlash: not an effect script", &["--add backlash"]);
    refused(&["--try", "absent.rhai"], "absent.rhai: cannot read", &[]);
    refused(&["--model", "clasic"], "--model: no model called `clasic`", &["did you mean `classic`?"]);
    folder.refused(&["list", "effects", "payloda"], "no effect", &["did you mean `payload`? known are "]);
    let columns = ["check", "log.csv", "--columns", "libfrank"];
    assert!(folder.run(&columns).out.contains("did you mean `libfranka`?"), "{}", folder.run(&columns).out);
    folder.refused(&["list", "efects"], "cannot list `efects`", &["did you mean `effects`?"]);
    folder.refused(&["list", "engines", "lmo"], "no engine", &["did you mean `lmi`?"]);
    folder.refused(&["list", "constraints", "totalmass"], "no constraint", &["did you mean `total_mass`?"]);
    folder.refused(&["benchmark", "--part", "strnog"], "--part", &["did you mean `strong`?"]);
}

#[test]
fn flags_that_do_nothing_are_not_offered_and_say_so() {
    let folder = Folder::new();
    let help = |command: &str| folder.run(&[command, "--help"]).out;
    for (command, offered, idle) in [
        ("scenario", &["--seed", "--resume", "--out", "--json", "--jobs"][..], &[][..]),
        ("diagnose", &["--seed", "--out", "--json", "--jobs"], &["--resume"]),
        ("compare", &["--json", "--quiet"], &["--seed", "--resume", "--out"]),
        ("check", &["--json"], &["--seed", "--resume", "--out"]),
        ("list", &["--json"], &["--seed", "--resume", "--out", "--jobs"]),
        ("export", &["--json", "--out"], &["--seed", "--resume", "--jobs"]),
        ("dynamics", &["--quiet"], &["--json", "--seed", "--resume", "--out", "--jobs"]),
    ] {
        let text = help(command);
        let has = |flag: &&&str| text.lines().any(|line| line.trim_start().starts_with(**flag));
        assert!(offered.iter().all(|f| has(&f)), "{text}");
        assert_eq!(idle.iter().filter(has).count(), 0, "{text}");
    }
    assert!(help("scenario").contains("report.html") && help("check").contains("a script of an effect"));
    assert!(help("export").contains("File to write"));
    let answer = folder.run(&["list", "effects", "--seed", "3", "--out", "x"]);
    assert_eq!(answer.code, Some(0));
    assert!(answer.err.contains("--seed does nothing here") && answer.err.contains("--out does nothing"));
    assert_eq!(folder.run(&["list", "effects", "--seed", "3", "--quiet"]).err, "");
    folder.refused(&["list", "effects", "--resume", "x"], "--resume: only", &[]);
}
