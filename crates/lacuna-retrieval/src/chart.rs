//! Coordinates to search in.
//!
//! Objective and cones are simplest in one set of unknowns `z` (link-frame moments), bounds and random
//! starts in another `p` (mass, centre of mass, inertia about it). A chart leads from `p` to `z`.

use std::fmt::Debug;

use crate::form::{Affine, Body};
use crate::space::Space;

/// Which of a coordinate's two bounds.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Side {
    /// The lower bound.
    Lower,
    /// The upper bound.
    Upper,
}

/// Search coordinates `p` with finite bounds, and the way to the unknowns `z`.
///
/// Groups of `p` and of `z` correspond: moving `p` within a group changes `z` only within that group.
pub trait Chart: Debug + Send + Sync {
    /// The coordinates with their bounds.
    fn space(&self) -> &Space;

    /// Writes the unknowns of one group for the coordinates of that group.
    fn group_to_unknowns(&self, group: usize, p: &[f64], z: &mut [f64]);

    /// Coordinates of one group for its unknowns, as far as they are determined (0 where they are not).
    fn group_to_coordinates(&self, group: usize, z: &[f64], p: &mut [f64]);

    /// Largest size of every unknown while the coordinates stay within their bounds, where that is known.
    fn reach(&self) -> Option<Vec<f64>> {
        None
    }

    /// A convex condition on the unknowns that is the same as one bound of a coordinate, where there is
    /// one. Solvers that work in the unknowns converge better on it than on the coordinate itself.
    fn convex_bound(&self, _coordinate: usize, _side: Side) -> Option<Body> {
        None
    }

    /// Unknowns for all coordinates.
    fn unknowns(&self, p: &[f64]) -> Vec<f64> {
        let mut z = vec![0.0; p.len()];
        for (group, range) in self.space().ranges().into_iter().enumerate() {
            self.group_to_unknowns(group, &p[range.clone()], &mut z[range]);
        }
        z
    }

    /// Coordinates for all unknowns.
    fn coordinates(&self, z: &[f64]) -> Vec<f64> {
        let mut p = vec![0.0; z.len()];
        for (group, range) in self.space().ranges().into_iter().enumerate() {
            self.group_to_coordinates(group, &z[range.clone()], &mut p[range]);
        }
        p
    }
}

/// Search coordinates that are the unknowns themselves.
#[derive(Debug, Clone, PartialEq)]
pub struct Identity {
    /// The unknowns with finite bounds.
    pub space: Space,
}

impl Chart for Identity {
    fn space(&self) -> &Space {
        &self.space
    }

    fn group_to_unknowns(&self, _group: usize, p: &[f64], z: &mut [f64]) {
        z.copy_from_slice(p);
    }

    fn group_to_coordinates(&self, _group: usize, z: &[f64], p: &mut [f64]) {
        p.copy_from_slice(z);
    }

    fn reach(&self) -> Option<Vec<f64>> {
        Some(self.space.parameters.iter().map(|p| p.lower.abs().max(p.upper.abs())).collect())
    }

    fn convex_bound(&self, coordinate: usize, side: Side) -> Option<Body> {
        let (parameter, value) = (&self.space.parameters[coordinate], Affine::variable(coordinate));
        let row = match side {
            Side::Lower => value.plus(-parameter.lower, &Affine::constant(1.0)),
            Side::Upper => value.times(-1.0).plus(parameter.upper, &Affine::constant(1.0)),
        };
        Some(Body::Affine(row))
    }
}
