//! Several columns through one filter at once, as many side by side as the processor computes; the width is
//! chosen at run time and does not show in the results.

use pulp::{Arch, Simd, WithSimd};

use super::ZeroPhase;
use super::filter::Section;

/// Samples that are put side by side at once: few enough to be in the cache when they are filtered.
const STRETCH: usize = 128;
/// Numbers in a cache line.
const LINE: usize = 8;

/// Columns of one length, what filters them, and where every `every`-th sample from `first` on goes.
pub(super) struct Bank<'a, 'r> {
    pub filter: &'a ZeroPhase,
    pub columns: &'a [&'a [f64]],
    pub first: usize,
    pub every: usize,
    pub rows: &'a mut [&'r mut [f64]],
}

impl Bank<'_, '_> {
    pub(super) fn run(self) {
        Arch::new().dispatch(self);
    }

    #[inline(always)]
    fn filtered<S: Simd, const N: usize>(self, simd: S) {
        let Self { filter, columns, first, every, rows } = self;
        let Some(samples) = columns.first().map(|c| c.len()).filter(|&n| n > 0) else { return };
        let (lanes, pad) = (S::F64_LANES, filter.padding().min(samples - 1));
        let mut room = vec![0.0; (samples + 2 * pad) * lanes + LINE];
        let start = room.as_ptr().align_offset(LINE * size_of::<f64>()).min(LINE);
        let room = &mut room[start..][..(samples + 2 * pad) * lanes];
        for (columns, rows) in columns.chunks(lanes).zip(rows.chunks_mut(lanes)) {
            if columns.len() < lanes {
                room.fill(0.0);
            }
            both_ways::<S, N>(simd, filter, columns, pad, first, room);
            for (lane, rows) in rows.iter_mut().enumerate() {
                for (k, y) in rows.iter_mut().enumerate() {
                    *y = room[(pad + first + k * every) * lanes + lane];
                }
            }
        }
    }
}

impl WithSimd for Bank<'_, '_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        match self.filter.sections().len() {
            1 => self.filtered::<S, 1>(simd),
            2 => self.filtered::<S, 2>(simd),
            3 => self.filtered::<S, 3>(simd),
            _ => self.filtered::<S, 4>(simd),
        }
    }
}

/// Forwards over the columns, extended by `pad` odd reflections at both ends, and backwards down to sample `first`:
/// sample `k` of lane `l` comes to stand at `(pad + k) * lanes + l`.
#[inline(always)]
fn both_ways<S: Simd, const N: usize>(
    simd: S,
    filter: &ZeroPhase,
    columns: &[&[f64]],
    pad: usize,
    first: usize,
    room: &mut [f64],
) {
    let (lanes, samples) = (S::F64_LANES, columns[0].len());
    for (lane, x) in columns.iter().enumerate() {
        for i in 1..=pad {
            room[(pad - i) * lanes + lane] = 2.0 * x[0] - x[i];
            room[(pad + samples - 1 + i) * lanes + lane] = 2.0 * x[samples - 1] - x[samples - 1 - i];
        }
        // Where it begins may be the first sample itself.
        room[pad * lanes + lane] = x[0];
    }
    let mut cascade = Cascade::<S, N>::new(simd, filter.sections());
    cascade.rest_at(S::as_simd_f64s(room).0[0]);
    let (before, rest) = room.split_at_mut(pad * lanes);
    cascade.forwards(before);
    let (own, after) = rest.split_at_mut(samples * lanes);
    for (part, from) in own.chunks_mut(STRETCH * lanes).zip((0..samples).step_by(STRETCH)) {
        for (lane, x) in columns.iter().enumerate() {
            for (place, x) in part.chunks_exact_mut(lanes).zip(&x[from..]) {
                place[lane] = *x;
            }
        }
        cascade.forwards(part);
    }
    cascade.forwards(after);
    let back = &mut room[(pad + first) * lanes..];
    let Some(&last) = S::as_simd_f64s(back).0.last() else { return };
    cascade.rest_at(last);
    cascade.backwards(back);
}

/// Sections in a row with their memories, as [`super::filter`] has them, of as many columns as there are lanes.
struct Cascade<S: Simd, const N: usize> {
    simd: S,
    b: [[S::f64s; 3]; N],
    a: [[S::f64s; 2]; N],
    /// What the memories of a section settle at under a constant input of one.
    rest: [[S::f64s; 2]; N],
    memory: [[S::f64s; 2]; N],
}

impl<S: Simd, const N: usize> Cascade<S, N> {
    #[inline(always)]
    fn new(simd: S, sections: &[Section]) -> Self {
        let sections: [Section; N] =
            std::array::from_fn(|i| sections.get(i).copied().unwrap_or(Section::THROUGH));
        let splat = |x: f64| simd.splat_f64s(x);
        Self {
            simd,
            b: sections.map(|s| s.b.map(splat)),
            a: sections.map(|s| s.a.map(splat)),
            rest: sections.map(|s| s.rest().map(splat)),
            memory: [[simd.splat_f64s(0.0); 2]; N],
        }
    }

    #[inline(always)]
    fn rest_at(&mut self, x: S::f64s) {
        for (memory, rest) in self.memory.iter_mut().zip(&self.rest) {
            *memory = rest.map(|r| self.simd.mul_f64s(r, x));
        }
    }

    #[inline(always)]
    fn forwards(&mut self, room: &mut [f64]) {
        let mut memory = self.memory;
        for x in S::as_mut_simd_f64s(room).0 {
            *x = self.step(&mut memory, *x);
        }
        self.memory = memory;
    }

    #[inline(always)]
    fn backwards(&mut self, room: &mut [f64]) {
        let mut memory = self.memory;
        for x in S::as_mut_simd_f64s(room).0.iter_mut().rev() {
            *x = self.step(&mut memory, *x);
        }
        self.memory = memory;
    }

    /// The memories are handed in, so that they stay in registers.
    #[inline(always)]
    fn step(&self, memory: &mut [[S::f64s; 2]; N], mut x: S::f64s) -> S::f64s {
        let simd = self.simd;
        for i in 0..N {
            let (b, a, [one, two]) = (self.b[i], self.a[i], memory[i]);
            let y = simd.add_f64s(simd.mul_f64s(b[0], x), one);
            let next = simd.sub_f64s(simd.mul_f64s(b[1], x), simd.mul_f64s(a[0], y));
            memory[i] =
                [simd.add_f64s(next, two), simd.sub_f64s(simd.mul_f64s(b[2], x), simd.mul_f64s(a[1], y))];
            x = y;
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Columns with nothing in common, some with steps.
    fn columns(count: usize, samples: usize) -> Vec<Vec<f64>> {
        let value = |c: usize, k: usize| {
            let t = (c + 1) as f64 * k as f64;
            libm::sin(0.013 * t) + 1e-3 * t + if (k / 7).is_multiple_of(c + 2) { 1.0 } else { -0.3 }
        };
        (0..count).map(|c| (0..samples).map(|k| value(c, k)).collect()).collect()
    }

    #[test]
    fn together_they_have_the_bits_of_one_by_one() {
        for order in 1..=8 {
            let filter = ZeroPhase::butterworth(order, 7.0, 0.004).expect("a valid filter");
            for (count, samples, first, every) in
                [(1, 300, 20, 3), (2, 1, 0, 1), (5, 12, 2, 2), (8, 129, 0, 1), (19, 500, 101, 7)]
            {
                let all = columns(count, samples);
                let picked = (samples - first).div_ceil(every);
                let mut rows = vec![vec![f64::NAN; picked]; count];
                let from: Vec<&[f64]> = all.iter().map(Vec::as_slice).collect();
                let mut to: Vec<&mut [f64]> = rows.iter_mut().map(Vec::as_mut_slice).collect();
                filter.apply_together(&from, first, every, &mut to);
                for (column, rows) in all.iter().zip(&rows) {
                    let mut plain = column.clone();
                    filter.apply(&mut plain);
                    let plain: Vec<u64> = plain[first..].iter().step_by(every).map(|y| y.to_bits()).collect();
                    let rows: Vec<u64> = rows.iter().map(|y| y.to_bits()).collect();
                    assert_eq!(rows, plain, "order {order}, {count} columns of {samples}");
                }
            }
        }
    }
}
