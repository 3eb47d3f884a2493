//! The page is one file, asks for nothing, and what it shows stays text.

use std::collections::BTreeMap;

use super::*;
use crate::report::pictures::{Compared, JointUnits, Role, Trace};
use crate::signals::Rows;

const HOSTILE: &str = "</script><img src=x onerror=alert(1)>&{{script}}\u{2028}\"'`${1}";

fn pictures(joint: &str, rows: usize) -> Pictures {
    let wave = |by: f64| -> Vec<f64> { (0..rows).map(|k| libm::sin(by * k as f64)).collect() };
    let trace = Trace {
        name: format!("log {joint}"),
        role: Role::Fitted,
        rows: Rows { start: 1.0, dt: 0.025, count: rows },
        q: vec![wave(0.01)],
        dq: vec![wave(0.02)],
        ddq: vec![wave(0.03)],
        channels: BTreeMap::from([(joint.to_string(), wave(0.1))]),
        measured: vec![wave(0.05)],
        models: vec![vec![wave(0.049)]],
    };
    Pictures {
        joints: vec![JointUnits { name: joint.to_string(), position: "rad", torque: "N m" }],
        models: vec![Compared { label: "model".into(), held_out: true }],
        traces: vec![trace],
        ..Pictures::default()
    }
}

fn page(title: &str, pictures: &Pictures) -> String {
    let page = Page { title, diagnosis: None, report: None, pictures: Some(pictures) };
    page.html().expect("the page is written")
}

fn json(html: &str) -> serde_json::Value {
    let (_, rest) = html.split_once("id=\"data\">").expect("the data are there");
    let (data, _) = rest.split_once("</script>").expect("the data end");
    serde_json::from_str(data).expect("the data are JSON")
}

#[test]
fn names_from_logs_never_become_markup() {
    let html = page(HOSTILE, &pictures(HOSTILE, 10));
    assert!(!html.contains("<img"), "a name became an element");
    assert!(html.contains("&lt;/script&gt;&lt;img"), "the title is escaped");
    assert_eq!(html.matches("</script>").count(), 2, "the data ended their element early");
    assert_eq!(json(&html)["pictures"]["joints"][0][0], HOSTILE);
    assert_eq!(html.matches("const data = JSON.parse").count(), 1, "a name was taken for a place to fill");
}

#[test]
fn the_page_asks_for_nothing() {
    let html = page("log", &pictures("joint1", 10));
    for outside in
        ["http://", "https://", " src=", "@import", "url(", "fetch(", "XMLHttpRequest", "WebSocket"]
    {
        let places: Vec<&str> =
            html.split(outside).skip(1).map(|after| after.get(..30).unwrap_or(after)).collect();
        // The namespace of SVG is a name and not an address.
        assert!(places.iter().all(|after| after.starts_with("www.w3.org/2000/svg")), "{outside}: {places:?}");
    }
    assert!(!html.contains(" onclick=") && !html.contains(" onload="), "handlers stand in the script");
    assert!(
        !SCRIPTS.iter().any(|(_, s)| s.contains("innerHTML") || s.contains("eval(")),
        "text is never parsed"
    );
}

#[test]
fn modules_join_into_one_script() {
    let script: String = SCRIPTS.iter().map(|(name, text)| joined(name, text)).collect();
    assert!(!script.lines().any(|l| l.starts_with("import ") || l.starts_with("export ")));
    let mut names: Vec<&str> = script
        .lines()
        .filter_map(|l| {
            ["function ", "class ", "const ", "let "].iter().find_map(|word| l.strip_prefix(word))
        })
        .filter_map(|l| l.split([' ', '(', '=']).next())
        .collect();
    names.sort_unstable();
    let count = names.len();
    names.dedup();
    // Names of one file must not meet those of another.
    assert_eq!(count, names.len(), "a name is declared in two files");
}

#[test]
fn long_logs_stay_small_and_keep_their_spikes() {
    let mut pictures = pictures("joint1", 1_000_000);
    pictures.traces[0].measured[0][654_321] = 1e3;
    let html = page("long", &pictures);
    assert!(html.len() < 4_000_000, "{} bytes", html.len());
    let series = &json(&html)["pictures"]["traces"][0]["measured"][0];
    let every = series["every"].as_u64().expect("a number");
    assert!((10..=500).contains(&every), "{every}");
    let high = base64::Engine::decode(
        &base64::engine::general_purpose::STANDARD,
        series["high"].as_str().expect("an envelope"),
    )
    .expect("base64");
    let most = high.chunks_exact(4).map(|b| f32::from_le_bytes([b[0], b[1], b[2], b[3]])).fold(0.0, f32::max);
    assert!((most - 1e3).abs() < 1e-3);
}

#[test]
fn every_term_that_the_script_uses_is_explained() {
    let glossary: BTreeMap<String, String> = serde_json::from_str(GLOSSARY).expect("the glossary is JSON");
    for (name, text) in SCRIPTS {
        for after in text.split("term(\"").skip(1) {
            let term = after.split('"').next().unwrap_or_default();
            assert!(glossary.contains_key(term), "{name}: `{term}` is not in the glossary");
        }
    }
}
