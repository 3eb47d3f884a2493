//! Robots: a tree of links moved by revolute and prismatic joints, whatever file described them.
//!
//! Every joint moves exactly one link, so joint `i` and link `i` share an index; the order is that
//! of the movable joints in the file. The link frame is the file's own: the URDF link frame, or the
//! Denavit-Hartenberg frame `i` (which in the standard convention sits at the *far* end of the link).

mod dh;
mod inertia;
mod kinematics;
mod plausibility;
mod prior;
pub mod samples;
mod urdf;

pub use inertia::{InertialParameters, PARAMETER_NAMES, PARAMETER_UNITS};
pub use plausibility::implausible_inertias;
pub use urdf::with_document as with_urdf_document;

use nalgebra::{Matrix3, Vector3};
use std::path::Path;

use crate::error::{Error, Result};

/// Number of inertial parameters of one link.
pub const PARAMETERS_PER_LINK: usize = 10;

/// Numbers of a robot file beyond this are refused: they are not meant, and their products overflow.
const LARGEST_NUMBER: f64 = 1e12;

/// How a joint moves.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation \[rad\]; URDF `revolute` and `continuous`.
    Revolute,
    /// Translation \[m\].
    Prismatic,
}

/// Limits of a joint, where the file gives them.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Limits {
    /// Smallest position [rad or m].
    pub lower: Option<f64>,
    /// Largest position [rad or m].
    pub upper: Option<f64>,
    /// Largest speed [rad/s or m/s].
    pub velocity: Option<f64>,
    /// Largest torque or force [N m or N].
    pub effort: Option<f64>,
}

/// A rigid transformation: a point `x` of the child frame is `rotation * x + translation` in the parent.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Pose {
    /// Orientation of the child frame in the parent frame.
    pub rotation: Matrix3<f64>,
    /// Origin of the child frame in the parent frame \[m\].
    pub translation: Vector3<f64>,
}

impl Pose {
    /// No motion at all.
    pub fn identity() -> Self {
        Self { rotation: Matrix3::identity(), translation: Vector3::zeros() }
    }

    /// This pose followed by `next` (given in this pose's child frame).
    #[must_use]
    pub fn then(&self, next: &Pose) -> Pose {
        Pose {
            rotation: self.rotation * next.rotation,
            translation: self.rotation * next.translation + self.translation,
        }
    }

    /// The way back.
    #[must_use]
    pub fn inverse(&self) -> Pose {
        let rotation = self.rotation.transpose();
        Pose { rotation, translation: -(rotation * self.translation) }
    }
}

/// A movable joint and where it sits: parent link frame -> `before` -> motion along or about
/// `axis` -> `after` -> link frame.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// Name in the file, or `joint1`, `joint2`, ...
    pub name: String,
    /// Rotation or translation.
    pub kind: JointKind,
    /// Index of the link it is mounted on; `None` is the fixed base.
    pub parent: Option<usize>,
    /// From the parent link frame to the joint frame at zero position.
    pub before: Pose,
    /// Unit axis in the joint frame.
    pub axis: Vector3<f64>,
    /// From the moved joint frame to the link frame (identity but for standard Denavit-Hartenberg).
    pub after: Pose,
    /// Limits, where known.
    pub limits: Limits,
}

/// A moving body: all links of the file that no movable joint separates.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// Name of the link that the joint moves.
    pub name: String,
    /// Inertial parameters about the link frame, fixed attachments included; `None` when the file has none.
    pub inertia: Option<InertialParameters>,
}

/// A named frame of the file that is fixed to a link: the frames that merging would otherwise lose.
#[derive(Debug, Clone, PartialEq)]
pub struct Frame {
    /// Name of the link (or flange) in the file.
    pub name: String,
    /// The moving link it is fixed to; `None` is the base.
    pub link: Option<usize>,
    /// Its pose in that link's frame (in the base frame for `None`).
    pub pose: Pose,
}

/// A remark about a robot file that does not stop the work, with the line it is about.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Remark {
    /// Line in the file, where there is one.
    pub line: Option<usize>,
    /// What to know.
    pub text: String,
}

/// A fixed-base robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Robot {
    /// Name in the file.
    pub name: String,
    /// Gravity in the base frame [m/s²].
    pub gravity: Vector3<f64>,
    /// Movable joints in document order.
    pub joints: Vec<Joint>,
    /// `links[i]` is moved by `joints[i]`.
    pub links: Vec<Link>,
    /// Joint indices from the base outwards: every parent stands before its children.
    pub order: Vec<usize>,
    /// Frames kept by name.
    pub frames: Vec<Frame>,
    /// What was ignored or looks odd.
    pub remarks: Vec<Remark>,
}

impl Robot {
    /// Reads a robot file: `.ron` is a Denavit-Hartenberg table, anything else is URDF.
    ///
    /// # Errors
    /// When the file cannot be read or is not a robot; with file, line and column.
    pub fn open(path: impl AsRef<Path>) -> Result<Self> {
        let path = path.as_ref();
        let text = crate::text::read(path)?;
        let is_table = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("ron"));
        let robot = if is_table { Self::from_dh(&text) } else { Self::from_urdf(&text) };
        robot.map_err(|e| e.in_file(path))
    }

    /// Reads a Denavit-Hartenberg table in RON; `robots/panda.ron` shows one.
    ///
    /// A table has `convention` (`Modified`: `Rx(alpha) Tx(a) Rz(theta) Tz(d)`, link frame on the
    /// joint's own axis; `Standard`: `Rz(theta) Tz(d) Tx(a) Rx(alpha)`, link frame at the far end),
    /// `gravity` [m/s², base frame], `rows`, and optionally `name`, `angles` (`Radians` or `Degrees`,
    /// for every angle in the file) and `frames` fixed to a link (the last one, or `link: 3`; 0 is the
    /// base). A row has `a`, `d` \[m\], `alpha`, `theta`, and optionally `name`, `kind` (`Revolute` or
    /// `Prismatic`), `limits` and `inertia`: `mass` \[kg\], `com` \[m\] and `tensor` about it [kg m²], in
    /// the link frame. The joint moves `theta`, or `d` when prismatic; the value written is its offset.
    ///
    /// # Errors
    /// When the text is not such a table; the error has line and column but no file name.
    pub fn from_dh(text: &str) -> Result<Self> {
        dh::read(text)
    }

    /// Reads a URDF: a tree on a fixed base, with revolute, continuous, prismatic and fixed joints.
    ///
    /// Links on fixed joints are merged into the link that carries them, and kept as [`Frame`]s; the
    /// root link is the base frame, and gravity 9.81 m/s² along its -z. Inertia, joints and limits are
    /// read, everything else is left alone. Infinite limits are none, as is every position limit of a
    /// `continuous` joint.
    ///
    /// # Errors
    /// When the text is not a usable URDF; the error has line and column but no file name.
    pub fn from_urdf(text: &str) -> Result<Self> {
        urdf::read(text)
    }

    /// The same robot under another gravity [m/s², base frame].
    #[must_use]
    pub fn with_gravity(mut self, gravity: Vector3<f64>) -> Self {
        self.gravity = gravity;
        self
    }

    /// Number of movable joints.
    pub fn dof(&self) -> usize {
        self.joints.len()
    }

    /// Index of the joint called `name`, or numbered so (`"3"` is the third).
    pub fn joint_index(&self, name: &str) -> Option<usize> {
        let by_name = self.joints.iter().position(|j| j.name == name);
        by_name.or_else(|| name.parse::<usize>().ok()?.checked_sub(1).filter(|&i| i < self.dof()))
    }

    /// The joints between the base and link `i`, `i` included, outermost first.
    pub fn path_to_base(&self, i: usize) -> impl Iterator<Item = usize> + '_ {
        std::iter::successors(Some(i), |&k| self.joints[k].parent)
    }

    /// Stacked inertial parameters of all links (10 each, link by link).
    ///
    /// # Errors
    /// When a link has none.
    pub fn inertial_parameters(&self) -> Result<Vec<f64>> {
        let mut all = Vec::with_capacity(PARAMETERS_PER_LINK * self.dof());
        for link in &self.links {
            let Some(inertia) = &link.inertia else {
                return Err(Error::new(format!("link `{}` has no inertia in the robot file", link.name))
                    .help("add mass, centre of mass and inertia to the file, or identify them from a log"));
            };
            all.extend_from_slice(inertia.as_slice());
        }
        Ok(all)
    }

    /// Stacked inertial parameters of all links, where a link without any counts as massless: what
    /// the URDF specification says about a link without `<inertial>`.
    pub fn inertial_parameters_or_zero(&self) -> Vec<f64> {
        self.links.iter().flat_map(|link| link.inertia.unwrap_or(InertialParameters::ZERO).0).collect()
    }
}
