//! `scripts/panda_log.py`, on a made-up clone of two samples.

use super::*;
use std::fs;
use std::path::Path;
use std::process::{Command, Output};

/// Runs the script; `None` where there is no Python.
fn convert(clone: &Path, csv: &Path) -> Option<Output> {
    let script = Path::new(env!("CARGO_MANIFEST_DIR")).join("scripts/panda_log.py");
    let run = Command::new("python3").arg(script).arg(clone).arg(csv).output();
    run.inspect_err(|e| println!("skipped: python3 does not run ({e})")).ok()
}

#[test]
fn the_public_text_files_become_a_log() -> lacuna::Result<()> {
    let folder = tempfile::tempdir().expect("a folder for the test");
    let logs = folder.path().join("matlab/data/Exciting_Traj/Trajectory_1/rbt_log");
    fs::create_dir_all(&logs).expect("the folder is writable");
    let write = |name: &str, values: std::ops::Range<i32>| {
        let text: String = values.map(|v| format!("{v}.50\n")).collect();
        fs::write(logs.join(format!("exciting_traj_{name}.txt")), text).expect("the folder is writable");
    };
    write("time", 0..2);
    write("positions", 100..114);
    write("velocity", 200..214);
    write("torques", 300..314);
    for name in ["log.csv", "log.csv.gz"] {
        let csv = folder.path().join(name);
        let Some(run) = convert(folder.path(), &csv) else { return Ok(()) };
        assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
        let log = Log::open(&csv, &chain(7), None)?;
        assert_same(&log.t, &[0.5, 1.5]);
        assert_same(&log.q[6], &[106.5, 113.5]);
        assert_same(&log.dq.as_ref().expect("dq is there")[0], &[200.5, 207.5]);
        assert_same(&log.tau[1], &[301.5, 308.5]);
    }
    let text = fs::read_to_string(folder.path().join("log.csv")).expect("it is text");
    assert!(text.contains("\n0.50,100.50,"), "number texts are copied: {text}");

    write("torques", 300..313);
    let csv = folder.path().join("short.csv");
    let Some(run) = convert(folder.path(), &csv) else { return Ok(()) };
    let message = String::from_utf8_lossy(&run.stderr);
    assert!(!run.status.success() && message.contains("13 numbers, expected 14"), "{message}");
    assert!(!csv.exists());
    Ok(())
}
