//! Constraints: what link parameters must satisfy. Each is a plug-in, one file each; [`CATALOGUE`] names
//! those that ship.
//!
//! A constraint is lowered once per study to [`Form`]s over the unknowns of [`LinkSpace`]. Margins are
//! reported in the constraint's own unit (a centre of mass in metres), while the form is written in mass,
//! first moment and inertia about the link origin, where it is convex whenever it can be.

mod com_box;
mod com_cone;
mod com_cylinder;
mod com_ellipsoid;
mod com_hull;
mod com_sphere;
mod com_union;
mod density_realisable;
mod equal_links;
mod hull;
mod intervals;
mod known_payload;
mod links;
mod mass_order;
mod mass_range;
mod mass_ratio;
mod measure;
mod mesh;
mod mirrored_links;
mod number;
mod parameter_bounds;
mod positive_mass;
mod pseudo_inertia;
mod script;
mod search;
mod shape;
mod space;
mod stl;
mod total_mass;
mod triangle_inequality;
mod twins;

pub use com_box::ComBox;
pub use com_cone::ComCone;
pub use com_cylinder::ComCylinder;
pub use com_ellipsoid::ComEllipsoid;
pub use com_hull::ComHull;
pub use com_sphere::ComSphere;
pub use com_union::ComUnion;
pub use density_realisable::DensityRealisable;
pub use equal_links::EqualLinks;
pub use intervals::{Interval, Intervals};
pub use known_payload::{KnownPayload, Tensor};
pub use links::{Links, link_index};
pub use mass_order::MassOrder;
pub use mass_range::MassRange;
pub use mass_ratio::MassRatio;
pub use mesh::Mesh;
pub use mirrored_links::{Axis, MirroredLinks};
pub use parameter_bounds::ParameterBounds;
pub use positive_mass::PositiveMass;
pub use pseudo_inertia::PseudoInertia;
pub(crate) use script::explain_until;
pub use script::{Explanation, FormExplanation, RuleExplanation, Scripted, explain};
pub use search::{Bound, SearchSpace, search_space};
pub use shape::{Extent, Shape};
pub use space::{Barycentric, COORDINATES, LinkSpace};
pub use total_mass::TotalMass;
pub use triangle_inequality::TriangleInequality;

use std::fmt::Debug;
use std::path::Path;

use crate::error::Result;
use crate::form::{Affine, Form};
use crate::robot::Robot;
use crate::stop::Stop;
use crate::text;

/// What a constraint says about itself; printed by `lacuna list constraints NAME`.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct About {
    /// Name in RON, JSON and on the command line.
    pub name: &'static str,
    /// One line for the catalogue.
    pub title: &'static str,
    /// What it means and when to use it.
    pub text: &'static str,
    /// The condition as a formula.
    pub condition: &'static str,
    /// Settings: name, unit, meaning.
    pub settings: &'static [(&'static str, &'static str, &'static str)],
    /// An entry of a scenario to start from, in RON: links by number, so that it fits any robot that has them.
    pub example: &'static str,
    /// Which forms it lowers to, and so which engines take it.
    pub form: &'static str,
}

/// A condition on link parameters. What it cannot express: conditions on torque or data, and conditions
/// that hold only for some motions.
#[typetag::serde]
pub trait Constraint: Debug + Send + Sync {
    /// Name, text and condition.
    fn about(&self) -> About;

    /// Reads the files it names, which are relative to `folder`, that of the scenario. Called once, before
    /// anything else is asked for.
    ///
    /// # Errors
    /// When a file is missing, damaged, or outside the scenario's repository.
    fn load(&mut self, _folder: &Path) -> Result<()> {
        Ok(())
    }

    /// Told which work it belongs to, before its forms are asked for: they may take long where a script states them.
    fn ends_with(&mut self, _stop: &Stop) {}

    /// The forms it stands for on this robot.
    ///
    /// # Errors
    /// When its settings do not fit the robot.
    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>>;

    /// Bounds on single coordinates that follow from it; engines that search draw their starts within them.
    ///
    /// # Errors
    /// When its settings do not fit the robot.
    fn bounds(&self, _robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        Ok(Vec::new())
    }
}

/// The constraints that ship, the most general first.
pub const CATALOGUE: &[fn() -> About] = &[
    || TriangleInequality::ABOUT,
    || PseudoInertia::ABOUT,
    || PositiveMass::ABOUT,
    || MassRange::ABOUT,
    || TotalMass::ABOUT,
    || MassRatio::ABOUT,
    || MassOrder::ABOUT,
    || ComBox::ABOUT,
    || ComSphere::ABOUT,
    || ComCylinder::ABOUT,
    || ComCone::ABOUT,
    || ComEllipsoid::ABOUT,
    || ComHull::ABOUT,
    || ComUnion::ABOUT,
    || DensityRealisable::ABOUT,
    || EqualLinks::ABOUT,
    || MirroredLinks::ABOUT,
    || KnownPayload::ABOUT,
    || ParameterBounds::ABOUT,
    || Scripted::ABOUT,
];

/// Reads a file that holds a list of constraints, such as `scenarios/panda_bounds.ron`, and loads what they
/// name.
///
/// # Errors
/// With file, line and column, and what is known there.
pub fn open(path: &Path) -> Result<Vec<Box<dyn Constraint>>> {
    let mut all: Vec<Box<dyn Constraint>> =
        text::from_ron(&text::read(path)?).map_err(|e| e.in_file(path))?;
    let folder = path.parent().unwrap_or(Path::new("."));
    for constraint in &mut all {
        constraint.load(folder)?;
    }
    Ok(all)
}

/// The forms of all constraints, in order.
///
/// # Errors
/// When one does not fit the robot; the message names it.
pub fn forms(robot: &Robot, space: &LinkSpace, constraints: &[Box<dyn Constraint>]) -> Result<Vec<Form>> {
    let mut all = Vec::new();
    for constraint in constraints {
        let name = constraint.about().name;
        all.extend(constraint.forms(robot, space).map_err(|e| e.within(name))?);
    }
    Ok(all)
}

/// `min <= what <= max` as affine forms, each scaled by its own bound.
fn range_forms(what: &str, unit: &str, row: &Affine, min: Option<f64>, max: Option<f64>) -> Vec<Form> {
    let form = |relation: &str, bound: f64, sign: f64| {
        let row = row.clone().plus(-1.0, &Affine::constant(bound)).times(sign);
        Form::affine(format!("{what} {relation} {bound} {unit}"), unit, bound, row)
    };
    let least = min.map(|bound| form(">=", bound, 1.0));
    least.into_iter().chain(max.map(|bound| form("<=", bound, -1.0))).collect()
}

/// The centre of mass of each of `links` is inside `shape`.
fn inside(links: &Links, shape: &Shape, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
    let of_links = links.indices(robot)?.into_iter().map(|link| shape.forms(space, link));
    Ok(of_links.collect::<Result<Vec<_>>>()?.into_iter().flatten().collect())
}

/// The centre of mass of each of `links` is inside a box.
fn within(links: &Links, extent: &Extent, robot: &Robot) -> Result<Vec<Bound>> {
    let of_link =
        |link: usize| (0..3).map(move |axis| Bound::com(link, axis, extent[axis].0, extent[axis].1));
    Ok(links.indices(robot)?.into_iter().flat_map(of_link).collect())
}
