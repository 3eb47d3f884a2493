use nalgebra::{DMatrix, Vector3};
use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Described, Effect, Stretch, Term, find_link};
use crate::error::{Error, Result};
use crate::robot::{JointKind, Pose, Robot};

/// Something that pushes against a link for a while, with a constant force.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ContactForce {
    /// When it begins, on the log's own clock \[s\].
    pub from_s: f64,
    /// When it has ended \[s\].
    pub to_s: f64,
    /// The link it acts on, by name or number; the last one when not given.
    #[serde(default)]
    pub link: Option<String>,
    /// Where it acts, in the link's frame \[m\].
    #[serde(default)]
    pub point: [f64; 3],
    /// Name of the log it happens in; in every log when not given.
    #[serde(default)]
    pub log: Option<String>,
}

const AXES: [&str; 3] = ["x", "y", "z"];

impl ContactForce {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "contact_force",
        title: "something pushes against the robot for a while",
        text: "A hand, a table edge, a workpiece: between two times a constant force acts on a point of a \
               link, and the drives have to hold against it. All joints between the base and that link see \
               it at once. The force is that on the robot, in the base frame. Where it does not act at the \
               point assumed (by default the origin of the last link), the joints near the end keep a \
               remainder.",
        equation: "tau = -J(q)^T f, from from_s to to_s",
        parameters: &[Parameter::new("fx, fy, fz", "N", "force on the robot, base frame")],
        cause: "a hand, a table edge or a workpiece in the way",
        confused_with: "a disturbance of a single sensor (then one joint alone shows it), payload (always there)",
        separation: Separation::OTHER,
        example: r#"{"contact_force": (from_s: 2.0, to_s: 3.0)}"#,
        drawn_against: Variable::Time,
        at_rest: AtRest::Smooth,
        reach: Reach::Robot,
        stage: Stage::Event,
        imitated_by: &[],
        special: Special::NONE,
    };

    fn check(&self) -> Result<()> {
        let finite = [self.from_s, self.to_s].iter().chain(&self.point).all(|x| x.is_finite());
        if finite && self.from_s < self.to_s {
            return Ok(());
        }
        Err(Error::new(format!("a contact_force from {} s to {} s", self.from_s, self.to_s))
            .help("`from_s` must lie before `to_s`, both on the log's clock"))
    }

    /// Torque on every joint of `path` (base first) of a unit force along each axis.
    fn lever(&self, robot: &Robot, path: &[usize], q: impl Fn(usize) -> f64) -> Vec<Vector3<f64>> {
        let mut pose = Pose::identity();
        let mut axes = Vec::with_capacity(path.len());
        for &i in path {
            let joint = &robot.joints[i];
            let at = pose.then(&joint.before);
            axes.push((at.translation, at.rotation * joint.axis, joint.kind));
            pose = pose.then(&joint.pose(q(i)));
        }
        let point = pose.rotation * Vector3::from(self.point) + pose.translation;
        axes.into_iter()
            .map(|(origin, axis, kind)| match kind {
                JointKind::Revolute => axis.cross(&(point - origin)),
                JointKind::Prismatic => axis,
            })
            .collect()
    }
}

#[typetag::serde(name = "contact_force")]
impl Effect for ContactForce {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        self.check()?;
        let mut joints: Vec<usize> = robot.path_to_base(find_link(robot, self.link.as_deref())?).collect();
        joints.sort_unstable();
        let log = self.log.as_deref().map_or_else(String::new, |log| format!("_{log}"));
        let term = |axis: &str| Term {
            symbol: format!("f{axis}_{:.2}s{log}", self.from_s),
            unit: "N",
            joints: joints.clone(),
        };
        Ok(AXES.iter().map(|axis| term(axis)).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        if self.log.as_ref().is_some_and(|log| *log != at.run.name) {
            return Ok(());
        }
        let mut path: Vec<usize> =
            at.robot.path_to_base(find_link(at.robot, self.link.as_deref())?).collect();
        path.reverse();
        let touched = |k: usize| {
            let t = at.run.start + k as f64 * at.run.dt;
            t >= self.from_s && t < self.to_s
        };
        let levers: Vec<(usize, Vec<Vector3<f64>>)> = at
            .range
            .clone()
            .filter(|&k| touched(k))
            .map(|k| (k - at.range.start, self.lever(at.robot, &path, |i| at.run.q[i][k])))
            .collect();
        for term in 0..3 {
            for (place, &joint) in path.iter().enumerate() {
                out.column(term, joint, |slot| {
                    levers.iter().for_each(|(row, lever)| slot[*row] = -lever[place][term]);
                });
            }
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn describe(&self, robot: &Robot, values: &[f64], covariance: &DMatrix<f64>) -> Result<Vec<Described>> {
        let force = self.terms(robot)?.into_iter().enumerate().map(|(i, term)| Described {
            name: term.symbol,
            value: values[i],
            unit: term.unit,
            standard_error: Some(covariance[(i, i)].sqrt()).filter(|e| e.is_finite()),
        });
        // Where it acts is only worth a word away from the link's origin.
        let point = AXES.iter().zip(self.point).map(|(axis, value)| Described {
            name: format!("point_{axis}"),
            value,
            unit: "m",
            standard_error: None,
        });
        let away = self.point.iter().any(|x| x.abs() > 0.0);
        Ok(force.chain(point.filter(|_| away)).collect())
    }

    fn interval(&self) -> Option<(f64, f64)> {
        Some((self.from_s, self.to_s))
    }

    fn undecidable(&self, _robot: &Robot, runs: &[crate::signals::Run]) -> Option<String> {
        let here = |run: &crate::signals::Run| {
            let end = run.start + run.samples() as f64 * run.dt;
            self.log.as_ref().is_none_or(|log| *log == run.name) && self.from_s < end && self.to_s > run.start
        };
        (!runs.iter().any(here)).then(|| "no log covers the time of the contact".to_string())
    }
}
