//! What is in a part of the data that somebody marked: a span of time, or ranges of variables.

use serde::Deserialize;
use serde_json::{Value, json};

use super::bench::Bench;
use super::pictures::{Pair, Shown};
use crate::error::{Error, Result};
use crate::report::finite;
use crate::report::pictures::{JointUnits, Trace};
use crate::signals::correlation;

/// Correlations that are told at most.
const MOST: usize = 5;
/// Weaker ones say nothing.
const LEAST_R: f64 = 0.3;
/// Fewer rows say nothing of a correlation.
const LEAST_ROWS: usize = 12;

/// A part of the data.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Marked {
    #[serde(default)]
    pub step: Option<usize>,
    #[serde(default)]
    pub against: Option<usize>,
    /// Number of the log among those that are drawn.
    #[serde(default)]
    pub log: usize,
    /// Joint whose torque `load` stands for.
    #[serde(default)]
    pub joint: Option<String>,
    #[serde(default)]
    pub from: Option<f64>,
    #[serde(default)]
    pub to: Option<f64>,
    #[serde(default)]
    pub variable: Option<String>,
    #[serde(default)]
    pub low: Option<f64>,
    #[serde(default)]
    pub high: Option<f64>,
    #[serde(default)]
    pub variable2: Option<String>,
    #[serde(default)]
    pub low2: Option<f64>,
    #[serde(default)]
    pub high2: Option<f64>,
}

/// What is there: errors joint by joint, how the robot moves, and what the error follows.
///
/// # Errors
/// When there is no such log, joint or variable.
pub(super) fn read(bench: &Bench, marked: &Marked) -> Result<Value> {
    let shown = Shown::of(bench, Pair { step: marked.step, against: marked.against })?;
    let pictures = shown.pictures();
    let trace = pictures.traces.get(marked.log).ok_or_else(|| {
        Error::new(format!("there is no log {}", marked.log)).help("logs count from 0, as they are drawn")
    })?;
    let place = Place { trace, joints: &pictures.joints, load: joint(marked, &pictures.joints)? };
    let rows = place.rows(marked)?;
    if rows.is_empty() {
        return Ok(
            json!({"rows": 0, "seconds": 0.0, "models": [], "joints": [], "motion": [], "depends": [],
                         "text": "no row lies here"}),
        );
    }
    let residuals: Vec<Vec<Vec<f64>>> = (0..trace.models.len()).map(|m| trace.residual(m)).collect();
    let joints: Vec<Value> = (0..place.joints.len()).map(|j| place.joint(j, &rows, &residuals)).collect();
    let depends = residuals.last().map_or_else(Vec::new, |last| place.depends(&rows, last));
    let text = place.sentence(&rows, &residuals);
    Ok(json!({
        "rows": rows.len(),
        "seconds": rows.len() as f64 * trace.rows.dt,
        "models": pictures.models.iter().map(|m| &m.label).collect::<Vec<_>>(),
        "joints": joints,
        "motion": place.motion(&rows),
        "depends": depends.into_iter().map(|(joint, variable, r)| json!({"joint": joint, "variable": variable, "r": r}))
            .collect::<Vec<_>>(),
        "text": text,
    }))
}

fn joint(marked: &Marked, joints: &[JointUnits]) -> Result<usize> {
    let Some(name) = &marked.joint else { return Ok(0) };
    joints
        .iter()
        .position(|j| j.name == *name)
        .ok_or_else(|| Error::new(format!("there is no joint `{name}`")))
}

struct Place<'a> {
    trace: &'a Trace,
    joints: &'a [JointUnits],
    /// Joint whose torque `load` stands for.
    load: usize,
}

impl Place<'_> {
    fn rows(&self, m: &Marked) -> Result<Vec<usize>> {
        let first = self.range(m.variable.as_deref(), m.low, m.high)?;
        let second = self.range(m.variable2.as_deref(), m.low2, m.high2)?;
        let (from, to) = (m.from.unwrap_or(f64::NEG_INFINITY), m.to.unwrap_or(f64::INFINITY));
        let inside = |range: &Option<(Vec<f64>, f64, f64)>, k: usize| {
            range.as_ref().is_none_or(|(values, low, high)| (*low..=*high).contains(&values[k]))
        };
        let within =
            |k: &usize| (from..=to).contains(&self.time(*k)) && inside(&first, *k) && inside(&second, *k);
        Ok((0..self.trace.rows.count).filter(within).collect())
    }

    fn range(
        &self,
        name: Option<&str>,
        low: Option<f64>,
        high: Option<f64>,
    ) -> Result<Option<(Vec<f64>, f64, f64)>> {
        let Some(name) = name else { return Ok(None) };
        let values = self.values(name).ok_or_else(|| {
            Error::new(format!("there is no variable `{name}`"))
                .help("q1, dq1, ddq1, .., load, time or a channel")
        })?;
        Ok(Some((values, low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY))))
    }

    fn time(&self, row: usize) -> f64 {
        self.trace.rows.start + row as f64 * self.trace.rows.dt
    }

    fn values(&self, name: &str) -> Option<Vec<f64>> {
        let numbered = |prefix: &str, columns: &[Vec<f64>]| -> Option<Vec<f64>> {
            let number: usize = name.strip_prefix(prefix)?.parse().ok()?;
            columns.get(number.checked_sub(1)?).cloned()
        };
        let t = self.trace;
        match name {
            "time" => Some((0..t.rows.count).map(|k| self.time(k)).collect()),
            "load" => t.measured.get(self.load).cloned(),
            _ => numbered("ddq", &t.ddq)
                .or_else(|| numbered("dq", &t.dq))
                .or_else(|| numbered("q", &t.q))
                .or_else(|| t.channels.get(name).cloned()),
        }
    }

    fn joint(&self, j: usize, rows: &[usize], residuals: &[Vec<Vec<f64>>]) -> Value {
        let inside: std::collections::BTreeSet<usize> = rows.iter().copied().collect();
        let others: Vec<usize> = (0..self.trace.rows.count).filter(|k| !inside.contains(k)).collect();
        let all = |rows: &[usize]| residuals.iter().map(|r| finite(rms(&r[j], rows))).collect::<Vec<_>>();
        let most: Vec<f64> =
            residuals.iter().map(|r| rows.iter().map(|&k| r[j][k].abs()).fold(0.0, f64::max)).collect();
        let last = residuals.last().map(|r| &r[j]);
        let at = last.and_then(|r| rows.iter().copied().max_by(|&a, &b| r[a].abs().total_cmp(&r[b].abs())));
        json!({
            "name": self.joints[j].name, "unit": self.joints[j].torque,
            "torque_rms": finite(rms(&self.trace.measured[j], rows)),
            "rms": all(rows), "rms_elsewhere": all(&others), "most": most, "at_s": at.map(|k| self.time(k)),
        })
    }

    fn motion(&self, rows: &[usize]) -> Vec<Value> {
        let mut all = Vec::new();
        for (j, units) in self.joints.iter().enumerate() {
            for (kind, per, columns) in
                [("q", "", &self.trace.q), ("dq", "/s", &self.trace.dq), ("ddq", "/s²", &self.trace.ddq)]
            {
                let ends = rows.iter().map(|&k| columns[j][k]);
                let (low, high) =
                    ends.fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), x| (a.min(x), b.max(x)));
                all.push(
                    json!({"variable": format!("{kind}{}", j + 1), "joint": units.name, "from": finite(low),
                                "to": finite(high), "unit": format!("{}{per}", units.position)}),
                );
            }
        }
        all
    }

    /// The strongest correlations of what is left with the joint's own motion, load and channels.
    fn depends(&self, rows: &[usize], residual: &[Vec<f64>]) -> Vec<(String, String, f64)> {
        let mut all = Vec::new();
        if rows.len() < LEAST_ROWS {
            return all;
        }
        for (j, units) in self.joints.iter().enumerate() {
            let own = ["q", "dq", "ddq"].map(|kind| format!("{kind}{}", j + 1));
            let names =
                own.into_iter().chain(["time".to_string()]).chain(self.trace.channels.keys().cloned());
            for name in names {
                let Some(values) = self.values(&name) else { continue };
                let r = correlation(&picked(&residual[j], rows), &picked(&values, rows));
                if r.abs() >= LEAST_R {
                    all.push((units.name.clone(), name, r));
                }
            }
        }
        all.sort_by(|a, b| b.2.abs().total_cmp(&a.2.abs()));
        all.truncate(MOST);
        all
    }

    /// The joint that stands out most from its own other rows, in words.
    fn sentence(&self, rows: &[usize], residuals: &[Vec<Vec<f64>>]) -> String {
        let seconds = rows.len() as f64 * self.trace.rows.dt;
        let Some(last) = residuals.last() else { return format!("{seconds:.2} s") };
        let whole: Vec<usize> = (0..self.trace.rows.count).collect();
        let ratio = |j: usize| rms(&last[j], rows) / rms(&last[j], &whole).max(1e-300);
        let worst = (0..self.joints.len()).max_by(|&a, &b| ratio(a).total_cmp(&ratio(b))).unwrap_or(0);
        let units = &self.joints[worst];
        let here = rms(&last[worst], rows);
        let count = rows.len();
        if ratio(worst) < 1.2 {
            return format!("{count} rows, {seconds:.2} s: no joint is worse here than elsewhere");
        }
        format!(
            "{count} rows, {seconds:.2} s: {} is off by {here:.3} {} rms here, {:.1} times its rms over the whole log",
            units.name,
            units.torque,
            ratio(worst)
        )
    }
}

fn picked(values: &[f64], rows: &[usize]) -> Vec<f64> {
    rows.iter().map(|&k| values[k]).collect()
}

fn rms(values: &[f64], rows: &[usize]) -> f64 {
    (rows.iter().map(|&k| values[k] * values[k]).sum::<f64>() / rows.len() as f64).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::pictures::Role;
    use crate::signals::Rows;

    fn trace() -> Trace {
        let ramp = |by: f64| -> Vec<f64> { (0..100).map(|k| by * f64::from(k)).collect() };
        let measured: Vec<f64> = (0..100).map(|k| if k >= 50 { 2.0 } else { 1.0 }).collect();
        Trace {
            name: "log".into(),
            role: Role::Fitted,
            rows: Rows { start: 10.0, dt: 0.1, count: 100 },
            q: vec![ramp(0.01)],
            dq: vec![ramp(-1.0)],
            ddq: vec![vec![0.0; 100]],
            channels: [("heat".to_string(), ramp(3.0))].into(),
            measured: vec![measured],
            models: vec![vec![vec![1.0; 100]]],
        }
    }

    #[test]
    fn rows_are_those_inside_every_range() -> Result<()> {
        let (trace, joints) = (trace(), [JointUnits { name: "a".into(), position: "rad", torque: "N m" }]);
        let place = Place { trace: &trace, joints: &joints, load: 0 };
        let marked = |m: Marked| place.rows(&m);
        assert_eq!(marked(Marked::default())?.len(), 100);
        let span = Marked { from: Some(10.95), to: Some(12.05), ..Marked::default() };
        assert_eq!(marked(span.clone())?, (10..=20).collect::<Vec<_>>());
        let both = Marked { variable: Some("q1".into()), low: Some(0.145), high: None, ..span.clone() };
        assert_eq!(marked(both)?, (15..=20).collect::<Vec<_>>());
        let second = Marked { variable2: Some("heat".into()), high2: Some(31.0), ..span };
        assert_eq!(marked(second)?, [10]);
        let loaded = Marked { variable: Some("load".into()), low: Some(1.5), ..Marked::default() };
        assert_eq!(marked(loaded)?, (50..100).collect::<Vec<_>>());
        assert!(marked(Marked { variable: Some("q2".into()), ..Marked::default() }).is_err());
        Ok(())
    }

    #[test]
    fn what_the_error_follows_and_where_it_stands_out_is_told() {
        let (trace, joints) = (trace(), [JointUnits { name: "a".into(), position: "rad", torque: "N m" }]);
        let place = Place { trace: &trace, joints: &joints, load: 0 };
        let all: Vec<usize> = (0..100).collect();
        let step = trace.residual(0);
        let depends = place.depends(&all, &step);
        // A step correlates with a ramp as the root of three quarters, against a falling one with the other sign.
        assert!(depends.iter().all(|(_, _, r)| (r.abs() - 0.75_f64.sqrt()).abs() < 1e-3), "{depends:?}");
        assert!(depends.iter().any(|(_, name, r)| name == "dq1" && *r < 0.0));
        assert!(depends.iter().all(|(_, name, _)| name != "ddq1"), "what does not vary explains nothing");
        let late: Vec<usize> = (50..100).collect();
        let text = place.sentence(&late, std::slice::from_ref(&step));
        assert!(text.contains("off by 1.000 N m rms here, 1.4 times"), "{text}");
        let early: Vec<usize> = (0..50).collect();
        assert!(place.sentence(&early, std::slice::from_ref(&step)).contains("no joint is worse"));
    }
}
