//! Three-vectors over any [`Real`].

use super::chain::V3;
use super::real::Real;

#[inline(always)]
pub(super) fn add<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[0] + b[0], a[1] + b[1], a[2] + b[2]]
}

#[inline(always)]
pub(super) fn dot<T: Real>(a: [T; 3], b: [T; 3]) -> T {
    a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
}

#[inline(always)]
pub(super) fn dot_constant<T: Real>(a: [T; 3], c: &V3) -> T {
    a[0] * c[0] + a[1] * c[1] + a[2] * c[2]
}

#[inline(always)]
pub(super) fn cross<T: Real>(a: [T; 3], b: [T; 3]) -> [T; 3] {
    [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]
}

/// `a × c` with a constant.
#[inline(always)]
pub(super) fn cross_constant<T: Real>(a: [T; 3], c: &V3) -> [T; 3] {
    [a[1] * c[2] - a[2] * c[1], a[2] * c[0] - a[0] * c[2], a[0] * c[1] - a[1] * c[0]]
}

#[inline(always)]
pub(super) fn scale<T: Real>(a: [T; 3], s: T) -> [T; 3] {
    [a[0] * s, a[1] * s, a[2] * s]
}

/// `s * c` with a constant vector.
#[inline(always)]
pub(super) fn along<T: Real>(c: &V3, s: T) -> [T; 3] {
    [s * c[0], s * c[1], s * c[2]]
}

#[inline(always)]
pub(super) fn lift<T: Real>(like: T, c: &V3) -> [T; 3] {
    [like.lift(c[0]), like.lift(c[1]), like.lift(c[2])]
}

/// `m x`.
#[inline(always)]
pub(super) fn turn<T: Real>(m: &[[T; 3]; 3], x: [T; 3]) -> [T; 3] {
    [dot(m[0], x), dot(m[1], x), dot(m[2], x)]
}

/// `mᵀ x`.
#[inline(always)]
pub(super) fn turn_back<T: Real>(m: &[[T; 3]; 3], x: [T; 3]) -> [T; 3] {
    [
        m[0][0] * x[0] + m[1][0] * x[1] + m[2][0] * x[2],
        m[0][1] * x[0] + m[1][1] * x[1] + m[2][1] * x[2],
        m[0][2] * x[0] + m[1][2] * x[1] + m[2][2] * x[2],
    ]
}
