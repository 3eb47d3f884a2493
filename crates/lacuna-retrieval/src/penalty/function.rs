//! The exterior penalty function of Gaz et al. 2019, eq. 29.

use serde::{Deserialize, Serialize};

use crate::polish::Target;

/// Measure `g` of a scaled violation `v`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum PenaltyForm {
    /// 1 where violated: the choice before the paper, which says that searches get stuck on it.
    Constant,
    /// `v`, the distance: exact, so a large enough weight leaves no violation.
    #[default]
    Linear,
    /// `v²`: smooth, but every finite weight leaves some violation.
    Squared,
}

impl PenaltyForm {
    /// All of them.
    pub const ALL: [Self; 3] = [Self::Constant, Self::Linear, Self::Squared];

    /// Penalty for a scaled violation (not negative).
    pub fn of(self, violation: f64) -> f64 {
        match self {
            Self::Constant if violation > 0.0 => 1.0,
            Self::Constant => 0.0,
            Self::Linear => violation,
            Self::Squared => violation * violation,
        }
    }
}

impl Target<'_> {
    /// `objective + weight * sum of penalties` at unknowns `z` (bounds not looked at); infinite where an
    /// infinite weight meets a violation.
    pub fn value(&self, z: &[f64]) -> f64 {
        let objective = self.problem.objective.value(z);
        if self.weight <= 0.0 {
            return objective;
        }
        let sum: f64 = self.problem.forms.iter().map(|f| self.penalty.of(f.violation(z))).sum();
        if sum > 0.0 { objective + self.weight * sum } else { objective }
    }
}
