use serde::{Deserialize, Serialize};

use super::number::{positive_triple, triple};
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, inside, within};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// The centre of mass lies in an ellipsoid.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComEllipsoid {
    /// Links it holds for; coordinates are in each link's own frame.
    pub links: Links,
    /// Centre \[m\].
    #[serde(deserialize_with = "triple")]
    pub center: [f64; 3],
    /// Half-lengths along its own axes \[m\].
    #[serde(deserialize_with = "positive_triple")]
    pub semi_axes: [f64; 3],
    /// Roll, pitch, yaw of its axes about the fixed link axes \[rad\].
    #[serde(default, deserialize_with = "triple")]
    pub rpy: [f64; 3],
}

impl ComEllipsoid {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "com_ellipsoid",
        title: "the centre of mass lies in an ellipsoid",
        text: "For a link's bounding ellipsoid, or a confidence region of a measured centre of mass. \
               density_realisable says more: with it the whole body fits into the ellipsoid.",
        condition: "|diag(1/semi_axes) R^T (m c - m center)| <= m",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            ("center", "m", "centre, (x, y, z)"),
            ("semi_axes", "m", "half-lengths along its own axes"),
            ("rpy", "rad", "roll, pitch, yaw of its axes, as in URDF; none when not given"),
        ],
        example: r#"{"com_ellipsoid": (links: Only(["1"]), center: (0.0, 0.0, 0.1), semi_axes: (0.1, 0.1, 0.2))}"#,
        form: "norm: every engine",
    };

    fn shape(&self) -> Shape {
        Shape::Ellipsoid { center: self.center, semi_axes: self.semi_axes, rpy: self.rpy }
    }
}

#[typetag::serde(name = "com_ellipsoid")]
impl Constraint for ComEllipsoid {
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
