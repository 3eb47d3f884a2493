use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::check_finite;
use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, phase};
use lacuna_base::error::Result;
use lacuna_base::robot::InertialParameters;

/// A base that does not stand as the robot file says: gravity gets components along the base's x and y,
/// as parts of its size, and keeps its size. The controller does not know.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct BaseTilt {
    /// Gravity along x over its size \[rad\].
    #[serde(default)]
    pub x: f64,
    /// Gravity along y over its size \[rad\].
    #[serde(default)]
    pub y: f64,
}

impl BaseTilt {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "base_tilt",
        example: "(x: 0.005, y: -0.003)",
        scope: Scope::Robot,
        unit: 0.01,
        limit: 0.2,
        not_on: &[],
        make: |_, s, draw| {
            let (y, x) = libm::sincos(phase(draw));
            boxed(BaseTilt { x: s * x, y: s * y })
        },
    };
}

#[typetag::serde(name = "base_tilt")]
impl PlantEffect for BaseTilt {
    fn check(&self, _dof: usize) -> Result<()> {
        check_finite("the base tilt", &[self.x, self.y])
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn change_robot(&self, gravity: &mut Vector3<f64>, _links: &mut [InertialParameters]) {
        let size = gravity.norm();
        let tilted = *gravity + Vector3::new(self.x, self.y, 0.0) * size;
        // Scaled back; a robot without gravity stays without.
        let length = tilted.norm();
        if length > 0.0 {
            *gravity = tilted * (size / length);
        }
    }
}
