//! A smooth function whose minimiser approaches the constrained one: objective plus barrier.

use nalgebra::DVector;

use super::bounds::Bounds;
use super::cholesky::dot;
use super::equalities::Equalities;
use super::terms::{LogSum, Scratch, Slopes, Term};
use crate::form::{Affine, Form};
use crate::{Chart, Quadratic};

/// How forms may be left.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Relaxation {
    /// Not at all; the start must hold them all.
    None,
    /// One slack for all, of any sign, is minimised: the search for a first point.
    Shared,
    /// One slack `s >= 0` per form, at a cost of `linear * s + square * s²` each: the exterior penalty.
    Each { linear: f64, square: f64 },
}

/// What is minimised, with its second derivative: shared by all programs over one problem.
#[derive(Debug, Clone)]
pub(super) struct Squares<'a> {
    objective: &'a Quadratic,
    /// `rᵀ r`, column by column.
    gram: Vec<f64>,
}

impl<'a> Squares<'a> {
    pub(super) fn new(objective: &'a Quadratic) -> Self {
        let columns: Vec<_> = objective.r.column_iter().collect();
        let entry = |a: usize, b: usize| dot(columns[a].as_slice(), columns[b].as_slice());
        let n = columns.len();
        Self { objective, gram: (0..n * n).map(|k| entry(k / n, k % n)).collect() }
    }

    fn unknowns(&self) -> usize {
        self.objective.r.ncols()
    }
}

/// Objective, forms, bounds; the unknowns are those of the problem, then the slacks.
pub(super) struct Program<'a> {
    squares: &'a Squares<'a>,
    chart: &'a dyn Chart,
    /// Those of the chart's bounds come first.
    terms: Vec<Term>,
    convex_bounds: usize,
    bounds: Vec<Bounds>,
    equalities: Equalities,
    relaxation: Relaxation,
    slacks: usize,
    degree: f64,
}

/// Room that evaluations share.
#[derive(Debug, Default)]
pub(super) struct Room {
    scratch: Scratch,
    coordinates: Vec<f64>,
}

impl<'a> Program<'a> {
    /// A program over `forms` and the bounds of a chart. Without slacks per form, opposite pairs of
    /// affine conditions become equations.
    pub(super) fn new(
        squares: &'a Squares<'a>,
        chart: &'a dyn Chart,
        forms: &[&Form],
        relaxation: Relaxation,
    ) -> Self {
        let n = squares.unknowns();
        let slack = |k: usize, form: &Form| match relaxation {
            Relaxation::None => None,
            Relaxation::Shared => Some((n, form.scale)),
            Relaxation::Each { .. } => Some((n + k, form.scale)),
        };
        let (mut terms, bounds) = Bounds::of(chart);
        let slacks = match relaxation {
            Relaxation::None => 0,
            Relaxation::Shared => 1,
            Relaxation::Each { .. } => forms.len(),
        };
        let convex_bounds;
        let equalities = if matches!(relaxation, Relaxation::Each { .. }) {
            convex_bounds = terms.len();
            terms.extend((0..slacks).map(|k| Term::Affine(Affine::variable(n + k))));
            terms.extend(forms.iter().enumerate().map(|(k, f)| Term::new(f, slack(k, f))));
            Equalities::default()
        } else {
            let (equalities, forms) = separate(&mut terms, forms, n);
            convex_bounds = terms.len();
            terms.extend(forms.into_iter().map(|f| Term::new(f, slack(0, f))));
            equalities
        };
        let degree = degree(&terms, &bounds);
        Self { squares, chart, terms, convex_bounds, bounds, equalities, relaxation, slacks, degree }
    }

    /// The least of other `squares` within the bounds of this program, without its forms and equations.
    pub(super) fn within_bounds<'b>(&'b self, squares: &'b Squares<'b>) -> Program<'b> {
        let terms = self.terms[..self.convex_bounds].to_vec();
        let bounds = self.bounds.clone();
        let degree = degree(&terms, &bounds);
        let (equalities, relaxation) = (Equalities::default(), Relaxation::None);
        let convex_bounds = self.convex_bounds;
        Program { squares, terms, bounds, equalities, relaxation, slacks: 0, degree, convex_bounds, ..*self }
    }

    /// Equations that every point must satisfy.
    pub(super) fn equalities(&self) -> &Equalities {
        &self.equalities
    }

    /// Number of unknowns, slacks included.
    pub(super) fn size(&self) -> usize {
        self.unknowns() + self.slacks
    }

    /// Number of unknowns of the problem.
    pub(super) fn unknowns(&self) -> usize {
        self.squares.unknowns()
    }

    /// The minimum is nearer than `mu` times this, where the program is convex.
    pub(super) fn degree(&self) -> f64 {
        self.degree
    }

    /// What is minimised, without the barrier and the objective's constant part.
    pub(super) fn cost(&self, x: &[f64]) -> f64 {
        let (z, s) = x.split_at(self.unknowns());
        match self.relaxation {
            Relaxation::Shared => s[0],
            Relaxation::None => self.distance(z),
            Relaxation::Each { linear, square } => {
                self.distance(z) + s.iter().map(|s| linear * s + square * s * s).sum::<f64>()
            }
        }
    }

    fn distance(&self, z: &[f64]) -> f64 {
        self.squares.objective.residual(z).norm_squared()
    }

    /// Cost and `mu` times the barrier; `None` outside of its domain.
    pub(super) fn value(&self, x: &[f64], mu: f64, room: &mut Room) -> Option<f64> {
        let mut logs = LogSum::new();
        let inside = self.bounds.iter().all(|b| b.add_logs(self.chart, x, &mut room.coordinates, &mut logs))
            && self.terms.iter().all(|t| t.add_logs(x, &mut room.scratch, &mut logs));
        inside.then(|| self.cost(x) - mu * logs.total()).filter(|v| v.is_finite())
    }

    /// Gradient and Hessian of [`Program::value`] at a point of its domain.
    pub(super) fn slopes(&self, x: &[f64], mu: f64, room: &mut Room, slopes: &mut Slopes<'_>) {
        slopes.gradient.fill(0.0);
        slopes.hessian.fill(0.0);
        let n = self.unknowns();
        if self.relaxation == Relaxation::Shared {
            slopes.gradient[n] = 1.0;
        } else {
            self.add_squares(&x[..n], slopes);
        }
        if let Relaxation::Each { linear, square } = self.relaxation {
            for (k, s) in x.iter().enumerate().skip(n) {
                slopes.gradient[k] = linear + 2.0 * square * s;
                slopes.hessian[k * slopes.size + k] = 2.0 * square;
            }
        }
        for bounds in &self.bounds {
            bounds.add_slopes(self.chart, x, mu, slopes);
        }
        for term in &self.terms {
            term.add_slopes(x, mu, &mut room.scratch, slopes);
        }
    }

    fn add_squares(&self, z: &[f64], slopes: &mut Slopes<'_>) {
        let n = z.len();
        let rest: DVector<f64> = self.squares.objective.residual(z);
        for (slot, column) in slopes.gradient.iter_mut().zip(self.squares.objective.r.column_iter()) {
            *slot = 2.0 * dot(column.as_slice(), rest.as_slice());
        }
        for (column, gram) in slopes.hessian.chunks_exact_mut(slopes.size).zip(self.squares.gram.chunks(n)) {
            column.iter_mut().zip(gram).for_each(|(h, g)| *h = 2.0 * g);
        }
    }

    /// Largest step along `d` that affine terms allow.
    pub(super) fn reach(&self, x: &[f64], d: &[f64]) -> f64 {
        self.terms.iter().map(|t| t.reach(x, d)).fold(f64::INFINITY, f64::min)
    }
}

fn degree(terms: &[Term], bounds: &[Bounds]) -> f64 {
    terms.iter().map(Term::degree).sum::<f64>() + bounds.iter().map(Bounds::degree).sum::<f64>()
}

/// Takes the equations out of the affine conditions among terms (bounds) and forms; the forms left over.
fn separate<'f>(terms: &mut Vec<Term>, forms: &[&'f Form], n: usize) -> (Equalities, Vec<&'f Form>) {
    let row = |f: &Form| match &f.body {
        crate::form::Body::Affine(row) => Some(row.clone()),
        _ => None,
    };
    let mut conditions: Vec<Affine> = forms.iter().filter_map(|f| row(f)).collect();
    conditions.extend(terms.iter().filter_map(Term::affine).cloned());
    let equalities = Equalities::extract(&mut conditions, n);
    if equalities.is_empty() {
        return (equalities, forms.to_vec());
    }
    let kept = |row: &Affine| conditions.contains(row);
    terms.retain(|t| t.affine().is_none_or(kept));
    let forms = forms.iter().copied().filter(|f| row(f).is_none_or(|r| kept(&r))).collect();
    (equalities, forms)
}
