//! The rows of the regressor, in pieces small enough to stay in the cache and in an order that does not
//! depend on the number of threads.

use std::ops::Range;

use rayon::prelude::*;

use crate::error::Result;
use crate::model::{Model, ModelBlock};
use crate::signals::Run;

/// Rows handled by one task; fixed, so that sums are the same on any number of threads.
const UNIT: usize = 8192;
/// Units under way at a time, per thread; the results do not depend on it.
const UNITS_PER_THREAD: usize = 8;
/// Rows worked on at once when nothing is filtered.
const STRETCH: usize = 128;
/// Samples filtered at once.
const FILTERED_SAMPLES: usize = 16_384;

/// A few consecutive rows of every joint, with their torque.
pub struct RowView<'a> {
    /// Which run.
    pub run: usize,
    /// Row numbers within the run.
    pub rows: Range<usize>,
    block: &'a ModelBlock,
    offset: usize,
    tau: &'a [Vec<f64>],
    tau_offset: usize,
}

impl RowView<'_> {
    /// Column `local` (an index into [`Model::active`]) in the rows of `joint`.
    pub fn column(&self, joint: usize, local: usize) -> &[f64] {
        let at = local * self.block.stride + self.offset;
        &self.block.joints[joint][at..at + self.rows.len()]
    }

    /// Torque of `joint`.
    pub fn tau(&self, joint: usize) -> &[f64] {
        &self.tau[joint][self.tau_offset..self.tau_offset + self.rows.len()]
    }

    /// Part of this view: rows `from..to` counted within it.
    fn part(&self, from: usize, to: usize) -> Self {
        Self {
            run: self.run,
            rows: self.rows.start + from..self.rows.start + to,
            block: self.block,
            offset: self.offset + from,
            tau: self.tau,
            tau_offset: self.tau_offset + from,
        }
    }

    /// Cuts the view where `key` of a row number changes, and at most a few hundred rows long.
    pub fn split_by<K: PartialEq>(
        &self,
        key: impl Fn(usize) -> K,
        mut visit: impl FnMut(K, &RowView<'_>) -> Result<()>,
    ) -> Result<()> {
        let mut from = 0;
        while from < self.rows.len() {
            let k = key(self.rows.start + from);
            let mut to = from + 1;
            while to < self.rows.len() && to - from < STRETCH && key(self.rows.start + to) == k {
                to += 1;
            }
            visit(k, &self.part(from, to))?;
            from = to;
        }
        Ok(())
    }
}

/// Runs `work` over all rows in parallel, each task with its own `start()` value, and returns those values
/// in the order of the rows.
///
/// # Errors
/// The first error of `work` in the order of the rows.
pub fn over_rows<T: Send>(
    model: &Model,
    runs: &[Run],
    start: impl Fn() -> T + Sync,
    work: impl Fn(&mut T, &RowView<'_>) -> Result<()> + Sync,
) -> Result<Vec<T>> {
    let mut values = Vec::new();
    over_rows_in_turn(model, runs, start, work, |value| values.push(value))?;
    Ok(values)
}

/// As [`over_rows`], but hands the values on to `take` in the order of the rows, and holds only a few of
/// them at a time.
///
/// # Errors
/// The first error of `work` in the order of the rows.
pub fn over_rows_in_turn<T: Send>(
    model: &Model,
    runs: &[Run],
    start: impl Fn() -> T + Sync,
    work: impl Fn(&mut T, &RowView<'_>) -> Result<()> + Sync,
    mut take: impl FnMut(T),
) -> Result<()> {
    let units: Vec<(usize, Range<usize>)> = runs
        .iter()
        .enumerate()
        .flat_map(|(run, r)| {
            let rows = r.rows().count;
            (0..rows.div_ceil(UNIT)).map(move |u| (run, u * UNIT..((u + 1) * UNIT).min(rows)))
        })
        .collect();
    let wave = UNITS_PER_THREAD * rayon::current_num_threads();
    for units in units.chunks(wave) {
        let values: Result<Vec<T>> = units
            .par_iter()
            .map(|(run, range)| {
                let (run, range) = (*run, range.clone());
                let mut value = start();
                let mut each = |view: &RowView<'_>| work(&mut value, view);
                match &runs[run].row_filter {
                    None => plain(model, runs, run, range, &mut each)?,
                    Some(_) => filtered(model, runs, run, range, &mut each)?,
                }
                Ok(value)
            })
            .collect();
        values?.into_iter().for_each(&mut take);
    }
    Ok(())
}

type Visit<'a> = &'a mut dyn FnMut(&RowView<'_>) -> Result<()>;

/// Rows are samples: fill and visit stretch by stretch.
fn plain(model: &Model, runs: &[Run], run: usize, range: Range<usize>, visit: Visit<'_>) -> Result<()> {
    let mut block = ModelBlock::new(model, STRETCH);
    let from = &runs[run];
    for first in range.clone().step_by(STRETCH) {
        let rows = first..(first + STRETCH).min(range.end);
        model.fill(from, rows.clone(), &mut block)?;
        visit(&RowView { run, rows, block: &block, offset: 0, tau: &from.tau, tau_offset: first })?;
    }
    Ok(())
}

/// Rows are filtered and decimated samples: fill a longer piece, so that what the filter makes of its
/// cut ends has died away where the rows begin.
fn filtered(model: &Model, runs: &[Run], run: usize, range: Range<usize>, visit: Visit<'_>) -> Result<()> {
    let from = &runs[run];
    let Some(plan) = &from.row_filter else { return Ok(()) };
    let (every, origin) = (plan.every, plan.range.start);
    let per_piece = (FILTERED_SAMPLES / every).max(1);
    let margin = plan.filter.settle_samples(1e-17);
    for first in range.clone().step_by(per_piece) {
        let rows = first..(first + per_piece).min(range.end);
        let samples = origin + rows.start * every..origin + (rows.end - 1) * every + 1;
        let wide = samples.start.saturating_sub(margin)..(samples.end + margin).min(from.samples());
        let mut block = ModelBlock::new(model, wide.len());
        model.fill(from, wide.clone(), &mut block)?;
        let tau = from.tau.iter().take(block.joints.len()).map(|tau| &tau[wide.clone()]);
        let columns: Vec<&[f64]> =
            block.joints.iter().flat_map(|data| data.chunks_exact(block.stride)).chain(tau).collect();
        let mut kept = vec![0.0; columns.len() * rows.len()];
        let mut places: Vec<&mut [f64]> = kept.chunks_exact_mut(rows.len()).collect();
        plan.filter.apply_together(&columns, samples.start - wide.start, every, &mut places);
        let mut kept = kept.as_slice();
        let mut next = |columns: usize| -> Vec<f64> {
            let (own, others) = kept.split_at(columns * rows.len());
            kept = others;
            own.to_vec()
        };
        let left_out = |joint: usize, mut columns: Vec<f64>| {
            columns.chunks_exact_mut(rows.len()).for_each(|column| from.leave_out(joint, rows.start, column));
            columns
        };
        for (joint, data) in block.joints.iter_mut().enumerate() {
            *data = left_out(joint, next(data.len() / block.stride));
        }
        let tau: Vec<Vec<f64>> = (0..block.joints.len()).map(|joint| left_out(joint, next(1))).collect();
        block.stride = rows.len();
        visit(&RowView { run, rows, block: &block, offset: 0, tau: &tau, tau_offset: 0 })?;
    }
    Ok(())
}
