use super::folder::{Folder, SIMULATED};

const ROBOT: &str = "robot: \"arm.ron\"";

/// Column 0 stands for any.
fn place(line: usize, column: usize) -> String {
    if column == 0 { "bad.ron".to_owned() } else { format!("bad.ron:{line}:{column}: ") }
}

/// Scenarios of one line: the rest of the text, the column, and words of the message.
#[track_caller]
fn refused(texts: &[(&str, usize, &[&str])]) {
    let folder = Folder::new();
    for (text, column, words) in texts {
        folder.write("bad.ron", text);
        folder.refused(&["scenario", "bad.ron"], &place(1, *column), words);
    }
}

/// The same with a robot and a simulated log before the rest of the text, which stands in the second line.
#[track_caller]
fn refused_after(texts: &[(&str, usize, &[&str])]) {
    let folder = Folder::new();
    for (text, column, words) in texts {
        folder.write("bad.ron", format!("({ROBOT}, logs: {SIMULATED},\n{text})"));
        folder.refused(&["scenario", "bad.ron"], &place(2, *column), words);
    }
}

/// `check` finds what running finds, but does not run.
#[test]
fn what_check_sees_of_scenarios() {
    let folder = Folder::new();
    for (text, words) in [
        ("seed: -1", "bad.ron:2:8: the whole number is out of range"),
        (
            "effects: [{\"torque_offset\": ()}, {\"torque_offset\": ()}]",
            "bad.ron:2:12: `torque_offset` would",
        ),
        ("effects: [{\"torque_offset\": (joints: Only([\"joint3\"]))}]", "no joint `joint3`"),
        ("presets: [\"none.ron\"]", "none.ron: cannot read"),
        ("weighting: Hubber", "did you mean `Huber`?"),
    ] {
        folder.write("bad.ron", format!("({ROBOT}, logs: {SIMULATED},\n{text})"));
        let checked = folder.run(&["check", "bad.ron"]);
        assert!(matches!(checked.code, Some(1 | 2)), "check finds nothing in {text}: {}", checked.out);
        assert!(checked.out.contains(words), "{text}: {}", checked.out);
    }
}

#[test]
fn texts_that_are_none() {
    let deep = format!("(robot: \"arm.ron\", effects: [{{\"rigid_body\": {}", "(".repeat(100_000));
    refused(&[
        ("", 1, &["the file is empty", "scenarios/panda.ron"]),
        ("()", 2, &["the field `robot` of `Scenario` is missing"]),
        ("(robot: \"arm.ron\", sead: 3)", 20, &["no field `sead`", "did you mean `seed`?"]),
        ("(robot: \"arm.ron\" seed: 3)", 19, &["comma"]),
        ("(robot: arm.ron)", 9, &["text in double quotes"]),
        ("(robot: \"arm.ron\", logs: Files(fit", 35, &["ends in the middle"]),
        ("{\"robot\": \"arm.ron\"}", 1, &["opening `(`"]),
        ("t,q1,q2\n0,1,2\n", 1, &["opening `(`"]),
        (&deep, 46, &["name is expected"]),
    ]);
    let folder = Folder::new();
    for brackets in ["[", "{\"rigid_body\":", "(joints:", "Some("] {
        let text = format!("(robot: \"arm.ron\",\neffects: {}", brackets.repeat(100_000));
        folder.write("deep.ron", text);
        folder.refused(&["scenario", "deep.ron"], "deep.ron:2:", &[]);
    }
    let text =
        format!("(robot: \"arm.ron\", effects: [{{\"torque_offset\": (joints:\n{}", "[".repeat(100_000));
    folder.write("deep.ron", text);
    folder.refused(&["scenario", "deep.ron"], "deep.ron:2:", &["`joints` takes `All`"]);
    folder.write("bytes.ron", b"(robot: \"\xFF\")");
    folder.refused(&["scenario", "bytes.ron"], "bytes.ron:1:10: ", &["not UTF-8"]);
}

#[test]
fn effects() {
    refused_after(&[
        ("effects: []", 1, &["`effects` names none", "rigid_body"]),
        ("effects: [{\"rigid_bdy\": ()}]", 13, &["did you mean `rigid_body`?", "torque_offset"]),
        ("effects: [rigid_body]", 11, &["{\"viscous_friction\": (joints: All)}"]),
        ("effects: [{\"torque_offset\": (joint: All)}]", 30, &["no field `joint`", "did you mean `joints`?"]),
        ("effects: [{\"torque_offset\": (joints: Al)}]", 0, &["`Al`", "`All`"]),
        ("effects: [{\"torque_offset\": (joints: [1])}]", 38, &["`joints` takes `All` or `Only([..])`"]),
        ("effects: [{\"torque_offset\": (joints: \"joint2\")}]", 38, &["Only([\"joint1\", \"joint2\"])"]),
        ("effects: [{\"torque_offset\": (joints: Only([1]))}]", 44, &["in double quotes"]),
        ("effects: [{\"torque_offset\": (joints: Only([]))}]", 0, &["list of joints is empty"]),
        (
            "effects: [{\"torque_offset\": (joints: Only([\"joint3\"]))}]",
            44,
            &["no joint `joint3`", "joint1, joint2"],
        ),
        (
            "effects: [{\"torque_offset\": (joints: Only([\"1\", \"joint1\"]))}]",
            49,
            &["`joint1` stands twice", "every joint once"],
        ),
        ("effects: [{\"torque_offset\": ()}, {\"torque_offset\": ()}]", 12, &["`fo1` twice"]),
        ("effects: [{\"coulomb_friction\": (width: -1)}]", 33, &["`width` of `coulomb_friction` is -1"]),
        ("effects: [{\"coulomb_friction\": (width: NaN)}]", 40, &["is NaN"]),
        ("effects: [{\"sigmoid_friction\": (phi2: [1], phi3: [0])}]", 12, &["2 joints", "1 values of phi2"]),
        ("effects: [{\"sigmoid_friction\": (phi2: [1, inf], phi3: [0, 0])}]", 43, &["`phi2` is infinite"]),
        ("effects: [{\"sigmoid_friction\": ()}]", 0, &["`phi2`", "is missing"]),
    ]);
}

#[test]
fn settings() {
    refused_after(&[
        ("signals: (band: 5)", 11, &["no field `band`", "did you mean `band_hz`?"]),
        ("signals: (mode: parallel)", 17, &["did you mean `Parallel`?"]),
        ("signals: (band_hz: 0)", 20, &["`band_hz` is 0", "give 1e-6 to"]),
        ("signals: (band_hz: 1e9)", 11, &["cut-off of 1000000000.0 Hz", "below 500 Hz"]),
        ("signals: (mode: Parallel, position_cutoff_hz: 900)", 27, &["below 500 Hz"]),
        ("signals: (order: 99)", 18, &["`order` is 99", "1 to 8"]),
        ("signals: (trim_s: 1e300)", 19, &["`trim_s` is 1e300", "too large"]),
        ("signals: (trim_s: 1e5)", 11, &["nothing is left", "100000.0 s"]),
        ("signals: (decimate: 0)", 21, &["`decimate` is 0"]),
        ("signals: (velocity_from: Gyro)", 26, &["Auto, Position, Velocity"]),
        ("hold_out: SamePhase(period_s: 0, folds: 8)", 31, &["`period_s` is 0 s", "1e-6 to"]),
        ("hold_out: Contiguous(block_s: 1, folds: 1)", 41, &["`folds` is 1", "2 to 1000: "]),
        ("hold_out: SamePhase(period_s: 1e5, folds: 2)", 1, &["held out"]),
        ("drop_above_percent: -3", 21, &["`drop_above_percent` is -3"]),
        ("gravity: (0, 0, NaN)", 17, &["`gravity` is NaN"]),
        ("gravity: (0, 0, 1e7)", 17, &["`gravity` is 1e7 m/s²", "three numbers"]),
        ("gravity: (0, 0)", 0, &["array of length 3"]),
        ("weighting: Hubber", 12, &["did you mean `Huber`?"]),
        ("seed: -1", 8, &["out of range"]),
        ("friction: ()", 1, &["rigid part to freeze"]),
        ("friction: (coefficients: \"table.ron\")", 26, &["no file `table.ron`"]),
        ("poses: File(\"poses.csv\")", 13, &["no file of static poses `poses.csv`", "LACUNA_DATA"]),
        ("poses: ReadOut(coefficients: \"c.ron\", count: 0, noise_percent: 0)", 46, &["`count` is 0"]),
        ("poses: ReadOut(coefficients: \"c.ron\", count: 9, noise_percent: -1)", 64, &["0 to 100 %"]),
    ]);
}

#[test]
fn data_and_simulations() {
    let simulated = |inside: &str| {
        format!(
            "({ROBOT}, logs: Simulated((duration_s: 2,\nmotion: Random(harmonics: 3, period_s: 2, amplitude: 1), {inside})))"
        )
    };
    let folder = Folder::new();
    for (inside, words) in [
        ("sensors: (torque_nose: [1])", ["no field `torque_nose`", "did you mean `torque_noise`?"]),
        ("sensors: (torque_noise: [1, 2, 3])", ["`torque_noise` has 3 numbers for 2 joints", "one for all"]),
        ("sensors: (sampling_time_s: 1e-12)", ["`sampling_time_s` is 1e-12 s", "microsecond"]),
        ("sensors: (sampling_time_s: -1)", ["`sampling_time_s` is -1", "a time in seconds"]),
        ("sensors: (reader: (jitter: 7))", ["`jitter` is 7", "0 to 1"]),
        ("effects: [{\"gremlins\": ()}]", ["`gremlins` is not known", "viscous_friction"]),
        ("effects: [{\"viscous_friction\": (coefficients: [1, NaN])}]", ["`coefficients` is NaN", "finite"]),
        ("controller: (bandwidth_hz: 0)", ["`bandwidth_hz` is 0 Hz", "frequency"]),
    ] {
        folder.write("bad.ron", simulated(inside));
        folder.refused(&["scenario", "bad.ron"], "bad.ron", &words);
    }
    refused(&[
        ("(robot: \"arm.ron\")", 1, &["neither `poses` nor `logs`"]),
        (
            "(robot: \"none.ron\", poses: File(\"x\"))",
            9,
            &["no file `none.ron`", "folder that the scenario is in"],
        ),
        ("(robot: \"arm.ron\", logs: Files(fit: []))", 20, &["no file to fit"]),
        ("(robot: \"arm.ron\", logs: Files(fit: [\"no.csv\"]))", 38, &["no log `no.csv`", "--data LOG.csv"]),
        (
            "(robot: \"arm.ron\", logs: Files(fit: [\"no.csv\"], missing: \"ask Ann\"))",
            38,
            &["no log `no.csv`", "ask Ann"],
        ),
        (
            "(robot: \"arm.ron\", logs: Files(fit: [\"log.csv\"], validate: [\"log.csv\"]))",
            38,
            &["`log.csv` stands under `fit` and under `validate`"],
        ),
        ("(robot: \"arm.ron\", logs: File(fit: []))", 26, &["did you mean `Files`?"]),
        (
            "(robot: \"arm.ron\", logs: Simulated((motion: PandaTableII, duration_s: 1)))",
            37,
            &["`motion` is of 7 joints, the robot has 2"],
        ),
        (
            "(robot: \"arm.ron\", logs: Simulated((motion: Random(harmonics: 0, period_s: 1, amplitude: 1), duration_s: 1)))",
            63,
            &["`harmonics` is 0", "5 harmonics are usual"],
        ),
        (
            "(robot: \"arm.ron\", logs: Simulated((motion: Fourier((period_s: 1, a: [[1]], b: [[1, 2]], q0: [0, 0])), duration_s: 1)))",
            0,
            &["do not fit together", "one per harmonic"],
        ),
        (
            "(robot: \"arm.ron\", logs: Simulated((motion: PandaTableII, duration_s: 1e30)))",
            71,
            &["`duration_s` is 1e30, too large"],
        ),
        (
            "(robot: \"arm.ron\", logs: Simulated((motion: PandaTableII, duration_s: 1e5)))",
            59,
            &["`duration_s` asks for 1.000e8 samples"],
        ),
    ]);
}

#[test]
fn data_for_a_scenario_that_takes_none() {
    let folder = Folder::new();
    folder.refused(
        &["scenario", "good.ron", "--data", "log.csv"],
        "good.ron:1:20: ",
        &["--data", "Files(fit:"],
    );
}

/// What the reader of RON says in words of its own is said in ours.
#[test]
fn numbers_and_texts_that_are_nearly_right() {
    refused(&[
        ("(robot: \"arm.ron\", seed: 1e3)", 0, &["bad.ron:1:", "a whole number is expected"]),
        ("(robot: \"arm.ron\", seed: 0x1g)", 0, &["bad.ron:1:"]),
        ("(robot: \"arm.ron\", engines: [{\"penalty\": (runs: 2e1)}])", 0, &["bad.ron:1:", "whole number"]),
        ("(robot: \"a\\qrm.ron\")", 0, &["bad.ron:1:", "means nothing"]),
        ("(robot: \"a\\u{zz}rm.ron\")", 0, &["bad.ron:1:", "means nothing"]),
    ]);
    refused_after(&[("engines: [{\"penalty\": (runs: 0)}]", 30, &["`runs` is 0"])]);
}
