//! Retrieval of feasible link parameters: every engine on the same problem, one audit for all.

use std::ops::ControlFlow;

use nalgebra::{DMatrix, DVector};

use crate::constraints::{LinkSpace, forms, search_space};
use crate::error::{Error, Result};
use crate::identify::BaseParameters;
use crate::linalg::Triangle;
use crate::report::{Identification, LinkParameters, NamedValue, Retrieval, finite};
use crate::retrieval::{Problem, Quadratic, Retrieved, audit};
use crate::scenario::Objective;
use crate::space::Parameter;

use super::Study;
use super::moving::FromLogs;
use super::statics::FromPoses;

/// What the engines gave.
pub(super) struct FromEngines {
    pub space: LinkSpace,
    /// Label and unknowns of every engine.
    pub found: Vec<(String, Vec<f64>)>,
    pub reports: Vec<Retrieval>,
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
        let (space, problem) = self.problem(poses, moving)?;
        let engines = std::mem::take(&mut self.scenario.engines);
        let mut results: Vec<(String, Retrieved)> = Vec::new();
        for engine in &engines {
            engine.available()?;
            let label = engine.label().to_string();
            if results.iter().any(|(l, _)| *l == label) {
                return Err(Error::new(format!("two engines are called `{label}`"))
                    .help("give each a `label` of its own"));
            }
            self.say(&format!("retrieving link parameters with {label}"));
            let start = std::time::Instant::now();
            let found = engine.retrieve(&problem, &|_| ControlFlow::Continue(()))?;
            self.timing.insert(label.clone(), start.elapsed().as_secs_f64());
            results.push((label, found));
        }
        let bound = results
            .iter()
            .filter_map(|(_, r)| r.lower_bound)
            .fold(None, |best: Option<f64>, b| Some(best.map_or(b, |x| x.max(b))));
        let exact = problem.forms.iter().all(|form| form.is_convex());
        let reports = engines
            .iter()
            .zip(&results)
            .map(|(engine, (label, found))| {
                report(engine.name(), label, &space, &problem, found, bound, exact)
            })
            .collect();
        let found = results.into_iter().map(|(label, r)| (label, r.z)).collect();
        Ok(Some(FromEngines { space, found, reports }))
    }

    fn problem(
        &mut self,
        poses: Option<&FromPoses>,
        moving: Option<&FromLogs>,
    ) -> Result<(LinkSpace, Problem)> {
        let (space, objective) = match self.scenario.objective {
            Objective::Coefficients => self.coefficient_distance(poses, moving)?,
            Objective::Torque => self.torque_error(moving)?,
        };
        let forms = forms(&self.robot, &space, &self.scenario.constraints)?;
        let search = search_space(&self.robot, &space, &self.scenario.constraints)?;
        for assumed in search.assumed {
            self.warn(format!("no constraint bounds the search: {assumed}"));
        }
        let chart = Box::new(search.chart);
        let problem = Problem { space: space.space.clone(), objective, forms, chart, seed: self.seed };
        Ok((space, problem))
    }

    /// Distance to the coefficients that were kept: from the poses, else from the logs.
    fn coefficient_distance(
        &self,
        poses: Option<&FromPoses>,
        moving: Option<&FromLogs>,
    ) -> Result<(LinkSpace, Quadratic)> {
        let source: &Identification = match (poses, moving) {
            (Some(poses), _) => &poses.report,
            (None, Some(moving)) => &moving.report,
            (None, None) => {
                return Err(Error::new("nothing was identified to retrieve link parameters from"));
            }
        };
        let space = LinkSpace::new(&self.robot, &[]);
        let base = BaseParameters::new(&self.robot);
        let rows: Vec<(usize, f64)> = source.coefficients[..base.rank()]
            .iter()
            .enumerate()
            .filter_map(|(i, c)| Some((i, c.value.filter(|_| c.kept)?)))
            .collect();
        let picked: Vec<usize> = rows.iter().map(|r| r.0).collect();
        let r = base.map.select_rows(&picked);
        let d = DVector::from_iterator(rows.len(), rows.iter().map(|r| r.1));
        Ok((space, Quadratic { r, d, floor: 0.0, unit: "squared coefficients, SI".to_string() }))
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
        let others: Vec<Parameter> = model.columns[base.rank()..]
            .iter()
            .map(|c| Parameter::free(c.about.symbol.clone(), c.about.unit))
            .collect();
        let space = LinkSpace::new(&self.robot, &others);
        let total = self.stacked(moving);
        let p = model.columns.len();
        let (links, rank) = (base.map.ncols(), base.rank());
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

    /// One triangle over all columns of the model and the torque, every row weighing alike.
    fn stacked(&self, moving: &FromLogs) -> Triangle {
        let model = &moving.fitted;
        let p = model.columns.len();
        let mut total = Triangle::new(p + 1);
        for (joint, triangle) in moving.evidence.merged(None).iter().enumerate() {
            let places: Vec<Option<usize>> =
                model.active[joint].iter().copied().map(Some).chain([Some(p)]).collect();
            total.merge(triangle, &places, 1.0);
        }
        total
    }
}

fn report(
    engine: &str,
    label: &str,
    space: &LinkSpace,
    problem: &Problem,
    found: &Retrieved,
    bound: Option<f64>,
    exact: bool,
) -> Retrieval {
    let audit = audit(problem, &found.z);
    let links = (0..space.links).map(|l| LinkParameters::new(&space.names[l], &space.link(&found.z, l)));
    let others = problem.space.parameters.iter().zip(&found.z).skip(10 * space.links);
    Retrieval {
        engine: engine.to_string(),
        label: label.to_string(),
        objective: audit.objective,
        objective_unit: problem.objective.unit.clone(),
        violation: finite(audit.violation),
        feasible: audit.feasible,
        lower_bound: bound,
        certified_gap_percent: bound
            .filter(|b| *b > 0.0 && audit.feasible)
            .map(|b| 100.0 * (audit.objective - b) / b),
        bound_is: bound.map(|_| if exact { "exact" } else { "relaxation" }.to_string()),
        runs: found.runs,
        stages: found.stages,
        status: found.status.clone(),
        links: links.collect(),
        others: others
            .map(|(p, &value)| NamedValue { name: p.name.clone(), value, unit: p.unit.clone() })
            .collect(),
        constraints: audit.constraints,
    }
}
