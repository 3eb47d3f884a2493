use serde::{Deserialize, Serialize};

use super::number::{direction, optional_positive, positive, triple};
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, inside, within};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// The centre of mass lies in a cylinder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComCylinder {
    /// Links it holds for; coordinates are in each link's own frame.
    pub links: Links,
    /// Centre, half-way up \[m\].
    #[serde(deserialize_with = "triple")]
    pub center: [f64; 3],
    /// Direction of the axis, of any length.
    #[serde(deserialize_with = "direction")]
    pub axis: [f64; 3],
    /// Radius \[m\].
    #[serde(deserialize_with = "positive")]
    pub radius: f64,
    /// Height \[m\]; endless when not given.
    #[serde(default, deserialize_with = "optional_positive")]
    pub height: Option<f64>,
}

impl ComCylinder {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "com_cylinder",
        title: "the centre of mass lies in a cylinder",
        text: "For tube-like links: the two-link robot of the paper's supplement, or the arms of a \
               UR. Without a height only the distance to the axis counts.",
        condition: "|across(m c - m center)| <= radius m, |along(m c - m center)| <= height/2 m",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            ("center", "m", "centre, half-way up, (x, y, z)"),
            ("axis", "", "direction of the axis, (x, y, z), of any length"),
            ("radius", "m", "radius"),
            ("height", "m", "height; endless when not given"),
        ],
        example: r#"{"com_cylinder": (links: Only(["1"]), center: (0.0, 0.0, 0.1), axis: (0.0, 0.0, 1.0), radius: 0.1, height: 0.4)}"#,
        form: "norm and affine: every engine",
    };

    fn shape(&self) -> Shape {
        Shape::Cylinder { center: self.center, axis: self.axis, radius: self.radius, height: self.height }
    }
}

#[typetag::serde(name = "com_cylinder")]
impl Constraint for ComCylinder {
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
