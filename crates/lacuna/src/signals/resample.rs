//! Linear interpolation onto a uniform grid.

/// Where each point of a uniform grid lies between the kept rows of a log.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Grid {
    /// For each grid point: the row (of the log) at or before it, the next one, and the share of the
    /// way between them.
    points: Vec<(u32, u32, f64)>,
    /// Grid points inside gaps, i.e. without a row within one sampling time.
    pub filled: usize,
    /// Longest distance between neighbouring rows, in sampling times.
    pub longest: f64,
}

impl Grid {
    /// `at[i]` is the place of row `rows[i]` on the clock in sampling times, increasing from 0.
    pub fn new(rows: &[usize], at: &[f64]) -> Self {
        let end = at.last().copied().unwrap_or(0.0);
        let mut grid = Self { points: Vec::with_capacity(end as usize + 1), filled: 0, longest: 0.0 };
        for i in 0..rows.len().saturating_sub(1) {
            let width = at[i + 1] - at[i];
            grid.longest = grid.longest.max(width);
            while (grid.points.len() as f64) < at[i + 1] {
                let share = (grid.points.len() as f64 - at[i]) / width;
                grid.filled += usize::from(width > 1.5 && share > 0.0);
                grid.points.push((rows[i] as u32, rows[i + 1] as u32, share));
            }
        }
        if let Some(&row) = rows.last().filter(|_| grid.points.len() as f64 <= end) {
            grid.points.push((row as u32, row as u32, 0.0));
        }
        grid
    }

    /// Number of grid points.
    pub fn len(&self) -> usize {
        self.points.len()
    }

    /// The column on the grid; where a row lies on a grid point its value is copied bit by bit.
    pub fn apply(&self, column: &[f64]) -> Vec<f64> {
        let between = |&(low, high, share): &(u32, u32, f64)| {
            let value = column[low as usize];
            if share > 0.0 { value + share * (column[high as usize] - value) } else { value }
        };
        self.points.iter().map(between).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::Grid;

    #[test]
    fn rows_on_the_grid_are_copied_and_gaps_filled_linearly() {
        let column = [1.0, f64::NAN, 2.0, 6.0, 7.0];
        let grid = Grid::new(&[0, 2, 3, 4], &[0.0, 1.0, 5.0, 6.0]);
        assert_eq!(grid.apply(&column), [1.0, 2.0, 3.0, 4.0, 5.0, 6.0, 7.0]);
        assert_eq!((grid.len(), grid.filled), (7, 3));
        assert!((grid.longest - 4.0).abs() < 1e-15);
    }

    #[test]
    fn a_straight_line_stays_straight_under_uneven_stamps() {
        let at = [0.0, 0.8, 2.1, 2.9, 4.2, 5.3];
        let column: Vec<f64> = at.iter().map(|x| 3.0 * x - 1.0).collect();
        let grid = Grid::new(&[0, 1, 2, 3, 4, 5], &at);
        for (k, y) in grid.apply(&column).iter().enumerate() {
            assert!((y - (3.0 * k as f64 - 1.0)).abs() < 1e-13);
        }
        assert_eq!((grid.len(), grid.filled), (6, 0));
    }
}
