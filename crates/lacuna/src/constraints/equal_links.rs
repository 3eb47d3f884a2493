use serde::{Deserialize, Serialize};

use super::number::positive;
use super::twins::twins;
use super::{About, Constraint, LinkSpace};
use crate::error::Result;
use crate::form::Form;
use crate::robot::Robot;

/// Two links have the same parameters.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct EqualLinks {
    /// The two links.
    pub links: (String, String),
    /// How far mass, first moment and inertia may differ [SI units].
    #[serde(default = "micro", deserialize_with = "positive")]
    pub tolerance: f64,
}

fn micro() -> f64 {
    1e-6
}

impl EqualLinks {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "equal_links",
        title: "two links are the same part",
        text: "The same part built in twice: equal wrist housings, the legs of a parallel arm. Both must be \
               described in the same way in their own link frames, for example because both joints have the \
               same Denavit-Hartenberg row. Equality is held within a tolerance, since engines that search need \
               room; the smaller it is, the harder their work.",
        condition: "|m_a - m_b|, |m c_a - m c_b|, |J_a - J_b| <= tolerance, each in the 2-norm",
        settings: &[
            ("links", "", "the two links, (\"a\", \"b\")"),
            ("tolerance", "kg, kg m, kg m^2", "how far they may differ; 1e-6 when not given"),
        ],
        example: r#"{"equal_links": (links: ("1", "2"), tolerance: 1e-3)}"#,
        form: "norm: every engine",
    };
}

#[typetag::serde(name = "equal_links")]
impl Constraint for EqualLinks {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        twins(robot, space, [&self.links.0, &self.links.1], None, self.tolerance)
    }
}
