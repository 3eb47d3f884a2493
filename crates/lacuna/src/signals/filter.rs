//! Zero-phase Butterworth low-pass: second-order sections, run forwards and backwards.

use std::f64::consts::PI;
use std::ops::Range;

use super::bank::Bank;
use crate::error::{Error, Result};

/// Highest order offered; above it the transients grow and nothing is gained.
pub(super) const MAX_ORDER: usize = 8;

/// One second-order section `b / (1 + a0 z⁻¹ + a1 z⁻²)` of unit gain at zero frequency.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Section {
    pub(super) b: [f64; 3],
    pub(super) a: [f64; 2],
}

/// A Butterworth low-pass run forwards and backwards over a signal: no delay, and the squared
/// magnitude response, so -6 dB at the cut-off.
///
/// Designed by the bilinear transform with pre-warped cut-off. The signal is extended at both ends by
/// its own odd reflection, and each pass starts from the steady state of its first sample: the
/// conventions, padding included, of SciPy's `butter` and `sosfiltfilt`.
///
/// ```
/// let low_pass = lacuna::signals::ZeroPhase::butterworth(4, 5.0, 0.001)?;
/// let mut steps = vec![1.0; 1000];
/// low_pass.apply(&mut steps);
/// assert!(steps.iter().all(|y| (y - 1.0).abs() < 1e-12));
/// # Ok::<(), lacuna::Error>(())
/// ```
#[derive(Debug, Clone, PartialEq)]
pub struct ZeroPhase {
    order: usize,
    cutoff_hz: f64,
    sections: Vec<Section>,
}

impl ZeroPhase {
    /// Designs the filter: `order` (1 to 8) of each of the two passes, cut-off \[Hz\], sampling time \[s\].
    ///
    /// # Errors
    /// When the order is out of range, `dt` is not positive, or the cut-off is not between zero and
    /// half the sampling rate.
    pub fn butterworth(order: usize, cutoff_hz: f64, dt: f64) -> Result<Self> {
        if !(1..=MAX_ORDER).contains(&order) {
            return Err(Error::new(format!("a Butterworth filter of order {order} is not offered"))
                .help(format!("choose an order from 1 to {MAX_ORDER}; 4 is usual")));
        }
        if !(dt.is_finite() && dt > 0.0) {
            return Err(Error::new(format!("the sampling time must be positive, not {dt} s")));
        }
        let nyquist = 0.5 / dt;
        if !(cutoff_hz > 0.0 && cutoff_hz < nyquist) {
            let what = format!("a cut-off of {cutoff_hz:?} Hz does not fit a sampling time of {dt} s");
            return Err(Error::new(what).help(format!("choose one above 0 and below {nyquist} Hz")));
        }
        let warped = libm::tan(PI * cutoff_hz * dt);
        let mut sections: Vec<Section> =
            (0..order / 2).map(|pair| second_order(warped, order, pair)).collect();
        if order % 2 == 1 {
            sections.push(first_order(warped));
        }
        Ok(Self { order, cutoff_hz, sections })
    }

    /// Order of each of the two passes.
    pub fn order(&self) -> usize {
        self.order
    }

    /// Cut-off \[Hz\], where the two passes together give half the amplitude.
    pub fn cutoff_hz(&self) -> f64 {
        self.cutoff_hz
    }

    /// Samples by which both ends are extended before filtering.
    pub fn padding(&self) -> usize {
        3 * (self.order + 1)
    }

    /// Checks that a signal of `samples` is long enough for the usual extension of its ends.
    ///
    /// # Errors
    /// When it is not longer than [`Self::padding`].
    pub fn check_length(&self, samples: usize) -> Result<()> {
        let padding = self.padding();
        if samples > padding {
            return Ok(());
        }
        let what = format!("{samples} samples are too few for a filter of order {}", self.order);
        Err(Error::new(what).help(format!("give more than {padding} samples, or lower the order")))
    }

    /// Filters `x` in place. A signal shorter than [`Self::check_length`] asks for is extended by as
    /// much as it can give.
    pub fn apply(&self, x: &mut [f64]) {
        match self.sections.len() {
            1 => self.both_ways::<1>(x),
            2 => self.both_ways::<2>(x),
            3 => self.both_ways::<3>(x),
            _ => self.both_ways::<4>(x),
        }
    }

    /// Filters the whole of `x` and puts every `every`-th sample of `range` into `out`, which is
    /// cleared first.
    pub fn apply_decimated(&self, x: &[f64], range: Range<usize>, every: usize, out: &mut Vec<f64>) {
        out.clear();
        out.extend_from_slice(x);
        self.apply(out);
        keep_every(out, range, every);
    }

    /// Filters `columns`, all of one length, and puts every `every`-th sample from `first` on into the rows of each,
    /// as many as these have room for. The same bits as [`Self::apply`] column by column, several times as fast.
    ///
    /// # Panics
    /// When the columns differ in length, or the rows want samples that they have not.
    pub fn apply_together(&self, columns: &[&[f64]], first: usize, every: usize, rows: &mut [&mut [f64]]) {
        assert_eq!(columns.len(), rows.len());
        assert!(columns.iter().all(|c| c.len() == columns[0].len()));
        match (columns, &mut *rows) {
            // One alone has nothing to share the way with.
            ([column], [rows]) => {
                let mut column = column.to_vec();
                self.apply(&mut column);
                rows.iter_mut().zip(column[first..].iter().step_by(every)).for_each(|(y, x)| *y = *x);
            }
            _ => Bank { filter: self, columns, first, every, rows }.run(),
        }
    }

    /// Its second-order sections.
    pub(super) fn sections(&self) -> &[Section] {
        &self.sections
    }

    /// Number of samples after which a disturbance has faded: whatever happens further away changes
    /// the result by less than `tolerance` times its size. Long columns can be filtered in chunks
    /// that overlap by this much on each side. At most ten million.
    pub fn settle_samples(&self, tolerance: f64) -> usize {
        let slowest = self.sections.iter().map(Section::pole_radius).fold(0.0, f64::max);
        let decay = libm::log(slowest.max(f64::MIN_POSITIVE));
        let enough = libm::log(tolerance.clamp(1e-300, 0.5) * 1e-6) / decay;
        let mut response = vec![0.0; enough.min(1e7) as usize + 2 * self.padding()];
        response[0] = 1.0;
        let mut cascade = Cascade::<{ MAX_ORDER / 2 }>::new(&self.sections);
        response.iter_mut().for_each(|y| *y = cascade.step(*y));
        cascade.rest_at(0.0);
        response.iter_mut().rev().for_each(|y| *y = cascade.step(*y));
        let mut tail = 0.0;
        for (lag, value) in response.iter().enumerate().rev() {
            tail += 2.0 * value.abs();
            if tail >= tolerance {
                return lag + 1;
            }
        }
        1
    }

    fn both_ways<const S: usize>(&self, x: &mut [f64]) {
        let (Some(&first), Some(&last)) = (x.first(), x.last()) else { return };
        let pad = self.padding().min(x.len() - 1);
        let n = x.len();
        let mut beyond: Vec<f64> = (1..=pad).map(|i| 2.0 * last - x[n - 1 - i]).collect();
        let mut cascade = Cascade::<S>::new(&self.sections);
        cascade.rest_at(2.0 * first - x[pad]);
        for i in (1..=pad).rev() {
            cascade.step(2.0 * first - x[i]);
        }
        x.iter_mut().for_each(|v| *v = cascade.step(*v));
        beyond.iter_mut().for_each(|v| *v = cascade.step(*v));
        cascade.rest_at(beyond.last().copied().unwrap_or(x[n - 1]));
        for v in beyond.iter().rev() {
            cascade.step(*v);
        }
        x.iter_mut().rev().for_each(|v| *v = cascade.step(*v));
    }
}

/// Keeps every `every`-th sample of `range`, in place.
pub(super) fn keep_every(x: &mut Vec<f64>, range: Range<usize>, every: usize) {
    let (every, end) = (every.max(1), range.end.min(x.len()));
    let mut kept = 0;
    for k in (range.start..end).step_by(every) {
        x[kept] = x[k];
        kept += 1;
    }
    x.truncate(kept);
}

/// The `pair`-th complex pole pair of the analogue prototype, through the bilinear transform.
fn second_order(warped: f64, order: usize, pair: usize) -> Section {
    let damping = 2.0 * libm::sin(PI * (2 * pair + 1) as f64 / (2 * order) as f64);
    let (linear, square) = (damping * warped, warped * warped);
    let scale = 1.0 / (1.0 + linear + square);
    let gain = square * scale;
    Section {
        b: [gain, 2.0 * gain, gain],
        a: [2.0 * (square - 1.0) * scale, (1.0 - linear + square) * scale],
    }
}

fn first_order(warped: f64) -> Section {
    let gain = warped / (1.0 + warped);
    Section { b: [gain, gain, 0.0], a: [(warped - 1.0) / (1.0 + warped), 0.0] }
}

impl Section {
    /// Passes everything.
    pub(super) const THROUGH: Self = Self { b: [1.0, 0.0, 0.0], a: [0.0, 0.0] };

    /// What its memories settle at under a constant input of one.
    pub(super) fn rest(&self) -> [f64; 2] {
        let second = self.b[2] - self.a[1];
        [self.b[1] - self.a[0] + second, second]
    }

    fn pole_radius(&self) -> f64 {
        if self.a[1].abs() > 0.0 { libm::sqrt(self.a[1].abs()) } else { self.a[0].abs() }
    }
}

/// Up to `S` sections in a row with their memories (direct form II transposed); missing ones pass
/// everything.
struct Cascade<const S: usize> {
    sections: [Section; S],
    memory: [[f64; 2]; S],
}

impl<const S: usize> Cascade<S> {
    fn new(sections: &[Section]) -> Self {
        let sections = std::array::from_fn(|i| sections.get(i).copied().unwrap_or(Section::THROUGH));
        Self { sections, memory: [[0.0; 2]; S] }
    }

    /// Puts every memory where it settles under the constant input `x`.
    fn rest_at(&mut self, x: f64) {
        for (section, memory) in self.sections.iter().zip(&mut self.memory) {
            *memory = section.rest().map(|rest| rest * x);
        }
    }

    #[inline(always)]
    fn step(&mut self, mut x: f64) -> f64 {
        for (Section { b, a }, memory) in self.sections.iter().zip(&mut self.memory) {
            let y = b[0] * x + memory[0];
            memory[0] = b[1] * x - a[0] * y + memory[1];
            memory[1] = b[2] * x - a[1] * y;
            x = y;
        }
        x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sine_on_parabola(n: usize) -> Vec<f64> {
        (0..n).map(|k| k as f64).map(|k| libm::sin(0.07 * k) + 1e-4 * k * k - 0.3).collect()
    }

    fn low_pass(order: usize, cutoff_hz: f64, dt: f64) -> ZeroPhase {
        ZeroPhase::butterworth(order, cutoff_hz, dt).expect("a valid filter")
    }

    /// Samples and values of `sosfiltfilt(butter(order, cutoff, fs=1/dt, output="sos"), x)` of SciPy
    /// 1.17.1, `x` being [`sine_on_parabola`] of 400, 60, 50 and 80 samples.
    const SCIPY: [[(usize, f64); 6]; 4] = [
        [
            (0, -0.519661219031632),
            (1, -0.5080500519465471),
            (133, 1.4080180661584036),
            (200, 3.6297132161230476),
            (398, 10.607617540040316),
            (399, 10.60773740155928),
        ],
        [
            (0, -0.2983931875417568),
            (1, -0.2286250761448124),
            (20, 0.7254326398838146),
            (30, 0.6532137706319702),
            (58, -0.751370619013222),
            (59, -0.7858934336434175),
        ],
        [
            (0, -0.29747796072680044),
            (1, -0.2294327136019887),
            (16, 0.6100255287714492),
            (25, 0.7292790828595231),
            (48, -0.28213936404264073),
            (49, -0.33935286947131205),
        ],
        [
            (0, -0.299992645888286),
            (1, -0.22991269965485175),
            (26, 0.7367090274777989),
            (40, 0.1949881924528809),
            (78, -0.4243087497473169),
            (79, -0.3599126849029558),
        ],
    ];

    #[test]
    fn agrees_with_scipy() {
        let filters = [
            low_pass(4, 5.0, 0.001),
            low_pass(3, 40.0, 0.002),
            low_pass(1, 8.0, 0.01),
            low_pass(6, 90.0, 0.002),
        ];
        for ((filter, n), expected) in filters.iter().zip([400, 60, 50, 80]).zip(SCIPY) {
            let mut x = sine_on_parabola(n);
            filter.apply(&mut x);
            for (k, y) in expected {
                assert!((x[k] - y).abs() < 1e-12 * y.abs().max(1.0), "{filter:?} at {k}: {} not {y}", x[k]);
            }
        }
    }

    #[test]
    fn passes_constants_and_halves_the_cutoff_without_delay() {
        let filter = low_pass(4, 5.0, 0.001);
        let mut constant = vec![-2.5; 500];
        filter.apply(&mut constant);
        let off = constant.iter().fold(0.0, |m: f64, y| m.max((y + 2.5).abs()));
        assert!(off < 1e-11, "{off}");

        let wave: Vec<f64> = (0..6000).map(|k| libm::sin(2.0 * PI * 5.0 * 0.001 * k as f64)).collect();
        let mut y = wave.clone();
        filter.apply(&mut y);
        for k in 2500..3500 {
            assert!((y[k] - 0.5 * wave[k]).abs() < 1e-9, "half the amplitude, in phase: sample {k}");
        }
    }

    #[test]
    fn rolls_off_with_both_passes() {
        let filter = low_pass(4, 5.0, 0.001);
        let mut y: Vec<f64> = (0..8000).map(|k| libm::sin(2.0 * PI * 25.0 * 0.001 * k as f64)).collect();
        filter.apply(&mut y);
        let peak = y[3000..5000].iter().fold(0.0, |m: f64, v| m.max(v.abs()));
        let ratio = libm::tan(PI * 0.025) / libm::tan(PI * 0.005);
        let expected = 1.0 / (1.0 + ratio.powi(8));
        assert!((peak / expected - 1.0).abs() < 1e-3, "{peak} not {expected}");
    }

    #[test]
    fn chunks_that_overlap_by_the_settling_time_join_seamlessly() {
        let filter = low_pass(4, 5.0, 0.001);
        let overlap = filter.settle_samples(1e-9);
        let x = sine_on_parabola(6000).iter().map(|v| v / 3600.0).collect::<Vec<_>>();
        let mut whole = x.clone();
        filter.apply(&mut whole);
        let mut chunk = x[3000 - overlap..3100 + overlap].to_vec();
        filter.apply(&mut chunk);
        for k in 0..100 {
            assert!((chunk[overlap + k] - whole[3000 + k]).abs() < 1e-8);
        }
        let shorter = filter.settle_samples(1e-3);
        assert!((100..overlap / 2).contains(&shorter), "{shorter} of {overlap}");
        let too_short = shorter / 4;
        let mut chunk = x[3000 - too_short..3100 + too_short].to_vec();
        filter.apply(&mut chunk);
        assert!((chunk[too_short] - whole[3000]).abs() > 1e-8, "a much shorter overlap must show");
    }

    #[test]
    fn impossible_designs_and_short_signals_are_refused() {
        for (order, cutoff, dt) in [
            (0, 5.0, 0.01),
            (9, 5.0, 0.01),
            (4, 50.0, 0.01),
            (4, 0.0, 0.01),
            (4, f64::NAN, 0.01),
            (4, 5.0, 0.0),
        ] {
            assert!(ZeroPhase::butterworth(order, cutoff, dt).is_err(), "{order} {cutoff} {dt}");
        }
        let filter = low_pass(4, 5.0, 0.01);
        assert!(filter.check_length(15).is_err() && filter.check_length(16).is_ok());
        for n in 0..16 {
            let mut x = sine_on_parabola(n);
            filter.apply(&mut x);
            assert!(x.iter().all(|y| y.is_finite()));
        }
    }
}
