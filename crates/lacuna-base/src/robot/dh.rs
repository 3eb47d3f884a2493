//! Denavit-Hartenberg tables in RON: `robots/panda.ron` shows every field.
//!
//! The two conventions differ in where the link frame sits, and mixing them up gives a robot that
//! looks almost right; so a table must say which one it means, and which way gravity points.
//!
//! - `Modified` (Craig; Khalil and Kleinfinger): `Rx(alpha) Tx(a) Rz(theta) Tz(d)`, frame `i` lies on
//!   the axis of joint `i`.
//! - `Standard` (Denavit and Hartenberg; Spong): `Rz(theta) Tz(d) Tx(a) Rx(alpha)`, frame `i` lies at
//!   the far end of link `i`, on the axis of joint `i + 1`.

mod table;

use std::collections::HashMap;

use nalgebra::Vector3;

use super::kinematics::{along_x, along_z};
use super::plausibility::{Body, far_for};
use super::{Frame, InertialParameters, Joint, Limits, Link, Pose, Robot};
use crate::error::Result;
use table::{Angles, Convention, FrameRow, Kind, LimitsRow, Located, Parsed, Row, Screw};

pub(super) fn read(text: &str) -> Result<Robot> {
    let Parsed { table, rows, frames } = table::parse(text)?;
    let units = Units { angles: table.angles, convention: table.convention };
    let mut robot = Robot {
        name: table.name.clone().unwrap_or_else(|| "robot".into()),
        gravity: table.gravity(),
        joints: Vec::with_capacity(rows.len()),
        links: Vec::with_capacity(rows.len()),
        order: (0..rows.len()).collect(),
        frames: Vec::new(),
        remarks: Vec::new(),
    };
    for (i, row) in rows.iter().enumerate() {
        robot.joints.push(units.joint(i, &row.value));
        robot.links.push(link(i, &row.value));
    }
    for frame in &frames {
        let pose = units.fixed(&frame.value.screw());
        let link = frame_link(frame, rows.len())?;
        robot.frames.push(Frame { name: frame.value.name.clone(), link, pose });
    }
    check_names(&robot, &rows, &frames)?;
    remark_on_inertias(&mut robot, &rows);
    Ok(robot)
}

/// What a table's numbers mean.
struct Units {
    angles: Angles,
    convention: Convention,
}

impl Units {
    fn radians(&self, angle: f64) -> f64 {
        match self.angles {
            Angles::Radians => angle,
            // The quotient is exact for multiples of a right angle, so that 90 is π/2 to the last bit.
            Angles::Degrees => angle / 180.0 * std::f64::consts::PI,
        }
    }

    fn joint(&self, index: usize, row: &Row) -> Joint {
        let Screw { a, alpha, d, theta } = row.screw();
        let about_x = along_x(self.radians(alpha), a);
        // The joint's own motion is along or about the same z axis, so it may stand anywhere
        // among theta and d; the joint frame of the standard convention is the previous link's.
        let (before, after) = match self.convention {
            Convention::Modified => (about_x.then(&along_z(self.radians(theta), d)), Pose::identity()),
            Convention::Standard => (along_z(self.radians(theta), 0.0), along_z(0.0, d).then(&about_x)),
        };
        Joint {
            name: row.name.clone().unwrap_or_else(|| format!("joint{}", index + 1)),
            kind: row.kind.into(),
            parent: index.checked_sub(1),
            before,
            axis: Vector3::z(),
            after,
            limits: self.limits(row.kind, row.limits.unwrap_or_default()),
        }
    }

    fn fixed(&self, screw: &Screw) -> Pose {
        let about_x = along_x(self.radians(screw.alpha), screw.a);
        let about_z = along_z(self.radians(screw.theta), screw.d);
        match self.convention {
            Convention::Modified => about_x.then(&about_z),
            Convention::Standard => about_z.then(&about_x),
        }
    }

    fn limits(&self, kind: Kind, row: LimitsRow) -> Limits {
        let motion = |x: f64| if kind == Kind::Revolute { self.radians(x) } else { x };
        Limits {
            lower: row.lower.map(motion),
            upper: row.upper.map(motion),
            velocity: row.velocity.map(motion),
            effort: row.effort,
        }
    }
}

fn link(index: usize, row: &Row) -> Link {
    let inertia = row.inertia.map(|i| InertialParameters::from_barycentric(i.mass(), i.com(), i.tensor()));
    Link { name: link_name(index), inertia }
}

fn link_name(index: usize) -> String {
    format!("link{}", index + 1)
}

/// The link a frame is fixed to: the last one unless the row names another; 0 is the base.
fn frame_link(frame: &Located<FrameRow>, links: usize) -> Result<Option<usize>> {
    let number = frame.value.link.unwrap_or(links);
    if number > links {
        let text =
            format!("frame `{}` is fixed to link {number}, but the table has {links}", frame.value.name);
        return Err(frame.error(text).help(format!("write 0 for the base or 1 to {links} for a link")));
    }
    Ok(number.checked_sub(1))
}

/// Joints are chosen by name in data files, frames in scenarios; so names must differ.
fn check_names(robot: &Robot, rows: &[Located<Row>], frames: &[Located<FrameRow>]) -> Result<()> {
    let mut seen = HashMap::new();
    for (joint, row) in robot.joints.iter().zip(rows) {
        if let Some(line) = seen.insert(joint.name.as_str(), row.line) {
            let text = format!("two joints are called `{}`, the other one in line {line}", joint.name);
            return Err(row.error(text).help("give every joint its own name"));
        }
    }
    seen.clear();
    for row in frames {
        if let Some(line) = seen.insert(row.value.name.as_str(), row.line) {
            let text = format!("two frames are called `{}`, the other one in line {line}", row.value.name);
            return Err(row.error(text).help("give every frame its own name"));
        }
    }
    Ok(())
}

fn remark_on_inertias(robot: &mut Robot, rows: &[Located<Row>]) {
    let far = far_for(robot);
    for (row, link) in rows.iter().zip(&robot.links) {
        let Some(i) = row.value.inertia else { continue };
        let body = Body { name: &link.name, mass: i.mass(), com: i.com(), inertia: i.tensor() };
        robot.remarks.extend(body.remark(far, Some(row.line)));
    }
}
