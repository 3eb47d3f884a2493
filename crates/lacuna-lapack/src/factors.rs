//! LAPACK: Cholesky and LU factors and solutions with them. Failures are LAPACK's `info`: the number of
//! the pivot, from 1.

use crate::matrix::ViewMut;
use crate::products::Triangle;
use crate::scalar::Scalar;

/// `A = L Lᵀ` or `A = Uᵀ U` in place, by columns; the other triangle is left alone.
pub(crate) fn cholesky<T: Scalar>(triangle: Triangle, n: usize, a: &mut ViewMut<'_, T>) -> Result<(), usize> {
    for j in 0..n {
        for i in j..n {
            let (row, column) = triangle.place(i, j);
            let known = (0..j).fold(a.at(row, column), |rest, k| {
                let ((ri, ci), (rj, cj)) = (triangle.place(i, k), triangle.place(j, k));
                rest - a.at(ri, ci) * a.at(rj, cj)
            });
            if i > j {
                let pivot = a.at(j, j);
                a.set(row, column, known / pivot);
            } else if known > T::ZERO {
                a.set(j, j, known.root());
            } else {
                return Err(j + 1);
            }
        }
    }
    Ok(())
}

/// Solves `A X = B` in place with the factor that [`cholesky`] left in `a`.
pub(crate) fn cholesky_solve<T: Scalar>(
    triangle: Triangle,
    (n, columns): (usize, usize),
    a: impl Fn(usize, usize) -> T,
    b: &mut ViewMut<'_, T>,
) {
    let factor = |i: usize, j: usize| {
        let (row, column) = triangle.place(i, j);
        a(row, column)
    };
    for c in 0..columns {
        for i in 0..n {
            let rest = (0..i).fold(b.at(i, c), |rest, k| rest - factor(i, k) * b.at(k, c));
            b.set(i, c, rest / factor(i, i));
        }
        for i in (0..n).rev() {
            let rest = (i + 1..n).fold(b.at(i, c), |rest, k| rest - factor(k, i) * b.at(k, c));
            b.set(i, c, rest / factor(i, i));
        }
    }
}

/// Solves `A X = B` in place by LU with row exchanges; `a` keeps the factors, `pivots` the exchanges (from 1).
pub(crate) fn lu_solve<T: Scalar>(
    (n, columns): (usize, usize),
    a: &mut ViewMut<'_, T>,
    pivots: &mut [i32],
    b: &mut ViewMut<'_, T>,
) -> Result<(), usize> {
    for (j, pivot) in pivots.iter_mut().enumerate().take(n) {
        let best =
            (j + 1..n).fold(j, |best, i| if a.at(i, j).size() > a.at(best, j).size() { i } else { best });
        *pivot = i32::try_from(best + 1).unwrap_or(i32::MAX);
        if !a.at(best, j).nonzero() {
            return Err(j + 1);
        }
        swap_rows(a, n, j, best);
        swap_rows(b, columns, j, best);
        for i in j + 1..n {
            let factor = a.at(i, j) / a.at(j, j);
            a.set(i, j, factor);
            for k in j + 1..n {
                let value = a.at(i, k) - factor * a.at(j, k);
                a.set(i, k, value);
            }
            for c in 0..columns {
                let value = b.at(i, c) - factor * b.at(j, c);
                b.set(i, c, value);
            }
        }
    }
    for c in 0..columns {
        for i in (0..n).rev() {
            let rest = (i + 1..n).fold(b.at(i, c), |rest, k| rest - a.at(i, k) * b.at(k, c));
            b.set(i, c, rest / a.at(i, i));
        }
    }
    Ok(())
}

fn swap_rows<T: Scalar>(a: &mut ViewMut<'_, T>, columns: usize, i: usize, k: usize) {
    for j in 0..columns {
        let (first, second) = (a.at(i, j), a.at(k, j));
        a.set(i, j, second);
        a.set(k, j, first);
    }
}
