use serde::{Deserialize, Serialize};

use super::number::{optional, ordered};
use super::{About, Bound, Constraint, LinkSpace, Links, range_forms};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// Each link's mass lies in a range.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct MassRange {
    /// Links it holds for.
    pub links: Links,
    /// Smallest mass \[kg\].
    #[serde(deserialize_with = "optional")]
    pub min: Option<f64>,
    /// Largest mass \[kg\].
    #[serde(deserialize_with = "optional")]
    pub max: Option<f64>,
}

impl MassRange {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "mass_range",
        title: "each link's mass lies in a range",
        text: "Bounds on the mass of single links, from a data sheet, a scale or common sense: a link cannot \
               outweigh the robot. Masses are among the least determined parameters, so this is where knowledge \
               counts.",
        condition: "min <= m <= max",
        settings: &[
            ("links", "", "links it holds for, Only([\"name\", ..]); All when not given"),
            ("min", "kg", "smallest mass; no limit when not given"),
            ("max", "kg", "largest mass; no limit when not given"),
        ],
        example: r#"{"mass_range": (min: 0.1, max: 10.0)}"#,
        form: "affine: every engine",
    };
}

#[typetag::serde(name = "mass_range")]
impl Constraint for MassRange {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        ordered("mass_range", self.min, self.max, "kg")?;
        let links = self.links.indices(robot)?;
        let forms = |link: usize| {
            let what = format!("{}: mass", space.names[link]);
            range_forms(&what, "kg", &space.mass(link), self.min, self.max)
        };
        Ok(links.into_iter().flat_map(forms).collect())
    }

    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        let (min, max) = (self.min.unwrap_or(f64::NEG_INFINITY), self.max.unwrap_or(f64::INFINITY));
        Ok(self.links.indices(robot)?.into_iter().map(|link| Bound::mass(link, min, max)).collect())
    }
}
