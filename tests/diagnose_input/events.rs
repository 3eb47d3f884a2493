//! What happens between two times only.

use serde_json::Value;

use super::{FRICTION, all_named, recorded, text};

fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().expect("a list").iter().map(|x| x.as_f64().expect("a number")).collect()
}

/// The force is far above the noise, so that it turns the joints' weights upside down; it acts beside the origin of the
/// last link. The other log is as long and knows nothing of it.
#[test]
fn a_contact_is_found_with_its_force_and_does_not_happen_in_another_log() {
    let contact =
        r#"{"contact_force": (force: (6.0, -4.0, 3.0), from_s: 7.0, to_s: 8.5, point: (0.0, 0.15, 0.0))}"#;
    let pushed = recorded(&format!("{FRICTION}, {contact}"), 1.0, (0.008, 10.0), "");
    let other = recorded(FRICTION, 1.0, (0.008, 9.0), "");
    let d = pushed.diagnose(&["--auto", "--validate", &other.path("data/fit.csv.gz")]);
    assert_eq!(all_named(&d), ["contact_force"], "{} {}", d["missing"], d["minor"]);
    assert_eq!(text(&d["first"]["cause"]), "contact_force");
    let event = &d["events"][0];
    let time = |name: &str| event[name].as_f64().expect("a time");
    assert!((time("from_s") - 7.0).abs() < 0.15 && (time("to_s") - 8.5).abs() < 0.15, "{event}");
    for (found, hidden) in numbers(&event["force_n"]).iter().zip([6.0, -4.0, 3.0]) {
        assert!((found - hidden).abs() < 0.5, "{event}");
    }
    let v = &d["validation"];
    let error = |name: &str| v[name].as_f64().expect("a number");
    // Without the force in it the fit is a better one; with the force at the same time of day it would be far worse.
    assert!(error("after_relative_error_percent") < error("before_relative_error_percent"), "{v}");
}
