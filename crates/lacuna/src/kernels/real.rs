//! Numbers that kernels work on: one sample (`f64`), several samples side by side ([`Lanes`]), or a
//! value with its derivative ([`Dual`]).
//!
//! Every implementation performs the same additions and multiplications in the same order and never
//! fuses them, so a sample has the same bits whichever way and on whichever processor it is computed.

use std::ops::{Add, AddAssign, Mul, Neg, Sub};

use pulp::Simd;

/// A real number, or several of them computed in step.
pub trait Real:
    Copy
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + Mul<f64, Output = Self>
{
    /// The constant `c`, shaped like `self`.
    fn lift(self, c: f64) -> Self;

    /// Sine and cosine.
    fn sin_cos(self) -> (Self, Self);
}

/// [`Real`]s that can be compared; what the sine needs.
pub(super) trait Ordered: Real {
    /// `if self < bound { yes } else { no }`, in every lane.
    fn if_less(self, bound: f64, yes: Self, no: Self) -> Self;
}

impl Real for f64 {
    #[inline(always)]
    fn lift(self, c: f64) -> Self {
        c
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        super::trig::sin_cos(self)
    }
}

impl Ordered for f64 {
    #[inline(always)]
    fn if_less(self, bound: f64, yes: Self, no: Self) -> Self {
        if self < bound { yes } else { no }
    }
}

/// As many samples as the processor's vector registers hold.
#[derive(Debug, Clone, Copy)]
#[repr(align(64))] // a cache line: wide loads that straddle two take twice the time
pub struct Lanes<S: Simd> {
    simd: S,
    value: S::f64s,
}

impl<S: Simd> Lanes<S> {
    /// Number of samples side by side.
    pub const COUNT: usize = S::F64_LANES;

    /// The first samples of `slice`; lanes beyond its end are 0.
    #[inline(always)]
    pub fn load(simd: S, slice: &[f64]) -> Self {
        let value = match S::as_simd_f64s(slice) {
            ([value], []) => *value,
            _ => simd.partial_load_f64s(slice),
        };
        Self { simd, value }
    }

    /// Writes as many lanes as `slice` takes.
    #[inline(always)]
    pub fn store(self, slice: &mut [f64]) {
        match S::as_mut_simd_f64s(slice) {
            ([value], []) => *value = self.value,
            _ => self.simd.partial_store_f64s(slice, self.value),
        }
    }

    /// The same constant in every lane.
    #[inline(always)]
    pub fn constant(simd: S, c: f64) -> Self {
        Self { simd, value: simd.splat_f64s(c) }
    }
}

impl<S: Simd> Add for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn add(self, other: Self) -> Self {
        Self { value: self.simd.add_f64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Sub for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, other: Self) -> Self {
        Self { value: self.simd.sub_f64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Mul for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, other: Self) -> Self {
        Self { value: self.simd.mul_f64s(self.value, other.value), ..self }
    }
}

impl<S: Simd> Mul<f64> for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, c: f64) -> Self {
        Self { value: self.simd.mul_f64s(self.value, self.simd.splat_f64s(c)), ..self }
    }
}

impl<S: Simd> Neg for Lanes<S> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: self.simd.neg_f64s(self.value), ..self }
    }
}

impl<S: Simd> AddAssign for Lanes<S> {
    #[inline(always)]
    fn add_assign(&mut self, other: Self) {
        *self = *self + other;
    }
}

impl<S: Simd> Real for Lanes<S> {
    #[inline(always)]
    fn lift(self, c: f64) -> Self {
        Self::constant(self.simd, c)
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        super::trig::sin_cos(self)
    }
}

impl<S: Simd> Ordered for Lanes<S> {
    #[inline(always)]
    fn if_less(self, bound: f64, yes: Self, no: Self) -> Self {
        let less = self.simd.less_than_f64s(self.value, self.simd.splat_f64s(bound));
        Self { value: self.simd.select_f64s(less, yes.value, no.value), ..self }
    }
}

/// A value and its derivative with respect to one variable (forward differentiation, exact); of one sample,
/// or of several side by side.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dual<T = f64> {
    /// The value.
    pub value: T,
    /// Its derivative.
    pub slope: T,
}

impl Dual {
    /// A constant: slope 0.
    pub fn constant(value: f64) -> Self {
        Self { value, slope: 0.0 }
    }

    /// The variable itself: slope 1.
    pub fn variable(value: f64) -> Self {
        Self { value, slope: 1.0 }
    }
}

impl<T: Real> Add for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, o: Self) -> Self {
        Self { value: self.value + o.value, slope: self.slope + o.slope }
    }
}

impl<T: Real> Sub for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, o: Self) -> Self {
        Self { value: self.value - o.value, slope: self.slope - o.slope }
    }
}

impl<T: Real> Mul for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, o: Self) -> Self {
        Self { value: self.value * o.value, slope: self.slope * o.value + self.value * o.slope }
    }
}

impl<T: Real> Mul<f64> for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, c: f64) -> Self {
        Self { value: self.value * c, slope: self.slope * c }
    }
}

impl<T: Real> Neg for Dual<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self { value: -self.value, slope: -self.slope }
    }
}

impl<T: Real> AddAssign for Dual<T> {
    #[inline(always)]
    fn add_assign(&mut self, o: Self) {
        *self = *self + o;
    }
}

impl<T: Real> Real for Dual<T> {
    #[inline(always)]
    fn lift(self, c: f64) -> Self {
        Self { value: self.value.lift(c), slope: self.value.lift(0.0) }
    }

    #[inline(always)]
    fn sin_cos(self) -> (Self, Self) {
        let (s, c) = self.value.sin_cos();
        (Self { value: s, slope: c * self.slope }, Self { value: c, slope: -(s * self.slope) })
    }
}
