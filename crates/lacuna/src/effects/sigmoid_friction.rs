use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::DRIVES_MOTION;
use super::{Columns, Effect, Joints, Shape, Stretch, Term};
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
            Parameter::new("phi1", "N m", "amplitude, from far negative to far positive speed")
                .at_least(0.0, DRIVES_MOTION),
            Parameter::new("phi2", "s/rad", "steepness"),
            Parameter::new("phi3", "rad/s", "velocity shift"),
        ],
        cause: "surfaces that slide with lubricant between them, seen through a filter",
        confused_with: "coulomb_friction (large phi2), viscous_friction (small phi2), torque_offset (phi3)",
        separation: Separation::SPEEDS,
        example: r#"{"sigmoid_friction": (joints: Only(["2"]), phi2: [10.0], phi3: [0.0])}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special { exports: Exports { c: "as it is", ..Exports::NOWHERE }, ..Special::NONE },
    };

    /// What a diagnosis tries: every joint for itself.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, phi2: vec![10.0], phi3: vec![0.0] })
    }

    fn per_joint(&self, robot: &Robot) -> Result<Vec<(usize, SigmoidParameters)>> {
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
        self.per_joint(robot)?;
        self.joints.terms(robot, "phi1_", "N m")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        for (term, (joint, shape)) in self.per_joint(at.robot)?.into_iter().enumerate() {
            out.column(term, joint, |slot| {
                for (y, &v) in slot.iter_mut().zip(at.friction_dq(joint)) {
                    *y = shape.shape(v);
                }
            });
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    /// Free while the effect acts on one joint.
    fn shapes(&self) -> Vec<Shape> {
        let ([phi2], [phi3]) = (self.phi2.as_slice(), self.phi3.as_slice()) else { return Vec::new() };
        vec![
            Shape {
                symbol: "phi2",
                unit: "s/rad",
                value: *phi2,
                low: 0.5,
                high: 500.0,
                trials: vec![3.0, 8.0, 20.0, 50.0],
            },
            Shape {
                symbol: "phi3",
                unit: "rad/s",
                value: *phi3,
                low: -0.3,
                high: 0.3,
                trials: vec![-0.05, -0.015, 0.015, 0.05],
            },
        ]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        let mut other = self.clone();
        if let [phi2, phi3] = values {
            (other.phi2, other.phi3) = (vec![*phi2], vec![*phi3]);
        }
        Box::new(other)
    }
}
