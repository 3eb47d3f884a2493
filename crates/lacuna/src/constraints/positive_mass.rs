use serde::{Deserialize, Serialize};

use super::measure::LIGHTEST;
use super::number::positive;
use super::{About, Bound, Constraint, LinkSpace, Links};
use crate::error::Result;
use crate::form::{Affine, Form};
use crate::robot::Robot;

/// Masses are strictly positive (Gaz et al. 2019, eq. 11).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PositiveMass {
    /// Links it holds for.
    pub links: Links,
    /// Smallest mass that counts as positive \[kg\].
    #[serde(deserialize_with = "positive")]
    pub at_least: f64,
}

impl Default for PositiveMass {
    fn default() -> Self {
        Self { links: Links::All, at_least: LIGHTEST }
    }
}

impl PositiveMass {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "positive_mass",
        title: "each link has mass",
        text: "The mass of a link is above 0. No solver can tell \"above\" from \"not below\", so a smallest mass \
               stands for it; below one milligram a link has no centre of mass to speak of. Use mass_range when \
               you know more.",
        condition: "m >= at_least > 0",
        settings: &[
            ("links", "", "links it holds for, Only([\"name\", ..]); All when not given"),
            ("at_least", "kg", "smallest mass; 1e-6 when not given"),
        ],
        example: r#"{"positive_mass": (at_least: 1e-6)}"#,
        form: "affine: every engine",
    };
}

#[typetag::serde(name = "positive_mass")]
impl Constraint for PositiveMass {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let form = |link: usize| {
            let row = space.mass(link).plus(-1.0, &Affine::constant(self.at_least));
            Form::affine(format!("{}: mass is positive", space.names[link]), "kg", 1.0, row)
        };
        Ok(self.links.indices(robot)?.into_iter().map(form).collect())
    }

    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        let bound = |link| Bound::mass(link, self.at_least, f64::INFINITY);
        Ok(self.links.indices(robot)?.into_iter().map(bound).collect())
    }
}
