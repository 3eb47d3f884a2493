//! The list of constraints that a retrieval must satisfy, as text that people edit.

use std::path::Path;

use serde_json::{Value, json};

use crate::constraints::{About, CATALOGUE, Constraint, LinkSpace, forms};
use crate::error::Result;
use crate::robot::Robot;
use crate::text;

/// What a list starts with.
pub(super) const USUAL: &str = "\
// What the link parameters must satisfy; `lacuna list constraints` explains every kind.
[
    {\"triangle_inequality\": ()},
    {\"mass_range\": (min: 0.05, max: 50.0)},
]
";

/// The constraints of a list; files that they name are looked for in `folder`.
///
/// # Errors
/// With line and column, when the text is no such list or does not fit the robot.
pub(super) fn parse(text: &str, folder: &Path, robot: Option<&Robot>) -> Result<Vec<Box<dyn Constraint>>> {
    let mut all: Vec<Box<dyn Constraint>> = text::from_ron(text)?;
    for constraint in &mut all {
        constraint.load(folder).map_err(|e| text::located(e, text))?;
    }
    if let Some(robot) = robot {
        forms(robot, &LinkSpace::new(robot, &[]), &all).map_err(|e| text::located(e, text))?;
    }
    Ok(all)
}

/// The same list with one more entry at its end.
pub(super) fn with_script(list: &str, file: &str) -> String {
    let entry = format!("{{\"script\": (path: \"{file}\")}}");
    if list.contains(&entry) {
        return list.to_string();
    }
    match list.rfind(']') {
        Some(end) => {
            let head = list[..end].trim_end();
            let comma = if head.ends_with([',', '[']) { "" } else { "," };
            format!("{head}{comma}\n    {entry},\n{}", &list[end..])
        }
        None => format!("[\n    {entry},\n]\n"),
    }
}

/// Every kind of constraint, with an entry to start from; files are looked for in `folder`.
pub(super) fn kinds(folder: &Path, robot: Option<&Robot>) -> Vec<Value> {
    let one = |about: About| {
        let settings = about.settings.iter().map(|(n, u, m)| json!({"name": n, "unit": u, "meaning": m}));
        json!({
            "name": about.name, "title": about.title, "text": about.text, "condition": about.condition,
            "form": about.form, "settings": settings.collect::<Vec<_>>(),
            "template": template(about.example, folder, robot),
        })
    };
    CATALOGUE.iter().map(|about| one(about())).collect()
}

/// The example of a constraint as lines of a list. One that cannot be used here yet, because it names a file that is
/// not there or a second link of a robot that has one, stands behind slashes with the reason: whatever is offered
/// leaves a list that is read.
fn template(example: &str, folder: &Path, robot: Option<&Robot>) -> String {
    match parse(&format!("[{example}]"), folder, robot) {
        Ok(_) => format!("{example},"),
        Err(why) => {
            let why = why.message().replace(['\n', '\r'], " ");
            format!("// not yet: {why}\n    // {example},")
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_usual_list_is_one_and_takes_scripts() -> Result<()> {
        let robot = Robot::open("robots/two_link.ron")?;
        assert_eq!(parse(USUAL, Path::new("."), Some(&robot))?.len(), 2);
        let more = with_script(USUAL, "constraints/total_mass.rhai");
        assert_eq!(parse(&more, Path::new("."), None)?.len(), 3);
        assert_eq!(with_script(&more, "constraints/total_mass.rhai"), more, "once is enough");
        assert_eq!(parse(&with_script("[]", "constraints/total_mass.rhai"), Path::new("."), None)?.len(), 1);
        let wrong = parse("[\n {\"mass_rage\": ()}]", Path::new("."), None).expect_err("no such kind");
        assert_eq!(wrong.place().and_then(|p| p.line), Some(2));
        Ok(())
    }

    /// A list with this entry after those that it starts with, as the page puts it there.
    fn inserted(template: &str) -> String {
        let end = USUAL.rfind(']').expect("a list ends");
        format!("{}\n    {template}\n{}", USUAL[..end].trim_end(), &USUAL[end..])
    }

    #[test]
    fn whatever_is_offered_is_accepted_with_and_without_robot_and_files() -> Result<()> {
        let files = tempfile::tempdir().expect("a folder");
        let place = |from: &str, to: &str| {
            let to = files.path().join(to);
            std::fs::create_dir_all(to.parent().expect("a folder of its own")).expect("is made");
            std::fs::copy(from, to).expect("is copied");
        };
        place("tests/fixtures/meshes/box.stl", "meshes/link1.stl");
        place("constraints/total_mass.rhai", "constraints/total_mass.rhai");
        let bare = tempfile::tempdir().expect("a folder");
        let mut short = Robot::open("robots/two_link.ron")?;
        short.joints.truncate(1);
        short.links.truncate(1);
        short.order.truncate(1);
        short.frames.clear();
        let robots = [
            None,
            Some(short),
            Some(Robot::open("robots/two_link.ron")?),
            Some(Robot::open("robots/panda.ron")?),
        ];
        for folder in [bare.path(), files.path()] {
            for robot in &robots {
                for (kind, about) in kinds(folder, robot.as_ref()).iter().zip(CATALOGUE) {
                    let text = inserted(kind["template"].as_str().expect("a text"));
                    let found =
                        parse(&text, folder, robot.as_ref()).unwrap_or_else(|e| panic!("{text}: {e}"));
                    let usable = !text.contains("// not yet");
                    assert_eq!(found.len(), if usable { 3 } else { 2 }, "{text}");
                    let full = folder == files.path() && robot.as_ref().is_none_or(|r| r.links.len() > 1);
                    assert!(usable || !full, "{}: {text}", about().name);
                }
            }
        }
        Ok(())
    }
}
