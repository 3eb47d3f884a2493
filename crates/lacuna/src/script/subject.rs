//! What a script sees: a robot's bodies, as affine quantities of the unknowns.

use std::rc::Rc;

use rhai::{Array, Dynamic, Engine, NativeCallContext};

use super::dimension::Dimension;
use super::functions::eigenvalues;
use super::graph::Id;
use super::tracer::{Answer, Matrix, Number, Shared, Tracer, Vector, fail, kind};
use crate::form::Affine;

const MASS: Option<Dimension> = Some(Dimension::new(1, 0, 0));
const MOMENT: Option<Dimension> = Some(Dimension::new(1, 1, 0));
const INERTIA: Option<Dimension> = Some(Dimension::new(1, 2, 0));
const ACCELERATION: Option<Dimension> = Some(Dimension::new(0, 1, -2));

/// One rigid body, in its own frame.
#[derive(Debug, Clone)]
pub struct Body {
    /// Its name in the robot file.
    pub name: String,
    /// Mass \[kg\]; one unknown.
    pub mass: Affine,
    /// Mass times centre of mass [kg m].
    pub first_moment: [Affine; 3],
    /// Inertia tensor about the frame's origin, `xx xy xz yy yz zz` [kg m²].
    pub inertia_at_origin: [Affine; 6],
}

/// The robot a script is about.
#[derive(Debug, Clone, Default)]
pub struct Subject {
    /// Name in the robot file.
    pub name: String,
    /// Gravity in the base frame [m/s²].
    pub gravity: [f64; 3],
    /// All bodies, in order.
    pub bodies: Vec<Body>,
    /// The bodies the script is asked about, as places in `bodies`.
    pub chosen: Vec<usize>,
    /// Names of the unknowns, for labels.
    pub unknowns: Vec<String>,
}

/// A link in a script.
#[derive(Debug, Clone, Copy)]
pub(super) struct LinkView(pub(super) usize);

/// The robot in a script.
#[derive(Debug, Clone, Copy)]
pub(super) struct RobotView;

/// Properties by type: its name in error messages, what it has.
pub const PROPERTIES: [(&str, &str); 4] = [
    (
        "link",
        "name, number, mass, com, first_moment, inertia (about the centre of mass), inertia_at_origin, \
         principal_moments, pseudo_inertia",
    ),
    ("robot", "name, gravity, links"),
    ("vector", "x, y, z, and [0], [1], ..."),
    ("matrix", "xx, xy, xz, yy, yz, zz"),
];

type Quantity = fn(&mut Tracer, &Body) -> Result<Dynamic, String>;

/// Makes links, the robot, vectors and matrices known.
pub(super) fn register(engine: &mut Engine, shared: &Shared, subject: &Rc<Subject>) {
    engine.register_type_with_name::<LinkView>("link");
    engine.register_type_with_name::<RobotView>("robot");
    engine.register_type_with_name::<Vector>("vector");
    engine.register_type_with_name::<Matrix>("matrix");
    engine.register_type_with_name::<Number>("number");
    engine.register_type_with_name::<super::tracer::Relation>("relation");
    links(engine, shared, subject);
    robot(engine, shared, subject);
    components(engine);
}

fn links(engine: &mut Engine, shared: &Shared, subject: &Rc<Subject>) {
    let quantities: [(&str, Quantity); 7] = [
        ("mass", |t, b| t.quantity(&b.mass, MASS, true).map(|id| Dynamic::from(Number(id)))),
        ("com", |t, b| Ok(Dynamic::from(center_of_mass(t, b)?))),
        ("first_moment", |t, b| Ok(Dynamic::from(first_moment(t, b)?))),
        ("inertia", |t, b| Ok(Dynamic::from(inertia(t, b)?))),
        ("inertia_at_origin", |t, b| Ok(Dynamic::from(inertia_at_origin(t, b)?))),
        ("principal_moments", |t, b| {
            let inertia = inertia(t, b)?;
            eigenvalues(t, &inertia).map(Dynamic::from)
        }),
        ("pseudo_inertia", |t, b| Ok(Dynamic::from(pseudo_inertia(t, b)?))),
    ];
    for (name, quantity) in quantities {
        let (shared, subject) = (shared.clone(), subject.clone());
        let get = move |context: NativeCallContext, link: &mut LinkView| -> Answer<Dynamic> {
            let mut tracer = shared.borrow_mut();
            tracer.stand(&context);
            quantity(&mut tracer, &subject.bodies[link.0]).map_err(fail)
        };
        engine.register_get(name, get);
    }
    let named = subject.clone();
    engine.register_get("name", move |link: &mut LinkView| named.bodies[link.0].name.clone());
    engine.register_get("number", |link: &mut LinkView| link.0 as i64 + 1);
}

fn robot(engine: &mut Engine, shared: &Shared, subject: &Rc<Subject>) {
    let (state, about) = (shared.clone(), subject.clone());
    engine.register_get("gravity", move |_: &mut RobotView| -> Answer<Vector> {
        let mut tracer = state.borrow_mut();
        let component = |&g: &f64| tracer.quantity(&Affine::constant(g), ACCELERATION, false);
        about.gravity.iter().map(component).collect::<Result<_, _>>().map(Vector).map_err(fail)
    });
    let about = subject.clone();
    engine.register_get("name", move |_: &mut RobotView| about.name.clone());
    let count = subject.bodies.len();
    engine.register_get("links", move |_: &mut RobotView| link_list(0..count));
    let about = subject.clone();
    engine.register_fn("named", move |list: Array, name: &str| -> Answer<LinkView> {
        let views: Vec<LinkView> = list.into_iter().filter_map(|v| v.try_cast::<LinkView>()).collect();
        let found = views.iter().copied().find(|v| about.bodies[v.0].name == name);
        found.ok_or_else(|| {
            let known: Vec<&str> = views.iter().map(|v| about.bodies[v.0].name.as_str()).collect();
            fail(format!("no link `{name}`; known are {}", known.join(", ")))
        })
    });
    let (state, about) = (shared.clone(), subject.clone());
    let total = move |context: NativeCallContext, list: Array| -> Answer<Number> {
        let mut tracer = state.borrow_mut();
        tracer.stand(&context);
        let mut sum = tracer.quantity(&Affine::constant(0.0), MASS, false).map_err(fail)?;
        for value in &list {
            let Some(link) = value.read_lock::<LinkView>() else {
                return Err(fail(format!("`total_mass` takes a list of links, not of {}", kind(value))));
            };
            let mass = tracer.quantity(&about.bodies[link.0].mass, MASS, true).map_err(fail)?;
            sum = tracer.graph.add(sum, mass).map_err(fail)?;
        }
        Ok(Number(sum))
    };
    engine.register_fn("total_mass", total);
}

/// Links as a list for the script.
pub(super) fn link_list(places: impl IntoIterator<Item = usize>) -> Array {
    places.into_iter().map(|i| Dynamic::from(LinkView(i))).collect()
}

fn components(engine: &mut Engine) {
    for (place, name) in ["x", "y", "z"].into_iter().enumerate() {
        engine.register_get(name, move |vector: &mut Vector| -> Answer<Number> {
            let id = vector.0.get(place).copied().filter(|_| vector.0.len() == 3);
            id.map(Number).ok_or_else(|| fail(format!("a vector of {} has no `{name}`", vector.0.len())))
        });
    }
    let entries = [("xx", 0, 0), ("xy", 0, 1), ("xz", 0, 2), ("yy", 1, 1), ("yz", 1, 2), ("zz", 2, 2)];
    for (name, i, j) in entries {
        engine.register_get(name, move |matrix: &mut Matrix| -> Answer<Number> {
            let id = matrix.at(i, j).filter(|_| matrix.size == 3);
            id.map(Number).ok_or_else(|| fail(format!("a matrix of {} rows has no `{name}`", matrix.size)))
        });
    }
}

fn first_moment(tracer: &mut Tracer, body: &Body) -> Result<Vector, String> {
    body.first_moment
        .iter()
        .map(|row| tracer.quantity(row, MOMENT, false))
        .collect::<Result<_, _>>()
        .map(Vector)
}

fn center_of_mass(tracer: &mut Tracer, body: &Body) -> Result<Vector, String> {
    let mass = tracer.quantity(&body.mass, MASS, true)?;
    let moments = first_moment(tracer, body)?;
    moments.0.iter().map(|&m| tracer.graph.divide(m, mass)).collect::<Result<_, _>>().map(Vector)
}

/// Rows of a symmetric 3x3 matrix below the diagonal, as places in `xx xy xz yy yz zz`.
const LOWER: [usize; 6] = [0, 1, 3, 2, 4, 5];

fn inertia_at_origin(tracer: &mut Tracer, body: &Body) -> Result<Matrix, String> {
    let entry = |place: usize| tracer.quantity(&body.inertia_at_origin[place], INERTIA, false);
    Ok(Matrix { size: 3, lower: LOWER.into_iter().map(entry).collect::<Result<_, _>>()? })
}

/// `J - (|mc|² 1 - mc mcᵀ) / m`.
fn inertia(tracer: &mut Tracer, body: &Body) -> Result<Matrix, String> {
    let mass = tracer.quantity(&body.mass, MASS, true)?;
    let moment = first_moment(tracer, body)?.0;
    let at_origin = inertia_at_origin(tracer, body)?;
    let (graph, mut lower) = (&mut tracer.graph, Vec::with_capacity(6));
    for i in 0..3 {
        for j in 0..=i {
            let shift = if i == j {
                let (a, b) = (moment[(i + 1) % 3], moment[(i + 2) % 3]);
                let (a, b) = (graph.multiply(a, a)?, graph.multiply(b, b)?);
                let sum = graph.add(a, b)?;
                graph.negative(sum)?
            } else {
                graph.multiply(moment[i], moment[j])?
            };
            let shift = graph.divide(shift, mass)?;
            let about_origin = at_origin.lower[i * (i + 1) / 2 + j];
            lower.push(graph.add(about_origin, shift)?);
        }
    }
    Ok(Matrix { size: 3, lower: lower.into() })
}

/// `[[tr(J)/2 1 - J, mc], [mcᵀ, m]]`; its entries have different units, so it carries none.
fn pseudo_inertia(tracer: &mut Tracer, body: &Body) -> Result<Matrix, String> {
    let [xx, xy, xz, yy, yz, zz] = &body.inertia_at_origin;
    let half = |plus: &Affine, also: &Affine, minus: &Affine| {
        plus.clone().plus(1.0, also).plus(-1.0, minus).times(0.5)
    };
    let [mx, my, mz] = &body.first_moment;
    let rows = [
        half(yy, zz, xx),
        xy.clone().times(-1.0),
        half(xx, zz, yy),
        xz.clone().times(-1.0),
        yz.clone().times(-1.0),
        half(xx, yy, zz),
        mx.clone(),
        my.clone(),
        mz.clone(),
        body.mass.clone(),
    ];
    let lower: Vec<Id> = rows.iter().map(|r| tracer.quantity(r, None, false)).collect::<Result<_, _>>()?;
    Ok(Matrix { size: 4, lower: lower.into() })
}
