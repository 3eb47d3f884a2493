//! From samples at the full rate to the rows of a fit.

use std::ops::Range;

use super::filter::{ZeroPhase, keep_every};

/// Where the rows of a run lie in time: row `k` at `start + k * dt`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Rows {
    /// Time of the first row \[s\], on the log's own clock.
    pub start: f64,
    /// Time between rows \[s\].
    pub dt: f64,
    /// Number of rows.
    pub count: usize,
}

/// What turns a column at the full rate into rows of a fit: filter, trim, decimate. The torque and
/// every regressor column go through the same one, so none is favoured ("parallel filtering",
/// M. Gautier, "Dynamic identification of robots with power model", ICRA 1997).
#[derive(Debug, Clone, PartialEq)]
pub struct RowFilter {
    /// The band in which the model is fitted.
    pub filter: ZeroPhase,
    /// Samples far enough from both ends.
    pub range: Range<usize>,
    /// Every so-many-th of them is a row.
    pub every: usize,
}

impl RowFilter {
    /// The rows of a column given at the full rate.
    pub fn apply(&self, column: &[f64]) -> Vec<f64> {
        let mut rows = Vec::new();
        self.apply_into(column, &mut rows);
        rows
    }

    /// As [`Self::apply`], into a vector that can be used again.
    pub fn apply_into(&self, column: &[f64], rows: &mut Vec<f64>) {
        self.filter.apply_decimated(column, self.range.clone(), self.every, rows);
    }

    /// The same rows of a column that needs no filter (a time, a label, a smooth motion).
    pub fn pick(&self, column: &[f64]) -> Vec<f64> {
        let mut rows = column.to_vec();
        keep_every(&mut rows, self.range.clone(), self.every);
        rows
    }

    /// Number of rows it gives.
    pub fn count(&self) -> usize {
        self.range.len().div_ceil(self.every.max(1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn rows_are_the_filtered_samples_of_the_range() {
        let filter = ZeroPhase::butterworth(4, 5.0, 0.01).expect("a valid filter");
        let column: Vec<f64> = (0..300).map(|k| libm::sin(0.1 * k as f64) + (k % 7) as f64).collect();
        let rows = RowFilter { filter: filter.clone(), range: 50..251, every: 4 };
        let mut whole = column.clone();
        filter.apply(&mut whole);
        let kept: Vec<f64> = (50..251).step_by(4).map(|k| whole[k]).collect();
        assert_eq!(rows.apply(&column), kept);
        assert_eq!(rows.count(), kept.len());
        assert_eq!(rows.pick(&column)[1].to_bits(), column[54].to_bits());
    }
}
