//! The list of constraints that a retrieval must satisfy, as text that people edit.

use std::path::Path;

use serde_json::{Value, json};

use crate::constraints::{CATALOGUE, Constraint, LinkSpace, forms};
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

/// Every kind of constraint, with an entry to start from.
pub(super) fn kinds() -> Vec<Value> {
    let one = |about: crate::constraints::About| {
        json!({
            "name": about.name, "title": about.title, "text": about.text, "condition": about.condition,
            "form": about.form,
            "settings": about.settings.iter().map(|(n, u, m)| json!({"name": n, "unit": u, "meaning": m})).collect::<Vec<_>>(),
            "template": template(about.name),
        })
    };
    CATALOGUE.iter().map(|about| one(about())).collect()
}

/// An entry with settings that a reader sees through.
fn template(name: &str) -> String {
    let settings = match name {
        "mass_range" => "min: 0.1, max: 10.0",
        "total_mass" => "min: 10.0, max: 20.0",
        "mass_ratio" => "link: \"link1\", to: \"link2\", min: 0.5, max: 2.0",
        "mass_order" => "heavier: \"link1\", lighter: \"link2\"",
        "com_box" => "links: Only([\"link1\"]), min: (-0.1, -0.1, -0.1), max: (0.1, 0.1, 0.1)",
        "com_sphere" => "links: Only([\"link1\"]), centre: (0.0, 0.0, 0.0), radius: 0.1",
        "parameter_bounds" => "bounds: {\"m1\": (0.0, 10.0)}",
        "script" => "path: \"constraint_1.rhai\"",
        _ => "",
    };
    format!("{{\"{name}\": ({settings})}}")
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
}
