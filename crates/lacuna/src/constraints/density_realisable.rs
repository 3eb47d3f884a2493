use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::measure::is_body;
use super::number::{positive_triple, triple};
use super::shape::rotation;
use super::{About, Bound, Constraint, LinkSpace, Links, Shape, within};
use crate::error::Result;
use crate::form::{Affine, Form};
use crate::robot::Robot;

/// The link is a body with non-negative density inside an ellipsoid (Wensing, Kim and Slotine 2018).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct DensityRealisable {
    /// Links it holds for; coordinates are in each link's own frame.
    pub links: Links,
    /// Centre of the ellipsoid \[m\].
    #[serde(deserialize_with = "triple")]
    pub center: [f64; 3],
    /// Half-lengths along its own axes \[m\].
    #[serde(deserialize_with = "positive_triple")]
    pub semi_axes: [f64; 3],
    /// Roll, pitch, yaw of its axes about the fixed link axes \[rad\].
    #[serde(default, deserialize_with = "triple")]
    pub rpy: [f64; 3],
}

impl DensityRealisable {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "density_realisable",
        title: "a density inside a bounding ellipsoid gives the parameters",
        text: "The strongest convex statement about a link of known size: there is a body with non-negative \
               density inside the ellipsoid that has exactly this mass, centre of mass and inertia. It bounds \
               the inertia from above, which a centre of mass in a shape does not. Take the smallest ellipsoid \
               around the link's mesh.",
        condition: "tr(P Q) >= 0 with P the pseudo-inertia, (x - center)^T A (x - center) <= 1 the ellipsoid and \
                    Q = [[-A, A center], [.., 1 - center^T A center]]; and P is positive semidefinite",
        settings: &[
            ("links", "", "links it holds for: All, or Only([\"name\", ..])"),
            ("center", "m", "centre, (x, y, z)"),
            ("semi_axes", "m", "half-lengths along its own axes"),
            ("rpy", "rad", "roll, pitch, yaw of its axes, as in URDF; none when not given"),
        ],
        example: r#"{"density_realisable": (links: Only(["1"]), center: (0.0, 0.0, 0.1), semi_axes: (0.15, 0.15, 0.3))}"#,
        form: "affine and semidefinite: every engine",
    };

    /// `tr(P Q)`: the density's integral of `1 - (x - center)ᵀ A (x - center)` \[kg\].
    fn trace(&self, p: &[Affine]) -> Affine {
        let r = rotation(&self.rpy);
        let squares = Matrix3::from_diagonal(&Vector3::from(self.semi_axes.map(|s| 1.0 / (s * s))));
        let (a, c) = (r * squares * r.transpose(), Vector3::from(self.center));
        let towards = a * c;
        let mut sum = p[9].clone().times(1.0 - c.dot(&towards));
        for i in 0..3 {
            sum = sum.plus(2.0 * towards[i], &p[6 + i]);
            for j in 0..=i {
                let twice = if i == j { 1.0 } else { 2.0 };
                sum = sum.plus(-twice * a[(i, j)], &p[i * (i + 1) / 2 + j]);
            }
        }
        sum
    }
}

#[typetag::serde(name = "density_realisable")]
impl Constraint for DensityRealisable {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let forms = |link: usize| {
            let (name, p) = (&space.names[link], space.pseudo_inertia(link));
            let size = Form::affine(format!("{name}: fits into its ellipsoid"), "kg", 0.0, self.trace(&p));
            [size, is_body(format!("{name}: density is not negative"), p)]
        };
        Ok(self.links.indices(robot)?.into_iter().flat_map(forms).collect())
    }

    fn bounds(&self, robot: &Robot, _space: &LinkSpace) -> Result<Vec<Bound>> {
        let (center, semi_axes, rpy) = (self.center, self.semi_axes, self.rpy);
        within(&self.links, &Shape::Ellipsoid { center, semi_axes, rpy }.extent()?, robot)
    }
}
