//! Joint friction of the plant.

use serde::{Deserialize, Serialize};

use super::effect::{Moment, PlantEffect};
use super::per_joint::PerJoint;
use super::twin::{Scope, Twin, boxed, only};
use lacuna_base::error::{Error, Result};
use lacuna_base::text::bounds::{NotNegative, Positive};

/// Friction in proportion to velocity.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ViscousFriction {
    /// Load per velocity [N m s/rad, N s/m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub coefficients: PerJoint,
}

impl ViscousFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "viscous_friction",
        example: "(coefficients: [0.5])",
        scope: Scope::Joint,
        unit: 0.5,
        limit: 50.0,
        not_on: &[],
        make: |j, s, _| boxed(ViscousFriction { coefficients: only(j, s) }),
    };
}

#[typetag::serde(name = "viscous_friction")]
impl PlantEffect for ViscousFriction {
    fn check(&self, dof: usize) -> Result<()> {
        self.coefficients.check_not_negative("viscous friction", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            *load += self.coefficients.of(j) * now.dq[j];
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        slope.iter_mut().enumerate().for_each(|(j, slope)| *slope += self.coefficients.of(j));
    }
}

/// Dry friction of constant size against the motion, with a steep but smooth passage through rest:
/// `level tanh(dq / width)`.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CoulombFriction {
    /// Load of a moving joint [N m, N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub levels: PerJoint,
    /// Velocity at which 76 % of the level is reached [rad/s, m/s].
    #[serde(default = "CoulombFriction::default_width", deserialize_with = "Positive::read")]
    pub width: f64,
}

impl CoulombFriction {
    /// With the passage through rest as narrow as simulation at usual steps bears.
    pub fn new(levels: PerJoint) -> Self {
        Self { levels, width: Self::default_width() }
    }

    fn default_width() -> f64 {
        5e-3
    }
}

impl CoulombFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "coulomb_friction",
        example: "(levels: [0.8])",
        scope: Scope::Joint,
        unit: 0.5,
        limit: 20.0,
        not_on: &[],
        make: |j, s, _| boxed(CoulombFriction { levels: only(j, s), width: 0.005 }),
    };
}

#[typetag::serde(name = "coulomb_friction")]
impl PlantEffect for CoulombFriction {
    fn check(&self, dof: usize) -> Result<()> {
        if !(self.width.is_finite() && self.width > 0.0) {
            let what = format!("the width of Coulomb friction is {}", self.width);
            return Err(Error::new(what).help("give a small positive velocity, such as 0.005"));
        }
        self.levels.check_not_negative("Coulomb friction", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            *load += self.levels.of(j) * libm::tanh(now.dq[j] / self.width);
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        slope.iter_mut().enumerate().for_each(|(j, slope)| *slope += self.levels.of(j) / self.width);
    }
}

/// A constant load, as a torque sensor's zero error shows it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TorqueOffset {
    /// Load [N m, N].
    pub offsets: PerJoint,
}

impl TorqueOffset {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "torque_offset",
        example: "(offsets: [0.3])",
        scope: Scope::Joint,
        unit: 0.3,
        limit: 20.0,
        not_on: &[],
        make: |j, s, _| boxed(TorqueOffset { offsets: only(j, s) }),
    };
}

#[typetag::serde(name = "torque_offset")]
impl PlantEffect for TorqueOffset {
    fn check(&self, dof: usize) -> Result<()> {
        self.offsets.check("the torque offset", dof)
    }

    fn add_load(&self, _now: &Moment, load: &mut [f64]) {
        load.iter_mut().enumerate().for_each(|(j, load)| *load += self.offsets.of(j));
    }
}

/// Sigmoid friction (Gaz et al. 2019, eq. 25):
/// `phi1 / (1 + exp(-phi2 (dq + phi3))) - phi1 / (1 + exp(-phi2 phi3))`, zero at rest.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct SigmoidFriction {
    /// Distance between both plateaus [N m, N].
    #[serde(deserialize_with = "NotNegative::read")]
    pub phi1: PerJoint,
    /// Steepness [s/rad, s/m].
    #[serde(deserialize_with = "NotNegative::read")]
    pub phi2: PerJoint,
    /// Shift along the velocity [rad/s, m/s].
    pub phi3: PerJoint,
}

impl SigmoidFriction {
    /// Friction of the Franka Emika Panda's joints as published (supplement of Gaz et al. 2019, Table I).
    pub fn panda() -> Self {
        Self {
            phi1: [5.4615e-01, 0.87224, 6.4068e-01, 1.2794, 8.3904e-01, 3.0301e-01, 5.6489e-01].into(),
            phi2: [5.1181, 9.0657, 1.0136e+01, 5.5903, 8.3469, 1.7133e+01, 1.0336e+01].into(),
            phi3: [3.9533e-02, 2.5882e-02, -4.6070e-02, 3.6194e-02, 2.6226e-02, -2.1047e-02, 3.5526e-03]
                .into(),
        }
    }
}

impl SigmoidFriction {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "sigmoid_friction",
        example: "(phi1: [1.0], phi2: [8.0], phi3: [0.02])",
        scope: Scope::Joint,
        unit: 1.0,
        limit: 20.0,
        not_on: &[],
        make: |j, s, draw| {
            let (phi2, phi3) = (draw.between(4.0, 15.0), draw.between(-0.05, 0.05));
            boxed(SigmoidFriction { phi1: only(j, s), phi2: only(j, phi2), phi3: only(j, phi3) })
        },
    };
}

#[typetag::serde(name = "sigmoid_friction")]
impl PlantEffect for SigmoidFriction {
    fn check(&self, dof: usize) -> Result<()> {
        self.phi1.check_not_negative("phi1 of sigmoid friction", dof)?;
        self.phi2.check_not_negative("phi2 of sigmoid friction", dof)?;
        self.phi3.check("phi3 of sigmoid friction", dof)
    }

    fn add_load(&self, now: &Moment, load: &mut [f64]) {
        for (j, load) in load.iter_mut().enumerate() {
            let (height, steepness, shift) = (self.phi1.of(j), self.phi2.of(j), self.phi3.of(j));
            let sigmoid = |v: f64| height / (1.0 + libm::exp(-steepness * v));
            *load += sigmoid(now.dq[j] + shift) - sigmoid(shift);
        }
    }

    fn add_steepest_slope(&self, slope: &mut [f64]) {
        slope
            .iter_mut()
            .enumerate()
            .for_each(|(j, slope)| *slope += 0.25 * self.phi1.of(j) * self.phi2.of(j));
    }
}

/// Inertia of a drive's rotor, reflected through its gear: it resists acceleration and moves no link.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct RotorInertia {
    /// Reflected inertia [kg m², kg].
    #[serde(deserialize_with = "NotNegative::read")]
    pub inertias: PerJoint,
}

/// Why it cannot be told on the first two joints of a Panda.
const LIKE_THE_LINK: &str = "is the same as a rotational inertia of the link";

impl RotorInertia {
    /// See [`Twin`].
    pub const TWIN: Twin = Twin {
        name: "rotor_inertia",
        example: "(inertias: [0.2])",
        scope: Scope::Joint,
        unit: 0.1,
        limit: 5.0,
        not_on: &[(0, LIKE_THE_LINK), (1, LIKE_THE_LINK)],
        make: |j, s, _| boxed(RotorInertia { inertias: only(j, s) }),
    };
}

#[typetag::serde(name = "rotor_inertia")]
impl PlantEffect for RotorInertia {
    fn check(&self, dof: usize) -> Result<()> {
        self.inertias.check_not_negative("rotor inertia", dof)
    }

    fn add_load(&self, _now: &Moment, _load: &mut [f64]) {}

    fn add_armature(&self, armature: &mut [f64]) {
        armature.iter_mut().enumerate().for_each(|(j, armature)| *armature += self.inertias.of(j));
    }
}

#[cfg(test)]
mod tests {
    use super::super::Kinematics;
    use super::*;
    use lacuna_base::robot::samples;

    fn load(effect: &dyn PlantEffect, dq: &[f64]) -> Vec<f64> {
        let zero = vec![0.0; dq.len()];
        let mut load = zero.clone();
        let arm = Kinematics::new(&samples::seven_joint()).expect("a robot");
        effect.add_load(&Moment { t: 0.0, q: &zero, dq, tau: &zero, own: &[], arm: &arm }, &mut load);
        load
    }

    fn catalogue() -> Vec<Box<dyn PlantEffect>> {
        vec![
            Box::new(ViscousFriction { coefficients: [0.5, 2.0, 0.0, 1.0, 3.0, 0.1, 0.2].into() }),
            Box::new(CoulombFriction::new(PerJoint::all(0.8))),
            Box::new(TorqueOffset { offsets: [0.1, -0.2, 0.3, 0.0, 0.0, 0.0, 1.0].into() }),
            Box::new(SigmoidFriction::panda()),
            Box::new(RotorInertia { inertias: PerJoint::all(0.2) }),
        ]
    }

    #[test]
    fn loads_are_what_the_formulas_say() {
        let dq = [2.0, -0.5, 0.0, 1e-4, 0.0, 0.0, 0.0];
        assert_eq!(load(catalogue()[0].as_ref(), &dq)[..2], [1.0, -1.0]);
        let dry = load(catalogue()[1].as_ref(), &dq);
        assert!((dry[0] - 0.8).abs() < 1e-12 && (dry[1] + 0.8).abs() < 1e-12 && dry[2].abs() < 1e-15);
        assert!((dry[3] - 0.8 * (0.02_f64).tanh()).abs() < 1e-12, "smooth through rest: {dry:?}");
        let sigmoid = load(catalogue()[3].as_ref(), &[0.0; 7]);
        assert!(sigmoid.iter().all(|x| x.abs() < 1e-15), "no friction at rest: {sigmoid:?}");
        let (fast, slow) =
            (load(catalogue()[3].as_ref(), &[50.0; 7]), load(catalogue()[3].as_ref(), &[-50.0; 7]));
        assert!((fast[3] - slow[3] - 1.2794).abs() < 1e-12, "plateaus lie phi1 apart");
        // Joint 1 at 1 rad/s, worked by hand from the printed numbers.
        let hand = 0.54615 / (1.0 + (-5.1181_f64 * 1.039533).exp())
            - 0.54615 / (1.0 + (-5.1181_f64 * 0.039533).exp());
        assert!((load(catalogue()[3].as_ref(), &[1.0; 7])[0] - hand).abs() < 1e-14);
    }

    #[test]
    fn no_load_is_steeper_than_said() {
        for effect in catalogue() {
            let mut said = [0.0; 7];
            effect.add_steepest_slope(&mut said);
            let mut seen = [0.0_f64; 7];
            for k in -4000..4000 {
                let v = 1e-4 * f64::from(k);
                let (low, high) = (load(effect.as_ref(), &[v; 7]), load(effect.as_ref(), &[v + 1e-4; 7]));
                seen.iter_mut().enumerate().for_each(|(j, s)| *s = s.max((high[j] - low[j]) / 1e-4));
            }
            for j in 0..7 {
                assert!(seen[j] <= said[j] * (1.0 + 1e-9) + 1e-9, "{effect:?}: {} {}", seen[j], said[j]);
                assert!(seen[j] >= 0.98 * said[j], "{effect:?} exaggerates: {} {}", seen[j], said[j]);
            }
        }
    }

    #[test]
    fn every_effect_is_written_under_its_catalogue_name_and_read_back() -> Result<()> {
        let names =
            ["viscous_friction", "coulomb_friction", "torque_offset", "sigmoid_friction", "rotor_inertia"];
        for (effect, name) in catalogue().iter().zip(names) {
            effect.check(7)?;
            let text = ron::to_string(effect).map_err(|e| Error::new(e.to_string()))?;
            assert!(text.starts_with(&format!("{{\"{name}\":")), "{text}");
            let back: Box<dyn PlantEffect> = ron::from_str(&text).map_err(|e| Error::new(e.to_string()))?;
            assert_eq!(format!("{effect:?}"), format!("{back:?}"));
        }
        let wrong = "{\"viscous_friction\": (coefficient: [1.0])}";
        assert!(ron::from_str::<Box<dyn PlantEffect>>(wrong).is_err());
        assert!(ViscousFriction { coefficients: [1.0, 2.0].into() }.check(7).is_err());
        assert!(ViscousFriction { coefficients: [-1.0].into() }.check(7).is_err());
        assert!(CoulombFriction { levels: PerJoint::all(1.0), width: 0.0 }.check(7).is_err());
        Ok(())
    }
}
