//! What is done at a workbench: from dropped files to a model and back.

use super::client::{Bench, json};
use super::data::Files;

#[test]
fn a_study_from_dropped_files_to_a_smaller_error_and_back() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &[]).enter();
    assert_eq!(bench.upload("log", "arm one.csv", &files.bytes("logs/fit.csv.gz")).status, 200);
    let state = bench.wait("the log is looked at", |s| s["logs"][0]["read"] == true);
    assert_eq!(state["logs"][0]["name"], "arm one.csv");
    assert_eq!(state["logs"][0]["columns"][1]["meaning"], "position");
    assert!(state["shown"].is_null(), "no model without a robot");
    assert_eq!(
        bench.upload("robot", "r.ron", &std::fs::read("robots/two_link.ron").expect("reads")).status,
        200
    );

    let first = bench.wait("a fitted model", |s| !s["steps"][0]["held_out_percent"].is_null());
    assert_eq!(first["robot"]["joints"][0]["torque"], "N m");
    let page = bench.get("/api/page").json();
    assert_eq!(page["pictures"]["models"].as_array().map(Vec::len), Some(1));
    assert!(page["pictures"]["traces"][0]["rows"].as_u64() > Some(200));

    let full = bench.wait("a full search", |s| s["steps"][0]["scanned"] == true && s["job"].is_null());
    let before = full["steps"][0]["held_out_percent"].as_f64().expect("a number");
    assert_eq!(
        full["diagnosis"]["baseline"]["held_out_relative_error_percent"].as_f64(),
        Some(before),
        "the search starts from the very model on show"
    );
    let hidden = &full["candidates"][0];
    assert_eq!((hidden["rank"].as_str(), hidden["effect"].as_str()), (Some("missing"), Some("joint_spring")));

    assert_eq!(bench.post("/api/add", &hidden["add"].to_string()).status, 200);
    let added = bench.wait("another step", |s| s["steps"].as_array().is_some_and(|a| a.len() == 2));
    let after = added["steps"][1]["held_out_percent"].as_f64().expect("a number");
    assert!(after < 0.7 * before, "{before} to {after} %");
    assert_eq!((added["shown"].as_u64(), added["against"].as_u64()), (Some(1), Some(0)));
    assert_eq!(added["path"], json("[0, 1]"));
    let page = bench.get("/api/page").json();
    assert_eq!(page["pictures"]["models"].as_array().map(Vec::len), Some(2));
    let clean = bench.wait("the verdict on the new model", |s| s["steps"][1]["scanned"] == true);
    assert_eq!(clean["diagnosis"]["missing"], json("[]"), "{}", clean["verdict"]);

    let region = bench.get("/api/region?log=0&from=3&to=6&variable=dq1&low=0").json();
    assert!(
        region["rows"].as_u64() > Some(5) && region["joints"][1]["rms"].as_array().map(Vec::len) == Some(2)
    );
    assert_eq!(bench.get("/api/region?log=0&from=1e9").json()["rows"], 0);
    assert_eq!(bench.get("/api/region?log=5").status, 422);

    // The report's verdict says what was added, and most of the error is put down to it where it explains most.
    let added = files.run(&[
        "diagnose",
        "--robot",
        "two_link.ron",
        "--data",
        "logs/fit.csv.gz",
        "--add",
        "joint_spring:joint1",
        "--json",
        "--out",
        "added",
    ]);
    let page = String::from_utf8(files.bytes("added/report.html")).expect("text");
    assert!(page.contains("added joint spring on joint1: held-out error "), "{}", json(&added)["ladder"]);
    let flags =
        ["diagnose", "--robot", "two_link.ron", "--data", "logs/fit.csv.gz", "--model", "rigid", "--json"];
    let first = |more: &[&str]| json(&files.run(&[&flags[..], more].concat()))["first"].clone();
    assert_eq!(first(&[])["joint"], "joint1");
    let with_spring = first(&["--add", "joint_spring:joint1"]);
    assert_eq!(
        (&with_spring["joint"], &with_spring["cause"]),
        (&json("\"joint1\""), &json("\"joint_spring\""))
    );
    // The command line repeats it.
    let scenario = files.run(&["diagnose", "study/scenario.ron", "--json"]);
    let again = json(&scenario)["baseline"]["held_out_relative_error_percent"].as_f64().expect("a number");
    assert!((again - after).abs() < 1e-9 * after, "{again} and {after}");

    assert_eq!(bench.post("/api/undo", "{}").status, 200);
    let back = bench.wait("the first model", |s| s["shown"] == 0);
    assert_eq!(back["steps"].as_array().map(Vec::len), Some(2), "undone is not lost");
    assert_eq!(bench.post("/api/undo", "{}").status, 422);
    for file in ["scenario.ron", "model.ron", "report.html", "diagnosis.json"] {
        let taken = bench.get(&format!("/api/file/{file}"));
        assert_eq!(taken.status, 200, "{file}");
        assert!(taken.header("content-disposition").is_some_and(|d| d.starts_with("attachment")));
    }
}

#[test]
fn what_was_made_of_logs_that_are_gone_is_not_shown() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron"]).enter();
    let log = files.bytes("logs/fit.csv.gz");
    for k in 0..12 {
        assert_eq!(bench.upload("log", &format!("{k}.csv"), &log).status, 200);
    }
    bench.wait("a fit of all logs", |s| {
        s["job"]["kind"] == "fit"
            && s["logs"].as_array().is_some_and(|l| l.iter().all(|l| l["usable"] == true))
    });
    for k in 0..12 {
        assert_eq!(bench.post("/api/remove", &format!(r#"{{"log": {k}}}"#)).status, 200);
    }
    let empty = bench.wait("the end of the fit", |s| s["job"].is_null());
    assert_eq!((&empty["shown"], &empty["steps"]), (&json("null"), &json("[]")), "{}", empty["trouble"]);
    assert!(empty["trouble"].is_null(), "{}", empty["trouble"]);
    assert_eq!(bench.upload("log", "again.csv", &log).status, 200);
    bench.wait("the model of the new log", |s| s["steps"][0]["held_out_percent"].is_f64());
}

#[test]
fn a_killed_process_loses_no_finished_step() {
    let files = Files::new();
    files.simulate();
    let args = ["--robot", "two_link.ron", "--data", "logs/fit.csv.gz", "--validate", "logs/check.csv.gz"];
    let mut bench = Bench::open(&files, &args).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    assert_eq!(bench.post("/api/add", r#"{"effect": "joint_spring", "joints": ["joint1"]}"#).status, 200);
    let before = bench.wait("a step", |s| s["steps"].as_array().is_some_and(|a| a.len() == 2));
    bench.kill();
    let bench = Bench::resume(&files).enter();
    let after = bench.wait("the models, fitted again", |s| {
        s["steps"].as_array().is_some_and(|a| a.len() == 2 && a.iter().all(|s| s["fitted"] == true))
    });
    for key in ["held_out_percent", "joints", "added", "validation_percent", "parameters"] {
        assert_eq!(before["steps"][1][key], after["steps"][1][key], "{key}");
    }
    assert!(after["steps"][1]["validation_percent"].as_f64().is_some());
    assert_eq!((&before["shown"], &before["against"]), (&after["shown"], &after["against"]));
}

#[test]
fn two_tabs_are_told_of_the_same_study() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    let (mut one, mut two) = (bench.listen(), bench.listen());
    assert!(one.next("state").is_some() && two.next("state").is_some(), "said at once");
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    let version =
        bench.post("/api/add", r#"{"effect": "joint_spring", "joints": ["joint1"]}"#).json()["version"]
            .as_u64()
            .expect("a version");
    for tab in [&mut one, &mut two] {
        let told = tab.until("state", |v| v["version"].as_u64() > Some(version));
        assert!(told, "each tab hears of the change");
    }
}

#[test]
fn a_retrieval_is_stopped_and_keeps_its_best() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    let order = r#"{"engines": ["lmi", "penalty"], "runs": 4000}"#;
    assert_eq!(bench.post("/api/retrieve", order).status, 200);
    let mut tab = bench.listen();
    let begun = bench.wait("progress", |s| {
        s["retrieval"]["engine"] == "penalty" && s["job"]["seconds_left"].as_f64() > Some(0.0)
    });
    let done = begun["job"]["fraction"].as_f64().expect("a share");
    assert!(done > 0.0 && done < 1.0, "{done}");
    let told = tab.until("retrieval", |r| r["fraction"].as_f64() > Some(done) && r["seconds_left"].is_f64());
    assert!(told, "every tab hears how far it is and what is left");
    assert_eq!(bench.post("/api/add", r#"{"effect": "payload"}"#).status, 409);
    assert_eq!(bench.post("/api/stop", "{}").status, 200);
    let state = bench.wait("the end", |s| s["retrieval"]["running"] == false);
    let retrieval = &state["retrieval"];
    assert_eq!(retrieval["stopped"], true, "{}", state["trouble"]);
    let results = retrieval["results"].as_array().expect("results");
    assert_eq!(results.len(), 2);
    assert!(results.iter().all(|r| r["feasible"] == true), "{results:?}");
    assert!(results[1]["runs"].as_u64().expect("a count") < 4000);
    assert!(results[1]["certified_gap_percent"].as_f64().is_some_and(|gap| gap >= 0.0));
    assert_eq!(bench.get("/api/file/robot.urdf").status, 200);
    let report = bench.get("/api/file/report.json").json();
    assert_eq!(report["diagnosis"].is_null(), state["diagnosis"].is_null(), "what was found stands in it");
    assert!(bench.get("/api/page").json()["report"]["retrievals"].is_array());
}

/// The spring that the logs hide, as a user may write it.
const SPRING: &str = r#"// A spring.
fn about() {
    #{
        title: "spring", text: "A spring on the joint.", equation: "tau_j = k_j q_j",
        confused_with: "gravity",
        parameters: [#{ symbol: "k", unit: "N m/rad", meaning: "stiffness", min: 0.0 }],
    }
}
fn columns(joint, now, memory, with) {
    [ now.q ]
}
"#;

#[test]
fn scripts_are_checked_while_they_are_typed_and_used_at_once() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    let draft = |kind: &str, text: &str| serde_json::json!({"kind": kind, "text": text}).to_string();
    let good = SPRING;
    let broken = good.replacen("fn columns(", "fn columns((", 1);
    let answer = bench.post("/api/script/check", &draft("effect", &broken)).json();
    let line = 1 + broken[..broken.find("fn columns((").expect("there")].matches('\n').count() as u64;
    assert_eq!((answer["ok"].as_bool(), answer["problems"][0]["line"].as_u64()), (Some(false), Some(line)));
    assert!(answer["problems"][0]["column"].as_u64().is_some(), "{answer}");
    assert_eq!(bench.post("/api/script/save", &draft("effect", &broken)).status, 422);
    assert_eq!(bench.post("/api/script/save", &draft("constraint", good)).status, 422, "that is an effect");

    let answer = bench.post("/api/script/check", &draft("effect", good)).json();
    assert_eq!(answer["ok"], true, "{answer}");
    let saved = bench.post("/api/script/save", &draft("effect", good));
    assert_eq!((saved.status, saved.json()["file"].as_str()), (200, Some("effect_1.rhai")));
    let add = r#"{"effect": "effect_1.rhai", "joints": ["joint1"]}"#;
    assert_eq!(bench.post("/api/add", add).status, 200);
    let state = bench.wait("a step with it", |s| s["steps"].as_array().is_some_and(|a| a.len() == 2));
    assert!(state["steps"][1]["effects"].to_string().contains("effect_1.rhai"));
    let error = |step: usize| state["steps"][step]["held_out_percent"].as_f64().expect("a number");
    assert!(error(1) < 0.1 * error(0), "{} to {} %", error(0), error(1));

    let rule = std::fs::read_to_string("constraints/total_mass.rhai").expect("reads");
    let saved = bench.post("/api/script/save", &draft("constraint", &rule));
    assert_eq!(saved.json()["file"], "constraint_1.rhai", "{}", saved.text());
    let state = bench.get("/api/state").json();
    assert!(state["constraints"]["text"].as_str().is_some_and(|t| t.contains("constraint_1.rhai")));
    assert_eq!(state["constraints"]["problems"], json("[]"));
    assert_eq!(files.half_done("study"), [""; 0]);
}

#[test]
fn what_is_found_is_added_by_itself_where_that_is_asked_for() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    assert_eq!(bench.post("/api/diagnose", r#"{"auto": true}"#).status, 200);
    let state = bench.wait("nothing left to add", |s| {
        s["diagnosis"]["verdict"] == "nothing" && s["shown"] != 0 && s["job"].is_null()
    });
    assert!(state["steps"][1]["added"]["effect"] == "joint_spring", "{}", state["steps"][1]["added"]);
    let ladder: Vec<f64> = state["path"]
        .as_array()
        .expect("a path")
        .iter()
        .filter_map(|id| state["steps"][id.as_u64()? as usize]["held_out_percent"].as_f64())
        .collect();
    assert!(ladder.len() >= 2 && ladder[1] < 0.1 * ladder[0], "{ladder:?}");
}

#[test]
fn other_models_logs_and_maps_begin_anew_where_they_must() {
    let files = Files::new();
    files.simulate();
    let args = ["--robot", "two_link.ron", "--data", "logs/fit.csv.gz", "--data", "logs/check.csv.gz"];
    let bench = Bench::open(&files, &args).enter();
    let fitted = |s: &serde_json::Value| {
        s["steps"].as_array().is_some_and(|a| !a.is_empty() && a.iter().all(|s| s["fitted"] == true))
    };
    let first = bench.wait("a model", fitted);
    assert!(first["steps"][0]["validation_percent"].is_null());
    assert_eq!(bench.post("/api/role", r#"{"log": 1, "role": "validate"}"#).status, 200);
    let second = bench.wait("a model of one log", |s| s["steps"][0]["validation_percent"].is_number());
    assert_ne!(first["steps"][0]["held_out_percent"], second["steps"][0]["held_out_percent"]);
    assert_eq!(bench.get("/api/page").json()["pictures"]["traces"].as_array().map(Vec::len), Some(2));

    assert_eq!(bench.post("/api/model", r#"{"model": "rigid"}"#).status, 200);
    let rigid = bench.wait("the rigid model", |s| s["steps"][1]["fitted"] == true);
    assert_eq!(
        (rigid["steps"][1]["label"].as_str(), rigid["shown"].as_u64()),
        (Some("rigid model"), Some(1))
    );
    let error = |state: &serde_json::Value, k: usize| {
        state["steps"][k]["held_out_percent"].as_f64().expect("a number")
    };
    assert!(error(&rigid, 1) > error(&rigid, 0));

    // Degrees for radians: wrong, said so, and taken back.
    let map = r#"{"text": "(position: (columns: \"q{1}\", unit: Degrees))"}"#;
    assert_eq!(bench.post("/api/columns", map).status, 200);
    let wrong = bench.wait("what the map did", |s| s["logs"][0]["sound"] == false);
    let finding = wrong["logs"][0]["findings"][0]["text"].as_str().expect("a finding");
    assert!(wrong["logs"][0]["columns"][1]["unit"] == "deg" && !finding.is_empty());
    assert_eq!(bench.post("/api/columns", "{}").status, 200);
    let right = bench.wait("the first numbers", |s| {
        fitted(s) && s["logs"][0]["columns"][1]["unit"] == "rad" && s["logs"][0]["checked"] == true
    });
    assert!((error(&right, 0) - error(&second, 0)).abs() < 0.05 * error(&second, 0));

    assert_eq!(bench.post("/api/remove", r#"{"log": 0}"#).status, 200);
    let none = bench
        .wait("no log to fit", |s| s["logs"].as_array().is_some_and(|l| l.len() == 1) && s["job"].is_null());
    assert!(none["shown"].is_null() && files.path("logs/fit.csv.gz").is_file(), "the user's own file stays");
}

#[test]
fn a_model_file_can_be_the_start() {
    let files = Files::new();
    files.simulate();
    files.run(&[
        "diagnose",
        "--robot",
        "two_link.ron",
        "--data",
        "logs/fit.csv.gz",
        "--add",
        "joint_spring:joint1",
        "--out",
        "d",
    ]);
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    assert_eq!(bench.upload("model", "m.ron", &files.bytes("d/model.ron")).status, 200);
    let state = bench.wait("that model", |s| s["steps"][1]["fitted"] == true);
    assert!(state["steps"][1]["effects"].to_string().contains("joint_spring"));
    assert!(state["steps"][1]["held_out_percent"].as_f64().expect("a number") < 1.0);
}

#[test]
fn every_effect_of_the_catalogue_can_be_added_or_says_why_not() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    let first = bench.wait("a model", |s| s["signals"]["chosen"] == true && s["job"].is_null());
    let names: Vec<&str> = first["catalogue"]
        .as_array()
        .expect("a catalogue")
        .iter()
        .filter_map(|e| e["name"].as_str())
        .collect();
    let mut added = 0;
    for name in &names {
        let steps = bench.get("/api/state").json()["steps"].as_array().map_or(0, Vec::len);
        let order = serde_json::json!({"effect": name, "joints": []}).to_string();
        assert_eq!(bench.post("/api/add", &order).status, 200);
        let state = bench.wait(&format!("{name} or why not"), |s| {
            s["trouble"].is_object() || s["steps"].as_array().is_some_and(|a| a.len() > steps)
        });
        let why = state["trouble"]["text"].as_str().unwrap_or_default();
        assert!(!why.contains("broke down") && !why.contains("not known here"), "{name}: {why}");
        added += usize::from(why.is_empty());
        assert_eq!(bench.post("/api/show", r#"{"step": 0}"#).status, 200);
        bench.wait("the first model again", |s| s["shown"] == 0);
    }
    assert!(added >= 8, "{added} of {} could be added", names.len());
}

#[test]
fn every_rule_that_the_page_inserts_is_taken() {
    let files = Files::new();
    let bench = Bench::open(&files, &[]).enter();
    let robot = std::fs::read("robots/two_link.ron").expect("reads");
    assert_eq!(bench.upload("robot", "r.ron", &robot).status, 200);
    let state =
        bench.wait("the robot is read", |s| s["robot"]["joints"].as_array().is_some_and(|j| j.len() == 2));
    let kinds = state["constraint_kinds"].as_array().expect("a list");
    assert_eq!(kinds.len(), lacuna::constraints::CATALOGUE.len());
    let usual = state["constraints"]["text"].as_str().expect("a text");
    for kind in kinds {
        let template = kind["template"].as_str().expect("a text");
        // As `insert` in parameters.js.
        let end = usual.rfind(']').expect("a list ends");
        let text = format!("{}\n    {template}\n{}", usual[..end].trim_end(), &usual[end..]);
        let answer = bench.post("/api/constraints", &serde_json::json!({ "text": text }).to_string());
        assert_eq!(answer.status, 200, "{template}: {}", answer.text());
        let after = bench.get("/api/state").json();
        assert_eq!(after["constraints"]["problems"], json("[]"), "{template}");
    }
    let engines = state["engine_kinds"].as_array().expect("a list");
    assert!(engines.iter().any(|e| e["name"] == "lmi") && engines.len() >= 3, "{engines:?}");
}
