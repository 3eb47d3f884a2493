//! The two precisions.

use std::fmt::Debug;
use std::ops::{Add, AddAssign, Div, Mul, Neg, Sub, SubAssign};

/// `f32` or `f64`: what the algorithms need of a number.
pub(crate) trait Scalar:
    Copy
    + Debug
    + PartialOrd
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
    + AddAssign
    + SubAssign
{
    const ZERO: Self;
    const ONE: Self;
    const EPSILON: Self;

    fn root(self) -> Self;
    fn size(self) -> Self;
    /// Not zero; a NaN is.
    fn nonzero(self) -> bool;
    /// A length of workspace, as LAPACK hands it out.
    fn from_length(length: usize) -> Self;
}

macro_rules! scalar {
    ($t:ty) => {
        impl Scalar for $t {
            const ZERO: Self = 0.0;
            const ONE: Self = 1.0;
            const EPSILON: Self = <$t>::EPSILON;

            fn root(self) -> Self {
                self.sqrt()
            }

            fn size(self) -> Self {
                self.abs()
            }

            #[allow(clippy::float_cmp)]
            fn nonzero(self) -> bool {
                self != 0.0
            }

            fn from_length(length: usize) -> Self {
                length as $t
            }
        }
    };
}

scalar!(f32);
scalar!(f64);
