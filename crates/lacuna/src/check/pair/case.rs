//! How well a model explains one reading of a log, for every choice of torque signs at once.

use nalgebra::{DMatrix, DVector};

use crate::error::{Error, Result};
use crate::identify::Evidence;
use crate::kernels::{MassMatrix, Samples, Workspace, inverse_dynamics_batch};
use crate::linalg::{Triangle, product};
use crate::model::Model;
use crate::signals::{Folds, Run};

/// A joint's torque counts at least this part of the liveliest joint's, so that a joint that
/// measures nothing but noise does not decide.
const QUIETEST: f64 = 1e-3;

/// The classical model fitted to one reading. Rows are weighed so that every joint's torque has the
/// variation 1: an error of 1 is that of a constant, and small joints count as much as large ones.
pub(super) struct Case {
    /// Scalar products of the residuals that each joint's torque leaves (with the other torques zero).
    gram: DMatrix<f64>,
    /// `R` of the regressor, and `Qᵀ tau` of every joint.
    r: DMatrix<f64>,
    projected: DMatrix<f64>,
    /// Columns of the model that the motion excites.
    kept: Vec<usize>,
    /// What friction does per joint.
    friction: Vec<Friction>,
    /// Per joint, with friction and offset projected out: torque², torque x model, model² of the robot
    /// file's own inertias.
    given: Option<Vec<[f64; 3]>>,
}

/// Identified friction of one joint for every choice of signs: its columns' rows of `R⁻¹ Qᵀ tau`, and the
/// weighted squares of its torque.
#[derive(Debug, Clone)]
struct Friction {
    /// Coefficient of viscous friction per unit of each joint's torque sign.
    viscous: Vec<f64>,
    /// The same for Coulomb friction.
    coulomb: Vec<f64>,
    /// Weighted sums of v², |v| and 1 over the rows that move.
    squares: [f64; 3],
}

impl Friction {
    /// Weighted square of a friction torque that drives the motion instead of braking it; 0 where it brakes.
    fn driving(&self, signs: &[f64]) -> f64 {
        let times = |row: &[f64]| row.iter().zip(signs).map(|(f, s)| f * s).sum::<f64>();
        let (fv, fc, [vv, v, one]) = (times(&self.viscous), times(&self.coulomb), self.squares);
        if fv * vv + fc * v < 0.0 { fv * fv * vv + 2.0 * fv * fc * v + fc * fc * one } else { 0.0 }
    }
}

impl Case {
    /// Fits `model` to `run`, all rows together; `parameters` are the robot file's own (ten per link).
    pub fn new(model: &Model, run: &Run, parameters: Option<&[f64]>) -> Result<Self> {
        let rows = run.samples();
        let whole = Folds { fold: vec![0; rows], count: 1, description: String::new() };
        let evidence = Evidence::collect(model, std::slice::from_ref(run), &whole)?;
        let weights = weights(run)?;
        let (total, kept) = stack(model, &evidence.triangles[0], &weights);
        let case = Self::of(&total, kept, run.tau.len());
        let friction = case.friction(model, run, &weights);
        Ok(Self { friction, given: parameters.map(|x| given_products(model, run, &weights, x)), ..case })
    }

    /// From a triangle over the `kept` columns and `n` torques.
    fn of(total: &Triangle, kept: Vec<usize>, n: usize) -> Self {
        let p = kept.len();
        let part = |row: usize, column: usize, rows: usize, columns: usize| {
            DMatrix::from_fn(rows, columns, |i, j| total.at(row + i, column + j))
        };
        let rest = part(p, p, n, n);
        Self {
            gram: product(&rest.transpose(), &rest),
            r: part(0, 0, p, p),
            projected: part(0, p, p, n),
            kept,
            friction: Vec::new(),
            given: None,
        }
    }

    /// Relative error with these signs of the torques: root of the mean over joints of
    /// (residual / variation of the torque)².
    pub fn error(&self, signs: &[f64]) -> f64 {
        let row = |i: usize| (0..signs.len()).map(|j| self.gram[(i, j)] * signs[j]).sum::<f64>();
        let squares: f64 = signs.iter().enumerate().map(|(i, s)| s * row(i)).sum();
        (squares.max(0.0) / signs.len() as f64).sqrt()
    }

    /// The same with friction that drives the motion, which is no friction, counted as error.
    pub fn physical_error(&self, signs: &[f64]) -> f64 {
        let driving: f64 = self.friction.iter().map(|f| f.driving(signs)).sum();
        (self.error(signs).powi(2) + driving / signs.len() as f64).sqrt()
    }

    fn friction(&self, model: &Model, run: &Run, weights: &[f64]) -> Vec<Friction> {
        let n = run.tau.len();
        let none = || DMatrix::zeros(self.kept.len(), n);
        let solved = self.r.solve_upper_triangular(&self.projected).unwrap_or_else(none);
        let row = |symbol: String| {
            let column = model.columns.iter().position(|c| c.about.symbol == symbol);
            let at = column.and_then(|c| self.kept.binary_search(&c).ok());
            at.map_or(vec![0.0; n], |i| solved.row(i).iter().copied().collect())
        };
        let joint = |j: usize| {
            let sum = |f: fn(f64) -> f64| run.dq[j].iter().map(|v| f(*v)).sum::<f64>();
            let moving = |v: f64| f64::from(u8::from(v.abs() > 0.0));
            let squares = [sum(|v| v * v), sum(f64::abs), sum(moving)].map(|s| s * weights[j] * weights[j]);
            Friction { viscous: row(format!("fv{}", j + 1)), coulomb: row(format!("fc{}", j + 1)), squares }
        };
        (0..n).map(joint).collect()
    }

    /// The same for the robot file's own inertias, with only friction and offset fitted.
    pub fn given_error(&self, signs: &[f64]) -> Option<f64> {
        let given = self.given.as_ref()?;
        let squares = given.iter().zip(signs).map(|([tt, tg, gg], s)| tt - 2.0 * s * tg + gg);
        Some((squares.sum::<f64>().max(0.0) / signs.len() as f64).sqrt())
    }

    /// Factor per joint by which the torque exceeds what the file's own inertias predict, and how well the
    /// two agree in shape (correlation, friction and offset projected out).
    pub fn scales(&self) -> Option<Vec<(f64, f64)>> {
        let one = |[tt, tg, gg]: &[f64; 3]| (tg / gg.max(1e-300), tg / (tt * gg).sqrt().max(1e-300));
        Some(self.given.as_ref()?.iter().map(one).collect())
    }

    /// The signs that explain most: all combinations for few joints, else one joint after the other.
    /// The signs' common sign cannot be told here; the first is 1.
    pub fn best_signs(&self) -> Vec<f64> {
        let n = self.gram.nrows();
        let mut best = vec![1.0; n];
        // Friction tells a sign from its opposite, so it only counts for the sense it allows more.
        let either = |signs: &[f64]| {
            let opposite: Vec<f64> = signs.iter().map(|s| -s).collect();
            self.physical_error(signs).min(self.physical_error(&opposite))
        };
        let mut least = either(&best);
        let mut consider = |signs: Vec<f64>, best: &mut Vec<f64>| {
            let error = either(&signs);
            let better = error < least * (1.0 - 1e-9);
            if better {
                (least, *best) = (error, signs);
            }
            better
        };
        if n <= 10 {
            for pattern in 0..1_usize << (n - 1) {
                let sign = |j: usize| if j > 0 && pattern >> (j - 1) & 1 == 1 { -1.0 } else { 1.0 };
                consider((0..n).map(sign).collect(), &mut best);
            }
            return best;
        }
        loop {
            let flipped = |j: usize, of: &[f64]| {
                of.iter().enumerate().map(|(i, s)| if i == j { -s } else { *s }).collect::<Vec<f64>>()
            };
            let better = (1..n).any(|j| {
                let next = flipped(j, &best);
                consider(next, &mut best)
            });
            if !better {
                return best;
            }
        }
    }

    /// Fitted parameters, one per column of the model; those that are not excited are 0.
    fn parameters(&self, columns: usize, signs: &[f64]) -> Vec<f64> {
        let mut x = vec![0.0; columns];
        let sum = |i: usize| signs.iter().enumerate().map(|(j, s)| s * self.projected[(i, j)]).sum();
        let right = DVector::from_fn(self.kept.len(), |i, _| sum(i));
        if let Some(solved) = self.r.solve_upper_triangular(&right) {
            self.kept.iter().zip(solved.iter()).for_each(|(&c, value)| x[c] = *value);
        }
        x
    }

    /// Whether the torques have the right common sign, from -1 (surely not) to 1: inertia and friction must
    /// be positive, and the file's own inertias should not predict the opposite. Each is a vote.
    pub fn orientation(&self, model: &Model, run: &Run, signs: &[f64]) -> f64 {
        let x = self.parameters(model.columns.len(), signs);
        let mut votes = Vec::new();
        votes.extend(inertia_vote(model, run, &x));
        votes.extend(friction_vote(model, run, &x));
        if let (Some(scales), Some(error)) = (self.scales(), self.given_error(signs)) {
            let agreement: f64 = scales.iter().zip(signs).map(|((_, r), s)| r * s).sum();
            let opposite: Vec<f64> = signs.iter().map(|s| -s).collect();
            if error.min(self.given_error(&opposite).unwrap_or(error)) < 0.7 {
                votes.push(agreement.signum());
            }
        }
        votes.iter().sum::<f64>() / votes.len().max(1) as f64
    }
}

/// Relative error as [`Case::error`], every fold predicted by the fit of the others.
///
/// # Errors
/// When the model cannot be evaluated.
pub(super) fn held_out(model: &Model, run: &Run, folds: &Folds) -> Result<f64> {
    let evidence = Evidence::collect(model, std::slice::from_ref(run), folds)?;
    let weights = weights(run)?;
    let n = run.tau.len();
    let mut squares = 0.0;
    for (fold, left_out) in evidence.triangles.iter().enumerate() {
        let (total, kept) = stack(model, &evidence.merged(Some(fold)), &weights);
        let x = Case::of(&total, kept, n).parameters(model.columns.len(), &vec![1.0; n]);
        for (joint, triangle) in left_out.iter().enumerate() {
            let own = model.active[joint].iter().map(|&c| x[c]).chain(std::iter::once(-1.0));
            squares += weights[joint] * weights[joint] * triangle.squares(&own.collect::<Vec<f64>>());
        }
    }
    Ok((squares / n as f64).sqrt())
}

/// One over the variation of each joint's torque.
fn weights(run: &Run) -> Result<Vec<f64>> {
    let variation = |tau: &Vec<f64>| {
        let mean = tau.iter().sum::<f64>() / tau.len().max(1) as f64;
        tau.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>().sqrt()
    };
    let each: Vec<f64> = run.tau.iter().map(variation).collect();
    let largest = each.iter().copied().fold(0.0, f64::max);
    if !(largest > 0.0 && largest.is_finite()) {
        return Err(Error::new("no joint's torque ever changes, so there is nothing to compare")
            .help("check that the log holds torques of a moving robot"));
    }
    Ok(each.iter().map(|v| 1.0 / v.max(QUIETEST * largest)).collect())
}

/// One triangle over the excited columns of the model, then the torque of every joint by itself.
fn stack(model: &Model, triangles: &[Triangle], weights: &[f64]) -> (Triangle, Vec<usize>) {
    let (p, n) = (model.columns.len(), triangles.len());
    let over = |kept: &[usize]| {
        let mut total = Triangle::new(kept.len() + n);
        for (joint, triangle) in triangles.iter().enumerate() {
            let places: Vec<Option<usize>> = model.active[joint]
                .iter()
                .map(|c| kept.binary_search(c).ok())
                .chain(std::iter::once(Some(kept.len() + joint)))
                .collect();
            total.merge(triangle, &places, weights[joint]);
        }
        total
    };
    let all: Vec<usize> = (0..p).collect();
    let total = over(&all);
    let idle: Vec<usize> = total.dependent_columns().into_iter().filter(|c| *c < p).collect();
    if idle.is_empty() {
        return (total, all);
    }
    let kept: Vec<usize> = all.into_iter().filter(|c| !idle.contains(c)).collect();
    (over(&kept), kept)
}

/// Weighted products of measured and given torque of each joint, with viscous and Coulomb friction and
/// offset projected out.
fn given_products(model: &Model, run: &Run, weights: &[f64], parameters: &[f64]) -> Vec<[f64; 3]> {
    let samples = Samples { q: &run.q, dq: &run.dq, ddq: &run.ddq };
    let predicted = inverse_dynamics_batch(&model.chain, samples, parameters);
    let joint = |j: usize| {
        let rows = run.samples();
        let length = Triangle::padded(rows);
        let mut block = vec![0.0; 5 * length];
        for k in 0..rows {
            let v = run.dq[j][k];
            let sign = if v > 0.0 { 1.0 } else { -f64::from(i8::from(v < 0.0)) };
            let row = [1.0, v, sign, weights[j] * predicted[j][k], weights[j] * run.tau[j][k]];
            row.into_iter().enumerate().for_each(|(c, value)| block[c * length + k] = value);
        }
        let mut triangle = Triangle::new(5);
        triangle.absorb(&mut block, rows);
        let (gg, gt, tt) = (triangle.at(3, 3), triangle.at(3, 4), triangle.at(4, 4));
        [gt * gt + tt * tt, gg * gt, gg * gg]
    };
    (0..run.tau.len()).map(joint).collect()
}

/// Mean sign of the diagonal of the identified inertia matrix along the motion.
fn inertia_vote(model: &Model, run: &Run, x: &[f64]) -> Option<f64> {
    let base = model.base.as_ref()?;
    let first = model.columns.iter().position(|c| base.pivots.contains(&c.term))?;
    let links = base.lift(x.get(first..first + base.rank())?);
    let n = run.q.len();
    let matrix = MassMatrix::new(&model.chain, &links);
    let (mut ws, mut m) = (Workspace::new(&model.chain, 0.0), vec![0.0; n * n]);
    let mut mean = vec![0.0; n];
    for k in (0..run.samples()).step_by((run.samples() / 40).max(1)) {
        let q: Vec<f64> = run.q.iter().map(|c| c[k]).collect();
        matrix.at(&mut ws, &q, &mut m);
        mean.iter_mut().enumerate().for_each(|(j, sum)| *sum += m[j * n + j]);
    }
    Some(mean.iter().map(|m| m.signum()).sum::<f64>() / n as f64)
}

/// Mean sign of the identified friction power, over joints where friction is a part of the torque.
fn friction_vote(model: &Model, run: &Run, x: &[f64]) -> Option<f64> {
    let value = |name: &str, j: usize| {
        let symbol = format!("{name}{}", j + 1);
        model.columns.iter().position(|c| c.about.symbol == symbol).map_or(0.0, |c| x[c])
    };
    let rms = |c: &[f64]| (c.iter().map(|v| v * v).sum::<f64>() / c.len().max(1) as f64).sqrt();
    let mut votes = Vec::new();
    for j in 0..run.tau.len() {
        let friction = value("fv", j) * rms(&run.dq[j]) + value("fc", j);
        if friction.abs() > 0.05 * rms(&run.tau[j]) {
            votes.push(friction.signum());
        }
    }
    (!votes.is_empty()).then(|| votes.iter().sum::<f64>() / votes.len() as f64)
}
