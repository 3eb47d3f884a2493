//! What scripts of rules may use up: memory, as the system counts it.

use lacuna::constraints::{Constraint, LinkSpace, Scripted};
use lacuna::robot::Robot;
use lacuna::script::{Script, Settings};

/// A sum over all parameters of all links, and then again and again another one.
const WIDE: &str = "fn constrain(robot, links, with) {
    let all = 0.0;
    for l in links {
        let p = l.pseudo_inertia;
        for i in 0..4 { for j in 0..4 { all += entry(p, i, j) * (1.0 + 0.1 * i + 0.01 * j); } }
    }
    let three = vector(all, 2.0 * all, 3.0 * all);
    for i in 0..30000 { three = three * 1.0001; }
    [three.x >= 0.0]
}";

/// Many rules that no cone expresses, each a program as long as the one before.
const PROGRAMS: &str = "fn constrain(robot, links, with) {
    let s = 0.0;
    let ratio = links[0].mass / links[1].mass;
    for i in 0..20000 { s += sin(i * ratio); }
    let all = [];
    for i in 0..900 { all.push(margin(\"rule\", s + i)); }
    all
}";

#[test]
fn long_sums_and_programs_are_refused_by_what_they_take() {
    let robot = Robot::open("robots/panda.ron").expect("the robot reads");
    let space = LinkSpace::new(&robot, &[]);
    for text in [WIDE, PROGRAMS] {
        let script = Scripted::from_script(Script::new("large.rhai", text), Settings::new());
        let error = script.forms(&robot, &space).expect_err("takes far more than 256 MB");
        let told = error.to_string();
        assert!(told.contains("more than 256 MB") && told.contains("help: build fewer"), "{told}");
        assert!(told.contains("large.rhai") && error.place().is_some_and(|p| p.line.is_some()), "{told}");
    }
}

/// The most memory that checking a script took [MB].
#[cfg(target_os = "linux")]
fn peak(script: &str) -> (f64, String) {
    use std::process::{Command, Stdio};
    let folder = tempfile::tempdir().expect("a folder");
    let file = folder.path().join("large.rhai");
    std::fs::write(&file, script).expect("writes");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    command.arg("check").arg(&file).args(["--robot", "robots/panda.ron"]);
    let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("starts");
    let status = format!("/proc/{}/status", child.id());
    let mut most = 0.0_f64;
    while child.try_wait().expect("can be asked").is_none() {
        let text = std::fs::read_to_string(&status).unwrap_or_default();
        let line = text.lines().find_map(|l| l.strip_prefix("VmHWM:"));
        let kb: Option<f64> = line.and_then(|l| l.trim().trim_end_matches("kB").trim().parse().ok());
        most = most.max(kb.unwrap_or(0.0) / 1024.0);
        std::thread::sleep(std::time::Duration::from_millis(1));
    }
    let output = child.wait_with_output().expect("ended");
    (most, String::from_utf8_lossy(&output.stdout).into_owned())
}

#[cfg(target_os = "linux")]
#[test]
fn the_system_agrees_with_what_is_counted() {
    for script in [WIDE, PROGRAMS] {
        let (most, told) = peak(script);
        assert!(told.contains("more than 256 MB"), "{told}");
        assert!(most > 20.0 && most < 320.0, "{most} MB");
    }
}
