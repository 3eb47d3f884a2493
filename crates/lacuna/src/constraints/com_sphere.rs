use serde::{Deserialize, Serialize};

use super::number::{positive, triple};
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, inside, within};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// The centre of mass lies in a ball.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComSphere {
    /// Links it holds for; coordinates are in each link's own frame.
    pub links: Links,
    /// Centre \[m\].
    #[serde(deserialize_with = "triple")]
    pub center: [f64; 3],
    /// Radius \[m\].
    #[serde(deserialize_with = "positive")]
    pub radius: f64,
}

impl ComSphere {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "com_sphere",
        title: "the centre of mass lies in a ball",
        text: "For compact links such as wrists, and for \"known to within 2 cm\": a centre of mass \
               from CAD with its uncertainty.",
        condition: "|m c - m center| <= radius m",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            ("center", "m", "centre, (x, y, z)"),
            ("radius", "m", "radius"),
        ],
        example: r#"{"com_sphere": (links: Only(["1"]), center: (0.0, 0.0, 0.1), radius: 0.15)}"#,
        form: "norm: every engine",
    };

    fn shape(&self) -> Shape {
        Shape::Sphere { center: self.center, radius: self.radius }
    }
}

#[typetag::serde(name = "com_sphere")]
impl Constraint for ComSphere {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        inside(&self.links, &self.shape(), robot, space)
    }

    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        within(&self.links, &self.shape().extent()?, robot)
    }
}
