//! A point of the penalised objective that moves one coordinate at a time, at the cost of that coordinate.
//!
//! A move within a group changes the unknowns of that group alone, so the sum of squares follows from the
//! Gram matrix and only forms that depend on the group are looked at.

use std::ops::Range;

use super::eigenvalue::least_eigenvalue;
use super::function::PenaltyForm;
use crate::Problem;
use crate::form::{Affine, Body, Form};

/// After so many moves everything is computed afresh, so that rounding does not add up.
const REFRESH: u32 = 1 << 13;

/// What does not change while a point moves; shared by all runs.
#[derive(Debug)]
pub struct Ground<'a> {
    problem: &'a Problem,
    ranges: Vec<Range<usize>>,
    /// Group of every coordinate.
    group: Vec<usize>,
    /// `rᵀ r`.
    gram: Vec<f64>,
    gauges: Vec<Gauge<'a>>,
    /// Forms that depend on each group, quickest first.
    touched: Vec<Vec<usize>>,
}

/// A quick way to a form's violation.
#[derive(Debug)]
enum Gauge<'a> {
    Affine {
        row: &'a Affine,
        scale: f64,
    },
    /// A Cholesky factor shows that nothing is violated; else the least eigenvalue or the form's own measure.
    Psd {
        size: usize,
        constant: Vec<f64>,
        entries: Vec<(usize, usize, f64)>,
        form: &'a Form,
    },
    Other(&'a Form),
}

/// Room for one matrix.
#[derive(Debug, Clone, Default)]
struct Scratch {
    matrix: Vec<f64>,
    factor: Vec<f64>,
    room: Vec<f64>,
}

impl<'a> Ground<'a> {
    /// Prepares a problem.
    pub fn new(problem: &'a Problem) -> Self {
        let ranges = problem.chart.space().ranges();
        let n = problem.space.len();
        let r = &problem.objective.r;
        let gram = (0..n * n).map(|k| r.column(k / n).dot(&r.column(k % n))).collect();
        let group = ranges.iter().enumerate().flat_map(|(g, range)| vec![g; range.len()]).collect();
        let gauges: Vec<Gauge<'_>> = problem.forms.iter().map(Gauge::new).collect();
        let supports: Vec<Vec<usize>> = problem.forms.iter().map(Form::support).collect();
        let touched = ranges
            .iter()
            .map(|range| {
                let touches = |f: &usize| supports[*f].iter().any(|i| range.contains(i));
                let mut forms: Vec<usize> = (0..gauges.len()).filter(touches).collect();
                forms.sort_by_key(|&f| gauges[f].cost());
                forms
            })
            .collect();
        Self { problem, ranges, group, gram, gauges, touched }
    }

    /// The problem.
    pub fn problem(&self) -> &'a Problem {
        self.problem
    }
}

impl<'a> Gauge<'a> {
    fn new(form: &'a Form) -> Self {
        match &form.body {
            Body::Affine(row) if form.measure.is_none() => Self::Affine { row, scale: form.scale },
            Body::Psd { size, lower } => {
                let place = |k: usize| {
                    let i = (0..*size).find(|i| (i + 1) * (i + 2) / 2 > k).unwrap_or(0);
                    i * size + k - i * (i + 1) / 2
                };
                let mut constant = vec![0.0; size * size];
                let mut entries = Vec::new();
                for (k, row) in lower.iter().enumerate() {
                    constant[place(k)] = row.constant;
                    entries.extend(row.terms.iter().map(|&(i, factor)| (place(k), i, factor)));
                }
                Self::Psd { size: *size, constant, entries, form }
            }
            _ => Self::Other(form),
        }
    }

    fn cost(&self) -> usize {
        match self {
            Self::Affine { row, .. } => row.terms.len(),
            Self::Psd { size, .. } => 100 * size,
            Self::Other(_) => 10_000,
        }
    }

    fn violation(&self, z: &[f64], scratch: &mut Scratch) -> f64 {
        match self {
            Self::Affine { row, scale } => {
                let margin = row.at(z);
                if margin.is_nan() { f64::INFINITY } else { (-margin / scale).max(0.0) }
            }
            Self::Other(form) => form.violation(z),
            Self::Psd { size, constant, entries, form } => {
                scratch.matrix.clone_from(constant);
                for &(place, i, factor) in entries {
                    scratch.matrix[place] += factor * z[i];
                }
                scratch.factor.clone_from(&scratch.matrix);
                if positive_definite(&mut scratch.factor, *size) {
                    return 0.0;
                }
                if form.measure.is_some() {
                    return form.violation(z);
                }
                let least = least_eigenvalue(&mut scratch.matrix, *size, &mut scratch.room);
                if least.is_nan() { f64::INFINITY } else { (-least / form.scale).max(0.0) }
            }
        }
    }
}

/// Gaussian elimination of a symmetric matrix (lower triangle by rows) meets positive pivots only.
fn positive_definite(a: &mut [f64], n: usize) -> bool {
    for j in 0..n {
        let pivot = a[j * n + j];
        // Written so that NaN is refused.
        if !(pivot > 0.0) {
            return false;
        }
        for i in j + 1..n {
            let factor = a[i * n + j] / pivot;
            for k in j + 1..=i {
                a[i * n + k] -= factor * a[k * n + j];
            }
        }
    }
    true
}

/// The moving point.
#[derive(Debug, Clone)]
pub struct Walk<'a> {
    ground: &'a Ground<'a>,
    form: PenaltyForm,
    weight: f64,
    p: Vec<f64>,
    z: Vec<f64>,
    /// `rᵀ (r z - d)`.
    slope: Vec<f64>,
    squares: f64,
    penalties: Vec<f64>,
    penalty: f64,
    moves: u32,
    old: Vec<f64>,
    change: Vec<(usize, f64)>,
    fresh: Vec<(usize, f64)>,
    scratch: Scratch,
}

impl<'a> Walk<'a> {
    /// Stands at coordinates `p`.
    pub fn new(ground: &'a Ground<'a>, form: PenaltyForm, weight: f64, p: Vec<f64>) -> Self {
        let n = p.len();
        let mut walk = Self {
            ground,
            form,
            weight,
            p,
            z: vec![0.0; n],
            slope: vec![0.0; n],
            squares: 0.0,
            penalties: vec![0.0; ground.gauges.len()],
            penalty: 0.0,
            moves: 0,
            old: Vec::new(),
            change: Vec::new(),
            fresh: Vec::new(),
            scratch: Scratch::default(),
        };
        walk.refresh();
        walk
    }

    /// Where it stands.
    pub fn coordinates(&self) -> &[f64] {
        &self.p
    }

    /// Value of the penalised objective, without its constant part.
    pub fn value(&self) -> f64 {
        self.squares + self.weight * self.penalty
    }

    /// Computes everything afresh.
    fn refresh(&mut self) {
        let problem = self.ground.problem;
        self.moves = 0;
        self.z = problem.chart.unknowns(&self.p);
        let rest = problem.objective.residual(&self.z);
        self.squares = rest.norm_squared();
        for (slot, column) in self.slope.iter_mut().zip(problem.objective.r.column_iter()) {
            *slot = column.dot(&rest);
        }
        for (slot, gauge) in self.penalties.iter_mut().zip(&self.ground.gauges) {
            *slot = self.form.of(gauge.violation(&self.z, &mut self.scratch));
        }
        self.penalty = self.penalties.iter().sum();
    }

    /// Moves coordinate `c` to `value` when the penalised objective is then at most `limit`.
    pub fn try_move(&mut self, c: usize, value: f64, limit: f64) -> bool {
        let ground = self.ground;
        let group = ground.group[c];
        let range = ground.ranges[group].clone();
        let before = std::mem::replace(&mut self.p[c], value);
        self.old.clear();
        self.old.extend_from_slice(&self.z[range.clone()]);
        let z = &mut self.z[range.clone()];
        ground.problem.chart.group_to_unknowns(group, &self.p[range.clone()], z);
        let squares = self.squares + self.growth(range.start);
        if squares <= limit
            && let Some(penalty) = self.penalty_after(group, squares, limit)
        {
            self.settle(squares, penalty);
            return true;
        }
        self.p[c] = before;
        self.z[range].copy_from_slice(&self.old);
        false
    }

    /// By how much the sum of squares grows: `2 dzᵀ slope + dzᵀ gram dz`.
    fn growth(&mut self, start: usize) -> f64 {
        let n = self.z.len();
        self.change.clear();
        for (i, old) in (start..).zip(&self.old) {
            if self.z[i].to_bits() != old.to_bits() {
                self.change.push((i, self.z[i] - old));
            }
        }
        let mut growth = 0.0;
        for (k, &(i, d)) in self.change.iter().enumerate() {
            let gram = &self.ground.gram[i * n..(i + 1) * n];
            let beside: f64 = self.change[..k].iter().map(|&(j, e)| gram[j] * e).sum();
            growth += d * (2.0 * (self.slope[i] + beside) + gram[i] * d);
        }
        growth
    }

    /// Sum of penalties after the move; `None` as soon as it is sure that the value exceeds `limit`.
    fn penalty_after(&mut self, group: usize, squares: f64, limit: f64) -> Option<f64> {
        self.fresh.clear();
        if self.weight <= 0.0 {
            return Some(self.penalty);
        }
        let touched = &self.ground.touched[group];
        let most = (limit - squares) / self.weight;
        let mut sum = self.penalty - touched.iter().map(|&f| self.penalties[f]).sum::<f64>();
        for &f in touched {
            let penalty = self.form.of(self.ground.gauges[f].violation(&self.z, &mut self.scratch));
            sum += penalty;
            // Written so that NaN is refused.
            if !(sum <= most) {
                return None;
            }
            self.fresh.push((f, penalty));
        }
        Some(sum.max(0.0))
    }

    fn settle(&mut self, squares: f64, penalty: f64) {
        let n = self.z.len();
        (self.squares, self.penalty) = (squares, penalty);
        for &(f, penalty) in &self.fresh {
            self.penalties[f] = penalty;
        }
        for &(i, d) in &self.change {
            let gram = &self.ground.gram[i * n..(i + 1) * n];
            self.slope.iter_mut().zip(gram).for_each(|(s, g)| *s += g * d);
        }
        self.moves += 1;
        if self.moves >= REFRESH {
            self.refresh();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::penalty::testing;
    use crate::polish::Target;
    use lacuna_base::random::Stream;

    #[test]
    fn moves_agree_with_the_whole_function() {
        let problem = testing::disc();
        let ground = Ground::new(&problem);
        for penalty in PenaltyForm::ALL {
            let mut stream = Stream::new(5, 0);
            let mut walk = Walk::new(&ground, penalty, 3.0, vec![0.2, -0.4, 0.7]);
            let target = Target { problem: &problem, penalty, weight: 3.0 };
            let mut moved = 0;
            for _ in 0..3000 {
                let c = (stream.uniform() * 3.0) as usize;
                let limit = walk.value() + stream.uniform();
                moved += u32::from(walk.try_move(c, stream.between(-2.0, 2.0), limit));
                let whole = target.value(&problem.chart.unknowns(walk.coordinates()));
                assert!((walk.value() - whole).abs() < 1e-10, "{} {whole}", walk.value());
                assert!(walk.value() <= limit + 1e-12);
            }
            assert!(moved > 300, "{moved}");
        }
    }
}
