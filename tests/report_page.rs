//! The page against the numbers it stands beside: what is drawn is what was computed.

use std::path::Path;
use std::process::Command;

use base64::Engine;
use serde_json::Value;

fn lacuna(arguments: &[&str], out: &Path) {
    let run = Command::new(env!("CARGO_BIN_EXE_lacuna"))
        .args(arguments)
        .args(["--quiet", "--out"])
        .arg(out)
        .output()
        .expect("the command runs");
    assert!(run.status.success(), "{}", String::from_utf8_lossy(&run.stderr));
}

fn data(html: &str) -> Value {
    let (_, rest) = html.split_once("id=\"data\">").expect("the page has data");
    serde_json::from_str(rest.split_once("</script>").expect("they end").0).expect("they are JSON")
}

fn floats(value: &Value) -> Vec<f64> {
    let bytes =
        base64::engine::general_purpose::STANDARD.decode(value.as_str().expect("text")).expect("base64");
    bytes.chunks_exact(4).map(|b| f64::from(f32::from_le_bytes([b[0], b[1], b[2], b[3]]))).collect()
}

fn rms(x: &[f64]) -> f64 {
    (x.iter().map(|x| x * x).sum::<f64>() / x.len() as f64).sqrt()
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() <= 1e-4 * b.abs()
}

fn list(value: &Value) -> &[Value] {
    value.as_array().map_or(&[], Vec::as_slice)
}

#[test]
fn a_diagnosis_draws_the_residuals_that_its_numbers_are_of() {
    let folder = tempfile::tempdir().expect("a folder");
    lacuna(&["diagnose", "scenarios/mystery_two.ron"], folder.path());
    let html = std::fs::read_to_string(folder.path().join("report.html")).expect("the page is written");
    assert!(html.len() < 4_000_000, "{} bytes", html.len());
    let page = data(&html);
    let diagnosis: Value =
        serde_json::from_str(&std::fs::read_to_string(folder.path().join("diagnosis.json")).expect("reads"))
            .expect("JSON");
    assert!(page["diagnosis"]["timing"].is_null(), "the clock has no place in a page");
    let fitted = &page["pictures"]["traces"][0];
    for (j, joint) in list(&diagnosis["joints"]).iter().enumerate() {
        for (model, key) in [(0, "held_out_rms"), (1, "held_out_rms_after")] {
            let residual = floats(&fitted["residuals"][model][j]["low"]);
            let expected = joint[key].as_f64().expect("a number");
            assert!(close(rms(&residual), expected), "joint {j}, {key}: {} {expected}", rms(&residual));
            // Model and residual add up to what was measured.
            let (measured, torque) =
                (floats(&fitted["measured"][j]["low"]), floats(&fitted["models"][model][j]["low"]));
            let worst = (0..residual.len()).map(|k| (measured[k] - torque[k] - residual[k]).abs());
            assert!(worst.fold(0.0, f64::max) < 1e-4);
        }
    }
    let never = &page["pictures"]["traces"][1];
    assert_eq!(never["role"], "never fitted");
    for (j, joint) in list(&diagnosis["joints"]).iter().enumerate() {
        let name = joint["name"].as_str().expect("a name");
        for model in 0..2 {
            let expected = diagnosis["validation"]["rms"][name][model].as_f64().expect("a number");
            let residual = floats(&never["residuals"][model][j]["low"]);
            assert!(close(rms(&residual), expected), "{name}: {} {expected}", rms(&residual));
        }
    }
    shows_what_was_found(&page, &diagnosis);
}

fn shows_what_was_found(page: &Value, diagnosis: &Value) {
    let pictures = &page["pictures"];
    let last = list(&pictures["climb"]).last().expect("a ladder");
    for joint in list(&diagnosis["joints"]) {
        let at_the_end = last["rms"][joint["name"].as_str().expect("a name")].as_f64().expect("a number");
        assert!(close(at_the_end, joint["held_out_rms_after"].as_f64().expect("a number")));
    }
    let found: Vec<&Value> = list(&diagnosis["missing"]).iter().map(|m| &m["effect"]).collect();
    let best = &pictures["ranking"][0];
    assert!(found.contains(&&best["effect"]) && best["passes"] == true, "{best}");
    for name in found {
        let share = list(&pictures["effects"]).iter().find(|e| &e["effect"] == name && e["found"] == true);
        let own = &share.expect("every missing effect is drawn")["partials"][0];
        let (mean, curve) = (floats(&own["mean"]), floats(&own["curve"]));
        assert!(mean.len() > 20 && mean.len() == curve.len());
        // The points follow the curve much closer than they follow nothing.
        let off: Vec<f64> = mean.iter().zip(&curve).map(|(m, c)| m - c).collect();
        assert!(rms(&off) < 0.4 * rms(&mean), "{name}: {} of {}", rms(&off), rms(&mean));
    }
}

#[test]
fn a_study_has_a_page_and_the_same_study_has_the_same_one() {
    let folder = tempfile::tempdir().expect("a folder");
    let pages: Vec<String> = ["1", "2"]
        .iter()
        .map(|jobs| {
            let out = folder.path().join(jobs);
            lacuna(&["scenario", "scenarios/two_link.ron", "--jobs", jobs], &out);
            std::fs::read_to_string(out.join("report.html")).expect("the page is written")
        })
        .collect();
    assert!(pages[0] == pages[1], "the page depends on the number of threads or the clock");
    let page = data(&pages[0]);
    assert!(page["report"]["timing"].is_null() && !page["report"]["identifications"].is_null());
}
