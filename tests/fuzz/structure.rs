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
use proptest::sample::Index;
use proptest::test_runner::{TestError, TestRunner};

/// Cases of each kind of file where nothing else is asked for.
const USUAL: u32 = 250;
/// Cases between two looks at the clock.
const PORTION: u32 = 50;
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

/// A change of structure: what is done, where, how often, and with what.
type Change = (u8, Index, Index, usize, usize);

fn changes() -> impl Strategy<Value = Vec<Change>> {
    let change = (0..9_u8, any::<Index>(), any::<Index>(), 0..TOKENS.len(), 0..8_usize);
    prop::collection::vec(change, 1..5)
}

/// What stands in the place of a value.
const TOKENS: [&str; 40] = [
    "4294967295",
    "4294967296",
    "18446744073709551615",
    "18446744073709551616",
    "-1",
    "0",
    "1e308",
    "-1e308",
    "1e-320",
    "NaN",
    "inf",
    "-inf",
    "1_000",
    "0x10",
    "1e3",
    "()",
    "[]",
    "{}",
    "[[]]",
    "(())",
    "\"\"",
    "\"text\"",
    "All",
    "None",
    "Some(1)",
    "true",
    "'c'",
    "\"\\u{1b}[31m\"",
    "\"\\q\"",
    "\"\u{1b}[2J\u{202e}\"",
    "\u{0}",
    "\u{feff}",
    "/*",
    "//",
    "r#\"",
    ",",
    "Only([])",
    "LONG",
    "\"LONG\"",
    "\"../../../etc/passwd\"",
];

/// Words, texts in quotes, and single characters.
fn lexed(text: &str) -> Vec<String> {
    let mut tokens: Vec<String> = Vec::new();
    let mut rest = text;
    let is_word = |c: char| c.is_alphanumeric() || "_.+-".contains(c);
    while let Some(first) = rest.chars().next() {
        let length = if first == '"' {
            rest[1..].find('"').map_or(rest.len(), |end| end + 2)
        } else if is_word(first) {
            rest.find(|c| !is_word(c)).unwrap_or(rest.len())
        } else {
            first.len_utf8()
        };
        tokens.push(rest[..length].to_string());
        rest = &rest[length..];
    }
    tokens
}

/// Places of what holds a value: words and texts.
fn values(tokens: &[String]) -> Vec<usize> {
    let holds =
        |t: &String| t.starts_with('"') || t.starts_with(|c: char| c.is_alphanumeric() || "_.+-".contains(c));
    (0..tokens.len()).filter(|&i| holds(&tokens[i])).collect()
}

/// The end of the bracket that opens at `start`.
fn closing(tokens: &[String], start: usize) -> usize {
    let mut depth = 0_i32;
    for (i, token) in tokens.iter().enumerate().skip(start) {
        match token.as_str() {
            "(" | "[" | "{" | "<" => depth += 1,
            ")" | "]" | "}" | ">" => depth -= 1,
            _ => {}
        }
        if depth <= 0 {
            return i;
        }
    }
    tokens.len() - 1
}

fn changed(text: &str, most_copies: usize, changes: &[Change]) -> String {
    let mut tokens = lexed(text);
    for (kind, place, other, token, size) in changes {
        let all = values(&tokens);
        if all.is_empty() {
            break;
        }
        let (i, j) = (all[place.index(all.len())], all[other.index(all.len())]);
        let token = TOKENS[*token].replace("LONG", &"x1".repeat(2048));
        let brackets: Vec<usize> =
            (0..tokens.len()).filter(|&i| ["(", "[", "{", "<"].contains(&tokens[i].as_str())).collect();
        let group = (!brackets.is_empty()).then(|| brackets[place.index(brackets.len())]);
        match (kind, group) {
            (0..=3, _) => tokens[i] = token,
            (4, _) => tokens.swap(i, j),
            (5, Some(start)) => drop(tokens.drain(start..=closing(&tokens, start))),
            (6, Some(start)) => {
                let copy = tokens[start..=closing(&tokens, start)].join("");
                tokens.insert(
                    start,
                    format!("{copy},").repeat([1, 2, 3, 10, 50, 100, 200, 400][*size].min(most_copies)),
                );
            }
            (7, _) => {
                let opened = ["(", "[", "{\"a\":", "Some(", "-", "!", "fn(x){", "<a>"][*size];
                tokens.insert(i, opened.repeat([1, 3, 20, 130, 300, 2000, 10_000, 60_000][other.index(8)]));
            }
            _ => tokens.insert(i, token),
        }
    }
    tokens.concat()
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

fn number(name: &str) -> Option<u64> {
    std::env::var(name).ok().and_then(|n| n.parse().ok())
}

/// Time to look for, where one is given.
fn budget() -> Option<Duration> {
    let slow = std::env::var("LACUNA_SLOW").is_ok_and(|v| v == "1").then_some(1200);
    number("LACUNA_FUZZ_SECONDS").or(slow).map(Duration::from_secs)
}

/// Tries changed texts until the cases, or the time, are used up; answers how many it were.
fn attack(name: &str, usual: u32, share: u32, test: impl Fn(&[Change]) -> Result<(), TestCaseError>) -> u32 {
    let wanted = number("PROPTEST_CASES").map_or(usual, |n| n as u32);
    let until = budget().map(|all| Instant::now() + all / share);
    let mut done = 0;
    while until.map_or(done < wanted, |end| Instant::now() < end) {
        let cases = if until.is_some() { PORTION } else { PORTION.min(wanted - done) };
        let config = ProptestConfig { cases, failure_persistence: None, ..ProptestConfig::default() };
        match TestRunner::new(config).run(&changes(), |changes| test(&changes)) {
            Ok(()) => done += cases,
            Err(TestError::Fail(why, changes)) => panic!("{name}: {why}\n{changes:?}"),
            Err(TestError::Abort(why)) => panic!("{name}: {why}"),
        }
    }
    println!("{name}: {done} cases");
    done
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

/// A workbench that goes on with a study whose steps were tampered with.
#[test]
fn steps_of_the_workbench_changed_in_their_structure() {
    use lacuna::workbench::{Options, Workbench};
    let folder = tempfile::tempdir().expect("a temporary folder");
    let study = folder.path().join("study");
    let options = Options {
        robot: Some(root("robots/two_link.ron")),
        folder: Some(study.clone()),
        ..Options::default()
    };
    drop(Workbench::open(&options).expect("a study can be made"));
    let Ok(steps) = std::fs::read_to_string(study.join("steps.json")) else { panic!("no steps are written") };
    let steps = steps.replace("\"steps\": []", concat!(
        "\"steps\": [{\"id\": 0, \"parent\": null, \"root\": \"Classic\", \"added\": null, \"effects\": [{\"rigid_body\": {}}], ",
        "\"numbers\": {\"held_out_percent\": 1.0}}]"
    ));
    let resumed = Options { folder: Some(study.clone()), resume: true, ..Options::default() };
    // Every study that opens keeps its threads.
    attack("steps.json", 24, 40, |changes| {
        std::fs::write(study.join("steps.json"), changed(&steps, 400, changes)).expect("written");
        if let Err(error) = Workbench::open(&resumed) {
            let text = error.to_string();
            prop_assert!(error.place().is_some() && text.len() < 2500, "{}", text);
        }
        Ok(())
    });
}
