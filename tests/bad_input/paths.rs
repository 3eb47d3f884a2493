use std::ffi::OsString;

use super::folder::Folder;

#[test]
fn files_that_are_not_there_or_are_none() {
    let folder = Folder::new();
    std::fs::create_dir(folder.path("sub")).expect("a folder");
    for name in ["none", "sub"] {
        let words: &[&str] =
            if name == "sub" { &["a folder, not a file"] } else { &["cannot read the file"] };
        let place = format!("{name}: ");
        folder.refused(&["scenario", name], &place, words);
        folder.refused(&["scenario", "files.ron", "--data", name], &place, words);
        folder.refused(&["dynamics", "--robot", name, "--states", "states.csv"], &place, words);
        folder.refused(&["dynamics", "--robot", "arm.ron", "--states", name], &place, words);
        folder.refused(&["compare", name, "--robot", "arm.ron", "--data", "log.csv"], &place, words);
        folder.refused(&["compare", "model.ron", "--robot", name, "--data", "log.csv"], &place, words);
        folder.refused(&["compare", "model.ron", "--robot", "arm.ron", "--data", name], &place, words);
    }
    folder.write("sub.ron", "(robot: \"sub\", logs: Files(fit: [\"sub\"]))");
    folder.refused(&["scenario", "sub.ron"], "sub: ", &["a folder, not a file"]);
    folder.write("sub.ron", "(robot: \"arm.ron\", logs: Files(fit: [\"sub\"]))");
    folder.refused(&["scenario", "sub.ron"], "sub.ron:1:38: ", &["no log `sub`"]);
}

/// What has no end is not read to its end.
#[cfg(unix)]
#[test]
fn devices() {
    let folder = Folder::new();
    folder.refused(&["scenario", "/dev/zero"], "/dev/zero: ", &["larger than 16 MiB"]);
    folder.refused(
        &["dynamics", "--robot", "/dev/zero", "--states", "states.csv"],
        "/dev/zero: ",
        &["larger than"],
    );
    folder.refused(
        &["dynamics", "--robot", "arm.ron", "--states", "/dev/zero"],
        "/dev/zero:1:1: ",
        &["longer than"],
    );
}

#[test]
fn flags() {
    let folder = Folder::new();
    for gravity in ["down", "", "1,2", "1,2,3,4", "0,0,nan", "0,0,inf", "0;0;9", "0,0,1e300"] {
        let flag = format!("--gravity \"{gravity}\" ");
        let dynamics = ["dynamics", "--robot", "arm.ron", "--states", "states.csv", "--gravity", gravity];
        folder.refused(&dynamics, &flag, &["--gravity 0,0,-9.81"]);
        let compare =
            ["compare", "model.ron", "--robot", "arm.ron", "--data", "log.csv", "--gravity", gravity];
        folder.refused(&compare, &flag, &["--gravity 0,0,-9.81"]);
    }
    folder.refused(
        &["dynamics", "--robot", "arm.ron", "--states", "states.csv", "--json"],
        "--json",
        &["leave out --json"],
    );
    folder.refused(&["list", "efects"], "cannot list `efects`", &["effects, constraints, engines"]);
    folder.refused(&["list", "effects", "rigid"], "no effect called `rigid`", &["rigid_body"]);
    for arguments in [
        &["--jobs", "0", "list", "effects"][..],
        &["--jobs", "many", "list", "effects"],
        &["--seed", "-1", "list", "effects"],
        &["scenario"],
        &["scenario", "good.ron", "--dta", "log.csv"],
        &["compare", "--robot", "arm.ron", "--data", "log.csv"],
        &["dynamics"],
        &["scenaro", "good.ron"],
        &[],
    ] {
        let answer = folder.run(arguments);
        assert_eq!((answer.code, answer.out.as_str()), (Some(2), ""), "{arguments:?}");
        assert!(answer.err.contains("--help") || answer.err.contains("Usage"), "{}", answer.err);
    }
}

#[test]
fn results_that_cannot_be_written() {
    let folder = Folder::new();
    for out in ["arm.ron", "arm.ron/deeper", "/dev/null/x", "/proc/none"] {
        folder.refused(&["scenario", "good.ron", "--out", out], &format!("{out}: "), &["--out"]);
    }
    // A result that cannot take its place is refused before the work, and leaves nothing half-written beside it.
    assert_eq!(folder.run(&["scenario", "good.ron", "--quiet", "--out", "taken"]).code, Some(0));
    std::fs::remove_file(folder.path("taken/report.json")).expect("there");
    std::fs::create_dir_all(folder.path("taken/report.json/x")).expect("folders");
    folder.refused(&["scenario", "good.ron", "--quiet", "--out", "taken"], "taken/report.json: ", &["--out"]);
}

/// A run that is killed at any time leaves whole files or none.
#[cfg(unix)]
#[test]
fn an_interrupted_run_leaves_no_half_report() {
    let folder = Folder::new();
    for milliseconds in (0..12).map(|k| 10 * k) {
        let mut child = folder
            .command(&["scenario", "good.ron", "--quiet", "--out", "out"])
            .stdout(std::process::Stdio::null())
            .spawn()
            .expect("the program starts");
        std::thread::sleep(std::time::Duration::from_millis(milliseconds));
        // It may have ended by itself.
        let _ = child.kill();
        child.wait().expect("it ends");
        if let Ok(text) = std::fs::read_to_string(folder.path("out/report.json")) {
            assert!(serde_json::from_str::<serde_json::Value>(&text).is_ok(), "half a report");
        }
    }
}

/// File names need not be UTF-8, and come out readable.
#[cfg(target_os = "linux")]
#[test]
fn names_that_are_no_text() {
    use std::os::unix::ffi::OsStringExt;
    let folder = Folder::new();
    let name = |ending: &str| OsString::from_vec([b"\xFF", ending.as_bytes()].concat());
    for (from, to) in
        [("good.ron", ".ron"), ("arm.ron", "arm.ron"), ("log.csv", ".csv"), ("model.ron", "m.ron")]
    {
        std::fs::copy(folder.path(from), folder.path(name(to))).expect("copies");
    }
    let argument = |text: &str| OsString::from(text);
    let scenario = [argument("scenario"), name(".ron"), argument("--quiet"), argument("--json")];
    let answer = folder.run(&scenario);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let report: serde_json::Value = serde_json::from_str(&answer.out).expect("JSON");
    assert_eq!(report["scenario"], "\u{fffd}");
    let compare = [
        argument("compare"),
        name("m.ron"),
        argument("--robot"),
        name("arm.ron"),
        argument("--data"),
        name(".csv"),
        argument("--json"),
    ];
    let answer = folder.run(&compare);
    assert_eq!(answer.code, Some(0), "{}", answer.err);
    let missing = folder.run(&[argument("scenario"), name("none")]);
    assert_eq!(missing.code, Some(2));
    assert!(missing.err.starts_with("error: \u{fffd}none: "), "{}", missing.err);
}
