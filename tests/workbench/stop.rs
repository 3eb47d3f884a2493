//! Stopping what runs.

use super::client::{Bench, json};
use super::data::Files;

/// An effect that takes minutes on the rows of a log.
const SLOW: &str = r#"fn about() {
    #{ title: "slow", text: "takes long", equation: "k sin(..)",
       parameters: [#{ symbol: "k", unit: "N m", meaning: "size" }] }
}
fn columns(joint, now, memory, with) {
    let s = 0.0;
    for i in 0..30000 { s += sin(now.q * i); }
    [s]
}"#;

#[test]
fn a_script_at_the_samples_of_a_log_is_stopped_and_nothing_is_lost() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    let before = bench.wait("a full search", |s| s["steps"][0]["scanned"] == true && s["job"].is_null());
    let draft = serde_json::json!({"kind": "effect", "text": SLOW}).to_string();
    let saved = bench.post("/api/script/save", &draft);
    assert_eq!(saved.status, 200, "{}", saved.text());
    let file = saved.json()["file"].as_str().expect("a name").to_string();
    let addition = serde_json::json!({"effect": file, "joints": []}).to_string();
    assert_eq!(bench.post("/api/add", &addition).status, 200);
    let busy = bench.wait("the script at work", |s| s["job"]["kind"] == "add");
    assert_eq!(busy["job"]["stoppable"], true);
    // Long enough to be among the samples, far from what the script may take.
    std::thread::sleep(std::time::Duration::from_millis(700));
    assert_eq!(bench.post("/api/stop", "{}").status, 200);
    let after = bench.wait("the end of the work", |s| s["job"].is_null());
    let trouble = after["trouble"].to_string();
    assert!(trouble.contains("stopped before it was done"), "{trouble}");
    assert_eq!(after["steps"].as_array().map(Vec::len), Some(1));
    assert_eq!(after["steps"][0]["held_out_percent"], before["steps"][0]["held_out_percent"]);

    // What is asked for next is done as ever.
    assert_eq!(bench.post("/api/add", r#"{"effect": "joint_spring", "joints": ["joint1"]}"#).status, 200);
    let added = bench.wait("another step", |s| s["steps"].as_array().is_some_and(|a| a.len() == 2));
    assert_eq!(added["path"], json("[0, 1]"));
    // The search beside it has the script among its candidates, and can be stopped as well.
    bench.wait("the search", |s| s["job"]["kind"] == "scan");
    assert_eq!(bench.post("/api/stop", "{}").status, 200);
    bench.wait("its end", |s| s["job"].is_null());
}

#[test]
fn a_script_that_takes_too_long_is_refused_and_says_so() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    bench.wait("a full search", |s| s["steps"][0]["scanned"] == true && s["job"].is_null());
    let slower = SLOW.replace("sin(now.q * i)", "sin(now.q * i) * cos(now.dq * i)").replace("30000", "20000");
    let draft = serde_json::json!({"kind": "effect", "text": slower}).to_string();
    let file = bench.post("/api/script/save", &draft).json()["file"].as_str().expect("a name").to_string();
    let addition = serde_json::json!({"effect": file, "joints": []}).to_string();
    assert_eq!(bench.post("/api/add", &addition).status, 200);
    let refused = bench.wait("a refusal", |s| !s["trouble"].is_null());
    let trouble = refused["trouble"].to_string();
    assert!(trouble.contains("more than 10 s") && trouble.contains(&file), "{trouble}");
}
