use serde::{Deserialize, Serialize};

use super::about::*;
use super::{Columns, Effect, Stretch, Term};
use crate::error::Result;
use crate::kernels::RegressorBlock;
use crate::robot::{PARAMETER_NAMES, PARAMETER_UNITS, PARAMETERS_PER_LINK, Robot};

/// The rigid links: `M(q) ddq + c(q, dq) + g(q)`, linear in ten parameters per link.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RigidBody {}

impl RigidBody {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "rigid_body",
        title: "rigid links under gravity: inertia, Coriolis and gravity torque",
        text: "The torque that moves rigid links. Only some combinations of the link parameters show in \
               joint torque; those base parameters are found by rank analysis and are what gets identified.",
        equation: "tau = M(q) ddq + c(q, dq) + g(q)",
        parameters: &[
            Parameter::new("m", "kg", "mass"),
            Parameter::new("mx, my, mz", "kg m", "mass times centre of mass, link frame"),
            Parameter::new(
                "Jxx, Jxy, Jxz, Jyy, Jyz, Jzz",
                "kg m^2",
                "inertia tensor about the link-frame origin",
            ),
        ],
        cause: "every link has mass",
        confused_with: "payload (adds to the last link), base_tilt (turns gravity), rotor_inertia (adds to M)",
        separation: Separation::OTHER,
        example: r#"{"rigid_body": ()}"#,
        drawn_against: Variable::Acceleration,
        at_rest: AtRest::Smooth,
        reach: Reach::Robot,
        stage: Stage::InEveryModel,
        imitated_by: &[],
        special: Special {
            exports: Exports {
                mujoco: "the body's inertial",
                isaaclab: "mass properties of the link",
                gazebo: "the link's inertial",
                drake: "the link's inertial",
                c: "inverse dynamics",
                ..Exports::NOWHERE
            },
            ..Special::NONE
        },
    };
}

#[typetag::serde(name = "rigid_body")]
impl Effect for RigidBody {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let mut terms = Vec::new();
        for link in 0..robot.dof() {
            let mut joints: Vec<usize> = robot.path_to_base(link).collect();
            joints.sort_unstable();
            for (name, unit) in PARAMETER_NAMES.iter().zip(PARAMETER_UNITS) {
                terms.push(Term { symbol: format!("{name}{}", link + 1), unit, joints: joints.clone() });
            }
        }
        Ok(terms)
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let fits =
            |b: &RegressorBlock| b.capacity() >= at.range.len() && b.parameters() == at.robot.dof() * 10;
        let mut block = match out.scratch.take() {
            Some(block) if fits(&block) => block,
            _ => RegressorBlock::new(at.chain, at.range.len()),
        };
        block.fill(at.chain, at.samples(), at.range.clone());
        for joint in 0..at.robot.dof() {
            for parameter in 0..PARAMETERS_PER_LINK * at.robot.dof() {
                if let Some(column) = block.column(joint, parameter) {
                    out.column(parameter, joint, |slot| slot.copy_from_slice(column));
                }
            }
        }
        *out.scratch = Some(block);
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }
}
