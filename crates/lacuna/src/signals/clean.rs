//! Rows that are no measurements of their own, and gaps.

use std::collections::BTreeMap;
use std::ops::Range;

use serde::Serialize;

use crate::error::{Error, Result};
use crate::log::Log;

/// A stretch of a log without a gap.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Segment {
    /// Time of its first row \[s\].
    pub from_s: f64,
    /// Time of its last row \[s\].
    pub to_s: f64,
    /// Rows in it.
    pub rows: usize,
    /// Whether it was kept.
    pub used: bool,
}

/// The rows worth using: increasing in time, without a gap above the limit.
#[derive(Debug)]
pub(super) struct Cleaned {
    pub rows: Vec<usize>,
    pub dropped: BTreeMap<String, usize>,
    pub segments: Vec<Segment>,
}

/// A joint that is farther than this from where it stood has left; less where it travels little [rad, m].
const LEFT: f64 = 2e-3;
/// Rows one after the other that must have left.
const FEW: usize = 3;
/// Standing longer than this before or after the motion says nothing of it \[s\].
const STOOD: f64 = 1.0;

/// Drops what is no measurement, keeps the longest stretch without a gap above `max_gap_s`, and of the time that the
/// robot stands still before and after its motion no more than `stand_s`: stiction holds any torque there.
pub(super) fn clean(log: &Log, max_gap_s: f64, stand_s: f64) -> Result<Cleaned> {
    check_shape(log)?;
    let mut dropped: BTreeMap<String, usize> =
        log.dropped.iter().map(|(reason, d)| (reason.clone(), d.rows)).collect();
    let mut drop = |reason: &str, rows: usize| {
        if rows > 0 {
            *dropped.entry(reason.to_owned()).or_default() += rows;
        }
    };
    let finite: Vec<usize> = (0..log.rows()).filter(|&k| is_finite(log, k)).collect();
    drop("not a number", log.rows() - finite.len());
    let max_gap = max_gap_s.max(3.0 * usual_step(&log.t, &finite));
    let fresh = without_stale(log, &finite, max_gap);
    drop("stale", finite.len() - fresh.len());
    let ordered = in_order(&log.t, &fresh);
    let repeats = same_time(&log.t, &fresh, &ordered);
    drop("time repeats", repeats);
    drop("out of order", fresh.len() - ordered.len() - repeats);

    let parts: Vec<&[usize]> = ordered.chunk_by(|&a, &b| log.t[b] - log.t[a] <= max_gap).collect();
    let moving: Vec<&[usize]> = parts.iter().map(|part| &part[in_motion(log, part, stand_s)]).collect();
    let longest = moving.iter().enumerate().rev().max_by_key(|(_, rows)| rows.len()).map_or(0, |(i, _)| i);
    let whole = parts.get(longest).map_or(0, |part| part.len());
    let rows = moving.get(longest).map_or_else(Vec::new, |rows| rows.to_vec());
    drop("outside the longest stretch", ordered.len() - whole);
    drop("standing still at the ends", whole - rows.len());
    if rows.len() < 3 {
        let what = format!("{} of {} rows can be used, which is no motion", rows.len(), log.rows());
        return Err(Error::new(what)
            .in_file(&log.name)
            .help("check the time column and the units of the log"));
    }
    let segment = |(i, part): (usize, &&[usize])| Segment {
        from_s: log.t[part[0]],
        to_s: log.t[part[part.len() - 1]],
        rows: part.len(),
        used: i == longest,
    };
    let segments = parts.iter().enumerate().map(segment).collect();
    Ok(Cleaned { rows, dropped, segments })
}

/// The part of `rows` from `stand_s` before the robot leaves where it stood first until as long after it arrives where
/// it stands last; all of them where it does not stand still for long.
fn in_motion(log: &Log, rows: &[usize], stand_s: f64) -> Range<usize> {
    let all = 0..rows.len();
    let (Some(&first), Some(&last)) = (rows.first(), rows.last()) else { return all };
    let moving: Vec<(&[f64], f64)> =
        log.q.iter().filter_map(|q| Some((q.as_slice(), left(q, rows)?))).collect();
    let away = |from: usize, row: usize| moving.iter().any(|(q, left)| (q[row] - q[from]).abs() > *left);
    // A single row that jumps is no motion.
    let gone = |from: usize, few: &[usize]| few.iter().all(|&row| away(from, row));
    let Some(leaves) = rows.windows(FEW).position(|few| gone(first, few)) else { return all };
    let Some(arrives) = rows.windows(FEW).rposition(|few| gone(last, few)) else { return all };
    let (from, to) = (log.t[rows[leaves]], log.t[rows[arrives + FEW - 1]]);
    let start = match from - log.t[first] > STOOD {
        true => rows.partition_point(|&row| log.t[row] < from - stand_s),
        false => 0,
    };
    let end = match log.t[last] - to > STOOD {
        true => rows.partition_point(|&row| log.t[row] <= to + stand_s),
        false => rows.len(),
    };
    // What creeps all the time leaves its first place after it has come to its last one.
    if leaves < arrives { start..end } else { all }
}

/// How far from where it stood a joint has left; none where it never moves.
fn left(q: &[f64], rows: &[usize]) -> Option<f64> {
    let ends =
        rows.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], &row| [a.min(q[row]), b.max(q[row])]);
    let travel = ends[1] - ends[0];
    (travel >= LEFT).then(|| (0.01 * travel).clamp(0.15 * LEFT, LEFT))
}

/// Every joint quantity must have as many joints and rows as it says.
fn check_shape(log: &Log) -> Result<()> {
    let joints = log.q.len();
    let parts =
        [("q", Some(&log.q)), ("dq", log.dq.as_ref()), ("tau", Some(&log.tau).filter(|tau| !tau.is_empty()))];
    for (name, columns) in parts {
        let Some(columns) = columns else { continue };
        if joints == 0 || columns.len() != joints || columns.iter().any(|c| c.len() != log.rows()) {
            let what = format!("`{name}` does not have {joints} columns of {} rows", log.rows());
            return Err(Error::new(what).in_file(&log.name).help("give every joint a column of every row"));
        }
    }
    if let Some((name, _)) = log.channels.iter().find(|(_, c)| c.len() != log.rows()) {
        return Err(Error::new(format!("`{name}` does not have {} rows", log.rows())).in_file(&log.name));
    }
    Ok(())
}

fn joint_columns(log: &Log) -> impl Iterator<Item = &Vec<f64>> {
    log.q.iter().chain(log.dq.iter().flatten()).chain(&log.tau)
}

fn is_finite(log: &Log, row: usize) -> bool {
    log.t[row].is_finite() && joint_columns(log).all(|c| c[row].is_finite())
}

/// Median of the steps forward in time.
fn usual_step(t: &[f64], rows: &[usize]) -> f64 {
    let steps = rows.windows(2).map(|w| t[w[1]] - t[w[0]]).filter(|step| *step > 0.0).collect();
    super::median(steps).unwrap_or(0.0)
}

/// How a row stands to the one before it.
#[derive(Clone, Copy, PartialEq)]
enum Kind {
    /// Something moved, or the robot is known to stand still.
    Fresh,
    /// No joint channel changed.
    Stale,
    /// The velocities are those of the row before, other channels are newer: a record that was
    /// written while it was read.
    Torn,
}

/// Leaves out rows that repeat the state of the row before: an asynchronous reader was faster than
/// the robot. Torn rows count as repeats in a log that has many whole ones; in others equal
/// velocities are just a steady motion.
fn without_stale(log: &Log, rows: &[usize], max_gap: f64) -> Vec<usize> {
    let mut kinds: Vec<Kind> = std::iter::once(Kind::Fresh)
        .chain(rows.windows(2).map(|w| kind(log, w[0], w[1])))
        .take(rows.len())
        .collect();
    let count = |kind| kinds.iter().filter(|&&k| k == kind).count();
    let torn_are_stale = 2 * count(Kind::Torn) < count(Kind::Stale);
    keep_rests(log, rows, &mut kinds, max_gap);
    let fresh = |kind| kind == Kind::Fresh || (kind == Kind::Torn && !torn_are_stale);
    rows.iter().zip(kinds).filter(|&(_, kind)| fresh(kind)).map(|(&row, _)| row).collect()
}

fn kind(log: &Log, before: usize, row: usize) -> Kind {
    let same = |columns: &[Vec<f64>]| columns.iter().all(|c| !differ(c[before], c[row]));
    if let Some(dq) = &log.dq {
        let at_rest = dq.iter().all(|c| !differ(c[row], 0.0));
        if at_rest || !same(dq) {
            return Kind::Fresh;
        }
    }
    match (same(&log.q) && same(&log.tau), log.dq.is_some()) {
        (true, _) => Kind::Stale,
        (false, true) => Kind::Torn,
        (false, false) => Kind::Fresh,
    }
}

fn differ(a: f64, b: f64) -> bool {
    (a - b).abs() > 0.0
}

/// A long run of equal rows after which the motion goes on where it stopped is a robot at rest in a
/// log without noise; after a stuck logger the position has jumped.
fn keep_rests(log: &Log, rows: &[usize], kinds: &mut [Kind], max_gap: f64) {
    let mut first = 1;
    while first < rows.len() {
        let end = (first..rows.len()).find(|&i| kinds[i] != Kind::Stale).unwrap_or(rows.len());
        let long = end > first && log.t[rows[end - 1]] - log.t[rows[first - 1]] > max_gap;
        if long && end < rows.len() && goes_on_smoothly(log, rows, end) {
            kinds[first..end].fill(Kind::Fresh);
        }
        first = end + 1;
    }
}

/// The step into row `rows[i]` is not above the steps of the next half hundred rows.
fn goes_on_smoothly(log: &Log, rows: &[usize], i: usize) -> bool {
    let near = &rows[i..rows.len().min(i + 50)];
    log.q.iter().all(|q| {
        let step = |w: &[usize]| (q[w[1]] - q[w[0]]).abs();
        step(&rows[i - 1..=i]) <= near.windows(2).map(step).fold(0.0, f64::max)
    })
}

/// The largest set of rows whose time increases (longest increasing subsequence, by patience
/// sorting), so that one wild stamp costs one row; of equal stamps the first stays.
fn in_order(t: &[f64], rows: &[usize]) -> Vec<usize> {
    const NONE: usize = usize::MAX;
    let mut ends: Vec<usize> = Vec::new(); // position in `rows` of the earliest end of a chain of each length
    let mut before = vec![NONE; rows.len()];
    for (i, &row) in rows.iter().enumerate() {
        let length = match ends.last() {
            Some(&last) if t[rows[last]] < t[row] => ends.len(),
            _ => ends.partition_point(|&end| t[rows[end]] < t[row]),
        };
        if length > 0 {
            before[i] = ends[length - 1];
        }
        match ends.get_mut(length) {
            Some(end) if t[row] < t[rows[*end]] => *end = i,
            Some(_) => {}
            None => ends.push(i),
        }
    }
    let mut chain: Vec<usize> =
        std::iter::successors(ends.last().copied(), |&i| Some(before[i]).filter(|&b| b != NONE))
            .map(|i| rows[i])
            .collect();
    chain.reverse();
    chain
}

/// How many of the rows that `ordered` lacks have the very stamp of the ordered row before them.
fn same_time(t: &[f64], rows: &[usize], ordered: &[usize]) -> usize {
    let mut next = 0;
    let mut repeats = 0;
    for &row in rows {
        if ordered.get(next) == Some(&row) {
            next += 1;
        } else if next > 0 && !differ(t[row], t[ordered[next - 1]]) {
            repeats += 1;
        }
    }
    repeats
}
