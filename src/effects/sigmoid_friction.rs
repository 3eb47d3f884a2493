use serde::{Deserialize, Serialize};

use super::{About, Columns, Effect, Joints, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// Parameters of one joint's sigmoid friction (Gaz et al. 2019, eq. 25).
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SigmoidParameters {
    /// Amplitude: torque from far negative to far positive speed [N m].
    pub phi1: f64,
    /// Steepness [s/rad].
    pub phi2: f64,
    /// Velocity shift [rad/s].
    pub phi3: f64,
}

impl SigmoidParameters {
    /// Friction torque at joint velocity `dq` [rad/s]; exactly 0 at rest.
    pub fn torque(&self, dq: f64) -> f64 {
        self.phi1 * self.shape(dq)
    }

    /// Torque per unit of amplitude.
    pub fn shape(&self, dq: f64) -> f64 {
        logistic(self.phi2 * (dq + self.phi3)) - logistic(self.phi2 * self.phi3)
    }
}

/// `1 / (1 + e^-x)` without overflow.
pub(crate) fn logistic(x: f64) -> f64 {
    if x >= 0.0 {
        1.0 / (1.0 + libm::exp(-x))
    } else {
        let e = libm::exp(x);
        e / (1.0 + e)
    }
}

/// Sigmoid friction with given shape; the amplitude is the linear parameter.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SigmoidFriction {
    /// Joints it acts on.
    #[serde(default)]
    pub joints: Joints,
    /// Steepness of each joint [s/rad].
    pub phi2: Vec<f64>,
    /// Velocity shift of each joint [rad/s].
    pub phi3: Vec<f64>,
}

impl SigmoidFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "sigmoid_friction",
        title: "smooth friction that saturates with speed",
        text: "The paper's friction: no jump at zero speed, constant at high speed, possibly shifted. Its \
               steepness depends on how strongly torque and velocity were filtered. It has no free offset.",
        equation: "tau_j = phi1/(1 + exp(-phi2 (dq_j + phi3))) - phi1/(1 + exp(-phi2 phi3))",
        parameters: &[
            ("phi1", "N m", "amplitude, from far negative to far positive speed"),
            ("phi2", "s/rad", "steepness"),
            ("phi3", "rad/s", "velocity shift"),
        ],
        confused_with: "coulomb_friction (large phi2), viscous_friction (small phi2), torque_offset (phi3)",
    };

    fn shapes(&self, robot: &Robot) -> Result<Vec<(usize, SigmoidParameters)>> {
        let joints = self.joints.indices(robot)?;
        if joints.len() != self.phi2.len() || joints.len() != self.phi3.len() {
            return Err(Error::new(format!(
                "`sigmoid_friction` acts on {} joints but has {} values of phi2 and {} of phi3",
                joints.len(),
                self.phi2.len(),
                self.phi3.len()
            ))
            .help("give one phi2 [s/rad] and one phi3 [rad/s] per joint"));
        }
        if self.phi2.iter().chain(&self.phi3).any(|x| !x.is_finite()) {
            return Err(Error::new("`sigmoid_friction` has a shape that is not finite")
                .help("give finite phi2 [s/rad] and phi3 [rad/s]"));
        }
        let shape = |(k, j): (usize, usize)| {
            (j, SigmoidParameters { phi1: 1.0, phi2: self.phi2[k], phi3: self.phi3[k] })
        };
        Ok(joints.into_iter().enumerate().map(shape).collect())
    }
}

#[typetag::serde(name = "sigmoid_friction")]
impl Effect for SigmoidFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.shapes(robot)?;
        self.joints.terms(robot, "phi1_", "N m")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        for (term, (joint, shape)) in self.shapes(at.robot)?.into_iter().enumerate() {
            out.column(term, joint, |slot| {
                for (y, &v) in slot.iter_mut().zip(at.dq(joint)) {
                    *y = shape.shape(v);
                }
            });
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
