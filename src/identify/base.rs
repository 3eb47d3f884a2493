//! Base parameters: which combinations of link parameters joint torque can reveal.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::kernels::{Chain, State, Twists, Workspace, regressor};
use crate::linalg::product;
use crate::robot::{PARAMETER_NAMES, PARAMETERS_PER_LINK, Robot};

/// Columns whose remainder is below this part of their size depend on earlier ones. Robot files print
/// angles with some eleven digits, so it cannot be much smaller.
const DEPENDENT: f64 = 1e-9;

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
        let chain = Chain::new(robot);
        let y = random_regressor(&chain);
        let order: Vec<usize> = robot
            .order
            .iter()
            .flat_map(|&link| (4..10).chain(1..4).chain(0..1).map(move |k| PARAMETERS_PER_LINK * link + k))
            .collect();
        let pivots = independent_columns(&y, &order);
        let map = dependence(&y, &pivots);
        Self { pivots, map }
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

/// Regressor rows at random states, enough to outnumber the columns twice.
fn random_regressor(chain: &Chain) -> DMatrix<f64> {
    let n = chain.dof();
    let states = 3 * PARAMETERS_PER_LINK + 10;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0x6c61_6375_6e61);
    let mut y = DMatrix::zeros(states * n, PARAMETERS_PER_LINK * n);
    let (mut ws, mut twists) = (Workspace::new(chain, 0.0), Twists::new(chain, 0.0));
    for k in 0..states {
        let mut draw = |reach: f64| -> Vec<f64> { (0..n).map(|_| rng.random_range(-reach..reach)).collect() };
        let (q, dq, ddq) = (draw(std::f64::consts::PI), draw(3.0), draw(5.0));
        regressor(chain, &mut ws, &mut twists, State::new(&q, &dq, &ddq), |joint, link, columns| {
            for (c, value) in columns.into_iter().enumerate() {
                y[(k * n + joint, PARAMETERS_PER_LINK * link + c)] = value;
            }
        });
    }
    y
}

/// Greedy choice by Gram-Schmidt with a second pass, in the given order of columns; ascending result.
fn independent_columns(y: &DMatrix<f64>, order: &[usize]) -> Vec<usize> {
    let largest = (0..y.ncols()).map(|j| y.column(j).norm()).fold(0.0, f64::max);
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut pivots = Vec::new();
    for &j in order {
        let mut rest: DVector<f64> = y.column(j).into_owned();
        let size = rest.norm();
        for _ in 0..2 {
            for b in &basis {
                let part = b.dot(&rest);
                rest.axpy(-part, b, 1.0);
            }
        }
        let left = rest.norm();
        if left > DEPENDENT * size && left > DEPENDENT * largest {
            basis.push(rest / left);
            pivots.push(j);
        }
    }
    pivots.sort_unstable();
    pivots
}

/// Expresses every column by the pivot columns; tiny factors are rounding and become 0.
fn dependence(y: &DMatrix<f64>, pivots: &[usize]) -> DMatrix<f64> {
    let lead = y.select_columns(pivots);
    let qr = lead.qr();
    let mut factors = product(&qr.q().transpose(), y);
    let solved = qr.r().solve_upper_triangular_mut(&mut factors);
    debug_assert!(solved, "pivot columns are independent");
    factors.map(|f| {
        let whole = f.round();
        if f.abs() < 1e-8 {
            0.0
        } else if (f - whole).abs() < 1e-9 {
            whole
        } else {
            f
        }
    })
}
