//! Where a model fails: the residual against every variable, region by region.

use super::answer::Region;
use super::data::Data;
use super::present::rms;
use super::score::long_run_variance;
use crate::signals::extremes;

/// Regions must stand out by this much to be listed.
const STANDS_OUT: f64 = 3.0;
/// And their rms by this factor.
const LARGER: f64 = 1.15;
/// Parts that a variable's range is cut into.
const PARTS: usize = 6;
/// Speeds below this part of the joint's rms speed count as near zero.
const SLOW: f64 = 0.15;
/// At most so many regions per joint.
const MOST: usize = 4;

/// Regions where the residual is significantly larger than elsewhere on the same joint, worst first.
pub(super) fn find(data: &Data, residual: &[Vec<f64>]) -> Vec<Region> {
    let mut all = Vec::new();
    for (joint, residual) in residual.iter().enumerate() {
        let mut own: Vec<Region> = Vec::new();
        for (variable, values) in variables(data, joint) {
            let cuts = if variable.starts_with("dq") { speed_cuts(&values) } else { even_cuts(&values) };
            own.extend(cuts.windows(2).filter_map(|cut| {
                let mut region = judge(data, residual, &values, (cut[0], cut[1]))?;
                (region.joint, region.variable) = (data.robot.joints[joint].name.clone(), variable.clone());
                Some(region)
            }));
        }
        own.sort_by(|a, b| b.z.total_cmp(&a.z));
        own.truncate(MOST);
        all.extend(own);
    }
    all.sort_by(|a, b| b.z.total_cmp(&a.z));
    all
}

/// Every variable that the torque error of a joint is looked at against.
pub(super) fn variables(data: &Data, joint: usize) -> Vec<(String, Vec<f64>)> {
    let number = joint + 1;
    let mut all = Vec::new();
    let mut push = |name: String, values: Option<Vec<f64>>| {
        all.extend(values.map(|values| (name, values)));
    };
    push(format!("dq{number}"), data.picked(|run| run.dq.get(joint).map(Vec::as_slice)));
    push(format!("q{number}"), data.picked(|run| run.q.get(joint).map(Vec::as_slice)));
    push(format!("ddq{number}"), data.picked(|run| run.ddq.get(joint).map(Vec::as_slice)));
    push("load".to_string(), Some(data.tau[joint].clone()));
    push("time".to_string(), Some(times(data)));
    let channels: Vec<&String> = data.runs.first().map_or_else(Vec::new, |run| run.channels.keys().collect());
    for name in channels {
        push(name.clone(), data.picked(|run| run.channels.get(name).map(Vec::as_slice)));
    }
    all
}

/// Time of every row since its run began \[s\].
pub(super) fn times(data: &Data) -> Vec<f64> {
    data.rows.iter().flat_map(|rows| (0..rows.count).map(|k| k as f64 * rows.dt)).collect()
}

fn even_cuts(values: &[f64]) -> Vec<f64> {
    let (low, high) = extremes(values);
    (0..=PARTS).map(|k| low + (high - low) * k as f64 / PARTS as f64).collect()
}

/// Backwards, near zero, forwards.
fn speed_cuts(values: &[f64]) -> Vec<f64> {
    let (low, high) = extremes(values);
    let slow = SLOW * rms(values);
    vec![low.min(-slow), -slow, slow, high.max(slow)]
}

fn judge(data: &Data, residual: &[f64], values: &[f64], (from, to): (f64, f64)) -> Option<Region> {
    let inside = |x: f64| x >= from && x <= to;
    let mean = residual.iter().map(|r| r * r).sum::<f64>() / residual.len().max(1) as f64;
    let (mut rows, mut square) = (0, 0.0);
    let u: Vec<f64> = residual
        .iter()
        .zip(values)
        .map(|(r, &x)| {
            if !inside(x) {
                return 0.0;
            }
            rows += 1;
            square += r * r;
            r * r - mean
        })
        .collect();
    if rows < 10 || rows == residual.len() {
        return None;
    }
    let variance = long_run_variance(data, &u);
    let z = if variance > 0.0 { u.iter().sum::<f64>() / variance.sqrt() } else { 0.0 };
    let here = (square / rows as f64).sqrt();
    let stands_out = z >= STANDS_OUT && here > LARGER * mean.sqrt();
    stands_out.then(|| Region { joint: String::new(), variable: String::new(), from, to, rms: here, rows, z })
}
