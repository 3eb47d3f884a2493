//! Comparisons: `must be <=` states a relation, `is <=` asks which way to go.

use std::cmp::Ordering;

use rhai::{Dynamic, Engine, NativeCallContext};

use super::dialect::{COMPARISONS, PRECEDENCES};
use super::graph::Id;
use super::tracer::{Answer, Demand, Number, Relation, Shared, Tracer, fail, kind};

/// Makes all comparisons known; each takes any two values, so none falls through to rhai's own.
pub(super) fn register(engine: &mut Engine, shared: &Shared) -> Result<(), String> {
    for ((written, statement, question), precedence) in COMPARISONS.into_iter().zip(PRECEDENCES) {
        for (name, asks) in [(statement, false), (question, true)] {
            engine.register_custom_operator(name, precedence)?;
            let shared = shared.clone();
            engine.register_fn(
                name,
                move |context: NativeCallContext, a: Dynamic, b: Dynamic| -> Answer<Dynamic> {
                    let mut tracer = shared.borrow_mut();
                    tracer.stand(&context);
                    compare(&mut tracer, written, asks, &a, &b).map_err(fail)
                },
            );
        }
    }
    Ok(())
}

fn compare(tracer: &mut Tracer, op: &str, asks: bool, a: &Dynamic, b: &Dynamic) -> Result<Dynamic, String> {
    if let (Some(x), Some(y)) = (tracer.operand(a), tracer.operand(b)) {
        let traced = tracer.is_at_point() && (a.is::<Number>() || b.is::<Number>());
        return numbers(tracer, op, asks, traced, x?, y?);
    }
    let equal = match (a.as_immutable_string_ref(), b.as_immutable_string_ref()) {
        (Ok(a), Ok(b)) => Some(a.as_str() == b.as_str()),
        _ => a.as_bool().ok().zip(b.as_bool().ok()).map(|(a, b)| a == b),
    };
    match (equal, op) {
        (Some(equal), "==") => Ok(equal.into()),
        (Some(equal), "!=") => Ok((!equal).into()),
        _ if a.is::<Relation>() || b.is::<Relation>() => Err(format!(
            "`{op}` follows another comparison; write `a <= b <= c` as two rules, `a <= b` and `b <= c`"
        )),
        _ => Err(format!("`{op}` compares numbers, but here are {} and {}", kind(a), kind(b))),
    }
}

/// `traced` where constants stand for unknowns, in a run at a point.
fn numbers(tracer: &mut Tracer, op: &str, asks: bool, traced: bool, x: Id, y: Id) -> Result<Dynamic, String> {
    let graph = &mut tracer.graph;
    if let (Some(x), Some(y), false) = (graph.value(x), graph.value(y), traced) {
        tracer.plain = Some(graph.here);
        return Ok(plain(op, x, y).into());
    }
    let equality = matches!(op, "==" | "!=");
    if equality && (asks || op == "!=") {
        return Err(format!("`{op}` on an unknown: it is never exactly equal; compare with a tolerance"));
    }
    let margin = if matches!(op, "<" | "<=") { graph.subtract(y, x)? } else { graph.subtract(x, y)? };
    // `a < b` is where `a - b >= 0` does not hold.
    let test = match op {
        "<" | ">" => (graph.negative(margin)?, false),
        _ => (margin, true),
    };
    if asks {
        return Ok((tracer.decide(test.0)? == test.1).into());
    }
    let bound = graph.value(y).or(graph.value(x)).map_or(1.0, f64::abs);
    let demand = if equality { Demand::Zero(margin) } else { Demand::Margin(margin) };
    let relation = Relation {
        label: super::print::comparison(tracer, x, op, y),
        scale: if bound > 0.0 { bound } else { 1.0 },
        test: (!equality).then_some(test),
        ..tracer.relation(demand)
    };
    Ok(Dynamic::from(relation))
}

fn plain(op: &str, x: f64, y: f64) -> bool {
    let order = x.partial_cmp(&y);
    match op {
        "<" => order == Some(Ordering::Less),
        "<=" => matches!(order, Some(Ordering::Less | Ordering::Equal)),
        ">" => order == Some(Ordering::Greater),
        ">=" => matches!(order, Some(Ordering::Greater | Ordering::Equal)),
        "==" => order == Some(Ordering::Equal),
        _ => order != Some(Ordering::Equal),
    }
}
