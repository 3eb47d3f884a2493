//! What no effect of the catalogue explains: on which variable a joint's error depends, and a formula that fits.

mod families;
mod groups;
mod variable;

use std::sync::Arc;

use rayon::prelude::*;

use self::groups::Group;
use self::variable::Variable;
use super::data::{Column, Data};
use super::gates::flipped;
use super::present::{Present, Response};
use super::score::{Projection, Ridge, Score};
use crate::effects::{Curve, Formula};
use crate::error::Result;
use crate::random::Stream;

/// Variables over which formulas are tried, beside the joint's own position.
const LIKELY: usize = 3;
/// Something that comes and goes with time must explain this part of the joint's error, and this many times what
/// anything else does: a clock is what remains when no cause is found.
const OF_TIME: [f64; 2] = [0.4, 1.25];

/// Flexible columns of one variable, or two, scored on one joint.
pub(super) struct Dependence {
    pub variables: Vec<String>,
    pub score: Score,
    /// Part of the joint's held-out squared error that it explains.
    pub part: f64,
}

/// A formula with its score.
pub(super) struct Proposal {
    /// The joint whose error it explains.
    pub joint: usize,
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
    /// Whether torque ripple of the joint may still be found.
    pub ripple_open: bool,
    /// Whether friction of the joint that depends on its position may still be found.
    pub friction_open: bool,
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

    /// Groups of flexible columns of every variable, beside the model.
    pub fn projections(&self) -> Vec<(Vec<String>, Projection)> {
        let variables = Variable::all(&self.data.runs, &self.data.still);
        self.beside(variables.par_iter().flat_map(|v| self.groups_of(v)).collect())
    }

    /// The two positions that together explain most. One pair after the other: there are many columns.
    pub fn two(&self) -> Option<Dependence> {
        let moving: Vec<usize> = (0..self.data.dof()).filter(|&j| !self.data.still[j]).collect();
        let pairs = moving.iter().flat_map(|&a| moving.iter().filter(move |b| a < **b).map(move |&b| (a, b)));
        let strongest = |(a, b)| {
            let groups = self.beside(self.groups_of_two(a, b));
            self.scored(&groups, self.response).into_iter().next()
        };
        pairs.filter_map(strongest).reduce(|best, next| if next.part > best.part { next } else { best })
    }

    fn beside(&self, groups: Vec<Group>) -> Vec<(Vec<String>, Projection)> {
        let project = |Group { variables, columns, ridge }: Group| {
            (variables, Projection::new(self.data, self.present, vec![columns], ridge))
        };
        groups.into_par_iter().map(project).collect()
    }

    /// How much of a response depends on each variable, most first; the best group of each.
    pub fn scored(&self, groups: &[(Vec<String>, Projection)], response: &Response) -> Vec<Dependence> {
        let square: f64 = response.residual[self.joint].iter().map(|r| r * r).sum();
        let one = |(variables, projection): &(Vec<String>, Projection)| {
            let mut score = projection.score(self.data, self.present, response)?;
            let part = score.gain_of_joint[self.joint] / square.max(1e-300);
            // Nobody asks for its rows, and there are many.
            score.effect = Vec::new();
            Some(Dependence { variables: variables.clone(), part, score })
        };
        let mut all: Vec<Dependence> = groups.par_iter().filter_map(one).collect();
        all.sort_by(|a, b| b.part.total_cmp(&a.part));
        let mut known: Vec<Vec<String>> = Vec::new();
        all.retain(|d| {
            let new = !known.contains(&d.variables);
            known.push(d.variables.clone());
            new
        });
        all
    }

    /// The largest part of the joint's error that any variable explains by chance: residuals whose sign is drawn
    /// for every second have nothing to find.
    pub fn chance(&self, groups: &[(Vec<String>, Projection)], replicates: usize) -> f64 {
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

    /// The formula that explains most: over the variables that come first, the joint's own position, and time.
    pub fn formula(&self, first: &[Dependence]) -> Result<Option<Proposal>> {
        let mut likely: Vec<&str> =
            first.iter().take(LIKELY).filter_map(|d| d.variables.first()).map(String::as_str).collect();
        let own = Variable::Position(self.joint).name();
        likely.push(&own);
        let known = |v: &Variable| likely.contains(&v.name().as_str());
        let variables = Variable::all(&self.data.runs, &self.data.still);
        let mut families: Vec<Vec<Formula>> =
            variables.iter().filter(|v| known(v)).flat_map(|v| self.families(v)).collect();
        families.extend(self.clocks());
        let scored: Vec<Proposal> = families
            .into_par_iter()
            .map(|family| self.score_family(family))
            .collect::<Result<Vec<_>>>()?
            .into_iter()
            .flatten()
            .collect();
        let of_time =
            |p: &Proposal| p.formula.variable == "time" && matches!(p.formula.shape, Curve::Wave { .. });
        let (clocks, others): (Vec<Proposal>, Vec<Proposal>) = scored.into_iter().partition(of_time);
        let best = |all: Vec<Proposal>| {
            all.into_iter().reduce(|best, next| if next.part > best.part { next } else { best })
        };
        let (clock, other) = (best(clocks), best(others));
        let least = OF_TIME[0].max(OF_TIME[1] * other.as_ref().map_or(0.0, |o| o.part));
        Ok(clock.filter(|c| c.part >= least).or(other))
    }

    fn score_family(&self, family: Vec<Formula>) -> Result<Option<Proposal>> {
        let columns = |f: &Formula| -> Result<Vec<Arc<Column>>> {
            Ok(self.data.candidate_columns(f)?.into_iter().map(Arc::new).collect())
        };
        let alternatives = family.iter().map(columns).collect::<Result<Vec<_>>>()?;
        let projection = Projection::new(self.data, self.present, alternatives, Ridge::None);
        let Some(score) = projection.score(self.data, self.present, self.response) else { return Ok(None) };
        let formula = family[score.alternative].clone();
        Ok(Some(Proposal { joint: self.joint, formula, part: self.part(&score), score }))
    }
}
