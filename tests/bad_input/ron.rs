//! What is said of RON that is not what it should be.

use lacuna::effects::Effect;
use lacuna::scenario::Scenario;
use lacuna::text::from_ron;

#[track_caller]
fn scenario(text: &str, place: (usize, usize), words: &[&str]) {
    let error = from_ron::<Scenario>(text).expect_err(text).to_string();
    check(&error, words);
    let found = from_ron::<Scenario>(text).expect_err(text);
    let found = found.place().and_then(|p| Some((p.line?, p.column?)));
    assert_eq!(found, Some(place), "{error}");
}

#[track_caller]
fn effect(text: &str, words: &[&str]) {
    check(&from_ron::<Vec<Box<dyn Effect>>>(text).expect_err(text).to_string(), words);
}

#[track_caller]
fn check(message: &str, words: &[&str]) {
    for word in words.iter().chain(&["help: "]) {
        assert!(message.contains(word), "`{word}` is not in: {message}");
    }
}

#[test]
fn what_is_known_is_listed_inside_and_outside_of_effects() {
    scenario("(\n  sead: 3)", (2, 3), &["no field `sead`", "did you mean `seed`", "robot, gravity"]);
    scenario("(robot: \"r\", signals: (mode: inputs))", (1, 30), &["`inputs`", "known names: Inputs, Pa"]);
    scenario("(seed: 1)", (1, 9), &["field `robot` of `Scenario` is missing"]);
    scenario("(robot: \"r\", robot: \"s\")", (1, 14), &["`robot` stands twice"]);
    effect("[{\"rigid_bdy\": ()}]", &["did you mean `rigid_body`", "known names: ", "coulomb_friction, "]);
    effect("[{\"rigid_body\": (mass: 1)}]", &["no field `mass`", "there are none"]);
    effect("[{\"torque_offset\": (joint: All)}]", &["no field `joint`", "did you mean `joints`"]);
    effect("[{\"sigmoid_friction\": (phi2: [])}]", &["field `phi3` of `SigmoidFriction` is missing"]);
    effect("[{\"sigmoid_friction\": (phi2: [\"\"])}]", &["a number is expected"]);
    effect("[{\"sigmoid_friction\": (phi2: 1)}]", &["a list is expected"]);
    effect("[torque_offset]", &["{\"viscous_friction\": (joints: All)}"]);
    effect("[{\"rigid_body\": (), \"torque_offset\": ()}]", &["its own braces"]);
}

#[test]
fn brackets_and_literals() {
    for (text, at, words) in [
        ("(robot: 3)", 9, "text in double quotes"),
        ("(robot: \"r\" seed: 1)", 13, "comma is missing"),
        ("(robot = \"r\")", 8, "colon is expected"),
        ("(robot: \"r\", seed: \"1\")", 20, "whole number is expected"),
        ("(robot: \"r\", seed: -1)", 21, "out of range"),
        ("(robot: \"r\", seed: 1", 21, "ends in the middle"),
        ("(robot: \"r\") x", 14, "follows after the end"),
        ("{\"robot\": \"r\"}", 1, "opening `(`"),
        ("robot: \"r\"", 1, "opening `(`"),
        ("(\"robot\": \"r\")", 2, "the name without quotes"),
    ] {
        scenario(text, (1, at), &[words]);
    }
}
