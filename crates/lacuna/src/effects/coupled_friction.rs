use serde::{Deserialize, Serialize};

use super::about::*;
use super::parts::FrictionPart;
use super::{Columns, Effect, Joints, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;

/// Friction of one joint that appears in the torque of another.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoupledFriction {
    /// The joint that feels it, by name or number.
    pub joint: String,
    /// The joint whose motion makes it, by name or number.
    pub from: String,
    /// Which parts of it.
    #[serde(default = "CoupledFriction::both")]
    pub part: FrictionPart,
    /// Width of the smoothed sign `tanh(dq / width)` [rad/s]; 0 is the hard sign.
    #[serde(default)]
    pub width: f64,
}

impl CoupledFriction {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "coupled_friction",
        title: "friction of another joint that shows in this one",
        text: "In wrists that share gears or belts, and where shafts run one inside the other, a motor turns \
               against the friction of a neighbour. The residual of the joint follows another joint's \
               velocity. Viscous and dry part should have the same sign.",
        equation: "tau_j = cv dq_i + cc sign(dq_i)",
        parameters: &[
            Parameter::new("cv", "N m s/rad", "torque on joint j per velocity of joint i"),
            Parameter::new("cc", "N m", "torque on joint j by the direction of joint i"),
        ],
        cause: "shafts that run one inside the other, gears or belts that two joints of a wrist share",
        confused_with: "friction of the joint itself where both move alike (slow motions of single joints \
                        separate them), rigid_body terms of the other joint's acceleration",
        separation: Separation::OTHER,
        example: r#"{"coupled_friction": (joint: "1", from: "2")}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::ChangingStep,
        reach: Reach::Pair,
        stage: Stage::Usual,
        imitated_by: &[],
        special: Special { exports: Exports { c: "as it is", ..Exports::NOWHERE }, ..Special::NONE },
    };

    fn both() -> FrictionPart {
        FrictionPart::Both
    }

    /// Neighbours on the arm, and the last three joints of it among each other.
    pub(super) fn candidates(robot: &Robot) -> Vec<Box<dyn Effect>> {
        let wrist = &robot.order[robot.dof().saturating_sub(3)..];
        let parent = |i: usize| robot.joints[i].parent;
        let near = |j: usize, i: usize| {
            parent(i) == Some(j) || parent(j) == Some(i) || (wrist.contains(&i) && wrist.contains(&j))
        };
        let mut all: Vec<Box<dyn Effect>> = Vec::new();
        for j in 0..robot.dof() {
            for i in (0..robot.dof()).filter(|&i| i != j && near(j, i)) {
                let name = |k: usize| robot.joints[k].name.clone();
                let part = FrictionPart::Both;
                all.push(Box::new(Self { joint: name(j), from: name(i), part, width: 0.0 }));
            }
        }
        all
    }

    /// Indices of the joint that feels it and of the one that makes it.
    fn pair(&self, robot: &Robot) -> Result<(usize, usize)> {
        let one =
            |name: &String| -> Result<usize> { Ok(Joints::Only(vec![name.clone()]).indices(robot)?[0]) };
        let (joint, from) = (one(&self.joint)?, one(&self.from)?);
        if joint == from {
            return Err(Error::new("coupled_friction of a joint with itself")
                .help("use viscous_friction and coulomb_friction, or name another joint in `from`"));
        }
        Ok((joint, from))
    }
}

#[typetag::serde(name = "coupled_friction")]
impl Effect for CoupledFriction {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let (joint, from) = self.pair(robot)?;
        let named = self.part.named(("cv", "N m s/rad"), ("cc", "N m"));
        let term = |(prefix, unit): (&str, &'static str)| Term {
            symbol: format!("{prefix}{}_{}", joint + 1, from + 1),
            unit,
            joints: vec![joint],
        };
        Ok(named.into_iter().map(term).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let (joint, from) = self.pair(at.robot)?;
        for (term, part) in self.part.singles().iter().enumerate() {
            out.column(term, joint, |slot| part.fill(at, from, self.width, slot));
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn sign_of(&self, robot: &Robot) -> Result<Option<usize>> {
        Ok(Some(self.pair(robot)?.1))
    }

    fn with_width(&self, width: f64) -> Box<dyn Effect> {
        Box::new(Self { width, ..self.clone() })
    }

    fn odd(&self, _robot: &Robot, values: &[f64]) -> Option<String> {
        let opposite = matches!(values, [v, c] if v * c < 0.0);
        opposite.then(|| "viscous and dry part have opposite signs, as shared gears never do".to_string())
    }
}
