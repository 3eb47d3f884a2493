//! What may be missing: every effect of the catalogue on every joint, with a grid for its nonlinear parameters.

use std::sync::Arc;

use rayon::prelude::*;

use super::data::{Column, Data};
use crate::effects::{CATALOGUE, Effect, Stage};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// One effect on one joint (or on the whole robot) that may be missing.
#[derive(Debug, Clone)]
pub(super) struct Candidate {
    pub effect: Box<dyn Effect>,
    /// The joint it acts on, where it is one.
    pub joint: Option<usize>,
    /// What tells it from the same effect elsewhere.
    pub identity: Identity,
    /// Place in the catalogue: the simpler of two equally good explanations wins.
    pub order: usize,
    /// The effect with every combination of trial values.
    pub alternatives: Vec<Box<dyn Effect>>,
    /// Columns of every alternative; empty until they are asked for.
    pub columns: Vec<Vec<Arc<Column>>>,
    /// Why there are none.
    pub trouble: Option<Error>,
}

impl Candidate {
    /// A candidate with its grid of nonlinear parameters.
    pub fn new(robot: &Robot, effect: Box<dyn Effect>, order: usize, widths: &[f64]) -> Result<Self> {
        let joint = local_joint(effect.as_ref(), robot)?;
        let whose = effect.sign_of(robot)?.or(joint);
        let effect = whose.map_or_else(|| effect.clone(), |j| effect.with_width(widths[j]));
        let alternatives = grid(effect.as_ref());
        let identity = Identity::of(effect.as_ref(), robot)?;
        Ok(Self { effect, joint, identity, order, alternatives, columns: Vec::new(), trouble: None })
    }

    /// Name of the effect.
    pub fn name(&self) -> &'static str {
        self.effect.about().name
    }

    /// Whether it belongs to plain friction, which is taken first.
    pub fn is_plain(&self) -> bool {
        self.effect.about().stage == Stage::First
    }

    /// Computes the columns; none where the data lack what the effect needs (a temperature, say).
    fn fill(&mut self, data: &Data) {
        let effects: Vec<&dyn Effect> = self.alternatives.iter().map(AsRef::as_ref).collect();
        let shared = |columns: Vec<Column>| columns.into_iter().map(Arc::new).collect();
        (self.columns, self.trouble) = match data.candidate_columns_of_each(&effects) {
            Ok(all) => (all.into_iter().map(shared).collect(), None),
            Err(trouble) => (Vec::new(), Some(trouble)),
        };
    }
}

/// Which effect, on which joint, with which parameters.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Identity {
    pub name: &'static str,
    symbols: Vec<String>,
    /// The joint it is called after: the only one it acts on, or the one it belongs to.
    pub joint: Option<usize>,
}

impl Identity {
    pub fn of(effect: &dyn Effect, robot: &Robot) -> Result<Self> {
        let symbols = effect.terms(robot)?.into_iter().map(|t| t.symbol).collect();
        let joint = local_joint(effect, robot)?.or(effect.belongs_to(robot)?);
        Ok(Self { name: effect.about().name, symbols, joint })
    }

    /// Whether this has every parameter of `other`.
    pub fn covers(&self, other: &Self) -> bool {
        self.name == other.name && other.symbols.iter().all(|s| self.symbols.contains(s))
    }
}

/// The joint an effect acts on, where all its parameters act on the same one.
pub(super) fn local_joint(effect: &dyn Effect, robot: &Robot) -> Result<Option<usize>> {
    let terms = effect.terms(robot)?;
    let first = terms.first().and_then(|t| t.joints.first().copied());
    Ok(first.filter(|j| terms.iter().all(|t| t.joints == [*j])))
}

/// All combinations of the trial values of an effect's shapes.
fn grid(effect: &dyn Effect) -> Vec<Box<dyn Effect>> {
    let mut all = vec![Vec::new()];
    for shape in effect.shapes() {
        all = all
            .into_iter()
            .flat_map(|values: Vec<f64>| {
                shape.trials.iter().map(move |t| [values.as_slice(), &[*t]].concat())
            })
            .collect();
    }
    all.iter().map(|values| effect.with_shapes(values)).collect()
}

/// The catalogue on this robot, and `extra` effects after it.
pub(super) fn catalogue(data: &Data, widths: &[f64], extra: &[Box<dyn Effect>]) -> Result<Vec<Candidate>> {
    let mut all = Vec::new();
    for (order, entry) in CATALOGUE.iter().enumerate() {
        for effect in (entry.candidates)(&data.robot) {
            all.push(Candidate::new(&data.robot, effect, order, widths)?);
        }
    }
    for effect in extra {
        for one in effect.one_by_one(&data.robot)? {
            all.push(Candidate::new(&data.robot, one, CATALOGUE.len(), widths)?);
        }
    }
    // Nothing can be said of a joint that never moves, or whose torque is no measurement.
    all.retain(|c| c.joint.is_none_or(|j| !data.still[j] && !data.silent[j]));
    Ok(all)
}

/// Computes the columns of all candidates: of all, or of those that depend on the model's own torque.
///
/// # Errors
/// When the work is stopped, or a script has used up what it may: that is no reason to go on without it.
pub(super) fn fill(candidates: &mut [Candidate], data: &Data, only_model_dependent: bool) -> Result<()> {
    candidates
        .par_iter_mut()
        .filter(|c| c.columns.is_empty() || !only_model_dependent || c.effect.needs_torque())
        .for_each(|candidate| candidate.fill(data));
    let ending = candidates.iter().filter_map(|c| c.trouble.as_ref()).find(|t| t.ends_work());
    ending.map_or(Ok(()), |trouble| Err(trouble.clone()))
}
