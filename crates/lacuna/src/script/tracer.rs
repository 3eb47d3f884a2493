//! What flows through a running script: numbers that remember how they were made, and the relations stated
//! between them.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::rc::Rc;

use rhai::{Dynamic, EvalAltResult, NativeCallContext, Position};

use super::dimension::Dimension;
use super::graph::{Graph, Id, Spot};
use crate::error::Error;
use crate::form::Affine;

/// More decisions than this on one way through a script are refused.
const MOST_DECISIONS: usize = 64;

/// What a relation takes with its place in the list of all \[bytes\].
const RELATION: usize = 512;

/// Result of a function that scripts call.
pub(super) type Answer<T> = Result<T, Box<EvalAltResult>>;

/// The state all functions of one engine share.
pub(super) type Shared = Rc<RefCell<Tracer>>;

/// A number that may depend on unknowns.
#[derive(Debug, Clone, Copy)]
pub(super) struct Number(pub(super) Id);

/// Several of them.
#[derive(Debug, Clone)]
pub(super) struct Vector(pub(super) Rc<[Id]>);

/// A symmetric matrix of them: lower triangle by rows.
#[derive(Debug, Clone)]
pub(super) struct Matrix {
    pub(super) size: usize,
    pub(super) lower: Rc<[Id]>,
}

impl Matrix {
    pub(super) fn at(&self, i: usize, j: usize) -> Option<Id> {
        let (i, j) = (i.max(j), i.min(j));
        (i < self.size).then(|| self.lower[i * (i + 1) / 2 + j])
    }
}

/// What a relation demands.
#[derive(Debug, Clone, PartialEq)]
pub(super) enum Demand {
    /// Not negative.
    Margin(Id),
    /// Zero.
    Zero(Id),
    /// Positive semidefinite.
    Psd { lower: Rc<[Id]>, size: usize },
}

/// A relation that the script states.
#[derive(Debug, Clone)]
pub(super) struct Relation {
    pub(super) demand: Demand,
    pub(super) label: Option<String>,
    pub(super) unit: Option<String>,
    pub(super) scale: f64,
    pub(super) spot: Spot,
    /// Which of the relations of this run it is.
    pub(super) serial: usize,
    /// What `holds` asks: the node is not negative, or (`false`) negative.
    pub(super) test: Option<(Id, bool)>,
}

/// Shared state: the expressions, and which way the script is sent where it compares unknowns.
#[derive(Debug, Default)]
pub(super) struct Tracer {
    pub(super) graph: Graph,
    /// Names of the unknowns.
    pub(super) names: Vec<String>,
    /// Answers for the first decisions of this run; further ones are `true`.
    pub(super) plan: Vec<bool>,
    /// Decisions of this run: is the node not negative?
    pub(super) taken: Vec<(Id, bool)>,
    /// Unknowns to compute with instead of tracing, for the interpreter as oracle.
    point: Option<Vec<f64>>,
    /// Relations of this run that nothing has used yet, and where they were stated.
    open: BTreeMap<usize, Spot>,
    stated: usize,
    /// Where numbers without unknowns were compared last.
    pub(super) plain: Option<Spot>,
}

impl Tracer {
    /// The node of a number, plain or not; `None` for anything else.
    pub(super) fn operand(&mut self, value: &Dynamic) -> Option<Result<Id, String>> {
        if let Some(number) = value.read_lock::<Number>() {
            return Some(Ok(number.0));
        }
        if let Ok(plain) = value.as_float() {
            return Some(self.graph.constant(plain));
        }
        value.as_int().ok().map(|whole| self.graph.constant(whole as f64))
    }

    /// Which way the run goes: is `node` not negative?
    pub(super) fn decide(&mut self, node: Id) -> Result<bool, String> {
        if let Some(value) = self.graph.value(node) {
            return Ok(value >= 0.0);
        }
        if let Some((_, earlier)) = self.taken.iter().find(|(known, _)| *known == node) {
            return Ok(*earlier);
        }
        if self.taken.len() >= MOST_DECISIONS {
            return Err(format!(
                "the script compares unknowns more than {MOST_DECISIONS} times on one way through: write \
                 `constrain_link`, which is asked link by link, or use `min`, `max`, `any_of`"
            ));
        }
        let answer = self.plan.get(self.taken.len()).copied().unwrap_or(true);
        self.taken.push((node, answer));
        Ok(answer)
    }

    /// A number for the script: plain where it depends on nothing.
    pub(super) fn give(&self, id: Id) -> Dynamic {
        match self.graph.value(id).filter(|_| self.graph.dimension(id).is_none() && self.point.is_none()) {
            Some(value) => Dynamic::from_float(value),
            None => Dynamic::from(Number(id)),
        }
    }

    /// Begins a run that takes the decisions of `plan`.
    pub(super) fn restart(&mut self, plan: Vec<bool>) {
        (self.plan, self.plain, self.stated) = (plan, None, 0);
        self.taken.clear();
        self.open.clear();
    }

    /// Begins a run at a point.
    pub(super) fn restart_at(&mut self, z: &[f64]) {
        self.restart(Vec::new());
        self.graph.clear();
        self.point = Some(z.to_vec());
    }

    /// Whether numbers are values at a point.
    pub(super) fn is_at_point(&self) -> bool {
        self.point.is_some()
    }

    /// Margin of a relation in a run at a point.
    pub(super) fn margin_at_point(&mut self, relation: &Relation) -> Result<f64, Error> {
        let id = match &relation.demand {
            Demand::Margin(id) => Ok(*id),
            Demand::Zero(id) => self.graph.magnitude(*id).and_then(|size| self.graph.negative(size)),
            Demand::Psd { lower, size } => self.graph.eigenvalue(lower, *size, 0),
        };
        let value = id.map(|id| self.graph.value(id)).map_err(Error::new)?;
        value.ok_or_else(|| Error::new("a margin has no value at this point"))
    }

    /// A quantity of the robot.
    pub(super) fn quantity(
        &mut self,
        row: &Affine,
        unit: Option<Dimension>,
        is_mass: bool,
    ) -> Result<Id, String> {
        match &self.point {
            Some(z) => {
                let value = row.at(z);
                self.graph.quantity(&Affine::constant(value), unit, false)
            }
            None => self.graph.quantity(row, unit, is_mass),
        }
    }

    /// A new relation, stated where the script is.
    pub(super) fn relation(&mut self, demand: Demand) -> Relation {
        self.stated += 1;
        // Where this is too much, whatever comes next says so.
        let _ = self.graph.charge(RELATION);
        let (spot, serial) = (self.graph.here, self.stated);
        self.open.insert(serial, spot);
        Relation { demand, label: None, unit: None, scale: 1.0, spot, serial, test: None }
    }

    /// Notes that a relation was not stated in vain.
    pub(super) fn use_up(&mut self, relation: &Relation) {
        self.open.remove(&relation.serial);
    }

    /// Where the first relation stands that nothing used.
    pub(super) fn unused(&self) -> Option<Spot> {
        self.open.values().next().copied()
    }

    /// Notes where the script is.
    pub(super) fn stand(&mut self, context: &NativeCallContext) {
        self.graph.here = spot(context.call_position());
    }
}

/// Line and column of a position; 0 where there is none.
pub(super) fn spot(position: Position) -> Spot {
    (position.line().unwrap_or(0), position.position().unwrap_or(0))
}

/// An error of a script function; the interpreter adds where it was called.
pub(super) fn fail(what: impl Into<String>) -> Box<EvalAltResult> {
    EvalAltResult::ErrorRuntime(what.into().into(), Position::NONE).into()
}

/// What people call the type of a value.
pub(super) fn kind(value: &Dynamic) -> &'static str {
    if value.is::<Number>() || value.is_float() || value.is_int() {
        "a number"
    } else if value.is::<Vector>() {
        "a vector"
    } else if value.is::<Matrix>() {
        "a matrix"
    } else if value.is::<Relation>() {
        "a relation"
    } else if value.is::<super::subject::LinkView>() {
        "a link"
    } else if value.is::<super::subject::RobotView>() {
        "the robot"
    } else if value.is::<super::effect::JointView>() {
        "a joint"
    } else if value.is::<super::effect::Moment>() {
        "a moment of the motion"
    } else if value.is_bool() {
        "true or false"
    } else if value.is_string() {
        "a text"
    } else if value.is_array() {
        "a list"
    } else if value.is_map() {
        "a map"
    } else if value.is_unit() {
        "nothing"
    } else {
        "something else"
    }
}
