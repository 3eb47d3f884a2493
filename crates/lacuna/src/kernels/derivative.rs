//! Change of joint torques along a displacement of one joint, for many samples at once.

use std::ops::Range;

use pulp::{Arch, Simd, WithSimd};

use super::batch::Samples;
use super::chain::Chain;
use super::motion::{State, Workspace};
use super::real::{Dual, Lanes};
use super::rnea::inverse_dynamics;

/// A displacement of one joint, sample by sample.
#[derive(Debug, Clone, Copy)]
pub struct Direction<'a> {
    /// The joint that is displaced.
    pub joint: usize,
    /// Displacement of its position [rad, m].
    pub q: &'a [f64],
    /// Displacement of its velocity [rad/s, m/s].
    pub dq: &'a [f64],
    /// Displacement of its acceleration [rad/s², m/s²].
    pub ddq: &'a [f64],
}

/// Directional derivative of inverse dynamics over `samples[range]`: `change[i][k]` is the change of the
/// torque of joint `i` at sample `range.start + k`, per unit by which `direction` is followed. Exact, by dual
/// numbers.
///
/// # Panics
/// When the range reaches beyond the samples, or the direction is shorter than it.
pub fn torque_derivative_batch(
    chain: &Chain,
    samples: Samples<'_>,
    range: Range<usize>,
    direction: Direction<'_>,
    parameters: &[f64],
) -> Vec<Vec<f64>> {
    let mut change = vec![vec![0.0; range.len()]; chain.dof()];
    Arch::new().dispatch(Changes { chain, samples, range, direction, parameters, change: &mut change });
    change
}

struct Changes<'a> {
    chain: &'a Chain,
    samples: Samples<'a>,
    range: Range<usize>,
    direction: Direction<'a>,
    parameters: &'a [f64],
    change: &'a mut [Vec<f64>],
}

impl WithSimd for Changes<'_> {
    type Output = ();

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) {
        let Changes { chain, samples, range, direction, parameters, change } = self;
        let n = chain.dof();
        let none = Lanes::constant(simd, 0.0);
        let zero = Dual { value: none, slope: none };
        let mut ws = Workspace::new(chain, zero);
        let (mut state, mut out) = (vec![zero; 3 * n], vec![zero; n]);
        let mut row = 0;
        while row < range.len() {
            let take = Lanes::<S>::COUNT.min(range.len() - row);
            let at = range.start + row;
            for j in 0..n {
                state[j].value = Lanes::load(simd, &samples.q[j][at..at + take]);
                state[n + j].value = Lanes::load(simd, &samples.dq[j][at..at + take]);
                state[2 * n + j].value = Lanes::load(simd, &samples.ddq[j][at..at + take]);
            }
            state[direction.joint].slope = Lanes::load(simd, &direction.q[row..row + take]);
            state[n + direction.joint].slope = Lanes::load(simd, &direction.dq[row..row + take]);
            state[2 * n + direction.joint].slope = Lanes::load(simd, &direction.ddq[row..row + take]);
            let (q, rest) = state.split_at(n);
            let (dq, ddq) = rest.split_at(n);
            inverse_dynamics(chain, &mut ws, State::new(q, dq, ddq), parameters, &mut out);
            for (change, value) in change.iter_mut().zip(&out) {
                value.slope.store(&mut change[row..row + take]);
            }
            row += take;
        }
    }
}
