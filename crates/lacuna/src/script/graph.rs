//! What a script computed, as expressions over the unknowns: equal expressions are one node, affine ones are
//! kept as such, and constants are folded.

use std::collections::HashMap;

use super::budget::{MOST_BYTES, TOO_LARGE};
use super::dimension::Dimension;
use super::elementary::Function;
use crate::form::Affine;

/// How deep factors are pushed into minima and sums.
const DEEPEST: usize = 12;
/// More nodes than this are refused: memory is limited.
const MOST_NODES: usize = 400_000;

/// What a node takes, wherever it is noted, in a table that has just grown \[bytes\].
const NODE: usize = 640;
/// What a term of a sum takes: twice as bits, once as a number, once as a cone \[bytes\].
const TERM: usize = 64;
/// What a place in a norm or a matrix takes \[bytes\].
const ENTRY: usize = 8;

/// A node of a [`Graph`]; children have smaller numbers.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash, PartialOrd, Ord)]
pub(super) struct Id(pub(super) u32);

/// Line and column in the script, from 1; 0 where there is none.
pub(super) type Spot = (usize, usize);

/// How a node is made from others.
#[derive(Debug, Clone, PartialEq, Eq, Hash)]
pub(super) enum Op {
    /// Terms by ascending index, and the constant; all as bits.
    Affine(Box<[(usize, u64)]>, u64),
    Add(Id, Id),
    Mul(Id, Id),
    Div(Id, Id),
    Least(Id, Id),
    Greatest(Id, Id),
    Apply(Function, Id),
    Power(Id, Id),
    Norm(Box<[Id]>),
    /// Eigenvalue number `which` (ascending) of the symmetric matrix with this lower triangle.
    Eigenvalue {
        lower: Box<[Id]>,
        size: usize,
        which: usize,
    },
    /// `yes` where `test >= 0`, else `no`.
    Choose {
        test: Id,
        yes: Id,
        no: Id,
    },
}

/// A node with what is known about it.
#[derive(Debug)]
pub(super) struct Node {
    pub(super) op: Op,
    pub(super) dimension: Option<Dimension>,
    /// Where it was first computed.
    pub(super) spot: Spot,
    /// Its value where that is affine.
    pub(super) affine: Option<Affine>,
}

/// All expressions of a script.
#[derive(Debug, Default)]
pub(super) struct Graph {
    pub(super) nodes: Vec<Node>,
    known: HashMap<(Op, Option<Dimension>), Id>,
    /// Unknowns that are masses, so that dividing by them is meant.
    masses: Vec<usize>,
    /// Where the script is.
    pub(super) here: Spot,
    /// What it takes \[bytes\].
    bytes: usize,
    /// What is kept of the script from before \[bytes\].
    kept: usize,
}

/// What a node takes \[bytes\].
fn size(op: &Op) -> usize {
    NODE + match op {
        Op::Affine(terms, _) => TERM * terms.len(),
        Op::Norm(all) | Op::Eigenvalue { lower: all, .. } => ENTRY * all.len(),
        _ => 0,
    }
}

impl Graph {
    /// Forgets all expressions.
    pub(super) fn clear(&mut self) {
        self.nodes.clear();
        self.known.clear();
        self.bytes = 0;
    }

    /// Counts what is kept of the script from before \[bytes\].
    pub(super) fn keep(&mut self, bytes: usize) {
        self.kept = bytes;
    }

    /// Counts what is about to be kept of the script, here or elsewhere \[bytes\].
    pub(super) fn charge(&mut self, bytes: usize) -> Result<(), String> {
        self.bytes = self.bytes.saturating_add(bytes);
        let all = self.bytes.saturating_add(self.kept);
        if all <= MOST_BYTES { Ok(()) } else { Err(TOO_LARGE.into()) }
    }

    pub(super) fn node(&self, id: Id) -> &Node {
        &self.nodes[id.0 as usize]
    }

    pub(super) fn affine(&self, id: Id) -> Option<&Affine> {
        self.node(id).affine.as_ref()
    }

    pub(super) fn dimension(&self, id: Id) -> Option<Dimension> {
        self.node(id).dimension
    }

    /// Its value where that does not depend on unknowns.
    pub(super) fn value(&self, id: Id) -> Option<f64> {
        self.affine(id).filter(|a| a.terms.is_empty()).map(|a| a.constant)
    }

    /// An affine quantity of the robot; `is_mass` where it is one unknown that is a mass.
    pub(super) fn quantity(
        &mut self,
        row: &Affine,
        dimension: Option<Dimension>,
        is_mass: bool,
    ) -> Result<Id, String> {
        if let (true, [(index, _)]) = (is_mass, row.terms.as_slice())
            && !self.masses.contains(index)
        {
            self.masses.push(*index);
        }
        self.push_affine(row.clone(), dimension)
    }

    /// A plain number.
    pub(super) fn constant(&mut self, value: f64) -> Result<Id, String> {
        self.push_affine(Affine::constant(value), None)
    }

    fn push_affine(&mut self, mut row: Affine, dimension: Option<Dimension>) -> Result<Id, String> {
        row.terms.retain(|t| t.1 != 0.0 || t.1.is_nan());
        row.terms.sort_unstable_by_key(|t| t.0);
        if !row.constant.is_finite() || row.terms.iter().any(|t| !t.1.is_finite()) {
            return Err("this is not a finite number".into());
        }
        // One zero only, so that equal expressions are one node.
        row.constant += 0.0;
        let terms = row.terms.iter().map(|&(i, f)| (i, f.to_bits())).collect();
        self.push(Op::Affine(terms, row.constant.to_bits()), dimension, Some(row))
    }

    fn push(&mut self, op: Op, dimension: Option<Dimension>, affine: Option<Affine>) -> Result<Id, String> {
        let key = (op, dimension);
        if let Some(&id) = self.known.get(&key) {
            return Ok(id);
        }
        if self.nodes.len() >= MOST_NODES {
            return Err(format!("the script builds more than {MOST_NODES} expressions"));
        }
        self.charge(size(&key.0))?;
        let id = Id(self.nodes.len() as u32);
        self.nodes.push(Node { op: key.0.clone(), dimension, spot: self.here, affine });
        self.known.insert(key, id);
        Ok(id)
    }

    /// 1 in the unit of `id`.
    pub(super) fn unit_of(&mut self, id: Id) -> Result<Id, String> {
        self.push_affine(Affine::constant(1.0), self.dimension(id))
    }

    pub(super) fn add(&mut self, a: Id, b: Id) -> Result<Id, String> {
        let dimension = Dimension::common(self.dimension(a), self.dimension(b))?;
        if let (Some(x), Some(y)) = (self.affine(a), self.affine(b)) {
            let sum = x.clone().plus(1.0, y);
            return self.push_affine(sum, dimension);
        }
        self.push(Op::Add(a.min(b), a.max(b)), dimension, None)
    }

    pub(super) fn negative(&mut self, a: Id) -> Result<Id, String> {
        self.scaled(-1.0, a, self.dimension(a), DEEPEST)
    }

    pub(super) fn subtract(&mut self, a: Id, b: Id) -> Result<Id, String> {
        let b = self.negative(b)?;
        self.add(a, b)
    }

    /// `factor * a`, pushed inside minima and maxima so that these stay visible.
    fn scaled(
        &mut self,
        factor: f64,
        a: Id,
        dimension: Option<Dimension>,
        depth: usize,
    ) -> Result<Id, String> {
        if let Some(row) = self.affine(a) {
            let row = row.clone().times(factor);
            return self.push_affine(row, dimension);
        }
        let op = self.node(a).op.clone();
        match op {
            Op::Least(x, y) | Op::Greatest(x, y) | Op::Add(x, y) if depth > 0 => {
                let x = self.scaled(factor, x, dimension, depth - 1)?;
                let y = self.scaled(factor, y, dimension, depth - 1)?;
                let (x, y) = (x.min(y), x.max(y));
                let scaled = match op {
                    Op::Add(..) => Op::Add(x, y),
                    Op::Least(..) if factor >= 0.0 => Op::Least(x, y),
                    Op::Greatest(..) if factor < 0.0 => Op::Least(x, y),
                    _ => Op::Greatest(x, y),
                };
                self.push(scaled, dimension, None)
            }
            Op::Mul(inner, x) if self.value(inner).is_some() => {
                let factor = factor * self.value(inner).unwrap_or(1.0);
                let factor = self.constant(factor)?;
                self.push(Op::Mul(factor, x), dimension, None)
            }
            _ => {
                let factor = self.constant(factor)?;
                self.push(Op::Mul(factor, a), dimension, None)
            }
        }
    }

    pub(super) fn multiply(&mut self, a: Id, b: Id) -> Result<Id, String> {
        let dimension = Dimension::product(self.dimension(a), self.dimension(b), 1);
        match (self.value(a), self.value(b)) {
            (Some(factor), _) => self.scaled(factor, b, dimension, DEEPEST),
            (_, Some(factor)) => self.scaled(factor, a, dimension, DEEPEST),
            // A mean times its mass is the moment again: centre of mass times mass.
            _ => match self.undivided(a, b).or_else(|| self.undivided(b, a)) {
                Some(row) => self.push_affine(row, dimension),
                None => self.push(Op::Mul(a.min(b), a.max(b)), dimension, None),
            },
        }
    }

    fn undivided(&self, quotient: Id, mass: Id) -> Option<Affine> {
        let Op::Div(above, below) = self.node(quotient).op else { return None };
        let Op::Apply(Function::Floor, divisor) = self.node(below).op else { return None };
        (self.affine(divisor).is_some() && self.affine(divisor) == self.affine(mass))
            .then(|| self.affine(above).cloned())
            .flatten()
    }

    pub(super) fn divide(&mut self, a: Id, b: Id) -> Result<Id, String> {
        let dimension = Dimension::product(self.dimension(a), self.dimension(b), -1);
        if let Some(divisor) = self.value(b) {
            if divisor.abs() < f64::MIN_POSITIVE {
                return Err("division by zero".into());
            }
            if let Some(row) = self.affine(a) {
                let mut row = row.clone();
                row.terms.iter_mut().for_each(|t| t.1 /= divisor);
                row.constant /= divisor;
                return self.push_affine(row, dimension);
            }
            return self.scaled(1.0 / divisor, a, dimension, DEEPEST);
        }
        let below = if self.is_mass(b) { self.apply(Function::Floor, b)? } else { b };
        self.push(Op::Div(a, below), dimension, None)
    }

    /// Whether it is a mass or a sum of masses with positive weights.
    fn is_mass(&self, id: Id) -> bool {
        self.affine(id).is_some_and(|row| {
            row.constant >= 0.0
                && !row.terms.is_empty()
                && row.terms.iter().all(|(i, f)| *f > 0.0 && self.masses.contains(i))
        })
    }

    pub(super) fn least(&mut self, a: Id, b: Id) -> Result<Id, String> {
        self.extreme(a, b, f64::min, Op::Least)
    }

    pub(super) fn greatest(&mut self, a: Id, b: Id) -> Result<Id, String> {
        self.extreme(a, b, f64::max, Op::Greatest)
    }

    fn extreme(
        &mut self,
        a: Id,
        b: Id,
        fold: fn(f64, f64) -> f64,
        op: fn(Id, Id) -> Op,
    ) -> Result<Id, String> {
        let dimension = Dimension::common(self.dimension(a), self.dimension(b))?;
        if let (Some(x), Some(y)) = (self.value(a), self.value(b)) {
            return self.push_affine(Affine::constant(fold(x, y)), dimension);
        }
        if a == b { Ok(a) } else { self.push(op(a.min(b), a.max(b)), dimension, None) }
    }

    pub(super) fn magnitude(&mut self, a: Id) -> Result<Id, String> {
        let other = self.negative(a)?;
        self.greatest(a, other)
    }

    /// 1, 0 or -1.
    pub(super) fn sign(&mut self, a: Id) -> Result<Id, String> {
        let (up, none, down) = (self.constant(1.0)?, self.constant(0.0)?, self.constant(-1.0)?);
        if let Some(x) = self.value(a) {
            return Ok(if x > 0.0 {
                up
            } else if x < 0.0 {
                down
            } else {
                none
            });
        }
        let other = self.negative(a)?;
        let not_up = self.choose(other, none, up)?;
        self.choose(a, not_up, down)
    }

    pub(super) fn apply(&mut self, function: Function, a: Id) -> Result<Id, String> {
        let given = self.dimension(a);
        let dimension = match function {
            Function::Sqrt => given.map(Dimension::root),
            Function::Floor => given,
            _ => match given.filter(|d| d.is_surely_not_plain()) {
                Some(unit) => return Err(format!("{} of a quantity in {unit}", function.name())),
                None => None,
            },
        };
        match self.value(a) {
            Some(x) => {
                let value = function.at(x);
                if !value.is_finite() {
                    return Err(format!("{}({x}) is not a finite number", function.name()));
                }
                self.push_affine(Affine::constant(value), dimension)
            }
            None => self.push(Op::Apply(function, a), dimension, None),
        }
    }

    pub(super) fn power(&mut self, a: Id, b: Id) -> Result<Id, String> {
        match (self.value(a), self.value(b)) {
            (Some(x), Some(y)) => self.constant(libm::pow(x, y)),
            (None, Some(2.0)) => self.multiply(a, a),
            (None, Some(1.0)) => Ok(a),
            (None, Some(0.5)) => self.apply(Function::Sqrt, a),
            _ => self.push(Op::Power(a, b), None, None),
        }
    }

    fn common_dimension(&self, ids: &[Id]) -> Result<Option<Dimension>, String> {
        ids.iter().try_fold(None, |sum, &id| Dimension::common(sum, self.dimension(id)))
    }

    pub(super) fn norm(&mut self, rows: &[Id]) -> Result<Id, String> {
        let dimension = self.common_dimension(rows)?;
        let values: Option<Vec<f64>> = rows.iter().map(|&r| self.value(r)).collect();
        match values {
            Some(values) => {
                let squares: f64 = values.iter().map(|v| v * v).sum();
                self.push_affine(Affine::constant(squares.sqrt()), dimension)
            }
            None => self.push(Op::Norm(rows.into()), dimension, None),
        }
    }

    pub(super) fn eigenvalue(&mut self, lower: &[Id], size: usize, which: usize) -> Result<Id, String> {
        // Pseudo-inertias mix units, so entries need not agree.
        let dimension = self.common_dimension(lower).unwrap_or(None);
        let values: Option<Vec<f64>> = lower.iter().map(|&id| self.value(id)).collect();
        if let Some(values) = values {
            let places: Vec<usize> = (0..values.len()).collect();
            let value = super::program::eigenpair(&places, size, which, &values).0;
            return self.push_affine(Affine::constant(value), dimension);
        }
        self.push(Op::Eigenvalue { lower: lower.into(), size, which }, dimension, None)
    }

    pub(super) fn choose(&mut self, test: Id, yes: Id, no: Id) -> Result<Id, String> {
        if yes == no {
            return Ok(yes);
        }
        let dimension = Dimension::common(self.dimension(yes), self.dimension(no)).unwrap_or(None);
        self.push(Op::Choose { test, yes, no }, dimension, None)
    }
}
