use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::twin::{Scope, Twin, boxed};
use super::{check_finite, check_positive, joint_index};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{JointNumber, Seconds};

/// Something pushes against a link for a while, with a constant force on the robot in the base frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactForce {
    /// Force on the robot, base frame \[N\].
    pub force: [f64; 3],
    /// When it begins \[s\].
    pub from_s: f64,
    /// When it has ended \[s\].
    pub to_s: f64,
    /// Time in which it comes and goes \[s\].
    #[serde(default = "ContactForce::quick", deserialize_with = "Seconds::read")]
    pub rise_s: f64,
    /// Where it acts, in the link's frame \[m\].
    #[serde(default)]
    pub point: [f64; 3],
    /// Number of the joint whose link it acts on, from 1; the last one when not given.
    #[serde(default, deserialize_with = "JointNumber::read")]
    pub link: Option<usize>,
}

impl ContactForce {
    fn quick() -> f64 {
        0.02
    }

    /// How much of the force acts at time `t`: from 0 to 1 along a cubic, and back.
    fn part(&self, t: f64) -> f64 {
        let s = ((t - self.from_s).min(self.to_s - t) / self.rise_s).clamp(0.0, 1.0);
        s * s * (3.0 - 2.0 * s)
    }
}

impl ContactForce {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "contact_force",
        example: "(force: (3, -2, 5), from_s: 1, to_s: 2, point: (0.0, 0.1, 0.2))",
        scope: Scope::Event,
        unit: 2.0,
        limit: 200.0,
        not_on: &[],
        make: |_, s, draw| {
            let direction = [draw.normal(), draw.normal(), draw.normal()];
            let length = direction.iter().map(|x| x * x).sum::<f64>().sqrt();
            let from_s = draw.between(2.0, 10.0);
            let to_s = from_s + draw.between(1.0, 2.3);
            let (force, point) = (direction.map(|x| s * x / length), [0.0; 3]);
            boxed(ContactForce { force, from_s, to_s, rise_s: 0.02, point, link: None })
        },
    };
}

#[typetag::serde(name = "contact_force")]
impl PlantEffect for ContactForce {
    fn interval(&self) -> Option<(f64, f64)> {
        Some((self.from_s, self.to_s))
    }

    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the rise time of the contact force", self.rise_s)?;
        check_finite("the contact force", &self.force)?;
        check_finite("the contact force", &self.point)?;
        joint_index("the contact force", self.link.unwrap_or(dof), dof)?;
        if self.from_s.is_finite() && self.to_s.is_finite() && self.from_s < self.to_s {
            return Ok(());
        }
        Err(Error::new(format!("a contact from {} s to {} s", self.from_s, self.to_s))
            .help("`from_s` must lie before `to_s`"))
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        let part = self.part(now.t);
        if part > 0.0 {
            let link = self.link.unwrap_or(load.len()) - 1;
            // What pushes the robot along spares its drives the same.
            let force = -part * Vector3::from(self.force);
            now.arm.add_push(now.q, link, &self.point.into(), &force, load);
        }
    }
}
