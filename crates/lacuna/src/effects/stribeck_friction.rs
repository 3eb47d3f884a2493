use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{fill_with, positive, sign};
use super::{Columns, Effect, Joints, Shape, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;
use crate::signals::Run;

/// More friction near rest than at speed (Stribeck 1902; the Gaussian form of Armstrong-Hélouvry 1991).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StribeckFriction {
    /// Joints it acts on.
    #[serde(default)]
    pub joints: Joints,
    /// Speed at which the extra friction has fallen to 37 % [rad/s].
    pub vs: f64,
    /// Width of the smoothed sign `tanh(dq / width)` [rad/s]; 0 is the hard sign.
    #[serde(default)]
    pub width: f64,
}

impl StribeckFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "stribeck_friction",
        title: "more friction near rest than at speed",
        text: "While surfaces touch, friction is high; a film of lubricant builds up with speed and friction \
               falls. Shows as two peaks beside zero velocity. It needs motion below vs and well above it. A \
               narrow one is easily faked by a sign that was smoothed more or less than the friction is, so \
               vs below twice the width of the sign is not believed.",
        equation: "tau_j = fs_j sign(dq_j) exp(-(dq_j / vs)^2)",
        parameters: &[
            Parameter::new("fs", "N m", "friction at breakaway above the Coulomb level")
                .at_least(f64::MIN_POSITIVE, "friction that falls towards rest is not Stribeck's"),
            Parameter::new("vs", "rad/s", "speed over which it fades"),
        ],
        cause: "surfaces that touch until speed has built up a film of lubricant",
        confused_with: "coulomb_friction (when all motion is slow), presliding_hysteresis (depends on the \
                        way since the last reversal, not on speed), sigmoid_friction",
        separation: Separation::new(
            Asks::SlowReversals,
            "a wider range of speeds, with slow reversals well below the Stribeck speed",
        ),
        example: r#"{"stribeck_friction": (joints: Only(["2"]), vs: 0.12)}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Step,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special { exports: Exports { c: "as it is", ..Exports::NOWHERE }, ..Special::NONE },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, vs: 0.12, width: 0.0 })
    }

    /// Shares of samples of `joint` below `vs` and above twice that.
    fn shares(&self, joint: usize, runs: &[Run]) -> (f64, f64) {
        let (mut slow, mut fast, mut all) = (0_usize, 0_usize, 0_usize);
        for v in runs.iter().flat_map(|run| run.friction_dq(joint)) {
            slow += usize::from(v.abs() < self.vs);
            fast += usize::from(v.abs() > 2.0 * self.vs);
            all += 1;
        }
        (slow as f64 / all.max(1) as f64, fast as f64 / all.max(1) as f64)
    }
}

#[typetag::serde(name = "stribeck_friction")]
impl Effect for StribeckFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        positive("stribeck_friction", "vs", self.vs)?;
        self.joints.terms(robot, "fs", "N m")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let curve = |v: f64| sign(v, self.width) * libm::exp(-(v / self.vs) * (v / self.vs));
        self.joints.fill(at, out, 1, |_, joint, slot| fill_with(slot, at.friction_dq(joint), curve))
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let trials = vec![0.03, 0.06, 0.12, 0.25, 0.5];
        vec![Shape { symbol: "vs", unit: "rad/s", value: self.vs, low: 0.005, high: 1.5, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { vs: values.first().copied().unwrap_or(self.vs), ..self.clone() })
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }

    fn implausible(&self, robot: &Robot, values: &[f64]) -> Option<String> {
        let within_the_sign = || {
            format!(
                "vs = {:.3} rad/s is within the smoothing of the sign (width {:.3} rad/s)",
                self.vs, self.width
            )
        };
        let narrow = self.vs < 2.0 * self.width;
        let bound = Self::ABOUT.impossible(&self.terms(robot).ok()?, &self.shapes(), values);
        bound.map(str::to_string).or_else(|| narrow.then(within_the_sign))
    }

    fn undecidable(&self, robot: &Robot, runs: &[Run]) -> Option<String> {
        let joints = self.joints.indices(robot).ok()?;
        joints.into_iter().find_map(|j| {
            let (slow, fast) = self.shares(j, runs);
            let (name, vs) = (&robot.joints[j].name, self.vs);
            if slow <= 0.02 {
                Some(format!("{name} is slower than {vs:.3} rad/s in only {:.1} % of the data", 100.0 * slow))
            } else if fast <= 0.25 {
                let twice = 2.0 * vs;
                Some(format!(
                    "{name} is faster than {twice:.3} rad/s in only {:.0} % of the data",
                    100.0 * fast
                ))
            } else {
                None
            }
        })
    }
}
