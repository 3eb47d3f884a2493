//! Static poses: gravity torque and inertia matrix read out at rest.

use std::path::Path;

use crate::error::{Error, Result};
use crate::robot::Robot;

/// Read-outs of the gravity torque and the inertia matrix at `rows` configurations (joint by joint).
#[derive(Debug, Clone, PartialEq, Default)]
pub struct StaticPoses {
    /// File name without folder, or where the poses come from.
    pub name: String,
    /// Configurations `q[joint][pose]` [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Gravity torques `g[joint][pose]` [N m, N].
    pub g: Vec<Vec<f64>>,
    /// Lower triangle of the inertia matrix by rows: `m[i * (i + 1) / 2 + j][pose]`, `j <= i`.
    pub m: Vec<Vec<f64>>,
}

impl StaticPoses {
    /// Reads `q1..qn, g1..gn, m11,m21,m22,m31,..,mnn`.
    ///
    /// # Errors
    /// When the file is not such a table; with file, line, column and remedy.
    pub fn open(_path: impl AsRef<Path>, _robot: &Robot) -> Result<Self> {
        Err(Error::new("not here yet"))
    }

    /// Number of poses.
    pub fn rows(&self) -> usize {
        self.q.first().map_or(0, Vec::len)
    }
}
