use serde::{Deserialize, Serialize};

use super::measure::is_body;
use super::{About, Constraint, LinkSpace, Links};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// The principal moments of inertia are those of a body (Gaz et al. 2019, eq. 16).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct TriangleInequality {
    /// Links it holds for.
    pub links: Links,
}

impl TriangleInequality {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "triangle_inequality",
        title: "each link is a body with non-negative density",
        text: "No principal moment of inertia about the centre of mass exceeds the sum of the other two, and \
               the mass is not negative. Use it in every study: without it the parameters may reproduce the \
               torque but belong to no body, and simulators refuse them. It is the paper's condition on the \
               inertia tensor, taken together with that on the mass so that it becomes convex.",
        condition: "tr(I)/2 - lambda_max(I) >= 0, equivalently [[tr(J)/2 1 - J, m c], [(m c)^T, m]] is positive semidefinite",
        settings: &[("links", "", "links it holds for, Only([\"name\", ..]); All when not given")],
        example: r#"{"triangle_inequality": ()}"#,
        form: "semidefinite: every engine",
    };
}

#[typetag::serde(name = "triangle_inequality")]
impl Constraint for TriangleInequality {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let form = |link: usize| {
            let label = format!("{}: triangle inequality", space.names[link]);
            is_body(label, space.pseudo_inertia(link))
        };
        Ok(self.links.indices(robot)?.into_iter().map(form).collect())
    }
}
