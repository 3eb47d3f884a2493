use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{fill_with, positive, scale_with, sign};
use super::torque_ripple::describe_waves;
use super::{Columns, Described, Effect, Joints, Own, Shape, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Coulomb friction whose level goes up and down along the way.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PositionDependentFriction {
    /// Joints it acts on.
    #[serde(default)]
    pub joints: Joints,
    /// Waves per turn.
    pub k: f64,
    /// Width of the smoothed sign `tanh(dq / width)` [rad/s]; 0 is the hard sign.
    #[serde(default)]
    pub width: f64,
}

impl PositionDependentFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "position_dependent_friction",
        title: "Coulomb friction that varies along the way",
        text: "An eccentric bearing, a bent shaft, a cable that is dragged along: the joint rubs more in some \
               places. The residual is a wave over position that turns over with the direction of motion.",
        equation: "tau_j = sign(dq_j) (ps_j sin(k q_j) + pc_j cos(k q_j))",
        parameters: &[
            Parameter::new("ps, pc", "N m", "amplitudes of sine and cosine; told as amplitude and phase"),
            Parameter::new("k", "1/rad", "waves per turn"),
        ],
        cause: "an eccentric bearing, a bent shaft, a cable that is dragged along",
        confused_with: "torque_ripple (does not turn over with the direction), load_dependent_friction \
                        (gravity load is a wave over position too, with k = 1)",
        separation: Separation::TWICE,
        example: r#"{"position_dependent_friction": (joints: Only(["2"]), k: 1.0)}"#,
        drawn_against: Variable::Position,
        at_rest: AtRest::ChangingStep,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special {
            wave: Some(Own::Sign),
            exports: Exports { c: "as it is", ..Exports::NOWHERE },
            ..Special::NONE
        },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, k: 1.0, width: 0.0 })
    }
}

#[typetag::serde(name = "position_dependent_friction")]
impl Effect for PositionDependentFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        positive("position_dependent_friction", "k", self.k)?;
        self.joints.terms_each(robot, &[("ps", "N m"), ("pc", "N m")])
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 2, |part, joint, slot| {
            let wave = if part == 0 { libm::sin } else { libm::cos };
            fill_with(slot, at.friction_dq(joint), |v| sign(v, self.width));
            scale_with(slot, at.q(joint), |q| wave(self.k * q));
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let trials = (2..=16).map(|k| 0.5 * f64::from(k)).collect();
        vec![Shape { symbol: "k", unit: "1/rad", value: self.k, low: 0.5, high: 8.5, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { k: values.first().copied().unwrap_or(self.k), ..self.clone() })
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }

    fn describe(&self, robot: &Robot, values: &[f64], covariance: &DMatrix<f64>) -> Result<Vec<Described>> {
        describe_waves(&self.joints.indices(robot)?, self.k, values, covariance)
    }
}
