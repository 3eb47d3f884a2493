//! Shapes that hold a centre of mass, lowered to forms in mass and first moment.
//!
//! With `c = mc / m`, a convex condition on `c` times `m` is a convex condition on `(m, mc)`: a half-space
//! becomes affine, a ball a norm. Margins are reported in metres.

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::LinkSpace;
use super::measure::per_mass;
use super::mesh::Mesh;
use super::number::{direction, not_negative, optional_positive, positive, positive_triple, triple};
use crate::error::{Error, Result};
use crate::form::{Affine, Body, Form};

/// Smallest and largest coordinate along each axis \[m\]; infinite where there is no limit.
pub type Extent = [(f64, f64); 3];

/// A convex region in a link's frame; lengths in metres.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Shape {
    /// Parallel to the link frame's axes.
    Box {
        /// Smallest coordinates.
        #[serde(deserialize_with = "triple")]
        lower: [f64; 3],
        /// Largest coordinates.
        #[serde(deserialize_with = "triple")]
        upper: [f64; 3],
    },
    /// A ball.
    Sphere {
        /// Centre.
        #[serde(deserialize_with = "triple")]
        center: [f64; 3],
        /// Radius.
        #[serde(deserialize_with = "positive")]
        radius: f64,
    },
    /// A cylinder, endless without `height`.
    Cylinder {
        /// Centre, half-way up.
        #[serde(deserialize_with = "triple")]
        center: [f64; 3],
        /// Direction of the axis, of any length.
        #[serde(deserialize_with = "direction")]
        axis: [f64; 3],
        /// Radius.
        #[serde(deserialize_with = "positive")]
        radius: f64,
        /// Height along the axis.
        #[serde(default, deserialize_with = "optional_positive")]
        height: Option<f64>,
    },
    /// A truncated cone; `top_radius: 0.0` makes it pointed.
    Cone {
        /// Centre of the base disc.
        #[serde(deserialize_with = "triple")]
        base: [f64; 3],
        /// From base to top, of any length.
        #[serde(deserialize_with = "direction")]
        axis: [f64; 3],
        /// Radius of the base.
        #[serde(deserialize_with = "not_negative")]
        radius: f64,
        /// Radius of the top.
        #[serde(deserialize_with = "not_negative")]
        top_radius: f64,
        /// Distance from base to top.
        #[serde(deserialize_with = "positive")]
        height: f64,
        /// Whether base and top bound it too; without, only the slanted surface does.
        #[serde(default = "yes")]
        caps: bool,
    },
    /// An ellipsoid.
    Ellipsoid {
        /// Centre.
        #[serde(deserialize_with = "triple")]
        center: [f64; 3],
        /// Half-lengths along its own axes.
        #[serde(deserialize_with = "positive_triple")]
        semi_axes: [f64; 3],
        /// Roll, pitch, yaw of its axes about the fixed link axes \[rad\], as in URDF.
        #[serde(default, deserialize_with = "triple")]
        rpy: [f64; 3],
    },
    /// The convex hull of a mesh.
    Hull {
        /// The mesh and where it sits.
        mesh: Mesh,
    },
}

pub(super) fn yes() -> bool {
    true
}

/// One surface of a shape: `bound m - |rows| >= 0`, or `bound` alone.
pub(super) struct Surface {
    pub label: String,
    /// Length that its margin is compared with \[m\].
    pub scale: f64,
    /// Rows and bound as `(direction, offset)`: `direction . mc + offset m`.
    pub rows: Vec<(Vector3<f64>, f64)>,
    pub bound: (Vector3<f64>, f64),
}

impl Surface {
    /// `normal . c <= offset`.
    pub fn plane(label: String, scale: f64, normal: Vector3<f64>, offset: f64) -> Self {
        Self { label, scale, rows: Vec::new(), bound: (-normal, offset) }
    }

    /// The form on a link, reported in metres.
    fn form(&self, space: &LinkSpace, link: usize) -> Form {
        let lower = |(direction, offset): &(Vector3<f64>, f64)| {
            let nonzero = (0..3).filter(|&axis| direction[axis].abs() > 0.0);
            let sum = nonzero.fold(Affine::default(), |sum, axis| {
                sum.plus(direction[axis], &space.first_moment(link, axis))
            });
            if offset.abs() > 0.0 { sum.plus(*offset, &space.mass(link)) } else { sum }
        };
        let bound = lower(&self.bound);
        let body = if self.rows.is_empty() {
            Body::Affine(bound)
        } else {
            Body::Norm { rows: self.rows.iter().map(lower).collect(), bound }
        };
        let label = format!("{}: centre of mass {}", space.names[link], self.label);
        per_mass(Form::new(label, "m", self.scale, body), space.mass(link))
    }
}

impl Shape {
    /// The forms that keep the centre of mass of `link` inside.
    ///
    /// # Errors
    /// When the shape is empty or its mesh was not loaded.
    pub fn forms(&self, space: &LinkSpace, link: usize) -> Result<Vec<Form>> {
        Ok(self.surfaces()?.iter().map(|surface| surface.form(space, link)).collect())
    }

    fn surfaces(&self) -> Result<Vec<Surface>> {
        match self {
            Self::Box { lower, upper } => {
                if let Some(axis) = (0..3).find(|&axis| lower[axis] > upper[axis]) {
                    let (lower, upper, axis) = (lower[axis], upper[axis], ["x", "y", "z"][axis]);
                    let text =
                        format!("the box is empty: in {axis}, lower {lower} m is above upper {upper} m");
                    return Err(Error::new(text).help("swap them"));
                }
                Ok(box_planes(&std::array::from_fn(|axis| (lower[axis], upper[axis]))))
            }
            Self::Sphere { center, radius } => Ok(vec![Surface {
                label: format!("within {radius} m of {}", point(center)),
                scale: *radius,
                rows: (0..3).map(|axis| (unit(axis), -center[axis])).collect(),
                bound: (Vector3::zeros(), *radius),
            }]),
            Self::Cylinder { center, axis, radius, height } => Ok(cylinder(center, axis, *radius, *height)),
            Self::Cone { base, axis, radius, top_radius, height, caps } => {
                cone(base, axis, [*radius, *top_radius], *height, *caps)
            }
            Self::Ellipsoid { center, semi_axes, rpy } => Ok(vec![ellipsoid(center, semi_axes, rpy)]),
            Self::Hull { mesh } => mesh.planes(),
        }
    }

    /// The smallest box around it, parallel to the link's axes.
    ///
    /// # Errors
    /// When its mesh was not loaded.
    pub fn extent(&self) -> Result<Extent> {
        Ok(match self {
            Self::Box { lower, upper } => std::array::from_fn(|i| (lower[i], upper[i])),
            Self::Sphere { center, radius } => around(center, [*radius; 3]),
            Self::Cylinder { center, axis, radius, height } => {
                let a = Vector3::from(*axis).normalize();
                let half = height.map_or(f64::INFINITY, |h| 0.5 * h);
                let along = |i: usize| if a[i].abs() > 0.0 { half * a[i].abs() } else { 0.0 };
                around(center, std::array::from_fn(|i| along(i) + radius * across(&a, i)))
            }
            Self::Cone { caps: false, .. } => [(f64::NEG_INFINITY, f64::INFINITY); 3],
            Self::Cone { base, axis, radius, top_radius, height, .. } => {
                let a = Vector3::from(*axis).normalize();
                let top = Vector3::from(*base) + a * *height;
                let disc = |c: &[f64; 3], r: f64| around(c, std::array::from_fn(|i| r * across(&a, i)));
                hull_of(&disc(base, *radius), &disc(&top.into(), *top_radius))
            }
            Self::Ellipsoid { center, semi_axes, rpy } => {
                let r = rotation(rpy);
                let reach = |i: usize| (0..3).map(|k| (r[(i, k)] * semi_axes[k]).powi(2)).sum::<f64>().sqrt();
                around(center, std::array::from_fn(reach))
            }
            Self::Hull { mesh } => mesh.extent()?,
        })
    }
}

/// The two boxes' common box.
pub(super) fn hull_of(a: &Extent, b: &Extent) -> Extent {
    std::array::from_fn(|i| (a[i].0.min(b[i].0), a[i].1.max(b[i].1)))
}

fn around(center: &[f64; 3], reach: [f64; 3]) -> Extent {
    std::array::from_fn(|i| (center[i] - reach[i], center[i] + reach[i]))
}

/// How far a unit disc with unit normal `a` reaches along axis `i`.
fn across(a: &Vector3<f64>, i: usize) -> f64 {
    (1.0 - a[i] * a[i]).max(0.0).sqrt()
}

fn unit(axis: usize) -> Vector3<f64> {
    Vector3::ith(axis, 1.0)
}

fn point(x: &[f64; 3]) -> String {
    format!("({}, {}, {})", x[0], x[1], x[2])
}

/// The finite sides of a box.
pub(super) fn box_planes(extent: &Extent) -> Vec<Surface> {
    let mut planes = Vec::new();
    for (axis, name) in ["x", "y", "z"].iter().enumerate() {
        let (lower, upper) = extent[axis];
        if lower.is_finite() {
            planes.push(Surface::plane(format!("{name} >= {lower} m"), lower, -unit(axis), -lower));
        }
        if upper.is_finite() {
            planes.push(Surface::plane(format!("{name} <= {upper} m"), upper, unit(axis), upper));
        }
    }
    planes
}

/// The forms of a box on a link, without a shape around them.
pub(super) fn box_forms(extent: &Extent, space: &LinkSpace, link: usize) -> Vec<Form> {
    box_planes(extent).iter().map(|plane| plane.form(space, link)).collect()
}

/// Two unit vectors across a unit vector.
fn frame_of(a: &Vector3<f64>) -> [Vector3<f64>; 2] {
    let u = a.cross(&unit(a.iamin())).normalize();
    [u, a.cross(&u)]
}

/// The offset from an axis through `origin`, as rows.
fn off_axis(a: &Vector3<f64>, origin: &Vector3<f64>) -> Vec<(Vector3<f64>, f64)> {
    frame_of(a).iter().map(|u| (*u, -u.dot(origin))).collect()
}

fn cylinder(center: &[f64; 3], axis: &[f64; 3], radius: f64, height: Option<f64>) -> Vec<Surface> {
    let (a, c) = (Vector3::from(*axis).normalize(), Vector3::from(*center));
    let mut surfaces = vec![Surface {
        label: format!("within {radius} m of the axis through {}", point(center)),
        scale: radius,
        rows: off_axis(&a, &c),
        bound: (Vector3::zeros(), radius),
    }];
    if let Some(height) = height {
        let (half, middle) = (0.5 * height, a.dot(&c));
        surfaces.push(Surface::plane("below the cylinder's top".into(), half, a, middle + half));
        surfaces.push(Surface::plane("above the cylinder's bottom".into(), half, -a, half - middle));
    }
    surfaces
}

fn cone(
    base: &[f64; 3],
    axis: &[f64; 3],
    [radius, top]: [f64; 2],
    height: f64,
    caps: bool,
) -> Result<Vec<Surface>> {
    if radius.max(top) <= 0.0 {
        return Err(Error::new("the cone has no radius at either end").help("give one of them a radius"));
    }
    let (a, b) = (Vector3::from(*axis).normalize(), Vector3::from(*base));
    let slope = (top - radius) / height;
    let start = a.dot(&b);
    let mut surfaces = vec![Surface {
        label: format!("inside the cone from {radius} m to {top} m"),
        scale: radius.max(top),
        rows: off_axis(&a, &b),
        bound: (a * slope, radius - slope * start),
    }];
    if caps {
        surfaces.push(Surface::plane("above the cone's base".into(), 0.0, -a, -start));
        surfaces.push(Surface::plane("below the cone's top".into(), height, a, start + height));
    }
    Ok(surfaces)
}

/// `|D (c - center)| <= least` with `D = least / semi_axes` along the ellipsoid's own axes: the margin is in
/// metres and never more than the distance to the surface.
fn ellipsoid(center: &[f64; 3], semi_axes: &[f64; 3], rpy: &[f64; 3]) -> Surface {
    let (r, c) = (rotation(rpy), Vector3::from(*center));
    let least = semi_axes.iter().copied().fold(f64::INFINITY, f64::min);
    let row = |k: usize| {
        let direction = r.column(k) * (least / semi_axes[k]);
        (direction, -direction.dot(&c))
    };
    Surface {
        label: format!("inside the ellipsoid about {}", point(center)),
        scale: least,
        rows: (0..3).map(row).collect(),
        bound: (Vector3::zeros(), least),
    }
}

/// `Rz(yaw) Ry(pitch) Rx(roll)`, as in URDF.
pub(super) fn rotation(rpy: &[f64; 3]) -> Matrix3<f64> {
    let [(sr, cr), (sp, cp), (sy, cy)] = rpy.map(|angle| (libm::sin(angle), libm::cos(angle)));
    let x = Matrix3::new(1.0, 0.0, 0.0, 0.0, cr, -sr, 0.0, sr, cr);
    let y = Matrix3::new(cp, 0.0, sp, 0.0, 1.0, 0.0, -sp, 0.0, cp);
    let z = Matrix3::new(cy, -sy, 0.0, sy, cy, 0.0, 0.0, 0.0, 1.0);
    z * y * x
}
