//! Which parameters of a link show beside those of the links that carry it, found link by link from the base outwards.
//!
//! Torque is linear in the parameters `p` of a link, and what joint torque cannot tell is a body on link `k` that acts
//! as if it were fixed to the parent: then kinetic and potential energy do not depend on the position of joint `k`, so
//! that `Y_k p = Y_parent T p` with the parameters `T p` of the same body seen from the parent at position 0 (Gautier
//! 1991; Khalil and Bennis 1995). No other link can take a body's place, so ten columns of `Y_k - Y_parent T` say all,
//! however many links there are.

use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

use crate::kernels::{Chain, State, Twists, Workspace, regressor};
use crate::linalg::product;
use crate::robot::{InertialParameters, PARAMETERS_PER_LINK, Robot};

/// Columns whose remainder is below this part of their size depend on earlier ones. Robot files print
/// angles with some eleven digits, so it cannot be much smaller.
const DEPENDENT: f64 = 1e-9;
/// States at which the regressor is computed.
const STATES: usize = 3 * PARAMETERS_PER_LINK + 10;
/// Within a link from J to m c to m, so that masses are what gets grouped (the choice of Table III of Gaz et al. 2019).
const ORDER: [usize; PARAMETERS_PER_LINK] = [4, 5, 6, 7, 8, 9, 1, 2, 3, 0];

/// What was found.
pub(super) struct Grouping {
    /// Stacked index of every parameter that leads a combination, ascending.
    pub pivots: Vec<usize>,
    /// `rank x 10 n`: combinations of parameters.
    pub map: DMatrix<f64>,
    /// Multiplications that the search for dependent columns took; tests hold it to the square of the joints.
    #[cfg_attr(not(test), allow(dead_code))]
    pub work: usize,
}

/// The parameters of one link.
struct Own {
    /// Those that lead a combination, as numbers from 0 to 9 in [`ORDER`].
    pivots: Vec<usize>,
    /// `pivots x 10`: the link's columns, less what the parent can do, by those of the pivots.
    factors: DMatrix<f64>,
    /// `10 x 10`: parameters seen from the parent.
    seen_from_parent: DMatrix<f64>,
}

impl Grouping {
    pub(super) fn of(robot: &Robot) -> Self {
        let columns = random_regressor(robot);
        let largest = columns.iter().flat_map(|y| y.column_iter()).map(|c| c.norm()).fold(0.0, f64::max);
        let mut work = 0;
        let links: Vec<Own> =
            (0..robot.dof()).map(|k| Own::new(robot, k, &columns, largest, &mut work)).collect();
        let mut pivots: Vec<usize> = Vec::new();
        for (link, own) in links.iter().enumerate() {
            pivots.extend(own.pivots.iter().map(|k| PARAMETERS_PER_LINK * link + k));
        }
        pivots.sort_unstable();
        let map = map(robot, &links, &pivots);
        Self { pivots, map, work }
    }
}

/// What every parameter is worth in terms of the pivots: a link's own, and those of its parent, which are known.
fn map(robot: &Robot, links: &[Own], pivots: &[usize]) -> DMatrix<f64> {
    let mut map = DMatrix::zeros(pivots.len(), PARAMETERS_PER_LINK * robot.dof());
    for &link in &robot.order {
        let own = &links[link];
        let first = PARAMETERS_PER_LINK * link;
        // What is left of each parameter beside the link's own pivots goes to the parent.
        let mut rest = DMatrix::identity(PARAMETERS_PER_LINK, PARAMETERS_PER_LINK);
        for (place, &pivot) in own.pivots.iter().enumerate() {
            for k in 0..PARAMETERS_PER_LINK {
                rest[(pivot, k)] -= own.factors[(place, k)];
            }
        }
        if let Some(parent) = robot.joints[link].parent {
            let passed_on = product(&own.seen_from_parent, &rest);
            let of_parent = map.columns(PARAMETERS_PER_LINK * parent, PARAMETERS_PER_LINK).into_owned();
            map.columns_mut(first, PARAMETERS_PER_LINK).copy_from(&product(&of_parent, &passed_on));
        }
        for (place, &pivot) in own.pivots.iter().enumerate() {
            if let Ok(row) = pivots.binary_search(&(first + pivot)) {
                for k in 0..PARAMETERS_PER_LINK {
                    map[(row, first + k)] += own.factors[(place, k)];
                }
            }
        }
    }
    map
}

impl Own {
    fn new(robot: &Robot, link: usize, columns: &[DMatrix<f64>], largest: f64, work: &mut usize) -> Self {
        let joint = &robot.joints[link];
        let pose = joint.pose(0.0);
        let seen = |k: usize| {
            let mut unit = InertialParameters::ZERO;
            unit.0[k] = 1.0;
            DVector::from_column_slice(unit.moved(&pose).as_slice())
        };
        let seen: Vec<DVector<f64>> = (0..PARAMETERS_PER_LINK).map(seen).collect();
        let seen_from_parent = DMatrix::from_columns(&seen);
        let mut beyond = columns[link].clone();
        if let Some(parent) = joint.parent {
            let replaced = product(&columns[parent], &seen_from_parent);
            // The rows of a link are those of its parent and, last at every state, its own joint's.
            let levels = beyond.nrows() / STATES;
            for (row, values) in replaced.row_iter().enumerate() {
                let (state, level) = (row / (levels - 1), row % (levels - 1));
                beyond.row_mut(state * levels + level).zip_apply(&values, |y, other| *y -= other);
            }
        }
        let sizes: Vec<f64> = columns[link].column_iter().map(|c| c.norm()).collect();
        let pivots = independent(&beyond, &sizes, largest, work);
        let factors = dependence(&beyond, &pivots);
        Self { pivots, factors, seen_from_parent }
    }
}

/// The regressor at random states, one block per link: rows are states, in each the joints that carry the link from the
/// base outwards.
fn random_regressor(robot: &Robot) -> Vec<DMatrix<f64>> {
    let chain = Chain::new(robot);
    let n = robot.dof();
    let mut level = vec![0; n];
    for &k in &robot.order {
        level[k] = robot.joints[k].parent.map_or(0, |p| level[p] + 1);
    }
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(0x6c61_6375_6e61);
    let mut columns: Vec<DMatrix<f64>> =
        level.iter().map(|l| DMatrix::zeros(STATES * (l + 1), PARAMETERS_PER_LINK)).collect();
    let (mut ws, mut twists) = (Workspace::new(&chain, 0.0), Twists::new(&chain, 0.0));
    for state in 0..STATES {
        let mut draw = |reach: f64| -> Vec<f64> { (0..n).map(|_| rng.random_range(-reach..reach)).collect() };
        let (q, dq, ddq) = (draw(std::f64::consts::PI), draw(3.0), draw(5.0));
        regressor(&chain, &mut ws, &mut twists, State::new(&q, &dq, &ddq), |joint, link, values| {
            let row = state * (level[link] + 1) + level[joint];
            for (c, value) in values.into_iter().enumerate() {
                columns[link][(row, c)] = value;
            }
        });
    }
    columns
}

/// Greedy choice by Gram-Schmidt with a second pass, in [`ORDER`]; `sizes` are those of the columns as they were.
fn independent(beyond: &DMatrix<f64>, sizes: &[f64], largest: f64, work: &mut usize) -> Vec<usize> {
    let mut basis: Vec<DVector<f64>> = Vec::new();
    let mut pivots = Vec::new();
    for k in ORDER {
        let mut rest: DVector<f64> = beyond.column(k).into_owned();
        for _ in 0..2 {
            for b in &basis {
                let part = b.dot(&rest);
                rest.axpy(-part, b, 1.0);
            }
        }
        *work += 2 * 2 * basis.len() * rest.len();
        let left = rest.norm();
        if left > DEPENDENT * sizes[k] && left > DEPENDENT * largest {
            basis.push(rest / left);
            pivots.push(k);
        }
    }
    pivots
}

/// Expresses every column by those of the pivots.
fn dependence(beyond: &DMatrix<f64>, pivots: &[usize]) -> DMatrix<f64> {
    if pivots.is_empty() {
        return DMatrix::zeros(0, PARAMETERS_PER_LINK);
    }
    let qr = beyond.select_columns(pivots).qr();
    let mut factors = product(&qr.q().transpose(), beyond);
    let solved = qr.r().solve_upper_triangular_mut(&mut factors);
    debug_assert!(solved, "pivot columns are independent");
    factors
}
