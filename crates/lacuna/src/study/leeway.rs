//! What data and constraints leave open, and who decides there.

use crate::constraints::LinkSpace;
use crate::error::Result;
use crate::report::{Chosen, Interval};
use crate::retrieval::{Problem, TieBreak, choose, intervals};
use crate::robot::Robot;
use crate::scenario::Choice;

use super::Study;
use super::retrieval::{CHOSEN, Candidate, FromEngines, judge};

/// Ends of intervals beyond this are none: where nothing bounds a quantity, rounding does [m].
const FARTHEST_COM: f64 = 1e3;
/// The same for masses and inertias [kg, kg m²].
const LARGEST: f64 = 1e6;

/// What is left open.
#[derive(Default)]
pub(super) struct Leeway {
    pub intervals: Option<Vec<Interval>>,
    pub chosen: Option<Chosen>,
}

impl Study<'_> {
    /// Intervals and choice, as far as the scenario asks for them and something feasible was found. The
    /// chosen parameters join the candidates.
    pub(super) fn leeway(&mut self, engines: &mut FromEngines) -> Result<Leeway> {
        let (asked, choice) = (self.scenario.intervals, self.scenario.choice.clone());
        let Some(problem) = engines.problem.as_ref().filter(|_| asked.is_some() || choice.is_some()) else {
            return Ok(Leeway::default());
        };
        let Some((best, candidate)) = engines.best() else {
            self.warn("no engine found feasible parameters, so there is nothing to choose from");
            return Ok(Leeway::default());
        };
        let level = asked.unwrap_or_default().level(best.objective);
        let start = [candidate.links.as_slice(), &candidate.others].concat();
        let intervals = match asked {
            Some(_) => Some(self.open_intervals(problem, &engines.space, level)?),
            None => None,
        };
        let chosen = match &choice {
            Some(choice) => {
                self.choose((problem, &engines.space), choice, level, &start, intervals.as_deref())?
            }
            None => None,
        };
        if let Some((chosen, z)) = &chosen {
            engines.candidates.push(Candidate::new(&chosen.retrieval.label, &engines.space, z));
        }
        Ok(Leeway { intervals, chosen: chosen.map(|(chosen, _)| chosen) })
    }

    fn open_intervals(&mut self, problem: &Problem, space: &LinkSpace, level: f64) -> Result<Vec<Interval>> {
        self.say("what data and constraints leave open");
        if problem.forms.iter().any(|form| !form.is_convex()) {
            self.warn("intervals: constraints that no cone expresses are relaxed, so some may be too wide");
        }
        let mut found = intervals(problem, level, &space.quantities())?;
        for interval in &mut found {
            let largest = if interval.unit == "m" { FARTHEST_COM } else { LARGEST };
            let bounded = |end: Option<f64>| end.filter(|v| v.abs() <= largest);
            (interval.low, interval.high) = (bounded(interval.low), bounded(interval.high));
        }
        let missing = found.iter().filter(|i| i.low.is_none() || i.high.is_none()).count();
        if missing > 0 {
            self.warn(format!("intervals: {missing} of {} are open or could not be computed", found.len()));
        }
        let interval = |i: crate::retrieval::Interval| Interval {
            parameter: i.parameter,
            low: i.low,
            high: i.high,
            unit: i.unit,
        };
        Ok(found.into_iter().map(interval).collect())
    }

    fn choose(
        &mut self,
        (problem, space): (&Problem, &LinkSpace),
        choice: &Choice,
        level: f64,
        start: &[f64],
        intervals: Option<&[Interval]>,
    ) -> Result<Option<(Chosen, Vec<f64>)>> {
        self.say("choosing among equally good parameters");
        let (rule, tie_break) = self.rule(choice, space)?;
        let found = match choose(problem, &space.bodies(), level, start, &tie_break) {
            Ok(found) => found,
            Err(why) => {
                self.warn(format!("the choice ({rule}) cannot be made: {}", why.message()));
                return Ok(None);
            }
        };
        let reach = if found.global { "" } else { " as far as steps from the best engine's answer lead" };
        let status = format!("{rule}{reach}; the choice decided, not the data");
        let retrieval = judge(("choice", CHOSEN, &status), space, problem, &found.z, None);
        let open = intervals.unwrap_or_default().iter().filter(|i| i.is_open());
        let decided = open.map(|i| i.parameter.clone()).collect();
        Ok(Some((Chosen { rule, largest_objective: level, decided, retrieval }, found.z)))
    }

    /// The rule in words and as the engine takes it.
    pub(super) fn rule(&self, choice: &Choice, space: &LinkSpace) -> Result<(String, TieBreak)> {
        Ok(match choice {
            Choice::Uniform => ("mass spread most uniformly".to_string(), TieBreak::Uniform),
            Choice::Smallest => ("smallest masses and second moments".to_string(), TieBreak::Smallest),
            Choice::Nearest { prior } => {
                let (name, mut z) = match prior {
                    Some(file) => {
                        let path = self.folder.join(file);
                        let z = Robot::open(&path)?.prior_for(&self.robot).map_err(|e| e.in_file(&path))?;
                        (file.display().to_string(), z)
                    }
                    None => ("the robot file".to_string(), self.robot.inertial_parameters()?),
                };
                // Friction has no prior, and bodies do not depend on it.
                z.resize(z.len() + space.space.len() - 10 * space.links, 0.0);
                (format!("nearest to the inertias of {name}"), TieBreak::Nearest { prior: z })
            }
        })
    }
}
