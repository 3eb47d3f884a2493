//! Many samples at once, as wide as the processor computes; the width is chosen at run time.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::chain::Chain;
use super::motion::{State, Workspace};
use super::real::Lanes;
use super::regressor::{Twists, regressor};
use super::rnea::inverse_dynamics;
use crate::linalg::{LINE_LENGTH, line_start};
use crate::robot::PARAMETERS_PER_LINK;

/// A stretch of motion, stored joint by joint: `q[j][k]` is joint `j` at sample `k`.
#[derive(Debug, Clone, Copy)]
pub struct Samples<'a> {
    /// Positions [rad, m].
    pub q: &'a [Vec<f64>],
    /// Velocities [rad/s, m/s].
    pub dq: &'a [Vec<f64>],
    /// Accelerations [rad/s², m/s²].
    pub ddq: &'a [Vec<f64>],
}

impl Samples<'_> {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }
}

/// Joint-torque regressor of a block of samples, one contiguous column per (joint, parameter) pair that
/// is not identically zero.
#[derive(Debug, Clone)]
pub struct RegressorBlock {
    capacity: usize,
    rows: usize,
    parameters: usize,
    /// Distance of columns: full cache lines, and an odd number of them, so that columns do not compete for
    /// the same places in the cache.
    stride: usize,
    /// Start of the columns of (joint, link), where the joint carries the link.
    start: Vec<Option<usize>>,
    /// Where the first column begins: at a cache line.
    base: usize,
    data: Vec<f64>,
}

impl RegressorBlock {
    /// Room for up to `capacity` samples.
    pub fn new(chain: &Chain, capacity: usize) -> Self {
        let n = chain.dof();
        let mut next = 0;
        let mut start = vec![None; n * n];
        for joint in 0..n {
            for link in 0..n {
                if chain.carries(joint, link) {
                    start[joint * n + link] = Some(next);
                    next += PARAMETERS_PER_LINK;
                }
            }
        }
        let stride = (capacity.div_ceil(LINE_LENGTH) | 1) * LINE_LENGTH;
        let data = vec![0.0; next * stride + LINE_LENGTH];
        let base = line_start(&data);
        Self { capacity, rows: 0, parameters: PARAMETERS_PER_LINK * n, stride, start, base, data }
    }

    /// Number of samples it holds at the moment.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Number of samples it has room for.
    pub fn capacity(&self) -> usize {
        self.capacity
    }

    /// Number of stacked parameters (10 per link).
    pub fn parameters(&self) -> usize {
        self.parameters
    }

    /// Column of `parameter` (stacked index) in the rows of `joint`; `None` where it is zero throughout.
    pub fn column(&self, joint: usize, parameter: usize) -> Option<&[f64]> {
        debug_assert!(parameter < self.parameters);
        let n = self.parameters / PARAMETERS_PER_LINK;
        let block = self.start[joint * n + parameter / PARAMETERS_PER_LINK]?;
        let at = self.base + (block + parameter % PARAMETERS_PER_LINK) * self.stride;
        Some(&self.data[at..at + self.rows])
    }

    /// Fills the block with the regressor of `samples[range]`.
    ///
    /// # Panics
    /// When the range is longer than the block's capacity or reaches beyond the samples.
    pub fn fill(&mut self, chain: &Chain, samples: Samples<'_>, range: Range<usize>) {
        assert!(range.len() <= self.capacity && range.end <= samples.len());
        self.rows = range.len();
        Arch::new().dispatch(Fill { chain, samples, range, block: self });
    }
}

struct Fill<'a> {
    chain: &'a Chain,
    samples: Samples<'a>,
    range: Range<usize>,
    block: &'a mut RegressorBlock,
}

impl WithSimd for Fill<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Fill { chain, samples, range, block } = self;
        let n = chain.dof();
        let zero = Lanes::constant(simd, 0.0);
        let mut ws = Workspace::new(chain, zero);
        let mut twists = Twists::new(chain, zero);
        let mut state = vec![zero; 3 * n];
        let (stride, base) = (block.stride, block.base);
        let mut row = 0;
        while row < range.len() {
            let take = Lanes::<S>::COUNT.min(range.len() - row);
            load(simd, samples, range.start + row, take, &mut state);
            let (start, data) = (&block.start, &mut block.data);
            let (q, rest) = state.split_at(n);
            let (dq, ddq) = rest.split_at(n);
            regressor(chain, &mut ws, &mut twists, State::new(q, dq, ddq), |joint, link, columns| {
                if let Some(first) = start[joint * n + link] {
                    for (c, value) in columns.into_iter().enumerate() {
                        let at = base + (first + c) * stride + row;
                        value.store(&mut data[at..at + take]);
                    }
                }
            });
            row += take;
        }
    }
}

/// Loads joint states of `take` samples from `at` on into `q, dq, ddq` lanes.
#[inline(always)]
fn load<S: Simd>(simd: S, samples: Samples<'_>, at: usize, take: usize, state: &mut [Lanes<S>]) {
    let n = samples.q.len();
    for j in 0..n {
        state[j] = Lanes::load(simd, &samples.q[j][at..at + take]);
        state[n + j] = Lanes::load(simd, &samples.dq[j][at..at + take]);
        state[2 * n + j] = Lanes::load(simd, &samples.ddq[j][at..at + take]);
    }
}

/// Inverse dynamics of every sample: `tau[j][k]` is the torque of joint `j` at sample `k` [N m, N].
///
/// The same bits as [`inverse_dynamics`] sample by sample, whatever the vector width.
pub fn inverse_dynamics_batch(chain: &Chain, samples: Samples<'_>, parameters: &[f64]) -> Vec<Vec<f64>> {
    let mut tau = vec![vec![0.0; samples.len()]; chain.dof()];
    Arch::new().dispatch(Torques { chain, samples, parameters, tau: &mut tau });
    tau
}

struct Torques<'a> {
    chain: &'a Chain,
    samples: Samples<'a>,
    parameters: &'a [f64],
    tau: &'a mut [Vec<f64>],
}

impl WithSimd for Torques<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let n = self.chain.dof();
        let zero = Lanes::constant(simd, 0.0);
        let mut ws = Workspace::new(self.chain, zero);
        let mut state = vec![zero; 3 * n];
        let mut out = vec![zero; n];
        let mut row = 0;
        while row < self.samples.len() {
            let take = Lanes::<S>::COUNT.min(self.samples.len() - row);
            load(simd, self.samples, row, take, &mut state);
            let (q, rest) = state.split_at(n);
            let (dq, ddq) = rest.split_at(n);
            inverse_dynamics(self.chain, &mut ws, State::new(q, dq, ddq), self.parameters, &mut out);
            for (tau, value) in self.tau.iter_mut().zip(&out) {
                value.store(&mut tau[row..row + take]);
            }
            row += take;
        }
    }
}
