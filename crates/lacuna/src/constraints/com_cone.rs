use serde::{Deserialize, Serialize};

use super::number::{direction, not_negative, positive, triple};
use super::shape::yes;
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, inside, within};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// The centre of mass lies in a truncated cone.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComCone {
    /// Links it holds for; coordinates are in each link's own frame.
    pub links: Links,
    /// Centre of the base disc \[m\].
    #[serde(deserialize_with = "triple")]
    pub base: [f64; 3],
    /// From base to top, of any length.
    #[serde(deserialize_with = "direction")]
    pub axis: [f64; 3],
    /// Radius of the base \[m\].
    #[serde(deserialize_with = "not_negative")]
    pub radius: f64,
    /// Radius of the top \[m\].
    #[serde(deserialize_with = "not_negative")]
    pub top_radius: f64,
    /// From base to top \[m\].
    #[serde(deserialize_with = "positive")]
    pub height: f64,
    /// Whether base and top bound it too.
    #[serde(default = "yes")]
    pub caps: bool,
}

impl ComCone {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "com_cone",
        title: "the centre of mass lies in a truncated cone",
        text: "For tapered links. With caps: false only the slanted surface counts, on both sides of \
               the base: together with a com_cylinder this is the cylinder with a conical tip of the \
               paper's supplement, which is convex although it is written there as an if-else rule.",
        condition: "|across(m c - m base)| <= radius m + (top_radius - radius)/height along(m c - m base), 0 <= along(..) <= height m",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            ("base", "m", "centre of the base disc, (x, y, z)"),
            ("axis", "", "from base to top, (x, y, z), of any length"),
            ("radius", "m", "radius of the base"),
            ("top_radius", "m", "radius of the top; 0 for a point"),
            ("height", "m", "from base to top"),
            ("caps", "", "whether base and top bound it too; true when not given"),
        ],
        example: r#"{"com_cone": (links: Only(["1"]), base: (0.0, 0.0, -0.1), axis: (0.0, 0.0, 1.0), radius: 0.15, top_radius: 0.05, height: 0.4)}"#,
        form: "norm and affine: every engine",
    };

    fn shape(&self) -> Shape {
        Shape::Cone {
            base: self.base,
            axis: self.axis,
            radius: self.radius,
            top_radius: self.top_radius,
            height: self.height,
            caps: self.caps,
        }
    }
}

#[typetag::serde(name = "com_cone")]
impl Constraint for ComCone {
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
