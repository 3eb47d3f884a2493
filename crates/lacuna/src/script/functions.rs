//! The functions that scripts may call, beside arithmetic and comparisons.

use std::rc::Rc;

use rhai::{Array, Dynamic, Engine, FnPtr, ImmutableString, NativeCallContext};

use super::elementary::Function;
use super::engine::{MOST_ENTRIES, MOST_LETTERS};
use super::graph::{Graph, Id};
use super::tracer::{Answer, Demand, Matrix, Number, Relation, Shared, Tracer, Vector, fail, kind};

/// What scripts may call, for error messages and the handbook.
pub const FUNCTIONS: [(&str, &str); 30] = [
    ("total_mass(links)", "sum of the masses [kg]"),
    ("named(links, \"name\")", "the link with that name"),
    ("sum(list)", "sum of numbers or vectors"),
    ("min(a, b), min(list)", "smallest"),
    ("max(a, b), max(list)", "largest"),
    ("abs(x)", "size without sign"),
    ("sign(x)", "1, 0 or -1"),
    ("sqrt(x)", "square root"),
    ("pow(x, y)", "x to the power y, also `x ** y`"),
    ("sin(x)", "sine of an angle [rad]"),
    ("cos(x)", "cosine of an angle [rad]"),
    ("tan(x)", "tangent of an angle [rad]"),
    ("atan(x)", "inverse tangent [rad]"),
    ("exp(x)", "exponential"),
    ("ln(x)", "natural logarithm"),
    ("tanh(x)", "hyperbolic tangent"),
    ("pi()", "3.14159..."),
    ("vector(x, y, z)", "a vector"),
    ("norm(vector or list)", "length; `norm(..) <= ..` is convex"),
    ("dot(a, b)", "scalar product"),
    ("matrix([[a, b], [b, c]])", "a symmetric matrix"),
    ("identity(n)", "the unit matrix"),
    ("trace(matrix)", "sum of the diagonal"),
    ("entry(matrix, i, j)", "an element, counted from 0"),
    ("eigenvalues(matrix)", "ascending, as a vector"),
    ("psd(matrix)", "rule: no negative eigenvalue; convex"),
    ("margin(\"label\", x, \"unit\")", "rule: x is not negative"),
    ("rule(\"label\", relation)", "the same relation with a name"),
    ("any_of([a, [b, c]])", "rule: at least one holds; a list holds when all in it do"),
    ("holds(relation)", "true or false, for conditions kept in variables"),
];

/// Makes all of them known.
pub(super) fn register(engine: &mut Engine, shared: &Shared) {
    numbers(engine, shared);
    extremes(engine, shared);
    vectors(engine, shared);
    matrices(engine, shared);
    rules(engine, shared);
    lists(engine, shared);
}

/// How often a label is noted until it is that of a form.
const LABEL: usize = 8;

/// Registers a function of values that works on the tracer.
fn on_tracer<const N: usize>(
    engine: &mut Engine,
    shared: &Shared,
    name: &'static str,
    call: fn(&mut Tracer, [Dynamic; N]) -> Result<Dynamic, String>,
) {
    let shared = shared.clone();
    let run = move |context: &NativeCallContext, values: [Dynamic; N]| -> Answer<Dynamic> {
        let mut tracer = shared.borrow_mut();
        tracer.stand(context);
        call(&mut tracer, values).map_err(fail)
    };
    // The number of arguments is part of a function's name in rhai.
    let all = |values: Vec<Dynamic>| <[Dynamic; N]>::try_from(values).map_err(|_| fail("wrong arguments"));
    match N {
        1 => engine.register_fn(name, move |c: NativeCallContext, a: Dynamic| run(&c, all(vec![a])?)),
        2 => engine
            .register_fn(name, move |c: NativeCallContext, a: Dynamic, b: Dynamic| run(&c, all(vec![a, b])?)),
        _ => engine.register_fn(name, move |c: NativeCallContext, a: Dynamic, b: Dynamic, d: Dynamic| {
            run(&c, all(vec![a, b, d])?)
        }),
    };
}

fn id(tracer: &mut Tracer, value: &Dynamic, taker: &str) -> Result<Id, String> {
    match tracer.operand(value) {
        Some(id) => id,
        None => Err(format!("`{taker}` takes numbers, not {}", kind(value))),
    }
}

/// The numbers of a vector or a list.
fn ids(tracer: &mut Tracer, value: &Dynamic, taker: &str) -> Result<Vec<Id>, String> {
    if let Some(vector) = value.read_lock::<Vector>() {
        return Ok(vector.0.to_vec());
    }
    let Some(list) = value.read_lock::<Array>() else {
        return Err(format!("`{taker}` takes a vector or a list of numbers, not {}", kind(value)));
    };
    list.iter().map(|v| id(tracer, v, taker)).collect()
}

macro_rules! elementary {
    ($engine:expr, $shared:expr, $($name:literal => $function:expr),+) => {
        $(on_tracer::<1>($engine, $shared, $name, |tracer, [x]| {
            let x = id(tracer, &x, $name)?;
            let value = tracer.graph.apply($function, x)?;
            Ok(tracer.give(value))
        });)+
    };
}

fn numbers(engine: &mut Engine, shared: &Shared) {
    elementary!(engine, shared, "sqrt" => Function::Sqrt, "sin" => Function::Sin, "cos" => Function::Cos,
        "tan" => Function::Tan, "atan" => Function::Atan, "exp" => Function::Exp, "ln" => Function::Ln,
        "tanh" => Function::Tanh);
    on_tracer::<1>(engine, shared, "abs", |tracer, [x]| {
        let x = id(tracer, &x, "abs")?;
        let value = tracer.graph.magnitude(x)?;
        Ok(tracer.give(value))
    });
    on_tracer::<1>(engine, shared, "sign", |tracer, [x]| {
        let x = id(tracer, &x, "sign")?;
        let value = tracer.graph.sign(x)?;
        Ok(tracer.give(value))
    });
    on_tracer::<2>(engine, shared, "pow", |tracer, [x, y]| {
        let (x, y) = (id(tracer, &x, "pow")?, id(tracer, &y, "pow")?);
        let value = tracer.graph.power(x, y)?;
        Ok(tracer.give(value))
    });
    engine.register_fn("pi", || std::f64::consts::PI);
}

/// Combines a list pairwise, so that the expression stays shallow.
fn reduce(
    tracer: &mut Tracer,
    all: &[Id],
    combine: fn(&mut Graph, Id, Id) -> Result<Id, String>,
) -> Result<Id, String> {
    match all {
        [] => Err("the list is empty".into()),
        [one] => Ok(*one),
        _ => {
            let (left, right) = all.split_at(all.len() / 2);
            let (left, right) = (reduce(tracer, left, combine)?, reduce(tracer, right, combine)?);
            combine(&mut tracer.graph, left, right)
        }
    }
}

macro_rules! extreme {
    ($engine:expr, $shared:expr, $name:literal, $combine:expr) => {
        on_tracer::<2>($engine, $shared, $name, |tracer, [a, b]| {
            let (a, b) = (id(tracer, &a, $name)?, id(tracer, &b, $name)?);
            let value = $combine(&mut tracer.graph, a, b)?;
            Ok(tracer.give(value))
        });
        on_tracer::<1>($engine, $shared, $name, |tracer, [list]| {
            let all = ids(tracer, &list, $name)?;
            let value = reduce(tracer, &all, $combine)?;
            Ok(tracer.give(value))
        });
    };
}

fn extremes(engine: &mut Engine, shared: &Shared) {
    extreme!(engine, shared, "min", Graph::least);
    extreme!(engine, shared, "max", Graph::greatest);
}

fn vectors(engine: &mut Engine, shared: &Shared) {
    on_tracer::<3>(engine, shared, "vector", |tracer, values| {
        let all: Vec<Id> = values.iter().map(|v| id(tracer, v, "vector")).collect::<Result<_, _>>()?;
        Ok(Dynamic::from(Vector(all.into())))
    });
    on_tracer::<1>(engine, shared, "norm", |tracer, [list]| {
        let all = ids(tracer, &list, "norm")?;
        let value = tracer.graph.norm(&all)?;
        Ok(tracer.give(value))
    });
    on_tracer::<2>(engine, shared, "dot", |tracer, [a, b]| {
        let (a, b) = (ids(tracer, &a, "dot")?, ids(tracer, &b, "dot")?);
        if a.len() != b.len() {
            return Err(format!("`dot` of {} and {} numbers", a.len(), b.len()));
        }
        let products: Vec<Id> =
            a.into_iter().zip(b).map(|(a, b)| tracer.graph.multiply(a, b)).collect::<Result<_, _>>()?;
        let value = reduce(tracer, &products, Graph::add)?;
        Ok(tracer.give(value))
    });
    on_tracer::<1>(engine, shared, "sum", |tracer, [list]| match list.read_lock::<Array>() {
        Some(array) if array.first().is_some_and(|v| v.is::<Vector>()) => sum_of_vectors(tracer, &array),
        _ => {
            let all = ids(tracer, &list, "sum")?;
            if all.is_empty() {
                return Ok(Dynamic::from_float(0.0));
            }
            let value = reduce(tracer, &all, Graph::add)?;
            Ok(tracer.give(value))
        }
    });
}

fn sum_of_vectors(tracer: &mut Tracer, array: &Array) -> Result<Dynamic, String> {
    let rows: Vec<Vec<Id>> = array.iter().map(|v| ids(tracer, v, "sum")).collect::<Result<_, _>>()?;
    let size = rows.first().map_or(0, Vec::len);
    if rows.iter().any(|r| r.len() != size) {
        return Err("`sum` of vectors of different sizes".into());
    }
    let column = |i: usize| rows.iter().map(|r| r[i]).collect::<Vec<_>>();
    let sums: Vec<Id> =
        (0..size).map(|i| reduce(tracer, &column(i), Graph::add)).collect::<Result<_, _>>()?;
    Ok(Dynamic::from(Vector(sums.into())))
}

fn matrix_of(value: &Dynamic, taker: &str) -> Result<Matrix, String> {
    let matrix = value.read_lock::<Matrix>().map(|m| m.clone());
    matrix.ok_or_else(|| format!("`{taker}` takes a matrix, not {}", kind(value)))
}

fn matrices(engine: &mut Engine, shared: &Shared) {
    on_tracer::<1>(engine, shared, "matrix", |tracer, [rows]| new_matrix(tracer, &rows));
    on_tracer::<1>(engine, shared, "identity", |tracer, [size]| {
        let size = size.as_int().ok().and_then(|n| usize::try_from(n).ok()).filter(|n| (1..=16).contains(n));
        let size = size.ok_or("`identity` takes a whole number from 1 to 16")?;
        let (zero, one) = (tracer.graph.constant(0.0)?, tracer.graph.constant(1.0)?);
        let row = |i: usize| (0..=i).map(move |j| if i == j { one } else { zero });
        Ok(Dynamic::from(Matrix { size, lower: (0..size).flat_map(row).collect() }))
    });
    on_tracer::<1>(engine, shared, "trace", |tracer, [matrix]| {
        let matrix = matrix_of(&matrix, "trace")?;
        let diagonal: Vec<Id> = (0..matrix.size).filter_map(|i| matrix.at(i, i)).collect();
        let value = reduce(tracer, &diagonal, Graph::add)?;
        Ok(tracer.give(value))
    });
    on_tracer::<3>(engine, shared, "entry", |tracer, [matrix, i, j]| {
        let matrix = matrix_of(&matrix, "entry")?;
        let place = |v: &Dynamic| v.as_int().ok().and_then(|n| usize::try_from(n).ok());
        let id = place(&i).zip(place(&j)).and_then(|(i, j)| matrix.at(i, j));
        let id =
            id.ok_or_else(|| format!("`entry` counts rows and columns from 0 to {}", matrix.size - 1))?;
        Ok(tracer.give(id))
    });
    on_tracer::<1>(engine, shared, "eigenvalues", |tracer, [matrix]| {
        let matrix = matrix_of(&matrix, "eigenvalues")?;
        eigenvalues(tracer, &matrix).map(Dynamic::from)
    });
}

/// Ascending eigenvalues.
pub(super) fn eigenvalues(tracer: &mut Tracer, matrix: &Matrix) -> Result<Vector, String> {
    let value = |which| tracer.graph.eigenvalue(&matrix.lower, matrix.size, which);
    let all: Rc<[Id]> = (0..matrix.size).map(value).collect::<Result<_, _>>()?;
    Ok(Vector(all))
}

fn new_matrix(tracer: &mut Tracer, rows: &Dynamic) -> Result<Dynamic, String> {
    let help = "`matrix` takes a list of rows of equal length, as in matrix([[a, b], [b, c]])";
    let Some(list) = rows.read_lock::<Array>() else { return Err(help.into()) };
    let rows: Vec<Vec<Id>> = list.iter().map(|r| ids(tracer, r, "matrix")).collect::<Result<_, _>>()?;
    let size = rows.len();
    if size == 0 || size > 16 || rows.iter().any(|r| r.len() != size) {
        return Err(format!("{help}, at most 16"));
    }
    let skew = rows.iter().enumerate().find(|(i, row)| (0..*i).any(|j| row[j] != rows[j][*i]));
    if let Some((i, _)) = skew {
        return Err(format!("the matrix is not symmetric in row {}", i + 1));
    }
    tracer.graph.charge(size_of::<Id>() * size * size)?;
    let lower = rows.iter().enumerate().flat_map(|(i, r)| r[..=i].to_vec()).collect();
    Ok(Dynamic::from(Matrix { size, lower }))
}

fn rules(engine: &mut Engine, shared: &Shared) {
    on_tracer::<1>(engine, shared, "psd", |tracer, [matrix]| {
        let matrix = matrix_of(&matrix, "psd")?;
        let demand = Demand::Psd { lower: matrix.lower, size: matrix.size };
        Ok(Dynamic::from(tracer.relation(demand)))
    });
    on_tracer::<2>(engine, shared, "margin", |tracer, [label, x]| margin(tracer, &label, &x, None));
    on_tracer::<3>(engine, shared, "margin", |tracer, [label, x, unit]| {
        let unit = unit.into_string().map_err(|_| "the unit of `margin` is a text")?;
        margin(tracer, &label, &x, Some(unit))
    });
    on_tracer::<2>(engine, shared, "rule", |tracer, [label, stated]| {
        let label = label.into_string().map_err(|_| "`rule` takes its label first, as a text")?;
        tracer.graph.charge(LABEL * label.len())?;
        match stated.try_cast_result::<Relation>() {
            Ok(stated) => Ok(Dynamic::from(Relation { label: Some(label), ..stated })),
            Err(other) => Err(format!("`rule` takes a relation, not {}", kind(&other))),
        }
    });
    on_tracer::<1>(engine, shared, "any_of", |tracer, [list]| super::alternatives::any_of(tracer, &list));
    on_tracer::<1>(engine, shared, "holds", |tracer, [stated]| {
        holds(tracer, &stated).map(Dynamic::from_bool)
    });
}

fn margin(
    tracer: &mut Tracer,
    label: &Dynamic,
    x: &Dynamic,
    unit: Option<String>,
) -> Result<Dynamic, String> {
    let label = label.clone().into_string().map_err(|_| "`margin` takes its label first, as a text")?;
    tracer.graph.charge(LABEL * label.len())?;
    let x = id(tracer, x, "margin")?;
    let stated = tracer.relation(Demand::Margin(x));
    Ok(Dynamic::from(Relation { label: Some(label), unit, test: Some((x, true)), ..stated }))
}

/// Whether a relation holds, as a decision of this run.
fn holds(tracer: &mut Tracer, stated: &Dynamic) -> Result<bool, String> {
    if let Ok(known) = stated.as_bool() {
        return Ok(known);
    }
    let test = stated.read_lock::<Relation>().map(|r| {
        tracer.use_up(&r);
        r.test
    });
    match test {
        Some(Some((node, wanted))) => Ok(tracer.decide(node)? == wanted),
        Some(None) => Err("`holds` takes relations between numbers by `<`, `<=`, `>`, `>=`".into()),
        None => Err(format!("`holds` takes a relation, not {}", kind(stated))),
    }
}

fn lists(engine: &mut Engine, shared: &Shared) {
    engine.register_fn("len", |list: &mut Array| list.len() as i64);
    engine.register_get("len", |list: &mut Array| list.len() as i64);
    engine.register_fn("is_empty", |list: &mut Array| list.is_empty());
    growing(engine, shared);
    engine.register_fn("map", |context: NativeCallContext, list: Array, f: FnPtr| -> Answer<Array> {
        list.into_iter().map(|v| f.call_within_context::<Dynamic>(&context, (v,))).collect()
    });
    let state = shared.clone();
    let filter = move |context: NativeCallContext, list: Array, f: FnPtr| -> Answer<Array> {
        let mut kept = Array::new();
        for value in list {
            let answer: Dynamic = f.call_within_context(&context, (value.clone(),))?;
            if holds(&mut state.borrow_mut(), &answer).map_err(fail)? {
                kept.push(value);
            }
        }
        Ok(kept)
    };
    engine.register_fn("filter", filter);
    engine.register_indexer_get(|vector: &mut Vector, at: i64| -> Answer<Number> {
        let id = usize::try_from(at).ok().and_then(|i| vector.0.get(i).copied());
        id.map(Number).ok_or_else(|| fail(format!("a vector of {} has no [{at}]", vector.0.len())))
    });
}

/// What grows says so itself where it would grow too large: rhai's own error has no place.
fn growing(engine: &mut Engine, shared: &Shared) {
    engine.register_fn("push", |list: &mut Array, value: Dynamic| -> Answer<()> {
        list.push(value);
        fits(list.len(), MOST_ENTRIES, "list", "entries")
    });
    engine.register_fn("+=", |list: &mut Array, more: Array| -> Answer<()> {
        fits(list.len() + more.len(), MOST_ENTRIES, "list", "entries")?;
        list.extend(more);
        Ok(())
    });
    engine.register_fn("+", |mut list: Array, more: Array| -> Answer<Array> {
        fits(list.len() + more.len(), MOST_ENTRIES, "list", "entries")?;
        list.extend(more);
        Ok(list)
    });
    let state = shared.clone();
    engine.register_fn("+=", move |text: &mut ImmutableString, more: ImmutableString| -> Answer<()> {
        fits(text.len() + more.len(), MOST_LETTERS, "text", "letters")?;
        state.borrow_mut().graph.charge(text.len() + more.len()).map_err(fail)?;
        *text += more;
        Ok(())
    });
    let state = shared.clone();
    engine.register_fn("+", move |text: ImmutableString, more: ImmutableString| -> Answer<ImmutableString> {
        fits(text.len() + more.len(), MOST_LETTERS, "text", "letters")?;
        state.borrow_mut().graph.charge(text.len() + more.len()).map_err(fail)?;
        Ok(text + more)
    });
}

fn fits(size: usize, most: usize, what: &str, of: &str) -> Answer<()> {
    if size <= most {
        Ok(())
    } else {
        Err(fail(format!("this {what} grows too large, to more than {most} {of}")))
    }
}
