use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{DRIVES_MOTION, positive, sign};
use super::{Columns, Effect, Joints, Shape, Stretch, StribeckFriction, Term};
use crate::error::Result;
use crate::robot::Robot;

/// Friction that builds up over a short way after each reversal (Dahl 1968).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PreslidingHysteresis {
    /// Joints it acts on.
    #[serde(default)]
    pub joints: Joints,
    /// Reciprocal of the way over which the friction turns round [1/rad].
    pub s: f64,
    /// Width of the smoothed sign that it takes the place of [rad/s]; 0 is the hard sign.
    #[serde(default)]
    pub width: f64,
}

/// Bristles stiffer than this say no more than that the friction turns round at once [1/rad]; measured arms have 300 to
/// 1100.
const STIFFEST: f64 = 1400.0;
const A_SIGN: &str = "that is a sign, or stiction";

/// What else turns round near rest depends on the speed there, not on the way.
const BESIDE_STRIBECK: &[(&str, &str)] = &[(
    StribeckFriction::ABOUT.name,
    "small reversals of 5 to 50 mrad, each position approached from both sides",
)];

/// Factors e^-40 of an old state are forgotten.
const FORGOTTEN: f64 = 40.0;

impl PreslidingHysteresis {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "presliding_hysteresis",
        title: "friction that turns round over a short way instead of at once",
        text: "Bristles of the surfaces, seals and the teeth of a strain-wave gear bend before they slide: \
               after a reversal the friction follows the way travelled, not the velocity, and runs from one \
               side to the other within a few thousandths of a radian. The residual of a Coulomb model shows \
               a short spike at every reversal, also a slow one. The parameter is the part of the Coulomb \
               level that behaves so; the effect is the difference to the sign that Coulomb friction uses.",
        equation: "tau_j = fh_j (z - sign(dq_j)), dz/dq = s (1 - z sign(dq))",
        parameters: &[
            Parameter::new("fh", "N m", "Coulomb friction that is hysteretic").at_least(0.0, DRIVES_MOTION),
            Parameter::new("s", "1/rad", "reciprocal of the way over which it turns round")
                .at_most(STIFFEST, A_SIGN),
        ],
        cause: "bristles of the surfaces, seals, and the teeth of a strain-wave gear, which bend before they slide",
        confused_with: "stribeck_friction and the smoothing of the sign (depend on speed: slow reversals \
                        separate them), backlash (acts where the load changes sign, not the motion)",
        separation: Separation { beside: BESIDE_STRIBECK, ..Separation::OTHER },
        example: r#"{"presliding_hysteresis": (joints: Only(["2"]), s: 150.0)}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Step,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special {
            exports: Exports { c: "with a state of its own", ..Exports::NOWHERE },
            ..Special::NONE
        },
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        super::per_joint(robot, |joints| Self { joints, s: 150.0, width: 0.0 })
    }

    /// State over the samples of the stretch. It looks back until what was before is forgotten, so it does
    /// not depend on how a run is cut; a run begins as if its first velocity had lasted.
    fn state(&self, at: &Stretch<'_>, joint: usize, slot: &mut [f64]) {
        let (v, dt) = (at.run.friction_dq(joint), at.run.dt);
        let mut first = at.range.start;
        let mut travel = 0.0;
        while first > 0 && self.s * travel <= FORGOTTEN {
            let [a, b] = ways(v[first - 1], v[first], dt);
            travel += a.abs() + b.abs();
            first -= 1;
        }
        let Some(&start) = v.get(first) else { return };
        let mut bristles = Bristles { at_reversal: sign(start, self.width), forwards: start > 0.0, way: 0.0 };
        for k in first..at.range.end {
            if k > first {
                ways(v[k - 1], v[k], dt).into_iter().for_each(|way| bristles.travel(way, self.s));
            }
            if k >= at.range.start {
                slot[k - at.range.start] = bristles.bent(self.s);
            }
        }
    }
}

/// Signed ways between two samples with velocity linear in time: one, or one before and one after a reversal.
fn ways(v0: f64, v1: f64, dt: f64) -> [f64; 2] {
    if v0 * v1 < 0.0 {
        let turn = v0 / (v0 - v1);
        [0.5 * dt * v0 * turn, 0.5 * dt * v1 * (1.0 - turn)]
    } else {
        [0.5 * dt * (v0 + v1), 0.0]
    }
}

/// Dahl's state: where it stood at the last reversal, and the way since.
struct Bristles {
    at_reversal: f64,
    forwards: bool,
    way: f64,
}

impl Bristles {
    fn travel(&mut self, way: f64, s: f64) {
        let forwards = way > 0.0;
        if forwards != self.forwards && way.abs() > 0.0 {
            (self.at_reversal, self.forwards, self.way) = (self.bent(s), forwards, 0.0);
        }
        self.way += way.abs();
    }

    /// The exact solution of Dahl's equation since the last reversal.
    fn bent(&self, s: f64) -> f64 {
        let goal = if self.forwards { 1.0 } else { -1.0 };
        goal + (self.at_reversal - goal) * libm::exp(-s * self.way)
    }
}

#[typetag::serde(name = "presliding_hysteresis")]
impl Effect for PreslidingHysteresis {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        positive("presliding_hysteresis", "s", self.s)?;
        self.joints.terms(robot, "fh", "N m")
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        self.joints.fill(at, out, 1, |_, joint, slot| {
            self.state(at, joint, slot);
            slot.iter_mut().zip(at.friction_dq(joint)).for_each(|(z, &v)| *z -= sign(v, self.width));
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let trials = vec![15.0, 50.0, 150.0, 450.0, 1000.0];
        vec![Shape { symbol: "s", unit: "1/rad", value: self.s, low: 15.0, high: 1500.0, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { s: values.first().copied().unwrap_or(self.s), ..self.clone() })
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }

    fn implausible(&self, robot: &Robot, values: &[f64]) -> Option<String> {
        let beyond = Self::ABOUT.impossible(&self.terms(robot).ok()?, &self.shapes(), values)?;
        let at_once = format!("it turns round within {:.2} mrad: {beyond}", 1e3 / self.s);
        Some(if beyond == A_SIGN { at_once } else { beyond.to_string() })
    }
}
