//! Contacts: a force between two times, which held-out blocks cannot see because it lies inside one.

use std::ops::Range;
use std::sync::Arc;

use super::data::{Column, Data};
use super::floor::Floor;
use super::normal::Cholesky;
use super::present::{Present, rms};
use super::score::long_run_variance;
use crate::effects::ContactForce;
use crate::error::Result;

/// Lengths of windows that are tried first \[s\].
const LENGTHS: [f64; 6] = [0.5, 1.0, 1.5, 2.0, 3.0, 4.0];
/// Distance between their starts \[s\].
const STRIDE: f64 = 0.25;
/// Distance between edges in the end \[s\].
const EDGE: f64 = 0.1;
/// Least F of a contact. Nothing hidden has shown 9 at most, a twisting gear 24, a push of half a newton 250.
const LEAST_F: f64 = 60.0;
/// Least part of all reducible error that a contact must remove.
const LEAST_PART: f64 = 0.6;
/// Or it must be alone: no other window of the log, apart from it, gains more than this part of what it gains.
const SECOND: f64 = 0.25;
/// A force has two parameters more than a disturbance of one joint; each must pay this much.
const PRICE: f64 = 8.0;

/// Steps in which a contact's point is looked for, first and last, and how far from the link's origin [m].
const FIRST_STEP: f64 = 0.1;
const LAST_STEP: f64 = 0.01;
const FAR: f64 = 0.5;
/// Turns that its search takes at most.
const TURNS: usize = 20;

/// A contact that stands out.
pub(super) struct Contact {
    pub effect: ContactForce,
    pub force: [f64; 3],
    /// Its F statistic.
    pub f: f64,
}

/// Running sums over rows, so that any window costs one difference.
struct Sums {
    /// `sums[k]`: over the rows before `k`, of every product.
    sums: Vec<Vec<f64>>,
    width: usize,
    count: usize,
}

impl Sums {
    /// Products of `columns` with the model, with each other, and with the residual. Rows in which a joint nearly rests
    /// have no part in it: stiction holds any force there, and nobody knows which.
    fn new(
        data: &Data,
        present: &Present,
        columns: &[Arc<Column>],
        residual: &[Vec<f64>],
        rows: Range<usize>,
    ) -> Self {
        let (p, n) = (present.width(), columns.len());
        let mut sums = vec![vec![0.0; n * p + n * n + n]];
        for k in rows {
            let mut next = sums.last().cloned().unwrap_or_default();
            for (i, column) in columns.iter().enumerate() {
                for (joint, own) in column.parts.iter().filter(|(joint, _)| !data.resting[*joint][k]) {
                    let c = present.weights[*joint] * present.weights[*joint] * own[k];
                    if c == 0.0 {
                        continue;
                    }
                    for &m in &present.active[*joint] {
                        next[i * p + m] += c * present.rows(m, *joint)[k];
                    }
                    for (other, column) in columns.iter().enumerate() {
                        next[n * p + i * n + other] += c * column.part(*joint).map_or(0.0, |o| o[k]);
                    }
                    next[n * p + n * n + i] += c * residual[*joint][k];
                }
            }
            sums.push(next);
        }
        Self { sums, width: p, count: n }
    }

    /// The products over a window.
    fn over(&self, window: &Range<usize>) -> Vec<f64> {
        self.sums[window.end].iter().zip(&self.sums[window.start]).map(|(a, b)| a - b).collect()
    }

    /// Coefficients over a window, and the weighted squared error they remove.
    fn window(&self, factor: &Cholesky, window: &Range<usize>) -> Option<(Vec<f64>, f64)> {
        let (p, n) = (self.width, self.count);
        let s = self.over(window);
        let mut h = s[n * p..n * p + n * n].to_vec();
        for k in 0..n {
            let shadow = factor.solve(&s[k * p..(k + 1) * p]);
            for i in 0..n {
                h[i * n + k] -= s[i * p..(i + 1) * p].iter().zip(&shadow).map(|(a, b)| a * b).sum::<f64>();
            }
        }
        let g = &s[n * p + n * n..];
        let h = Cholesky::new(&h, n, 1e-6, 0.0);
        if h.kept.is_empty() {
            return None;
        }
        let d = h.solve(g);
        let gain = g.iter().zip(&d).map(|(a, b)| a * b).sum();
        Some((d, gain))
    }
}

/// The strongest contact, where one stands out from everything else.
pub(super) fn contact(data: &Data, present: &Present, floor: &Floor) -> Result<Option<Contact>> {
    let mut best: Option<Contact> = None;
    for run in (0..data.runs.len()).filter(|&r| data.changed[r]) {
        let found = in_run(data, present, floor, run)?;
        if let Some(found) = found
            && best.as_ref().is_none_or(|b| found.f > b.f)
        {
            best = Some(found);
        }
    }
    Ok(best)
}

fn in_run(data: &Data, present: &Present, floor: &Floor, run: usize) -> Result<Option<Contact>> {
    let (rows, span) = (&data.rows[run], data.run_ranges()[run].clone());
    let name = data.runs[run].name.clone();
    // Named even where there is one log only: another one knows nothing of it.
    let log = Some(name);
    let end = rows.start + rows.count as f64 * rows.dt;
    let whole = ContactForce {
        from_s: rows.start - 1e3,
        to_s: end + 1e3,
        link: None,
        point: [0.0; 3],
        log: log.clone(),
    };
    let columns: Vec<Arc<Column>> = data.columns(&whole)?.into_iter().map(Arc::new).collect();
    let mut here = Here::new(data, present.clone(), span);
    let per = |seconds: f64| (libm::round(seconds / rows.dt) as usize).max(1);
    let mut second = f64::INFINITY;
    for round in 0..3 {
        let sums = here.sums(&columns);
        let try_window = |w: Range<usize>| sums.window(&here.present.all, &w).map(|(d, gain)| (w, d, gain));
        let candidates: Vec<Range<usize>> =
            if round == 0 { coarse(rows.count, &per) } else { edges(&here.window, rows.count, per(EDGE)) };
        let tried: Vec<_> = candidates.into_iter().filter_map(try_window).collect();
        let best = tried.iter().reduce(|a, b| if b.2 > a.2 { b } else { a });
        let Some((w, d, gain)) = best.cloned() else { return Ok(None) };
        if round == 0 {
            let apart = tried.iter().filter(|(other, _, _)| other.end <= w.start || w.end <= other.start);
            second = apart.map(|t| t.2).fold(0.0, f64::max) / gain.max(1e-300);
        }
        here.window = w;
        let after = here.without(&columns, &d, &sums);
        here.weigh(outside_weights(data, &after, &here.rows()));
    }
    // Once more with weights that know nothing of the contact.
    let sums = here.sums(&columns);
    let Some((d, gain)) = sums.window(&here.present.all, &here.window) else { return Ok(None) };
    let after = here.without(&columns, &d, &sums);
    let kappa = autocorrelation(data, &after, &here.rows());
    let f = gain / 3.0 / kappa;
    let alone = removed(data, floor, &here.residual, &after) >= LEAST_PART || second <= SECOND;
    if f < LEAST_F || !alone || gain <= here.one_joint() + 2.0 * PRICE * kappa {
        return Ok(None);
    }
    let time = |row: usize| rows.start + row as f64 * rows.dt;
    let (from_s, to_s) = (time(here.window.start), time(here.window.end));
    let origin = ContactForce { from_s, to_s, link: None, point: [0.0; 3], log };
    let (effect, force) = here.point(origin, [d[0], d[1], d[2]], 3.0 * PRICE * kappa)?;
    Ok(Some(Contact { effect, force, f }))
}

/// A contact in a window of one run. The joints are weighed anew in every round, and everything is fitted with the same
/// weights.
struct Here<'a> {
    data: &'a Data,
    present: Present,
    /// Of the model without a contact.
    residual: Vec<Vec<f64>>,
    /// Rows of the run.
    span: Range<usize>,
    /// Rows of the contact, counted from the run's first.
    window: Range<usize>,
}

impl<'a> Here<'a> {
    fn new(data: &'a Data, present: Present, span: Range<usize>) -> Self {
        let residual = present.residual_of(&data.tau, &present.fit(&data.tau));
        Self { data, present, residual, span, window: 0..0 }
    }

    fn weigh(&mut self, weights: Vec<f64>) {
        self.present = self.present.reweighted(weights);
        self.residual = self.present.residual_of(&self.data.tau, &self.present.fit(&self.data.tau));
    }

    fn sums(&self, columns: &[Arc<Column>]) -> Sums {
        Sums::new(self.data, &self.present, columns, &self.residual, self.span.clone())
    }

    /// Coefficients of some columns over the window, and the weighted squared error they remove.
    fn fitted(&self, columns: &[Arc<Column>]) -> Option<(Vec<f64>, f64)> {
        let sums = Sums::new(self.data, &self.present, columns, &self.residual, self.rows());
        sums.window(&self.present.all, &(0..self.window.len()))
    }

    /// What a disturbance of a single joint's torque would remove over the same window, at most.
    fn one_joint(&self) -> f64 {
        let of = |joint| self.fitted(&[Arc::new(self.data.column_of(joint, |_, out| out.fill(1.0)))]);
        (0..self.data.dof()).filter_map(of).map(|(_, gain)| gain).fold(0.0, f64::max)
    }

    /// Rows of the window, counted over all runs.
    fn rows(&self) -> Range<usize> {
        self.span.start + self.window.start..self.span.start + self.window.end
    }

    /// Residual with a force of these coefficients in the model.
    fn without(&self, columns: &[Arc<Column>], d: &[f64], sums: &Sums) -> Vec<Vec<f64>> {
        let (p, s) = (sums.width, sums.over(&self.window));
        let mut cross = vec![0.0; p];
        for (i, dk) in d.iter().enumerate() {
            cross.iter_mut().zip(&s[i * p..(i + 1) * p]).for_each(|(c, x)| *c += dk * x);
        }
        // The model gives back what it had taken of the force.
        let back: Vec<f64> = self.present.all.solve(&cross).into_iter().map(|x| -x).collect();
        let left = |(joint, residual): (usize, &Vec<f64>)| {
            let mut rest = residual.clone();
            for (dk, column) in d.iter().zip(columns) {
                let Some(part) = column.part(joint) else { continue };
                for k in self.rows().filter(|&k| !self.data.resting[joint][k]) {
                    rest[k] -= dk * part[k];
                }
            }
            let rows = 0..rest.len();
            self.present.take_away(&back, joint, rows, &mut rest);
            rest
        };
        self.residual.iter().enumerate().map(left).collect()
    }

    /// The force of a contact, and the weighted squared error it removes.
    fn force(&self, effect: &ContactForce) -> Result<Option<([f64; 3], f64)>> {
        let columns: Vec<Arc<Column>> = self.data.columns(effect)?.into_iter().map(Arc::new).collect();
        Ok(self.fitted(&columns).map(|(d, gain)| ([d[0], d[1], d[2]], gain)))
    }

    /// The point of the last link that the force acts on, where another than its origin explains `worth` more.
    fn point(&self, origin: ContactForce, force: [f64; 3], worth: f64) -> Result<(ContactForce, [f64; 3])> {
        let Some((_, from)) = self.force(&origin)? else { return Ok((origin, force)) };
        let mut best = (origin.clone(), force, from);
        let (mut step, mut turns) = (FIRST_STEP, 0);
        while step >= LAST_STEP && turns < TURNS {
            let mut moved = false;
            turns += 1;
            for (axis, sign) in (0..3).flat_map(|axis| [(axis, 1.0), (axis, -1.0)]) {
                let mut effect = best.0.clone();
                effect.point[axis] = (effect.point[axis] + sign * step).clamp(-FAR, FAR);
                if let Some((force, gain)) = self.force(&effect)?.filter(|(_, gain)| *gain > best.2) {
                    (best, moved) = ((effect, force, gain), true);
                }
            }
            step *= if moved { 1.0 } else { 0.5 };
        }
        Ok(if best.2 > from + worth { (best.0, best.1) } else { (origin, force) })
    }
}

fn coarse(count: usize, per: &dyn Fn(f64) -> usize) -> Vec<Range<usize>> {
    let mut all = Vec::new();
    for length in LENGTHS.map(per) {
        let mut start = 0;
        while start + length <= count {
            all.push(start..start + length);
            start += per(STRIDE);
        }
    }
    all
}

fn edges(window: &Range<usize>, count: usize, step: usize) -> Vec<Range<usize>> {
    let near = |x: usize| -> Vec<usize> {
        (0..=12).filter_map(|k| (x + k * step).checked_sub(6 * step)).filter(|&x| x <= count).collect()
    };
    let ends = near(window.end);
    near(window.start)
        .into_iter()
        .flat_map(|a| ends.iter().map(move |&b| a..b))
        .filter(|w| w.start + 2 * step <= w.end)
        .collect()
}

/// One over the rms of each joint outside a window; none for joints without a measurement.
fn outside_weights(data: &Data, residual: &[Vec<f64>], window: &Range<usize>) -> Vec<f64> {
    let outside = |r: &Vec<f64>| -> Vec<f64> {
        r.iter().enumerate().filter(|(k, _)| !window.contains(k)).map(|(_, x)| *x).collect()
    };
    let weight =
        |(r, silent): (&Vec<f64>, &bool)| if *silent { 0.0 } else { 1.0 / rms(&outside(r)).max(1e-12) };
    residual.iter().zip(&data.silent).map(weight).collect()
}

/// How much larger sums of the residual vary than if its rows were independent, outside the window.
fn autocorrelation(data: &Data, residual: &[Vec<f64>], window: &Range<usize>) -> f64 {
    let factors: Vec<f64> = residual
        .iter()
        .zip(&data.silent)
        .filter(|(_, silent)| !**silent)
        .map(|(r, _)| {
            let mut outside = r.clone();
            outside[window.clone()].fill(0.0);
            let white: f64 = outside.iter().map(|x| x * x).sum();
            if white > 0.0 { long_run_variance(data, &outside) / white } else { 1.0 }
        })
        .collect();
    (factors.iter().sum::<f64>() / factors.len().max(1) as f64).max(1.0)
}

/// Part of all reducible error, in units of the noise floors, that a contact removes.
fn removed(data: &Data, floor: &Floor, before: &[Vec<f64>], after: &[Vec<f64>]) -> f64 {
    let (mut gain, mut excess) = (0.0, 0.0);
    let counts = |joint: &usize| !data.silent[*joint] && !data.still[*joint];
    for joint in (0..data.dof()).filter(counts) {
        let floor = floor.rms[joint];
        let square = |r: &[f64]| r.iter().map(|x| x * x).sum::<f64>() / (floor * floor);
        gain += square(&before[joint]) - square(&after[joint]);
        excess += (square(&before[joint]) - data.counted[joint]).max(0.0);
    }
    if excess > 0.0 { gain / excess } else { 0.0 }
}
