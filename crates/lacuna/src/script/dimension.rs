//! Units that are tracked through a script: adding a mass to a length is refused, and margins know their unit.

use std::fmt;

/// Exponents of kilogram, metre and second, doubled so that a square root stays whole.
///
/// A plain number in a script may carry any unit (`0.1 * link.mass` may be a first moment), so what it is
/// multiplied with is no longer `sure`: it names the unit of a margin but never causes a refusal.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Hash)]
pub(super) struct Dimension {
    doubled: [i8; 3],
    sure: bool,
}

impl Dimension {
    /// The unit with these exponents of kg, m, s.
    pub(super) const fn new(kg: i8, m: i8, s: i8) -> Self {
        Self { doubled: [2 * kg, 2 * m, 2 * s], sure: true }
    }

    /// What a sum, a minimum or a branch of the two has; `Err` when they can not be added.
    pub(super) fn common(a: Option<Self>, b: Option<Self>) -> Result<Option<Self>, String> {
        match (a, b) {
            (Some(a), Some(b)) if a.sure && b.sure && a.doubled != b.doubled => {
                Err(format!("a quantity in {a} and one in {b} can neither be added nor compared"))
            }
            (Some(a), Some(b)) => Ok(Some(if a.sure || !b.sure { a } else { b })),
            (one, other) => Ok(one.or(other)),
        }
    }

    /// Unit of a product (`sign` 1) or quotient (`sign` -1).
    pub(super) fn product(a: Option<Self>, b: Option<Self>, sign: i8) -> Option<Self> {
        let zero = Self { doubled: [0; 3], sure: false };
        if a.is_none() && b.is_none() {
            return None;
        }
        let (a, b) = (a.unwrap_or(zero), b.unwrap_or(zero));
        let exponent = |i: usize| a.doubled[i].saturating_add(sign.saturating_mul(b.doubled[i]));
        Some(Self { doubled: std::array::from_fn(exponent), sure: a.sure && b.sure })
    }

    /// Unit of the square root.
    pub(super) fn root(self) -> Self {
        Self {
            doubled: self.doubled.map(|e| e / 2),
            sure: self.sure && self.doubled.iter().all(|e| e % 2 == 0),
        }
    }

    /// Whether it is certainly not a plain number.
    pub(super) fn is_surely_not_plain(self) -> bool {
        self.sure && self.doubled != [0; 3]
    }
}

impl fmt::Display for Dimension {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let mut first = true;
        for (symbol, exponent) in ["kg", "m", "s"].iter().zip(self.doubled) {
            if exponent == 0 {
                continue;
            }
            if !first {
                write!(f, " ")?;
            }
            first = false;
            match (exponent, exponent % 2) {
                (2, _) => write!(f, "{symbol}")?,
                (e, 0) => write!(f, "{symbol}^{}", e / 2)?,
                (e, _) => write!(f, "{symbol}^({e}/2)")?,
            }
        }
        if first { write!(f, "1") } else { Ok(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_multiply_and_refuse_to_mix() {
        let (mass, length) = (Dimension::new(1, 0, 0), Dimension::new(0, 1, 0));
        let moment = Dimension::product(Some(mass), Some(length), 1);
        assert_eq!(moment.map(|d| d.to_string()).as_deref(), Some("kg m"));
        assert_eq!(Dimension::product(moment, Some(mass), -1), Some(length));
        assert!(Dimension::common(Some(mass), Some(length)).is_err());
        // A plain number may carry the missing metre.
        let scaled = Dimension::product(None, Some(mass), 1);
        assert_eq!(Dimension::common(scaled, moment), Ok(moment));
        assert_eq!(Dimension::new(0, 2, 0).root(), length);
    }
}
