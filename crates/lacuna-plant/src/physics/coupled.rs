use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed, neighbour};
use super::{check_finite, check_positive, joint_index, smooth_sign, usual_width};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{JointNumber, Positive};

/// Friction on one joint that comes from the motion of another, as in wrists with common gears:
/// `viscous dq_from + coulomb tanh(dq_from / width)` on `joint`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoupledFriction {
    /// Number of the joint that carries the load, from 1.
    #[serde(deserialize_with = "JointNumber::read")]
    pub joint: usize,
    /// Number of the joint whose motion makes it, from 1.
    #[serde(deserialize_with = "JointNumber::read")]
    pub from: usize,
    /// Load per velocity of the other joint [N m s/rad].
    #[serde(default)]
    pub viscous: f64,
    /// Dry load in the direction of the other joint's motion [N m, N].
    #[serde(default)]
    pub coulomb: f64,
    /// Velocity at which 76 % of the sign is reached [rad/s, m/s].
    #[serde(default = "usual_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

impl CoupledFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "coupled_friction",
        example: "(joint: 5, from: 4, viscous: 0.3, coulomb: 0.1)",
        scope: Scope::Joint,
        unit: 0.3,
        limit: 20.0,
        not_on: &[],
        make: |j, s, draw| {
            let viscous = draw.uniform() < 0.5;
            boxed(CoupledFriction {
                joint: j + 1,
                from: neighbour(j) + 1,
                viscous: if viscous { s } else { 0.0 },
                coulomb: if viscous { 0.0 } else { s },
                width: 0.005,
            })
        },
    };
}

#[typetag::serde(name = "coupled_friction")]
impl PlantEffect for CoupledFriction {
    fn check(&self, dof: usize) -> Result<()> {
        let (joint, from) = (
            joint_index("coupled friction", self.joint, dof)?,
            joint_index("coupled friction", self.from, dof)?,
        );
        if joint == from {
            return Err(Error::new("coupled friction of a joint with itself")
                .help("use viscous_friction and coulomb_friction for that"));
        }
        check_positive("the width of coupled friction", self.width)?;
        check_finite("coupled friction", &[self.viscous, self.coulomb])
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        let v = now.dq[self.from - 1];
        load[self.joint - 1] += self.viscous * v + self.coulomb * smooth_sign(v, self.width);
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        // It is no damping of its own joint, but what reacts to the other joint is as fast.
        let steepness = self.viscous.abs() + self.coulomb.abs() / self.width;
        slope[self.joint - 1] += steepness;
        slope[self.from - 1] += steepness;
    }
}
