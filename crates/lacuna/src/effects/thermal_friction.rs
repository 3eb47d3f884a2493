use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{FrictionPart, positive, scale_with};
use super::{Columns, Effect, Joints, Shape, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;
use crate::signals::Run;

/// What tells how warm a joint is.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
pub enum Warmth {
    /// The log's column `temperature1` (or `temperature_<joint>`) of the joint.
    #[default]
    Channel,
    /// The time since the log began: the joint warms up towards its working temperature as
    /// `exp(-t / time_s)`.
    Elapsed {
        /// Time over which it warms up \[s\].
        time_s: f64,
    },
}

/// Friction that depends on the temperature of the joint (Bittencourt and Gunnarsson 2012, linearised).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct ThermalFriction {
    /// Joints it acts on.
    pub joints: Joints,
    /// Which part of friction depends on temperature.
    pub part: FrictionPart,
    /// What tells how warm the joint is.
    pub warmth: Warmth,
    /// Temperature at which the other friction terms hold, in the channel's unit.
    pub reference: f64,
    /// Width of the smoothed sign `tanh(dq / width)` [rad/s]; 0 is the hard sign.
    pub width: f64,
}

impl Default for ThermalFriction {
    fn default() -> Self {
        Self {
            joints: Joints::All,
            part: FrictionPart::Both,
            warmth: Warmth::Channel,
            reference: 25.0,
            width: 0.0,
        }
    }
}

impl ThermalFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "thermal_friction",
        title: "friction that falls as the joint warms up",
        text: "Lubricant thins with warmth: viscous friction halves between a cold start and an hour of work. \
               With the column temperature1 (temperature2, ...; or temperature_ and the joint's name) in \
               the log, friction is linear in that temperature. Without, the time since the log began \
               stands in: warmth approaches its final value as exp(-t / time_s), and the parameters are the \
               extra friction at the start.",
        equation: "tau_j = (tv_j dq_j + tc_j sign(dq_j)) (T_j - reference), or exp(-t / time_s) for the bracket",
        parameters: &[
            Parameter::new(
                "tv",
                "N m s/(rad K) or N m s/rad",
                "change of viscous friction per kelvin, or at the start",
            ),
            Parameter::new("tc", "N m/K or N m", "change of Coulomb friction per kelvin, or at the start"),
            Parameter::new(
                "time_s",
                "s",
                "time over which the joint warms up, where there is no temperature",
            ),
        ],
        cause: "lubricant that thins as the joint warms up",
        confused_with: "friction_drift (follows time, not temperature), viscous_friction (when the \
                        temperature hardly changes)",
        separation: Separation::LONG,
        example: r#"{"thermal_friction": (joints: Only(["2"]), warmth: Elapsed(time_s: 20.0))}"#,
        drawn_against: Variable::Time,
        at_rest: AtRest::ChangingStep,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special::NONE,
    };

    /// By temperature, and by time, for every joint.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        let by = |warmth| super::per_joint(robot, |joints| Self { joints, warmth, ..Self::default() });
        by(Warmth::Channel).into_iter().chain(by(Warmth::Elapsed { time_s: 20.0 })).collect()
    }

    fn units(&self) -> ((&'static str, &'static str), (&'static str, &'static str)) {
        match self.warmth {
            Warmth::Channel => (("tv", "N m s/(rad K)"), ("tc", "N m/K")),
            Warmth::Elapsed { .. } => (("tvs", "N m s/rad"), ("tcs", "N m")),
        }
    }
}

/// The temperature of joint `j`, where the run has it.
fn temperature<'a>(robot: &Robot, run: &'a Run, j: usize) -> Option<&'a [f64]> {
    let (number, name) = (j + 1, &robot.joints[j].name);
    [format!("temperature{number}"), format!("temperature_{number}"), format!("temperature_{name}")]
        .iter()
        .find_map(|channel| run.channels.get(channel))
        .map(Vec::as_slice)
}

fn no_temperature(robot: &Robot, run: &Run, j: usize) -> String {
    format!("{} has no column `temperature{}` for {}", run.name, j + 1, robot.joints[j].name)
}

#[typetag::serde(name = "thermal_friction")]
impl Effect for ThermalFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        if let Warmth::Elapsed { time_s } = self.warmth {
            positive("thermal_friction", "time_s", time_s)?;
        }
        let (viscous, coulomb) = self.units();
        self.joints.terms_each(robot, &self.part.named(viscous, coulomb))
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        if self.warmth == Warmth::Channel {
            let mut joints = self.joints.indices(at.robot)?.into_iter();
            if let Some(j) = joints.find(|&j| temperature(at.robot, at.run, j).is_none()) {
                return Err(Error::new(no_temperature(at.robot, at.run, j))
                    .help("log it, or let time stand in: `warmth: Elapsed(time_s: 20.0)`"));
            }
        }
        let parts = self.part.singles();
        self.joints.fill(at, out, parts.len(), |part, joint, slot| {
            parts[part].fill(at, joint, self.width, slot);
            match (self.warmth, temperature(at.robot, at.run, joint)) {
                (Warmth::Channel, None) => {}
                (Warmth::Channel, Some(t)) => {
                    scale_with(slot, &t[at.range.clone()], |t| t - self.reference);
                }
                (Warmth::Elapsed { time_s }, _) => {
                    slot.iter_mut().zip(at.elapsed()).for_each(|(y, t)| *y *= libm::exp(-t / time_s));
                }
            }
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let Warmth::Elapsed { time_s: value } = self.warmth else { return Vec::new() };
        let trials = vec![5.0, 10.0, 20.0, 60.0];
        vec![Shape { symbol: "time_s", unit: "s", value, low: 1.0, high: 3600.0, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        let warmth = match (self.warmth, values) {
            (Warmth::Elapsed { .. }, [time_s]) => Warmth::Elapsed { time_s: *time_s },
            (warmth, _) => warmth,
        };
        Box::new(Self { warmth, ..self.clone() })
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }

    fn undecidable(&self, robot: &Robot, runs: &[Run]) -> Option<String> {
        if self.warmth != Warmth::Channel {
            return None;
        }
        for j in self.joints.indices(robot).ok()? {
            let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
            for run in runs {
                let Some(t) = temperature(robot, run, j) else { return Some(no_temperature(robot, run, j)) };
                (low, high) = t.iter().fold((low, high), |(low, high), &t| (low.min(t), high.max(t)));
            }
            if !(high - low >= 1.0) {
                return Some(format!("the temperature of {} changes by less than 1 K", robot.joints[j].name));
            }
        }
        None
    }
}
