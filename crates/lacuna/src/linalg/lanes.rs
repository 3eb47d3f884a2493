//! Sums whose order is fixed at sixteen interleaved partial sums, so that every vector width gives the
//! same bits.

use pulp::{Arch, Simd, WithSimd};

/// Rows are padded to a multiple of this.
pub(super) const WIDTH: usize = 16;

/// Reflects the columns `others` of a block (as far as `pivot` is long, `stride` apart) at the vector whose lower
/// part is `pivot`: with `s = head * tops[k] + pivot · column`, adds `s * over_beta` to the top entry and
/// `s * over_both * pivot` to the column.
///
/// The second half of that is left for the next call, so that every column is read and written once per
/// reflection: the factors go to `scales`, and the column first receives `scales[k] * before`, what the
/// reflection at `before` left open.
pub(super) struct Reflect<'a> {
    pub before: &'a [f64],
    pub pivot: &'a [f64],
    pub others: &'a mut [f64],
    pub stride: usize,
    pub tops: &'a mut [f64],
    pub scales: &'a mut [f64],
    pub head: f64,
    pub over_beta: f64,
    pub over_both: f64,
}

impl Reflect<'_> {
    pub(super) fn run(self) {
        Arch::new().dispatch(self);
    }

    /// `K` registers make up [`WIDTH`] rows; `C` columns are worked on at once, as many as keep the adders
    /// busy and their sums in registers.
    #[inline(always)]
    fn columns<S: Simd, const K: usize, const C: usize>(mut self, simd: S) {
        let many = self.tops.len() - self.tops.len() % C;
        for first in (0..many).step_by(C) {
            self.update::<S, K, C>(simd, first);
        }
        for k in many..self.tops.len() {
            self.update::<S, K, 1>(simd, k);
        }
    }

    #[inline(always)]
    fn update<S: Simd, const K: usize, const C: usize>(&mut self, simd: S, first: usize) {
        let length = self.pivot.len();
        let (before, pivot) = (registers::<S, K>(self.before), registers::<S, K>(self.pivot));
        let mut rest = &mut self.others[first * self.stride..(first + C) * self.stride];
        let mut columns: [&mut [[S::f64s; K]]; C] = std::array::from_fn(|_| Default::default());
        let mut scales = [simd.splat_f64s(0.0); C];
        for c in 0..C {
            let (column, others) = rest.split_at_mut(self.stride);
            columns[c] = registers_mut::<S, K>(&mut column[..length]);
            scales[c] = simd.splat_f64s(self.scales[first + c]);
            rest = others;
        }
        let mut sums = [[simd.splat_f64s(0.0); K]; C];
        for (row, (&before, &pivot)) in before.iter().zip(pivot).enumerate() {
            for c in 0..C {
                let column = &mut columns[c][row];
                for i in 0..K {
                    let y = simd.add_f64s(column[i], simd.mul_f64s(scales[c], before[i]));
                    column[i] = y;
                    sums[c][i] = simd.add_f64s(sums[c][i], simd.mul_f64s(pivot[i], y));
                }
            }
        }
        for c in 0..C {
            let top = &mut self.tops[first + c];
            let s = self.head * *top + total(simd, sums[c]);
            *top += s * self.over_beta;
            self.scales[first + c] = s * self.over_both;
        }
    }
}

impl WithSimd for Reflect<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match S::F64_LANES {
            8 => self.columns::<S, 2, 4>(simd),
            4 => self.columns::<S, 4, 2>(simd),
            2 => self.columns::<S, 8, 1>(simd),
            _ => self.columns::<S, WIDTH, 1>(simd),
        }
    }
}

/// Adds `scale * x` to the padded column `y`, and gives the sum of squares of what comes out.
pub(super) fn add_scaled(y: &mut [f64], scale: f64, x: &[f64]) -> f64 {
    struct Add<'a>(&'a mut [f64], f64, &'a [f64]);
    impl Add<'_> {
        #[inline(always)]
        fn run<S: Simd, const K: usize>(self, simd: S) -> f64 {
            let scale = simd.splat_f64s(self.1);
            let mut sums = [simd.splat_f64s(0.0); K];
            for (y, x) in registers_mut::<S, K>(self.0).iter_mut().zip(registers::<S, K>(self.2)) {
                for i in 0..K {
                    y[i] = simd.add_f64s(y[i], simd.mul_f64s(scale, x[i]));
                    sums[i] = simd.add_f64s(sums[i], simd.mul_f64s(y[i], y[i]));
                }
            }
            total(simd, sums)
        }
    }
    impl WithSimd for Add<'_> {
        type Output = f64;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            match S::F64_LANES {
                8 => self.run::<S, 2>(simd),
                4 => self.run::<S, 4>(simd),
                2 => self.run::<S, 8>(simd),
                _ => self.run::<S, WIDTH>(simd),
            }
        }
    }
    Arch::new().dispatch(Add(y, scale, x))
}

/// Subtracts `factor * column` for every given pair from `y`, in their order; all of one length.
pub(crate) fn subtract_product<'a>(y: &mut [f64], terms: impl Iterator<Item = (f64, &'a [f64])>) {
    struct Subtract<'b, I>(&'b mut [f64], I);
    impl<'a, I: Iterator<Item = (f64, &'a [f64])>> WithSimd for Subtract<'_, I> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            let (wide, rest) = S::as_mut_simd_f64s(self.0);
            for (factor, column) in self.1 {
                let (x_wide, x_rest) = S::as_simd_f64s(column);
                let many = simd.splat_f64s(factor);
                for (y, &x) in wide.iter_mut().zip(x_wide) {
                    *y = simd.sub_f64s(*y, simd.mul_f64s(many, x));
                }
                for (y, x) in rest.iter_mut().zip(x_rest) {
                    *y -= factor * x;
                }
            }
        }
    }
    Arch::new().dispatch(Subtract(y, terms));
}

/// Hands the dot product of `y` with each of the columns to `put`; all of one length.
pub(crate) fn dots<'a>(y: &[f64], columns: impl Iterator<Item = &'a [f64]>, put: impl FnMut(f64)) {
    struct Dots<'b, I, P>(&'b [f64], I, P);
    impl<'a, I: Iterator<Item = &'a [f64]>, P: FnMut(f64)> Dots<'_, I, P> {
        #[inline(always)]
        fn run<S: Simd, const K: usize>(mut self, simd: S) {
            let whole = self.0.len() - self.0.len() % WIDTH;
            let (y, y_rest) = self.0.split_at(whole);
            for column in self.1 {
                let (x, x_rest) = column.split_at(whole);
                let mut sums = [simd.splat_f64s(0.0); K];
                for (x, y) in registers::<S, K>(x).iter().zip(registers::<S, K>(y)) {
                    for i in 0..K {
                        sums[i] = simd.add_f64s(sums[i], simd.mul_f64s(x[i], y[i]));
                    }
                }
                let mut sum = total(simd, sums);
                for (x, y) in x_rest.iter().zip(y_rest) {
                    sum += x * y;
                }
                (self.2)(sum);
            }
        }
    }
    impl<'a, I: Iterator<Item = &'a [f64]>, P: FnMut(f64)> WithSimd for Dots<'_, I, P> {
        type Output = ();
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) {
            match S::F64_LANES {
                8 => self.run::<S, 2>(simd),
                4 => self.run::<S, 4>(simd),
                2 => self.run::<S, 8>(simd),
                _ => self.run::<S, WIDTH>(simd),
            }
        }
    }
    Arch::new().dispatch(Dots(y, columns, put));
}

/// A padded column, [`WIDTH`] rows at a time.
#[inline(always)]
fn registers<S: Simd, const K: usize>(column: &[f64]) -> &[[S::f64s; K]] {
    S::as_simd_f64s(column).0.as_chunks().0
}

#[inline(always)]
fn registers_mut<S: Simd, const K: usize>(column: &mut [f64]) -> &mut [[S::f64s; K]] {
    S::as_mut_simd_f64s(column).0.as_chunks_mut().0
}

/// Adds up the [`WIDTH`] partial sums as a binary tree: the upper half onto the lower, and so on.
#[inline(always)]
fn total<S: Simd, const K: usize>(simd: S, mut sums: [S::f64s; K]) -> f64 {
    let mut half = K / 2;
    while half > 0 {
        for i in 0..half {
            sums[i] = simd.add_f64s(sums[i], sums[i + half]);
        }
        half /= 2;
    }
    let mut parts = [0.0; 8];
    simd.partial_store_f64s(&mut parts[..S::F64_LANES], sums[0]);
    let mut half = S::F64_LANES / 2;
    while half > 0 {
        for i in 0..half {
            parts[i] += parts[i + half];
        }
        half /= 2;
    }
    parts[0]
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand::{RngExt, SeedableRng};
    use rand_xoshiro::Xoshiro256PlusPlus;

    fn numbers(count: usize, seed: u64) -> Vec<f64> {
        let mut rng = Xoshiro256PlusPlus::seed_from_u64(seed);
        (0..count).map(|_| rng.random_range(-1.0..1.0)).collect()
    }

    /// The order that is promised, written plainly.
    fn sixteen_sums(a: &[f64], b: &[f64]) -> f64 {
        let whole = a.len() - a.len() % WIDTH;
        let mut parts = [0.0; WIDTH];
        for k in 0..whole {
            parts[k % WIDTH] += a[k] * b[k];
        }
        for half in [8, 4, 2, 1] {
            for i in 0..half {
                parts[i] += parts[i + half];
            }
        }
        a[whole..].iter().zip(&b[whole..]).fold(parts[0], |sum, (x, y)| sum + x * y)
    }

    #[test]
    fn sums_have_the_promised_order_to_the_bit() {
        for length in [0, 1, 15, 16, 17, 50, 256] {
            let (a, b) = (numbers(length, 1), numbers(length, 2));
            dots(&a, std::iter::once(&b[..]), |sum| {
                assert_eq!(sum.to_bits(), sixteen_sums(&a, &b).to_bits(), "{length}");
            });
            let mut y = a.clone();
            subtract_product(&mut y, [(0.3, &b[..]), (-2.0, &a[..])].into_iter());
            for k in 0..length {
                assert_eq!(y[k].to_bits(), (a[k] - 0.3 * b[k] - -2.0 * a[k]).to_bits());
            }
        }
    }

    #[test]
    fn reflections_have_the_bits_of_one_column_at_a_time() {
        let (length, columns) = (48, 7); // not a multiple of the columns worked on at once
        let (before, pivot) = (numbers(length, 3), numbers(length, 4));
        let (mut others, mut tops) = (numbers(length * columns, 5), numbers(columns, 6));
        let mut scales = numbers(columns, 7);
        let (head, over_beta, over_both) = (0.7, -1.3, 0.4);
        let (mut plain, mut plain_tops, old) = (others.clone(), tops.clone(), scales.clone());
        Reflect {
            before: &before,
            pivot: &pivot,
            others: &mut others,
            stride: length,
            tops: &mut tops,
            scales: &mut scales,
            head,
            over_beta,
            over_both,
        }
        .run();
        for (k, column) in plain.chunks_exact_mut(length).enumerate() {
            column.iter_mut().zip(&before).for_each(|(y, x)| *y += old[k] * x);
            let s = head * plain_tops[k] + sixteen_sums(&pivot, column);
            plain_tops[k] += s * over_beta;
            assert_eq!(scales[k].to_bits(), (s * over_both).to_bits());
        }
        assert_eq!(others, plain);
        assert_eq!(tops, plain_tops);
    }
}
