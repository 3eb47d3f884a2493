use serde::{Deserialize, Serialize};

use super::measure::is_body;
use super::number::not_negative;
use super::{About, Constraint, LinkSpace, Links};
use crate::error::Result;
use crate::form::{Affine, Body, Form};
use crate::robot::Robot;

/// The pseudo-inertia is positive semidefinite, with room to spare where a margin is asked for
/// (Wensing, Kim and Slotine 2018).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct PseudoInertia {
    /// Links it holds for.
    pub links: Links,
    /// Smallest eigenvalue, in SI units (mixed: kg m², kg m, kg).
    #[serde(deserialize_with = "not_negative")]
    pub margin: f64,
}

impl PseudoInertia {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "pseudo_inertia",
        title: "each link's pseudo-inertia is positive definite by a margin",
        text: "The same set as triangle_inequality when the margin is 0. A margin keeps links strictly inside, \
               so that every link has mass and extent in all directions and simulators take it. The matrix mixes \
               kg m^2, kg m and kg, so its eigenvalues have no unit of their own and the margin means what it \
               means in SI units only. It costs accuracy: on the Panda 1e-7 moves the best objective by 3e-5 of \
               itself, 1e-4 by 3 per cent.",
        condition: "[[tr(J)/2 1 - J, m c], [(m c)^T, m]] - margin 1 is positive semidefinite",
        settings: &[
            ("links", "", "links it holds for, Only([\"name\", ..]); All when not given"),
            ("margin", "mixed SI", "smallest eigenvalue; 0 when not given"),
        ],
        example: r#"{"pseudo_inertia": (margin: 1e-7)}"#,
        form: "semidefinite: every engine",
    };
}

#[typetag::serde(name = "pseudo_inertia")]
impl Constraint for PseudoInertia {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let form = |link: usize| {
            let name = &space.names[link];
            let mut lower = space.pseudo_inertia(link);
            if self.margin <= 0.0 {
                return is_body(format!("{name}: pseudo-inertia is positive semidefinite"), lower);
            }
            for diagonal in [0, 2, 5, 9] {
                let entry = std::mem::take(&mut lower[diagonal]);
                lower[diagonal] = entry.plus(-1.0, &Affine::constant(self.margin));
            }
            // The margin is room to spare, not a quantity to compare with: the scale stays 1.
            let label = format!("{name}: pseudo-inertia has no eigenvalue below {}", self.margin);
            Form::new(label, "mixed SI", 1.0, Body::Psd { size: 4, lower })
        };
        Ok(self.links.indices(robot)?.into_iter().map(form).collect())
    }
}
