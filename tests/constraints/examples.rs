//! What every constraint gives as an example of itself is one, and the recipe by which one is added is true.

use std::fs;
use std::path::Path;

use lacuna::conformance;
use lacuna::constraints::{About, CATALOGUE, Constraint};
use lacuna::text;

use super::common;

fn abouts() -> Vec<About> {
    CATALOGUE.iter().map(|about| about()).collect()
}

/// A folder with the files that examples name.
fn files() -> tempfile::TempDir {
    let folder = tempfile::tempdir().expect("a folder");
    for (from, to) in [
        ("tests/fixtures/meshes/box.stl", "meshes/link1.stl"),
        ("constraints/total_mass.rhai", "constraints/total_mass.rhai"),
    ] {
        let to = folder.path().join(to);
        fs::create_dir_all(to.parent().expect("a folder of its own")).expect("is made");
        fs::copy(from, to).expect("is copied");
    }
    folder
}

#[test]
fn every_example_is_read_and_keeps_its_promises_on_every_robot() {
    let folder = files();
    for about in abouts() {
        for robot in ["two_link.ron", "panda.ron", "six_axis.urdf"] {
            conformance::constraint(about.example, &common::robot(robot), folder.path(), &[])
                .unwrap_or_else(|e| panic!("{} on {robot}: {e}", about.example));
        }
    }
}

#[test]
fn every_example_comes_back_from_ron_as_it_was() {
    for about in abouts() {
        let read = |ron: &str| -> Box<dyn Constraint> { text::from_ron(ron).expect(ron) };
        let written = text::to_ron(&read(about.example)).expect("it is written");
        assert_eq!(text::to_ron(&read(&written)).expect("it is written"), written);
        assert_eq!(read(about.example).about(), about, "{}", about.example);
    }
}

#[test]
fn an_example_shows_every_setting_that_has_no_default() {
    for about in abouts() {
        let bare = text::from_ron::<Box<dyn Constraint>>(&format!("{{\"{}\": ()}}", about.name));
        let missing = bare.err().map(|e| e.to_string()).unwrap_or_default();
        for (setting, ..) in about.settings {
            let needed = missing.contains(&format!("field `{setting}`"));
            assert!(!needed || about.example.contains(&format!("{setting}: ")), "{}: {setting}", about.name);
        }
    }
}

/// A section of `CONTRIBUTING.md`.
fn recipe(title: &str) -> String {
    let text = fs::read_to_string("CONTRIBUTING.md").expect("it is there");
    let section = text.split("\n## ").find(|s| s.lines().next() == Some(title));
    section.unwrap_or_else(|| panic!("no recipe `{title}`")).to_string()
}

/// Files that a recipe names; `<name>` stands for the new one's.
fn named(recipe: &str) -> Vec<&str> {
    let quoted = recipe.split('`').skip(1).step_by(2);
    quoted.filter(|word| word.contains('/') && !word.contains(['<', ' ', ':'])).collect()
}

#[test]
fn the_files_that_the_recipes_name_are_there() {
    for title in ["Add a constraint", "Add an engine"] {
        let recipe = recipe(title);
        assert!(named(&recipe).len() >= 3, "{recipe}");
        for file in named(&recipe) {
            assert!(Path::new(file).exists(), "{title}: {file}");
        }
    }
}

/// Lines of `text` that are `line` but for blanks.
fn count(text: &str, line: impl Fn(&str) -> bool) -> usize {
    text.lines().filter(|l| line(l.trim())).count()
}

#[test]
fn every_constraint_has_the_pieces_of_its_recipe_and_no_file_lacks_them() {
    let list = fs::read_to_string("crates/lacuna/src/constraints/mod.rs").expect("it is there");
    let cases = fs::read_to_string("tests/constraints/cases.rs").expect("it is there");
    for about in abouts() {
        let name = about.name;
        let file = fs::read_to_string(format!("crates/lacuna/src/constraints/{name}.rs")).expect(name);
        for piece in
            [format!("#[typetag::serde(name = \"{name}\")]"), format!("name: \"{name}\""), "example: ".into()]
        {
            assert_eq!(file.matches(&piece).count(), 1, "{name}: {piece}");
        }
        let implemented = file.split("impl Constraint for ").nth(1).expect(name);
        let kind = implemented.split_whitespace().next().expect("a type");
        assert_eq!(count(&list, |l| l == format!("mod {name};")), 1, "{name}");
        assert_eq!(
            count(&list, |l| l.starts_with(&format!("pub use {name}::")) && l.contains(kind)),
            1,
            "{name}"
        );
        assert_eq!(count(&list, |l| l == format!("|| {kind}::ABOUT,")), 1, "{name}");
        assert!(cases.contains(&format!("{{\"{name}\": (")), "no case of {name}");
    }
    let files = fs::read_dir("crates/lacuna/src/constraints").expect("it is there");
    let texts = files.map(|file| fs::read_to_string(file.expect("a file").path()).expect("reads"));
    let kinds = texts.filter(|text| text.contains("\nimpl Constraint for ")).count();
    assert_eq!(kinds, CATALOGUE.len(), "a constraint is missing in the catalogue");
}

/// The RON that a document shows; parts of a scenario stand without its brackets.
fn shown(document: &str) -> Vec<String> {
    let text = fs::read_to_string(document).expect("it is there");
    let blocks =
        text.split("```ron\n").skip(1).filter_map(|rest| Some(rest.split_once("```")?.0.trim().to_string()));
    let whole =
        |block: String| if block.starts_with('(') { block } else { format!("(robot: \"r\", {block})") };
    blocks.map(whole).collect()
}

#[test]
fn the_readme_shows_scenarios_that_are_read() {
    let all = shown("README.md");
    assert!(all.len() >= 2, "{all:?}");
    for scenario in &all {
        text::from_ron::<lacuna::scenario::Scenario>(scenario).unwrap_or_else(|e| panic!("{scenario}: {e}"));
    }
    assert!(
        all.iter().any(|s| s.contains("constraints:") && s.contains("engines:") && s.contains("choice:"))
    );
}
