//! Two links with the same parameters, or mirrored ones.

use super::LinkSpace;
use super::links::link_index;
use crate::error::{Error, Result};
use crate::form::{Affine, Body, Form};
use crate::robot::Robot;

/// Forms that make link `a` equal `b` within `tolerance` (SI units), `b` being mirrored along `axis` first if
/// one is given: mass, first moment and inertia about the link origin, each in the 2-norm.
pub(super) fn twins(
    robot: &Robot,
    space: &LinkSpace,
    [a, b]: [&str; 2],
    axis: Option<usize>,
    tolerance: f64,
) -> Result<Vec<Form>> {
    let (left, right) = (link_index(robot, a)?, link_index(robot, b)?);
    if left == right {
        return Err(Error::new(format!("`{a}` and `{b}` are the same link")).help("name two links"));
    }
    let sign = |axes: &[usize]| {
        let flips = axes.iter().filter(|&&k| Some(k) == axis).count();
        if flips == 1 { -1.0 } else { 1.0 }
    };
    let mass = vec![space.mass(left).plus(-1.0, &space.mass(right))];
    let moment = |k: usize| space.first_moment(left, k).plus(-sign(&[k]), &space.first_moment(right, k));
    let inertia = |(j, k): (usize, usize)| {
        space.inertia_at_origin(left, j, k).plus(-sign(&[j, k]), &space.inertia_at_origin(right, j, k))
    };
    let elements = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    let relation = if axis.is_some() { "mirrors" } else { "equals" };
    // A bound of 0 would leave no inside to search in; it is room to spare, so the scale stays 1.
    let form = |what: &str, unit: &str, rows: Vec<Affine>| {
        let label = format!(
            "{} {relation} {}: {what} within {tolerance} {unit}",
            space.names[left], space.names[right]
        );
        Form::new(label, unit, 1.0, Body::Norm { rows, bound: Affine::constant(tolerance) })
    };
    Ok(vec![
        form("mass", "kg", mass),
        form("first moment", "kg m", (0..3).map(moment).collect()),
        form("inertia", "kg m^2", elements.into_iter().map(inertia).collect()),
    ])
}
