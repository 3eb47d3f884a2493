//! The triangular factor of a tall matrix that is never held: rows come in blocks and are folded in by
//! Householder reflections (streaming QR, also known as square-root information form).

use super::lanes::{Reflect, WIDTH, add_scaled};
use super::{LINE_LENGTH, line_start};

/// Upper-triangular `R` with `RᵀR = AᵀA` for all rows absorbed so far. By custom the last column of `A`
/// is the right-hand side, so `R` holds everything least squares needs: normal matrix, projection, and
/// the residual norm in the last diagonal entry.
///
/// Unlike the normal equations it keeps the condition number unsquared, and two triangles of different
/// rows can be merged.
#[derive(Debug, Clone, PartialEq)]
pub struct Triangle {
    columns: usize,
    /// Column by column, `columns` entries each; zero below the diagonal.
    r: Vec<f64>,
    rows: usize,
}

impl Triangle {
    /// No rows yet.
    pub fn new(columns: usize) -> Self {
        Self { columns, r: vec![0.0; columns * columns], rows: 0 }
    }

    /// Number of columns, the right-hand side included.
    pub fn columns(&self) -> usize {
        self.columns
    }

    /// Number of rows absorbed, merged triangles included.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Entry of `R` (0 below the diagonal).
    pub fn at(&self, row: usize, column: usize) -> f64 {
        self.r[column * self.columns + row]
    }

    /// Length that a block's columns must be padded to (with zeros) for `rows` rows.
    pub fn padded(rows: usize) -> usize {
        rows.next_multiple_of(WIDTH)
    }

    /// The part of `room`, grown where it is too short, that makes a block for [`Triangle::absorb`] of
    /// `columns` columns and `rows` rows, beginning at a cache line. What it holds is left from its last use.
    pub fn block(room: &mut Vec<f64>, columns: usize, rows: usize) -> &mut [f64] {
        let length = columns * Self::padded(rows);
        if room.len() < length + LINE_LENGTH {
            *room = vec![0.0; length + LINE_LENGTH];
        }
        let first = line_start(room);
        &mut room[first..first + length]
    }

    /// Absorbs `rows` rows given column by column in `block`, each column [`Triangle::padded`] long with
    /// zeros behind the last row. The block is used as scratch space.
    ///
    /// # Panics
    /// When the block's length is not `columns * padded(rows)`.
    pub fn absorb(&mut self, block: &mut [f64], rows: usize) {
        let length = Self::padded(rows);
        assert_eq!(block.len(), length * self.columns);
        self.reflect(block, length, |_| length);
        self.rows += rows;
    }

    /// Folds in a block of columns `length` long, of which the first `reach(j)` rows of column `j` and those before it
    /// may differ from zero.
    fn reflect(&mut self, block: &mut [f64], length: usize, reach: impl Fn(usize) -> usize) {
        if length == 0 {
            return;
        }
        let n = self.columns;
        let (mut tops, mut scales) = (vec![0.0; n], vec![0.0; n]);
        let none = vec![0.0; length];
        // The reflection that the columns from j on have received only in the top row.
        let mut pending: Option<usize> = None;
        for j in 0..n {
            let (left, others) = block.split_at_mut(j * length);
            let (pivot, others) = others.split_at_mut(length);
            let reached = reach(j);
            let pivot = &mut pivot[..reached];
            let before = pending.map_or(&none[..reached], |p| &left[p * length..][..reached]);
            let below = add_scaled(pivot, scales[j], before);
            if below > 0.0 {
                let alpha = self.r[j * n + j];
                let norm = (alpha * alpha + below).sqrt();
                let beta = if alpha > 0.0 { -norm } else { norm };
                let head = alpha - beta;
                let over_both = 1.0 / (beta * head);
                let (tops, scales) = (&mut tops[j + 1..], &mut scales[j + 1..]);
                for (k, top) in (j + 1..n).zip(tops.iter_mut()) {
                    *top = self.r[k * n + j];
                }
                let (stride, over_beta) = (length, 1.0 / beta);
                Reflect { before, pivot, others, stride, tops, scales, head, over_beta, over_both }.run();
                for (k, top) in (j + 1..n).zip(tops) {
                    self.r[k * n + j] = *top;
                }
                self.r[j * n + j] = beta;
                pending = Some(j);
            }
        }
    }

    /// Absorbs another triangle with its rows scaled by `weight`: column `i` of `other` goes to `places[i]`,
    /// or nowhere (its parameter is then taken as zero).
    ///
    /// # Panics
    /// When `places` has not one entry per column of `other`.
    pub fn merge(&mut self, other: &Triangle, places: &[Option<usize>], weight: f64) {
        assert_eq!(places.len(), other.columns);
        let length = Self::padded(other.columns);
        let mut block = vec![0.0; length * self.columns];
        let mut reach = vec![0; self.columns];
        for (from, to) in places.iter().enumerate() {
            let Some(to) = to else { continue };
            reach[*to] = Self::padded(from + 1);
            for row in 0..=from {
                block[to * length + row] = weight * other.at(row, from);
            }
        }
        // A triangle has nothing below its diagonal, and reflections at its columns in turn put nothing there.
        for j in 1..self.columns {
            reach[j] = reach[j].max(reach[j - 1]);
        }
        self.reflect(&mut block, length, |j| reach[j]);
        self.rows += other.rows;
    }

    /// Absorbs another triangle with the same columns.
    pub fn merge_same(&mut self, other: &Triangle) {
        let places: Vec<_> = (0..self.columns).map(Some).collect();
        self.merge(other, &places, 1.0);
    }

    /// Sum of squares of `A x` over all rows, with `x` of one entry per column (`-1` or `1` in the last
    /// gives a residual).
    pub fn squares(&self, x: &[f64]) -> f64 {
        let n = self.columns;
        (0..n)
            .map(|i| {
                let sum: f64 = (i..n).map(|j| self.at(i, j) * x[j]).sum();
                sum * sum
            })
            .sum()
    }

    /// Sum of squares of one column.
    pub fn column_squares(&self, column: usize) -> f64 {
        (0..=column).map(|i| self.at(i, column) * self.at(i, column)).sum()
    }

    /// Columns (the last excluded) that depend on those before them, or are zero.
    pub fn dependent_columns(&self) -> Vec<usize> {
        let depends = |j: &usize| {
            let size = self.column_squares(*j).sqrt();
            size <= 0.0 || self.at(*j, *j).abs() <= 1e-9 * size
        };
        (0..self.columns - 1).filter(depends).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A triangle of rows without any order in them.
    fn triangle(columns: usize, rows: usize, seed: usize) -> Triangle {
        let mut room = Vec::new();
        let mut all = Triangle::new(columns);
        let block = Triangle::block(&mut room, columns, rows);
        for (j, column) in block.chunks_exact_mut(Triangle::padded(rows)).enumerate() {
            for (k, y) in column[..rows].iter_mut().enumerate() {
                *y = libm::sin((seed + 7 * k * (j + 1) + j) as f64);
            }
        }
        all.absorb(block, rows);
        all
    }

    #[test]
    fn merging_skips_the_zeros_of_a_triangle_and_keeps_the_bits() {
        let columns = 45;
        let (one, other) = (triangle(columns, 200, 1), triangle(columns, 130, 2));
        let (mut merged, mut absorbed) = (one.clone(), one);
        merged.merge_same(&other);
        let mut room = Vec::new();
        let block = Triangle::block(&mut room, columns, columns);
        for (j, column) in block.chunks_exact_mut(Triangle::padded(columns)).enumerate() {
            (0..columns).for_each(|i| column[i] = other.at(i, j));
        }
        absorbed.absorb(block, columns);
        let bits = |t: &Triangle| t.r.iter().map(|x| x.to_bits()).collect::<Vec<_>>();
        assert_eq!(bits(&merged), bits(&absorbed));
    }
}
