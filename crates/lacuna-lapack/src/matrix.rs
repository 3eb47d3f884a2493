//! Column-major views, as Fortran lays matrices out.

use crate::scalar::Scalar;

/// A matrix somebody else owns: entry `(i, j)` is `data[i + j * stride]`.
#[derive(Debug, Clone, Copy)]
pub(crate) struct View<'a, T> {
    pub(crate) data: &'a [T],
    pub(crate) stride: usize,
    /// Read `(i, j)` as `(j, i)`.
    pub(crate) transposed: bool,
}

impl<'a, T: Scalar> View<'a, T> {
    pub(crate) fn new(data: &'a [T], stride: usize) -> Self {
        Self { data, stride, transposed: false }
    }

    pub(crate) fn transposed_if(mut self, transposed: bool) -> Self {
        self.transposed ^= transposed;
        self
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> T {
        let (i, j) = if self.transposed { (j, i) } else { (i, j) };
        self.data[i + j * self.stride]
    }
}

/// A matrix to write to.
#[derive(Debug)]
pub(crate) struct ViewMut<'a, T> {
    pub(crate) data: &'a mut [T],
    pub(crate) stride: usize,
}

impl<'a, T: Scalar> ViewMut<'a, T> {
    pub(crate) fn new(data: &'a mut [T], stride: usize) -> Self {
        Self { data, stride }
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> T {
        self.data[i + j * self.stride]
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, value: T) {
        self.data[i + j * self.stride] = value;
    }

    /// `beta * entry + value`, where `beta = 0` means that the entry is not read at all (it may be NaN).
    pub(crate) fn blend(&mut self, i: usize, j: usize, beta: T, value: T) {
        let kept = if beta.nonzero() { beta * self.at(i, j) } else { T::ZERO };
        self.set(i, j, kept + value);
    }
}

/// A square or rectangular matrix of our own.
#[derive(Debug, Clone)]
pub(crate) struct Owned<T> {
    pub(crate) data: Vec<T>,
    pub(crate) rows: usize,
    pub(crate) columns: usize,
}

impl<T: Scalar> Owned<T> {
    pub(crate) fn from_fn(rows: usize, columns: usize, mut entry: impl FnMut(usize, usize) -> T) -> Self {
        let mut data = Vec::with_capacity(rows * columns);
        for j in 0..columns {
            for i in 0..rows {
                data.push(entry(i, j));
            }
        }
        Self { data, rows, columns }
    }

    pub(crate) fn identity(n: usize) -> Self {
        Self::from_fn(n, n, |i, j| if i == j { T::ONE } else { T::ZERO })
    }

    pub(crate) fn at(&self, i: usize, j: usize) -> T {
        self.data[i + j * self.rows]
    }

    pub(crate) fn set(&mut self, i: usize, j: usize, value: T) {
        self.data[i + j * self.rows] = value;
    }

    pub(crate) fn column(&self, j: usize) -> &[T] {
        &self.data[j * self.rows..(j + 1) * self.rows]
    }

    /// Columns `p` and `q` become `c p - s q` and `s p + c q`.
    pub(crate) fn rotate_columns(&mut self, p: usize, q: usize, c: T, s: T) {
        for i in 0..self.rows {
            let (a, b) = (self.at(i, p), self.at(i, q));
            self.set(i, p, c * a - s * b);
            self.set(i, q, s * a + c * b);
        }
    }
}

/// Scalar product by plain sums.
pub(crate) fn dot<T: Scalar>(a: &[T], b: &[T]) -> T {
    a.iter().zip(b).fold(T::ZERO, |sum, (&x, &y)| sum + x * y)
}
