//! `any_of`: one alternative is enough, so its margin is the largest of theirs.

use rhai::{Array, Dynamic};

use super::graph::Id;
use super::tracer::{Demand, Relation, Tracer, kind};

/// How deep lists of alternatives may be nested.
const DEEPEST: usize = 8;

pub(super) fn any_of(tracer: &mut Tracer, list: &Dynamic) -> Result<Dynamic, String> {
    let Some(list) = list.read_lock::<Array>() else {
        return Err(format!("`any_of` takes a list of relations, not {}", kind(list)));
    };
    let parts: Vec<Vec<Relation>> = list.iter().map(|v| relations(v, DEEPEST)).collect::<Result<_, _>>()?;
    if parts.is_empty() || parts.iter().any(Vec::is_empty) {
        return Err("`any_of` got an empty alternative, which always holds".into());
    }
    let scaled = !same_unit(tracer, parts.iter().flatten())?;
    let mut best: Option<Id> = None;
    for part in &parts {
        let mut worst: Option<Id> = None;
        for stated in part {
            let margin = margin(tracer, stated, scaled)?;
            worst = Some(worst.map_or(Ok(margin), |w| tracer.graph.least(w, margin))?);
        }
        let worst = worst.ok_or("`any_of` got an empty alternative")?;
        best = Some(best.map_or(Ok(worst), |b| tracer.graph.greatest(b, worst))?);
    }
    let margin = best.ok_or("`any_of` got no alternative")?;
    let scale = if scaled { 1.0 } else { largest_scale(&parts) };
    let unit = parts.iter().flatten().find_map(|r| r.unit.clone()).filter(|_| !scaled);
    let demand = Demand::Margin(margin);
    parts.iter().flatten().for_each(|r| tracer.use_up(r));
    Ok(Dynamic::from(Relation { unit, scale, test: Some((margin, true)), ..tracer.relation(demand) }))
}

fn largest_scale(parts: &[Vec<Relation>]) -> f64 {
    parts.iter().flatten().map(|r| r.scale).fold(0.0, f64::max)
}

/// A relation, or all in a list.
fn relations(value: &Dynamic, depth: usize) -> Result<Vec<Relation>, String> {
    if let Some(stated) = value.read_lock::<Relation>() {
        return Ok(vec![stated.clone()]);
    }
    match value.read_lock::<Array>() {
        Some(list) if depth > 0 => {
            let parts: Vec<Vec<Relation>> =
                list.iter().map(|v| relations(v, depth - 1)).collect::<Result<_, _>>()?;
            Ok(parts.into_iter().flatten().collect())
        }
        _ => Err(format!("an alternative of `any_of` is {}, not a relation", kind(value))),
    }
}

fn node(tracer: &mut Tracer, stated: &Relation) -> Result<Id, String> {
    match &stated.demand {
        Demand::Margin(id) => Ok(*id),
        Demand::Zero(id) => {
            let other = tracer.graph.negative(*id)?;
            tracer.graph.least(*id, other)
        }
        Demand::Psd { lower, size } => tracer.graph.eigenvalue(lower, *size, 0),
    }
}

/// Margins in different units are compared after division by their bounds.
fn margin(tracer: &mut Tracer, stated: &Relation, scaled: bool) -> Result<Id, String> {
    let id = node(tracer, stated)?;
    if !scaled {
        return Ok(id);
    }
    let one = tracer.graph.unit_of(id)?;
    let scale = tracer.graph.constant(stated.scale)?;
    let bound = tracer.graph.multiply(scale, one)?;
    tracer.graph.divide(id, bound)
}

fn same_unit<'a>(tracer: &mut Tracer, all: impl Iterator<Item = &'a Relation>) -> Result<bool, String> {
    let mut units = Vec::new();
    for stated in all {
        let id = node(tracer, stated)?;
        units.push(tracer.graph.dimension(id).map(|d| d.to_string()));
    }
    Ok(units.windows(2).all(|pair| pair[0] == pair[1]))
}
