//! Folders for results: what was made there is replaced, nothing else ever is.

use std::fs;
use std::process::Stdio;
use std::time::{Duration, Instant};

use super::folder::Folder;

const PLANT: &str = "(
    robot: \"arm.ron\",
    logs: [(name: \"a\", duration_s: 1, motion: Random(harmonics: 2, period_s: 1, amplitude: 0.2))],
)";
const DIAGNOSE: [&str; 5] = ["diagnose", "--robot", "arm.ron", "--data", "log.csv"];

fn read(folder: &Folder, name: &str) -> String {
    fs::read_to_string(folder.path(name)).expect("reads")
}

#[test]
fn a_folder_with_files_of_somebody_else_is_refused_by_every_command() {
    let folder = Folder::new();
    folder.write("plant.ron", PLANT);
    fs::create_dir(folder.path("mine")).expect("makes");
    folder.write("mine/model.ron", "mine");
    for command in
        [&["scenario", "good.ron"][..], &DIAGNOSE, &["benchmark"], &["simulate", "plant.ron"], &["workbench"]]
    {
        let words = ["not empty", "`model.ron`", "--out DIR"];
        folder.refused(&[command, &["--out", "mine"]].concat(), "mine: ", &words);
        folder.refused(&[command, &["--out", "log.csv"]].concat(), "log.csv: ", &["--out DIR"]);
    }
    assert_eq!(read(&folder, "mine/model.ron"), "mine");
}

#[test]
fn results_are_replaced_and_what_lies_beside_them_is_not() {
    let folder = Folder::new();
    folder.write("plant.ron", PLANT);
    for command in [&["scenario", "good.ron"][..], &["simulate", "plant.ron"]] {
        let command = [command, &["--quiet", "--out", "out"]].concat();
        let run = || assert_eq!(folder.run(&command).code, Some(0), "{command:?}");
        run();
        folder.write("out/notes.txt", "mine");
        run();
        assert_eq!(read(&folder, "out/notes.txt"), "mine");
    }
    assert!(folder.path("out/a.csv.gz").is_file() && folder.path("out/report.json").is_file());
    // A name that this study did not need, but another one may.
    folder.write("out/identified.ron", "mine");
    folder.refused(
        &["scenario", "good.ron", "--out", "out"],
        "out/identified.ron: ",
        &["did not make", "--out"],
    );
    let names: Vec<_> =
        fs::read_dir(folder.path("out")).expect("reads").map(|e| e.expect("reads").path()).collect();
    assert!(!names.iter().any(|n| n.ends_with(".lacuna.lock")), "the lock is given back: {names:?}");
}

#[test]
fn an_export_replaces_exports_and_nothing_else() {
    let folder = Folder::new();
    folder.write("retrieved.ron", super::RETRIEVED);
    assert_eq!(folder.run(&["scenario", "retrieved.ron", "--quiet", "--out", "out"]).code, Some(0));
    let export = |format: &'static str, to: &'static str| {
        ["export", "out/model.ron", "--robot", "arm.ron", "--format", format, "--out", to]
    };
    folder.write("mine.txt", "mine");
    for format in ["urdf", "mjcf", "json"] {
        folder.refused(&export(format, "mine.txt"), "mine.txt: ", &["no export", "--out"]);
        folder.write("fresh", "");
        for _ in 0..2 {
            let answer = folder.run(&export(format, "fresh"));
            assert_eq!(answer.code, Some(0), "{format}: {}", answer.err);
        }
    }
    assert_eq!(read(&folder, "mine.txt"), "mine");
}

#[test]
fn an_export_stays_in_its_folder_whatever_the_robot_is_called() {
    let folder = Folder::new();
    folder.write("retrieved.ron", super::RETRIEVED);
    assert_eq!(folder.run(&["scenario", "retrieved.ron", "--quiet", "--out", "out"]).code, Some(0));
    let arm = read(&folder, "arm.ron");
    let name = arm.split("name: \"").nth(1).and_then(|rest| rest.split('"').next()).expect("a name");
    for file in ["arm.ron", "out/model.ron"] {
        folder.write(file, read(&folder, file).replacen(&format!("\"{name}\""), "\"../escaped\"", 1));
    }
    fs::create_dir(folder.path("there")).expect("makes");
    let to = ["--robot", "arm.ron", "--format", "json", "--out", "there"];
    let answer = folder.run(&[&["export", "out/model.ron"][..], &to].concat());
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    assert!(!folder.path("escaped.json").exists());
    assert!(folder.path("there/_escaped.json").exists(), "{:?}", folder.files());
}

#[test]
fn a_folder_that_is_not_there_cannot_be_gone_on_with() {
    let folder = Folder::new();
    folder.refused(&["scenario", "good.ron", "--resume", "nosuch"], "nosuch: ", &["go on with"]);
}

#[test]
fn a_folder_of_a_version_without_lists_is_known() {
    let folder = Folder::new();
    let command = ["scenario", "good.ron", "--quiet"];
    assert_eq!(folder.run(&command).code, Some(0));
    fs::remove_file(folder.path("out/good/.lacuna.json")).expect("a list");
    folder.write("out/good/notes.txt", "mine");
    assert_eq!(folder.run(&command).code, Some(0));
    assert!(read(&folder, "out/good/.lacuna.json").contains("\"report.html\""));
    assert!(!read(&folder, "out/good/.lacuna.json").contains("notes.txt"));
}

#[cfg(unix)]
#[test]
fn links_among_results_are_not_followed() {
    let folder = Folder::new();
    let command = ["scenario", "good.ron", "--out", "out"];
    assert_eq!(folder.run(&command).code, Some(0));
    folder.write("precious", "precious");
    fs::remove_file(folder.path("out/model.ron")).expect("removes");
    std::os::unix::fs::symlink("../precious", folder.path("out/model.ron")).expect("links");
    folder.refused(&command, "out/model.ron: ", &["link", "--out"]);
    assert_eq!(read(&folder, "precious"), "precious");
}

#[test]
fn a_second_process_is_refused_until_the_first_is_gone() {
    let folder = Folder::new();
    let long = super::RETRIEVED.replace("runs: 4", "runs: 2000");
    folder.write("long.ron", long);
    let first = ["scenario", "long.ron", "--quiet", "--out", "out"];
    let mut child = folder.command(&first).stdout(Stdio::null()).spawn().expect("starts");
    let checkpoint = folder.path("out/penalty.checkpoint.json");
    let start = Instant::now();
    while !checkpoint.exists() {
        assert!(start.elapsed() < Duration::from_secs(60), "no checkpoint");
        std::thread::sleep(Duration::from_millis(10));
    }
    let second = folder.run(&["scenario", "good.ron", "--quiet", "--out", "out"]);
    assert_eq!(second.code, Some(2), "{}", second.err);
    assert!(second.err.contains(&format!("out: process {} has", child.id())), "{}", second.err);
    child.kill().expect("ends");
    child.wait().expect("ended");
    assert_eq!(folder.run(&["scenario", "good.ron", "--quiet", "--out", "out"]).code, Some(0));
    let left = folder.files().into_iter().filter(|f| f.to_string_lossy().contains(".partial")).count();
    assert_eq!(left, 0, "what the first one left half-written is cleared");
}

/// A file that may not grow stands for a full disk.
#[cfg(unix)]
#[test]
fn a_full_disk_leaves_whole_files_or_none() {
    let folder = Folder::new();
    let program = env!("CARGO_BIN_EXE_lacuna");
    let limited = |limit: u32| {
        let script =
            format!("ulimit -f {limit}; trap '' XFSZ; exec \"$0\" scenario good.ron --quiet --out out");
        let mut command = std::process::Command::new("bash");
        let output =
            command.args(["-c", &script, program]).current_dir(folder.path("")).output().expect("runs");
        (output.status.code(), String::from_utf8_lossy(&output.stderr).into_owned())
    };
    for limit in [0, 8] {
        let (code, said) = limited(limit);
        assert!(code == Some(2) && said.contains("cannot write here"), "{limit}: {code:?} {said}");
        let half = folder.files().into_iter().filter(|f| f.to_string_lossy().contains(".partial")).count();
        assert_eq!((half, folder.path("out/report.html").exists()), (0, false));
    }
    assert_eq!(
        folder.run(&["scenario", "good.ron", "--out", "out"]).code,
        Some(0),
        "it works once there is room"
    );
}

#[cfg(unix)]
#[test]
fn a_folder_that_may_not_be_written_to_is_refused_at_once() {
    use std::os::unix::fs::PermissionsExt;
    let folder = Folder::new();
    fs::create_dir(folder.path("sealed")).expect("makes");
    fs::set_permissions(folder.path("sealed"), fs::Permissions::from_mode(0o555)).expect("sets");
    if fs::write(folder.path("sealed/probe"), "").is_ok() {
        eprintln!("skipped: this user may write anywhere");
        return;
    }
    for out in ["sealed", "sealed/below"] {
        folder.refused(
            &["scenario", "good.ron", "--out", out],
            &format!("{out}: "),
            &["cannot write here", "--out"],
        );
    }
}
