//! Eigenvalues and singular values by Jacobi's rotations: the matrices are small, the method is short, the
//! most accurate there is (Demmel and Veselic 1992), and its bits do not depend on the processor.

use crate::matrix::{Owned, dot};
use crate::scalar::Scalar;

/// Sweeps over all pairs at most; five or six are usual.
const SWEEPS: usize = 60;

/// Cosine and sine of the rotation that annihilates the off-diagonal `off` between the diagonal entries
/// `first` and `second`.
fn rotation<T: Scalar>(first: T, second: T, off: T) -> (T, T) {
    let theta = (second - first) / (off + off);
    let t = T::ONE / (theta.size() + (theta * theta + T::ONE).root());
    let t = if theta < T::ZERO { -t } else { t };
    let c = T::ONE / (t * t + T::ONE).root();
    (c, t * c)
}

/// Order of `values` under `before`; NaN stay where they are.
fn order<T: Scalar>(values: &[T], before: impl Fn(T, T) -> bool) -> Vec<usize> {
    let mut order: Vec<usize> = (0..values.len()).collect();
    order.sort_by(|&i, &j| {
        if before(values[i], values[j]) {
            std::cmp::Ordering::Less
        } else if before(values[j], values[i]) {
            std::cmp::Ordering::Greater
        } else {
            std::cmp::Ordering::Equal
        }
    });
    order
}

/// Eigenvalues of a symmetric matrix, ascending, and orthonormal eigenvectors as columns in that order.
pub(crate) fn symmetric_eigen<T: Scalar>(mut a: Owned<T>) -> (Vec<T>, Owned<T>) {
    let n = a.rows;
    let mut vectors = Owned::identity(n);
    let norm = dot(&a.data, &a.data).root();
    let floor = T::EPSILON * T::EPSILON * norm;
    for _ in 0..SWEEPS {
        let mut done = true;
        for p in 0..n {
            for q in p + 1..n {
                let off = a.at(p, q);
                let scale = (a.at(p, p).size() * a.at(q, q).size()).root();
                // A NaN rotates nothing: the comparison fails.
                if off.size() > floor && off.size() > T::EPSILON * scale {
                    done = false;
                    let (c, s) = rotation(a.at(p, p), a.at(q, q), off);
                    a.rotate_columns(p, q, c, s);
                    for j in 0..n {
                        let (x, y) = (a.at(p, j), a.at(q, j));
                        a.set(p, j, c * x - s * y);
                        a.set(q, j, s * x + c * y);
                    }
                    a.set(p, q, T::ZERO);
                    a.set(q, p, T::ZERO);
                    vectors.rotate_columns(p, q, c, s);
                }
            }
        }
        if done {
            break;
        }
    }
    let values: Vec<T> = (0..n).map(|i| a.at(i, i)).collect();
    let order = order(&values, |x, y| x < y);
    let sorted = Owned::from_fn(n, n, |i, j| vectors.at(i, order[j]));
    (order.iter().map(|&i| values[i]).collect(), sorted)
}

/// `A = U diag(s) Vᵀ`, thin: `s` descending.
#[derive(Debug)]
pub(crate) struct Svd<T> {
    pub(crate) u: Owned<T>,
    pub(crate) s: Vec<T>,
    pub(crate) v: Owned<T>,
}

/// Singular values and vectors by one-sided rotations (Hestenes 1958): the columns become orthogonal.
pub(crate) fn svd<T: Scalar>(a: Owned<T>) -> Svd<T> {
    if a.rows < a.columns {
        let flipped = svd(Owned::from_fn(a.columns, a.rows, |i, j| a.at(j, i)));
        return Svd { u: flipped.v, s: flipped.s, v: flipped.u };
    }
    let (m, n) = (a.rows, a.columns);
    let (mut a, mut v) = (a, Owned::identity(n));
    for _ in 0..SWEEPS {
        let mut done = true;
        for p in 0..n {
            for q in p + 1..n {
                let off = dot(a.column(p), a.column(q));
                let (first, second) = (dot(a.column(p), a.column(p)), dot(a.column(q), a.column(q)));
                if off.size() > T::EPSILON * (first * second).root() {
                    done = false;
                    let (c, s) = rotation(first, second, off);
                    a.rotate_columns(p, q, c, s);
                    v.rotate_columns(p, q, c, s);
                }
            }
        }
        if done {
            break;
        }
    }
    let sizes: Vec<T> = (0..n).map(|j| dot(a.column(j), a.column(j)).root()).collect();
    let order = order(&sizes, |x, y| x > y);
    let s: Vec<T> = order.iter().map(|&j| sizes[j]).collect();
    let mut u = Owned::from_fn(m, n, |i, j| a.at(i, order[j]));
    normalise(&mut u, &s);
    Svd { u, s, v: Owned::from_fn(n, n, |i, j| v.at(i, order[j])) }
}

/// Scales the columns to length 1; columns that vanish are replaced so that all stay orthonormal.
fn normalise<T: Scalar>(u: &mut Owned<T>, s: &[T]) {
    let least = s.first().map_or(T::ZERO, |&largest| largest * T::EPSILON * T::EPSILON);
    for (j, &size) in s.iter().enumerate() {
        if size > least {
            (0..u.rows).for_each(|i| u.set(i, j, u.at(i, j) / size));
        } else if size <= least {
            complete(u, j);
        }
    }
}

/// Makes column `j` a unit vector orthogonal to the columns before it: what is left of the best axis.
fn complete<T: Scalar>(u: &mut Owned<T>, j: usize) {
    let mut best = (T::ZERO, Vec::new());
    for axis in 0..u.rows {
        let mut rest: Vec<T> = (0..u.rows).map(|i| if i == axis { T::ONE } else { T::ZERO }).collect();
        for _ in 0..2 {
            for k in 0..j {
                let part = dot(u.column(k), &rest);
                rest.iter_mut().zip(u.column(k)).for_each(|(x, &y)| *x -= part * y);
            }
        }
        let length = dot(&rest, &rest).root();
        if length > best.0 {
            best = (length, rest);
        }
    }
    for (i, &value) in best.1.iter().enumerate() {
        u.set(i, j, value / best.0);
    }
}
