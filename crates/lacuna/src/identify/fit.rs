//! Least squares: ordinary, weighted per joint, robust; in sample and held out.

use serde::{Deserialize, Serialize};

use crate::error::{Error, Result};
use crate::linalg::{Solution, Triangle, condition_number, product, solved};
use crate::model::Model;
use crate::signals::{Folds, Run};

use super::evidence::{Evidence, residual_squares, residuals};
use super::rows::over_rows;
use super::uncertainty::score_variance;

/// How rows are weighed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Weighting {
    /// Every row alike (ordinary least squares, eq. 8 of Gaz et al. 2019).
    Ordinary,
    /// The rows of a joint by one over its residual rms, iterated.
    #[default]
    Joint,
    /// Per-joint weights, and rows with large residuals count less (Huber 1964).
    Huber,
}

/// Rounds of re-weighting by residual rms.
const JOINT_ROUNDS: usize = 3;
/// Rounds of robust re-weighting at most.
const HUBER_ROUNDS: usize = 20;
/// Residuals beyond this many standard deviations count less; 95 % efficient for Gaussian noise.
const HUBER_BEND: f64 = 1.345;

/// A fitted model.
#[derive(Debug, Clone, PartialEq)]
pub struct Fit {
    /// One value per column of the model; 0 for columns that were left out.
    pub x: Vec<f64>,
    /// Standard deviations for white residuals.
    pub classical_sd: Vec<f64>,
    /// Standard deviations that allow for autocorrelation; empty when not asked for.
    pub robust_sd: Vec<f64>,
    /// Columns that this motion does not excite, left at 0.
    pub unexcited: Vec<usize>,
    /// Weight of each joint's rows.
    pub weights: Vec<f64>,
    /// In-sample errors.
    pub errors: Errors,
    /// Condition number of the whole regressor in SI units, unscaled.
    pub condition_number: f64,
    /// Number of scalar rows (samples x joints).
    pub rows: usize,
}

/// Errors per joint and over all joints.
#[derive(Debug, Clone, PartialEq)]
pub struct Errors {
    /// Root mean square of the torque, per joint [N m, N].
    pub torque_rms: Vec<f64>,
    /// Root mean square of the residual, per joint [N m, N].
    pub rms: Vec<f64>,
    /// `100 |residual| / |torque|` per joint (Sousa and Cortesão 2014, eq. 84).
    pub relative_percent: Vec<f64>,
    /// The same over all rows of all joints.
    pub pooled_percent: f64,
    /// Whether a constant would have predicted the joint better.
    pub worse_than_constant: Vec<bool>,
}

impl Errors {
    /// From sums over rows: residual squares, torque squares, torque sum and rows, per joint.
    pub fn from_sums(sums: &[ErrorSums]) -> Self {
        let percent = |r: f64, t: f64| if t > 0.0 { 100.0 * (r / t).sqrt() } else { f64::NAN };
        let rms = |s: f64, n: usize| (s / n.max(1) as f64).sqrt();
        let total = |f: fn(&ErrorSums) -> f64| sums.iter().map(f).sum::<f64>();
        Self {
            torque_rms: sums.iter().map(|s| rms(s.torque, s.rows)).collect(),
            rms: sums.iter().map(|s| rms(s.residual, s.rows)).collect(),
            relative_percent: sums.iter().map(|s| percent(s.residual, s.torque)).collect(),
            pooled_percent: percent(total(|s| s.residual), total(|s| s.torque)),
            worse_than_constant: sums.iter().map(ErrorSums::worse_than_constant).collect(),
        }
    }
}

/// Sums over the rows of one joint.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct ErrorSums {
    /// Squared residuals.
    pub residual: f64,
    /// Squared torques.
    pub torque: f64,
    /// Torques.
    pub torque_sum: f64,
    /// Rows.
    pub rows: usize,
}

impl ErrorSums {
    /// Adds one row.
    pub fn add(&mut self, residual: f64, torque: f64) {
        self.residual += residual * residual;
        self.torque += torque * torque;
        self.torque_sum += torque;
        self.rows += 1;
    }

    fn worse_than_constant(&self) -> bool {
        self.rows > 0 && self.residual > self.torque - self.torque_sum * self.torque_sum / self.rows as f64
    }
}

/// Fits all folds together, or all but one.
///
/// # Errors
/// When there are fewer rows than unknowns, or the regressor is singular beyond what dropping unexcited
/// columns mends.
pub fn fit(model: &Model, evidence: &Evidence, left_out: Option<usize>, weighting: Weighting) -> Result<Fit> {
    let triangles = evidence.merged(left_out);
    let (weights, found) = estimated(model, &triangles, weighting)?;
    told(model, &triangles, &weights, found)
}

/// Parameters of a fit, with the weights of the joints that they settle at.
fn estimated(model: &Model, triangles: &[Triangle], weighting: Weighting) -> Result<(Vec<f64>, Estimate)> {
    enough_rows(model, triangles)?;
    let mut weights = vec![1.0; triangles.len()];
    let mut found = estimate(model, triangles, &weights)?;
    if weighting != Weighting::Ordinary {
        for _ in 0..JOINT_ROUNDS {
            weights = joint_weights(&errors(model, triangles, &found.x).rms);
            // Torque that is zero throughout was not measured.
            let silent = |t: &Triangle| t.column_squares(t.columns() - 1) <= 0.0;
            if !triangles.iter().all(silent) {
                weights.iter_mut().zip(triangles).filter(|(_, t)| silent(t)).for_each(|(w, _)| *w = 0.0);
            }
            found = estimate(model, triangles, &weights)?;
        }
    }
    Ok((weights, found))
}

/// Fits all folds together with the rows of each joint weighed by a number that the caller knows, such as one
/// over the noise of its torque.
///
/// # Errors
/// As [`fit`].
pub fn fit_with_weights(model: &Model, evidence: &Evidence, weights: &[f64]) -> Result<Fit> {
    let triangles = evidence.merged(None);
    enough_rows(model, &triangles)?;
    solve(model, &triangles, weights)
}

fn enough_rows(model: &Model, triangles: &[Triangle]) -> Result<()> {
    let rows: usize = triangles.iter().map(Triangle::rows).sum();
    let unknowns = model.columns.len();
    if rows <= unknowns {
        return Err(Error::new(format!("{rows} rows for {unknowns} unknowns"))
            .help("record a longer motion, or trim and decimate less (rows should far outnumber unknowns)"));
    }
    Ok(())
}

/// One over the residual rms of each joint. A joint that the model explains to the last digit (one that never
/// moved, say) must not drown the others: it counts as if its residual were a millionth of the largest.
fn joint_weights(rms: &[f64]) -> Vec<f64> {
    const LEAST: f64 = 1e-6;
    let floor = LEAST * rms.iter().copied().fold(0.0, f64::max);
    rms.iter().map(|&rms| if rms > 0.0 || floor > 0.0 { 1.0 / rms.max(floor) } else { 1.0 }).collect()
}

/// Robust fit: iteratively re-weighted passes over the data until the parameters settle.
///
/// # Errors
/// As [`fit`], and when an effect cannot be evaluated.
pub fn fit_huber(model: &Model, runs: &[Run], folds: &Folds, evidence: &Evidence) -> Result<Fit> {
    let mut best = fit(model, evidence, None, Weighting::Joint)?;
    let plain = evidence.merged(None);
    let mut scale = best.errors.rms.clone();
    for _ in 0..HUBER_ROUNDS {
        scale = huber_scale(model, runs, &best.x, &scale)?;
        let weight = |joint: usize, r: f64| (HUBER_BEND * scale[joint] / r.abs()).min(1.0);
        let weighed = Evidence::collect_weighted(model, runs, folds, &best.x, &weight)?;
        let next = solve(model, &weighed.merged(None), &joint_weights(&scale))?;
        let moved = next.x.iter().zip(&best.x).zip(&next.classical_sd);
        let settled = moved.fold(0.0_f64, |m, ((a, b), sd)| m.max((a - b).abs() / sd.max(1e-300)));
        best = next;
        if settled < 0.01 {
            break;
        }
    }
    best.errors = errors(model, &plain, &best.x);
    Ok(best)
}

/// Scale of each joint's residuals by Huber's second proposal: the rms of residuals cut at the bend, over
/// what that would be for Gaussian noise of scale one. One step of the fixed-point iteration.
fn huber_scale(model: &Model, runs: &[Run], x: &[f64], scale: &[f64]) -> Result<Vec<f64>> {
    /// Mean of `min(|z|, bend)²` for a standard normal `z`.
    const GAUSSIAN: f64 = 0.710_164_5;
    let n = scale.len();
    let parts = over_rows(
        model,
        runs,
        || vec![(0.0, 0_usize); n],
        |sums, view| {
            for (joint, sum) in sums.iter_mut().enumerate() {
                let bend = HUBER_BEND * scale[joint];
                for r in residuals(model, view, joint, x) {
                    let cut = r.abs().min(bend);
                    sum.0 += cut * cut;
                    sum.1 += 1;
                }
            }
            Ok(())
        },
    )?;
    let root = |joint: usize| {
        let (sum, rows) = parts.iter().fold((0.0, 0), |(s, r), p| (s + p[joint].0, r + p[joint].1));
        (sum / (GAUSSIAN * rows.max(1) as f64)).sqrt()
    };
    Ok((0..n).map(root).collect())
}

/// Adds robust standard deviations to a fit.
///
/// # Errors
/// When an effect cannot be evaluated.
pub fn with_robust_sd(model: &Model, runs: &[Run], evidence: &Evidence, mut fit: Fit) -> Result<Fit> {
    let kept = kept_columns(model, &fit.unexcited);
    let total = stack(model, &evidence.merged(None), &fit.weights, &kept);
    let inverse = Solution::new(&total)?.inverse;
    let scores = score_variance(model, runs, &fit.x, &fit.weights)?.select_columns(&kept).select_rows(&kept);
    let sandwich = product(&product(&inverse, &scores), &inverse);
    fit.robust_sd = vec![f64::NAN; model.columns.len()];
    for (i, &column) in kept.iter().enumerate() {
        fit.robust_sd[column] = sandwich[(i, i)].max(0.0).sqrt();
    }
    Ok(fit)
}

/// Pooled held-out error: every fold predicted by the fit of all the others.
///
/// # Errors
/// When a fold leaves too few rows to fit.
pub fn held_out(model: &Model, evidence: &Evidence, weighting: Weighting) -> Result<Errors> {
    let mut sums = vec![ErrorSums::default(); evidence.joints()];
    for (fold, triangles) in evidence.triangles.iter().enumerate() {
        if triangles.iter().all(|t| t.rows() == 0) {
            continue;
        }
        let (_, trained) = estimated(model, &evidence.merged(Some(fold)), weighting).map_err(|e| {
            e.about(&format!("`hold_out` leaves too little when fold {} is held out", fold + 1))
        })?;
        for (joint, triangle) in triangles.iter().enumerate() {
            let part = joint_sums(model, joint, triangle, &trained.x);
            sums[joint].residual += part.residual;
            sums[joint].torque += part.torque;
            sums[joint].rows += part.rows;
        }
    }
    let mut errors = Errors::from_sums(&sums);
    errors.worse_than_constant.clear();
    Ok(errors)
}

fn joint_sums(model: &Model, joint: usize, triangle: &Triangle, x: &[f64]) -> ErrorSums {
    ErrorSums {
        residual: residual_squares(model, joint, triangle, x),
        torque: triangle.column_squares(triangle.columns() - 1),
        torque_sum: f64::NAN,
        rows: triangle.rows(),
    }
}

/// In-sample errors of any parameter vector.
pub fn errors(model: &Model, triangles: &[Triangle], x: &[f64]) -> Errors {
    let sums: Vec<_> = triangles.iter().enumerate().map(|(j, t)| joint_sums(model, j, t, x)).collect();
    let mut errors = Errors::from_sums(&sums);
    errors.worse_than_constant.clear();
    errors
}

fn solve(model: &Model, triangles: &[Triangle], weights: &[f64]) -> Result<Fit> {
    told(model, triangles, weights, estimate(model, triangles, weights)?)
}

/// Least-squares parameters under some weights, without their uncertainty.
struct Estimate {
    x: Vec<f64>,
    unexcited: Vec<usize>,
    /// Columns that are fitted, and the triangle over them.
    kept: Vec<usize>,
    total: Triangle,
}

fn estimate(model: &Model, triangles: &[Triangle], weights: &[f64]) -> Result<Estimate> {
    let p = model.columns.len();
    let all: Vec<usize> = (0..p).collect();
    let total = stack(model, triangles, weights, &all);
    let unexcited = total.dependent_columns();
    let kept = kept_columns(model, &unexcited);
    if kept.is_empty() {
        return Err(Error::new("this motion moves nothing that the model could explain")
            .help("record a motion of every joint, or check the columns of the log"));
    }
    let total = if unexcited.is_empty() { total } else { stack(model, triangles, weights, &kept) };
    let mut x = vec![0.0; p];
    for (&column, value) in kept.iter().zip(solved(&total)?) {
        x[column] = value;
    }
    Ok(Estimate { x, unexcited, kept, total })
}

/// All that is told of an estimate.
fn told(model: &Model, triangles: &[Triangle], weights: &[f64], found: Estimate) -> Result<Fit> {
    let Estimate { x, unexcited, kept, total } = found;
    let solution = Solution::new(&total)?;
    let variance = solution.variance().unwrap_or(f64::NAN);
    let mut classical_sd = vec![f64::NAN; x.len()];
    for (i, &column) in kept.iter().enumerate() {
        classical_sd[column] = (variance * solution.inverse[(i, i)]).sqrt();
    }
    let unweighted = if weights.iter().all(|w| w.to_bits() == 1.0_f64.to_bits()) {
        condition_number(&total)
    } else {
        condition_number(&stack(model, triangles, &vec![1.0; triangles.len()], &kept))
    };
    Ok(Fit {
        errors: errors(model, triangles, &x),
        x,
        classical_sd,
        robust_sd: Vec::new(),
        unexcited,
        weights: weights.to_vec(),
        condition_number: unweighted,
        rows: total.rows(),
    })
}

fn kept_columns(model: &Model, left_out: &[usize]) -> Vec<usize> {
    (0..model.columns.len()).filter(|c| !left_out.contains(c)).collect()
}

/// One triangle over the `kept` columns and the torque, from the joints' triangles.
fn stack(model: &Model, triangles: &[Triangle], weights: &[f64], kept: &[usize]) -> Triangle {
    let mut total = Triangle::new(kept.len() + 1);
    for (joint, triangle) in triangles.iter().enumerate() {
        let places: Vec<Option<usize>> = model.active[joint]
            .iter()
            .map(|c| kept.binary_search(c).ok())
            .chain(std::iter::once(Some(kept.len())))
            .collect();
        total.merge(triangle, &places, weights[joint]);
    }
    total
}
