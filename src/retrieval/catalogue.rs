//! What the engines are, for people who choose one.

use super::RetrievalEngine;
use crate::error::{Error, Result};
use crate::text;

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
    /// Names and meanings of its settings.
    pub settings: &'static [(&'static str, &'static str)],
}

const LABEL: (&str, &str) = ("label", "the name of this entry in the study's results");
const POLISH: (&str, &str) = ("polish", "local search that ends each stage: InteriorPoint or NelderMead");
const PENALTY: (&str, &str) = ("penalty", "measure of a violation: Constant, Linear or Squared");

/// Every engine, the usual one first.
pub const CATALOGUE: [EngineAbout; 4] = [
    EngineAbout {
        name: "penalty",
        title: "random starts, annealing with penalties, polish",
        text: "Algorithm 1 of Gaz et al. 2019 with cheap coordinate moves and a polish that knows the \
               constraints. The one to start with, and the only kind where constraints are not convex. It \
               finds no proof that its answer is the best; the spread over its runs is a hint, and `lmi` on \
               the same problem gives a bound.",
        takes: "every constraint",
        settings: &[
            LABEL,
            ("runs", "independent runs from random starts, Q in the paper"),
            ("stages", "most stages of a run, kappa in the paper"),
            ("proposals", "moves tried in each stage"),
            PENALTY,
            POLISH,
        ],
    },
    EngineAbout {
        name: "penalty_paper",
        title: "the paper's Algorithm 1 to the letter",
        text: "Algorithm 1 of Gaz et al. 2019 as printed: penalty weights 0, 10, 20, .. and annealing over \
               all unknowns at once. To reproduce the paper; `penalty` reaches the same optimum sooner.",
        takes: "every constraint",
        settings: &[
            LABEL,
            ("runs", "independent runs from random starts, Q in the paper"),
            ("stages", "stages of a run, kappa in the paper"),
            ("evaluations", "evaluations of the annealing in each stage"),
            ("temperature", "temperature at the start of a stage"),
            ("cooling", "factor on the temperature from move to move"),
            ("reanneal", "moves after which the temperature returns to its start"),
            PENALTY,
            POLISH,
        ],
    },
    EngineAbout {
        name: "lmi",
        title: "global optimum under convex constraints, with a certified bound",
        text: "Linear matrix inequalities solved by an interior-point method (Wensing, Kim and Slotine 2018; \
               Sousa and Cortesao 2014). Milliseconds, no random draws, and a certified lower bound on what \
               any engine can reach.",
        takes: "convex constraints; of others it takes what they imply, and the audit shows the rest",
        settings: &[
            LABEL,
            ("tolerance", "relative gap and feasibility at which the solver stops"),
            ("iterations", "iterations at most"),
            ("margin", "distance kept from every limit, relative to its scale"),
        ],
    },
    EngineAbout {
        name: "nlopt",
        title: "NLopt's local solvers, as a yardstick (feature `nlopt`)",
        text: "The local solvers of Steven Johnson's NLopt on the same problem. Only in a build with \
               `--features nlopt`, which needs CMake and a C compiler; the library contains code under the \
               LGPL.",
        takes: "every constraint",
        settings: &[
            LABEL,
            ("runs", "independent runs from random starts"),
            ("algorithm", "Slsqp (gradients, all constraints) or Sbplx (simplex, penalty)"),
            ("evaluations", "most evaluations of a run"),
        ],
    },
];

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
