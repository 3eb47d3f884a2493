//! Effect scripts in a diagnosis: competing, added, proposed, refused.

use serde_json::Value;

use super::{Folder, names, simulated, text};

/// A damping of joint 4 that comes and goes with joint 2: no effect of the catalogue, but a script may say it.
const HIDDEN: &str =
    r#"{"product": (joint: 4, amplitude: 0.6, factors: [Velocity(4), Wave(of: 2, k: 3, phase: 0.6)])}"#;

const CABLE: &str = r#"
fn about() {
    #{
        title: "a cable that is squeezed by joint 2",
        text: "Damping that depends on where another joint stands.",
        equation: "tau_j = dq_j (cs_j sin(3 q2) + cc_j cos(3 q2))",
        parameters: [
            #{ symbol: "cs", unit: "N m s/rad", meaning: "amplitude of the sine" },
            #{ symbol: "cc", unit: "N m s/rad", meaning: "amplitude of the cosine" },
        ],
    }
}

fn columns(joint, now, memory, with) {
    let x = 3.0 * now.joint(2).q;
    [now.dq * sin(x), now.dq * cos(x)]
}
"#;

fn hidden() -> Folder {
    let folder = simulated(&format!("{}, {HIDDEN}", super::FRICTION), 1.0);
    folder.write("cable.rhai", CABLE);
    folder
}

fn after(d: &Value, joint: usize) -> [f64; 2] {
    let of = |name: &str| d["joints"][joint - 1][name].as_f64().expect("a number");
    [of("held_out_rms"), of("held_out_rms_after")]
}

#[test]
fn a_script_competes_with_the_catalogue_and_is_added() {
    let folder = hidden();
    let script = folder.path("cable.rhai");
    // By the flag.
    let d = folder.diagnose(&["--try", &script]);
    assert_eq!(names(&d["missing"])[0], "cable.rhai", "{}", d["missing"]);
    let cable = &d["missing"][0];
    assert_eq!(cable["joints"], serde_json::json!(["joint4"]));
    assert_eq!(cable["equation"], "tau_j = dq_j (cs_j sin(3 q2) + cc_j cos(3 q2))");
    let value = |k: usize| cable["parameters"][k]["value"].as_f64().expect("a number");
    let (truth, found) = ([0.6 * 0.6_f64.cos(), 0.6 * 0.6_f64.sin()], [value(0), value(1)]);
    assert!(truth.iter().zip(found).all(|(t, f)| (t - f).abs() < 0.05), "{found:?} for {truth:?}");
    assert_eq!(d["first"]["cause"], "cable.rhai");
    let plain = after(&d, 4)[0];
    // Among the candidates of a scenario, and added; the model that is written opens again without the file.
    folder.write(
        "study.ron",
        r#"(robot: "five.urdf", logs: Files(fit: ["data/fit.csv.gz"]), candidates: [{"script": (path: "cable.rhai")}])"#,
    );
    let (study, out) = (folder.path("study.ron"), folder.path("out"));
    let d = super::run(&["diagnose", &study, "--add", "cable.rhai:joint4", "--out", &out]).1;
    assert_eq!(
        (text(&d["ladder"][0]["effect"]), &d["ladder"][0]["joints"][0]),
        ("cable.rhai".into(), &"joint4".into())
    );
    let [before, left] = after(&d, 4);
    assert!(left < 0.5 * before, "{before} {left}");
    std::fs::remove_file(&script).expect("is there");
    let d = folder.diagnose(&["--model", &folder.path("out/model.ron")]);
    let effects = d["baseline"]["effects"].to_string();
    assert!(effects.contains("cable.rhai"), "{effects}");
    assert!(after(&d, 4)[0] < 0.5 * plain, "{plain} {}", d["joints"]);
    let model = std::fs::read_to_string(folder.path("out/model.ron")).expect("is there");
    assert!(!model.contains(&folder.path("")), "{model}");
}

#[test]
fn what_is_unexplained_becomes_a_script_that_takes_the_error_away() {
    let folder = tempfile::tempdir().expect("a folder");
    let out = folder.path().join("out").display().to_string();
    let mystery = "scenarios/mystery_unknown.ron";
    let (code, d, stderr) = super::run(&["diagnose", mystery, "--out", &out]);
    assert_eq!(code, 0, "{stderr}");
    let unknown = &d["unexplained"][0];
    assert_eq!(
        (text(&unknown["joint"]), text(&unknown["script"])),
        ("joint4".into(), "unknown_joint4.rhai".into())
    );
    let written = std::fs::read_to_string(folder.path().join("out/diagnosis.json")).expect("is there");
    assert!(!written.contains(&out), "a path of this machine stands in the results");
    let script = format!("{out}/unknown_joint4.rhai");
    let (code, said, stderr) = super::run(&["check", &script, "--robot", "robots/panda.ron"]);
    assert_eq!((code, text(&said["kind"])), (0, "effect_script".into()), "{stderr}");
    let (code, d, stderr) = super::run(&["diagnose", mystery, "--add", &script]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(
        (text(&d["ladder"][0]["effect"]), d["ladder"][0]["joints"].to_string()),
        ("unknown_joint4.rhai".into(), "[\"joint4\"]".into())
    );
    let rms = d["ladder"][0]["rms"]["joint4"].as_f64().expect("a number");
    assert!(rms < 0.5 * after(&d, 4)[0], "{rms} of {}", after(&d, 4)[0]);
    let left = d["unexplained"].as_array().expect("a list").iter().find(|u| u["joint"] == "joint4");
    assert!(left.is_none(), "{left:?}");

    // A proposal that was worked on is its user's: the next one gets another name.
    let mine = std::fs::read_to_string(&script).expect("reads") + "// mine\n";
    std::fs::write(&script, &mine).expect("writes");
    let (code, d, stderr) = super::run(&["diagnose", mystery, "--out", &out]);
    assert_eq!(code, 0, "{stderr}");
    assert_eq!(text(&d["unexplained"][0]["script"]), "unknown_joint4_2.rhai");
    assert_eq!(std::fs::read_to_string(&script).expect("reads"), mine);
}

#[test]
fn a_script_of_the_wrong_length_is_refused_with_its_place() {
    let folder = Folder::new();
    let wrong = CABLE.replace("[now.dq * sin(x), now.dq * cos(x)]", "[now.dq * sin(x)]");
    folder.write("wrong.rhai", &wrong);
    folder.write("fit.csv", "t,q1,q2,q3,q4,q5,tau1,tau2,tau3,tau4,tau5\n0,0,0,0,0,0,0,0,0,0,0\n");
    let (robot, data, script) = (folder.path("five.urdf"), folder.path("fit.csv"), folder.path("wrong.rhai"));
    for flag in ["--add", "--try"] {
        let (code, _, stderr) = super::run(&["diagnose", "--robot", &robot, "--data", &data, flag, &script]);
        assert_eq!(code, 2, "{stderr}");
        for part in ["wrong.rhai:14:4", "1 numbers for 2 parameters", "cs, cc"] {
            assert!(stderr.contains(part), "`{part}` is missing: {stderr}");
        }
    }
    let (code, _, stderr) =
        super::run(&["diagnose", "--robot", &robot, "--data", &data, "--try", "stribeck_friction"]);
    assert!(code == 2 && stderr.contains(".rhai"), "{stderr}");
}
