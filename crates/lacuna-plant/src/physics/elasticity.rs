//! What yields between the motor, where the position is measured, and the link that moves.
//!
//! Both are quasi-static: the link's motion is simulated and the motor's follows from the torque that passes
//! through the joint. The rotor's own acceleration against the link is left out, so results hold well below
//! the resonance of rotor and link (for a Panda's joints, far below 10 Hz), where logs are filtered anyway.

use serde::{Deserialize, Serialize};

use super::effect::{Moment, Observed, PlantEffect};
use super::twin::{Scope, Twin, boxed, only};
use super::{PerJoint, check_positive};
use lacuna_base::error::Result;
use lacuna_base::text::bounds::{NotNegative, Positive};

/// A gear that twists: the motor stands ahead of the link by `compliance` times the transmitted torque.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct JointElasticity {
    /// Twist per torque [rad/(N m), m/N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub compliance: PerJoint,
}

impl JointElasticity {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "joint_elasticity",
        example: "(compliance: [0.0001])",
        scope: Scope::Joint,
        unit: 1e-3,
        limit: 0.05,
        not_on: &[],
        make: |j, s, _| boxed(JointElasticity { compliance: only(j, s) }),
    };
}

#[typetag::serde(name = "joint_elasticity")]
impl PlantEffect for JointElasticity {
    fn check(&self, dof: usize) -> Result<()> {
        self.compliance.check_not_negative("the compliance of joints", dof)
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn observe(&self, seen: &mut Observed) {
        for j in 0..seen.q.len() {
            let compliance = self.compliance.of(j);
            lead(seen, j, |torque| compliance * torque);
        }
    }
}

/// Play between teeth: the motor stands half a gap ahead of the link on the side that carries the torque,
/// and crosses the gap while the torque is small: `gap / 2 tanh(transmitted / closing_torque)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Backlash {
    /// Width of the gap [rad, m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub gaps: PerJoint,
    /// Torque that presses the teeth together [N m, N].
    #[serde(default = "Backlash::light", deserialize_with = "Positive::read")]
    pub closing_torque: f64,
}

impl Backlash {
    fn light() -> f64 {
        0.2
    }
}

impl Backlash {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "backlash",
        example: "(gaps: [0.002])",
        scope: Scope::Joint,
        unit: 4e-3,
        limit: 0.05,
        not_on: &[],
        make: |j, s, _| boxed(Backlash { gaps: only(j, s), closing_torque: 0.2 }),
    };
}

#[typetag::serde(name = "backlash")]
impl PlantEffect for Backlash {
    fn check(&self, dof: usize) -> Result<()> {
        check_positive("the closing torque of backlash", self.closing_torque)?;
        self.gaps.check_not_negative("the gap of backlash", dof)
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn observe(&self, seen: &mut Observed) {
        for j in 0..seen.q.len() {
            let half = 0.5 * self.gaps.of(j);
            lead(seen, j, |torque| half * libm::tanh(torque / self.closing_torque));
        }
    }
}

/// Moves what is seen of joint `j` ahead by `twist` of the transmitted torque.
fn lead(seen: &mut Observed, j: usize, twist: impl Fn(f64) -> f64) {
    let lead: Vec<f64> = seen.transmitted[j].iter().map(|&torque| twist(torque)).collect();
    if lead.iter().all(|x| x.abs() <= 0.0) {
        return;
    }
    let last = lead.len() - 1;
    for k in 0..lead.len() {
        let (before, after) = (k.saturating_sub(1), (k + 1).min(last));
        if after > before {
            seen.dq[j][k] += (lead[after] - lead[before]) / ((after - before) as f64 * seen.dt);
        }
        seen.q[j][k] += lead[k];
    }
}
