use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed};
use super::{check_finite, check_positive, joint_index};
use lacuna_base::error::Result;
use lacuna_base::robot::InertialParameters;
use lacuna_base::text::bounds::{JointNumber, Mass};

/// A body on a link that the robot file does not have. The controller does not know of it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Payload {
    /// Mass \[kg\].
    #[serde(deserialize_with = "Mass::read")]
    pub mass: f64,
    /// Centre of mass in the link's frame \[m\].
    pub com: [f64; 3],
    /// Inertia about the centre of mass `xx, xy, xz, yy, yz, zz` in axes of the link's frame [kg m²].
    #[serde(default)]
    pub inertia: [f64; 6],
    /// Number of the joint whose link carries it, from 1; the last one when not given.
    #[serde(default, deserialize_with = "JointNumber::read")]
    pub link: Option<usize>,
}

impl Payload {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "payload",
        example: "(mass: 1.5, com: (0.02, 0.01, 0.08), inertia: (0.002, 0, 0, 0.003, 0, 0.001))",
        scope: Scope::TwoLogs,
        unit: 0.3,
        limit: 20.0,
        not_on: &[],
        make: |_, s, draw| {
            let mut within = |range: f64| draw.between(-range, range);
            let com = [within(0.03), within(0.03), 0.1 + within(0.04)];
            let inertia = [2e-3 * s, 0.0, 0.0, 2e-3 * s, 0.0, 1e-3 * s];
            boxed(Payload { mass: s, com, inertia, link: None })
        },
    };
}

#[typetag::serde(name = "payload")]
impl PlantEffect for Payload {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the mass of the payload", self.mass)?;
        check_finite("the payload", &self.com)?;
        check_finite("the payload", &self.inertia)?;
        joint_index("the payload", self.link.unwrap_or(dof), dof).map(|_| ())
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn change_robot(&self, _gravity: &mut Vector3<f64>, links: &mut [InertialParameters]) {
        let [xx, xy, xz, yy, yz, zz] = self.inertia;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let body = InertialParameters::from_barycentric(self.mass, self.com.into(), inertia);
        let link = self.link.unwrap_or(links.len()) - 1;
        links[link] = links[link].combined(&body);
    }
}
