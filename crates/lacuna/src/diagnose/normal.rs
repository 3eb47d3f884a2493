//! Small dense positive definite systems.

/// Lower Cholesky factor of a scaled normal matrix over the columns that are independent.
#[derive(Debug, Clone)]
pub(super) struct Cholesky {
    /// Numbers of the columns that are kept.
    pub kept: Vec<usize>,
    /// Scale of each kept column.
    scale: Vec<f64>,
    /// Rows of the factor, one after the other.
    factor: Vec<f64>,
}

impl Cholesky {
    /// Factors the matrix `a` (`n x n`, rows one after the other). A column whose remainder beside the
    /// columns before it is below `tolerance` of its size is left out; `ridge` is added to the scaled diagonal.
    pub fn new(a: &[f64], n: usize, tolerance: f64, ridge: f64) -> Self {
        let scale_of = |i: usize| {
            let d = a[i * n + i];
            if d > 0.0 { 1.0 / d.sqrt() } else { 0.0 }
        };
        let mut this = Self { kept: Vec::new(), scale: Vec::new(), factor: Vec::new() };
        let mut row = Vec::with_capacity(n);
        for i in 0..n {
            let si = scale_of(i);
            if si <= 0.0 || !si.is_finite() {
                continue;
            }
            row.clear();
            let mut start = 0;
            for (k, &j) in this.kept.iter().enumerate() {
                let other = &this.factor[start..start + k + 1];
                let dot: f64 = row.iter().zip(other).map(|(x, y)| x * y).sum();
                row.push((a[i * n + j] * si * this.scale[k] - dot) / other[k]);
                start += k + 1;
            }
            let rest = 1.0 + ridge - row.iter().map(|x| x * x).sum::<f64>();
            if rest > tolerance {
                row.push(rest.sqrt());
                this.factor.extend_from_slice(&row);
                this.kept.push(i);
                this.scale.push(si);
            }
        }
        this
    }

    /// Solves for `b` (full length); left-out columns get 0.
    pub fn solve(&self, b: &[f64]) -> Vec<f64> {
        let m = self.kept.len();
        let mut x: Vec<f64> = self.kept.iter().zip(&self.scale).map(|(&i, s)| b[i] * s).collect();
        let mut start = 0;
        for k in 0..m {
            let row = &self.factor[start..start + k + 1];
            let dot: f64 = row[..k].iter().zip(&x).map(|(l, y)| l * y).sum();
            x[k] = (x[k] - dot) / row[k];
            start += k + 1;
        }
        for k in (0..m).rev() {
            start -= k + 1;
            let row = &self.factor[start..start + k + 1];
            x[k] /= row[k];
            let xk = x[k];
            for (y, l) in x[..k].iter_mut().zip(row) {
                *y -= l * xk;
            }
        }
        let mut full = vec![0.0; b.len()];
        for ((&i, s), y) in self.kept.iter().zip(&self.scale).zip(&x) {
            full[i] = y * s;
        }
        full
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn solves_and_leaves_out_what_depends() {
        // The third column is the sum of the first two.
        let a = [4.0, 1.0, 5.0, 1.0, 3.0, 4.0, 5.0, 4.0, 9.0];
        let factor = Cholesky::new(&a, 3, 1e-10, 0.0);
        assert_eq!(factor.kept, [0, 1]);
        let x = factor.solve(&[6.0, 7.0, 13.0]);
        assert!((4.0 * x[0] + x[1] - 6.0).abs() < 1e-12 && (x[0] + 3.0 * x[1] - 7.0).abs() < 1e-12);
        assert!(x[2].abs() < 1e-15);
    }
}
