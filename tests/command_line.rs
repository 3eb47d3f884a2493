//! How the program behaves whatever is asked of it: streams, exit codes, one JSON document, the same bits on
//! any number of threads.

use super::folder;
#[path = "command_line/outputs.rs"]
mod outputs;
#[path = "command_line/texts.rs"]
mod texts;

use std::io::{BufRead, BufReader};
use std::process::Stdio;

use folder::{Answer, Folder};
use serde_json::Value;

fn json(answer: &Answer) -> Value {
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    serde_json::from_str(&answer.out).expect("exactly one JSON document")
}

const COMPARE: [&str; 6] = ["compare", "model.ron", "--robot", "arm.ron", "--data", "log.csv"];

#[test]
fn help_is_no_error_and_its_absence_is() {
    let folder = Folder::new();
    for arguments in
        [&["--help"][..], &["help"], &["help", "scenario"], &["compare", "--help"], &["--version"]]
    {
        let answer = folder.run(arguments);
        assert_eq!((answer.code, answer.err.as_str()), (Some(0), ""), "{arguments:?}");
        assert!(answer.out.contains("lacuna") && answer.out.lines().all(|l| l.chars().count() <= 80));
    }
    let answer = folder.run(&[] as &[&str]);
    assert_eq!((answer.code, answer.out.as_str()), (Some(2), ""));
    assert!(answer.err.contains("scenario") && answer.err.contains("dynamics"), "{}", answer.err);
}

#[test]
fn json_is_one_document_on_stdout() {
    let folder = Folder::new();
    let report = json(&folder.run(&["scenario", "good.ron", "--json"]));
    assert_eq!((report["scenario"].as_str(), report["lacuna"].as_str()), (Some("good"), Some("0.1.0")));
    let written = std::fs::read_to_string(folder.path("out/good/report.json")).expect("written");
    assert_eq!(serde_json::from_str::<Value>(&written).expect("JSON"), report);
    let comparison = json(&folder.run(&[&COMPARE[..], &["--json"]].concat()));
    assert!(comparison["models"]["model.ron"]["relative_error_percent"].as_f64().is_some(), "{comparison}");
    assert!(json(&folder.run(&["list", "effects", "--json"])).as_array().is_some_and(|a| a.len() > 4));
    assert_eq!(json(&folder.run(&["list", "effects", "rigid_body", "--json"]))["name"], "rigid_body");
}

#[test]
fn a_scenario_that_asks_for_a_diagnosis_has_it_in_its_report() {
    let folder = Folder::new();
    let study = |more: &str| {
        format!(
            "(robot: \"arm.ron\", logs: Files(fit: [\"log.csv\"]), signals: (mode: Parallel, band_hz: 8.0){more})"
        )
    };
    folder.write("plain.ron", study(""));
    folder.write("asked.ron", study(", diagnosis: true"));
    assert!(json(&folder.run(&["scenario", "plain.ron", "--json"]))["diagnosis"].is_null());
    let report = json(&folder.run(&["scenario", "asked.ron", "--json"]));
    assert_eq!(report["diagnosis"]["timing"], serde_json::json!({}), "wall-clock figures stand in one place");
    assert!(report["timing"]["diagnosis"].as_f64().is_some());
    let alone = folder.run(&["diagnose", "asked.ron", "--json"]).out;
    let mut alone: Value = serde_json::from_str(&alone).expect("one document");
    alone["timing"] = serde_json::json!({});
    assert_eq!(report["diagnosis"], alone);
    let page = std::fs::read_to_string(folder.path("out/asked/report.html")).expect("written");
    assert!(page.contains(&format!("\"verdict\":{}", report["diagnosis"]["verdict"])), "the page shows it");
}

#[test]
fn progress_goes_to_stderr_and_quiet_silences_it() {
    let folder = Folder::new();
    let loud = folder.run(&["scenario", "good.ron"]);
    let quiet = folder.run(&["scenario", "good.ron", "--quiet"]);
    assert_eq!((loud.code, quiet.code), (Some(0), Some(0)));
    assert!(loud.err.contains("simulating") && !loud.out.contains("simulating"), "{}", loud.err);
    assert_eq!((quiet.err.as_str(), quiet.out), ("", loud.out));
    let dynamics = folder.run(&["dynamics", "--robot", "arm.ron", "--states", "states.csv"]);
    assert_eq!((dynamics.code, dynamics.err.as_str()), (Some(0), ""));
    assert!(dynamics.out.starts_with("tau1,tau2\n") && dynamics.out.lines().count() == 2, "{}", dynamics.out);
}

/// `lacuna ... | head -1`
#[test]
fn a_reader_that_leaves_early_is_no_error() {
    let folder = Folder::new();
    let row = "0.1,0.2,0.3,0.4,0.5,0.6\n";
    folder.write("states.csv", format!("{}{}", folder::STATES_HEADER, row.repeat(20_000)));
    let mut child = folder
        .command(&["dynamics", "--robot", "arm.ron", "--states", "states.csv"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("the program starts");
    let mut first = String::new();
    let mut reader = BufReader::with_capacity(16, child.stdout.take().expect("piped"));
    reader.read_line(&mut first).expect("a line");
    drop(reader);
    let output = child.wait_with_output().expect("it ends");
    assert_eq!(first, "tau1,tau2\n");
    assert_eq!((output.status.code(), output.stderr.as_slice()), (Some(0), &b""[..]));
}

/// Engines with random starts on several threads, and one without.
const RETRIEVED: &str = "(
    robot: \"arm.ron\",
    logs: Simulated((motion: Random(harmonics: 3, period_s: 2, amplitude: 0.5), duration_s: 6)),
    constraints: [{\"positive_mass\": ()}, {\"triangle_inequality\": ()}, {\"total_mass\": (min: 2, max: 2.5)}],
    engines: [{\"penalty\": (runs: 4)}, {\"lmi\": ()}],
)";

#[test]
fn engines_give_the_same_bits_on_any_number_of_threads() {
    let folder = Folder::new();
    folder.write("retrieved.ron", RETRIEVED);
    let run = |jobs: &str| {
        let answer = folder.run(&["scenario", "retrieved.ron", "--jobs", jobs, "--out", jobs]);
        assert_ne!(answer.code, Some(2), "{}", answer.err);
        let text = std::fs::read_to_string(folder.path(jobs).join("report.json")).expect("written");
        text.split("\"timing\"").next().unwrap_or_default().to_owned()
    };
    let (one, two) = (run("1"), run("2"));
    assert!(one == two, "threads change what engines find");
    let links = one.matches("\"mass\"").count();
    assert!(links >= 4 && one.contains("\"engine\": \"lmi\""), "{links} masses in {one}");
}

#[test]
fn engines_are_listed_and_explained() {
    let folder = Folder::new();
    let all = folder.run(&["list", "engines"]).out;
    assert!(all.lines().all(|line| line.chars().count() <= 80), "{all}");
    for name in ["penalty", "penalty_paper", "lmi", "nlopt"] {
        assert!(all.lines().any(|line| line.starts_with(&format!("{name} "))), "{all}");
        let one = folder.run(&["list", "engines", name]);
        assert!(one.code == Some(0) && one.out.contains("  label: not set"), "{}{}", one.out, one.err);
        assert!(one.out.lines().all(|line| line.chars().count() <= 80), "{}", one.out);
        assert_eq!(json(&folder.run(&["list", "engines", name, "--json"]))["name"], name);
    }
    folder.refused(
        &["list", "engines", "lmy"],
        "no engine called `lmy`",
        &["penalty, penalty_paper, lmi, nlopt"],
    );
}

/// A study with every step: poses, simulated log, robust fit, filtered columns, folds, friction path.
const WHOLE: &str = "(
    robot: \"arm.ron\",
    poses: File(\"poses.csv\"),
    drop_above_percent: 30,
    logs: Simulated((
        motion: Random(harmonics: 3, period_s: 4, amplitude: 0.6),
        duration_s: 24,
        effects: [{\"viscous_friction\": (coefficients: [0.5])}],
        sensors: (position_noise: [1e-5], torque_noise: [0.05], reader: ()),
    )),
    signals: (mode: Parallel, decimate: 2),
    weighting: Huber,
    friction: (),
)";

/// Read-outs of the arm of these tests: any numbers will do, the fit need not be good.
fn poses() -> String {
    let row = |k: u32| {
        let x = |i: u32| f64::from((k * 37 + i * 101) % 97) / 97.0;
        (0..7).map(|i| x(i).to_string()).collect::<Vec<_>>().join(",") + "\n"
    };
    format!("q1,q2,g1,g2,m11,m21,m22\n{}", (0..60).map(row).collect::<String>())
}

#[test]
fn the_same_bits_on_any_number_of_threads() {
    let folder = Folder::new();
    folder.write("whole.ron", WHOLE);
    folder.write("poses.csv", poses());
    let mut results = Vec::new();
    for (out, jobs) in [("one", "1"), ("two", "2"), ("five", "5")] {
        let answer = folder.run(&["scenario", "whole.ron", "--jobs", jobs, "--out", out, "--json"]);
        let report = json(&answer);
        let text = std::fs::read_to_string(folder.path(out).join("report.json")).expect("written");
        let model = std::fs::read_to_string(folder.path(out).join("model.ron")).expect("written");
        assert!(report["timing"].as_object().is_some_and(|t| !t.is_empty()));
        let before_timing = text.split("\"timing\"").next().unwrap_or_default().to_owned();
        results.push((before_timing, model));
    }
    assert!(results[0] == results[1] && results[0] == results[2], "threads change the result");
    assert!(results[0].0.contains("\"friction\": [\n") && results[0].0.contains("\"huber\""));
    let temporary = folder.path("").display().to_string();
    let told = results[0].0.contains(&temporary) || results[0].1.contains(&temporary);
    assert!(!told, "results name the folder they were made in");
    let compared: Vec<String> = ["1", "2"]
        .map(|jobs| {
            let (model, robot) = (folder.path("two/model.ron"), folder.path("arm.ron"));
            let log = folder.path("log.csv");
            let mut arguments = vec!["compare".into(), model, "--robot".into(), robot, "--data".into(), log];
            arguments.extend(["--json".into(), "--jobs".into(), jobs.into()]);
            folder.run(&arguments).out
        })
        .into();
    assert_eq!(compared[0], compared[1]);
    assert!(compared[0].contains("\"model.ron\"") && !compared[0].contains(&temporary), "{}", compared[0]);
}

#[test]
fn timing_alone_differs_between_runs_and_the_seed_changes_the_rest() {
    let folder = Folder::new();
    folder.write("whole.ron", WHOLE);
    folder.write("poses.csv", poses());
    let run = |seed: &str| {
        let mut report = json(&folder.run(&["scenario", "whole.ron", "--seed", seed, "--json"]));
        report.as_object_mut().expect("an object").remove("timing").expect("there is timing");
        report
    };
    let (a, b, other) = (run("7"), run("7"), run("8"));
    assert_eq!(a, b);
    assert_ne!(a["identification"], Value::Null);
    assert_ne!(a["friction"], other["friction"]);
}

/// What a study writes, `compare` reads, whatever the order of the effects.
#[test]
fn a_written_model_predicts_what_it_was_fitted_to() {
    let folder = Folder::new();
    let log = "logs: Files(fit: [\"log.csv\"]), weighting: Ordinary";
    let offset = "{\"torque_offset\": ()}, {\"viscous_friction\": (joints: Only([\"joint2\"]))}";
    for (name, effects) in [
        ("first", format!("{{\"rigid_body\": ()}}, {offset}")),
        ("last", format!("{offset}, {{\"rigid_body\": ()}}")),
    ] {
        folder.write(format!("{name}.ron"), format!("(robot: \"arm.ron\", {log}, effects: [{effects}])"));
        let report = json(&folder.run(&["scenario", &format!("{name}.ron"), "--json", "--out", name]));
        let model = format!("{name}/model.ron");
        let comparison =
            json(&folder.run(&["compare", &model, "--robot", "arm.ron", "--data", "log.csv", "--json"]));
        let fitted = report["identification"]["relative_error_percent"].as_f64().expect("a number");
        let compared = comparison["models"][&model]["relative_error_percent"].as_f64().expect("a number");
        assert!((fitted - compared).abs() < 1e-9 * fitted, "{name}: fitted {fitted}, compared {compared}");
    }
}
