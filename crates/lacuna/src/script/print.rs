//! Short expressions as text, for labels.

use super::elementary::Function;
use super::graph::{Graph, Id, Op};
use super::tracer::Tracer;
use crate::form::Affine;

/// Longer labels than this help nobody.
const LONGEST: usize = 72;

/// `x op y` where that is short enough.
pub(super) fn comparison(tracer: &Tracer, x: Id, op: &str, y: Id) -> Option<String> {
    let (left, right) = (expression(tracer, x, 4)?, expression(tracer, y, 4)?);
    let text = format!("{left} {op} {right}");
    (text.len() <= LONGEST).then_some(text)
}

fn expression(tracer: &Tracer, id: Id, depth: usize) -> Option<String> {
    let graph: &Graph = &tracer.graph;
    let depth = depth.checked_sub(1)?;
    if let Some(row) = graph.affine(id) {
        return affine(row, &tracer.names);
    }
    let inner = |id: Id| expression(tracer, id, depth);
    match &graph.node(id).op {
        Op::Add(a, b) => Some(format!("{} + {}", inner(*a)?, inner(*b)?)),
        Op::Div(a, b) => Some(format!("{} / {}", inner(*a)?, inner(*b)?)),
        Op::Norm(rows) if rows.len() <= 3 => {
            let rows: Vec<String> = rows.iter().map(|&r| inner(r)).collect::<Option<_>>()?;
            Some(format!("|{}|", rows.join(", ")))
        }
        Op::Least(a, b) => Some(format!("min({}, {})", inner(*a)?, inner(*b)?)),
        Op::Greatest(a, b) => Some(format!("max({}, {})", inner(*a)?, inner(*b)?)),
        Op::Apply(Function::Floor, a) => inner(*a),
        Op::Apply(function, a) => Some(format!("{}({})", function.name(), inner(*a)?)),
        _ => None,
    }
}

fn affine(row: &Affine, names: &[String]) -> Option<String> {
    let mut text = String::new();
    for (index, factor) in &row.terms {
        let name = names.get(*index)?;
        let sign = match (text.is_empty(), *factor < 0.0) {
            (true, true) => "-",
            (true, false) => "",
            (false, true) => " - ",
            (false, false) => " + ",
        };
        let size = factor.abs();
        let weight = if (size - 1.0).abs() < 1e-15 { String::new() } else { format!("{size} ") };
        text += &format!("{sign}{weight}{name}");
        if text.len() > LONGEST {
            return None;
        }
    }
    if row.constant.abs() > 0.0 || text.is_empty() {
        let sign = match (text.is_empty(), row.constant < 0.0) {
            (true, _) => String::new(),
            (false, true) => " - ".into(),
            (false, false) => " + ".into(),
        };
        let constant = if text.is_empty() { row.constant } else { row.constant.abs() };
        text += &format!("{sign}{constant}");
    }
    Some(text)
}
