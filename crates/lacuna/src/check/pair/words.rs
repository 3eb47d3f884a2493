//! Findings in words, and the column map that puts them right.

use super::reading::{Change, Reading, Signed};
use super::velocity::Kinematics;
use crate::log::{Log, TimeUnit};
use crate::robot::Robot;

/// Names a joint: by number, and by name where that says more.
pub(super) fn joint(robot: &Robot, j: usize) -> String {
    let name = &robot.joints[j].name;
    let number = j + 1;
    if *name == format!("joint{number}") {
        format!("joint {number}")
    } else {
        format!("joint {number} `{name}`")
    }
}

/// Kind and sentence of a change, and the joints it is about.
pub(super) fn change(
    robot: &Robot,
    change: &Change,
    kinematics: &Kinematics,
) -> (&'static str, String, Vec<usize>) {
    let of = |j: &usize| joint(robot, *j);
    let has_velocity = kinematics.log.dq.is_some();
    let and_velocity = if has_velocity { "position and velocity" } else { "position" };
    match change {
        Change::Degrees => {
            let what = if has_velocity { "positions and velocities are" } else { "positions are" };
            ("position_unit", format!("{what} in degrees, not in radians"), vec![])
        }
        Change::FlipTorques(joints) => {
            let names: Vec<String> = joints.iter().map(of).collect();
            let text = format!("{}: torque has the wrong sign", names.join(", "));
            ("torque_sign", text, joints.clone())
        }
        Change::FlipPosition(j) => {
            // Where velocity and position disagreed, the velocity was right.
            let what = if kinematics.velocity[*j].sign < 0.0 { "position" } else { and_velocity };
            ("position_sign", format!("{}: {what} with the wrong sign", of(j)), vec![*j])
        }
        Change::FlipJoint(j) => {
            let text = format!("{}: {and_velocity} and torque with the wrong sign (axis turned)", of(j));
            ("joint_sign", text, vec![*j])
        }
        Change::SwapJoints(a, b) => {
            ("joint_order", format!("{} and {} stand in each other's columns", of(a), of(b)), vec![*a, *b])
        }
        Change::SwapPositions(a, b) => {
            let text = format!("{and_velocity} of {} and {} are exchanged", of(a), of(b));
            ("position_order", text, vec![*a, *b])
        }
        Change::SwapTorques(a, b) => {
            ("torque_order", format!("torques of {} and {} are exchanged", of(a), of(b)), vec![*a, *b])
        }
        Change::ReverseJoints | Change::ReversePositions | Change::ReverseTorques => {
            reversed(change, and_velocity)
        }
        Change::Gravity(g) => ("mounting", mounting(robot, g), vec![]),
        Change::NoGravity => ("no_gravity", "the torque has no gravity in it".into(), vec![]),
        Change::Convention => {
            let text = "the Denavit-Hartenberg table is meant in the other convention".to_string();
            ("convention", text, vec![])
        }
    }
}

fn reversed(change: &Change, and_velocity: &str) -> (&'static str, String, Vec<usize>) {
    let (kind, what) = match change {
        Change::ReversePositions => ("position_order", format!("{and_velocity} of the joints")),
        Change::ReverseTorques => ("torque_order", "torques of the joints".into()),
        _ => ("joint_order", "the joints".into()),
    };
    (kind, format!("{what} stand in reversed order"), vec![])
}

fn mounting(robot: &Robot, g: &nalgebra::Vector3<f64>) -> String {
    let direction = |g: &nalgebra::Vector3<f64>| {
        let u = g.normalize();
        let axes = ["x", "y", "z"];
        match (0..3).find(|&i| u[i].abs() > 0.9999) {
            Some(i) => format!("{}{}", if u[i] > 0.0 { "+" } else { "-" }, axes[i]),
            None => format!("({:.2}, {:.2}, {:.2})", u.x, u.y, u.z),
        }
    };
    let angle = libm::acos(g.normalize().dot(&robot.gravity.normalize()).clamp(-1.0, 1.0)).to_degrees();
    format!(
        "gravity points along {} of the base, not {}: mounted {angle:.0} degrees off",
        direction(g),
        direction(&robot.gravity)
    )
}

/// What to do about a change.
pub(super) fn remedy(change: &Change) -> String {
    match change {
        Change::Gravity(g) => {
            // Whole zeros, not -0.000.
            let [x, y, z] = [g.x, g.y, g.z].map(|c| if c.abs() < 5e-4 { 0.0 } else { c });
            format!("pass --gravity {x:.3},{y:.3},{z:.3} (in a scenario `gravity: ({x:.3}, {y:.3}, {z:.3})`)")
        }
        Change::NoGravity => "log the measured torque with gravity in it; or identify with --gravity 0,0,0, \
                              which leaves the gravity parameters unknown"
            .to_string(),
        Change::Convention => {
            "write the other one of `convention: Modified` and `convention: Standard` in the robot file"
                .to_string()
        }
        _ => "use the column map below".to_string(),
    }
}

/// The column map that reads the log right, or `None` where it is read right without.
pub(super) fn column_map(
    log: &Log,
    robot: &Robot,
    kinematics: &Kinematics,
    best: &Reading,
) -> Option<String> {
    let mut lines = Vec::new();
    if let Some(unit) = kinematics.time {
        lines.push(format!("    time: (column: \"t\", unit: {unit:?}),"));
    }
    let follow = |p: &Signed| {
        let own = kinematics.velocity[p.column];
        Signed { column: own.column, sign: own.sign * p.sign }
    };
    let rates: Vec<Signed> = best.position.iter().map(follow).collect();
    let named = log.named_joints;
    let mut add = |field: &str, prefix: &str, map: &[Signed], unit: &str| {
        lines.extend(entry(robot, named, field, prefix, map, unit));
    };
    let degrees = |wrong: bool| if wrong { "Degrees" } else { "" };
    add("position", "q", &best.position, degrees(best.degrees || kinematics.position_degrees));
    if log.dq.is_some() {
        add("velocity", "dq", &rates, degrees(best.degrees || kinematics.velocity_degrees));
    }
    if log.ddq.is_some() {
        add("acceleration", "ddq", &best.position, degrees(best.degrees));
    }
    add("torque", "tau", &best.torque, "");
    (!lines.is_empty()).then(|| format!("(\n{}\n)\n", lines.join("\n")))
}

fn entry(
    robot: &Robot,
    named: bool,
    field: &str,
    prefix: &str,
    map: &[Signed],
    unit: &str,
) -> Option<String> {
    let moved = map.iter().enumerate().any(|(j, s)| s.column != j);
    let turned = map.iter().any(|s| s.sign < 0.0);
    if !moved && !turned && unit.is_empty() {
        return None;
    }
    let name = |s: &Signed| match named {
        true => format!("\"{prefix}_{}\"", robot.joints[s.column].name),
        false => format!("\"{prefix}{}\"", s.column + 1),
    };
    let columns = match (moved, named) {
        (true, _) => format!("[{}]", map.iter().map(name).collect::<Vec<_>>().join(", ")),
        (false, true) => format!("\"{prefix}_{{name}}\""),
        (false, false) => format!("\"{prefix}{{1}}\""),
    };
    let mut text = format!("    {field}: (columns: {columns}");
    if !unit.is_empty() {
        text += &format!(", unit: {unit}");
    }
    if turned {
        let signs: Vec<String> = map.iter().map(|s| format!("{}", s.sign)).collect();
        text += &format!(", sign: [{}]", signs.join(", "));
    }
    Some(text + "),")
}

/// A unit of time in words.
pub(super) fn time_unit(unit: TimeUnit) -> &'static str {
    match unit {
        TimeUnit::Seconds => "seconds",
        TimeUnit::Milliseconds => "milliseconds",
        TimeUnit::Microseconds => "microseconds",
        TimeUnit::Nanoseconds => "nanoseconds",
    }
}
