use serde::{Deserialize, Serialize};

use super::links::link_index;
use super::number::not_negative;
use super::{About, Constraint, LinkSpace};
use crate::error::{Error, Result};
use crate::form::{Affine, Form};
use crate::robot::Robot;

/// Links in order of their masses.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct MassOrder {
    /// Links from the heaviest to the lightest.
    pub heaviest_first: Vec<String>,
    /// By how much each outweighs the next at least \[kg\].
    #[serde(default, deserialize_with = "not_negative")]
    pub gap: f64,
}

impl MassOrder {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "mass_order",
        title: "links named from the heaviest to the lightest",
        text: "Arms taper: the shoulder outweighs the elbow, the elbow the wrist. Often that is all one knows \
               without opening the robot, and it already rules out many sets of parameters that explain the \
               torque equally well.",
        condition: "m_a >= m_b + gap for each link a and the next one b",
        settings: &[
            ("heaviest_first", "", "two or more links, from the heaviest to the lightest"),
            ("gap", "kg", "smallest difference between neighbours; 0 when not given"),
        ],
        example: r#"{"mass_order": (heaviest_first: ["1", "2"], gap: 0.1)}"#,
        form: "affine: every engine",
    };
}

#[typetag::serde(name = "mass_order")]
impl Constraint for MassOrder {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        if self.heaviest_first.len() < 2 {
            return Err(Error::new("mass_order needs at least two links")
                .help("name them from the heaviest to the lightest"));
        }
        let links = self.heaviest_first.iter().map(|l| link_index(robot, l)).collect::<Result<Vec<_>>>()?;
        if let Some(i) = (1..links.len()).find(|&i| links[..i].contains(&links[i])) {
            let name = &self.heaviest_first[i];
            return Err(Error::new(format!("mass_order names link `{name}` twice")));
        }
        let form = |pair: &[usize]| {
            let (heavy, light) = (pair[0], pair[1]);
            let row =
                space.mass(heavy).plus(-1.0, &space.mass(light)).plus(-1.0, &Affine::constant(self.gap));
            let label = format!("mass of {} >= mass of {}", space.names[heavy], space.names[light]);
            Form::affine(label, "kg", self.gap, row)
        };
        Ok(links.windows(2).map(form).collect())
    }
}
