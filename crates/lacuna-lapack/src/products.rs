//! BLAS: products by their definitions.

use crate::matrix::{View, ViewMut};
use crate::scalar::Scalar;

/// Which triangle of a symmetric matrix is stored.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Triangle {
    Upper,
    Lower,
}

impl Triangle {
    /// Rows of column `j` that belong to it.
    fn rows(self, j: usize, n: usize) -> std::ops::Range<usize> {
        match self {
            Self::Upper => 0..j + 1,
            Self::Lower => j..n,
        }
    }

    /// The stored entry that stands for `(i, j)`.
    pub(crate) fn place(self, i: usize, j: usize) -> (usize, usize) {
        match self {
            Self::Upper => (i.min(j), i.max(j)),
            Self::Lower => (i.max(j), i.min(j)),
        }
    }
}

fn sum<T: Scalar>(n: usize, term: impl Fn(usize) -> T) -> T {
    (0..n).fold(T::ZERO, |sum, k| sum + term(k))
}

/// `C = alpha A B + beta C` with `C` of `m x n` and `k` inner entries.
pub(crate) fn gemm<T: Scalar>(
    (m, n, k): (usize, usize, usize),
    alpha: T,
    a: View<'_, T>,
    b: View<'_, T>,
    beta: T,
    c: &mut ViewMut<'_, T>,
) {
    for j in 0..n {
        for i in 0..m {
            c.blend(i, j, beta, alpha * sum(k, |l| a.at(i, l) * b.at(l, j)));
        }
    }
}

/// A vector with a step between its members; a negative step runs backwards, as in BLAS.
pub(crate) fn place(index: usize, n: usize, step: isize) -> usize {
    if step >= 0 { index * step.unsigned_abs() } else { (n - 1 - index) * step.unsigned_abs() }
}

/// `y = alpha A x + beta y` with `A` of `m x n`, whatever entry `a` gives.
pub(crate) fn matrix_vector<T: Scalar>(
    (m, n): (usize, usize),
    alpha: T,
    a: impl Fn(usize, usize) -> T,
    (x, x_step): (&[T], isize),
    beta: T,
    (y, y_step): (&mut [T], isize),
) {
    for i in 0..m {
        let value = alpha * sum(n, |j| a(i, j) * x[place(j, n, x_step)]);
        let slot = &mut y[place(i, m, y_step)];
        let kept = if beta.nonzero() { beta * *slot } else { T::ZERO };
        *slot = kept + value;
    }
}

/// One triangle of `C = alpha A Aᵀ + beta C`, `A` of `n x k`.
pub(crate) fn syrk<T: Scalar>(
    triangle: Triangle,
    (n, k): (usize, usize),
    alpha: T,
    a: View<'_, T>,
    beta: T,
    c: &mut ViewMut<'_, T>,
) {
    for j in 0..n {
        for i in triangle.rows(j, n) {
            c.blend(i, j, beta, alpha * sum(k, |l| a.at(i, l) * a.at(j, l)));
        }
    }
}

/// One triangle of `C = alpha (A Bᵀ + B Aᵀ) + beta C`, `A` and `B` of `n x k`.
pub(crate) fn syr2k<T: Scalar>(
    triangle: Triangle,
    (n, k): (usize, usize),
    alpha: T,
    (a, b): (View<'_, T>, View<'_, T>),
    beta: T,
    c: &mut ViewMut<'_, T>,
) {
    for j in 0..n {
        for i in triangle.rows(j, n) {
            let value = sum(k, |l| a.at(i, l) * b.at(j, l) + b.at(i, l) * a.at(j, l));
            c.blend(i, j, beta, alpha * value);
        }
    }
}
