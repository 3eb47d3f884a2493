//! Expressions as a flat list of instructions: value forwards, exact gradient backwards. Plain data, shared
//! by all threads; the interpreter is not needed any more.

use std::cell::RefCell;

use nalgebra::{DMatrix, SymmetricEigen};

use super::budget::{Clock, Halt};
use super::elementary::Function;
use super::graph::{Graph, Id, Op};
use crate::form::{Affine, General};

/// One step; numbers are places of earlier steps.
#[derive(Debug, Clone)]
enum Step {
    Affine(Affine),
    Add(usize, usize),
    Mul(usize, usize),
    Div(usize, usize),
    Least(usize, usize),
    Greatest(usize, usize),
    Apply(Function, usize),
    Power(usize, usize),
    Norm(Box<[usize]>),
    Eigenvalue { lower: Box<[usize]>, size: usize, which: usize },
    Choose { test: usize, yes: usize, no: usize },
}

/// A margin that no cone expresses.
#[derive(Debug)]
pub(super) struct Program {
    steps: Vec<Step>,
    support: Vec<usize>,
}

/// Steps between looks whether a script may go on.
const STEPS_AT_ONCE: usize = 1024;

thread_local! {
    /// Values and slopes of the steps, kept so that an evaluation allocates nothing.
    static SCRATCH: RefCell<(Vec<f64>, Vec<f64>)> = const { RefCell::new((Vec::new(), Vec::new())) };
}

/// The nodes an operation is made from.
pub(super) fn children(op: &Op) -> Vec<Id> {
    match op {
        Op::Affine(..) => Vec::new(),
        Op::Add(a, b)
        | Op::Mul(a, b)
        | Op::Div(a, b)
        | Op::Least(a, b)
        | Op::Greatest(a, b)
        | Op::Power(a, b) => vec![*a, *b],
        Op::Apply(_, a) => vec![*a],
        Op::Norm(rows) => rows.to_vec(),
        Op::Eigenvalue { lower, .. } => lower.to_vec(),
        Op::Choose { test, yes, no } => vec![*test, *yes, *no],
    }
}

/// The steps that compute `roots`, and their places among them.
fn flatten(graph: &Graph, roots: &[Id]) -> (Vec<Step>, Vec<usize>) {
    let count = roots.iter().map(|id| id.0 as usize + 1).max().unwrap_or(0);
    let mut needed = vec![false; count];
    roots.iter().for_each(|id| needed[id.0 as usize] = true);
    for i in (0..needed.len()).rev() {
        // The parts of an affine expression are known as a whole.
        if needed[i] && graph.nodes[i].affine.is_none() {
            let below = children(&graph.nodes[i].op);
            below.into_iter().for_each(|c| needed[c.0 as usize] = true);
        }
    }
    let mut place = vec![usize::MAX; needed.len()];
    let mut steps = Vec::new();
    for i in (0..needed.len()).filter(|&i| needed[i]) {
        place[i] = steps.len();
        let node = &graph.nodes[i];
        steps.push(match &node.affine {
            Some(row) => Step::Affine(row.clone()),
            None => Step::new(&node.op, |id| place[id.0 as usize]),
        });
    }
    (steps, roots.iter().map(|id| place[id.0 as usize]).collect())
}

/// What steps take \[bytes\].
fn size(steps: &[Step]) -> usize {
    let inside = |step: &Step| match step {
        Step::Affine(row) => size_of::<(usize, f64)>() * row.terms.len(),
        Step::Norm(all) | Step::Eigenvalue { lower: all, .. } => size_of::<usize>() * all.len(),
        _ => 0,
    };
    steps.iter().map(|step| size_of::<Step>() + inside(step)).sum()
}

/// Several values at once, in one pass and without gradients.
#[derive(Debug, Clone, Default)]
pub(super) struct Flow {
    steps: Vec<Step>,
    outputs: Vec<usize>,
}

impl Flow {
    /// The steps that compute `roots`.
    pub(super) fn new(graph: &Graph, roots: &[Id]) -> Self {
        let (steps, outputs) = flatten(graph, roots);
        Self { steps, outputs }
    }

    /// What it takes \[bytes\].
    pub(super) fn size(&self) -> usize {
        size(&self.steps)
    }

    /// The roots' values at `z`, into `out`; `values` is room to work in. Says so where `clock` ends it.
    pub(super) fn run(
        &self,
        z: &[f64],
        values: &mut Vec<f64>,
        out: &mut [f64],
        clock: &mut Clock<'_>,
    ) -> Result<(), Halt> {
        values.clear();
        for some in self.steps.chunks(STEPS_AT_ONCE) {
            clock.tick(some.len())?;
            for step in some {
                let value = step.value(z, values);
                values.push(value);
            }
        }
        for (slot, &place) in out.iter_mut().zip(&self.outputs) {
            *slot = values[place];
        }
        Ok(())
    }
}

impl Program {
    /// The steps that compute `id`.
    pub(super) fn new(graph: &Graph, id: Id) -> Self {
        let (steps, _) = flatten(graph, &[id]);
        let mut support: Vec<usize> = steps
            .iter()
            .filter_map(|s| if let Step::Affine(row) = s { Some(row) } else { None })
            .flat_map(|row| row.terms.iter().map(|t| t.0))
            .collect();
        support.sort_unstable();
        support.dedup();
        Self { steps, support }
    }

    /// What it takes \[bytes\].
    pub(super) fn size(&self) -> usize {
        size(&self.steps) + size_of::<usize>() * self.support.len()
    }

    fn run(&self, z: &[f64], values: &mut Vec<f64>) -> f64 {
        values.clear();
        for step in &self.steps {
            let value = step.value(z, values);
            values.push(value);
        }
        values.last().copied().unwrap_or(f64::NAN)
    }

    fn sweep_back(&self, values: &[f64], slopes: &mut Vec<f64>) -> Vec<f64> {
        let mut gradient = vec![0.0; self.support.len()];
        slopes.clear();
        slopes.resize(values.len(), 0.0);
        if let Some(last) = slopes.last_mut() {
            *last = 1.0;
        }
        for (i, step) in self.steps.iter().enumerate().rev() {
            let slope = slopes[i];
            if slope == 0.0 {
                continue;
            }
            match step {
                Step::Affine(row) => {
                    for (index, factor) in &row.terms {
                        if let Ok(at) = self.support.binary_search(index) {
                            gradient[at] += slope * factor;
                        }
                    }
                }
                _ => step.pass_back(values[i], slope, values, slopes),
            }
        }
        gradient
    }
}

impl General for Program {
    fn support(&self) -> Vec<usize> {
        self.support.clone()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        SCRATCH.with_borrow_mut(|(values, _)| self.run(z, values))
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        SCRATCH.with_borrow_mut(|(values, slopes)| {
            let margin = self.run(z, values);
            (margin, self.sweep_back(values, slopes))
        })
    }
}

impl Step {
    fn new(op: &Op, at: impl Fn(Id) -> usize) -> Self {
        match op {
            // Affine nodes carry their value and never come here.
            Op::Affine(..) => Self::Affine(Affine::constant(f64::NAN)),
            Op::Add(a, b) => Self::Add(at(*a), at(*b)),
            Op::Mul(a, b) => Self::Mul(at(*a), at(*b)),
            Op::Div(a, b) => Self::Div(at(*a), at(*b)),
            Op::Least(a, b) => Self::Least(at(*a), at(*b)),
            Op::Greatest(a, b) => Self::Greatest(at(*a), at(*b)),
            Op::Apply(f, a) => Self::Apply(*f, at(*a)),
            Op::Power(a, b) => Self::Power(at(*a), at(*b)),
            Op::Norm(rows) => Self::Norm(rows.iter().map(|&r| at(r)).collect()),
            Op::Eigenvalue { lower, size, which } => {
                Self::Eigenvalue { lower: lower.iter().map(|&r| at(r)).collect(), size: *size, which: *which }
            }
            Op::Choose { test, yes, no } => Self::Choose { test: at(*test), yes: at(*yes), no: at(*no) },
        }
    }

    fn value(&self, z: &[f64], v: &[f64]) -> f64 {
        match self {
            Self::Affine(row) => row.at(z),
            Self::Add(a, b) => v[*a] + v[*b],
            Self::Mul(a, b) => v[*a] * v[*b],
            Self::Div(a, b) => v[*a] / v[*b],
            // Not `f64::min`, which would drop a value that is not a number.
            Self::Least(a, b) if v[*a].is_nan() || v[*b].is_nan() => f64::NAN,
            Self::Greatest(a, b) if v[*a].is_nan() || v[*b].is_nan() => f64::NAN,
            Self::Least(a, b) => v[*a].min(v[*b]),
            Self::Greatest(a, b) => v[*a].max(v[*b]),
            Self::Apply(f, a) => f.at(v[*a]),
            Self::Power(a, b) => libm::pow(v[*a], v[*b]),
            Self::Norm(rows) => rows.iter().map(|&r| v[r] * v[r]).sum::<f64>().sqrt(),
            Self::Eigenvalue { lower, size, which } => eigenpair(lower, *size, *which, v).0,
            Self::Choose { test, .. } if v[*test].is_nan() => f64::NAN,
            Self::Choose { test, yes, no } => v[if v[*test] >= 0.0 { *yes } else { *no }],
        }
    }

    /// Adds `slope` times the derivatives of this step to the slopes of what it is made from.
    fn pass_back(&self, value: f64, slope: f64, v: &[f64], slopes: &mut [f64]) {
        match self {
            Self::Affine(_) => {}
            Self::Add(a, b) => {
                slopes[*a] += slope;
                slopes[*b] += slope;
            }
            Self::Mul(a, b) => {
                slopes[*a] += slope * v[*b];
                slopes[*b] += slope * v[*a];
            }
            Self::Div(a, b) => {
                slopes[*a] += slope / v[*b];
                slopes[*b] -= slope * value / v[*b];
            }
            Self::Least(a, b) => slopes[if v[*a] <= v[*b] { *a } else { *b }] += slope,
            Self::Greatest(a, b) => slopes[if v[*a] >= v[*b] { *a } else { *b }] += slope,
            Self::Apply(f, a) => slopes[*a] += slope * f.slope(v[*a], value),
            Self::Power(a, b) => {
                slopes[*a] += slope * v[*b] * libm::pow(v[*a], v[*b] - 1.0);
                // Where the exponent is constant its slope goes nowhere, so a negative base does no harm.
                slopes[*b] += if v[*a] > 0.0 { slope * value * libm::log(v[*a]) } else { 0.0 };
            }
            Self::Norm(rows) if value > 0.0 => {
                rows.iter().for_each(|&r| slopes[r] += slope * v[r] / value);
            }
            Self::Norm(_) => {}
            Self::Eigenvalue { lower, size, which } => {
                let (_, x) = eigenpair(lower, *size, *which, v);
                for i in 0..*size {
                    for j in 0..=i {
                        let weight = if i == j { x[i] * x[j] } else { 2.0 * x[i] * x[j] };
                        slopes[lower[i * (i + 1) / 2 + j]] += slope * weight;
                    }
                }
            }
            Self::Choose { test, yes, no } => {
                slopes[if v[*test] >= 0.0 { *yes } else { *no }] += slope;
            }
        }
    }
}

/// Eigenvalue number `which` (ascending) and its unit vector.
pub(super) fn eigenpair(lower: &[usize], size: usize, which: usize, v: &[f64]) -> (f64, Vec<f64>) {
    let entry = |i: usize, j: usize| v[lower[i.max(j) * (i.max(j) + 1) / 2 + i.min(j)]];
    let matrix = DMatrix::from_fn(size, size, entry);
    if matrix.iter().any(|x| !x.is_finite()) {
        return (f64::NAN, vec![f64::NAN; size]);
    }
    let eigen = SymmetricEigen::new(matrix);
    let mut order: Vec<usize> = (0..size).collect();
    order.sort_by(|&a, &b| eigen.eigenvalues[a].total_cmp(&eigen.eigenvalues[b]));
    let at = order[which];
    (eigen.eigenvalues[at], eigen.eigenvectors.column(at).iter().copied().collect())
}
