use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{fill_with, positive};
use super::{Columns, Described, Effect, Joints, Own, Shape, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Torque that goes up and down along the way, whatever the direction.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueRipple {
    /// Joints it acts on.
    #[serde(default)]
    pub joints: Joints,
    /// Waves per turn; need not be whole.
    pub k: f64,
}

impl TorqueRipple {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "torque_ripple",
        title: "a wave of torque over the joint angle",
        text: "Cogging of the motor, teeth of the gear, an eccentric sensor ring: the residual is a wave over \
               position, the same in both directions. Waves that are shorter than the way the joint travels \
               can be told from each other when their numbers per turn differ by 2 pi over that way.",
        equation: "tau_j = rs_j sin(k q_j) + rc_j cos(k q_j)",
        parameters: &[
            Parameter::new("rs, rc", "N m", "amplitudes of sine and cosine; told as amplitude and phase"),
            Parameter::new("k", "1/rad", "waves per turn")
                .odd_below(2.0, "a wave this long may stand for gravity or a spring"),
        ],
        cause: "cogging of the motor, teeth of the gear, a sensor ring that is eccentric",
        confused_with: "gravity torque (k = 1), joint_spring (a wave much longer than the way), \
                        position_dependent_friction (turns over with the direction)",
        separation: Separation::TWICE,
        example: r#"{"torque_ripple": (joints: Only(["2"]), k: 12.0)}"#,
        drawn_against: Variable::Position,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special {
            wave: Some(Own::One),
            exports: Exports { c: "as it is", ..Exports::NOWHERE },
            ..Special::NONE
        },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, k: 2.0 })
    }
}

#[typetag::serde(name = "torque_ripple")]
impl Effect for TorqueRipple {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        positive("torque_ripple", "k", self.k)?;
        self.joints.terms_each(robot, &[("rs", "N m"), ("rc", "N m")])
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 2, |part, joint, slot| {
            let wave = if part == 0 { libm::sin } else { libm::cos };
            fill_with(slot, at.q(joint), |q| wave(self.k * q));
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let trials = (4..=24).chain((28..=60).step_by(4)).map(|k| 0.5 * f64::from(k)).collect();
        vec![Shape { symbol: "k", unit: "1/rad", value: self.k, low: 1.5, high: 31.0, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { k: values.first().copied().unwrap_or(self.k), ..self.clone() })
    }

    fn describe(&self, robot: &Robot, values: &[f64], covariance: &DMatrix<f64>) -> Result<Vec<Described>> {
        describe_waves(&self.joints.indices(robot)?, self.k, values, covariance)
    }
}

/// Pairs `a sin + b cos` as `amplitude sin(k q + phase)`, with errors by the delta method.
pub(super) fn describe_waves(
    joints: &[usize],
    k: f64,
    values: &[f64],
    covariance: &DMatrix<f64>,
) -> Result<Vec<Described>> {
    let mut told = Vec::new();
    for (pair, joint) in joints.iter().enumerate() {
        let (s, c) = (2 * pair, 2 * pair + 1);
        let (a, b) = (values[s], values[c]);
        let amplitude = libm::hypot(a, b);
        let (vs, vc, vsc) = (covariance[(s, s)], covariance[(c, c)], covariance[(s, c)]);
        let along = (a * a * vs + b * b * vc + 2.0 * a * b * vsc).sqrt() / amplitude;
        let across = (b * b * vs + a * a * vc - 2.0 * a * b * vsc).sqrt() / (amplitude * amplitude);
        let number = joint + 1;
        let one = |name: &str, value, unit, error: f64| Described {
            name: format!("{name}{number}"),
            value,
            unit,
            standard_error: Some(error).filter(|e| e.is_finite()),
        };
        told.push(one("amplitude", amplitude, "N m", along));
        told.push(one("phase", libm::atan2(b, a), "rad", across));
    }
    told.push(Described { name: "k".to_string(), value: k, unit: "1/rad", standard_error: None });
    Ok(told)
}
