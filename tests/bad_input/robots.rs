use super::folder::{ARM, Folder};

const URDF: &str = include_str!("../fixtures/robots/good.urdf");

/// Gives a robot file to every command that reads one.
#[track_caller]
fn refused(name: &str, content: impl AsRef<[u8]>, place: &str, words: &[&str]) {
    let folder = Folder::new();
    folder.write(name, content);
    folder.write("bad_robot.ron", format!("(robot: \"{name}\", logs: Files(fit: [\"log.csv\"]))"));
    let place = format!("{name}:{place}: ");
    folder.refused(&["scenario", "bad_robot.ron"], &place, words);
    folder.refused(&["dynamics", "--robot", name, "--states", "states.csv"], &place, words);
    folder.refused(&["compare", "model.ron", "--robot", name, "--data", "log.csv"], &place, words);
    let checked = folder.run(&["check", name]);
    let said = format!("{}{}", checked.out, checked.err);
    assert!(checked.code == Some(2) && said.contains(place.trim()), "check: {said}");
}

#[track_caller]
fn urdf(from: &str, to: &str, place: &str, words: &[&str]) {
    assert!(URDF.contains(from), "the fixture has no {from}");
    refused("bad.urdf", URDF.replacen(from, to, 1), place, words);
}

#[track_caller]
fn table(from: &str, to: &str, place: &str, words: &[&str]) {
    assert!(ARM.contains(from), "the table has no {from}");
    refused("bad_arm.ron", ARM.replacen(from, to, 1), place, words);
}

#[test]
fn urdf_files() {
    refused("bad.urdf", "", "1:1", &["no element", "<robot>"]);
    refused("bad.urdf", "t,q1\n0,1\n", "1:1", &["not well-formed XML"]);
    refused("bad.urdf", b"<robot name='\xFF'/>", "1:14", &["not UTF-8"]);
    urdf("parent link=\"arm\"", "parent link=\"tool\"", "22:3", &["form a loop", "tree"]);
    urdf("<parent link=\"base\"/>", "", "12:3", &["`hinge`", "no <parent>"]);
    urdf("\"0 0 1\"", "\"0 0 0\"", "16:11", &["no direction"]);
    urdf("<robot", "<!DOCTYPE robot [<!ENTITY a \"b\">]>\n<robot", "2:1", &["DTD"]);
    urdf("value=\"1.5\"", "value=\"1.5kg\"", "7:13", &["1.5kg", "finite number"]);
    urdf("type=\"revolute\"", "type=\"floating\"", "12:23", &["floating"]);
    urdf("<axis", "<mimic joint=\"slide\"/><axis", "16:5", &["mimics"]);
    urdf("meshes/arm.stl", "../arm.stl", "10:29", &["leaves the folder"]);
}

#[test]
fn denavit_hartenberg_tables() {
    refused("bad_arm.ron", "", "1:1", &["the file is empty", "convention"]);
    table("    convention: Standard,\n", "", "10:1", &["`convention` is missing", "Modified"]);
    table("Standard", "Craig", "3:17", &["`Modified` or `Standard`"]);
    table("    gravity: (0.0, -9.81, 0.0),\n", "", "10:1", &["`gravity` is missing"]);
    table("a: 0.5", "a: NaN", "6:13", &["NaN", "finite"]);
    table("a: 0.5", "A: 0.5", "6:10", &["`A`", "`alpha`"]);
    let deep = ARM.replacen("[\n", &"[".repeat(100_000), 1);
    refused("bad_arm.ron", deep, "5:74", &["nested too deeply"]);
}

#[test]
fn robots_without_inertia_have_no_dynamics() {
    let folder = Folder::new();
    let bare = "(convention: Standard, gravity: (0, 0, -9.81), rows: [(a: 1, alpha: 0, d: 0, theta: 0)])";
    folder.write("bare.ron", bare);
    let arguments = ["dynamics", "--robot", "bare.ron", "--states", "states.csv"];
    folder.refused(&arguments, "bare.ron", &["no link of the robot has an inertia"]);
}
