use super::folder::{Folder, MODEL};

#[track_caller]
fn refused(from: &str, to: &str, place: &str, words: &[&str]) {
    let folder = Folder::new();
    assert!(MODEL.contains(from), "the model has no {from}");
    folder.write("bad.ron", MODEL.replacen(from, to, 1));
    let arguments = ["compare", "model.ron", "bad.ron", "--robot", "arm.ron", "--data", "log.csv"];
    folder.refused(&arguments, &format!("bad.ron:{place}: "), words);
}

#[test]
fn models() {
    refused(MODEL, "", "1:1", &["the file is empty", "lacuna scenario"]);
    refused(MODEL, "(robot: \"arm\")", "1:14", &["`lacuna`", "is missing"]);
    refused("robot: \"arm\"", "robot: \"leg\"", "3:5", &["model of the `robot` `leg`, not of `arm`"]);
    refused("\"fo2\"", "\"fo1\"", "8:18", &["`fo1` stands twice"]);
    refused("\"fv2\"", "\"fv1\"", "10:18", &["parameter `fv1`", "known are fo1, fo2, fv2"]);
    refused("value: 0.5", "value: NaN", "9:32", &["`value` is NaN"]);
    refused("value: 0.5", "value: half", "9:32", &["a number is expected"]);
    refused("band_hz: 5.0", "band_hz: -5.0", "5:24", &["`band_hz` is -5"]);
    refused("torque_offset", "torque_ofset", "6:17", &["did you mean `torque_offset`?"]);
    refused("\"joint2\"", "\"joint9\"", "6:85", &["no joint `joint9`", "joint1, joint2"]);
    refused("joints: All", "joint: All", "6:34", &["did you mean `joints`?"]);
    refused("        (symbol: \"fo2\", value: 0.5, unit: \"N m\"),\n", "", "7:5", &["no value of `fo2`"]);
}

#[test]
fn a_model_given_twice() {
    let folder = Folder::new();
    let arguments = ["compare", "model.ron", "model.ron", "--robot", "arm.ron", "--data", "log.csv"];
    folder.refused(&arguments, "model.ron: ", &["given twice"]);
}

#[test]
fn published_coefficients() {
    let folder = Folder::new();
    folder.write(
        "read_out.ron",
        "(robot: \"arm.ron\", poses: ReadOut(coefficients: \"table.ron\", count: 50, noise_percent: 0.1))",
    );
    for (table, place, words) in [
        ("", "1:1", "panda_table3.ron"),
        ("(source: \"me\")", "1:14", "`coefficients` of `Published` is missing"),
        ("(source: \"me\", coefficients: [(\"Jzz9\", 1)])", "1:32", "Jzz2"),
        ("(source: \"me\", coefficients: [(\"Jzz2\", 1), (\"Jzz2\", 1)])", "1:32", "`Jzz2` stands twice"),
        ("(source: \"me\", coefficients: [(\"Jzz2\", inf)])", "1:40", "`Jzz2` is infinite"),
        ("(source: \"me\", coefficients: [(\"Jzz2\")])", "1:38", "tuple of size 2"),
        ("(source: \"me\", coefficients: [(\"Jzz2\", \"1\")])", "1:40", "a number is expected"),
    ] {
        folder.write("table.ron", table);
        let found = folder.run(&["scenario", "read_out.ron"]).err;
        assert!(!found.is_empty());
        folder.refused(&["scenario", "read_out.ron"], &format!("table.ron:{place}"), &[words]);
    }
}
