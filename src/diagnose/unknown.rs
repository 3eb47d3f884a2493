//! What no effect of the catalogue explains: on which variable a joint's error depends, and a formula that fits.

use std::sync::Arc;

use rayon::prelude::*;

use super::data::{Column, Data};
use super::gates::flipped;
use super::present::{Present, Response};
use super::score::{Projection, Score};
use crate::effects::{Curve, Formula, Own};
use crate::error::Result;
use crate::random::Stream;
use crate::signals::Run;

/// Groups of many columns are held back by this part of each column's size.
const RIDGE: f64 = 0.02;
/// Waves per turn that are tried.
const WAVES: [f64; 6] = [1.0, 2.0, 3.0, 4.0, 5.0, 6.0];
/// Places tried over the range of a position.
const PLACES: usize = 24;
/// Widths of bumps tried \[rad\].
const BUMPS: [f64; 4] = [0.05, 0.1, 0.2, 0.4];

/// A group of flexible columns of one variable, scored on one joint.
pub(super) struct Dependence {
    pub variable: String,
    pub score: Score,
    /// Part of the joint's held-out squared error that it explains.
    pub part: f64,
}

/// A formula with its score.
pub(super) struct Proposal {
    pub formula: Formula,
    pub score: Score,
    pub part: f64,
}

/// Which joint, beside which model.
#[derive(Clone, Copy)]
pub(super) struct Search<'a> {
    pub data: &'a Data,
    pub present: &'a Present,
    pub response: &'a Response,
    pub joint: usize,
    pub width: f64,
}

impl Search<'_> {
    fn part(&self, score: &Score) -> f64 {
        let square: f64 = self.response.residual[self.joint].iter().map(|r| r * r).sum();
        score.gain_of_joint[self.joint] / square.max(1e-300)
    }

    /// How much of the joint's error depends on each variable, most first.
    pub fn dependences(&self) -> Vec<Dependence> {
        self.scored(&self.projections(), self.response)
    }

    /// One group of flexible columns per variable, beside the model.
    pub fn projections(&self) -> Vec<(String, Projection)> {
        let beside = |(variable, columns): (String, Vec<Arc<Column>>)| {
            (variable, Projection::new(self.data, self.present, vec![columns], RIDGE))
        };
        self.groups().into_par_iter().map(beside).collect()
    }

    /// How much of a response depends on each variable, most first.
    pub fn scored(&self, groups: &[(String, Projection)], response: &Response) -> Vec<Dependence> {
        let square: f64 = response.residual[self.joint].iter().map(|r| r * r).sum();
        let one = |(variable, projection): &(String, Projection)| {
            let score = projection.score(self.data, self.present, response)?;
            let part = score.gain_of_joint[self.joint] / square.max(1e-300);
            Some(Dependence { variable: variable.clone(), part, score })
        };
        let mut all: Vec<Dependence> = groups.par_iter().filter_map(one).collect();
        all.sort_by(|a, b| b.part.total_cmp(&a.part));
        all
    }

    /// The largest part of the joint's error that any variable explains by chance: residuals whose sign is drawn
    /// for every second have nothing to find.
    pub fn chance(&self, groups: &[(String, Projection)], replicates: usize) -> f64 {
        let seconds = self.data.seconds();
        let replicate = |number: usize| -> f64 {
            let mut stream = Stream::new(0x0076_6172, number);
            let residual = &self.response.residual;
            let drawn = residual.iter().map(|r| flipped(r, &seconds, &mut stream)).collect();
            let response = self.present.respond(self.data, drawn);
            self.scored(groups, &response).first().map_or(0.0, |d| d.part)
        };
        (0..replicates).into_par_iter().map(replicate).reduce(|| 0.0, f64::max)
    }

    fn groups(&self) -> Vec<(String, Vec<Arc<Column>>)> {
        let mut wanted: Vec<(String, Variable)> = Vec::new();
        for i in 0..self.data.dof() {
            wanted.push((format!("q{}", i + 1), Variable::Position(i)));
            wanted.push((format!("dq{}", i + 1), Variable::Speed(i)));
            wanted.push((format!("ddq{}", i + 1), Variable::Acceleration(i)));
        }
        wanted.push(("time".to_string(), Variable::Time));
        wanted.extend(self.channels().into_iter().map(|c| (c.clone(), Variable::Channel(c))));
        wanted.into_par_iter().map(|(name, variable)| (name, self.group(&variable))).collect()
    }

    /// Channels that every run has and that vary.
    fn channels(&self) -> Vec<String> {
        let Some(first) = self.data.runs.first() else { return Vec::new() };
        let varies = |name: &&String| {
            self.data.runs.iter().all(|run| {
                let Some(c) = run.channels.get(*name) else { return false };
                let (low, high) = range(c);
                high - low > 1e-9 * low.abs().max(high.abs()).max(1e-9)
            })
        };
        first.channels.keys().filter(varies).cloned().collect()
    }

    fn group(&self, variable: &Variable) -> Vec<Arc<Column>> {
        let j = self.joint;
        let mut functions: Vec<Box<dyn Fn(f64, f64) -> f64 + Sync>> = Vec::new();
        let width = self.width;
        let sign = move |v: f64| libm::tanh(v / width);
        match variable {
            Variable::Position(i) => {
                for k in WAVES {
                    functions.push(Box::new(move |x, _| libm::sin(k * x)));
                    functions.push(Box::new(move |x, _| libm::cos(k * x)));
                    functions.push(Box::new(move |x, v| v * libm::sin(k * x)));
                    functions.push(Box::new(move |x, v| v * libm::cos(k * x)));
                    functions.push(Box::new(move |x, v| sign(v) * libm::sin(k * x)));
                    functions.push(Box::new(move |x, v| sign(v) * libm::cos(k * x)));
                }
                let (low, high) = self.range_of(&Variable::Position(*i));
                let hats = (((high - low) / 0.1) as usize).clamp(6, 24);
                for h in 0..=hats {
                    functions.push(Box::new(move |x, _| hat(x, low, high, h, hats)));
                }
                for h in 0..=12 {
                    functions.push(Box::new(move |x, v| sign(v) * hat(x, low, high, h, 12)));
                }
            }
            Variable::Speed(_) => {
                functions.push(Box::new(|x, _| x * x.abs()));
                functions.push(Box::new(|x, _| x * x * x));
                functions.push(Box::new(|x, _| x.abs()));
                functions.push(Box::new(move |x, _| sign(x)));
                functions.push(Box::new(|x, _| x));
                functions.push(Box::new(move |x, v| x * sign(v)));
            }
            Variable::Acceleration(_) => {
                functions.push(Box::new(|x, _| x));
                functions.push(Box::new(|x, _| x.abs()));
                functions.push(Box::new(move |x, v| x * sign(v)));
            }
            Variable::Time | Variable::Channel(_) => {
                let (low, high) = self.range_of(variable);
                let unit = move |x: f64| (x - low) / (high - low).max(1e-12) - 0.5;
                for power in 1..=3 {
                    functions.push(Box::new(move |x, _| unit(x).powi(power)));
                    functions.push(Box::new(move |x, v| sign(v) * unit(x).powi(power)));
                }
                functions.push(Box::new(move |x, v| v * unit(x)));
            }
        }
        functions
            .iter()
            .map(|f| {
                let rows = self.data.rows_of(|run, out| {
                    let (x, v) = (variable.of(run), run.friction_dq(j));
                    for (k, y) in out.iter_mut().enumerate() {
                        *y = f(x.at(k), v[k]);
                    }
                });
                Arc::new(Column::of(j, rows))
            })
            .collect()
    }

    fn range_of(&self, variable: &Variable) -> (f64, f64) {
        self.data
            .runs
            .iter()
            .map(|run| variable.of(run).range())
            .fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), (c, d)| (a.min(c), b.max(d)))
    }

    /// The formula that explains most, over the variables given and always over the joint's own position.
    pub fn formula(&self, variables: &[String]) -> Result<Option<Proposal>> {
        let mut names: Vec<String> = variables.iter().take(3).cloned().collect();
        let own = format!("q{}", self.joint + 1);
        if !names.contains(&own) {
            names.push(own);
        }
        let families: Vec<Vec<Formula>> = names.iter().flat_map(|name| self.families(name)).collect();
        let scored: Vec<Proposal> = families
            .into_par_iter()
            .map(|family| self.score_family(family))
            .collect::<Result<Vec<_>>>()?
            .into_iter()
            .flatten()
            .collect();
        Ok(scored.into_iter().reduce(|best, next| if next.part > best.part { next } else { best }))
    }

    fn score_family(&self, family: Vec<Formula>) -> Result<Option<Proposal>> {
        let columns = |f: &Formula| -> Result<Vec<Arc<Column>>> {
            Ok(self.data.candidate_columns(f)?.into_iter().map(Arc::new).collect())
        };
        let alternatives = family.iter().map(columns).collect::<Result<Vec<_>>>()?;
        let projection = Projection::new(self.data, self.present, alternatives, 0.0);
        let Some(score) = projection.score(self.data, self.present, self.response) else { return Ok(None) };
        let formula = family[score.alternative].clone();
        Ok(Some(Proposal { formula, part: self.part(&score), score }))
    }

    /// Families of formulas over one variable: the same shape with its grid of places and widths.
    fn families(&self, name: &str) -> Vec<Vec<Formula>> {
        let Some(variable) = Variable::named(name) else { return Vec::new() };
        let (low, high) = self.range_of(&variable);
        let inner = |part: f64| low + part * (high - low);
        let places: Vec<f64> =
            (0..PLACES).map(|k| inner(0.05 + 0.9 * k as f64 / (PLACES - 1) as f64)).collect();
        let each = |f: &dyn Fn(f64) -> Curve| -> Vec<Curve> { places.iter().map(|&a| f(a)).collect() };
        let wide = |f: &dyn Fn(f64, f64) -> Curve| -> Vec<Curve> {
            places.iter().flat_map(|&a| BUMPS.iter().map(move |&w| (a, w))).map(|(a, w)| f(a, w)).collect()
        };
        let mut curves: Vec<Vec<Curve>> = vec![vec![Curve::Linear], vec![Curve::Square]];
        match variable {
            Variable::Position(_) => {
                curves.push((1..=12).map(|k| Curve::Wave { k: 0.5 + 0.5 * f64::from(k) }).collect());
                curves.push(each(&|a| Curve::Above { a }));
                curves.push(each(&|a| Curve::Below { a }));
                curves.push(each(&|a| Curve::Step { a }));
                curves.push(wide(&|a, w| Curve::Bump { a, w }));
                curves.push(wide(&|a, w| Curve::Detent { a, w }));
            }
            Variable::Speed(_) | Variable::Acceleration(_) => {
                curves.extend([vec![Curve::Size], vec![Curve::SignedSquare], vec![Curve::Sign]]);
            }
            Variable::Time | Variable::Channel(_) => curves.push(each(&|a| Curve::Step { a })),
        }
        let joint = &self.data.robot.joints[self.joint].name;
        let formula = |own: Own, shape: Curve| Formula {
            joint: joint.clone(),
            own,
            variable: name.to_string(),
            shape,
            width: self.width,
        };
        [Own::One, Own::Speed, Own::Sign]
            .into_iter()
            .flat_map(|own| curves.iter().map(move |family| (own, family)))
            .map(|(own, family)| family.iter().map(|&curve| formula(own, curve)).collect())
            .collect()
    }
}

/// What a joint's error may depend on.
#[derive(Debug, Clone)]
enum Variable {
    Position(usize),
    Speed(usize),
    Acceleration(usize),
    Time,
    Channel(String),
}

/// A variable at every sample of a run.
enum Values<'a> {
    Column(&'a [f64]),
    Clock { dt: f64, count: usize },
}

impl Values<'_> {
    fn at(&self, k: usize) -> f64 {
        match self {
            Self::Column(c) => c[k],
            Self::Clock { dt, .. } => k as f64 * dt,
        }
    }

    fn range(&self) -> (f64, f64) {
        match self {
            Self::Column(c) => range(c),
            Self::Clock { dt, count } => (0.0, *count as f64 * dt),
        }
    }
}

impl Variable {
    fn named(name: &str) -> Option<Self> {
        let number = |prefix: &str| name.strip_prefix(prefix)?.parse::<usize>().ok()?.checked_sub(1);
        Some(match (number("ddq"), number("dq"), number("q")) {
            (Some(i), _, _) => Self::Acceleration(i),
            (_, Some(i), _) => Self::Speed(i),
            (_, _, Some(i)) => Self::Position(i),
            _ if name == "time" => Self::Time,
            _ => Self::Channel(name.to_string()),
        })
    }

    fn of<'a>(&self, run: &'a Run) -> Values<'a> {
        match self {
            Self::Position(i) => Values::Column(&run.q[*i]),
            Self::Speed(i) => Values::Column(run.friction_dq(*i)),
            Self::Acceleration(i) => Values::Column(&run.ddq[*i]),
            Self::Time => Values::Clock { dt: run.dt, count: run.samples() },
            Self::Channel(name) => Values::Column(run.channels.get(name).map_or(&[], Vec::as_slice)),
        }
    }
}

fn range(values: &[f64]) -> (f64, f64) {
    values.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(*x), b.max(*x)))
}

/// Linear spline number `h` of `count` over a range.
fn hat(x: f64, low: f64, high: f64, h: usize, count: usize) -> f64 {
    let at = (x - low) / (high - low).max(1e-12) * count as f64;
    (1.0 - (at - h as f64).abs()).max(0.0)
}
