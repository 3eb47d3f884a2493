//! What one effect adds to a joint, and what it is seen against.

use super::{JointUnits, Partial, Role, Trace, binned};
use crate::effects::About;

/// What one effect adds to the torque, with its parameters fitted to all data.
#[derive(Debug, Clone)]
pub struct EffectShare {
    /// Name in the catalogue.
    pub effect: String,
    /// Whether it was found, or belongs to the starting model.
    pub found: bool,
    /// The joint it acts on.
    pub joint: usize,
    /// Its torque on that joint in every fitted log [N m, N]: `torque[log][row]`.
    pub torque: Vec<Vec<f64>>,
    /// Residual with the effect put back, against variables; the first one is its own.
    pub partials: Vec<Partial>,
}

impl EffectShare {
    /// From the fitted logs among `traces`, the residual of the whole model on the joint and the effect's
    /// torque there, both over all fitted logs one after the other [N m, N]. `own` is the variable that the
    /// effect is made of, where that is not a matter of its name.
    #[allow(clippy::too_many_arguments)] // plain data, given once
    pub fn new(
        about: &About,
        found: bool,
        joint: usize,
        own: Option<&str>,
        traces: &[Trace],
        units: &[JointUnits],
        residual: &[f64],
        torque: &[f64],
    ) -> Self {
        let fitted: Vec<&Trace> = traces.iter().filter(|t| t.role != Role::NeverFitted).collect();
        let own = own.map_or_else(|| about.drawn_against.of_joint(joint), str::to_string);
        let mut names = vec![own.clone()];
        let usual = ["dq", "q", "ddq"].map(|kind| format!("{kind}{}", joint + 1));
        let channels = fitted.first().map_or_else(Vec::new, |t| t.channels.keys().cloned().collect());
        let others = usual.into_iter().chain(["load".to_string(), "time".to_string()]).chain(channels);
        names.extend(others.filter(|name| *name != own));
        let one = |variable: String| {
            let values = values(&fitted, joint, &variable)?;
            let unit = unit(units, joint, &variable);
            Some(Partial { bins: binned(&values, residual, torque), variable, unit })
        };
        let mut rest = torque;
        let cut = |trace: &&Trace| {
            let (own, later) = rest.split_at(trace.rows.count.min(rest.len()));
            rest = later;
            own.to_vec()
        };
        let by_log = fitted.iter().map(cut).collect();
        let partials = names.into_iter().filter_map(one).collect();
        Self { effect: about.name.to_string(), found, joint, torque: by_log, partials }
    }
}

/// `dq3` as kind and joint.
fn parts(variable: &str) -> Option<(&str, usize)> {
    let kind = ["ddq", "dq", "q"].into_iter().find(|kind| variable.starts_with(kind))?;
    let number: usize = variable[kind.len()..].parse().ok()?;
    Some((kind, number.checked_sub(1)?))
}

/// Values of a variable in all logs, one after the other; `None` where a log lacks it.
fn values(traces: &[&Trace], joint: usize, variable: &str) -> Option<Vec<f64>> {
    let mut all = Vec::new();
    for trace in traces {
        let of_joint = parts(variable).and_then(|(kind, j)| match kind {
            "q" => trace.q.get(j),
            "dq" => trace.dq.get(j),
            _ => trace.ddq.get(j),
        });
        match (variable, of_joint, trace.channels.get(variable)) {
            ("load", _, _) => all.extend_from_slice(&trace.measured[joint]),
            ("time", _, _) => {
                all.extend((0..trace.rows.count).map(|k| trace.rows.start + k as f64 * trace.rows.dt));
            }
            (_, Some(column), _) | (_, None, Some(column)) => all.extend_from_slice(column),
            _ => return None,
        }
    }
    Some(all)
}

/// Unit of a variable; empty for a channel, whose unit the log does not say.
fn unit(units: &[JointUnits], joint: usize, variable: &str) -> String {
    match (variable, parts(variable)) {
        ("load", _) => units[joint].torque.to_string(),
        ("time", _) => "s".to_string(),
        (_, Some((kind, j))) if j < units.len() => {
            let per = match kind {
                "q" => "",
                "dq" => "/s",
                _ => "/s²",
            };
            format!("{}{per}", units[j].position)
        }
        _ => String::new(),
    }
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use super::*;
    use crate::effects::{JointSpring, ScriptedEffect, TorqueDrift, TorqueGain, ViscousFriction};
    use crate::signals::Rows;

    fn trace(name: &str, role: Role, from: f64) -> Trace {
        let ramp = |by: f64| -> Vec<f64> { (0..30).map(|k| from + by * f64::from(k)).collect() };
        Trace {
            name: name.into(),
            role,
            rows: Rows { start: from, dt: 0.1, count: 30 },
            q: vec![ramp(1.0), ramp(2.0)],
            dq: vec![ramp(3.0), ramp(4.0)],
            ddq: vec![ramp(5.0), ramp(6.0)],
            channels: BTreeMap::from([
                ("q7".to_string(), ramp(7.0)),
                ("temperature1".to_string(), ramp(8.0)),
            ]),
            measured: vec![ramp(9.0), ramp(10.0)],
            models: vec![],
        }
    }

    fn units() -> Vec<JointUnits> {
        let one = |name: &str, position, torque| JointUnits { name: name.into(), position, torque };
        vec![one("a", "rad", "N m"), one("b", "m", "N")]
    }

    #[test]
    fn an_effect_is_first_seen_against_its_own_variable() {
        let traces = [trace("a", Role::Fitted, 0.0), trace("b", Role::Fitted, 100.0)];
        let (zero, torque) = (vec![0.0; 60], (0..60).map(f64::from).collect::<Vec<f64>>());
        let share = |about: About, own: Option<&str>| {
            EffectShare::new(&about, true, 1, own, &traces, &units(), &zero, &torque)
        };
        let spring = share(JointSpring::ABOUT, None);
        assert_eq!((spring.partials[0].variable.as_str(), spring.partials[0].unit.as_str()), ("q2", "m"));
        assert_eq!(share(ViscousFriction::ABOUT, None).partials[0].unit, "m/s");
        assert_eq!(share(TorqueGain::ABOUT, None).partials[0].unit, "N");
        assert_eq!(share(ScriptedEffect::ABOUT, Some("ddq1")).partials[0].unit, "rad/s²");
        assert_eq!(share(ScriptedEffect::ABOUT, Some("temperature1")).partials[0].unit, "");
        // Every variable once; both logs, each with its own rows.
        let mut names: Vec<&str> = spring.partials.iter().map(|p| p.variable.as_str()).collect();
        names.sort_unstable();
        assert_eq!(names, ["ddq2", "dq2", "load", "q2", "q7", "temperature1", "time"]);
        assert_eq!(spring.torque.iter().map(Vec::len).collect::<Vec<_>>(), [30, 30]);
        assert!(spring.partials.iter().all(|p| p.bins.iter().map(|b| b.rows).sum::<usize>() == 60));
    }

    #[test]
    fn logs_that_are_never_fitted_are_not_counted() {
        let traces = [trace("a", Role::Fitted, 0.0), trace("b", Role::NeverFitted, 100.0)];
        let (zero, torque) = (vec![0.0; 30], vec![1.0; 30]);
        let share = EffectShare::new(&TorqueDrift::ABOUT, true, 0, None, &traces, &units(), &zero, &torque);
        assert_eq!(share.torque.len(), 1);
        assert!(share.partials.iter().all(|p| p.bins.iter().all(|b| b.at < 300.0)));
    }
}
