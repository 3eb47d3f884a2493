//! Meshes that hold a centre of mass.

use std::path::{Path, PathBuf};

use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

use super::hull::{HalfSpace, convex_hull, size};
use super::number::{positive, triple};
use super::shape::{Extent, Surface, rotation};
use super::stl;
use crate::error::{Error, Result};
use crate::text::bounds::Faces;
use crate::text::files;

/// Largest mesh that is read [bytes].
const LARGEST: u64 = 64 << 20;

/// An STL mesh in a link's frame, used through its convex hull.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Mesh {
    /// STL file, ASCII or binary, relative to the scenario.
    pub path: PathBuf,
    /// Metres per unit of the file: 0.001 for a mesh in millimetres.
    #[serde(default = "one", deserialize_with = "positive")]
    pub scale: f64,
    /// Origin of the mesh in the link frame \[m\], as in a URDF's `<origin xyz=..>`.
    #[serde(default, deserialize_with = "triple")]
    pub xyz: [f64; 3],
    /// Roll, pitch, yaw of the mesh in the link frame \[rad\], as in a URDF's `<origin rpy=..>`.
    #[serde(default, deserialize_with = "triple")]
    pub rpy: [f64; 3],
    /// Most faces of the hull to use, at least 6. A hull with more is replaced by its largest ones and a box
    /// around it, which is slightly larger than the hull.
    #[serde(default = "two_hundred", deserialize_with = "Faces::read")]
    pub faces: usize,
    #[serde(skip)]
    loaded: Option<Loaded>,
}

/// The hull in the link frame.
#[derive(Debug, Clone, PartialEq)]
struct Loaded {
    planes: Vec<HalfSpace>,
    faces: usize,
    size: f64,
    extent: Extent,
}

fn one() -> f64 {
    1.0
}

fn two_hundred() -> usize {
    200
}

impl Mesh {
    /// A mesh in metres in the link frame itself; to be loaded before it is used.
    pub fn new(path: impl Into<PathBuf>) -> Self {
        Self {
            path: path.into(),
            scale: one(),
            xyz: [0.0; 3],
            rpy: [0.0; 3],
            faces: two_hundred(),
            loaded: None,
        }
    }

    /// Reads the file and builds the hull.
    ///
    /// # Errors
    /// When the file leaves the scenario's repository, is no STL, or is flat.
    pub fn load(&mut self, folder: &Path) -> Result<()> {
        let file = files::inside(folder, &self.path)?;
        self.loaded = Some(self.build(&file).map_err(|e| e.in_file(&self.path))?);
        Ok(())
    }

    fn build(&self, file: &Path) -> Result<Loaded> {
        let trouble = |e: std::io::Error| Error::new(format!("cannot read the mesh: {e}"));
        let length = std::fs::metadata(file).map_err(trouble)?.len();
        if length > LARGEST {
            return Err(Error::new(format!("the mesh has {length} bytes, more than {LARGEST}"))
                .help("use the collision mesh, or one with fewer triangles"));
        }
        if self.faces < 6 {
            return Err(Error::new(format!("`faces: {}` is too few", self.faces)).help("6 make a box"));
        }
        let mut corners = stl::corners(&std::fs::read(file).map_err(trouble)?)?;
        corners.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)).then(a.z.total_cmp(&b.z)));
        corners.dedup();
        let (turn, shift) = (rotation(&self.rpy), Vector3::from(self.xyz));
        let points: Vec<_> = corners.iter().map(|x| turn * (x * self.scale) + shift).collect();
        self.around(&points)
    }

    fn around(&self, points: &[Vector3<f64>]) -> Result<Loaded> {
        let mut planes = convex_hull(points).map_err(|why| {
            Error::new(format!("the mesh cannot hold a centre of mass: {why}"))
                .help("use the mesh of a solid part")
        })?;
        let coordinate = |axis: usize| points.iter().map(move |p| p[axis]);
        let extent: Extent = std::array::from_fn(|axis| {
            let low = coordinate(axis).fold(f64::INFINITY, f64::min);
            (low, coordinate(axis).fold(f64::NEG_INFINITY, f64::max))
        });
        let faces = planes.len();
        if faces > self.faces {
            planes.truncate(self.faces - 6);
            for (axis, (low, high)) in extent.iter().enumerate() {
                let normal = Vector3::ith(axis, 1.0);
                planes.push(HalfSpace { normal, offset: *high });
                planes.push(HalfSpace { normal: -normal, offset: -low });
            }
        }
        Ok(Loaded { planes, faces, size: size(points), extent })
    }

    fn loaded(&self) -> Result<&Loaded> {
        self.loaded.as_ref().ok_or_else(|| {
            Error::new("the mesh was not loaded")
                .in_file(&self.path)
                .help("call `load` with the scenario's folder before asking for forms")
        })
    }

    /// The planes of the hull, compared with half its size.
    pub(super) fn planes(&self) -> Result<Vec<Surface>> {
        let loaded = self.loaded()?;
        let name = self.path.display();
        let all = loaded.planes.len();
        let kind = if loaded.faces > all { "largest face" } else { "face" };
        let plane = |(i, h): (usize, &HalfSpace)| {
            let label = format!("inside the hull of {name}, {kind} {} of {}", i + 1, loaded.faces.max(all));
            Surface::plane(label, 0.5 * loaded.size, h.normal, h.offset)
        };
        Ok(loaded.planes.iter().enumerate().map(plane).collect())
    }

    pub(super) fn extent(&self) -> Result<Extent> {
        Ok(self.loaded()?.extent)
    }
}
