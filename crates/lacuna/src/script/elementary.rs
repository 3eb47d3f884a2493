//! Functions of one number: value and slope.

/// A mass that divides is never taken below this \[kg\]; a centre of mass has no meaning there.
pub(super) const SMALLEST_MASS: f64 = 1e-6;

/// Functions of one number.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) enum Function {
    Sqrt,
    Sin,
    Cos,
    Tan,
    Atan,
    Exp,
    Ln,
    Tanh,
    /// `max(x, SMALLEST_MASS)`: stands where a mass divides.
    Floor,
}

impl Function {
    pub(super) fn name(self) -> &'static str {
        match self {
            Self::Sqrt => "sqrt",
            Self::Sin => "sin",
            Self::Cos => "cos",
            Self::Tan => "tan",
            Self::Atan => "atan",
            Self::Exp => "exp",
            Self::Ln => "ln",
            Self::Tanh => "tanh",
            Self::Floor => "mass",
        }
    }

    /// Value; through `libm`, so that it has the same bits on every processor.
    pub(super) fn at(self, x: f64) -> f64 {
        match self {
            Self::Sqrt => x.sqrt(),
            Self::Sin => libm::sin(x),
            Self::Cos => libm::cos(x),
            Self::Tan => libm::tan(x),
            Self::Atan => libm::atan(x),
            Self::Exp => libm::exp(x),
            Self::Ln => libm::log(x),
            Self::Tanh => libm::tanh(x),
            Self::Floor if x.is_nan() => x,
            Self::Floor => x.max(SMALLEST_MASS),
        }
    }

    /// Derivative where the argument is `x` and the value `y`.
    pub(super) fn slope(self, x: f64, y: f64) -> f64 {
        match self {
            Self::Sqrt => 0.5 / y,
            Self::Sin => libm::cos(x),
            Self::Cos => -libm::sin(x),
            Self::Tan => 1.0 + y * y,
            Self::Atan => 1.0 / (1.0 + x * x),
            Self::Exp => y,
            Self::Ln => 1.0 / x,
            Self::Tanh => 1.0 - y * y,
            Self::Floor => f64::from(x >= SMALLEST_MASS),
        }
    }
}
