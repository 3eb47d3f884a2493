//! Are the inertias of a robot file physically possible? Public files often are not.

use nalgebra::{Matrix3, Vector3};

use super::{JointKind, Remark, Robot};

/// Share of the trace by which a principal moment may miss the triangle inequality: published
/// numbers are rounded, and a flat or rod-like body lies right on the border.
const ROUNDING: f64 = 1e-6;

/// Shortest distance \[m\] that counts as far, however small the robot is (think of a hand).
const SMALLEST_FAR: f64 = 0.5;

/// Radius of gyration \[m\] below which a body with mass is practically a point.
const POINT: f64 = 1e-4;

/// One `<inertial>` element or table row as written, in the axes of its own link frame.
pub(super) struct Body<'a> {
    pub name: &'a str,
    pub mass: f64,
    pub com: Vector3<f64>,
    /// About the centre of mass.
    pub inertia: Matrix3<f64>,
}

/// One remark for each moving link whose inertia, fixed attachments included, cannot be that of a
/// real body or is absurd for a robot of this size.
///
/// Readers of robot files have done the same for every single part of the file, with its line, and
/// left the result in [`Robot::remarks`]; this is for robots from elsewhere.
pub fn implausible_inertias(robot: &Robot) -> Vec<Remark> {
    let far = far_for(robot);
    let doubts_about = |link: &super::Link| {
        let inertia = link.inertia?;
        let body = Body {
            name: &link.name,
            mass: inertia.mass(),
            com: inertia.center_of_mass().unwrap_or_default(),
            inertia: inertia.inertia_at_center_of_mass().unwrap_or(inertia.inertia_at_origin()),
        };
        body.remark(far, None)
    };
    robot.links.iter().filter_map(doubts_about).collect()
}

/// A distance \[m\] that nothing on one link of this robot should exceed: twice its longest link.
pub(super) fn far_for(robot: &Robot) -> f64 {
    let reach = |joint: &super::Joint| {
        let travel = [joint.limits.lower, joint.limits.upper]
            .into_iter()
            .flatten()
            .fold(0.0, |a: f64, x| a.max(x.abs()));
        let travel = if joint.kind == JointKind::Prismatic { travel } else { 0.0 };
        joint.before.translation.norm() + joint.after.translation.norm() + travel
    };
    let joints = robot.joints.iter().map(reach);
    let frames = robot.frames.iter().map(|frame| frame.pose.translation.norm());
    let longest = joints.chain(frames).fold(0.0, f64::max);
    (2.0 * longest).max(SMALLEST_FAR)
}

impl Body<'_> {
    /// What is odd about this body, if anything.
    pub(super) fn remark(&self, far: f64, line: Option<usize>) -> Option<Remark> {
        let mut doubts = Vec::new();
        doubts.extend(self.mass_doubt());
        doubts.extend(self.inertia_doubt());
        doubts.extend(self.size_doubt(far));
        let text = || format!("link `{}`: {}", self.name, doubts.join("; "));
        (!doubts.is_empty()).then(|| Remark { line, text: text() })
    }

    fn mass_doubt(&self) -> Option<String> {
        if self.mass < 0.0 {
            Some(format!("its mass is {} kg, and no body has negative mass", self.mass))
        } else if self.mass <= 0.0 && self.inertia.amax() > 0.0 {
            Some("it has inertia but no mass".into())
        } else {
            None
        }
    }

    fn inertia_doubt(&self) -> Option<String> {
        if self.inertia == Matrix3::identity() {
            return Some(
                "its inertia is the default 1 0 0 1 0 1 kg m² of many exporters, not a computed one".into(),
            );
        }
        let mut principal: [f64; 3] = self.inertia.symmetric_eigenvalues().into();
        principal.sort_by(f64::total_cmp);
        let [small, middle, large] = principal;
        let slack = ROUNDING * self.inertia.trace().abs();
        let moments = format!("principal moments {small:.3e}, {middle:.3e}, {large:.3e} kg m²");
        if small < -slack {
            Some(format!("its inertia is not positive definite ({moments})"))
        } else if small + middle < large - slack {
            Some(format!("its inertia breaks the triangle inequality ({moments})"))
        } else {
            None
        }
    }

    fn size_doubt(&self, far: f64) -> Option<String> {
        if self.mass <= 0.0 {
            return None;
        }
        let distance = self.com.norm();
        if distance > far {
            return Some(format!(
                "its centre of mass is {distance:.3} m off the link frame, far outside the robot"
            ));
        }
        let gyration = (0.5 * self.inertia.trace().max(0.0) / self.mass).sqrt();
        if gyration > far {
            Some(format!("its radius of gyration is {gyration:.3} m: mass and inertia do not fit together"))
        } else if gyration < POINT {
            Some(format!(
                "its radius of gyration is {gyration:.1e} m: a point mass, or inertia in wrong units"
            ))
        } else {
            None
        }
    }
}
