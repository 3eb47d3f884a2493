//! A workbench that goes on with a study whose steps were tampered with.

use proptest::prop_assert;

use super::{Options, Workbench};

#[path = "../../tests/fuzz/changes.rs"]
mod changes;

use changes::{attack, changed};

#[test]
fn steps_of_the_workbench_changed_in_their_structure() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let study = folder.path().join("study");
    let options = Options {
        robot: Some("robots/two_link.ron".into()),
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
