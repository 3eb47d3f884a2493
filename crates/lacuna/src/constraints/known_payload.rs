use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::links::link_index;
use super::measure::is_body;
use super::number::{finite, positive, triple};
use super::{About, Bound, Constraint, LinkSpace};
use crate::error::{Error, Result};
use crate::form::{Affine, Form};
use crate::robot::{InertialParameters, Robot};

/// A known body is part of a link: what is left of the link is a body too.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct KnownPayload {
    /// The link that carries it.
    pub link: String,
    /// Its mass \[kg\].
    #[serde(deserialize_with = "positive")]
    pub mass: f64,
    /// Its centre of mass in the link frame \[m\].
    #[serde(deserialize_with = "triple")]
    pub com: [f64; 3],
    /// Its inertia about its own centre of mass, in the link's axes; a point mass when not given.
    #[serde(default)]
    pub inertia: Tensor,
}

/// Elements of an inertia tensor [kg m²].
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
#[expect(missing_docs, reason = "the names say it")]
pub struct Tensor {
    #[serde(deserialize_with = "finite")]
    pub xx: f64,
    #[serde(deserialize_with = "finite")]
    pub xy: f64,
    #[serde(deserialize_with = "finite")]
    pub xz: f64,
    #[serde(deserialize_with = "finite")]
    pub yy: f64,
    #[serde(deserialize_with = "finite")]
    pub yz: f64,
    #[serde(deserialize_with = "finite")]
    pub zz: f64,
}

impl KnownPayload {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "known_payload",
        title: "a body of known parameters is part of a link",
        text: "A gripper or test weight that was weighed or comes with its data, mounted during the recording: \
               the link's parameters contain it, so taking it off must leave a body. That bounds the link's \
               mass, centre of mass and inertia from below.",
        condition: "P_link - P_payload is positive semidefinite (P: pseudo-inertia)",
        settings: &[
            ("link", "", "the link that carries it"),
            ("mass", "kg", "its mass"),
            ("com", "m", "its centre of mass in the link frame, (x, y, z)"),
            (
                "inertia",
                "kg m^2",
                "about its own centre of mass in the link's axes, (xx, xy, xz, yy, yz, zz); a point mass when not given",
            ),
        ],
        example: r#"{"known_payload": (link: "1", mass: 1.2, com: (0.0, 0.0, 0.05), inertia: (xx: 2e-3, yy: 2e-3, zz: 1e-3))}"#,
        form: "semidefinite: every engine",
    };

    fn body(&self) -> Result<InertialParameters> {
        let Tensor { xx, xy, xz, yy, yz, zz } = self.inertia;
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        let spread = 0.5 * inertia.trace() - inertia.symmetric_eigenvalues().max();
        if spread < -1e-9 * inertia.trace().abs() {
            let text =
                format!("the payload's inertia breaks the triangle inequality by {:.1e} kg m^2", -spread);
            return Err(Error::new(text).help("check its elements, their signs and units"));
        }
        Ok(InertialParameters::from_barycentric(self.mass, Vector3::from(self.com), inertia))
    }
}

#[typetag::serde(name = "known_payload")]
impl Constraint for KnownPayload {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let link = link_index(robot, &self.link)?;
        let payload = self.body()?.pseudo_inertia();
        let mut lower = space.pseudo_inertia(link);
        for i in 0..4 {
            for j in 0..=i {
                let entry = &mut lower[i * (i + 1) / 2 + j];
                *entry = std::mem::take(entry).plus(-1.0, &Affine::constant(payload[(i, j)]));
            }
        }
        let label = format!("{}: what is left without the payload is a body", space.names[link]);
        Ok(vec![is_body(label, lower)])
    }

    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        Ok(vec![Bound::mass(link_index(robot, &self.link)?, self.mass, f64::INFINITY)])
    }
}
