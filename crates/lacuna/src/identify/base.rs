//! Base parameters: which combinations of link parameters joint torque can reveal.

mod grouping;
#[cfg(test)]
mod tests;

use nalgebra::DMatrix;

use crate::robot::{PARAMETER_NAMES, PARAMETERS_PER_LINK, Robot};
use grouping::Grouping;

/// The identifiable combinations of a robot's link parameters (the "dynamic coefficients" of Gaz et al.
/// 2019, eq. 8): coefficient `i` is parameter `pivots[i]` plus multiples of parameters that are not pivots.
#[derive(Debug, Clone, PartialEq)]
pub struct BaseParameters {
    /// Stacked index of the parameter that leads each combination, ascending.
    pub pivots: Vec<usize>,
    /// `rank x 10 n`: `coefficients = map * parameters`.
    pub map: DMatrix<f64>,
}

impl BaseParameters {
    /// Finds them from the regressor at random states: a column is a pivot when it does not depend on the
    /// columns before it, going link by link outwards and within a link from J to m c to m, so that masses
    /// are what gets grouped (the choice of Table III of Gaz et al. 2019).
    pub fn new(robot: &Robot) -> Self {
        let found = Grouping::of(robot);
        Self { pivots: found.pivots, map: found.map.map(tidy) }
    }

    /// Number of identifiable combinations.
    pub fn rank(&self) -> usize {
        self.pivots.len()
    }

    /// Values of the combinations for stacked link parameters.
    pub fn coefficients(&self, parameters: &[f64]) -> Vec<f64> {
        self.map.row_iter().map(|row| row.iter().zip(parameters).map(|(f, p)| f * p).sum()).collect()
    }

    /// The simplest link parameters with these coefficients: pivots take the values, all others are 0.
    /// They give the right torque but are not physical.
    pub fn lift(&self, coefficients: &[f64]) -> Vec<f64> {
        let mut parameters = vec![0.0; self.map.ncols()];
        for (&pivot, &value) in self.pivots.iter().zip(coefficients) {
            parameters[pivot] = value;
        }
        parameters
    }

    /// Combination `i` as people write it, as in Table III of Gaz et al. 2019:
    /// `Jxx2 - Jyy2 + Jyy3 + 0.09986 m3 + 0.632 mz3 + 0.1067 (m4 + m5 + m6 + m7)`.
    pub fn expression(&self, i: usize) -> String {
        let mut terms = vec![(1.0, vec![self.pivots[i]])];
        for j in 0..self.map.ncols() {
            let factor = self.map[(i, j)];
            if j == self.pivots[i] || factor == 0.0 {
                continue;
            }
            let kind = j % PARAMETERS_PER_LINK;
            let same = |(f, names): &(f64, Vec<usize>)| {
                (f - factor).abs() < 1e-9
                    && names[0] % PARAMETERS_PER_LINK == kind
                    && (f.abs() - 1.0).abs() > 1e-9
            };
            match terms.iter_mut().skip(1).find(|t| same(t)) {
                Some((_, names)) => names.push(j),
                None => terms.push((factor, vec![j])),
            }
        }
        terms.iter().enumerate().map(|(k, (factor, names))| term_text(k, *factor, names)).collect()
    }
}

/// Name of stacked parameter `j`: `Jxx2`, `mz3`.
pub fn parameter_name(j: usize) -> String {
    format!("{}{}", PARAMETER_NAMES[j % PARAMETERS_PER_LINK], j / PARAMETERS_PER_LINK + 1)
}

fn term_text(position: usize, factor: f64, names: &[usize]) -> String {
    let sign = match (position, factor < 0.0) {
        (0, false) => "",
        (0, true) => "-",
        (_, false) => " + ",
        (_, true) => " - ",
    };
    let size = factor.abs();
    let number = if (size - 1.0).abs() < 1e-9 { String::new() } else { format!("{} ", short(size)) };
    let names: Vec<String> = names.iter().map(|&j| parameter_name(j)).collect();
    match names.as_slice() {
        [one] => format!("{sign}{number}{one}"),
        many => format!("{sign}{number}({})", many.join(" + ")),
    }
}

/// Four significant digits, without trailing zeros.
fn short(x: f64) -> String {
    let digits = (3 - x.log10().floor() as i32).clamp(0, 12) as usize;
    let text = format!("{x:.digits$}");
    if text.contains('.') { text.trim_end_matches('0').trim_end_matches('.').to_string() } else { text }
}

/// Tiny factors are rounding and become 0, and so is what whole numbers miss.
fn tidy(f: f64) -> f64 {
    let whole = f.round();
    if f.abs() < 1e-8 {
        0.0
    } else if (f - whole).abs() < 1e-9 {
        whole
    } else {
        f
    }
}
