//! Barrier terms of those bounds of a chart that are no convex condition on the unknowns.

use super::terms::{LogSum, Slopes, Term};
use crate::space::Parameter;
use crate::{Chart, Side};

/// Such bounds of one group of search coordinates, measured on the coordinates themselves.
#[derive(Debug, Clone)]
pub(super) struct Bounds {
    group: usize,
    start: usize,
    /// Per coordinate: lower and upper bound, infinite where a barrier term has it.
    limits: Vec<[f64; 2]>,
}

/// Coordinates of a group and their derivatives with respect to its unknowns (row per coordinate).
struct Place {
    p: Vec<f64>,
    jacobian: Vec<f64>,
}

impl Bounds {
    /// The bounds of a chart: convex ones as terms, the others group by group.
    pub(super) fn of(chart: &dyn Chart) -> (Vec<Term>, Vec<Self>) {
        let (space, mut terms) = (chart.space(), Vec::new());
        let mut groups = Vec::new();
        for (group, range) in space.ranges().into_iter().enumerate() {
            let limits: Vec<[f64; 2]> = range
                .clone()
                .map(|i| {
                    let mut keep = |side, value, none| match chart.convex_bound(i, side) {
                        Some(body) => {
                            terms.push(Term::bound(&body));
                            none
                        }
                        None => value,
                    };
                    let [lower, upper] = widened(&space.parameters[i]);
                    [keep(Side::Lower, lower, f64::NEG_INFINITY), keep(Side::Upper, upper, f64::INFINITY)]
                })
                .collect();
            if limits.iter().flatten().any(|v| v.is_finite()) {
                groups.push(Self { group, start: range.start, limits });
            }
        }
        (terms, groups)
    }

    /// Number of bounds.
    pub(super) fn degree(&self) -> f64 {
        self.limits.iter().flatten().filter(|v| v.is_finite()).count() as f64
    }

    /// Adds the logarithms of all distances to the bounds; `false` outside.
    pub(super) fn add_logs(&self, chart: &dyn Chart, x: &[f64], p: &mut Vec<f64>, logs: &mut LogSum) -> bool {
        p.resize(self.limits.len(), 0.0);
        chart.group_to_coordinates(self.group, &x[self.start..self.start + self.limits.len()], p);
        p.iter().zip(&self.limits).all(|(&v, &[lower, upper])| {
            (lower.is_infinite() || logs.add(v - lower)) && (upper.is_infinite() || logs.add(upper - v))
        })
    }

    /// Adds `mu` times their derivatives, with the Gauss-Newton part of the Hessian.
    pub(super) fn add_slopes(&self, chart: &dyn Chart, x: &[f64], mu: f64, slopes: &mut Slopes<'_>) {
        let n = self.limits.len();
        let place = self.place(chart, &x[self.start..self.start + n]);
        for (i, &[lower, upper]) in self.limits.iter().enumerate() {
            // Zero where there is no bound.
            let (below, above) = (1.0 / (place.p[i] - lower), 1.0 / (upper - place.p[i]));
            let row: Vec<(usize, f64)> = (0..n)
                .map(|k| (self.start + k, place.jacobian[i * n + k]))
                .filter(|(_, slope)| slope.abs() > 0.0)
                .collect();
            slopes.outer(&row, mu * (above - below), mu * (above * above + below * below));
        }
    }

    /// Central differences: charts are smooth, and a barrier needs no more than six digits of them.
    fn place(&self, chart: &dyn Chart, z: &[f64]) -> Place {
        let n = z.len();
        let (mut jacobian, mut moved) = (vec![0.0; n * n], z.to_vec());
        let (mut above, mut below, mut p) = (vec![0.0; n], vec![0.0; n], vec![0.0; n]);
        for k in 0..n {
            let h = (1e-6 * z[k].abs()).max(1e-8);
            moved[k] = z[k] + h;
            chart.group_to_coordinates(self.group, &moved, &mut above);
            let top = moved[k];
            moved[k] = z[k] - h;
            chart.group_to_coordinates(self.group, &moved, &mut below);
            let width = top - moved[k];
            moved[k] = z[k];
            for i in 0..n {
                jacobian[i * n + k] = (above[i] - below[i]) / width;
            }
        }
        chart.group_to_coordinates(self.group, z, &mut p);
        Place { p, jacobian }
    }
}

/// A coordinate that is fixed gets a corridor within what counts as rounding, for a barrier needs an interior.
fn widened(about: &Parameter) -> [f64; 2] {
    let (lower, upper) = (about.lower, about.upper);
    let least = 1e-10 * lower.abs().max(upper.abs()).max(1.0);
    if upper - lower >= least { [lower, upper] } else { [lower - least, upper + least] }
}
