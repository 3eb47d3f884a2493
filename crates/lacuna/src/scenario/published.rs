//! Numbers that somebody published, with their source.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::effects::SigmoidParameters;
use crate::error::{Error, Result};
use crate::text;

/// Coefficients beyond this are refused: they are not meant, and their squares overflow.
const LARGEST_COEFFICIENT: f64 = 1e12;

/// Coefficients that somebody published, with their source.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Published {
    /// Where the numbers stand.
    pub source: String,
    /// Value of each base parameter by its leading symbol (`Jzz1`, `mx2`).
    pub coefficients: Vec<(String, f64)>,
}

impl Published {
    /// Reads a file of coefficients.
    ///
    /// # Errors
    /// With file, line and column.
    pub fn open(path: &Path) -> Result<Self> {
        Self::parse(&text::read(path)?).map_err(|e| e.in_file(path))
    }

    /// Reads the text of a file of coefficients.
    ///
    /// # Errors
    /// With line and column.
    pub fn parse(text: &str) -> Result<Self> {
        let shape = "scenarios/panda_table3.ron shows how coefficients are written";
        let published: Self = text::from_ron(text).map_err(|e| e.or_help(shape))?;
        published.check().map_err(|e| text::located(e, text))?;
        Ok(published)
    }

    fn check(&self) -> Result<()> {
        let mut seen = std::collections::BTreeSet::new();
        for (symbol, value) in &self.coefficients {
            if !seen.insert(symbol) {
                return Err(Error::new(format!("`{symbol}` stands twice")).help("keep one of them"));
            }
            if value.is_nan() || value.abs() > LARGEST_COEFFICIENT {
                return Err(Error::new(format!("`{symbol}` is {value}")).help("give a number in SI units"));
            }
        }
        Ok(())
    }

    /// Values in the order of `base`; coefficients that were not published are 0.
    ///
    /// # Errors
    /// When a symbol does not lead a base parameter of the robot.
    pub fn values(&self, base: &crate::identify::BaseParameters) -> Result<Vec<f64>> {
        let names: Vec<String> = base.pivots.iter().map(|&p| crate::identify::parameter_name(p)).collect();
        let mut values = vec![0.0; names.len()];
        for (symbol, value) in &self.coefficients {
            let Some(i) = names.iter().position(|n| n == symbol) else {
                return Err(Error::new(format!("`{symbol}` does not lead a base parameter of this robot"))
                    .help(format!("known are {}", names.join(", "))));
            };
            values[i] = *value;
        }
        Ok(values)
    }
}

/// Sigmoid friction that somebody published, with its source: one value per joint, in the robot's order.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PublishedFriction {
    /// Where the numbers stand.
    pub source: String,
    /// Amplitudes [N m].
    pub phi1: Vec<f64>,
    /// Steepness [s/rad].
    pub phi2: Vec<f64>,
    /// Velocity shifts [rad/s].
    pub phi3: Vec<f64>,
}

impl PublishedFriction {
    /// Reads a file of friction parameters.
    ///
    /// # Errors
    /// With file, line and column.
    pub fn open(path: &Path) -> Result<Self> {
        text::from_ron(&text::read(path)?).map_err(|e| e.in_file(path))
    }

    /// Joint by joint.
    ///
    /// # Errors
    /// When it is for another number of joints, or a number is not finite.
    pub fn parameters(&self, joints: usize) -> Result<Vec<SigmoidParameters>> {
        let lists = [&self.phi1, &self.phi2, &self.phi3];
        if lists.iter().any(|list| list.len() != joints || list.iter().any(|x| !x.is_finite())) {
            return Err(Error::new(format!("the robot has {joints} joints"))
                .help("phi1, phi2 and phi3 need a finite number for each of them"));
        }
        let at = |j: usize| SigmoidParameters { phi1: self.phi1[j], phi2: self.phi2[j], phi3: self.phi3[j] };
        Ok((0..joints).map(at).collect())
    }
}
