use lacuna::Result;
use lacuna::effects::{
    About, AtRest, Columns, Effect, Joints, Parameter, Reach, Separation, Shape, Special, Stage, Stretch,
    Term, Variable,
};
use lacuna::robot::Robot;
use serde::{Deserialize, Serialize};

/// A gas spring between two links: it pushes with a lever that turns with the joint.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct GasSpring {
    /// Joints it acts on.
    #[serde(default)]
    pub joints: Joints,
    /// Position in which it has no lever \[rad\].
    pub rest: f64,
}

impl GasSpring {
    /// What it says about itself.
    pub const ABOUT: About = About {
        name: "gas_spring",
        title: "a gas spring that carries part of the weight",
        text: "Pushes with nearly the same force wherever it is, so its torque is a sine of the joint's position.",
        equation: "tau_j = kg_j sin(q_j - rest)",
        parameters: &[
            Parameter::new("kg", "N m", "force times lever"),
            Parameter::new("rest", "rad", "position in which it has no lever"),
        ],
        cause: "a gas spring between two links",
        confused_with: "gravity on the link that it carries, where the joint's axis is horizontal",
        separation: Separation::FAR,
        example: r#"{"gas_spring": (rest: 0.3)}"#,
        drawn_against: Variable::Position,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Given,
        imitated_by: &[],
        special: Special::NONE,
    };
}

#[typetag::serde(name = "gas_spring")]
impl Effect for GasSpring {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let term = |j: usize| Term { symbol: format!("kg{}", j + 1), unit: "N m", joints: vec![j] };
        Ok(self.joints.indices(robot)?.into_iter().map(term).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        for (term, joint) in self.joints.indices(at.robot)?.into_iter().enumerate() {
            out.column(term, joint, |slot| {
                slot.iter_mut().zip(at.q(joint)).for_each(|(y, q)| *y = (q - self.rest).sin());
            });
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    fn shapes(&self) -> Vec<Shape> {
        let trials = vec![-1.5, 0.0, 1.5];
        vec![Shape { symbol: "rest", unit: "rad", value: self.rest, low: -3.2, high: 3.2, trials }]
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        Box::new(Self { rest: values[0], ..self.clone() })
    }
}
