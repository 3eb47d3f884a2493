//! One moment of a motion as an effect script sees it.

use std::cell::RefCell;
use std::rc::Rc;

use rhai::{Dynamic, Engine, NativeCallContext};

use crate::form::Affine;
use crate::script::tracer::{Answer, Number, Shared, Tracer, fail, kind};

/// What a column can depend on. Joints count from 0.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Input {
    /// Time since the run began \[s\].
    Time,
    /// Sampling time \[s\].
    Step,
    /// Position of a joint [rad, m].
    Position(usize),
    /// Its velocity [rad/s, m/s].
    Velocity(usize),
    /// Its velocity, less filtered: for signs, sizes and steps at rest [rad/s, m/s].
    SharpVelocity(usize),
    /// Its acceleration [rad/s², m/s²].
    Acceleration(usize),
    /// Torque of the model's rigid links: what the joint carries without friction [N m, N].
    Load(usize),
    /// A named channel of the log: that of the joint (`temperature3`) where there is one, else that of the
    /// whole robot (`temperature`).
    Channel {
        /// Name without the joint's number.
        name: String,
        /// The joint.
        joint: usize,
    },
    /// What is remembered, by its place in [`super::EffectAbout::memory`].
    Memory(usize),
    /// A shape, by its place in [`super::EffectAbout::shapes`].
    Shape(usize),
}

/// Inputs in the order of their first use; an input's place is its number among the unknowns.
pub(super) type Inputs = Rc<RefCell<Vec<Input>>>;

/// An input by its joint.
type OfJoint = fn(usize) -> Input;

/// The joint whose columns are asked for.
#[derive(Debug, Clone, Copy)]
pub(in crate::script) struct JointView(pub(super) usize);

/// The moment at hand, seen from a joint.
#[derive(Debug, Clone, Copy)]
pub(in crate::script) struct Moment(pub(super) usize);

/// Properties of what effect scripts get, for error messages.
pub(in crate::script) const PROPERTIES: [(&str, &str); 2] = [
    ("joint", "name, number"),
    (
        "moment",
        "t, dt, q, dq, dq_sharp (less filtered: for signs and steps), ddq, load (torque of the rigid links), joint(\"name\" or \
         number), channel(\"name\")",
    ),
];

/// The unknown that stands for an input.
pub(super) fn unknown(tracer: &mut Tracer, inputs: &Inputs, input: Input) -> Result<Number, String> {
    let mut inputs = inputs.borrow_mut();
    let place = inputs.iter().position(|known| *known == input).unwrap_or_else(|| {
        inputs.push(input);
        inputs.len() - 1
    });
    tracer.quantity(&Affine::variable(place), None, false).map(Number)
}

/// Makes joints and moments known.
pub(super) fn register(engine: &mut Engine, shared: &Shared, inputs: &Inputs, joints: &Rc<[String]>) {
    engine.register_type_with_name::<JointView>("joint");
    engine.register_type_with_name::<Moment>("moment");
    engine.register_type_with_name::<Number>("number");
    let names = joints.clone();
    engine.register_get("name", move |joint: &mut JointView| names[joint.0].clone());
    engine.register_get("number", |joint: &mut JointView| joint.0 as i64 + 1);
    let quantities: [(&str, OfJoint); 7] = [
        ("t", |_| Input::Time),
        ("dt", |_| Input::Step),
        ("q", Input::Position),
        ("dq", Input::Velocity),
        ("dq_sharp", Input::SharpVelocity),
        ("ddq", Input::Acceleration),
        ("load", Input::Load),
    ];
    for (name, input) in quantities {
        let (shared, inputs) = (shared.clone(), inputs.clone());
        engine.register_get(name, move |context: NativeCallContext, moment: &mut Moment| -> Answer<Number> {
            let mut tracer = shared.borrow_mut();
            tracer.stand(&context);
            unknown(&mut tracer, &inputs, input(moment.0)).map_err(fail)
        });
    }
    let (state, inputs) = (shared.clone(), inputs.clone());
    engine.register_fn("channel", move |moment: &mut Moment, name: &str| -> Answer<Number> {
        let channel = Input::Channel { name: name.to_string(), joint: moment.0 };
        unknown(&mut state.borrow_mut(), &inputs, channel).map_err(fail)
    });
    let names = joints.clone();
    engine.register_fn("joint", move |_: &mut Moment, which: Dynamic| -> Answer<Moment> {
        find(&names, &which).map(Moment).map_err(fail)
    });
}

fn find(names: &[String], which: &Dynamic) -> Result<usize, String> {
    let known = || format!("known are {}, or numbers 1 to {}", names.join(", "), names.len());
    if let Ok(number) = which.as_int() {
        let place = usize::try_from(number).ok().and_then(|n| n.checked_sub(1)).filter(|&j| j < names.len());
        return place.ok_or_else(|| format!("no joint {number}; {}", known()));
    }
    match which.as_immutable_string_ref() {
        Ok(name) => {
            let place = names.iter().position(|n| n.as_str() == name.as_str());
            place.ok_or_else(|| format!("no joint `{}`; {}", name.as_str(), known()))
        }
        Err(_) => Err(format!("`joint` takes a name or a number, not {}", kind(which))),
    }
}
