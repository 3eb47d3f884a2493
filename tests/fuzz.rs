//! Whatever is thrown at the readers and at a whole study, nothing panics: errors say where, and results
//! are finite. Short by default; `PROPTEST_CASES` sets how many cases are tried.

#[path = "fuzz/changes.rs"]
mod changes;
#[path = "fuzz/structure.rs"]
mod structure;

use std::fmt::Write;
use std::path::Path;

use lacuna::Result;
use lacuna::identify::BaseParameters;
use lacuna::log::ColumnMap;
use lacuna::model_file::ModelFile;
use lacuna::robot::Robot;
use lacuna::scenario::{Published, Scenario};
use lacuna::study::{self, Options, Outcome};
use proptest::prelude::*;
use serde_json::Value;

const SCENARIO: &str = include_str!("../scenarios/panda.ron");
const PUBLISHED: &str = include_str!("../scenarios/panda_table3.ron");
const COLUMNS: &str = include_str!("../columns/ur_rtde.ron");
const MODEL: &str = "(lacuna: \"0.1.0\", robot: \"arm\", origin: \"\", signals: (mode: Parallel, decimate: 3),
    effects: [{\"rigid_body\": ()}, {\"coulomb_friction\": (joints: All, width: 0.1)},
        {\"sigmoid_friction\": (joints: Only([\"2\"]), phi2: [1.5], phi3: [-0.1])}],
    parameters: [(symbol: \"Jzz1\", value: 1e-3, unit: \"kg m^2\", standard_error: 2.0, stands_for: \"a + b\")])";

fn cases(usual: u32) -> ProptestConfig {
    let given = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok());
    ProptestConfig { cases: given.unwrap_or(usual), failure_persistence: None, ..ProptestConfig::default() }
}

/// Every reader of RON; a refusal has line, column and help.
fn read_all(text: &str) -> Result<(), TestCaseError> {
    let readers: [fn(&str) -> Option<lacuna::Error>; 5] = [
        |t| Scenario::parse(t).err(),
        |t| Published::parse(t).err(),
        |t| ModelFile::parse(t).err(),
        |t| ColumnMap::parse(t).err(),
        |t| Robot::from_dh(t).err(),
    ];
    for (number, read) in readers.iter().enumerate() {
        if let Some(error) = read(text) {
            let place = error.place().and_then(|p| p.line.zip(p.column));
            prop_assert!(place.is_some(), "reader {}: {}", number, error);
            prop_assert!(error.to_string().contains("\n  help: "), "reader {}: {}", number, error);
            prop_assert!(error.to_string().len() < 2000, "reader {}: {}", number, error);
        }
    }
    Ok(())
}

/// Flips, removes, doubles or cuts characters, and swaps in odd tokens.
fn mutated(text: &'static str) -> impl Strategy<Value = String> {
    let token = prop::sample::select(vec![
        "NaN",
        "inf",
        "-1",
        "1e308",
        "0",
        "()",
        "[]",
        "{}",
        "All",
        "\"\"",
        "'",
        "\"",
        "/*",
        "//",
        "Some(",
        "r#\"",
        ",",
        ":",
        "99999999999999999999",
        "\u{feff}",
        "\u{0}",
        "é",
    ]);
    let change = (0..4_u8, any::<prop::sample::Index>(), 0..30_usize, token);
    prop::collection::vec(change, 1..5).prop_map(move |changes| {
        let mut text: Vec<char> = text.chars().collect();
        for (kind, place, length, token) in changes {
            let from = place.index(text.len() + 1);
            let to = (from + length).min(text.len());
            match kind {
                0 => drop(text.splice(from..to, token.chars())),
                1 => drop(text.splice(from..from, token.chars())),
                2 => drop(text.drain(from..to)),
                _ => {
                    let copy = text[from..to].to_vec();
                    drop(text.splice(from..from, copy));
                }
            }
        }
        text.into_iter().collect()
    })
}

proptest! {
    #![proptest_config(cases(150))]

    #[test]
    fn any_text_is_read_or_refused(text in "\\PC{0,80}", ron in "[()\\[\\]{}:,\"a-z0-9 .\\-]{0,60}") {
        read_all(&text)?;
        read_all(&ron)?;
    }

    #[test]
    fn mutated_files_are_read_or_refused(
        scenario in mutated(SCENARIO), published in mutated(PUBLISHED), columns in mutated(COLUMNS), model in mutated(MODEL),
    ) {
        for text in [scenario, published, columns, model] {
            read_all(&text)?;
        }
    }
}

/// A number as people and programs write them when something went wrong.
fn odd_number() -> impl Strategy<Value = String> {
    prop_oneof![
        4 => (0.01_f64..20.0).prop_map(|x| format!("{x:.3}")),
        1 => prop::sample::select(vec!["0", "-1", "1e-300", "1e300", "NaN", "inf", "1e-6", "400", "1e6"]).prop_map(str::to_owned),
    ]
}

fn odd_count() -> impl Strategy<Value = usize> {
    prop_oneof![6 => 1..9_usize, 1 => Just(0), 1 => Just(1_000_000_007)]
}

fn signals() -> impl Strategy<Value = String> {
    let choice = |all: &[&'static str]| prop::sample::select(all.to_vec());
    (
        choice(&["Inputs", "Parallel"]),
        odd_number(),
        odd_number(),
        odd_number(),
        odd_number(),
        odd_count(),
        odd_count(),
        choice(&["Auto", "Stamps", "Rebuilt"]),
        choice(&["Auto", "Position", "Velocity"]),
    )
        .prop_map(|(mode, band, position, trim, gap, order, decimate, clock, velocity)| {
            format!(
                "(mode: {mode}, band_hz: {band}, position_cutoff_hz: {position}, trim_s: {trim}, max_gap_s: {gap}, \
                 order: {order}, decimate: {decimate}, clock: {clock}, velocity_from: {velocity})"
            )
        })
}

fn effects() -> impl Strategy<Value = String> {
    let joints = || {
        prop_oneof![
            3 => Just("All".to_owned()),
            2 => prop::collection::vec(prop::sample::select(vec!["1", "2", "joint1", "elbow", "0", ""]), 1..3)
                .prop_map(|names| format!("Only({names:?})")),
        ]
    };
    let one = prop_oneof![
        Just("{\"rigid_body\": ()}".to_owned()),
        joints().prop_map(|j| format!("{{\"viscous_friction\": (joints: {j})}}")),
        (joints(), odd_number())
            .prop_map(|(j, w)| format!("{{\"coulomb_friction\": (joints: {j}, width: {w})}}")),
        joints().prop_map(|j| format!("{{\"torque_offset\": (joints: {j})}}")),
        (joints(), odd_number(), odd_number()).prop_map(|(j, a, b)| format!(
            "{{\"sigmoid_friction\": (joints: {j}, phi2: [{a}, {a}], phi3: [{b}, {b}])}}"
        )),
    ];
    prop::collection::vec(one, 0..4).prop_map(|all| format!("[{}]", all.join(", ")))
}

/// What happens at every row, by name of the kind of log.
const KINDS: [&str; 9] =
    ["rich", "still", "no torque", "constant torque", "one joint", "no velocity", "huge", "jumps", "noise"];

/// A log of a robot of `n` joints.
fn log(kind: &str, n: usize, rows: usize, dt: f64) -> String {
    let mut text = "t".to_owned();
    for name in ["q", "dq", "tau"] {
        (1..=n).for_each(|j| write!(text, ",{name}{j}").expect("text grows"));
    }
    for k in 0..rows {
        let t = dt * k as f64 * if kind == "jumps" && k % 50 == 49 { 3.0 } else { 1.0 };
        write!(text, "\n{t:e}").expect("text grows");
        let noise = f64::from((k as u32).wrapping_mul(2_654_435_761) >> 8) / f64::from(1 << 24) - 0.5;
        let wave = |j: usize, shift: f64| libm::sin(0.021 * (j + 1) as f64 * k as f64 + shift);
        for (quantity, shift) in [0.0, 1.57, 0.7].into_iter().enumerate() {
            for j in 0..n {
                let x = match (kind, quantity) {
                    ("still", 0) | ("constant torque", 2) => 0.3,
                    ("still" | "no torque", _) if quantity > 0 => 0.0,
                    ("no velocity", 1) => 0.0,
                    ("one joint", _) if j > 0 => 0.0,
                    ("huge", 2) => 1e11 * wave(j, shift),
                    ("noise", _) => noise * (j + quantity + 1) as f64,
                    _ => wave(j, shift),
                };
                write!(text, ",{x}").expect("text grows");
            }
        }
    }
    text + "\n"
}

/// Denavit-Hartenberg tables of robots, small and odd.
fn robot(joints: usize, prismatic: u8, twist: f64, gravity: f64) -> String {
    let row = |j: usize| {
        let (kind, limits) = match (usize::from(prismatic) >> (j % 8)) & 1 {
            1 => ("Prismatic", "limits: (lower: -1, upper: 1)"),
            _ => ("Revolute", "limits: (lower: -2, upper: 2)"),
        };
        let alpha = twist * ((j % 3) as f64 - 1.0);
        format!("(a: 0.{}, alpha: {alpha:?}, d: 0.1, theta: 0, kind: {kind}, {limits})", j % 4)
    };
    let rows: Vec<String> = (0..joints).map(row).collect();
    format!(
        "(name: \"arm\", convention: Modified, gravity: (0, 0, {gravity:?}), rows: [{}])",
        rows.join(", ")
    )
}

fn run(folder: &Path, scenario: &str) -> Result<Outcome> {
    let path = folder.join("study.ron");
    std::fs::write(&path, scenario).expect("temporary files can be written");
    study::run(&path, Options::new(&mut |_| {}))
}

/// No number of a result may be infinite; JSON would have to write null where a number is promised.
fn check_finite(outcome: Result<Outcome>) -> Result<bool, TestCaseError> {
    let outcome = match outcome {
        Ok(outcome) => outcome,
        Err(error) => {
            println!("{error}");
            prop_assert!(error.place().is_some() && error.to_string().contains("help: "), "{}", error);
            return Ok(false);
        }
    };
    let report = serde_json::to_value(&outcome.report).expect("reports become JSON");
    for run in report["identifications"].as_array().into_iter().flatten() {
        for joint in run["joints"].as_array().into_iter().flatten() {
            prop_assert!(joint["rms"].is_number() && joint["torque_rms"].is_number(), "{}", joint);
        }
        for coefficient in run["coefficients"].as_array().into_iter().flatten() {
            prop_assert!(coefficient["value"].is_number(), "{}", coefficient);
        }
        prop_assert!(run["condition_number"] != Value::Null, "{}", run["label"]);
    }
    for joint in report["friction"].as_array().into_iter().flatten() {
        for parameter in joint["parameters"].as_array().into_iter().flatten() {
            prop_assert!(parameter["value"].is_number(), "{}", joint);
        }
    }
    let model = outcome.model.expect("a study that ran has a model");
    prop_assert!(model.parameters.iter().all(|p| p.value.is_finite()));
    let text = lacuna::text::to_ron(&model).expect("models become RON");
    prop_assert!(ModelFile::parse(&text).is_ok_and(|back| back.parameters == model.parameters));
    Ok(true)
}

proptest! {
    #![proptest_config(cases(120))]

    #[test]
    fn studies_of_odd_logs_and_settings(
        kind in prop::sample::select(KINDS.to_vec()),
        rows in prop_oneof![1 => 0..5_usize, 4 => 50..400_usize],
        dt in prop_oneof![6 => Just(0.01), 1 => Just(1e-9), 1 => Just(1e9)],
        joints in 1..4_usize, prismatic: u8,
        signals in prop_oneof![2 => Just("()".to_owned()), 3 => signals()],
        effects in effects(),
        weighting in prop::sample::select(vec!["Ordinary", "Joint", "Huber"]),
    ) {
        let folder = tempfile::tempdir().expect("a temporary folder");
        for name in ["log.csv", "again.csv"] {
            std::fs::write(folder.path().join(name), log(kind, joints, rows, dt)).expect("writes");
        }
        std::fs::write(folder.path().join("arm.ron"), robot(joints, prismatic, 1.57, -9.81)).expect("writes");
        let scenario = format!(
            "(robot: \"arm.ron\", logs: Files(fit: [\"log.csv\"], validate: [\"again.csv\"]), signals: {signals}, \
             effects: {effects}, weighting: {weighting}, drop_above_percent: 30)"
        );
        check_finite(run(folder.path(), &scenario))?;
    }
}

/// The odd logs above with settings that are right: most must run, so that the test means something.
#[test]
fn odd_logs_with_good_settings() -> Result<()> {
    let mut ran = Vec::new();
    for kind in KINDS {
        for weighting in ["Ordinary", "Joint", "Huber"] {
            for mode in ["Inputs", "Parallel"] {
                let folder = tempfile::tempdir().expect("a temporary folder");
                std::fs::write(folder.path().join("log.csv"), log(kind, 2, 1500, 0.01)).expect("writes");
                std::fs::write(folder.path().join("arm.ron"), robot(2, 0, 1.57, -9.81)).expect("writes");
                let scenario = format!(
                    "(robot: \"arm.ron\", logs: Files(fit: [\"log.csv\"]), weighting: {weighting}, signals: (mode: {mode}))"
                );
                let outcome = check_finite(run(folder.path(), &scenario));
                if outcome.unwrap_or_else(|e| panic!("{kind}, {weighting}, {mode}: {e}")) {
                    ran.push(kind);
                }
            }
        }
    }
    println!("ran: {ran:?}");
    for kind in ["rich", "no torque", "constant torque", "one joint", "noise"] {
        assert_eq!(ran.iter().filter(|k| **k == kind).count(), 6, "{kind} ran not always: {ran:?}");
    }
    Ok(())
}

#[test]
fn robots_small_and_large() {
    for (joints, prismatic, twist, gravity) in [
        (1, 0, 0.0, -9.81),
        (1, 255, 0.0, -9.81),
        (1, 255, 0.0, 0.0),
        (3, 255, 0.0, -9.81),
        (3, 255, 1.57, 0.0),
        (30, 0, 1.57, -9.81),
        (30, 0b0100_1001, 1.57, 3.0),
    ] {
        let text = robot(joints, prismatic, twist, gravity);
        let base = BaseParameters::new(&Robot::from_dh(&text).expect("reads"));
        assert!(base.rank() >= 1 && base.rank() <= 10 * joints, "{joints} joints have rank {}", base.rank());
        let folder = tempfile::tempdir().expect("a temporary folder");
        std::fs::write(folder.path().join("arm.ron"), &text).expect("writes");
        let motion = "Random(harmonics: 3, period_s: 2, amplitude: 0.3)";
        let simulated = format!("(robot: \"arm.ron\", logs: Simulated((motion: {motion}, duration_s: 2)))");
        std::fs::write(folder.path().join("log.csv"), log("rich", joints, 1000, 0.01)).expect("writes");
        let read = "(robot: \"arm.ron\", logs: Files(fit: [\"log.csv\"]))";
        for scenario in [simulated.as_str(), read] {
            check_finite(run(folder.path(), scenario)).unwrap_or_else(|e| panic!("{joints} joints: {e}"));
        }
    }
    let still = "<robot name='r'><link name='a'/><link name='b'/><joint name='j' type='fixed'>\
                 <parent link='a'/><child link='b'/></joint></robot>";
    let error = Robot::from_urdf(still).expect_err("nothing moves");
    assert!(error.to_string().contains("no movable joint"), "{error}");
}
