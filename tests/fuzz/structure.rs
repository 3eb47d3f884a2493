//! Every reader against texts that were changed in their structure: huge counts, deep brackets, wrong kinds of values in
//! every field, control characters, tokens of four thousand characters. Nothing may panic, abort or hang, and whatever
//! is refused is refused with its file, in words of a length that can be read.
//!
//! How long it looks: `PROPTEST_CASES` sets the number of cases of each kind of file, `LACUNA_FUZZ_SECONDS` a time for
//! all of them instead; `LACUNA_SLOW=1` is short for 1200 s.

use std::path::{Path, PathBuf};
use std::time::{Duration, Instant};

use lacuna::check::{self, Options};
use proptest::prelude::*;

use super::changes::{Change, attack, changed};

/// Cases of each kind of file where nothing else is asked for.
const USUAL: u32 = 250;
/// No file of a few hundred words may take longer to judge.
const PATIENCE: Duration = Duration::from_secs(30);

/// A kind of file: its name, a good one, and with what it is checked.
struct Target {
    file: &'static str,
    text: String,
    robot: Option<PathBuf>,
    data: Option<PathBuf>,
}

fn shipped(file: &str) -> String {
    std::fs::read_to_string(file).unwrap_or_else(|e| panic!("{file}: {e}"))
}

fn root(file: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(file)
}

const SCENARIO: &str = "(robot: \"ROBOT\", gravity: (0, 0, -9.81), seed: 1,
    poses: ReadOut(coefficients: \"TABLE\", count: 10, noise_percent: 0.1),
    logs: Simulated((motion: Random(harmonics: 3, period_s: 2, amplitude: 0.5), duration_s: 2,
        effects: [{\"viscous_friction\": (coefficients: [0.5])}], sensors: (position_noise: [1e-5], reader: ()))),
    signals: (mode: Parallel, band_hz: 8, decimate: 2, trim_s: 0.5, order: 4),
    effects: [{\"rigid_body\": ()}, {\"coulomb_friction\": (joints: All, width: 0.1)},
        {\"sigmoid_friction\": (joints: Only([\"2\"]), phi2: [1.5], phi3: [-0.1])}, {\"time_delay\": ()}],
    candidates: [{\"payload\": ()}], weighting: Huber, drop_above_percent: 30,
    hold_out: SamePhase(period_s: 2, folds: 3), friction: (),
    constraints: [{\"positive_mass\": ()}, {\"mass_range\": (links: Only([\"1\"]), min: 0.1, max: 9)},
        {\"total_mass\": (min: 2, max: 2.5)}, {\"com_box\": (links: All, lower: (-1, -1, -1), upper: (1, 1, 1))}],
    objective: Coefficients, engines: [{\"penalty\": (runs: 2, stages: 2)}, {\"lmi\": ()}, {\"nlopt\": (runs: 4)}],
    intervals: (), choice: Nearest(prior: \"ROBOT\"), diagnosis: false, beside: [])";

const EXPERIMENT: &str = "(robot: \"ROBOT\", seed: 3,
    effects: [{\"viscous_friction\": (coefficients: [0.4, 0.3])}, {\"coulomb_friction\": (levels: [0.2], width: 0.01)},
        {\"torque_ripple\": (amplitudes: [0, 0.3], harmonics: [11], phases: [0.7])}, {\"joint_spring\": (stiffness: [1.5, 0], rest: [0.2, 0])}],
    sensors: (sampling_time_s: 0.01, position_noise: [1e-4], position_step: [2e-5], torque_noise: [0.1], torque_wander: [0.01]),
    logs: [(name: \"fit\", duration_s: 2, seed: 1, motion: Fourier((period_s: 2, a: [[0.5, 0.3]], b: [[0.4, -0.7]], q0: [-0.4, 0.3]))),
        (name: \"check\", duration_s: 2, motion: Random(harmonics: 5, period_s: 2, amplitude: 0.6))],
    decimals: (time: 4, position: 6, velocity: 5, torque: 4))";

const CONSTRAINTS: &str = "[{\"positive_mass\": ()}, {\"pseudo_inertia\": (links: All)}, {\"triangle_inequality\": ()},
    {\"mass_range\": (links: Only([\"1\"]), min: 0.1, max: 9)}, {\"total_mass\": (min: 2, max: 2.5)},
    {\"com_box\": (links: All, lower: (-1, -1, -1), upper: (1, 1, 1))}, {\"com_sphere\": (links: All, centre: (0, 0, 0), radius: 1)},
    {\"mass_ratio\": (links: (\"1\", \"2\"), min: 0.1, max: 10)}, {\"com_hull\": (links: All, points: [(0,0,0),(1,0,0),(0,1,0),(0,0,1)])}]";

const POSES: &str = "q1,q2,g1,g2,m11,m21,m22\n0.1,0.2,0.3,0.4,0.5,0.6,0.7\n1.1,1.2,0.3,0.4,0.5,0.6,0.9\n";

/// The head of a log of two joints, with a few rows.
fn log(rows: usize) -> String {
    super::log("rich", 2, rows, 0.01)
}

fn targets(folder: &Path) -> Vec<Target> {
    let robot = root("robots/two_link.ron");
    let placed = |text: &str| {
        let table = root("scenarios/two_link_coefficients.ron");
        text.replace("ROBOT", &robot.display().to_string()).replace("TABLE", &table.display().to_string())
    };
    let data = folder.join("good.csv");
    std::fs::write(&data, log(2000)).expect("temporary files can be written");
    let target = |file, text: String, robot: Option<&PathBuf>, data: Option<&PathBuf>| Target {
        file,
        text,
        robot: robot.cloned(),
        data: data.cloned(),
    };
    let own = Some(&robot);
    vec![
        target("scenario.ron", placed(SCENARIO), None, None),
        target("experiment.ron", placed(EXPERIMENT), None, None),
        target("map.ron", shipped("columns/ur_rtde.ron"), None, None),
        target("list.ron", CONSTRAINTS.to_string(), own, None),
        target("model.ron", super::MODEL.to_string(), own, None),
        target("arm.ron", shipped("robots/two_link.ron"), None, None),
        target("arm.urdf", shipped("tests/fixtures/robots/good.urdf"), None, None),
        target("arm_five.urdf", shipped("tests/fixtures/robots/five.urdf"), None, Some(&data)),
        target("table.ron", shipped("scenarios/two_link_coefficients.ron"), own, None),
        target("friction.ron", shipped("scenarios/panda_table1.ron"), own, None),
        target("rule.rhai", shipped("constraints/l_shape.rhai"), own, None),
        target("sum.rhai", shipped("constraints/total_mass.rhai"), own, None),
        target("effect.rhai", shipped("effects/quadratic_friction.rhai"), own, Some(&data)),
        target("stop.rhai", shipped("effects/end_stop.rhai"), own, None),
        target("log.csv", log(40), own, None),
        target(
            "named.csv",
            shipped("tests/fixtures/logs/named.csv").lines().take(30).collect::<Vec<_>>().join("\n"),
            None,
            None,
        ),
        target("poses.csv", POSES.to_string(), own, None),
    ]
}

/// Whether a file is judged as it should be.
fn judged(folder: &Path, target: &Target, text: &str) -> Result<(), TestCaseError> {
    let path = folder.join(target.file);
    std::fs::write(&path, text).expect("temporary files can be written");
    let options = Options { robot: target.robot.clone(), data: target.data.clone(), ..Options::default() };
    let start = Instant::now();
    let report = check::file(&path, &options);
    prop_assert!(start.elapsed() < PATIENCE, "{} took {:?}", target.file, start.elapsed());
    for problem in &report.problems {
        prop_assert!(problem.text.len() < 2500, "{}: {}", target.file, problem.text);
        prop_assert!(problem.file.as_ref().is_some_and(|f| !f.is_empty()), "no file: {}", problem.text);
        prop_assert!(
            problem.text.contains("\n  help: ") || problem.line.is_some(),
            "no remedy: {}",
            problem.text
        );
        prop_assert!(!problem.text.contains("base 10"), "not in plain words: {}", problem.text);
    }
    prop_assert!(!report.text().is_empty());
    prop_assert!(serde_json::to_string(&report).is_ok());
    Ok(())
}

#[test]
fn files_of_every_kind_changed_in_their_structure() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let all = targets(folder.path());
    let only = std::env::var("LACUNA_FUZZ_ONLY").unwrap_or_default();
    for target in all.iter().filter(|t| t.file.contains(&only)) {
        let whole = judged(folder.path(), target, &target.text);
        whole.unwrap_or_else(|e| panic!("{} as it is: {e}", target.file));
        // The time to judge a robot grows with the third power of its joints, and copied rows are joints.
        let most_copies = if target.file.starts_with("arm") { 3 } else { 400 };
        let test =
            |changes: &[Change]| judged(folder.path(), target, &changed(&target.text, most_copies, changes));
        let done = attack(target.file, USUAL, all.len() as u32 + 1, test);
        assert!(done > 0, "nothing was tried");
    }
}
