use serde::{Deserialize, Serialize};

use super::links::link_index;
use super::measure::per_mass;
use super::number::{optional, ordered};
use super::{About, Constraint, LinkSpace};
use crate::error::{Error, Result};
use crate::form::Form;
use crate::robot::Robot;

/// One link weighs so many times another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MassRatio {
    /// The link whose mass is compared.
    pub link: String,
    /// The link it is compared with.
    pub to: String,
    /// Smallest ratio.
    #[serde(default, deserialize_with = "optional")]
    pub min: Option<f64>,
    /// Largest ratio.
    #[serde(default, deserialize_with = "optional")]
    pub max: Option<f64>,
}

impl MassRatio {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "mass_ratio",
        title: "one link weighs between min and max times another",
        text: "For parts whose sizes or materials are known relative to each other, when the masses themselves \
               are not: scaled links of a robot family, or equal castings of two lengths.",
        condition: "min m_to <= m_link <= max m_to",
        settings: &[
            ("link", "", "the link whose mass is compared"),
            ("to", "", "the link it is compared with"),
            ("min", "kg/kg", "smallest ratio; no limit when not given"),
            ("max", "kg/kg", "largest ratio; no limit when not given"),
        ],
        example: r#"{"mass_ratio": (link: "1", to: "2", min: 0.5, max: 2.0)}"#,
        form: "affine: every engine",
    };
}

#[typetag::serde(name = "mass_ratio")]
impl Constraint for MassRatio {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        ordered("mass_ratio", self.min, self.max, "kg/kg")?;
        let (link, to) = (link_index(robot, &self.link)?, link_index(robot, &self.to)?);
        if link == to {
            return Err(Error::new(format!("mass_ratio compares `{}` with itself", self.link)));
        }
        let (mass, other) = (space.mass(link), space.mass(to));
        let what = format!("mass of {} to mass of {}", space.names[link], space.names[to]);
        let form = |relation: &str, ratio: f64, sign: f64| {
            let row = mass.clone().plus(-ratio, &other).times(sign);
            let form = Form::affine(format!("{what} {relation} {ratio}"), "kg/kg", ratio, row);
            per_mass(form, other.clone())
        };
        let least = self.min.map(|ratio| form(">=", ratio, 1.0));
        let most = self.max.map(|ratio| form("<=", ratio, -1.0));
        Ok(least.into_iter().chain(most).collect())
    }
}
