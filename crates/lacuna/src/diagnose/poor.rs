//! What data cannot tell, whatever is found in them.

use super::answer::Undecided;
use super::data::Data;
use crate::log::Log;
use crate::signals::at_limit;

/// What makes an answer impossible (`true`) or partial.
pub(super) fn judge(data: &Data) -> Vec<(Undecided, bool)> {
    let mut all = Vec::new();
    let seconds: f64 = data.rows.iter().map(|r| r.count as f64 * r.dt).sum();
    let unknowns = crate::identify::BaseParameters::new(&data.robot).rank() + 3 * data.dof();
    if data.count() * data.dof() < 10 * unknowns || seconds < 8.0 {
        let reason = format!(
            "{seconds:.1} s of motion give {} rows for {unknowns} unknowns: too little to hold anything out",
            data.count() * data.dof()
        );
        let record = "a motion of all joints of at least 20 s, better twice the same one".to_string();
        all.push((Undecided { reason, record }, true));
    }
    for (j, joint) in data.robot.joints.iter().enumerate() {
        let name = &joint.name;
        if data.still[j] {
            let reason = format!("{name} never moves: nothing is claimed on it");
            all.push((Undecided { reason, record: format!("a motion in which {name} moves too") }, false));
        }
        let limited = |run: &crate::signals::Run| at_limit(&run.tau[j]).iter().filter(|x| **x).count();
        let (count, samples) = (
            data.runs.iter().map(limited).sum::<usize>(),
            data.runs.iter().map(crate::signals::Run::samples).sum::<usize>(),
        );
        if count > 0 && !data.silent[j] {
            let reason = format!(
                "the torque of {name} stays at its largest or smallest value in {count} of {samples} samples: a limit \
                 of drive or sensor, not a measurement; these rows are left out"
            );
            let record = format!("a slower motion, which keeps {name} below its limit");
            all.push((Undecided { reason, record }, false));
        }
        if data.silent[j] {
            let reason = format!(
                "the torque of {name} is one constant: its rows are left out, nothing is claimed on it"
            );
            let record = format!("the torque of {name}, or map its column to the sensor that shows it");
            all.push((Undecided { reason, record }, false));
        }
    }
    all
}

/// Sets the torque of joints to zero where it never changes: a brake or a dead channel, not a measurement. Fits
/// leave out a joint whose torque is zero throughout.
pub(super) fn silence(logs: &mut [Log]) {
    let joints = logs.first().map_or(0, |log| log.tau.len());
    for joint in 0..joints {
        let constant = |log: &Log| {
            log.tau.get(joint).is_none_or(|c| c.windows(2).all(|pair| pair[0].to_bits() == pair[1].to_bits()))
        };
        if logs.iter().all(constant) {
            for log in logs.iter_mut() {
                log.tau[joint].iter_mut().for_each(|tau| *tau = 0.0);
            }
        }
    }
}
