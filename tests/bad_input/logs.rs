use std::io::Write;

use super::folder::{Folder, LOG_HEADER, STATES_HEADER};

/// Gives a log to every command that reads one. States have the columns of a log as far as they can.
#[track_caller]
fn refused(content: impl AsRef<[u8]>, place: &str, words: &[&str]) {
    let folder = Folder::new();
    folder.write("bad.csv", content);
    let place = if place.is_empty() { "bad.csv".to_owned() } else { format!("bad.csv:{place}: ") };
    folder.refused(&["scenario", "files.ron", "--data", "bad.csv"], &place, words);
    folder.refused(&["compare", "model.ron", "--robot", "arm.ron", "--data", "bad.csv"], &place, words);
    let checked = folder.run(&["check", "bad.csv", "--robot", "arm.ron"]);
    assert!(matches!(checked.code, Some(1 | 2)), "check finds nothing: {}{}", checked.out, checked.err);
}

#[track_caller]
fn refused_states(rows: &str, place: &str, words: &[&str]) {
    let folder = Folder::new();
    folder.write("bad.csv", format!("{STATES_HEADER}{rows}"));
    let arguments = ["dynamics", "--robot", "arm.ron", "--states", "bad.csv"];
    folder.refused(&arguments, &format!("bad.csv{place}: "), words);
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(bytes).expect("memory takes all bytes");
    packed.finish().expect("memory takes all bytes")
}

fn rows(row: impl Fn(f64) -> String) -> String {
    let rows: String = (0..500).map(|k| format!("{},{}\n", 0.01 * f64::from(k), row(f64::from(k)))).collect();
    format!("{LOG_HEADER}{rows}")
}

#[test]
fn tables_that_are_none() {
    refused("", "1:1", &["the file is empty", "header line"]);
    refused(LOG_HEADER, "1:1", &["no row"]);
    refused("t,q1,q2,tau1\n0,1,2,3\n", "1:1", &["no column `tau2`", "--columns"]);
    refused("t,q1,tau1\n0,1,2\n", "1:1", &["1 joints; the robot `arm` has 2"]);
    refused("0,1,2,3,4\n1,1,2,3,4\n", "1:1", &["no header line"]);
    refused(LOG_HEADER.replace(',', ";"), "1:1", &["delimiter: ';'"]);
    refused(format!("{}\n", "x,".repeat(100_000)), "1:1", &["100001 columns", "4096"]);
    refused(b"PK\x03\x04......", "1:1", &["Excel"]);
}

#[test]
fn rows_that_are_none() {
    refused(rows(|_| "NaN,NaN,NaN,NaN".into()), "2:2", &["500 of 500 rows", "`NaN` in `q1`"]);
    refused(rows(|_| "1,2,3,4x".into()), "2:5", &["`4x` in `tau2` is not a number"]);
    refused(rows(|_| "1,2,3,4".into()).replace("0.01,", "0,"), "", &["rows can be used"]);
    refused(rows(|k| format!("{},2,{k},4", (0.1 * k).sin())).replace(",4\n", "\n"), "2:5", &["4 fields"]);
    refused_states("", ":1:1", &["no row"]);
    refused_states("1,2,3,4,5,NaN\n", ":2:6", &["`NaN` in `ddq2`"]);
    refused_states("1,2,3,4,5,6\n1,2,x,4,5,6\n", ":3:3", &["every state needs numbers"]);
    refused_states("1,2,3,4,5,6\n1,2,1e200,4,5,6\n", "", &["the torque of state 2"]);
}

/// Numbers that no robot has: an error or numbers, never a model of infinities.
#[test]
fn logs_without_sense() {
    let wave = |k: f64| (0.03 * k).sin();
    refused(rows(|k| format!("{},{},0,1e200", 1e200 * wave(k), wave(2.0 * k))), "", &["too large"]);
    refused(rows(|k| format!("{},{},1.7e308,1", wave(k), wave(2.0 * k))), "", &["too large"]);
}

#[test]
fn gzip_files() {
    let packed = gzip(rows(|k| format!("{},2,{k},4", (0.1 * k).sin())).as_bytes());
    refused(&packed[..packed.len() / 2], "", &["cut off", "completely"]);
    refused(&packed[..12], "1:1", &["cut off"]);
    let mut damaged = packed.clone();
    damaged[20..40].fill(0x55);
    refused(damaged, "", &["damaged"]);
}

/// A file of 5 MB that unpacks to 5 GB is refused in less memory than its first hundredth needs.
#[cfg(target_os = "linux")]
#[test]
fn gzip_bombs_take_no_memory() {
    let folder = Folder::new();
    folder.write("bomb.csv.gz", gzip(&vec![b'\n'; 1 << 24]).repeat(300));
    let program = env!("CARGO_BIN_EXE_lacuna");
    for command in ["scenario files.ron --data", "compare model.ron --robot arm.ron --data"] {
        let limited = format!("ulimit -v 60000; exec {program} --jobs 2 {command} bomb.csv.gz");
        let shell =
            std::process::Command::new("sh").args(["-c", &limited]).current_dir(folder.path("")).output();
        let output = shell.expect("a shell");
        let said = String::from_utf8_lossy(&output.stderr);
        assert_eq!(output.status.code(), Some(2), "{said}");
        assert!(said.contains("error: bomb.csv.gz:") && said.contains("gzip bomb"), "{said}");
    }
}

#[test]
fn static_poses() {
    let folder = Folder::new();
    folder.write("poses.ron", "(robot: \"arm.ron\", poses: File(\"poses.csv\"))");
    let header = "q1,q2,g1,g2,m11,m21,m22\n";
    for (content, place, words) in [
        (String::new(), ":1:1", "empty"),
        ("q1,q2,g1,g2,m11,m22\n1,2,3,4,5,6\n".to_owned(), ":1:1", "no column `m21`"),
        (format!("{header}1,2,3,4,5,6,seven\n"), ":2:7", "`seven` in `m22`"),
        (format!("{header}1,2,3,4,5,6,7\n"), "", "rows for"),
        (format!("{header}{}", "1,2,3,4,5,6,7\n".repeat(9)), "", "do not determine"),
        (format!("{header}{}", "1,2,0,0,0,0,0\n".repeat(9)), "", "do not determine"),
    ] {
        folder.write("poses.csv", content);
        folder.refused(&["scenario", "poses.ron"], &format!("poses.csv{place}: "), &[words]);
    }
}

#[test]
fn column_maps() {
    let folder = Folder::new();
    let compare = |map: &'static str| {
        ["compare", "model.ron", "--robot", "arm.ron", "--data", "log.csv", "--columns", map]
    };
    folder.refused(&compare("nothing"), "nothing: ", &["libfranka, ur_rtde"]);
    folder.refused(&compare("."), ".: ", &["a folder"]);
    for (map, place, words) in [
        ("", "1:1", "empty"),
        ("(delimeter: ';')", "1:2", "did you mean `delimiter`?"),
        ("(delimiter: 'q')", "1:15", "delimiter must be"),
        ("(position: (columns: \"q{1}\", unit: Degree))", "1:36", "did you mean `Degrees`?"),
        ("(time: (rate_hz: -1))", "1:", "`rate_hz` is -1"),
        ("(torque: (current: \"i{1}\"))", "1:", "current and gains"),
    ] {
        folder.write("map.ron", map);
        folder.refused(&compare("map.ron"), &format!("map.ron:{place}"), &[words]);
    }
    folder.write("map.ron", "(position: (columns: \"angle{1}\"))");
    folder.refused(&compare("map.ron"), "log.csv:1:1: ", &["no column `angle1`"]);
}
