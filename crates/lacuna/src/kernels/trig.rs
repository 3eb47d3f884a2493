//! Sine and cosine that give the same bits in every lane and on every processor.
//!
//! The C library picks other code (fused or not) on other processors, so its last bit is not
//! reproducible. This is the classic recipe with the constants of FreeBSD's `k_sin.c` and `k_cos.c`
//! (Sun Microsystems 1993, freely distributable): reduce to a quarter turn, then two polynomials.

// The constants are written with the digits of their source.
#![allow(clippy::excessive_precision)]

use std::f64::consts::FRAC_2_PI;

use super::real::Ordered;

/// Adding and subtracting this rounds to the nearest whole number (1.5 · 2^52).
const ROUND: f64 = 6755399441055744.0;
/// Half pi in three pieces of which the first two have 33 bits, so products with small whole numbers are exact.
const HALF_PI: [f64; 3] =
    [1.57079632673412561417e+00, 6.07710050630396597660e-11, 2.02226624879595063154e-21];
const SIN: [f64; 6] = [
    -1.66666666666666324348e-01,
    8.33333333332248946124e-03,
    -1.98412698298579493134e-04,
    2.75573137070700676789e-06,
    -2.50507602534068634195e-08,
    1.58969099521155010221e-10,
];
const COS: [f64; 6] = [
    4.16666666666666019037e-02,
    -1.38888888888741095749e-03,
    2.48015872894767294178e-05,
    -2.75573143513906633035e-07,
    2.08757232129817482790e-09,
    -1.13596475577881948265e-11,
];

/// Sine and cosine of `x` \[rad\]: within 1.5e-16 for |x| up to 1e6, and no worse than the rounding of
/// `x` itself times a small factor beyond.
#[inline(always)]
pub(super) fn sin_cos<T: Ordered>(x: T) -> (T, T) {
    let round = x.lift(ROUND);
    let n = (x * FRAC_2_PI + round) - round;
    let r = ((x - n * HALF_PI[0]) - n * HALF_PI[1]) - n * HALF_PI[2];
    // Quadrant as -2, -1, 0, 1 or 2.
    let quadrant = n - ((n * 0.25 + round) - round) * 4.0;

    let z = r * r;
    let sin_tail = horner(z, &SIN);
    let sin = r + r * z * sin_tail;
    let half = z * 0.5;
    let one = x.lift(1.0);
    let w = one - half;
    let cos = w + (((one - w) - half) + z * z * horner(z, &COS));

    let odd = quadrant * quadrant - x.lift(1.0);
    let odd = odd * odd;
    let (a, b) = (odd.if_less(0.5, cos, sin), odd.if_less(0.5, sin, cos));
    // sin changes sign in quadrants -1 and ±2, cos in 1 and ±2.
    let sin = quadrant.if_less(-0.5, -a, (-quadrant).if_less(-1.5, -a, a));
    let cos = (-quadrant).if_less(-0.5, -b, quadrant.if_less(-1.5, -b, b));
    (sin, cos)
}

#[inline(always)]
fn horner<T: Ordered>(z: T, c: &[f64; 6]) -> T {
    let mut sum = z.lift(c[5]);
    for &k in c[..5].iter().rev() {
        sum = sum * z + z.lift(k);
    }
    sum
}

#[cfg(test)]
mod tests {
    use super::sin_cos;

    #[test]
    fn agrees_with_the_system_library() {
        for i in -40_000..40_000 {
            for x in [f64::from(i) * 1.234567e-3, f64::from(i) * 23.456789] {
                let (s, c) = sin_cos(x);
                assert!((s - x.sin()).abs() < 2.3e-16, "sin {x}: {s} {}", x.sin());
                assert!((c - x.cos()).abs() < 2.3e-16, "cos {x}: {c} {}", x.cos());
            }
        }
    }

    #[test]
    fn exact_where_it_must_be() {
        assert_eq!(sin_cos(0.0), (0.0, 1.0));
        let (s, c) = sin_cos(std::f64::consts::FRAC_PI_2);
        assert!((s - 1.0).abs() < 1e-16 && (c - 6.123233995736766e-17).abs() < 1e-30);
    }
}
