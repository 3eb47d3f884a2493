//! What a diagnosis makes of input that is poor, strange or foreign, on small simulated logs of a made-up arm of
//! five joints.

#[path = "diagnose_input/events.rs"]
mod events;
#[path = "diagnose_input/scripts.rs"]
mod scripts;

use std::path::Path;
use std::process::Command;

use serde_json::Value;

/// Runs the command line: exit code, the JSON it printed, and what it complained about.
fn run(arguments: &[&str]) -> (i32, Value, String) {
    let output = Command::new(env!("CARGO_BIN_EXE_lacuna"))
        .args(arguments)
        .args(["--json", "--quiet"])
        .output()
        .expect("the command runs");
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    (
        output.status.code().unwrap_or(-1),
        serde_json::from_slice(&output.stdout).unwrap_or(Value::Null),
        stderr,
    )
}

fn names(list: &Value) -> Vec<String> {
    list.as_array().map_or_else(Vec::new, |l| l.iter().map(|m| text(&m["effect"])).collect())
}

/// Everything that is said to be missing, important or not.
fn all_named(d: &Value) -> Vec<String> {
    [names(&d["missing"]), names(&d["minor"])].concat()
}

fn text(value: &Value) -> String {
    value.as_str().unwrap_or_default().to_string()
}

/// A folder with the arm in it.
struct Folder(tempfile::TempDir);

impl Folder {
    fn new() -> Self {
        let folder = Self(tempfile::tempdir().expect("a folder"));
        folder
            .write("five.urdf", &std::fs::read_to_string("tests/fixtures/robots/five.urdf").expect("ships"));
        folder
    }

    fn path(&self, file: &str) -> String {
        self.0.path().join(file).display().to_string()
    }

    fn write(&self, file: &str, text: &str) {
        std::fs::write(self.0.path().join(file), text).expect("writes");
    }

    /// The arm's own simulated log, with more flags.
    fn diagnose(&self, flags: &[&str]) -> Value {
        self.diagnose_log("data/fit.csv.gz", flags)
    }

    fn diagnose_log(&self, log: &str, flags: &[&str]) -> Value {
        let (robot, log) = (self.path("five.urdf"), self.path(log));
        let (code, d, stderr) = run(&[&["diagnose", "--robot", &robot, "--data", &log], flags].concat());
        assert!(code == 0 || d["verdict"] == "undecided", "{stderr}");
        d
    }
}

/// Friction as the classical model has it.
const FRICTION: &str = r#"{"viscous_friction": (coefficients: [0.5, 0.6, 0.4, 0.2, 0.1])},
    {"coulomb_friction": (levels: [1.0, 1.2, 0.8, 0.5, 0.3], width: 0.01)},
    {"torque_offset": (offsets: [0.1, -0.1, 0.1, 0.1, -0.1])}"#;

/// Two rounds of a random motion of the arm at 125 Hz with these effects in it; `noise` 1 is realistic.
fn simulated(effects: &str, noise: f64) -> Folder {
    recorded(effects, noise, (0.008, 10.0), "")
}

/// The same with another sampling time and period [s], and more of the sensors.
fn recorded(effects: &str, noise: f64, (dt, period): (f64, f64), sensors: &str) -> Folder {
    let folder = Folder::new();
    let torque = [0.14, 0.12, 0.08, 0.04, 0.02].map(|x| x * noise);
    let (position, velocity) = (1e-4 * noise, 1e-3 * noise);
    let plant = format!(
        r#"(
    robot: "five.urdf",
    effects: [{effects}],
    sensors: (sampling_time_s: {dt}, position_noise: [{position:e}], position_step: [2.4e-5],
        velocity_noise: [{velocity:e}], torque_noise: {torque:?}{sensors}),
    logs: [
        (
            name: "fit", duration_s: {}, seed: 31,
            motion: Random(harmonics: 5, period_s: {period:?}, amplitude: 0.7),
        ),
    ],
)"#,
        2.0 * period
    );
    folder.write("plant.ron", &plant);
    let (code, _, stderr) = run(&["simulate", &folder.path("plant.ron"), "--out", &folder.path("data")]);
    assert_eq!(code, 0, "{stderr}");
    folder
}

/// Header and rows of a gzipped log.
fn rows(path: &Path) -> (Vec<String>, Vec<Vec<f64>>) {
    use std::io::Read;
    let mut text = String::new();
    let file = std::fs::File::open(path).expect("opens");
    flate2::read::GzDecoder::new(file).read_to_string(&mut text).expect("unpacks");
    let mut lines = text.lines();
    let header = lines.next().expect("a header").split(',').map(str::to_string).collect();
    (header, lines.map(|l| l.split(',').map(|x| x.parse().expect("a number")).collect()).collect())
}

fn csv(header: &[String], rows: &[Vec<f64>]) -> String {
    let line = |row: &Vec<f64>| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n";
    format!("{}\n{}", header.join(","), rows.iter().map(line).collect::<String>())
}

/// The lesson of a well-known toolbox: one joint lacks Coulomb friction in the model, damping and rotor inertia
/// are free, and it answers with more damping and tiny error bars.
#[test]
fn the_friction_that_a_model_lacks_is_named_and_not_hidden_in_its_damping() {
    let friction = r#"{"viscous_friction": (coefficients: [0.5, 0.6, 0.4, 0.2, 0.1])},
        {"coulomb_friction": (levels: [0.0, 0.0, 0.8, 0.0, 0.0])}"#;
    let folder = simulated(friction, 1.0);
    folder.write(
        "study.ron",
        r#"(robot: "five.urdf", logs: Files(fit: ["data/fit.csv.gz"]),
            effects: [{"rigid_body": ()}, {"viscous_friction": ()}, {"rotor_inertia": ()}])"#,
    );
    let (code, d, stderr) = run(&["diagnose", &folder.path("study.ron")]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(
        (text(&d["first"]["joint"]), text(&d["first"]["cause"])),
        ("joint3".into(), "coulomb_friction".into())
    );
    assert_eq!(names(&d["missing"]), ["coulomb_friction"], "{}", d["missing"]);
    let level = &d["missing"][0]["parameters"][0];
    assert_eq!(level["name"], "fc3");
    assert!((level["value"].as_f64().expect("a number") - 0.8).abs() < 0.05, "{level}");
    // The damping had swallowed part of it, and says so.
    let damping = d["moved"].as_array().expect("a list").iter().find(|m| m["parameter"] == "fv3");
    let damping = damping.expect("the damping of joint 3 moved");
    let value = |name: &str| damping[name].as_f64().expect("a number");
    assert!(value("before") > 1.3 * value("after") && (value("after") - 0.4).abs() < 0.1, "{damping}");
}

#[test]
fn the_numbers_of_the_robot_file_are_compared_as_they_are() {
    let folder = simulated(FRICTION, 1.0);
    // The file's own numbers are right: what is missing is friction.
    let d = folder.diagnose(&["--model", "given"]);
    assert_eq!(d["baseline"]["effects"], serde_json::json!(["rigid_body"]));
    assert_eq!(d["baseline"]["fitted"], false);
    assert!(names(&d["missing"]).contains(&"coulomb_friction".to_string()), "{}", d["missing"]);
    assert_eq!(d["ladder"][0]["effect"], "rigid_body");
    // Now the file is wrong about the forearm, and hardly anything else is missing.
    let folder = simulated(r#"{"viscous_friction": (coefficients: [0.02])}"#, 1.0);
    let right = folder.diagnose(&["--model", "given"]);
    let wrong = std::fs::read_to_string(folder.path("five.urdf")).expect("is there");
    folder.write("wrong.urdf", &wrong.replace(r#"<mass value="2.0"/>"#, r#"<mass value="3.5"/>"#));
    let (robot, data) = (folder.path("wrong.urdf"), folder.path("data/fit.csv.gz"));
    let (code, worse, stderr) = run(&["diagnose", "--robot", &robot, "--data", &data, "--model", "given"]);
    assert_eq!(code, 0, "{stderr}");
    let error = |d: &Value| d["baseline"]["held_out_relative_error_percent"].as_f64().expect("a number");
    assert!(error(&worse) > 2.0 * error(&right), "{} {}", error(&worse), error(&right));
    assert_eq!(worse["first"]["cause"], "rigid_body", "{}", worse["first"]);
    assert_eq!(worse["ladder"][0]["effect"], "rigid_body");
    let fitted = worse["ladder"][0]["held_out_relative_error_percent"].as_f64().expect("a number");
    assert!(fitted < error(&worse), "{fitted}");
    let parameters = worse["missing"][0]["parameters"].as_array().expect("a list");
    assert!(names(&worse["missing"])[0] == "rigid_body" && !parameters.is_empty(), "{}", worse["missing"]);
}

/// The arm with joint 3 locked by a brake: its position, and the torque of its idle drive, stay what they are.
#[test]
fn a_joint_that_never_moves_is_left_out_and_the_others_are_diagnosed() {
    let folder = Folder::new();
    let urdf = std::fs::read_to_string(folder.path("five.urdf")).expect("is there");
    let locked =
        urdf.replace(r#"<joint name="joint3" type="revolute">"#, r#"<joint name="joint3" type="fixed">"#);
    folder.write("locked.urdf", &locked);
    folder.write(
        "plant.ron",
        r#"(
    robot: "locked.urdf",
    effects: [{"viscous_friction": (coefficients: [0.5, 0.6, 0.2, 0.1])},
        {"coulomb_friction": (levels: [1.0, 1.2, 0.5, 0.3], width: 0.01)},
        {"torque_ripple": (amplitudes: [0.0, 1.5, 0.0, 0.0], harmonics: [9.0])}],
    sensors: (sampling_time_s: 0.008, position_noise: [1e-4], velocity_noise: [1e-3],
        torque_noise: [0.14, 0.12, 0.04, 0.02]),
    logs: [(name: "fit", duration_s: 20.0, seed: 31, motion: Random(harmonics: 5, period_s: 10.0, amplitude: 0.7))],
)"#,
    );
    let (code, _, stderr) = run(&["simulate", &folder.path("plant.ron"), "--out", &folder.path("data")]);
    assert_eq!(code, 0, "{stderr}");
    let (_, moving) = rows(&folder.0.path().join("data/fit.csv.gz"));
    let number = |kind: &str| (1..=5).map(|j| format!("{kind}{j}")).collect::<Vec<_>>();
    let header =
        [vec!["t".to_string()], number("q"), number("dq"), number("tau"), vec!["temperature1".into()]]
            .concat();
    let with_third = |of: &[f64], value: f64| [&of[..2], &[value], &of[2..]].concat();
    let all: Vec<Vec<f64>> = moving
        .iter()
        .map(|r| {
            let (q, dq, tau) =
                (with_third(&r[1..5], 0.0), with_third(&r[5..9], 0.0), with_third(&r[9..13], 0.25));
            [vec![r[0]], q, dq, tau, vec![25.0]].concat()
        })
        .collect();
    folder.write("locked.csv", &csv(&header, &all));
    let d = folder.diagnose_log("locked.csv", &[]);
    assert_eq!(
        (text(&d["first"]["joint"]), text(&d["first"]["cause"])),
        ("joint2".into(), "torque_ripple".into())
    );
    let said = d["undecided"].to_string();
    assert!(
        said.contains("joint3 never moves") && said.contains("the torque of joint3 is one constant"),
        "{said}"
    );
    for list in ["missing", "minor", "refused", "unexplained", "inseparable", "regions"] {
        assert!(!d[list].to_string().contains("joint3"), "{list}: {}", d[list]);
    }
    assert_eq!(all_named(&d), ["torque_ripple"], "{} {}", d["missing"], d["minor"]);
}

/// A low-pass that runs forwards only, on the torque only (Butterworth, order 2).
fn causal(rows: &mut [Vec<f64>], columns: std::ops::Range<usize>, cutoff_hz: f64) {
    let dt = rows[1][0] - rows[0][0];
    let w = (std::f64::consts::PI * cutoff_hz * dt).tan();
    let scale = 1.0 / (1.0 + 2.0_f64.sqrt() * w + w * w);
    let (b, a1) = (w * w * scale, 2.0 * (w * w - 1.0) * scale);
    let a2 = (1.0 - 2.0_f64.sqrt() * w + w * w) * scale;
    for column in columns {
        let first = rows[0][column];
        let (mut x, mut y) = ([first; 2], [first; 2]);
        for row in rows.iter_mut() {
            let now = row[column];
            let out = b * (now + 2.0 * x[0] + x[1]) - a1 * y[0] - a2 * y[1];
            (x, y) = ([now, x[0]], [out, y[0]]);
            row[column] = out;
        }
    }
}

#[test]
fn torque_that_went_through_a_causal_filter_is_late_and_hardly_anything_else() {
    let folder = simulated(FRICTION, 1.0);
    let (header, mut all) = rows(&folder.0.path().join("data/fit.csv.gz"));
    let torque = header.iter().position(|h| h == "tau1").expect("a column");
    causal(&mut all, torque..torque + 5, 10.0);
    folder.write("late.csv", &csv(&header, &all));
    let d = folder.diagnose_log("late.csv", &["--auto"]);
    assert_eq!(d["first"]["cause"], "time_delay");
    let all: Vec<Value> =
        [&d["missing"], &d["minor"]].iter().flat_map(|l| l.as_array().expect("a list").clone()).collect();
    assert_eq!(all[0]["effect"], "time_delay");
    // A filter is no pure delay: what it does to fast torque may leave one small finding.
    let gain = |m: &Value| m["gain_percent"].as_f64().expect("a number");
    assert!(all.len() <= 2 && all[1..].iter().all(|m| gain(m) < 0.2 * gain(&all[0])), "{all:?}");
    assert!(d["unexplained"].as_array().is_some_and(Vec::is_empty), "{}", d["unexplained"]);
    // What the filter holds slow motion back: the square root of 2 over its angular frequency; faster motion less.
    let delay = d["missing"][0]["parameters"][0]["value"].as_f64().expect("a number");
    assert!((delay - 2.0_f64.sqrt() / (20.0 * std::f64::consts::PI)).abs() < 3e-3, "{delay}");
    assert!(text(&d["missing"][0]["where"]).contains("causal filter"), "{}", d["missing"][0]["where"]);
}

/// Friction whose passage through rest has another width than the model's sign.
fn of_width(width: f64, noise: f64) -> Value {
    let friction = r#"{"viscous_friction": (coefficients: [0.5, 0.6, 0.4, 0.2, 0.1])},
        {"coulomb_friction": (levels: [1.0, 1.2, 0.8, 0.5, 0.3], width: WIDTH)},
        {"torque_offset": (offsets: [0.1, -0.1, 0.1, 0.1, -0.1])}"#;
    let wander = [0.045, 0.06, 0.035, 0.012, 0.007].map(|x: f64| x * noise);
    let sensors = format!(", torque_wander: {wander:?}");
    let folder = recorded(&friction.replace("WIDTH", &format!("{width:?}")), noise, (0.004, 13.3), &sensors);
    folder.diagnose(&[])
}

/// Softer than the model's sign: that is no physics.
#[test]
fn the_softness_of_a_sign_is_not_sold_as_physics() {
    for width in [0.03, 0.06] {
        let d = of_width(width, 1.0);
        assert_eq!(d["verdict"], "nothing", "width {width}: {} {}", d["missing"], d["minor"]);
    }
}

/// Sharper than the model's sign, and softer with hardly any noise.
#[test]
fn the_sharpness_of_a_sign_is_not_sold_as_physics() {
    for (width, noise) in [(0.001, 1.0), (0.001, 0.1), (0.03, 0.1), (0.06, 0.1)] {
        let d = of_width(width, noise);
        assert_eq!(
            d["verdict"], "nothing",
            "width {width}, noise {noise}: {} {} {}",
            d["missing"], d["minor"], d["unexplained"]
        );
    }
}

#[test]
fn logs_of_different_robots_are_refused() {
    let folder = Folder::new();
    let log = |joints: &[&str]| {
        let columns =
            ["q_", "dq_", "tau_"].map(|kind| joints.iter().map(|j| format!("{kind}{j}")).collect::<Vec<_>>());
        let header = format!("t,{}", columns.concat().join(","));
        let rows: Vec<String> =
            (0..50).map(|k| format!("{}{}", 0.01 * f64::from(k), ",0.5".repeat(3 * joints.len()))).collect();
        format!("{header}\n{}\n", rows.join("\n"))
    };
    folder.write("own.csv", &log(&["joint1", "joint2", "joint3", "joint4", "joint5"]));
    folder.write("fewer.csv", &log(&["joint1", "joint2", "joint3", "joint4"]));
    folder.write("named.csv", &log(&["shoulder", "joint2", "joint3", "joint4", "joint5"]));
    folder.write("more.csv", &log(&["1", "2", "3", "4", "5", "6"]).replace('_', ""));
    let (robot, own) = (folder.path("five.urdf"), folder.path("own.csv"));
    for (other, words) in [
        ("fewer.csv", ["`q5`", "fewer.csv"]),
        ("named.csv", ["shoulder", "named.csv"]),
        ("more.csv", ["6 joints", "more.csv"]),
    ] {
        let other = folder.path(other);
        let (code, _, stderr) = run(&["diagnose", "--robot", &robot, "--data", &own, "--reference", &other]);
        assert_eq!(code, 2, "{stderr}");
        assert!(words.iter().all(|w| stderr.contains(w)) && stderr.contains("help:"), "{stderr}");
    }
}
