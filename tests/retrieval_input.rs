//! Retrievals that cannot work, and what the command line answers.

use std::path::Path;
use std::process::Command;

/// Exit code, standard output and standard error of a study of the Panda with these entries.
fn study(entries: &str) -> (Option<i32>, String, String) {
    study_beside(entries, &[])
}

/// The same with files, by name and content, beside the scenario.
fn study_beside(entries: &str, files: &[(&str, &[u8])]) -> (Option<i32>, String, String) {
    let folder = tempfile::tempdir().expect("a folder");
    for file in ["robots/panda.ron", "scenarios/panda_table3.ron", "scenarios/panda_bounds.ron"] {
        let name = Path::new(file).file_name().expect("a name");
        std::fs::copy(file, folder.path().join(name)).expect("shipped files copy");
    }
    for (name, content) in files {
        std::fs::write(folder.path().join(name), content).expect("writes");
    }
    let scenario = format!(
        r#"(robot: "panda.ron", drop_above_percent: 30.0,
            poses: ReadOut(coefficients: "panda_table3.ron", count: 200, noise_percent: 0.0315),
            {entries})"#
    );
    std::fs::write(folder.path().join("study.ron"), scenario).expect("writes");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    let output =
        command.current_dir(&folder).args(["scenario", "study.ron", "--quiet"]).output().expect("runs");
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (output.status.code(), text(&output.stdout), text(&output.stderr))
}

/// The study is refused with a message that has all these parts.
fn refused(entries: &str, parts: &[&str]) {
    refused_beside(entries, &[], parts);
}

fn refused_beside(entries: &str, files: &[(&str, &[u8])], parts: &[&str]) {
    let (code, _, message) = study_beside(entries, files);
    assert_eq!(code, Some(2), "{entries}: {message}");
    for part in parts {
        assert!(message.contains(part), "{entries}: {message}");
    }
}

#[test]
fn settings_that_make_no_sense_are_refused() {
    let bounds = r#"presets: ["panda_bounds.ron"]"#;
    refused(
        &format!(r#"{bounds}, engines: [{{"penalty": (runs: 0)}}]"#),
        &["`runs` is 0", "study.ron:3:", "give 1 to"],
    );
    refused(
        &format!(r#"{bounds}, engines: [{{"penalty_paper": (stages: 0)}}]"#),
        &["`stages` is 0", "study.ron:3:", "give 1 to"],
    );
    refused(
        &format!(r#"{bounds}, engines: [{{"penalty_paper": (cooling: 2.0)}}]"#),
        &["study.ron:3:", "`cooling` is 2", "give 0 to 1"],
    );
    refused(&format!(r#"{bounds}, engines: [{{"penalty": (run: 5)}}]"#), &["study.ron:3:", "run"]);
    refused(
        &format!(r#"{bounds}, engines: [{{"penalty": ()}}, {{"penalty": ()}}]"#),
        &["two engines", "label"],
    );
}

#[test]
#[cfg(not(feature = "nlopt"))]
fn an_engine_that_is_not_built_in_says_how_to_get_it() {
    refused(
        r#"engines: [{"penalty": (runs: 1)}, {"nlopt": ()}]"#,
        &["not part of this build", "--features nlopt"],
    );
}

#[test]
fn what_cannot_be_retrieved_from_or_compared_with_is_refused_at_once() {
    let engines = r#"presets: ["panda_bounds.ron"], engines: [{"penalty": (runs: 100)}]"#;
    refused(&format!(r#"{engines}, retrieve_from: "none.ron""#), &["study.ron", "none.ron"]);
    refused(&format!(r#"{engines}, retrieve_from: "panda.ron""#), &["panda.ron:"]);
    refused(
        &format!(r#"{engines}, retrieve_from: "panda_table3.ron", objective: Torque"#),
        &["`retrieve_from` gives coefficients", "leave one of the two out"],
    );
    refused(&format!(r#"{engines}, choice: Nearest(prior: "none.urdf")"#), &["none.urdf"]);
    refused(&format!(r#"{engines}, beside: ["panda.ron", "panda.ron"]"#), &["panda.ron", "two rows"]);
    let two = std::fs::read("robots/two_link.ron").expect("it is there");
    refused_beside(
        &format!(r#"{engines}, choice: Nearest(prior: "two.ron")"#),
        &[("two.ron", &two)],
        &["two.ron", "has 2 moving links, not 7", "same robot"],
    );
}

#[test]
fn bounds_that_leave_nothing_are_refused() {
    let swapped =
        r#"constraints: [{"parameter_bounds": (bounds: {"m1": (2.0, 1.0)})}], engines: [{"penalty": ()}]"#;
    refused(swapped, &["study.ron:3:", "lower limit 2 is above the upper limit 1"]);
    let beyond = r#"presets: ["panda_bounds.ron"],
        constraints: [{"parameter_bounds": (bounds: {"m1": (11.0, 12.0)})}], engines: [{"penalty": ()}]"#;
    // Each makes sense by itself: that they leave nothing is an answer, not a slip of the pen.
    let (code, shown, message) = study(beyond);
    assert_eq!(code, Some(1), "{message}");
    for part in ["no parameters satisfy these constraints together", "m1 >= 11 kg", "m1 <= 10 kg"] {
        assert!(shown.contains(part), "{shown}");
    }
}

#[test]
fn an_empty_list_of_constraints_is_no_constraint() {
    let (code, shown, message) = study(
        r#"constraints: [], engines: [{"penalty": (runs: 1)}, {"penalty_paper": (runs: 1, stages: 2)}]"#,
    );
    assert_eq!(code, Some(0), "{message}");
    assert!(shown.contains("0 of 0 constraints active"), "{shown}");
    assert!(shown.contains("it was assumed: m1 from"), "{shown}");
}

#[test]
fn contradictory_constraints_are_a_negative_answer() {
    let (code, shown, message) = study(
        r#"presets: ["panda_bounds.ron"], constraints: [{"total_mass": (min: 90.0, max: 95.0)}],
            engines: [{"penalty": (runs: 2, stages: 2)}]"#,
    );
    assert_eq!(code, Some(1), "{message}");
    // Though nothing but a search was asked for: the sum, and what keeps each of the seven masses below 10 kg.
    let listed = shown.split("satisfy these constraints together:").nth(1).expect("says so");
    let listed: Vec<&str> = listed.lines().skip(1).take_while(|l| l.starts_with("    ")).collect();
    assert_eq!(listed.len(), 8, "{shown}");
    assert_eq!(listed.iter().filter(|l| l.contains("total mass >= 90 kg")).count(), 1, "{shown}");
    assert_eq!(listed.iter().filter(|l| l.contains("<= 10 kg")).count(), 7, "{shown}");
}

#[test]
fn files_of_constraints_that_are_wrong_are_refused() {
    let script = b"fn constrain_link(robot, link, with) {\n    [ link.mass / 0.0 >= 1.0 ]\n}";
    let entries = r#"constraints: [{"script": (path: "zero.rhai")}], engines: [{"penalty": (runs: 1)}]"#;
    refused_beside(entries, &[("zero.rhai", script)], &["zero.rhai:2:", "division by zero"]);
    let entries = r#"constraints: [{"com_hull": (links: All, mesh: (path: "part.stl"))}],
        engines: [{"lmi": ()}]"#;
    let lying = [&[b' '; 80][..], &1_000_000_u32.to_le_bytes(), &[0; 50]].concat();
    refused_beside(
        entries,
        &[("part.stl", &lying)],
        &["part.stl", "1000000 triangles", "134 bytes", "help: "],
    );
}
