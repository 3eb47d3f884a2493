//! What the engines are, for people who choose one.

use super::nlopt::NloptEngine;
use super::penalty::{PaperEngine, PenaltyEngine};
use super::{LmiEngine, RetrievalEngine};
use lacuna_base::error::{Error, Result};
use lacuna_base::text;

/// An engine in words.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct EngineAbout {
    /// Its name in scenarios.
    pub name: &'static str,
    /// One line.
    pub title: &'static str,
    /// What it does and when to choose it.
    pub text: &'static str,
    /// Which constraints it takes.
    pub takes: &'static str,
    /// An entry of a scenario to start from, in RON.
    pub example: &'static str,
    /// Names and meanings of its settings.
    pub settings: &'static [(&'static str, &'static str)],
}

impl EngineAbout {
    /// What `label` means, which every engine has.
    pub const LABEL: (&'static str, &'static str) =
        ("label", "the name of this entry in the study's results");
    /// What `polish` means, where an engine has it.
    pub const POLISH: (&'static str, &'static str) =
        ("polish", "local search that ends each stage: InteriorPoint or NelderMead");
    /// What `penalty` means, where an engine has it.
    pub const PENALTY: (&'static str, &'static str) =
        ("penalty", "measure of a violation: Constant, Linear or Squared");
}

/// Every engine, the usual one first.
pub const CATALOGUE: [EngineAbout; 4] =
    [PenaltyEngine::ABOUT, PaperEngine::ABOUT, LmiEngine::ABOUT, NloptEngine::ABOUT];

/// The engine of this name with its usual settings.
///
/// # Errors
/// When there is no such engine; the message lists those that are known.
pub fn engine(name: &str) -> Result<Box<dyn RetrievalEngine>> {
    let known = CATALOGUE.iter().any(|about| about.name == name);
    if !known {
        let known = CATALOGUE.iter().map(|about| about.name);
        return Err(Error::new(format!("no engine called `{name}`")).help(text::suggestion(name, known)));
    }
    text::from_ron(&format!("{{\"{name}\": ()}}"))
}

/// The settings that an engine is given when a scenario says nothing else, as RON without its brackets.
///
/// # Errors
/// When the engine cannot be written as RON.
pub fn usual_settings(engine: &dyn RetrievalEngine) -> Result<Vec<(String, String)>> {
    let text = text::to_ron(&engine)?;
    let field = |line: &str| {
        let (name, value) = line.trim().trim_end_matches(',').split_once(": ")?;
        let name = name.trim();
        (!name.starts_with('"')).then(|| (name.to_owned(), value.trim().to_owned()))
    };
    Ok(text.lines().filter_map(field).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_engine_has_a_file_with_the_pieces_of_the_recipe() {
        let list = std::fs::read_to_string("src/catalogue.rs").expect("it is there");
        let catalogue = list.split("pub const CATALOGUE").nth(1).expect("it is there");
        let catalogue = catalogue.split(';').nth(1).expect("it ends");
        let mut found = Vec::new();
        for folder in ["src", "src/penalty"] {
            for file in std::fs::read_dir(folder).expect("it is there") {
                let text = std::fs::read_to_string(file.expect("a file").path()).unwrap_or_default();
                let Some((before, after)) = text.split_once("\nimpl RetrievalEngine for ") else { continue };
                let kind = after.split_whitespace().next().expect("a type");
                assert!(catalogue.contains(&format!("{kind}::ABOUT")), "{kind} is not in the catalogue");
                assert!(
                    before.contains("pub const ABOUT: EngineAbout") && before.contains("example: "),
                    "{kind}"
                );
                found.push(kind.to_string());
            }
        }
        assert_eq!(found.len(), CATALOGUE.len(), "{found:?}");
    }

    #[test]
    fn every_engine_is_known_by_its_name_and_has_the_settings_that_are_explained() -> Result<()> {
        for about in &CATALOGUE {
            let engine = engine(about.name)?;
            assert_eq!(engine.name(), about.name);
            let usual = usual_settings(engine.as_ref())?;
            for (setting, _) in about.settings {
                assert!(
                    usual.iter().any(|(name, _)| name == setting),
                    "{}: {setting} in {usual:?}",
                    about.name
                );
            }
        }
        assert!(
            engine("simplex").expect_err("no such engine").to_string().contains("penalty_paper, lmi, nlopt")
        );
        Ok(())
    }
}
