//! Cholesky factors: one for the Newton system, one for the small blocks of semidefinite forms.
//!
//! Sums run in an order that does not depend on the width of the processor's registers.

use pulp::{Arch, Simd, WithSimd};

/// Factors the symmetric matrix whose lower triangle stands in `a` (column by column, `n x n`) in place;
/// `false` when it is not positive definite.
pub(super) fn factor(a: &mut [f64], n: usize) -> bool {
    Arch::new().dispatch(Factor { a, n })
}

struct Factor<'a> {
    a: &'a mut [f64],
    n: usize,
}

impl WithSimd for Factor<'_> {
    type Output = bool;

    // The loops are plain; `dispatch` compiles them for the widest registers of the processor.
    #[inline(always)]
    fn with_simd<S: Simd>(self, _simd: S) -> bool {
        let n = self.n;
        for j in 0..n {
            let (done, rest) = self.a.split_at_mut(j * n);
            let column = &mut rest[j..n];
            subtract_earlier(done, column, j, n);
            let pivot = column[0];
            if !(pivot > 0.0 && pivot.is_finite()) {
                return false;
            }
            let root = pivot.sqrt();
            column.iter_mut().for_each(|v| *v /= root);
        }
        true
    }
}

/// Takes the contribution of the finished columns off column `j`, four at a time.
#[inline(always)]
fn subtract_earlier(done: &[f64], column: &mut [f64], j: usize, n: usize) {
    let mut quads = done.chunks_exact(4 * n);
    for four in &mut quads {
        let (a, b) = four.split_at(2 * n);
        let ((a, b), (c, d)) = (a.split_at(n), b.split_at(n));
        let (fa, fb, fc, fd) = (a[j], b[j], c[j], d[j]);
        let (a, b, c, d) = (&a[j..], &b[j..], &c[j..], &d[j..]);
        for ((((x, a), b), c), d) in column.iter_mut().zip(a).zip(b).zip(c).zip(d) {
            *x -= (fa * a + fb * b) + (fc * c + fd * d);
        }
    }
    for one in quads.remainder().chunks_exact(n) {
        let f = one[j];
        column.iter_mut().zip(&one[j..]).for_each(|(x, a)| *x -= f * a);
    }
}

/// Solves with the factor of [`factor`]; `b` becomes the solution.
pub(super) fn solve(l: &[f64], n: usize, b: &mut [f64]) {
    for j in 0..n {
        let column = &l[j * n..(j + 1) * n];
        let value = b[j] / column[j];
        b[j] = value;
        b[j + 1..n].iter_mut().zip(&column[j + 1..]).for_each(|(x, l)| *x -= value * l);
    }
    for j in (0..n).rev() {
        let column = &l[j * n..(j + 1) * n];
        let sum = dot(&column[j + 1..], &b[j + 1..n]);
        b[j] = (b[j] - sum) / column[j];
    }
}

/// Dot product with four partial sums.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut sums = [0.0; 4];
    let (pairs_a, pairs_b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = pairs_a.remainder().iter().zip(pairs_b.remainder()).map(|(x, y)| x * y).sum();
    for (x, y) in pairs_a.zip(pairs_b) {
        for k in 0..4 {
            sums[k] += x[k] * y[k];
        }
    }
    (sums[0] + sums[1]) + (sums[2] + sums[3]) + rest
}

/// Factors a small matrix (rows in `a`, lower triangle used) in place; `false` when it is not positive
/// definite.
pub(super) fn factor_small(a: &mut [f64], n: usize) -> bool {
    for i in 0..n {
        for j in 0..=i {
            let mut sum = a[i * n + j];
            for k in 0..j {
                sum -= a[i * n + k] * a[j * n + k];
            }
            if i > j {
                a[i * n + j] = sum / a[j * n + j];
            } else if sum > 0.0 && sum.is_finite() {
                a[i * n + i] = sum.sqrt();
            } else {
                return false;
            }
        }
    }
    true
}

/// Inverse (full, by rows) of the matrix whose factor is `l`; `root` takes the inverse of the factor.
pub(super) fn invert_small(l: &[f64], n: usize, root: &mut [f64], inverse: &mut [f64]) {
    for j in 0..n {
        root[j * n + j] = 1.0 / l[j * n + j];
        for i in j + 1..n {
            let sum: f64 = (j..i).map(|k| l[i * n + k] * root[k * n + j]).sum();
            root[i * n + j] = -sum / l[i * n + i];
        }
    }
    for i in 0..n {
        for j in 0..=i {
            let sum: f64 = (i..n).map(|k| root[k * n + i] * root[k * n + j]).sum();
            (inverse[i * n + j], inverse[j * n + i]) = (sum, sum);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_base::random::Stream;

    /// A random positive definite matrix, full.
    fn matrix(n: usize) -> Vec<f64> {
        let mut stream = Stream::new(3, n);
        let root: Vec<f64> = (0..n * n).map(|_| stream.normal()).collect();
        let mut a = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..n {
                a[i * n + j] = (0..n).map(|k| root[i * n + k] * root[j * n + k]).sum();
            }
            a[i * n + i] += 0.1;
        }
        a
    }

    #[test]
    fn solutions_satisfy_the_system() {
        for n in [1, 2, 5, 8, 13, 70] {
            let a = matrix(n);
            let truth: Vec<f64> = (0..n).map(|i| 1.0 + i as f64).collect();
            let mut b: Vec<f64> = (0..n).map(|i| dot(&a[i * n..(i + 1) * n], &truth)).collect();
            let mut l = a.clone();
            assert!(factor(&mut l, n));
            solve(&l, n, &mut b);
            for (x, t) in b.iter().zip(&truth) {
                assert!((x - t).abs() < 1e-8 * t.abs(), "{n}: {x} {t}");
            }
        }
    }

    #[test]
    fn small_inverses_invert() {
        for n in [1, 3, 4, 6] {
            let a = matrix(n);
            let (mut l, mut root, mut inverse) = (a.clone(), vec![0.0; n * n], vec![0.0; n * n]);
            assert!(factor_small(&mut l, n));
            invert_small(&l, n, &mut root, &mut inverse);
            for i in 0..n {
                for j in 0..n {
                    let sum: f64 = (0..n).map(|k| a[i * n + k] * inverse[k * n + j]).sum();
                    let one = if i == j { 1.0 } else { 0.0 };
                    assert!((sum - one).abs() < 1e-9, "{n}: {i},{j} {sum}");
                }
            }
        }
    }

    #[test]
    fn indefinite_matrices_are_refused() {
        assert!(!factor(&mut [1.0, 2.0, 2.0, 1.0], 2));
        assert!(!factor_small(&mut [1.0, 2.0, 2.0, 1.0], 2));
        assert!(!factor(&mut [f64::NAN], 1));
    }
}
