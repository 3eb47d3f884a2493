//! What the workbench made is its own; nothing else is ever written, removed or served.

use std::io::{BufRead, BufReader};
use std::path::Path;
use std::process::{Command, Stdio};

use super::client::Bench;
use super::data::Files;

const ROBOT: [&str; 2] = ["--robot", "two_link.ron"];
const ARGS: [&str; 4] = ["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"];

/// A study of the user's own log in `study`, ended by force.
fn ended_study() -> Files {
    let files = Files::new();
    files.simulate();
    let mut bench = Bench::open(&files, &ARGS).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    bench.kill();
    files
}

fn steps(files: &Files) -> String {
    String::from_utf8(files.bytes("study/steps.json")).expect("text")
}

#[test]
fn the_users_own_log_outlives_its_removal_from_a_study_that_went_on() {
    for of_before in [false, true] {
        let files = ended_study();
        let log = files.bytes("logs/fit.csv.gz");
        if of_before {
            // As a version without lists left it.
            std::fs::remove_file(files.path("study/.lacuna.json")).expect("a list");
        }
        let bench = Bench::resume(&files).enter();
        bench.wait("the log", |s| s["logs"][0]["read"] == true);
        assert_eq!(bench.upload("log", "copy.csv.gz", &log).status, 200);
        assert!(files.path("study/log_1.csv.gz").is_file());
        bench.wait("both logs", |s| s["logs"][1]["read"] == true);
        for id in [0, 1] {
            assert_eq!(bench.post("/api/remove", &format!(r#"{{"log": {id}}}"#)).status, 200);
        }
        assert_eq!(files.bytes("logs/fit.csv.gz"), log, "the user's own");
        assert!(!files.path("study/log_1.csv.gz").exists(), "the copy that was made goes");
    }
}

#[test]
fn a_log_that_its_user_put_into_the_folder_stays_there() {
    let files = ended_study();
    std::fs::copy(files.path("logs/check.csv.gz"), files.path("study/log_1.csv.gz")).expect("copies");
    let text = steps(&files).replace("../logs/fit.csv.gz", "log_1.csv.gz");
    std::fs::write(files.path("study/steps.json"), text).expect("writes");
    let bench = Bench::resume(&files).enter();
    bench.wait("the log", |s| s["logs"][0]["read"] == true);
    assert_eq!(bench.post("/api/remove", r#"{"log": 0}"#).status, 200);
    assert!(files.path("study/log_1.csv.gz").is_file(), "the list does not name it");
}

#[test]
fn a_folder_that_holds_something_else_is_no_place_for_a_study() {
    let files = Files::new();
    files.simulate();
    let scenario = "(robot: \"two_link.ron\", logs: Files(fit: [\"logs/fit.csv.gz\"]))";
    std::fs::write(files.path("scenario.ron"), scenario).expect("writes");
    let before = |name: &str| (files.names(name).len(), mode(&files.path(name)));
    let there = [before("."), before("logs")];
    for (args, word) in [
        (&["scenario.ron", "--out", "."][..], "not empty"),
        (&["--robot", "two_link.ron", "--data", "logs/fit.csv.gz", "--out", "logs"], "`lacuna simulate`"),
        (&["--resume", "logs"], "no study"),
        (&["scenario.ron", "--out", "two_link.ron"], "two_link.ron"),
    ] {
        let (code, said) = files.fail(&[&["workbench"], args].concat());
        assert!(
            code == Some(2) && said.contains(word) && said.contains("help: "),
            "{args:?}: {code:?} {said}"
        );
    }
    assert_eq!(files.bytes("scenario.ron"), scenario.as_bytes());
    assert_eq!([before("."), before("logs")], there, "nothing was added, and modes are as they were");
}

#[cfg(unix)]
fn mode(path: &Path) -> u32 {
    use std::os::unix::fs::PermissionsExt;
    std::fs::metadata(path).expect("is there").permissions().mode() & 0o7777
}

#[cfg(not(unix))]
fn mode(_: &Path) -> u32 {
    0
}

#[cfg(unix)]
#[test]
fn modes_are_set_on_what_was_made_and_nothing_else() {
    use std::os::unix::fs::PermissionsExt;
    let files = Files::new();
    std::fs::create_dir(files.path("study")).expect("makes");
    std::fs::set_permissions(files.path("study"), std::fs::Permissions::from_mode(0o1777)).expect("sets");
    let bench = Bench::open(&files, &[]).enter();
    assert_eq!(bench.upload("robot", "r.ron", &files.bytes("two_link.ron")).status, 200);
    bench.wait("the robot", |s| s["robot"]["name"].is_string() && s["job"].is_null());
    assert_eq!(mode(&files.path("study")), 0o1777, "a folder that was there keeps its mode");
    for name in files.names("study") {
        assert_eq!(mode(&files.path(&format!("study/{name}"))), 0o600, "{name}");
    }
}

#[test]
fn steps_that_lead_elsewhere_or_cannot_be_are_refused_with_their_line() {
    let files = ended_study();
    std::fs::write(files.path("secret.txt"), "secret").expect("writes");
    let good = steps(&files);
    let script = r#""scripts": [{"file": "../secret.txt", "kind": "effect", "text": ""}]"#;
    for (from, to, word) in [
        (r#""scripts": []"#, script, "`../secret.txt`"),
        ("../logs/fit.csv.gz", "../secret.txt", "`../secret.txt`"),
        ("../two_link.ron", "../../../../../../etc/passwd", "etc/passwd"),
        (r#""parent": null"#, r#""parent": 0"#, "step 0"),
        (r#""id": 0"#, r#""id": 18446744073709551615"#, "too large"),
        (r#""seed": 1"#, r#""seed": NaN"#, "damaged"),
        (r#""seed": 1"#, r#""seed": 1, "sed": 2"#, "`sed`"),
        (r#""band_hz": "#, r#""band_hz": -"#, "`band_hz`"),
        (r#""engines": []"#, r#""engines": ["{\"simplex\": ()}"]"#, "simplex"),
    ] {
        let text = good.replacen(from, to, 1);
        assert_ne!(text, good, "{from} is not in {good}");
        std::fs::write(files.path("study/steps.json"), &text).expect("writes");
        let (code, said) = files.fail(&["workbench", "--resume", "study"]);
        assert_eq!(code, Some(2), "{to}: {said}");
        assert!(
            said.contains("steps.json:") && said.contains(word) && said.contains("help: "),
            "{to}: {said}"
        );
    }
    assert_eq!(files.bytes("secret.txt"), b"secret");
    std::fs::write(files.path("study/steps.json"), good).expect("writes");
    let bench = Bench::resume(&files).enter();
    bench.wait("a model", |s| s["steps"][0]["fitted"] == true);
}

#[cfg(unix)]
#[test]
fn links_in_the_folder_are_neither_written_through_nor_served() {
    use std::os::unix::fs::symlink;
    let files = ended_study();
    std::fs::write(files.path("precious"), "precious").expect("writes");
    std::fs::remove_file(files.path("study/scenario.ron")).expect("removes");
    for name in ["scenario.ron", "report.json", ".upload-0", ".draft-0"] {
        symlink("../precious", files.path(&format!("study/{name}"))).expect("links");
    }
    let bench = Bench::resume(&files).enter();
    let state = bench.wait("what cannot be written", |s| s["trouble"].is_object());
    assert!(state["trouble"]["text"].as_str().is_some_and(|t| t.contains("link")), "{}", state["trouble"]);
    assert_eq!(bench.upload("log", "more.csv.gz", &files.bytes("logs/check.csv.gz")).status, 200);
    let draft = r#"{"kind": "effect", "text": "fn about() {}"}"#;
    assert_eq!(bench.post("/api/script/check", draft).status, 200);
    for name in ["scenario.ron", "report.json"] {
        assert_eq!(bench.get(&format!("/api/file/{name}")).status, 404, "{name}");
    }
    assert_eq!(files.bytes("precious"), b"precious");
    assert!(files.path("study/.upload-0").is_symlink());
}

#[test]
fn one_workbench_at_a_time_has_a_study() {
    let files = Files::new();
    let mut bench = Bench::open(&files, &ROBOT);
    let (code, said) = files.fail(&["workbench", "--resume", "study"]);
    assert!(code == Some(2) && said.contains(&format!("process {}", bench.id())), "{said}");
    bench.kill();
    drop(Bench::resume(&files));
}

#[test]
fn what_a_killed_process_had_half_done_is_cleared_and_nothing_else() {
    let files = ended_study();
    let half = ["study/.upload-7", "study/model.ron.99.partial", "study/.lacuna.json.99.partial"];
    let mine = ["study/notes.txt", "study/data.csv.99.partial"];
    half.iter().chain(&mine).for_each(|name| std::fs::write(files.path(name), "x").expect("writes"));
    std::fs::create_dir(files.path("study/.draft-3")).expect("makes");
    std::fs::write(files.path("study/.draft-3/script.rhai"), "x").expect("writes");
    let _bench = Bench::resume(&files);
    assert!(half.iter().all(|name| !files.path(name).exists()) && !files.path("study/.draft-3").exists());
    assert!(mine.iter().all(|name| files.bytes(name) == b"x"));
}

#[cfg(unix)]
#[test]
fn a_full_disk_leaves_nothing_half_done() {
    let files = Files::new();
    let bench = Bench::open_within(&files, &ROBOT, 64).enter();
    assert_eq!(bench.upload("log", "large.csv", &vec![b'1'; 66_000]).status, 500);
    let script = format!("// {}", "x".repeat(100_000));
    let draft = serde_json::json!({"kind": "effect", "text": script}).to_string();
    assert_eq!(bench.post("/api/script/check", &draft).status, 422);
    assert_eq!(files.half_done("study"), [""; 0]);
    assert_eq!(bench.get("/api/state").status, 200);
}

#[test]
fn a_study_that_goes_on_says_which_files_elsewhere_it_reads() {
    let files = ended_study();
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    let command = command.current_dir(files.path(".")).args(["workbench", "--resume", "study"]);
    let mut child = command.stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts");
    let lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    let said: Vec<String> = lines.take_while(|line| !line.contains("goes on")).collect();
    child.kill().expect("ends");
    child.wait().expect("ended");
    for name in ["logs/fit.csv.gz", "two_link.ron"] {
        assert!(said.iter().any(|line| line.ends_with(name)), "{name}: {said:?}");
    }
}
