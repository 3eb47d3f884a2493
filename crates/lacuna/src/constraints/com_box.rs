use serde::{Deserialize, Serialize};

use super::number::triple;
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, inside, within};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// The centre of mass lies in a box.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComBox {
    /// Links it holds for; coordinates are in each link's own frame.
    pub links: Links,
    /// Smallest coordinates \[m\].
    #[serde(deserialize_with = "triple")]
    pub lower: [f64; 3],
    /// Largest coordinates \[m\].
    #[serde(deserialize_with = "triple")]
    pub upper: [f64; 3],
}

impl ComBox {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "com_box",
        title: "the centre of mass lies in a box along the frame's axes",
        text: "The simplest statement about a link's shape, and the paper's: the smallest box \
               parallel to the link frame that holds the link also holds its centre of mass, if the \
               link has no holes in its density. For slender links that lie oblique to their frame a \
               cylinder or hull is much tighter.",
        condition: "lower m <= m c <= upper m, per axis",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            ("lower", "m", "smallest coordinates, (x, y, z)"),
            ("upper", "m", "largest coordinates, (x, y, z)"),
        ],
        example: r#"{"com_box": (links: Only(["1"]), lower: (-0.1, -0.1, -0.3), upper: (0.1, 0.1, 0.1))}"#,
        form: "affine: every engine",
    };

    fn shape(&self) -> Shape {
        Shape::Box { lower: self.lower, upper: self.upper }
    }
}

#[typetag::serde(name = "com_box")]
impl Constraint for ComBox {
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
