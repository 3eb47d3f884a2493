use serde::{Deserialize, Serialize};

use super::number::{optional, ordered};
use super::{About, Bound, Constraint, LinkSpace, Links, range_forms};
use crate::error::Result;
use crate::form::{Affine, Form};
use crate::robot::Robot;

/// The mass of the moving links together lies in a range (Gaz et al. 2019, eq. 30).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TotalMass {
    /// Links that are summed.
    pub links: Links,
    /// Smallest sum \[kg\].
    #[serde(deserialize_with = "optional")]
    pub min: Option<f64>,
    /// Largest sum \[kg\].
    #[serde(deserialize_with = "optional")]
    pub max: Option<f64>,
}

impl TotalMass {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "total_mass",
        title: "the moving links together weigh between two limits",
        text: "The data sheet says what the robot weighs; take off the base, which does not move and has no \
               parameters here. The paper uses 16 to 20 kg for the Panda. Joint torque alone does not tell the \
               total: on most robots the first link's mass is not identifiable.",
        condition: "min <= m1 + m2 + .. + mn <= max",
        settings: &[
            ("links", "", "links that are summed, Only([\"name\", ..]); All when not given"),
            ("min", "kg", "smallest sum; no limit when not given"),
            ("max", "kg", "largest sum; no limit when not given"),
        ],
        example: r#"{"total_mass": (min: 16.0, max: 20.0)}"#,
        form: "affine: every engine",
    };
}

#[typetag::serde(name = "total_mass")]
impl Constraint for TotalMass {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        ordered("total_mass", self.min, self.max, "kg")?;
        let links = self.links.indices(robot)?;
        let sum = links.iter().fold(Affine::default(), |sum, &link| sum.plus(1.0, &space.mass(link)));
        let what = match &self.links {
            Links::All => "total mass".to_string(),
            Links::Only(names) => format!("total mass of {}", names.join(", ")),
        };
        Ok(range_forms(&what, "kg", &sum, self.min, self.max))
    }

    /// No link outweighs the sum; that masses are not negative is another constraint's to say.
    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        let max = self.max.unwrap_or(f64::INFINITY);
        let bound = |link| Bound::mass(link, f64::NEG_INFINITY, max);
        Ok(self.links.indices(robot)?.into_iter().map(bound).collect())
    }
}
