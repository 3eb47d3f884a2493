use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::{FrictionPart, positive};
use super::{Columns, Effect, Joints, Shape, Stretch, Term};
use crate::error::Result;
use crate::robot::Robot;

/// How friction changes with time.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub enum Course {
    /// In proportion to time.
    Linear,
    /// As `exp(-t / time_s)`: much at first, then settled.
    Settling {
        /// Time over which it settles \[s\].
        time_s: f64,
    },
}

/// Friction that changes in the course of a log.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FrictionDrift {
    /// Joints it acts on.
    #[serde(default)]
    pub joints: Joints,
    /// Which part of friction changes.
    #[serde(default)]
    pub part: FrictionPart,
    /// How it changes.
    pub course: Course,
    /// Width of the smoothed sign `tanh(dq / width)` [rad/s]; 0 is the hard sign.
    #[serde(default)]
    pub width: f64,
}

impl FrictionDrift {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "friction_drift",
        title: "friction that changes while the log runs",
        text: "Grease that warms up or spreads after a rest: friction is higher at first and settles, or it \
               creeps. The residual is that of friction, with a size that changes over time. Time counts \
               from the start of each log. Where temperatures were logged, thermal_friction explains more.",
        equation: "tau_j = (dc_j sign(dq_j) + dv_j dq_j) t, or exp(-t / time_s) in place of t",
        parameters: &[
            Parameter::new("dc", "N m/s or N m", "change of Coulomb friction per second, or at the start"),
            Parameter::new(
                "dv",
                "N m/rad or N m s/rad",
                "change of viscous friction per second, or at the start",
            ),
            Parameter::new("time_s", "s", "time over which it settles"),
        ],
        cause: "grease that warms up or spreads after a rest",
        confused_with: "thermal_friction (the same without a temperature), torque_drift (does not turn over \
                        with the direction), load_dependent_friction when the load changes slowly",
        separation: Separation::LONG,
        example: r#"{"friction_drift": (joints: Only(["2"]), course: Settling(time_s: 10.0))}"#,
        drawn_against: Variable::Time,
        at_rest: AtRest::ChangingStep,
        reach: Reach::Joint,
        stage: Stage::Usual,
        imitated_by: &[Imitation::CourseOfTime],
        special: Special::NONE,
    };

    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        let mut all = Vec::new();
        for part in [FrictionPart::Coulomb, FrictionPart::Viscous] {
            for course in [Course::Linear, Course::Settling { time_s: 10.0 }] {
                all.extend(super::per_joint(robot, |joints| Self { joints, part, course, width: 0.0 }));
            }
        }
        all
    }

    fn named(&self) -> ((&'static str, &'static str), (&'static str, &'static str)) {
        match self.course {
            Course::Linear => (("dv", "N m/rad"), ("dc", "N m/s")),
            Course::Settling { .. } => (("dvs", "N m s/rad"), ("dcs", "N m")),
        }
    }
}

#[typetag::serde(name = "friction_drift")]
impl Effect for FrictionDrift {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        if let Course::Settling { time_s } = self.course {
            positive("friction_drift", "time_s", time_s)?;
        }
        let (viscous, coulomb) = self.named();
        self.joints.terms_each(robot, &self.part.named(viscous, coulomb))
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let parts = self.part.singles();
        self.joints.fill(at, out, parts.len(), |part, joint, slot| {
            parts[part].fill(at, joint, self.width, slot);
            for (y, t) in slot.iter_mut().zip(at.elapsed()) {
                *y *= match self.course {
                    Course::Linear => t,
                    Course::Settling { time_s } => libm::exp(-t / time_s),
                };
            }
        })
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let Course::Settling { time_s: value } = self.course else { return Vec::new() };
        let trials = vec![5.0, 10.0, 20.0, 60.0];
        vec![Shape { symbol: "time_s", unit: "s", value, low: 1.0, high: 600.0, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        let course = match (self.course, values) {
            (Course::Settling { .. }, [time_s]) => Course::Settling { time_s: *time_s },
            (course, _) => course,
        };
        Box::new(Self { course, ..self.clone() })
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }
}
