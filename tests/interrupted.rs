//! Ctrl-C, checkpoints and `--resume`, through the command line.
#![cfg(unix)]

use std::io::{BufRead, BufReader};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};
use std::time::{Duration, Instant};

/// Longest time to wait for anything.
const PATIENCE: Duration = Duration::from_secs(240);

/// A folder with a study of the Panda whose retrieval makes `runs` runs.
fn study(runs: usize, seed: u64) -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for file in ["robots/panda.ron", "scenarios/panda_table3.ron", "scenarios/panda_bounds.ron"] {
        let name = Path::new(file).file_name().expect("a name");
        std::fs::copy(file, folder.path().join(name)).expect("shipped files copy");
    }
    let engine = format!(r#"{{"penalty": (runs: {runs}, stages: 2, proposals: 20000)}}"#);
    let scenario = format!(
        r#"(robot: "panda.ron", seed: {seed}, presets: ["panda_bounds.ron"], drop_above_percent: 30.0,
            poses: ReadOut(coefficients: "panda_table3.ron", count: 200, noise_percent: 0.0315),
            engines: [{engine}, {{"lmi": ()}}])"#
    );
    std::fs::write(folder.path().join("study.ron"), scenario).expect("writes");
    folder
}

fn lacuna(folder: &Path, out: &str, more: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    command.current_dir(folder).args(["scenario", "study.ron", "--out", out]).args(more);
    command
}

fn report(folder: &Path, out: &str) -> serde_json::Value {
    let text = std::fs::read_to_string(folder.join(out).join("report.json")).expect("a report");
    let mut report: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    report.as_object_mut().expect("an object").remove("timing");
    report
}

fn checkpoint(folder: &Path, out: &str) -> PathBuf {
    folder.join(out).join("penalty.checkpoint.json")
}

fn text(bytes: &[u8]) -> String {
    String::from_utf8_lossy(bytes).into_owned()
}

fn send(signal: &str, child: &Child) {
    let kill = Command::new("kill").args([signal, &child.id().to_string()]).status().expect("kill is there");
    assert!(kill.success());
}

/// Presses Ctrl-C on a child and waits for its end.
fn interrupt(child: Child) -> Output {
    send("-INT", &child);
    child.wait_with_output().expect("it ends")
}

fn wait_for(what: &str, mut there: impl FnMut() -> bool) {
    let start = Instant::now();
    while !there() {
        assert!(start.elapsed() < PATIENCE, "{what} did not come");
        std::thread::sleep(Duration::from_millis(5));
    }
}

#[test]
fn an_interrupted_study_goes_on_to_the_same_bits() {
    let folder = study(40, 1);
    let folder = folder.path();
    let whole = lacuna(folder, "whole", &["--quiet"]).output().expect("runs");
    assert!(whole.status.success(), "{}", text(&whole.stderr));
    assert!(!checkpoint(folder, "whole").exists(), "a finished study leaves no checkpoint");

    let child = lacuna(folder, "part", &["--jobs", "1"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    wait_for("a checkpoint", || checkpoint(folder, "part").exists());
    let part = interrupt(child);
    let (said, shown) = (text(&part.stdout), text(&part.stderr));
    assert_eq!(part.status.code(), Some(1), "{shown}");
    assert!(said.contains("lacuna scenario study.ron --resume part"), "{said}");
    assert!(shown.contains("keeping the best"), "{shown}");
    let cut = report(folder, "part");
    assert_eq!(cut["retrievals"].as_array().map(Vec::len), Some(1));
    assert!(cut["retrievals"][0]["feasible"].as_bool() == Some(true), "{}", cut["retrievals"][0]);
    assert!(cut["retrievals"][0]["runs"].as_u64().expect("a count") < 40);
    assert!(cut["warnings"].to_string().contains("stopped before lmi was run"));

    let mut resume = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    resume.current_dir(folder).args(["scenario", "study.ron", "--resume", "part", "--quiet"]);
    let resumed = resume.output().expect("runs");
    assert!(resumed.status.success(), "{}", text(&resumed.stderr));
    assert_eq!(report(folder, "part"), report(folder, "whole"));
    assert!(!checkpoint(folder, "part").exists());
}

#[test]
fn a_killed_study_goes_on_to_the_same_bits_with_or_without_a_list() {
    let folder = study(12, 1);
    let folder = folder.path();
    let whole = lacuna(folder, "whole", &["--quiet"]).output().expect("runs");
    assert!(whole.status.success(), "{}", text(&whole.stderr));
    for (out, keeps_list) in [("part", true), ("of_before", false)] {
        let mut child =
            lacuna(folder, out, &["--jobs", "1", "--quiet"]).stdout(Stdio::null()).spawn().expect("starts");
        wait_for("a checkpoint", || checkpoint(folder, out).exists());
        child.kill().expect("ends");
        child.wait().expect("ended");
        if !keeps_list {
            for file in [".lacuna.json", ".lacuna.lock"] {
                std::fs::remove_file(folder.join(out).join(file)).expect("is there");
            }
        }
        let mut resume = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        resume.current_dir(folder).args(["scenario", "study.ron", "--resume", out, "--quiet"]);
        let resumed = resume.output().expect("runs");
        assert!(resumed.status.success(), "{}", text(&resumed.stderr));
        assert_eq!(report(folder, out), report(folder, "whole"));
        let left = std::fs::read_dir(folder.join(out)).expect("reads");
        let left: Vec<_> =
            left.map(|e| e.expect("reads").file_name().to_string_lossy().into_owned()).collect();
        assert!(!left.iter().any(|n| n.ends_with(".partial") || n.ends_with(".lock")), "{left:?}");
    }
}

#[test]
fn progress_names_best_value_violation_and_time_left() {
    let folder = study(100_000, 1);
    let folder = folder.path();
    let mut child =
        lacuna(folder, "out", &[]).stdout(Stdio::null()).stderr(Stdio::piped()).spawn().expect("starts");
    let lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    let mut shown = String::new();
    let mut asked = false;
    for line in lines {
        shown += &(line.clone() + "\n");
        if line.contains("s left") && !asked {
            asked = true;
            assert!(line.contains("penalty: 0 %, best ") && line.contains("violation"), "{line}");
            let id = child.id().to_string();
            assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill is there").success());
        }
    }
    assert!(asked, "{shown}");
    assert_eq!(child.wait().expect("it ends").code(), Some(1), "{shown}");
    assert!(checkpoint(folder, "out").exists());
}

#[test]
fn foreign_and_damaged_checkpoints_are_refused() {
    let folder = study(200, 1);
    let folder = folder.path();
    let child = lacuna(folder, "out", &["--quiet"]).stdout(Stdio::null()).spawn().expect("starts");
    wait_for("a checkpoint", || checkpoint(folder, "out").exists());
    interrupt(child);
    let refused = |more: &[&str]| {
        let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
        command.current_dir(folder).args(["scenario", "study.ron", "--quiet"]).args(more);
        let output = command.output().expect("runs");
        assert_eq!(output.status.code(), Some(2), "{more:?}: {}", text(&output.stderr));
        text(&output.stderr)
    };
    let foreign = refused(&["--resume", "out", "--seed", "2"]);
    assert!(
        foreign.contains("penalty.checkpoint.json") && foreign.contains("seed 1, this is seed 2"),
        "{foreign}"
    );
    assert!(refused(&["--resume", "elsewhere"]).contains("no checkpoint"));
    assert!(refused(&["--resume", "out", "--out", "other"]).contains("different folders"));
    let file = checkpoint(folder, "out");
    let content = std::fs::read_to_string(&file).expect("reads");
    let changed = content.replacen("\"evaluations\":", "\"evaluations\":1", 1);
    assert_ne!(changed, content);
    std::fs::write(&file, changed).expect("writes");
    assert!(refused(&["--resume", "out"]).contains("damaged"));
    std::fs::write(&file, &content[..content.len() / 2]).expect("writes");
    let cut = refused(&["--resume", "out"]);
    assert!(cut.contains("damaged") && cut.contains("help"), "{cut}");
}

#[test]
fn an_interrupted_diagnosis_keeps_what_it_had_found() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out");
    let mut child = Command::new(env!("CARGO_BIN_EXE_lacuna"))
        .args(["diagnose", "scenarios/mystery_two.ron", "--auto", "--jobs", "1", "--out"])
        .arg(&out)
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    let first = lines.find(|line| line.contains("found ")).expect("something is found");
    let id = child.id().to_string();
    assert!(Command::new("kill").args(["-INT", &id]).status().expect("kill is there").success());
    let rest: Vec<String> = lines.collect();
    let ended = child.wait_with_output().expect("it ends");
    assert_eq!(ended.status.code(), Some(1), "{rest:?}");
    assert!(rest.iter().any(|line| line.contains("keeping the best")), "{rest:?}");
    assert!(!rest.iter().any(|line| line.contains("calibrating")), "it went on: {rest:?}");
    assert!(text(&ended.stdout).contains("interrupted: "), "{}", text(&ended.stdout));
    let read = |file: &str| std::fs::read_to_string(out.join(file)).expect("was written");
    let diagnosis: serde_json::Value = serde_json::from_str(&read("diagnosis.json")).expect("JSON");
    assert!(diagnosis["stop_reason"].as_str().is_some_and(|why| why.starts_with("interrupted")));
    let steps = diagnosis["ladder"].as_array().expect("a list");
    let found = steps[0]["effect"].as_str().expect("a name");
    assert!(first.contains(found) && read("model.ron").contains(found), "{first}: {found}");
}

#[test]
fn a_system_that_shuts_down_is_as_good_as_ctrl_c() {
    let folder = study(400, 1);
    let folder = folder.path();
    let child =
        lacuna(folder, "out", &[]).stdout(Stdio::piped()).stderr(Stdio::piped()).spawn().expect("starts");
    wait_for("a checkpoint", || checkpoint(folder, "out").exists());
    send("-TERM", &child);
    let ended = child.wait_with_output().expect("it ends");
    let (said, shown) = (text(&ended.stdout), text(&ended.stderr));
    assert_eq!(ended.status.code(), Some(1), "{shown}");
    assert!(shown.contains("keeping the best"), "{shown}");
    assert!(said.contains("--resume out"), "{said}");
    assert!(checkpoint(folder, "out").exists());
    assert!(report(folder, "out")["retrievals"][0]["objective"].is_f64());
}

/// A log of the two-link robot, so long that every step of a diagnosis takes a while.
fn long_log(file: &Path) {
    use std::io::Write;
    let mut out = std::io::BufWriter::new(std::fs::File::create(file).expect("creates"));
    writeln!(out, "t,q1,q2,dq1,dq2,tau1,tau2").expect("writes");
    for k in 0..300_000 {
        let t = 0.002 * f64::from(k);
        let (a, b) = (0.7 * t, 1.3 * t);
        let (q, dq) = ([a.sin(), b.cos()], [0.7 * a.cos(), -1.3 * b.sin()]);
        let tau = [9.0 * q[0] + 0.4 * dq[0].signum(), 3.0 * q[1] + 0.2 * q[0] * dq[1]];
        writeln!(out, "{t:.3},{:.6},{:.6},{:.6},{:.6},{:.5},{:.5}", q[0], q[1], dq[0], dq[1], tau[0], tau[1])
            .expect("writes");
    }
}

#[test]
fn ctrl_c_with_nothing_found_yet_ends_at_once_however_long_the_log() {
    let folder = tempfile::tempdir().expect("a folder");
    long_log(&folder.path().join("long.csv"));
    std::fs::copy("robots/two_link.ron", folder.path().join("two_link.ron")).expect("copies");
    let mut child = Command::new(env!("CARGO_BIN_EXE_lacuna"))
        .current_dir(folder.path())
        .args(["diagnose", "--robot", "two_link.ron", "--data", "long.csv", "--auto", "--out", "out"])
        .stdout(Stdio::piped())
        .stderr(Stdio::piped())
        .spawn()
        .expect("starts");
    let mut lines = BufReader::new(child.stderr.take().expect("a pipe")).lines().map_while(Result::ok);
    assert!(lines.any(|line| line.contains("choosing the source")), "the logs are read");
    send("-INT", &child);
    let rest: Vec<String> = lines.collect();
    let ended = child.wait_with_output().expect("it ends");
    // Whoever waits for the end of a step answers with what was found, and with 1.
    assert_eq!(ended.status.code(), Some(130), "{rest:?}");
    assert!(ended.stdout.is_empty() && !rest.iter().any(|l| l.contains("keeping")), "{rest:?}");
    let left: Vec<_> = std::fs::read_dir(folder.path().join("out"))
        .map_or_else(|_| Vec::new(), |all| all.map(|entry| entry.expect("reads").file_name()).collect());
    // The lock file of a process that is gone is no lock; whoever comes next takes it over.
    assert!(left.iter().all(|name| name == ".lacuna.lock"), "nothing half-written: {left:?}");
}
