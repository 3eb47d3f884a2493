//! What the search does not see: units and signs of velocities, the torques' common sign and scale,
//! torque without gravity in robots where nothing else depends on it.

use super::reading::{Change, Reading, Signed};
use super::search::{Found, Ground, Scored};
use super::velocity::Kinematics;
use super::{Finding, Severity, all_torques, words};
use crate::error::Result;
use crate::kernels::{Chain, RegressorBlock, Samples};
use crate::log::Log;
use crate::robot::{PARAMETERS_PER_LINK, Robot};
use crate::signals::Run;

const MAP: &str = "use the column map below";

fn finding(kind: &'static str, severity: Severity, text: String, remedy: impl Into<String>) -> Finding {
    Finding {
        kind,
        severity,
        joints: Vec::new(),
        text,
        error_percent: None,
        held_out_error_percent: None,
        also_possible: Vec::new(),
        remedy: remedy.into(),
    }
}

fn defect(kind: &'static str, text: String) -> Finding {
    finding(kind, Severity::Defect, text, MAP)
}

/// Disagreements between time, position and velocity.
pub(super) fn of_kinematics(robot: &Robot, log: &Log, seen: &Kinematics, found: &Found) -> Vec<Finding> {
    let mut all = Vec::new();
    if let Some(unit) = seen.time {
        let proof = match log.dq {
            Some(_) => "diff(q) over diff(t) then agrees with dq".to_string(),
            None => format!("rows would stand {:.3} s apart", 1.0 / seen.rows_per_second.max(1e-12)),
        };
        let text = format!("time is in {}, not in seconds ({proof})", words::time_unit(unit));
        all.push(defect("time_unit", text));
    }
    if seen.position_degrees {
        let text = "positions are in degrees, not in radians (velocities are in rad/s)";
        all.push(defect("position_unit", text.into()));
    }
    if seen.velocity_degrees {
        let text = "velocities are in degrees per second, not in rad/s (positions are in rad)";
        all.push(defect("velocity_unit", text.into()));
    }
    all.extend(velocity_order(robot, seen, &found.best.reading));
    for j in 0..robot.dof() {
        all.extend(velocity_sign(robot, seen, &found.best.reading, j));
    }
    for &(j, factor) in &seen.scaled {
        let text = format!(
            "{}: position changes {factor:.3} times as fast as velocity says",
            words::joint(robot, j)
        );
        let remedy = "check its unit and whether it is the motor's; or leave velocities out of the log";
        all.push(named(robot, j, finding("velocity_scale", Severity::Defect, text, remedy)));
    }
    for &j in &seen.lost {
        let text = format!("{}: velocity does not follow the position of any joint", words::joint(robot, j));
        let remedy = "check what was logged; or leave velocities out of the log";
        all.push(named(robot, j, finding("velocity_lost", Severity::Warning, text, remedy)));
    }
    all
}

fn named(robot: &Robot, j: usize, finding: Finding) -> Finding {
    Finding { joints: vec![robot.joints[j].name.clone()], ..finding }
}

/// Velocities in another order than positions; where the search moved positions to where their
/// velocities are, it was the positions.
fn velocity_order(robot: &Robot, seen: &Kinematics, best: &Reading) -> Option<Finding> {
    let moved: Vec<usize> = (0..robot.dof()).filter(|&j| seen.velocity[j].column != j).collect();
    let right = |(j, p): (usize, &Signed)| seen.velocity[p.column].column == j;
    if moved.is_empty() || best.position.iter().enumerate().all(right) {
        return None;
    }
    let names: Vec<String> = moved.iter().map(|&j| words::joint(robot, j)).collect();
    let text = format!("velocities stand in another order than positions: {}", names.join(", "));
    let joints = moved.iter().map(|&j| robot.joints[j].name.clone()).collect();
    Some(Finding { joints, ..defect("velocity_order", text) })
}

/// A velocity against its position; the finding is the position's where the search turned that.
fn velocity_sign(robot: &Robot, seen: &Kinematics, best: &Reading, j: usize) -> Option<Finding> {
    let against = seen.velocity[j].sign < 0.0;
    let position_is_wrong = best.position.iter().any(|p| p.column == j && p.sign < 0.0);
    if !against || position_is_wrong {
        return None;
    }
    let slope = seen.slopes[j].map_or_else(String::new, |s| format!(", slope {s:.2}"));
    let text = format!(
        "{}: velocity has the wrong sign (it runs against the change of position{slope})",
        words::joint(robot, j)
    );
    Some(named(robot, j, defect("velocity_sign", text)))
}

/// All torques with the wrong sign: refitting cannot see it, but inertia and friction come out negative.
pub(super) fn common_sign(ground: &Ground, found: &mut Found) -> Result<Option<Finding>> {
    let (case, model, run) = ground.case(&found.best.reading)?;
    let signs = vec![1.0; ground.robot.dof()];
    if found.best.error > 0.7 || case.orientation(&model, &run, &signs) > -0.34 {
        return Ok(None);
    }
    let turned = ground.score(all_torques(&found.best.reading), None)?;
    let own = found.best.given.zip(turned.given).map(|(a, b)| [100.0 * a, 100.0 * b]);
    found.best = turned;
    let text = "all torques have the wrong sign: identified inertia and friction come out negative";
    Ok(Some(Finding { error_percent: own, ..defect("torque_sign", text.into()) }))
}

/// Torque without gravity where the refit only finds that gravity is zero.
pub(super) fn no_gravity(ground: &Ground, found: &Found) -> Result<Option<Finding>> {
    let best = &found.best;
    if best.reading.gravity.norm() <= 0.0 || best.error > 0.3 {
        return Ok(None);
    }
    let without = ground.score(best.reading.with(&Change::NoGravity), None)?;
    let (_, model, run) = ground.case(&best.reading)?;
    if without.error > 1.03 * best.error || gravity_shows(&model.chain, &run) < 1.0 {
        return Ok(None);
    }
    // A balanced arm feels no gravity either, and the file's own inertias would know.
    if without.given.zip(best.given).is_some_and(|(w, g)| g < 0.5 && w > 0.9 * g) {
        return Ok(None);
    }
    let text = "the torque has no gravity in it (a model without gravity explains it as well)".to_string();
    let remedy = words::remedy(&Change::NoGravity);
    let percent = [best.error, without.error].map(|e| 100.0 * e);
    let one = finding("no_gravity", Severity::Defect, text, remedy);
    let also = vec!["an arm that is balanced by counterweights or springs".to_string()];
    Ok(Some(Finding { error_percent: Some(percent), also_possible: also, ..one }))
}

/// Largest variation of gravity torque per first moment along the motion [N m per kg m].
fn gravity_shows(chain: &Chain, run: &Run) -> f64 {
    let (n, rows) = (run.q.len(), run.samples());
    let still = vec![vec![0.0; rows]; n];
    let mut block = RegressorBlock::new(chain, rows);
    block.fill(chain, Samples { q: &run.q, dq: &still, ddq: &still }, 0..rows);
    let mut most = 0.0_f64;
    for joint in 0..n {
        for link in 0..n {
            for moment in 1..4 {
                let Some(column) = block.column(joint, PARAMETERS_PER_LINK * link + moment) else { continue };
                let mean = column.iter().sum::<f64>() / rows as f64;
                let square = column.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / rows as f64;
                most = most.max(square.sqrt());
            }
        }
    }
    most
}

/// Torques of another size than the file's own inertias predict.
pub(super) fn torque_scale(ground: &Ground, found: &Found) -> Result<Option<Finding>> {
    let (case, ..) = ground.case(&found.best.reading)?;
    let Some(scales) = case.scales() else { return Ok(None) };
    let mut sure: Vec<f64> = scales.iter().filter(|(k, r)| *r > 0.8 && *k > 0.0).map(|(k, _)| *k).collect();
    let middle = sure.len() / 2;
    if 2 * sure.len() < scales.len() {
        return Ok(None);
    }
    let scale = *sure.select_nth_unstable_by(middle, f64::total_cmp).1;
    Ok(match scale {
        s if (0.33..3.0).contains(&s) => None,
        s if (500.0..2000.0).contains(&s) => Some(finding(
            "torque_unit",
            Severity::Defect,
            "torques are in N mm or mN m, not in N m (a thousand times what the robot file predicts)".into(),
            "map them: torque: (columns: \"tau{1}\", unit: MillinewtonMeters)",
        )),
        s => Some(finding(
            "torque_scale",
            Severity::Warning,
            format!("torques are about {s:.3} times what the robot file's inertias predict"),
            "is it motor current, torque on the motor's side of the gear, or another unit? map it with \
             `torque: (current: \"..\", gains: [..])`",
        )),
    })
}

/// A remark where nothing explains the torque.
pub(super) fn unexplained(found: &Found) -> Option<Finding> {
    let Scored { error, .. } = found.best;
    let text =
        format!("{:.0} % of the torque's variation is explained by no reading that was tried", 100.0 * error);
    let remedy = "is it the log of this robot? is the torque measured, and at the same time as the motion?";
    (error > 0.5).then(|| finding("unexplained", Severity::Warning, text, remedy))
}
