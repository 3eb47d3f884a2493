//! `lacuna simulate`: the shipped mysteries come out again, the truth stays where it is, mistakes are named.

use std::fs;
use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Command, Output};

use flate2::read::GzDecoder;
use lacuna::log::Log;
use lacuna::robot::Robot;
use lacuna::{Result, simulate};

const MYSTERIES: [&str; 3] = ["one", "two", "unknown"];

fn lacuna(arguments: &[&str]) -> Output {
    Command::new(env!("CARGO_BIN_EXE_lacuna")).args(arguments).output().expect("it runs")
}

fn unpacked(path: &Path) -> String {
    let mut text = String::new();
    let file = fs::File::open(path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    GzDecoder::new(file).read_to_string(&mut text).expect("gzip");
    text
}

fn plant(name: &str) -> PathBuf {
    Path::new("tests/mystery_plants").join(format!("{name}.ron"))
}

#[test]
fn mysteries_come_out_again_to_the_bit() -> Result<()> {
    let folder = tempfile::tempdir().expect("a folder");
    let mut bytes = 0;
    for name in MYSTERIES {
        simulate::run(&plant(name), None)?.write(folder.path())?;
        for log in ["fit", "validate"] {
            let file = format!("{name}_{log}.csv.gz");
            let shipped = Path::new("scenarios/mystery").join(&file);
            bytes += fs::metadata(&shipped).map_or(0, |m| m.len());
            let (ours, theirs) = (unpacked(&folder.path().join(&file)), unpacked(&shipped));
            let differs = ours.lines().zip(theirs.lines()).position(|(a, b)| a != b);
            assert_eq!(differs, None, "{file} differs from line {:?} on", differs.map(|d| d + 1));
            assert_eq!(ours.len(), theirs.len(), "{file}");
        }
    }
    println!("the mysteries take {bytes} bytes");
    assert!(bytes < 6_000_000);
    Ok(())
}

#[test]
fn logs_are_those_of_a_working_robot() -> Result<()> {
    let robot = Robot::open("robots/panda.ron")?;
    for name in MYSTERIES {
        let log = Log::open(format!("scenarios/mystery/{name}_fit.csv.gz"), &robot, None)?;
        assert_eq!((log.rows(), log.dropped.len()), (6901, 0));
        let rms = |x: &[f64]| (x.iter().map(|v| v * v).sum::<f64>() / x.len() as f64).sqrt();
        let heavy = rms(&log.tau[1]);
        assert!((5.0..60.0).contains(&heavy), "{name}: joint 2 carries {heavy} N m");
        let dq = log.dq.as_ref().expect("velocities are logged");
        assert!(dq.iter().all(|dq| rms(dq) > 0.2), "{name}: every joint moves");
    }
    Ok(())
}

/// A small experiment in a folder of its own.
fn two_link(folder: &Path, effects: &str, log: &str) -> PathBuf {
    let robot = fs::canonicalize("robots/two_link.ron").expect("it is there");
    fs::copy(robot, folder.join("two_link.ron")).expect("copies");
    let file = folder.join("plant.ron");
    let text = format!(
        "(\n    robot: \"two_link.ron\",\n    effects: [{effects}],\n    \
         sensors: (sampling_time_s: 0.002, torque_noise: [0.05]),\n    logs: [{log}],\n)\n"
    );
    fs::write(&file, text).expect("writes");
    file
}

const LOG: &str = "(name: \"a\", duration_s: 4, motion: Random(harmonics: 3, period_s: 4, amplitude: 0.5))";

#[test]
fn the_command_writes_logs_and_hides_the_truth() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = two_link(folder.path(), "{\"joint_spring\": (stiffness: [0, 3.5])}", LOG);
    let out = folder.path().join("out");
    let arguments =
        ["simulate", file.to_str().expect("text"), "--out", out.to_str().expect("text"), "--json", "--quiet"];
    let answer = lacuna(&arguments);
    let said = String::from_utf8_lossy(&answer.stdout).into_owned();
    assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
    let json: serde_json::Value = serde_json::from_str(&said).expect("one JSON document");
    assert_eq!(json["logs"][0]["rows"], 2501);
    assert!(!said.contains("spring") && !said.contains("3.5"), "nothing is given away: {said}");
    let truth = fs::read_to_string(out.join("truth/plant.ron")).expect("the truth is written");
    assert!(truth.contains("joint_spring") && truth.contains("3.5") && truth.contains("load_rms"), "{truth}");
    let before = unpacked(&out.join("a.csv.gz"));
    assert!(before.starts_with("t,q1,q2,dq1,dq2,tau1,tau2\n"));
    for jobs in ["1", "2"] {
        assert!(lacuna(&[&arguments[..], &["--jobs", jobs]].concat()).status.success());
        assert_eq!(unpacked(&out.join("a.csv.gz")), before, "same bits with {jobs} threads");
    }
    assert!(lacuna(&[&arguments[..], &["--seed", "9"]].concat()).status.success());
    assert_ne!(unpacked(&out.join("a.csv.gz")), before, "another seed, another log");
}

#[test]
fn no_command_needs_or_reads_the_truth() {
    let folder = tempfile::tempdir().expect("a folder");
    let file = two_link(folder.path(), "{\"coulomb_friction\": (levels: [0.3])}", LOG);
    let data = folder.path().join("data");
    let made = lacuna(&["simulate", file.to_str().expect("text"), "--out", data.to_str().expect("text")]);
    assert!(made.status.success());
    let scenario = folder.path().join("study.ron");
    fs::write(&scenario, "(robot: \"two_link.ron\", logs: Files(fit: [\"data/a.csv.gz\"]))").expect("writes");
    let report = |out: &str| {
        let out = folder.path().join(out);
        let answer =
            lacuna(&["scenario", scenario.to_str().expect("text"), "--out", out.to_str().expect("text")]);
        assert!(answer.status.success(), "{}", String::from_utf8_lossy(&answer.stderr));
        let text = fs::read_to_string(out.join("report.json")).expect("a report");
        let mut json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
        json.as_object_mut().expect("an object").remove("timing");
        json
    };
    let with = report("with");
    fs::write(data.join("truth/plant.ron"), "this would break whoever reads it").expect("writes");
    assert_eq!(report("spoilt"), with);
    fs::remove_dir_all(data.join("truth")).expect("removes");
    assert_eq!(report("without"), with);
}

#[test]
fn mistakes_are_named_with_their_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let spring = "{\"joint_spring\": (stiffness: [1, 2])}";
    for (effects, log, want) in [
        ("{\"joint_sprung\": (stiffness: [1])}", LOG, "joint_sprung"),
        ("{\"joint_spring\": (stifness: [1])}", LOG, "stifness"),
        ("{\"joint_spring\": (stiffness: [1, 2, 3])}", LOG, "3 numbers for 2 joints"),
        ("{\"coupled_friction\": (joint: 3, from: 1)}", LOG, "joint 3 of a robot with 2"),
        (spring, "", "`logs` is empty"),
        (spring, &format!("{LOG}, {LOG}"), "two logs are called `a`"),
        (spring, &LOG.replace("\"a\"", "\"../a\""), "no name for a log"),
        (spring, &LOG.replace("duration_s: 4", "duration_s: -4"), "-4 s"),
    ] {
        let file = two_link(folder.path(), effects, log);
        let answer = lacuna(&["simulate", file.to_str().expect("text"), "--out", "never"]);
        let said = String::from_utf8_lossy(&answer.stderr).into_owned();
        assert_eq!(answer.status.code(), Some(2), "{said}");
        assert!(said.contains(want) && said.contains("plant.ron"), "{want}: {said}");
        assert!(answer.stdout.is_empty() && !Path::new("never").exists());
    }
    let file = two_link(folder.path(), "{\"joint_spring\": (stifness: [1])}", LOG);
    let said = lacuna(&["simulate", file.to_str().expect("text"), "--out", "never"]);
    assert!(String::from_utf8_lossy(&said.stderr).contains("plant.ron:3:"), "the line is named");
    assert_eq!(lacuna(&["simulate", file.to_str().expect("text")]).status.code(), Some(2), "--out is needed");
}
