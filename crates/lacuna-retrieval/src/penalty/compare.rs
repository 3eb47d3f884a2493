//! How the measure of a violation decides where Algorithm 1 ends: Gaz et al. 2019 (section V) say that a
//! constant penalty gets it stuck.

use std::fmt;

use super::function::PenaltyForm;
use super::paper::PaperEngine;
use crate::{FEASIBLE, Problem, Watch};
use lacuna_base::error::Result;

/// Where runs from the same random starts end, for each measure of a violation.
#[derive(Debug, Clone, PartialEq)]
pub struct PenaltyTable {
    /// One row per measure.
    pub rows: Vec<PenaltyRow>,
}

/// One measure of a violation.
#[derive(Debug, Clone, PartialEq)]
pub struct PenaltyRow {
    /// The measure.
    pub form: PenaltyForm,
    /// Objective and largest scaled violation at the end of each run, in the order of the starts.
    pub ends: Vec<(f64, f64)>,
}

impl PenaltyRow {
    /// Number of runs that end feasible.
    pub fn feasible(&self) -> usize {
        self.ends.iter().filter(|e| e.1 <= FEASIBLE).count()
    }

    /// Objectives of the feasible ends, ascending.
    pub fn objectives(&self) -> Vec<f64> {
        let mut all: Vec<f64> = self.ends.iter().filter(|e| e.1 <= FEASIBLE).map(|e| e.0).collect();
        all.sort_by(f64::total_cmp);
        all
    }

    /// Largest violation at any end.
    pub fn worst_violation(&self) -> f64 {
        self.ends.iter().map(|e| e.1).fold(0.0, f64::max)
    }
}

impl PenaltyTable {
    /// Runs `engine` with every measure from the same random starts. Without a polish the table shows what
    /// the search alone makes of each measure.
    ///
    /// # Errors
    /// Those of the engine.
    pub fn new(engine: &PaperEngine, problem: &Problem, watch: &Watch<'_>) -> Result<Self> {
        let row = |form: PenaltyForm| -> Result<PenaltyRow> {
            let engine = PaperEngine { penalty: form, checkpoint: None, ..engine.clone() };
            let outcomes = engine.outcomes(problem, watch)?;
            Ok(PenaltyRow { form, ends: outcomes.iter().map(|o| (o.objective, o.violation)).collect() })
        };
        Ok(Self { rows: PenaltyForm::ALL.into_iter().map(row).collect::<Result<_>>()? })
    }
}

impl fmt::Display for PenaltyTable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{:<10} {:>9} {:>12} {:>12} {:>15}",
            "penalty", "feasible", "best", "median", "worst violation"
        )?;
        for row in &self.rows {
            let all = row.objectives();
            let number = |i: usize| all.get(i).map_or("-".into(), |v| format!("{v:.4e}"));
            let feasible = format!("{}/{}", row.feasible(), row.ends.len());
            let (best, median) = (number(0), number(all.len() / 2));
            let name = format!("{:?}", row.form);
            writeln!(f, "{name:<10} {feasible:>9} {best:>12} {median:>12} {:>15.1e}", row.worst_violation())?;
        }
        Ok(())
    }
}
