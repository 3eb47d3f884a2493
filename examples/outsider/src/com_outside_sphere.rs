use std::sync::Arc;

use lacuna::Result;
use lacuna::constraints::{About, Constraint, LinkSpace, Links};
use lacuna::form::{Body, Form, General};
use lacuna::robot::{PARAMETERS_PER_LINK, Robot};
use serde::{Deserialize, Serialize};

/// The centre of mass does not lie in a hollow part of the link.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ComOutsideSphere {
    /// Links it holds for.
    pub links: Links,
    /// Centre of the hollow in the link frame \[m\].
    pub center: [f64; 3],
    /// Its radius \[m\].
    pub radius: f64,
}

#[typetag::serde(name = "com_outside_sphere")]
impl Constraint for ComOutsideSphere {
    fn about(&self) -> About {
        About {
            name: "com_outside_sphere",
            title: "the centre of mass does not lie in a ball",
            text: "For links with everything on one side of a hollow shaft, where the middle is known to be empty.",
            condition: "|c - center| >= radius",
            settings: &[
                ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
                ("center", "m", "centre of the ball, (x, y, z)"),
                ("radius", "m", "its radius"),
            ],
            example: r#"{"com_outside_sphere": (links: Only(["1"]), center: (0.0, 0.0, 0.1), radius: 0.05)}"#,
            form: "general: engines that search",
        }
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let form = |link: usize| {
            let function =
                Outside { first: PARAMETERS_PER_LINK * link, center: self.center, radius: self.radius };
            let body = Body::General {
                function: Arc::new(function),
                why: "what lies outside a ball is not convex".into(),
                implied: Vec::new(),
            };
            let label = format!("{}: centre of mass outside its hollow", space.names[link]);
            Form::new(label, "m", self.radius, body)
        };
        Ok(self.links.indices(robot)?.into_iter().map(form).collect())
    }
}

/// `|mc / m - center| - radius`, without a centre of mass below 1 mg.
#[derive(Debug)]
struct Outside {
    /// Index of the link's mass; the first moments follow.
    first: usize,
    center: [f64; 3],
    radius: f64,
}

impl Outside {
    fn offset(&self, z: &[f64]) -> (f64, [f64; 3], f64) {
        let mass = z[self.first].max(1e-6);
        let offset = std::array::from_fn(|k| z[self.first + 1 + k] / mass - self.center[k]);
        let distance = offset.iter().map(|x: &f64| x * x).sum::<f64>().sqrt();
        (mass, offset, distance)
    }
}

impl General for Outside {
    fn support(&self) -> Vec<usize> {
        (self.first..self.first + 4).collect()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.offset(z).2 - self.radius
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let (mass, offset, distance) = self.offset(z);
        let direction = offset.map(|x| if distance > 0.0 { x / distance } else { 0.0 });
        let by_mass: f64 = (0..3).map(|k| -direction[k] * z[self.first + 1 + k] / (mass * mass)).sum();
        let by_mass = if z[self.first] > 1e-6 { by_mass } else { 0.0 };
        let slopes = std::iter::once(by_mass).chain(direction.map(|d| d / mass));
        (distance - self.radius, slopes.collect())
    }
}
