//! The motions of Gaz et al. 2019 (IEEE RA-L 4(4), doi 10.1109/LRA.2019.2931248) for the Franka Emika Panda.

use super::{FourierMotion, SinusoidalVelocity};
use crate::error::Result;

/// Fundamental period of Table II \[s\].
const PERIOD: f64 = 13.333;

/// Table II, rows a1..a5 [rad/s].
const COSINES: [[f64; 7]; 5] = [
    [-0.2031, -0.0699, 0.3076, 0.1269, -0.2773, 0.2100, -0.2273],
    [0.1295, -0.5380, 0.5864, -0.0253, -0.0857, -0.1194, -0.5636],
    [-0.0090, -0.2015, -0.4813, -0.2405, 0.4810, -0.0950, -0.2099],
    [0.2319, -0.5535, -0.1228, 0.2178, 0.5311, -0.0964, 0.5725],
    [-0.7598, 0.2352, -0.5273, 0.6984, -0.1639, -0.0399, -0.3748],
];

/// Table II, rows b1..b5 [rad/s].
const SINES: [[f64; 7]; 5] = [
    [-0.1136, -0.2437, 0.3898, 0.0401, 0.5491, 0.0692, 0.2023],
    [0.6600, 0.1820, -0.0268, -0.1503, 0.1046, -0.6946, -0.2570],
    [-0.1858, -0.2390, 0.0179, 0.2359, 0.0407, -0.4442, -0.5010],
    [0.1867, -0.2647, 0.4767, -0.2022, -0.0432, -0.5749, 0.0774],
    [0.2357, 0.4252, 0.2726, 0.3693, 0.2448, -0.0698, -0.4833],
];

/// Table II, row q0 \[rad\].
const CENTER: [f64; 7] = [-0.5850, -0.1744, -0.3373, -1.8767, -1.0631, 1.7917, -0.7284];

/// The exciting motion of Table II of the paper's supplement: five harmonics of a period of 13.333 s.
///
/// The row `q0` is the mean position of each joint, not the first one: the authors' log runs through these
/// positions only when read so.
pub fn panda_table_ii() -> FourierMotion {
    let rows = |table: [[f64; 7]; 5]| table.iter().map(|row| row.to_vec()).collect();
    FourierMotion::from_tables(PERIOD, rows(COSINES), rows(SINES), CENTER.to_vec())
}

/// Velocity amplitudes A_1..A_7 of the paper's Table I [rad/s].
pub const PANDA_EQ_31_AMPLITUDES: [f64; 7] = [2.21, -2.21, 1.2, -2.1, -2.3, 2.1, -2.5];

/// The sinusoidal validation motion of eq. 31 with the amplitudes of the paper's Table I.
///
/// The periods T_1..T_7 \[s\] of that table could not be read from the text at hand and are therefore asked
/// for, as are the starting positions `q0` \[rad\], which the paper does not give.
///
/// # Errors
/// When a period is not positive or a number is not finite.
pub fn panda_eq_31(periods_s: [f64; 7], q0: [f64; 7]) -> Result<SinusoidalVelocity> {
    SinusoidalVelocity::new(PANDA_EQ_31_AMPLITUDES.to_vec(), periods_s.to_vec(), q0.to_vec())
}

#[cfg(test)]
mod tests {
    use super::super::Motion;
    use super::*;

    #[test]
    fn table_ii_starts_with_the_sum_of_its_cosines_and_turns_about_q0() {
        let motion = panda_table_ii();
        let (mut q, mut dq, mut ddq) = ([0.0; 7], [0.0; 7], [0.0; 7]);
        motion.at(0.0, &mut q, &mut dq, &mut ddq);
        assert!((dq[0] + 0.6105).abs() < 1e-12, "{dq:?}");
        let mut mean = [0.0; 7];
        for k in 0..64 {
            motion.at(PERIOD * f64::from(k) / 64.0, &mut q, &mut dq, &mut ddq);
            mean.iter_mut().zip(&q).for_each(|(m, x)| *m += x / 64.0);
        }
        assert!(mean.iter().zip(&CENTER).all(|(m, c)| (m - c).abs() < 1e-13), "{mean:?}");
    }

    #[test]
    fn eq_31_reaches_the_printed_amplitudes() -> Result<()> {
        let motion = panda_eq_31([8.0; 7], [0.0; 7])?;
        let (mut q, mut dq, mut ddq) = ([0.0; 7], [0.0; 7], [0.0; 7]);
        motion.at(2.0, &mut q, &mut dq, &mut ddq);
        assert!(dq.iter().zip(&PANDA_EQ_31_AMPLITUDES).all(|(v, a)| (v - a).abs() < 1e-14), "{dq:?}");
        Ok(())
    }
}
