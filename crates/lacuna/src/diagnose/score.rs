//! How much a candidate would explain in data it has not seen, beside the model at hand.
//!
//! A candidate is never fitted to the residual: all parameters are estimated again together with it
//! (Frisch-Waugh-Lovell), fold by fold, and what it then predicts in the held-out fold is scored.

use std::ops::Range;
use std::sync::Arc;

use super::data::{Column, Data, per_second};
use super::normal::Cholesky;
use super::present::{Present, Response};
use crate::linalg::dots;

/// Candidates of which less than this part survives beside the model cannot be told from it.
const INSEPARABLE: f64 = 1e-4;

/// How the parameters of many columns are held back.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Ridge {
    /// Not at all.
    None,
    /// By a part of each column's own size, so that what the model explains stays small.
    OfEach(f64),
    /// By a part of their mean size at least, where they are pieces of one curve: it stays near zero where data are few.
    OfAll(f64),
}

impl Ridge {
    fn of(self, own: f64, mean: f64) -> f64 {
        match self {
            Self::None => 0.0,
            Self::OfEach(part) => part * own,
            Self::OfAll(part) => part * mean.max(own),
        }
    }
}

/// A candidate's columns, taken apart into what the model already explains and the rest, for every fold.
#[derive(Debug, Clone)]
pub(super) struct Projection {
    /// One per alternative.
    alternatives: Vec<Projected>,
}

#[derive(Debug, Clone)]
struct Projected {
    columns: Vec<Arc<Column>>,
    /// Per held-out fold; `None` where nothing of a column is left beside the model.
    folds: Vec<Option<Rest>>,
}

/// What is left of a candidate in training data.
#[derive(Debug, Clone)]
struct Rest {
    /// `shadow[column]`: how the model would have to change to make up for a unit of the candidate.
    shadow: Vec<Vec<f64>>,
    factor: Cholesky,
}

/// The held-out score of a candidate.
#[derive(Debug, Clone)]
pub(super) struct Score {
    /// Torque the candidate adds in held-out rows, `effect[joint][row]`, the model's own change included.
    pub effect: Vec<Vec<f64>>,
    /// Weighted squared error it removes.
    pub gain: f64,
    /// The same as part of the weighted squared error there is.
    pub share: f64,
    /// Squared error it removes, per joint, in the joint's own unit.
    pub gain_of_joint: Vec<f64>,
    /// Score with a variance that allows for autocorrelation.
    pub z: f64,
    /// The same without the one second that helps most.
    pub z_without_best: f64,
    /// Part of the gain that the one second brings that helps most.
    pub in_one_second: f64,
    /// Part of the gain from rows in which the joint that it acts on nearly rests.
    pub at_rest: f64,
    /// The alternative that most folds chose.
    pub alternative: usize,
}

impl Score {
    /// A score for what was found in another way than by held-out blocks.
    pub fn of_gain(gain_of_joint: Vec<f64>, z: f64) -> Self {
        let gain = gain_of_joint.iter().sum();
        Self {
            effect: Vec::new(),
            gain,
            share: 0.0,
            gain_of_joint,
            z,
            z_without_best: z,
            in_one_second: 0.0,
            at_rest: 0.0,
            alternative: 0,
        }
    }
}

impl Projection {
    /// Projects all alternatives.
    pub fn new(data: &Data, present: &Present, alternatives: Vec<Vec<Arc<Column>>>, ridge: Ridge) -> Self {
        Self {
            alternatives: alternatives.into_iter().map(|c| Projected::new(data, present, c, ridge)).collect(),
        }
    }

    /// Scores it against a response; `None` where it cannot be told from the model.
    pub fn score(&self, data: &Data, present: &Present, response: &Response) -> Option<Score> {
        let dof = data.dof();
        let mut effect: Vec<Vec<f64>> = (0..dof).map(|_| vec![0.0; data.count()]).collect();
        let products: Vec<Vec<Vec<f64>>> =
            self.alternatives.iter().map(|a| a.products(data, present, &response.y)).collect();
        let total = super::present::sum(&response.products);
        let mut votes = vec![0; self.alternatives.len()];
        for (fold, ranges) in data.fold_ranges.iter().enumerate() {
            let train: Vec<f64> = total.iter().zip(&response.products[fold]).map(|(a, b)| a - b).collect();
            let fitted = |k: usize| -> Option<(usize, Vec<f64>, f64)> {
                let (d, explained) = self.alternatives[k].fit(fold, &train, &products[k])?;
                Some((k, d, explained))
            };
            let best = (0..self.alternatives.len())
                .filter_map(fitted)
                .reduce(|best, next| if next.2 > best.2 { next } else { best });
            let Some((k, d, _)) = best else { continue };
            votes[k] += 1;
            self.alternatives[k].predict(fold, &d, present, ranges, &mut effect);
        }
        let most = votes.iter().copied().max().filter(|&v| v > 0)?;
        let alternative = votes.iter().position(|&v| v == most)?;
        let mut score = judge(data, present, &response.residual, effect);
        score.alternative = alternative;
        Some(score)
    }

    /// What alternative `k` explains of the response in all rows, its coefficients, and the change of the model.
    pub fn explained(&self, data: &Data, present: &Present, y: &[Vec<f64>], k: usize) -> Option<f64> {
        let all = 0..data.count();
        let all = std::slice::from_ref(&all);
        let alternative = &self.alternatives[k];
        let own = Crosses::new(present, &alternative.columns, all).rest(&present.all, Ridge::None)?.0;
        let products: Vec<f64> =
            alternative.columns.iter().map(|c| weighted_product(present, c, y, all)).collect();
        let g = own.residual_products(&products, &present.products_of(y, all));
        let d = own.factor.solve(&g);
        Some(g.iter().zip(&d).map(|(a, b)| a * b).sum())
    }
}

impl Rest {
    /// Products of the surviving part of each column with the response.
    fn residual_products(&self, own: &[f64], model: &[f64]) -> Vec<f64> {
        let dot = |shadow: &Vec<f64>| -> f64 { shadow.iter().zip(model).map(|(s, m)| s * m).sum() };
        own.iter().zip(&self.shadow).map(|(g, shadow)| g - dot(shadow)).collect()
    }
}

impl Projected {
    fn new(data: &Data, present: &Present, columns: Vec<Arc<Column>>, ridge: Ridge) -> Self {
        let mut this = Self { columns, folds: Vec::new() };
        let crosses: Vec<Crosses> =
            data.fold_ranges.iter().map(|ranges| Crosses::new(present, &this.columns, ranges)).collect();
        let total = Crosses::total(&crosses);
        this.folds = crosses
            .iter()
            .enumerate()
            .map(|(fold, own)| {
                let (rest, surviving) = total.less(own).rest(&present.folds[fold], ridge)?;
                (surviving >= INSEPARABLE || ridge != Ridge::None).then_some(rest)
            })
            .collect();
        this
    }

    /// `products[fold][column]` of the candidate's columns with `y`, weighted.
    fn products(&self, data: &Data, present: &Present, y: &[Vec<f64>]) -> Vec<Vec<f64>> {
        let product = |ranges: &Vec<Range<usize>>| -> Vec<f64> {
            self.columns.iter().map(|c| weighted_product(present, c, y, ranges)).collect()
        };
        data.fold_ranges.iter().map(product).collect()
    }

    /// Coefficients fitted without `fold`, and what they explain there.
    fn fit(&self, fold: usize, train: &[f64], products: &[Vec<f64>]) -> Option<(Vec<f64>, f64)> {
        let rest = self.folds[fold].as_ref()?;
        let own: Vec<f64> =
            super::present::sum(products).iter().zip(&products[fold]).map(|(a, b)| a - b).collect();
        let g = rest.residual_products(&own, train);
        let d = rest.factor.solve(&g);
        let explained = g.iter().zip(&d).map(|(a, b)| a * b).sum();
        Some((d, explained))
    }

    /// Writes the candidate's torque in the held-out rows, with the change of the model it brings.
    fn predict(
        &self,
        fold: usize,
        d: &[f64],
        present: &Present,
        ranges: &[Range<usize>],
        effect: &mut [Vec<f64>],
    ) {
        let Some(rest) = &self.folds[fold] else { return };
        let mut change = vec![0.0; present.width()];
        for (dk, shadow) in d.iter().zip(&rest.shadow) {
            change.iter_mut().zip(shadow).for_each(|(c, s)| *c += dk * s);
        }
        for range in ranges {
            let measured = |(joint, _): &(usize, &mut Vec<f64>)| present.weights[*joint] > 0.0;
            for (joint, rows) in effect.iter_mut().enumerate().filter(measured) {
                let rows = &mut rows[range.clone()];
                for (dk, column) in d.iter().zip(&self.columns) {
                    if let Some(part) = column.part(joint) {
                        rows.iter_mut().zip(&part[range.clone()]).for_each(|(r, c)| *r += dk * c);
                    }
                }
                present.take_away(&change, joint, range.clone(), rows);
            }
        }
    }
}

/// Products of candidate columns with the model's columns and with each other over some rows, weighted.
#[derive(Debug, Clone)]
struct Crosses {
    /// `model[candidate column][model column]`.
    model: Vec<Vec<f64>>,
    own: Vec<f64>,
}

impl Crosses {
    fn new(present: &Present, columns: &[Arc<Column>], ranges: &[Range<usize>]) -> Self {
        let n = columns.len();
        let mut this = Self { model: vec![vec![0.0; present.width()]; n], own: vec![0.0; n * n] };
        for (i, column) in columns.iter().enumerate() {
            for (joint, rows) in &column.parts {
                let w = present.weights[*joint] * present.weights[*joint];
                for range in ranges {
                    let mine = &rows[range.clone()];
                    let active = &present.active[*joint];
                    let mut places = active.iter();
                    let model = active.iter().map(|&c| &present.rows(c, *joint)[range.clone()]);
                    dots(mine, model, |dot| {
                        if let Some(&c) = places.next() {
                            this.model[i][c] += w * dot;
                        }
                    });
                    let others: Vec<(usize, &[f64])> =
                        (0..=i).filter_map(|k| Some((k, &columns[k].part(*joint)?[range.clone()]))).collect();
                    let mut places = others.iter();
                    dots(mine, others.iter().map(|(_, rows)| *rows), |dot| {
                        if let Some(&(k, _)) = places.next() {
                            this.own[i * n + k] += w * dot;
                        }
                    });
                }
            }
        }
        for i in 0..n {
            for k in 0..i {
                this.own[k * n + i] = this.own[i * n + k];
            }
        }
        this
    }

    fn total(parts: &[Self]) -> Self {
        let mut total = parts[0].clone();
        for part in &parts[1..] {
            total.own.iter_mut().zip(&part.own).for_each(|(t, x)| *t += x);
            for (t, x) in total.model.iter_mut().flatten().zip(part.model.iter().flatten()) {
                *t += x;
            }
        }
        total
    }

    fn less(&self, other: &Self) -> Self {
        let mut rest = self.clone();
        rest.own.iter_mut().zip(&other.own).for_each(|(t, x)| *t -= x);
        for (t, x) in rest.model.iter_mut().flatten().zip(other.model.iter().flatten()) {
            *t -= x;
        }
        rest
    }

    /// What is left beside the model, and the smallest surviving part of a column.
    fn rest(&self, model: &Cholesky, ridge: Ridge) -> Option<(Rest, f64)> {
        let n = self.model.len();
        let shadow: Vec<Vec<f64>> = self.model.iter().map(|cross| model.solve(cross)).collect();
        let mut h = self.own.clone();
        let mut surviving = f64::INFINITY;
        let mean = (0..n).map(|i| self.own[i * n + i]).sum::<f64>() / n.max(1) as f64;
        for i in 0..n {
            for k in 0..n {
                h[i * n + k] -= self.model[i].iter().zip(&shadow[k]).map(|(a, b)| a * b).sum::<f64>();
            }
            let own = self.own[i * n + i];
            surviving = surviving.min(if own > 0.0 { h[i * n + i] / own } else { 0.0 });
            h[i * n + i] += ridge.of(own, mean);
        }
        let factor = Cholesky::new(&h, n, 1e-9, 0.0);
        (!factor.kept.is_empty()).then_some((Rest { shadow, factor }, surviving))
    }
}

fn weighted_product(present: &Present, column: &Column, y: &[Vec<f64>], ranges: &[Range<usize>]) -> f64 {
    let mut sum = 0.0;
    for (joint, rows) in &column.parts {
        let w = present.weights[*joint] * present.weights[*joint];
        for range in ranges {
            dots(&rows[range.clone()], std::iter::once(&y[*joint][range.clone()]), |dot| sum += w * dot);
        }
    }
    sum
}

/// Scores a held-out prediction `effect` of what is missing in `residual`.
pub(super) fn judge(data: &Data, present: &Present, residual: &[Vec<f64>], effect: Vec<Vec<f64>>) -> Score {
    let n = data.count();
    let (mut cross, mut own, mut error, mut resting) = (vec![0.0; n], vec![0.0; n], 0.0, 0.0);
    let mut gain_of_joint = Vec::with_capacity(effect.len());
    for (joint, (f, r)) in effect.iter().zip(residual).enumerate() {
        let w = present.weights[joint] * present.weights[joint];
        let (mut fr, mut ff) = (0.0, 0.0);
        for k in 0..n {
            let (a, b) = (f[k] * r[k], f[k] * f[k]);
            (fr, ff) = (fr + a, ff + b);
            cross[k] += w * a;
            own[k] += w * b;
            if data.resting[joint][k] {
                resting += w * (2.0 * a - b);
            }
            error += w * r[k] * r[k];
        }
        gain_of_joint.push(2.0 * fr - ff);
    }
    let (fr, ff): (f64, f64) = (cross.iter().sum(), own.iter().sum());
    let gain = 2.0 * fr - ff;
    let z = autocorrelated_z(data, &cross, &own);
    let (without, in_one_second) = without_best_second(data, &cross, &own);
    let share = if error > 0.0 { gain / error } else { 0.0 };
    let at_rest = if gain > 0.0 { resting / gain } else { 0.0 };
    Score {
        effect,
        gain,
        share,
        gain_of_joint,
        z,
        z_without_best: without,
        in_one_second,
        at_rest,
        alternative: 0,
    }
}

/// `sum(f r) / sd(sum(f r))` with a Newey-West variance of bandwidth 1 s.
fn autocorrelated_z(data: &Data, cross: &[f64], own: &[f64]) -> f64 {
    let (fr, ff): (f64, f64) = (cross.iter().sum(), own.iter().sum());
    if !(ff > 0.0) {
        return 0.0;
    }
    let slope = fr / ff;
    let u: Vec<f64> = cross.iter().zip(own).map(|(a, b)| a - slope * b).collect();
    let variance = long_run_variance(data, &u);
    if variance > 0.0 { fr / variance.sqrt() } else { 0.0 }
}

/// Newey-West variance of the sum of a series over all runs, at least a quarter of the white one.
pub(super) fn long_run_variance(data: &Data, u: &[f64]) -> f64 {
    let white: f64 = u.iter().map(|x| x * x).sum();
    let mut total = white;
    for (range, rows) in data.run_ranges().into_iter().zip(&data.rows) {
        let (u, lags) = (&u[range], per_second(rows));
        for lag in 1..lags.min(u.len()) {
            let weight = 1.0 - lag as f64 / lags as f64;
            let mut together = 0.0;
            dots(&u[lag..], std::iter::once(&u[..u.len() - lag]), |dot| together = dot);
            total += 2.0 * weight * together;
        }
    }
    total.max(0.25 * white)
}

/// The score without the one second that helps most, and the part of the gain that this one brings.
fn without_best_second(data: &Data, cross: &[f64], own: &[f64]) -> (f64, f64) {
    let seconds = data.seconds();
    let mut gains = vec![0.0; seconds.last().map_or(0, |s| s + 1)];
    for (k, &second) in seconds.iter().enumerate() {
        gains[second] += 2.0 * cross[k] - own[k];
    }
    let best = (0..gains.len()).max_by(|&a, &b| gains[a].total_cmp(&gains[b]));
    let drop = |x: &[f64]| -> Vec<f64> {
        x.iter().zip(&seconds).map(|(x, s)| if Some(*s) == best { 0.0 } else { *x }).collect()
    };
    let part = best.map_or(0.0, |b| gains[b]) / gains.iter().sum::<f64>().max(1e-300);
    (autocorrelated_z(data, &drop(cross), &drop(own)), part)
}
