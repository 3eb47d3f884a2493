//! `+ - * / **` on numbers, vectors and matrices.

use std::rc::Rc;

use rhai::{Engine, NativeCallContext};

use super::graph::{Graph, Id};
use super::tracer::{Answer, Matrix, Number, Shared, Vector, fail};

type Combine = fn(&mut Graph, Id, Id) -> Result<Id, String>;

const OPERATORS: [(&str, Combine); 5] = [
    ("+", Graph::add),
    ("-", Graph::subtract),
    ("*", Graph::multiply),
    ("/", Graph::divide),
    ("**", Graph::power),
];

/// What may stand beside an operator.
trait Operand: Clone + Send + Sync + 'static {
    fn id(&self, graph: &mut Graph) -> Result<Id, String>;
}

impl Operand for Number {
    fn id(&self, _: &mut Graph) -> Result<Id, String> {
        Ok(self.0)
    }
}

impl Operand for f64 {
    fn id(&self, graph: &mut Graph) -> Result<Id, String> {
        graph.constant(*self)
    }
}

impl Operand for i64 {
    fn id(&self, graph: &mut Graph) -> Result<Id, String> {
        graph.constant(*self as f64)
    }
}

/// Makes arithmetic known.
pub(super) fn register(engine: &mut Engine, shared: &Shared) {
    for (name, combine) in OPERATORS {
        number::<Number, Number>(engine, shared, name, combine);
        number::<Number, f64>(engine, shared, name, combine);
        number::<f64, Number>(engine, shared, name, combine);
        number::<Number, i64>(engine, shared, name, combine);
        number::<i64, Number>(engine, shared, name, combine);
        if matches!(name, "+" | "-") {
            whole_arrays(engine, shared, name, combine);
        }
    }
    scaling::<Number>(engine, shared);
    scaling::<f64>(engine, shared);
    scaling::<i64>(engine, shared);
    negation(engine, shared);
    plain(engine);
}

fn number<A: Operand, B: Operand>(engine: &mut Engine, shared: &Shared, name: &str, combine: Combine) {
    let shared = shared.clone();
    engine.register_fn(name, move |context: NativeCallContext, a: A, b: B| -> Answer<Number> {
        let mut tracer = shared.borrow_mut();
        tracer.stand(&context);
        let graph = &mut tracer.graph;
        let (a, b) = (a.id(graph).map_err(fail)?, b.id(graph).map_err(fail)?);
        combine(graph, a, b).map(Number).map_err(fail)
    });
}

/// Entry by entry.
fn zip(graph: &mut Graph, a: &[Id], b: &[Id], combine: Combine) -> Answer<Rc<[Id]>> {
    if a.len() != b.len() {
        return Err(fail(format!("the sizes differ: {} and {} entries", a.len(), b.len())));
    }
    graph.charge(size_of_val(a)).map_err(fail)?;
    a.iter().zip(b).map(|(&a, &b)| combine(graph, a, b)).collect::<Result<_, _>>().map_err(fail)
}

fn whole_arrays(engine: &mut Engine, shared: &Shared, name: &str, combine: Combine) {
    let state = shared.clone();
    engine.register_fn(name, move |context: NativeCallContext, a: Vector, b: Vector| -> Answer<Vector> {
        let mut tracer = state.borrow_mut();
        tracer.stand(&context);
        zip(&mut tracer.graph, &a.0, &b.0, combine).map(Vector)
    });
    let state = shared.clone();
    engine.register_fn(name, move |context: NativeCallContext, a: Matrix, b: Matrix| -> Answer<Matrix> {
        let mut tracer = state.borrow_mut();
        tracer.stand(&context);
        Ok(Matrix { size: a.size, lower: zip(&mut tracer.graph, &a.lower, &b.lower, combine)? })
    });
}

fn each(graph: &mut Graph, all: &[Id], by: Id, combine: Combine) -> Answer<Rc<[Id]>> {
    graph.charge(size_of_val(all)).map_err(fail)?;
    all.iter().map(|&a| combine(graph, a, by)).collect::<Result<_, _>>().map_err(fail)
}

/// Vector or matrix times or divided by a number.
fn scaling<S: Operand>(engine: &mut Engine, shared: &Shared) {
    for (name, combine) in [("*", Graph::multiply as Combine), ("/", Graph::divide)] {
        let state = shared.clone();
        engine.register_fn(name, move |context: NativeCallContext, a: Vector, by: S| -> Answer<Vector> {
            let mut tracer = state.borrow_mut();
            tracer.stand(&context);
            let by = by.id(&mut tracer.graph).map_err(fail)?;
            each(&mut tracer.graph, &a.0, by, combine).map(Vector)
        });
        let state = shared.clone();
        engine.register_fn(name, move |context: NativeCallContext, a: Matrix, by: S| -> Answer<Matrix> {
            let mut tracer = state.borrow_mut();
            tracer.stand(&context);
            let by = by.id(&mut tracer.graph).map_err(fail)?;
            Ok(Matrix { size: a.size, lower: each(&mut tracer.graph, &a.lower, by, combine)? })
        });
    }
    let state = shared.clone();
    engine.register_fn("*", move |context: NativeCallContext, by: S, a: Vector| -> Answer<Vector> {
        let mut tracer = state.borrow_mut();
        tracer.stand(&context);
        let by = by.id(&mut tracer.graph).map_err(fail)?;
        each(&mut tracer.graph, &a.0, by, Graph::multiply).map(Vector)
    });
    let state = shared.clone();
    engine.register_fn("*", move |context: NativeCallContext, by: S, a: Matrix| -> Answer<Matrix> {
        let mut tracer = state.borrow_mut();
        tracer.stand(&context);
        let by = by.id(&mut tracer.graph).map_err(fail)?;
        Ok(Matrix { size: a.size, lower: each(&mut tracer.graph, &a.lower, by, Graph::multiply)? })
    });
}

fn negation(engine: &mut Engine, shared: &Shared) {
    let state = shared.clone();
    engine.register_fn("-", move |a: Number| -> Answer<Number> {
        state.borrow_mut().graph.negative(a.0).map(Number).map_err(fail)
    });
    let state = shared.clone();
    engine.register_fn("-", move |a: Vector| -> Answer<Vector> {
        let mut tracer = state.borrow_mut();
        let all = a.0.iter().map(|&x| tracer.graph.negative(x)).collect::<Result<_, _>>();
        all.map(Vector).map_err(fail)
    });
    engine.register_fn("+", |a: Number| a);
}

/// Plain numbers divide as real numbers, and never by zero: `1 / 2` is 0.5.
fn plain(engine: &mut Engine) {
    let divide = |a: f64, b: f64| -> Answer<f64> {
        let quotient = a / b;
        if quotient.is_finite() { Ok(quotient) } else { Err(fail("division by zero")) }
    };
    let power = |a: f64, b: f64| -> Answer<f64> {
        let value = libm::pow(a, b);
        if value.is_finite() { Ok(value) } else { Err(fail(format!("{a} ** {b} is not a finite number"))) }
    };
    engine.register_fn("/", divide);
    engine.register_fn("/", move |a: i64, b: i64| divide(a as f64, b as f64));
    engine.register_fn("/", move |a: i64, b: f64| divide(a as f64, b));
    engine.register_fn("/", move |a: f64, b: i64| divide(a, b as f64));
    engine.register_fn("**", power);
    engine.register_fn("**", move |a: i64, b: i64| power(a as f64, b as f64));
    engine.register_fn("**", move |a: i64, b: f64| power(a as f64, b));
    engine.register_fn("**", move |a: f64, b: i64| power(a, b as f64));
}
