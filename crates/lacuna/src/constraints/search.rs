//! Where engines that search may look: finite bounds on every coordinate, gathered from all constraints.

use std::collections::BTreeMap;

use super::{Barycentric, COORDINATES, Constraint, LinkSpace};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// Largest mass \[kg\] of a link about which nothing is known.
const HEAVY: f64 = 100.0;
/// Smallest reach \[m\] of a link's body from its frame when nothing is known.
const REACH: f64 = 0.5;
/// Largest size of a parameter beside the links' (friction, say) about which nothing is known.
const OTHER: f64 = 1e3;

/// Bounds on a barycentric coordinate (`m1`, `c1x`, `I1xx`) or on another parameter that follow from a
/// constraint; infinite where there are none.
#[derive(Debug, Clone, PartialEq)]
pub struct Bound {
    /// Name of the coordinate.
    pub name: String,
    /// Smallest value.
    pub lower: f64,
    /// Largest value.
    pub upper: f64,
}

impl Bound {
    /// On a link's mass \[kg\]; links count from 0.
    pub fn mass(link: usize, lower: f64, upper: f64) -> Self {
        Self { name: format!("m{}", link + 1), lower, upper }
    }

    /// On a coordinate of a link's centre of mass \[m\]; links and axes count from 0.
    pub fn com(link: usize, axis: usize, lower: f64, upper: f64) -> Self {
        Self { name: format!("c{}{}", link + 1, ["x", "y", "z"][axis]), lower, upper }
    }
}

/// Coordinates to search in, and what had to be assumed.
#[derive(Debug, Clone, PartialEq)]
pub struct SearchSpace {
    /// The coordinates; every bound is finite.
    pub chart: Barycentric,
    /// Coordinates that no constraint bounds, with what was taken instead, for people.
    pub assumed: Vec<String>,
}

/// The intersection of all bounds that the constraints imply. Where they leave a side open, wide limits are
/// taken from the robot's size and masses, and named in `assumed`.
///
/// # Errors
/// When two constraints leave no value for a coordinate, or a constraint does not fit the robot.
pub fn search_space(
    robot: &Robot,
    space: &LinkSpace,
    constraints: &[Box<dyn Constraint>],
) -> Result<SearchSpace> {
    let mut known: BTreeMap<String, (f64, f64)> = BTreeMap::new();
    for constraint in constraints {
        for Bound { name, lower, upper } in constraint.bounds(robot, space)? {
            let entry = known.entry(name.clone()).or_insert((f64::NEG_INFINITY, f64::INFINITY));
            *entry = (entry.0.max(lower), entry.1.min(upper));
            if entry.0 > entry.1 {
                let text = format!(
                    "the constraints contradict each other: {name} must be at least {} and at most {} (the last \
                     one read is {})",
                    entry.0,
                    entry.1,
                    constraint.about().name
                );
                return Err(Error::new(text).help("widen one of the bounds, or take one out"));
            }
        }
    }
    let mut assumed = Vec::new();
    let (heavy, reach) = (heaviest(robot), reach(robot));
    for link in 0..space.links {
        let mut names = COORDINATES.iter().map(|(head, tail, _)| format!("{head}{}{tail}", link + 1));
        let mass = close(&mut known, names.next(), (0.0, heavy), &mut assumed);
        let mut far = 0.0;
        for name in names.by_ref().take(3) {
            let (lower, upper) = close(&mut known, Some(name), (-reach, reach), &mut assumed);
            far = f64::max(far, lower.abs().max(upper.abs()));
        }
        // No part of the body is farther from its centre of mass than twice what bounds that.
        let largest = mass.1.max(0.0) * (2.0 * far.max(0.5 * reach)).powi(2);
        for ((head, tail, _), name) in COORDINATES[4..].iter().zip(names) {
            let diagonal = tail.chars().collect::<std::collections::BTreeSet<_>>().len() == 1;
            debug_assert_eq!(*head, "I");
            let limits = if diagonal { (0.0, largest) } else { (-0.5 * largest, 0.5 * largest) };
            close(&mut known, Some(name), limits, &mut assumed);
        }
    }
    for other in &space.space.parameters[10 * space.links..] {
        close(&mut known, Some(other.name.clone()), (-OTHER, OTHER), &mut assumed);
    }
    let chart = Barycentric::new(space, |name| known.get(name).copied().unwrap_or((-OTHER, OTHER)));
    Ok(SearchSpace { chart, assumed })
}

/// Closes open sides of a coordinate with `wide`, and says so.
fn close(
    known: &mut BTreeMap<String, (f64, f64)>,
    name: Option<String>,
    wide: (f64, f64),
    assumed: &mut Vec<String>,
) -> (f64, f64) {
    let Some(name) = name else { return wide };
    let entry = known.entry(name.clone()).or_insert((f64::NEG_INFINITY, f64::INFINITY));
    let before = *entry;
    if !entry.0.is_finite() {
        entry.0 = wide.0.min(before.1);
    }
    if !entry.1.is_finite() {
        entry.1 = wide.1.max(before.0);
    }
    if !(before.0.is_finite() && before.1.is_finite()) {
        assumed.push(format!("{name} from {:.4} to {:.4}", entry.0, entry.1));
    }
    *entry
}

/// Ten times the heaviest link of the robot file, where it has masses.
fn heaviest(robot: &Robot) -> f64 {
    let masses = robot.links.iter().filter_map(|l| l.inertia).map(|i| i.mass());
    let most = masses.fold(0.0, f64::max);
    if most > 0.0 { 10.0 * most } else { HEAVY }
}

/// A distance that no link's centre of mass should exceed: its longest link.
fn reach(robot: &Robot) -> f64 {
    let length = |j: &crate::robot::Joint| j.before.translation.norm() + j.after.translation.norm();
    robot.joints.iter().map(length).fold(REACH, f64::max)
}
