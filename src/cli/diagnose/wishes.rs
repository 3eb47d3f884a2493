//! What `--add` and `--try` name, looked up before any log is read.

use std::path::Path;

use lacuna::effects::{CATALOGUE, Effect, Joints, ScriptedEffect, Stage};
use lacuna::robot::Robot;
use lacuna::{Error, Result, text};

use super::Diagnose;

impl Diagnose {
    /// The effects to add by name; scripts become candidates, those to try as well.
    pub(super) fn wishes(
        &self,
        robot: &Robot,
        extra: &mut Vec<Box<dyn Effect>>,
    ) -> Result<Vec<(String, Option<String>)>> {
        let mut add = Vec::new();
        let add_flags = self.add.iter().map(|a| ("--add", a));
        for (flag, given) in add_flags.chain(self.tried.iter().map(|t| ("--try", t))) {
            let wanted = flag == "--add";
            let (name, joint) = wish(given);
            if let Some(joint) = &joint {
                check_joint(flag, joint, robot)?;
            }
            let listed = extra.iter().any(|other| other.about().name == name);
            if wanted && (!name.ends_with(".rhai") || listed && !Path::new(&name).exists()) {
                check_effect(&name, extra)?;
                add.push((name, joint));
                continue;
            }
            if !name.ends_with(".rhai") {
                let known = CATALOGUE.iter().any(|entry| entry.about.name == name);
                let first = if known { format!("; --add {given} adds it first") } else { String::new() };
                let help =
                    format!("the catalogue takes part anyway{first}; --try takes a file that ends in .rhai");
                return Err(Error::new(format!("--try {given}: not an effect script")).help(help));
            }
            let joints = joint.as_ref().map_or(Joints::All, |j| Joints::Only(vec![j.clone()]));
            let effect = ScriptedEffect::open(Path::new(&name), joints)?;
            effect.try_on(robot)?;
            let name = effect.about().name;
            extra.retain(|other| other.about().name != name);
            extra.push(effect.boxed());
            if wanted {
                add.push((name.to_string(), joint));
            }
        }
        Ok(add)
    }

    /// The effect as `--add` takes it: a script that was tried by its path.
    pub(super) fn where_it_is(&self, effect: &str) -> String {
        let named = |path: &String| Path::new(path).file_name().is_some_and(|file| file == effect);
        self.tried.iter().map(|t| wish(t).0).find(named).unwrap_or_else(|| effect.to_string())
    }
}

fn check_effect(name: &str, extra: &[Box<dyn Effect>]) -> Result<()> {
    let of_scenario = extra.iter().map(|effect| effect.about().name);
    let known: Vec<&str> = CATALOGUE.iter().map(|entry| entry.about.name).chain(of_scenario).collect();
    if known.contains(&name) {
        return if can_be_added(name) { Ok(()) } else { Err(belongs_elsewhere(name)) };
    }
    let help = text::suggestion(name, known);
    Err(Error::new(format!("--add: no effect called `{name}`")).help(help))
}

/// Whether `--add` takes this name: of the catalogue what a search tries; scripts are files.
pub(super) fn can_be_added(name: &str) -> bool {
    stage(name).is_none_or(|stage| matches!(stage, Stage::First | Stage::Usual))
}

/// When a search tries what the catalogue has under this name.
fn stage(name: &str) -> Option<Stage> {
    CATALOGUE.iter().find(|entry| entry.about.name == name).map(|entry| entry.about.stage)
}

fn belongs_elsewhere(name: &str) -> Error {
    let help = match stage(name) {
        Some(Stage::InEveryModel) => "every model has it",
        Some(Stage::Given) => "give the script's file: --add FILE.rhai",
        _ => "it is looked for anyway, as what acts in an interval only",
    };
    Error::new(format!("--add: `{name}` cannot be added by name")).help(help)
}

fn check_joint(flag: &str, joint: &str, robot: &Robot) -> Result<()> {
    if robot.joint_index(joint).is_some() {
        return Ok(());
    }
    let help = text::suggestion(joint, robot.joints.iter().map(|j| j.name.as_str()));
    Err(Error::new(format!("{flag}: no joint `{joint}`")).help(help))
}

/// `EFFECT` or `EFFECT:JOINT`; colons inside the path of a script stay in it.
fn wish(text: &str) -> (String, Option<String>) {
    let split = match text.find(".rhai") {
        Some(end) => text[end..].find(':').map(|colon| end + colon),
        None => text.find(':'),
    };
    match split {
        Some(colon) => (text[..colon].to_string(), Some(text[colon + 1..].to_string())),
        None => (text.to_string(), None),
    }
}

#[cfg(test)]
mod tests {
    use super::wish;

    #[test]
    fn a_joint_stands_behind_a_colon_and_paths_keep_theirs() {
        let pair = |name: &str, joint: Option<&str>| (name.to_string(), joint.map(str::to_string));
        assert_eq!(wish("backlash"), pair("backlash", None));
        assert_eq!(wish("backlash:joint3"), pair("backlash", Some("joint3")));
        assert_eq!(wish("C:/a.rhai:joint3"), pair("C:/a.rhai", Some("joint3")));
    }
}
