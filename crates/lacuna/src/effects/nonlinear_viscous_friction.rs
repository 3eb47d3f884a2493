use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{fill_with, sign};
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// Friction that grows faster or slower than in proportion to speed.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct NonlinearViscousFriction {
    /// Joints it acts on.
    pub joints: Joints,
    /// Power of the speed: 2 for `dq |dq|`, 3 for `dq^3`.
    pub exponent: f64,
    /// Width of the smoothed sign in `|dq| = dq tanh(dq / width)` [rad/s]; 0 is the exact size. Odd whole
    /// exponents need none.
    pub width: f64,
}

impl Default for NonlinearViscousFriction {
    fn default() -> Self {
        Self { joints: Joints::All, exponent: 2.0, width: 0.0 }
    }
}

impl NonlinearViscousFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "nonlinear_viscous_friction",
        title: "friction that bends away from a straight line at high speed",
        text: "Churning oil and air resist with the square of speed, and grease thins as it is sheared, which \
               bends the curve down (a negative coefficient). Shows at high speed only. Square and cube are \
               alike over the speeds of one log (correlation .99 beside a viscous term): which of the two is \
               a matter of taste, that there is curvature is not.",
        equation: "tau_j = f2_j dq_j |dq_j|^(exponent - 1)",
        parameters: &[Parameter::new("f2", "N m (s/rad)^exponent", "coefficient of the power of speed")
            .odd_below(
                0.0,
                "friction that bends down with speed: grease that thins, or a wide Stribeck curve",
            )],
        cause: "oil that is churned, air, or grease that thins as it is sheared",
        confused_with: "sigmoid_friction (bends at low speed), asymmetric_friction (when the joint moves \
                        mostly one way)",
        separation: Separation::SPEEDS,
        example: r#"{"nonlinear_viscous_friction": (joints: Only(["2"]), exponent: 2.0)}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special { exports: Exports { c: "as it is", ..Exports::NOWHERE }, ..Special::NONE },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        let with = |exponent| super::per_joint(robot, |joints| Self { joints, exponent, width: 0.0 });
        with(2.0).into_iter().chain(with(3.0)).collect()
    }
}

#[typetag::serde(name = "nonlinear_viscous_friction")]
impl Effect for NonlinearViscousFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        if !(1.0..=6.0).contains(&self.exponent) {
            let what = format!("`exponent` of nonlinear_viscous_friction is {}", self.exponent);
            return Err(Error::new(what).help("give a number from 1 to 6; 2 and 3 are usual"));
        }
        self.joints.terms(robot, &format!("f{}_", self.exponent), "N m (s/rad)^exponent")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let cubic = (self.exponent - 3.0).abs() < 1e-12;
        let curve = |v: f64| {
            let size = v * sign(v, self.width);
            if cubic { v * v * v } else { v * libm::pow(size, self.exponent - 1.0) }
        };
        self.joints.fill(at, out, 1, |_, joint, slot| fill_with(slot, at.friction_dq(joint), curve))
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }
}
