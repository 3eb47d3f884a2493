use nalgebra::DMatrix;
use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Described, Effect, Stretch, Term, find_link};
use crate::error::Result;
use crate::kernels::RegressorBlock;
use crate::robot::{PARAMETER_NAMES, PARAMETER_UNITS, PARAMETERS_PER_LINK, Robot};

/// A body carried by the last link, in the logs that have it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct Payload {
    /// The link that carries it, by name or number; the last one when not given.
    pub link: Option<String>,
    /// Whether its inertia has parameters of its own (10 in all), or it is a point mass of 4 parameters,
    /// whose inertia is left out.
    pub inertia: bool,
}

impl Default for Payload {
    fn default() -> Self {
        Self { link: None, inertia: true }
    }
}

impl Payload {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "payload",
        title: "a body that the last link carries in one log and not in the other",
        text: "Tool, workpiece, cable: ten parameters of a rigid body fixed to the last link. In a single log \
               it cannot be told from that link itself; with a log without it as reference, it is what \
               changed. Mass and centre of mass stand on gravity. They assume that torque is scaled right: an \
               error of the drive gains passes one to one into the mass.",
        equation: "tau = Y_last(q, dq, ddq) (m, m c, J)",
        parameters: &[
            Parameter::new("mass", "kg", "mass").at_least(
                f64::MIN_POSITIVE,
                "a negative mass; if it was taken away, exchange data and reference",
            ),
            Parameter::new("com_x, com_y, com_z", "m", "centre of mass in the link's frame")
                .within(2.0, "a centre of mass more than 2 m away from the link"),
            Parameter::new("Jxx .. Jzz", "kg m^2", "inertia about the link-frame origin"),
        ],
        cause: "a tool, a workpiece or a cable that was picked up between two logs",
        confused_with: "rigid_body of the last link (in one log: the same), torque_gain of several joints, \
                        contact_force (for part of a log)",
        separation: Separation::OTHER,
        example: r#"{"payload": ()}"#,
        drawn_against: Variable::Load,
        at_rest: AtRest::Smooth,
        reach: Reach::Robot,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special {
            caveat: Some(
                "an error of the drives' gain passes straight into the mass: 1 % of gain too much is 1 % of mass too much",
            ),
            exports: Exports {
                mujoco: "a body",
                isaaclab: "a body",
                gazebo: "a link",
                drake: "a link",
                c: "inverse dynamics",
                ..Exports::NOWHERE
            },
            ..Special::NONE
        },
    };

    pub(super) fn candidates(_robot: &Robot) -> Vec<Box<dyn Effect>> {
        vec![Box::new(Self::default())]
    }

    fn count(&self) -> usize {
        if self.inertia { PARAMETERS_PER_LINK } else { 4 }
    }
}

#[typetag::serde(name = "payload")]
impl Effect for Payload {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let mut joints: Vec<usize> = robot.path_to_base(find_link(robot, self.link.as_deref())?).collect();
        joints.sort_unstable();
        let term = |k: usize| Term {
            symbol: format!("payload_{}", PARAMETER_NAMES[k]),
            unit: PARAMETER_UNITS[k],
            joints: joints.clone(),
        };
        Ok((0..self.count()).map(term).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let link = find_link(at.robot, self.link.as_deref())?;
        let mut block = RegressorBlock::new(at.chain, at.range.len());
        block.fill(at.chain, at.samples(), at.range.clone());
        for joint in at.robot.path_to_base(link) {
            for k in 0..self.count() {
                if let Some(column) = block.column(joint, PARAMETERS_PER_LINK * link + k) {
                    out.column(k, joint, |slot| slot.copy_from_slice(column));
                }
            }
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    /// Of mass and centre of mass, which people are told; what is fitted are first moments.
    fn implausible(&self, _robot: &Robot, values: &[f64]) -> Option<String> {
        let [mass, com, ..] = Self::ABOUT.parameters else { return None };
        let m = *values.first()?;
        let broken = mass.broken(m).or_else(|| values[1..4].iter().find_map(|first| com.broken(first / m)));
        broken.map(|bound| bound.beyond.to_string())
    }

    /// Mass and centre of mass, the latter with errors by the delta method, then the inertia.
    fn describe(&self, robot: &Robot, values: &[f64], covariance: &DMatrix<f64>) -> Result<Vec<Described>> {
        let root = |variance: f64| Some(variance.sqrt()).filter(|e| e.is_finite());
        let m = values[0];
        let mut told = vec![Described {
            name: "mass".to_string(),
            value: m,
            unit: "kg",
            standard_error: root(covariance[(0, 0)]),
        }];
        for (k, axis) in (1..4).zip(["x", "y", "z"]) {
            let c = values[k] / m;
            let spread = covariance[(k, k)] - 2.0 * c * covariance[(0, k)] + c * c * covariance[(0, 0)];
            told.push(Described {
                name: format!("com_{axis}"),
                value: c,
                unit: "m",
                standard_error: root(spread / (m * m)),
            });
        }
        for (k, term) in self.terms(robot)?.into_iter().enumerate().skip(4) {
            told.push(Described {
                name: term.symbol,
                value: values[k],
                unit: term.unit,
                standard_error: root(covariance[(k, k)]),
            });
        }
        Ok(told)
    }
}
