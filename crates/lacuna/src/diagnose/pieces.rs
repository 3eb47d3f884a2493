//! The stretches of a run whose columns are computed at once, and the filter that they pass side by side.

use std::ops::Range;

use super::data::Column;
use crate::signals::Run;

/// Samples handled at once when columns are filtered.
const PIECE: usize = 16_384;
/// Columns that are filtered together.
const TOGETHER: usize = 8;

/// Part of a run whose columns are computed at once, wide enough that the filter has settled in its rows.
#[derive(Debug, Clone)]
pub(super) struct Piece {
    pub samples: Range<usize>,
    /// Samples of the rows, counted within `samples`.
    inner: Range<usize>,
    /// Number of rows.
    pub rows: usize,
}

impl Piece {
    /// The pieces of a run, one after the other.
    pub fn of(run: &Run) -> Vec<Self> {
        let Some(plan) = &run.row_filter else {
            let all = run.samples();
            return vec![Self { samples: 0..all, inner: 0..all, rows: all }];
        };
        let (every, origin, count) = (plan.every, plan.range.start, plan.count());
        let per_piece = (PIECE / every).max(1);
        let margin = plan.filter.settle_samples(1e-12);
        (0..count)
            .step_by(per_piece)
            .map(|first| {
                let last = (first + per_piece).min(count);
                let (from, to) = (origin + first * every, origin + (last - 1) * every + 1);
                let samples = from.saturating_sub(margin)..(to + margin).min(run.samples());
                Self { inner: from - samples.start..to - samples.start, samples, rows: last - first }
            })
            .collect()
    }
}

/// Where a column goes: number of the effect, of its term, and of the joint among those that the term reaches.
pub(super) type Place = (usize, usize, usize);

/// Columns over one piece that wait for others to be filtered with.
pub(super) struct Queue<'a> {
    run: &'a Run,
    piece: &'a Piece,
    room: Vec<f64>,
    waiting: Vec<Place>,
}

impl<'a> Queue<'a> {
    /// Nothing waits yet.
    pub fn new(run: &'a Run, piece: &'a Piece) -> Self {
        Self { run, piece, room: Vec::new(), waiting: Vec::new() }
    }

    /// Takes in what `fill` makes of a zeroed column; a full queue is let through.
    pub fn push(&mut self, place: Place, fill: &mut dyn FnMut(&mut [f64]), columns: &mut [Vec<Column>]) {
        let from = self.room.len();
        self.room.resize(from + self.piece.samples.len(), 0.0);
        fill(&mut self.room[from..]);
        self.waiting.push(place);
        if self.waiting.len() == TOGETHER {
            self.let_through(columns);
        }
    }

    /// Filters what waits and puts its rows at the end of its columns.
    pub fn let_through(&mut self, columns: &mut [Vec<Column>]) {
        let mut put = |&(effect, term, place): &Place, rows: &[f64]| {
            columns[effect][term].parts[place].1.extend_from_slice(rows);
        };
        let all: Vec<&[f64]> = self.room.chunks_exact(self.piece.samples.len().max(1)).collect();
        match &self.run.row_filter {
            None => self.waiting.iter().zip(all).for_each(|(place, rows)| put(place, rows)),
            Some(plan) => {
                let count = self.piece.rows;
                let mut kept = vec![0.0; count * all.len()];
                let mut rows: Vec<&mut [f64]> = kept.chunks_exact_mut(count).collect();
                plan.filter.apply_together(&all, self.piece.inner.start, plan.every, &mut rows);
                self.waiting.iter().zip(rows).for_each(|(place, rows)| put(place, rows));
            }
        }
        self.room.clear();
        self.waiting.clear();
    }
}
