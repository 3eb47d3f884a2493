//! Retrieval of feasible link parameters: every engine on the same problem, one audit for all.

use std::collections::BTreeSet;

use nalgebra::{DMatrix, DVector};

use crate::constraints::{LinkSpace, forms, search_space};
use crate::error::{Error, Result};
use crate::form::Form;
use crate::identify::BaseParameters;
use crate::linalg::Triangle;
use crate::model::Model;
use crate::report::{Identification, LinkParameters, NamedValue, Retrieval, finite};
use crate::retrieval::{Conflict, Problem, Quadratic, RetrievalEngine, Retrieved, audit, conflict};
use crate::robot::PARAMETERS_PER_LINK;
use crate::scenario::Objective;
use crate::space::Parameter;

use super::moving::FromLogs;
use super::rivals::Rival;
use super::statics::FromPoses;
use super::{Study, published};

/// Label of the robot file's own inertias.
pub(super) const GIVEN: &str = "given";
/// Label of parameters that the user's rule took among equally good ones.
pub(super) const CHOSEN: &str = "chosen";

/// What the engines gave.
pub(super) struct FromEngines {
    pub space: LinkSpace,
    /// What was solved; `None` where nothing could be.
    pub problem: Option<Problem>,
    /// All sets of parameters worth comparing: the robot file's own, every engine's, the chosen one.
    pub candidates: Vec<Candidate>,
    /// What was not retrieved here.
    pub given: Vec<Retrieval>,
    pub reports: Vec<Retrieval>,
    pub conflict: Option<Conflict>,
}

/// A set of parameters.
pub(super) struct Candidate {
    pub label: String,
    /// Ten per link.
    pub links: Vec<f64>,
    /// What was retrieved along: parameters of the model's other columns, in order.
    pub others: Vec<f64>,
}

impl Candidate {
    pub fn new(label: &str, space: &LinkSpace, z: &[f64]) -> Self {
        let (links, others) = z.split_at(PARAMETERS_PER_LINK * space.links);
        Self { label: label.to_string(), links: links.to_vec(), others: others.to_vec() }
    }

    /// Whether the user's rule took it.
    pub fn is_chosen(&self) -> bool {
        self.label == CHOSEN
    }
}

/// A certified bound on the objective.
#[derive(Clone, Copy)]
pub(super) struct Bound {
    value: f64,
    /// Whether it is that of the problem itself: nothing was left out, or what was left out holds at the
    /// answer all the same, which is then optimal for the whole problem.
    exact: bool,
}

impl Study<'_> {
    /// Runs every engine of the scenario on the same problem.
    pub(super) fn retrieve(
        &mut self,
        poses: Option<&FromPoses>,
        moving: Option<&FromLogs>,
    ) -> Result<Option<FromEngines>> {
        if self.scenario.engines.is_empty() {
            return Ok(None);
        }
        let mut engines = std::mem::take(&mut self.scenario.engines);
        let labels = self.make_ready(&mut engines)?;
        let (space, objective) = match self.scenario.objective {
            Objective::Coefficients => self.coefficient_distance(poses, moving)?,
            Objective::Torque => self.torque_error(moving)?,
        };
        // Whether these can be read is found out now, not after the engines' work.
        let rivals = self.rivals(&space, &labels)?;
        if let Some(choice) = &self.scenario.choice {
            self.rule(choice, &space)?;
        }
        let forms = forms(&self.robot, &space, &self.scenario.constraints)?;
        if let Some(conflict) = conflict(space.space.len(), &forms)? {
            return Ok(Some(FromEngines::nothing(space, conflict)));
        }
        let problem = self.problem(&space, objective, forms)?;
        let results = self.run_engines(&engines, &problem)?;
        Ok(Some(self.judged(space, problem, &engines, (&results, &rivals))))
    }

    /// Whether the engines can run, found out before the first one does; their labels.
    fn make_ready(&self, engines: &mut [Box<dyn RetrievalEngine>]) -> Result<BTreeSet<String>> {
        let mut labels = BTreeSet::new();
        for engine in engines.iter_mut() {
            engine.available()?;
            if !labels.insert(engine.label().to_string()) {
                return Err(Error::new(format!("two engines are called `{}`", engine.label()))
                    .help("give each a `label` of its own"));
            }
            if [GIVEN, CHOSEN].contains(&engine.label()) {
                return Err(Error::new(format!("`{}` is a name of reports", engine.label()))
                    .help("give the engine another `label`"));
            }
            engine.set_checkpoint(self.checkpoint.clone());
        }
        match self.checkpoint.as_ref().filter(|c| c.resume) {
            Some(c) if !labels.iter().any(|label| c.file(label).is_file()) => {
                let known: Vec<String> = labels.into_iter().collect();
                Err(Error::new(format!("there is no checkpoint of {} to go on from", known.join(", ")))
                    .in_file(&c.folder)
                    .help("give the folder that the interrupted study wrote to, or start without --resume"))
            }
            _ => Ok(labels),
        }
    }

    /// One engine after the other, until one is asked to stop.
    fn run_engines(
        &mut self,
        engines: &[Box<dyn RetrievalEngine>],
        problem: &Problem,
    ) -> Result<Vec<(String, Retrieved)>> {
        let mut results: Vec<(String, Retrieved)> = Vec::new();
        for engine in engines {
            let label = engine.label().to_string();
            if self.stopped {
                self.warn(format!("stopped before {label} was run"));
                continue;
            }
            self.say(&format!("retrieving link parameters with {label}"));
            let start = std::time::Instant::now();
            let found = engine.retrieve(problem, self.watch)?;
            self.timing.insert(label.clone(), start.elapsed().as_secs_f64());
            if found.stopped {
                self.stopped = true;
                self.warn(format!("{label}: {}", found.status));
            }
            results.push((label, found));
        }
        if let Some(checkpoint) = self.checkpoint.as_ref().filter(|_| !self.stopped) {
            results.iter().try_for_each(|(label, _)| checkpoint.discard(label))?;
        }
        Ok(results)
    }

    /// All results by the one audit, those that were not retrieved here among them.
    fn judged(
        &self,
        space: LinkSpace,
        problem: Problem,
        engines: &[Box<dyn RetrievalEngine>],
        (results, rivals): (&[(String, Retrieved)], &[Rival]),
    ) -> FromEngines {
        let bound = bound(&problem, results);
        let rows = engines.iter().zip(results).map(|(engine, (label, found))| {
            let (runs, stages) = (found.runs, found.stages);
            Retrieval {
                runs,
                stages,
                ..judge((engine.name(), label, &found.status), &space, &problem, &found.z, bound)
            }
        });
        let reports = rows.collect();
        let rows =
            rivals.iter().map(|r| judge(("given", &r.label, &r.status), &space, &problem, &r.z, bound));
        let given = rows.collect();
        let all = rivals.iter().map(|r| (&r.label, &r.z)).chain(results.iter().map(|(l, r)| (l, &r.z)));
        let candidates = all.map(|(label, z)| Candidate::new(label, &space, z)).collect();
        FromEngines { space, problem: Some(problem), candidates, given, reports, conflict: None }
    }

    fn problem(&mut self, space: &LinkSpace, objective: Quadratic, forms: Vec<Form>) -> Result<Problem> {
        let search = search_space(&self.robot, space, &self.scenario.constraints)?;
        if !search.assumed.is_empty() {
            self.warn(unbounded(&search.assumed));
        }
        let chart = Box::new(search.chart);
        Ok(Problem { space: space.space.clone(), objective, forms, chart, seed: self.seed })
    }

    /// Distance to the coefficients that were kept: published ones where the scenario names some, else those
    /// from the poses, else those from the logs.
    fn coefficient_distance(
        &self,
        poses: Option<&FromPoses>,
        moving: Option<&FromLogs>,
    ) -> Result<(LinkSpace, Quadratic)> {
        let base = BaseParameters::new(&self.robot);
        let moving = moving.filter(|m| m.fitted.base.is_some()).map(|m| &m.report);
        let source: Option<&Identification> = poses.map(|p| &p.report).or(moving);
        let identified = source.map(|s| &s.coefficients[..base.rank()]);
        let (whose, values) = match (&self.scenario.retrieve_from, identified) {
            (Some(file), _) => (file.display().to_string(), published(&self.folder, file, &base)?.1),
            (None, Some(all)) => {
                ("the identification".to_string(), all.iter().map(|c| c.value.unwrap_or(f64::NAN)).collect())
            }
            (None, None) => {
                return Err(Error::new("nothing was identified to retrieve link parameters from")
                    .help("give `poses`, or logs and `rigid_body` among the effects"));
            }
        };
        let kept = |i: &usize| values[*i].is_finite() && identified.is_none_or(|all| all[*i].kept);
        let picked: Vec<usize> = (0..base.rank()).filter(kept).collect();
        let r = base.map.select_rows(&picked);
        let d = DVector::from_iterator(picked.len(), picked.iter().map(|&i| values[i]));
        let unit = format!("squared distance to {} coefficients of {whose}, SI", picked.len());
        Ok((LinkSpace::new(&self.robot, &[]), Quadratic { r, d, floor: 0.0, unit }))
    }

    /// Torque error on the stacked regressor of the logs: link parameters and friction together.
    fn torque_error(&self, moving: Option<&FromLogs>) -> Result<(LinkSpace, Quadratic)> {
        let moving = moving.ok_or_else(|| {
            Error::new("`objective: Torque` needs `logs`").help("give logs, or use `objective: Coefficients`")
        })?;
        let model = &moving.fitted;
        let base = model
            .base
            .as_ref()
            .ok_or_else(|| Error::new("`objective: Torque` needs `rigid_body` among the effects"))?;
        let (order, rank) = rigid_first(model);
        let others: Vec<Parameter> = order[rank..]
            .iter()
            .map(|&c| &model.columns[c].about)
            .map(|about| Parameter::free(about.symbol.clone(), about.unit))
            .collect();
        let space = LinkSpace::new(&self.robot, &others);
        let total = stacked(moving, &order);
        let p = model.columns.len();
        let links = base.map.ncols();
        // R y - d with the coefficients y = (map z_links, z_others).
        let r = DMatrix::from_fn(p, links + p - rank, |row, column| {
            if column < links {
                (row.min(rank)..rank).map(|k| total.at(row, k) * base.map[(k, column)]).sum()
            } else {
                total.at(row, rank + column - links)
            }
        });
        let d = DVector::from_fn(p, |row, _| total.at(row, p));
        let floor = total.at(p, p).powi(2);
        Ok((space, Quadratic { r, d, floor, unit: "(N m)^2 summed over rows".to_string() }))
    }
}

/// One triangle over the columns of the model in this order and the torque, every row weighing alike.
fn stacked(moving: &FromLogs, order: &[usize]) -> Triangle {
    let model = &moving.fitted;
    let p = order.len();
    let place = |column: usize| order.iter().position(|&c| c == column);
    let mut total = Triangle::new(p + 1);
    for (joint, triangle) in moving.evidence.merged(None).iter().enumerate() {
        let columns = model.active[joint].iter().map(|&column| place(column));
        total.merge(triangle, &columns.chain([Some(p)]).collect::<Vec<_>>(), 1.0);
    }
    total
}

impl FromEngines {
    fn nothing(space: LinkSpace, conflict: Conflict) -> Self {
        let (candidates, reports) = (Vec::new(), Vec::new());
        Self { space, problem: None, candidates, given: Vec::new(), reports, conflict: Some(conflict) }
    }

    /// The feasible result with the smallest objective, and its parameters.
    pub fn best(&self) -> Option<(&Retrieval, &Candidate)> {
        let feasible = self.reports.iter().filter(|r| r.feasible);
        let best = feasible.min_by(|a, b| a.objective.total_cmp(&b.objective))?;
        Some((best, self.candidates.iter().find(|c| c.label == best.label)?))
    }
}

/// The best bound that any engine certified.
fn bound(problem: &Problem, results: &[(String, Retrieved)]) -> Option<Bound> {
    let bounds = results.iter().filter_map(|(_, r)| r.lower_bound);
    let value = bounds.reduce(f64::max)?;
    let convex = problem.forms.iter().all(Form::is_convex);
    let holds = || results.iter().any(|(_, r)| r.lower_bound.is_some() && audit(problem, &r.z).feasible);
    Some(Bound { value, exact: convex || holds() })
}

/// Columns of a model with the rigid body's first, and how many those are.
pub(super) fn rigid_first(model: &Model) -> (Vec<usize>, usize) {
    let is_rigid = |c: &usize| model.effects[model.columns[*c].effect].is_rigid_body();
    let (mut order, others): (Vec<usize>, Vec<usize>) = (0..model.columns.len()).partition(is_rigid);
    let rank = order.len();
    order.extend(others);
    (order, rank)
}

/// What a set of parameters is worth.
pub(super) fn judge(
    (engine, label, status): (&str, &str, &str),
    space: &LinkSpace,
    problem: &Problem,
    z: &[f64],
    bound: Option<Bound>,
) -> Retrieval {
    let audit = audit(problem, z);
    let links = (0..space.links).map(|l| LinkParameters::new(&space.names[l], &space.link(z, l)));
    let others = problem.space.parameters.iter().zip(z).skip(PARAMETERS_PER_LINK * space.links);
    Retrieval {
        engine: engine.to_string(),
        label: label.to_string(),
        objective: audit.objective,
        objective_unit: problem.objective.unit.clone(),
        violation: finite(audit.violation),
        feasible: audit.feasible,
        least_margin: finite(audit.least_margin),
        lower_bound: bound.map(|b| b.value),
        certified_gap_percent: bound
            .filter(|b| b.value > 0.0 && audit.feasible)
            .map(|b| 100.0 * (audit.objective - b.value) / b.value),
        bound_is: bound.map(|b| if b.exact { "exact" } else { "relaxation" }.to_string()),
        runs: 0,
        stages: 0,
        status: status.to_string(),
        links: links.collect(),
        others: others
            .map(|(p, &value)| NamedValue { name: p.name.clone(), value, unit: p.unit.clone() })
            .collect(),
        constraints: audit.constraints,
    }
}

/// A warning that names the first coordinates whose bounds had to be assumed.
fn unbounded(assumed: &[String]) -> String {
    let shown = assumed.iter().take(4).cloned().collect::<Vec<_>>().join(", ");
    let more = match assumed.len() {
        0..=4 => String::new(),
        n => format!(" and {} more", n - 4),
    };
    format!("no constraint bounds the search everywhere, so it was assumed: {shown}{more}")
}
