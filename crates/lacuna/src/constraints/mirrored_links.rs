use serde::{Deserialize, Serialize};

use super::number::positive;
use super::twins::twins;
use super::{About, Constraint, LinkSpace};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// An axis of the link frame.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
pub enum Axis {
    /// x.
    X,
    /// y.
    Y,
    /// z.
    Z,
}

/// Two links are mirror images.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MirroredLinks {
    /// The two links.
    pub links: (String, String),
    /// The coordinate that changes sign from one link's frame to the other's.
    pub along: Axis,
    /// How far mass, first moment and inertia may differ [SI units].
    #[serde(default = "micro", deserialize_with = "positive")]
    pub tolerance: f64,
}

fn micro() -> f64 {
    1e-6
}

impl MirroredLinks {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "mirrored_links",
        title: "two links are mirror images of each other",
        text: "Left and right: the fingers of a gripper, the arms of a humanoid. A point (x, y, z) of one link in \
               its frame has its image at the same coordinates in the other link's frame, one of them with the \
               other sign. Held within a tolerance, as equal_links is.",
        condition: "as equal_links, with m c and the two products of inertia along the mirrored axis negated",
        settings: &[
            ("links", "", "the two links, (\"a\", \"b\")"),
            ("along", "", "the coordinate that changes sign: X, Y or Z"),
            ("tolerance", "kg, kg m, kg m^2", "how far they may differ; 1e-6 when not given"),
        ],
        example: r#"{"mirrored_links": (links: ("1", "2"), along: Y, tolerance: 1e-3)}"#,
        form: "norm: every engine",
    };
}

#[typetag::serde(name = "mirrored_links")]
impl Constraint for MirroredLinks {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let axis = match self.along {
            Axis::X => 0,
            Axis::Y => 1,
            Axis::Z => 2,
        };
        twins(robot, space, [&self.links.0, &self.links.1], Some(axis), self.tolerance)
    }
}
