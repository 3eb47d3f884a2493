//! Sums whose order is fixed at sixteen interleaved partial sums, so that every vector width gives the
//! same bits.

use pulp::{Arch, Simd, WithSimd};

/// Rows are padded to a multiple of this.
pub(super) const WIDTH: usize = 16;

/// Reflects the columns `others` of a block (each `rows` long, contiguous) at the vector whose lower part
/// is `pivot`: with `s = head * tops[k] + pivot · column`, adds `s * over_beta` to the top entry and
/// `s * over_both * pivot` to the column.
pub(super) struct Reflect<'a> {
    pub pivot: &'a [f64],
    pub others: &'a mut [f64],
    pub tops: &'a mut [f64],
    pub head: f64,
    pub over_beta: f64,
    pub over_both: f64,
}

impl Reflect<'_> {
    pub(super) fn run(self) {
        Arch::new().dispatch(self);
    }
}

impl WithSimd for Reflect<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let rows = self.pivot.len();
        let (pivot, _) = S::as_simd_f64s(self.pivot);
        for (column, top) in self.others.chunks_exact_mut(rows).zip(self.tops) {
            let (column, _) = S::as_mut_simd_f64s(column);
            let s = self.head * *top + dot_registers(simd, pivot, column);
            *top += s * self.over_beta;
            let c = simd.splat_f64s(s * self.over_both);
            for (y, &x) in column.iter_mut().zip(pivot) {
                *y = simd.add_f64s(*y, simd.mul_f64s(c, x));
            }
        }
    }
}

/// Dot product of two padded columns.
pub(super) fn dot(a: &[f64], b: &[f64]) -> f64 {
    struct Dot<'a>(&'a [f64], &'a [f64]);
    impl WithSimd for Dot<'_> {
        type Output = f64;
        #[inline(always)]
        fn with_simd<S: Simd>(self, simd: S) -> f64 {
            dot_registers(simd, S::as_simd_f64s(self.0).0, S::as_simd_f64s(self.1).0)
        }
    }
    Arch::new().dispatch(Dot(a, b))
}

#[inline(always)]
fn dot_registers<S: Simd>(simd: S, a: &[S::f64s], b: &[S::f64s]) -> f64 {
    let count = WIDTH / S::F64_LANES;
    let mut sums = [simd.splat_f64s(0.0); WIDTH];
    for (x, y) in a.chunks_exact(count).zip(b.chunks_exact(count)) {
        for i in 0..count {
            sums[i] = simd.add_f64s(sums[i], simd.mul_f64s(x[i], y[i]));
        }
    }
    let mut parts = [0.0; WIDTH];
    for (slot, sum) in parts.chunks_exact_mut(S::F64_LANES).zip(sums) {
        simd.partial_store_f64s(slot, sum);
    }
    let mut half = WIDTH / 2;
    while half > 0 {
        for i in 0..half {
            parts[i] += parts[i + half];
        }
        half /= 2;
    }
    parts[0]
}
