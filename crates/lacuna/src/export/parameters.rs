//! What a finished model says about links and joints.

use nalgebra::{Matrix3, Vector3};

use crate::effects::OfJoint;
use crate::error::{Error, Result};
use crate::identify::parameter_name;
use crate::model_file::ModelFile;
use crate::robot::{InertialParameters, PARAMETERS_PER_LINK, Robot};

/// Mass \[kg\] below which a link has no centre of mass.
const LIGHTEST: f64 = 1e-6;
/// How far below 0 a mass or second moment may be by rounding, in SI units: what an audit calls feasible.
const ROUNDING: f64 = 1e-9;

/// Parameters of all links and the friction that other tools know.
#[derive(Debug, Clone, PartialEq)]
pub struct Parameters {
    /// Link by link, in the link frames of the robot.
    pub links: Vec<InertialParameters>,
    /// Joint by joint.
    pub friction: Vec<Friction>,
    /// Effects of the model that only JSON can carry.
    pub left_out: Vec<&'static str>,
    /// How many of the link parameters the model file lists.
    pub listed: usize,
}

/// Friction of a joint, where the model has it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Friction {
    /// Viscous coefficient [N m s/rad, N s/m].
    pub viscous: Option<f64>,
    /// Coulomb torque [N m, N].
    pub coulomb: Option<f64>,
}

impl Friction {
    /// The number that an effect says its parameter is.
    fn of(&mut self, which: OfJoint) -> &mut Option<f64> {
        match which {
            OfJoint::Damping => &mut self.viscous,
            OfJoint::Friction => &mut self.coulomb,
        }
    }
}

/// A link as other tools want it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Body {
    /// Mass \[kg\].
    pub mass: f64,
    /// Centre of mass \[m\].
    pub com: Vector3<f64>,
    /// Inertia about it [kg m²].
    pub inertia: Matrix3<f64>,
}

impl Body {
    /// From link parameters.
    ///
    /// # Errors
    /// When there is a first moment without mass, which no body has.
    pub fn new(link: &InertialParameters) -> Result<Self> {
        if let (Some(com), Some(inertia)) = (link.center_of_mass(), link.inertia_at_center_of_mass()) {
            return Ok(Self { mass: link.mass(), com, inertia });
        }
        if link.first_moment().amax() > ROUNDING || link.mass() < -ROUNDING {
            return Err(Error::new(format!(
                "a body of {:.3e} kg has no first moment of {:.3e} kg m",
                link.mass(),
                link.first_moment().norm()
            ))
            .help("there is no way to write it with a centre of mass; retrieve feasible parameters first"));
        }
        Ok(Self { mass: link.mass().max(0.0), com: Vector3::zeros(), inertia: link.inertia_at_origin() })
    }
}

impl Parameters {
    /// From a model file; link parameters that it does not list are 0.
    ///
    /// # Errors
    /// When the file does not fit the robot or has no rigid body.
    pub fn read(file: &ModelFile, robot: &Robot) -> Result<Self> {
        // Refuses parameters that are unknown, stand twice or are not numbers.
        file.on(robot)?;
        if !file.effects.iter().any(|e| e.is_rigid_body()) {
            return Err(Error::new("the model has no rigid_body, so it has no link parameters"));
        }
        let value = |symbol: String| file.parameters.iter().find(|p| p.symbol == symbol).map(|p| p.value);
        let mut listed = 0;
        let mut link = |link: usize| {
            InertialParameters(std::array::from_fn(|k| {
                let value = value(parameter_name(PARAMETERS_PER_LINK * link + k));
                listed += usize::from(value.is_some());
                value.unwrap_or(0.0)
            }))
        };
        let links = (0..robot.links.len()).map(&mut link).collect();
        let mut friction = vec![Friction::default(); robot.dof()];
        let mut left_out = Vec::new();
        for effect in file.effects.iter().filter(|e| !e.is_rigid_body()) {
            let Some(of_joint) = effect.about().special.exports.joint else {
                left_out.push(effect.about().name);
                continue;
            };
            for term in effect.terms(robot)? {
                for joint in term.joints {
                    *friction[joint].of(of_joint) = value(term.symbol.clone());
                }
            }
        }
        Ok(Self { links, friction, left_out, listed })
    }

    /// What no body can have: one sentence per link that is not physical; empty when all are.
    pub fn doubts(&self, robot: &Robot) -> Vec<String> {
        let links = robot.links.iter().zip(&self.links);
        links.filter_map(|(about, link)| Some(format!("link `{}`: {}", about.name, doubt(link)?))).collect()
    }

    /// Why a set of parameters that lists few of them is not physical.
    pub fn explanation(&self) -> Option<String> {
        let all = PARAMETERS_PER_LINK * self.links.len();
        (self.listed < all).then(|| {
            format!(
                "the model lists {} of {all} link parameters: base parameters give the right torque but belong to \
                 no body; retrieve feasible parameters first",
                self.listed
            )
        })
    }

    pub(super) fn body(&self, robot: &Robot, link: usize, parameters: &InertialParameters) -> Result<Body> {
        Body::new(parameters).map_err(|e| e.within(&format!("link `{}`", robot.links[link].name)))
    }

    pub(super) fn left_out_note(&self, format: &str) -> Option<String> {
        let names = self.left_out.join(", ");
        (!names.is_empty()).then(|| format!("{format} cannot say {names}; the JSON export has them"))
    }

    /// Friction coefficients that make sense to other tools; a note for each that does not.
    pub(super) fn usable_friction(&self, robot: &Robot, notes: &mut Vec<String>) -> Vec<Friction> {
        let joints = robot.joints.iter().zip(&self.friction);
        let mut usable = |name: &str, what: &str, value: Option<f64>| {
            let value = value?;
            if value < 0.0 {
                notes.push(format!("joint `{name}`: {what} friction {value:.3e} is negative and left out"));
            }
            (value >= 0.0).then_some(value)
        };
        joints
            .map(|(joint, friction)| Friction {
                viscous: usable(&joint.name, "viscous", friction.viscous),
                coulomb: usable(&joint.name, "Coulomb", friction.coulomb),
            })
            .collect()
    }
}

fn doubt(link: &InertialParameters) -> Option<String> {
    if link.mass() < -ROUNDING {
        return Some(format!("its mass is {:.6e} kg", link.mass()));
    }
    let Some(inertia) = link.inertia_at_center_of_mass().filter(|_| link.mass() >= LIGHTEST) else {
        let least = link.pseudo_inertia().symmetric_eigenvalues().min();
        return (least < -ROUNDING).then(|| "it has moments without mass".to_string());
    };
    let least = 0.5 * inertia.trace() - inertia.symmetric_eigenvalues().max();
    (least < -ROUNDING).then(|| {
        format!(
            "its inertia breaks the triangle inequality by {:.3e} kg m^2 (principal moments {})",
            -least,
            {
                let mut moments: [f64; 3] = inertia.symmetric_eigenvalues().into();
                moments.sort_by(f64::total_cmp);
                moments.map(|m| format!("{m:.3e}")).join(", ")
            }
        )
    })
}
