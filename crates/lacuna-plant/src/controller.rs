//! Joint controllers that follow a motion well, but not perfectly.

use serde::{Deserialize, Serialize};

use super::per_joint::PerJoint;
use super::survey::Survey;
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{Hertz, NotNegative, Positive};

/// Independent joint control with gravity compensation:
/// `tau = g(q) + H ddq_d + D (dq_d - dq) + K (q_d - q)`.
///
/// `H` is each joint's mean inertia along the motion. Unless given, `K` is the larger of `H w²` (with the
/// bandwidth `w`) and what holds the joint's friction within `friction_error`; `D = 2 z sqrt(K H)`. The
/// controller knows the plant's masses but not its friction, and acts in continuous time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Controller {
    /// Bandwidth `w / 2 pi` of the position loops \[Hz\].
    #[serde(deserialize_with = "Hertz::read")]
    pub bandwidth_hz: f64,
    /// Damping ratio `z` of the position loops.
    #[serde(deserialize_with = "Positive::read")]
    pub damping_ratio: f64,
    /// Largest tracking error that friction may cause [rad, m].
    #[serde(deserialize_with = "Positive::read")]
    pub friction_error: f64,
    /// Gains to use instead of the ones described above.
    pub gains: Option<Gains>,
    /// Largest torque of each joint's drive [N m, N]; no limit when absent.
    #[serde(deserialize_with = "NotNegative::read")]
    pub torque_limits: Option<PerJoint>,
}

/// Feedback gains of every joint.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Gains {
    /// Torque per position error [N m/rad, N/m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub stiffness: PerJoint,
    /// Torque per velocity error [N m s/rad, N s/m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub damping: PerJoint,
}

impl Default for Controller {
    fn default() -> Self {
        Self { bandwidth_hz: 5.0, damping_ratio: 0.8, friction_error: 5e-3, gains: None, torque_limits: None }
    }
}

impl Controller {
    /// Refuses settings that do not fit a robot of `dof` joints.
    ///
    /// # Errors
    /// When a setting is not positive, not finite, or has the wrong length.
    pub fn check(&self, dof: usize) -> Result<()> {
        for (name, value) in [
            ("bandwidth_hz", self.bandwidth_hz),
            ("damping_ratio", self.damping_ratio),
            ("friction_error", self.friction_error),
        ] {
            if !(value.is_finite() && value > 0.0) {
                let what = format!("`{name}` of the controller is {value}");
                return Err(Error::new(what).help("give a positive number"));
            }
        }
        if let Some(gains) = &self.gains {
            gains.stiffness.check_not_negative("the controller's stiffness", dof)?;
            gains.damping.check_not_negative("the controller's damping", dof)?;
        }
        match &self.torque_limits {
            Some(limits) => limits.check_not_negative("the controller's torque limits", dof),
            None => Ok(()),
        }
    }

    /// The controller with numbers for the motion that was surveyed.
    pub(super) fn tune(&self, survey: &Survey) -> Tuned {
        let w = std::f64::consts::TAU * self.bandwidth_hz;
        let joints = survey.inertia.iter().zip(&survey.friction).enumerate();
        let tuned = joints.map(|(j, (&inertia, friction))| {
            let stiffness = (inertia * w * w).max(friction / self.friction_error);
            let own = (stiffness, 2.0 * self.damping_ratio * (stiffness * inertia).sqrt());
            let (stiffness, damping) =
                self.gains.as_ref().map_or(own, |gains| (gains.stiffness.of(j), gains.damping.of(j)));
            let limit = self.torque_limits.as_ref().map_or(f64::INFINITY, |limits| limits.of(j));
            Loop { inertia, stiffness, damping, limit }
        });
        Tuned { loops: tuned.collect() }
    }
}

/// Numbers of one joint's loop.
#[derive(Debug, Clone, Copy)]
pub(super) struct Loop {
    inertia: f64,
    pub(super) stiffness: f64,
    pub(super) damping: f64,
    limit: f64,
}

/// A controller ready to run.
#[derive(Debug, Clone)]
pub(super) struct Tuned {
    pub(super) loops: Vec<Loop>,
}

/// What the controller is asked to follow at one instant.
#[derive(Debug, Clone)]
pub(super) struct Reference {
    pub(super) q: Vec<f64>,
    pub(super) dq: Vec<f64>,
    pub(super) ddq: Vec<f64>,
}

impl Reference {
    pub(super) fn new(dof: usize) -> Self {
        Self { q: vec![0.0; dof], dq: vec![0.0; dof], ddq: vec![0.0; dof] }
    }
}

impl Tuned {
    /// Turns the gravity torques in `tau` into what the drives apply.
    pub(super) fn add_tracking(&self, wanted: &Reference, q: &[f64], dq: &[f64], tau: &mut [f64]) {
        for (j, (control, tau)) in self.loops.iter().zip(tau).enumerate() {
            let feedback =
                control.stiffness * (wanted.q[j] - q[j]) + control.damping * (wanted.dq[j] - dq[j]);
            let all = *tau + control.inertia * wanted.ddq[j] + feedback;
            *tau = all.clamp(-control.limit, control.limit);
        }
    }
}
