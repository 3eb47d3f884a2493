use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::{Factor, check_finite, joint_index};
use lacuna_base::error::Result;
use lacuna_base::text::bounds::JointNumber;

/// A load that no catalogue has: `amplitude` times a product of [`Factor`]s, on one joint. Detents, end stops,
/// piecewise laws, loads of three variables, and loads that follow a channel are all of this kind.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Product {
    /// Number of the joint that carries the load, from 1.
    #[serde(deserialize_with = "JointNumber::read")]
    pub joint: usize,
    /// Load where all factors are 1 [N m, N].
    pub amplitude: f64,
    /// What it is multiplied with.
    pub factors: Vec<Factor>,
}

#[typetag::serde(name = "product")]
impl PlantEffect for Product {
    fn check(&self, dof: usize) -> Result<()> {
        joint_index("the product", self.joint, dof)?;
        check_finite("the amplitude of the product", &[self.amplitude])?;
        self.factors.iter().try_for_each(|factor| factor.check(dof))
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        let product: f64 = self.factors.iter().map(|factor| factor.value(now)).product();
        load[self.joint - 1] += self.amplitude * product;
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        for (i, factor) in self.factors.iter().enumerate() {
            let Some((joint, steepness)) = factor.slope() else { continue };
            let others = self.factors.iter().enumerate().filter(|(k, _)| *k != i);
            let largest: f64 = others.map(|(_, other)| other.largest()).product();
            slope[joint] += self.amplitude.abs() * steepness * largest;
        }
    }

    fn measure(&self, now: &Moment, note: &mut dyn FnMut(&str, f64)) {
        for factor in &self.factors {
            if let Factor::Channel { name, .. } = factor {
                note(name, factor.value(now));
            }
        }
    }
}
