//! Settings with one number per joint.

use serde::{Deserialize, Deserializer, Serialize};

use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{Kind, Numbers};

/// One number for each joint, or a single one for all; empty means zero everywhere.
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(transparent)]
pub struct PerJoint(pub Vec<f64>);

impl PerJoint {
    /// The same number for all joints.
    pub fn all(value: f64) -> Self {
        Self(vec![value])
    }

    /// The number of joint `j`.
    pub fn of(&self, j: usize) -> f64 {
        match self.0.as_slice() {
            [one] => *one,
            many => many.get(j).copied().unwrap_or(0.0),
        }
    }

    /// Whether it is zero everywhere.
    pub fn is_zero(&self) -> bool {
        self.0.iter().all(|x| *x == 0.0)
    }

    /// Refuses a wrong number of entries and entries that are not finite; `what` names it in the message.
    ///
    /// # Errors
    /// As said.
    pub fn check(&self, what: &str, dof: usize) -> Result<()> {
        let found = self.0.len();
        if found > 1 && found != dof {
            let help = format!("give {dof} numbers, or one for all joints");
            return Err(Error::new(format!("{what} has {found} numbers for {dof} joints")).help(help));
        }
        match self.0.iter().find(|x| !x.is_finite()) {
            Some(x) => Err(Error::new(format!("{what} holds {x}")).help("give finite numbers")),
            None => Ok(()),
        }
    }

    /// Like [`PerJoint::check`], and refuses negative numbers.
    ///
    /// # Errors
    /// As said.
    pub fn check_not_negative(&self, what: &str, dof: usize) -> Result<()> {
        self.check(what, dof)?;
        match self.0.iter().find(|x| **x < 0.0) {
            Some(x) => {
                Err(Error::new(format!("{what} holds {x}")).help("give numbers that are not negative"))
            }
            None => Ok(()),
        }
    }
}

impl Numbers for PerJoint {
    fn read<'de, K: Kind, D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        Vec::<f64>::read::<K, D>(from).map(Self)
    }
}

impl<const N: usize> From<[f64; N]> for PerJoint {
    fn from(values: [f64; N]) -> Self {
        Self(values.to_vec())
    }
}
