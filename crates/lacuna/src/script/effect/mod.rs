//! Effect scripts: causes of joint torque that need no compiler.
//!
//! A script says in `fn about()` what it is and which parameters it has, in `fn columns(joint, now, memory, with)`
//! what torque a unit of each parameter makes at one sample, and, where it has a memory, in `fn remember(joint, now,
//! memory, with)` how that goes on from sample to sample. Both run once per joint, on numbers that remember how
//! they were made; samples go through the flat program that comes out, and nothing is interpreted any more.

mod about;
mod sample;

pub use about::{EffectAbout, EffectParameter, EffectShape};
pub use sample::Input;
pub(super) use sample::{JointView, Moment, PROPERTIES};

use std::collections::BTreeMap;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::Path;
use std::rc::Rc;

use rhai::{Array, Dynamic, Map};

use super::budget::{Clock, MOST_BYTES, TOO_LARGE, Usage};
use super::engine::{Limits, Machine};
use super::graph::Id;
use super::paths::{Taken, ways};
use super::program::Flow;
use super::rules::choice;
use super::tracer::{Number, kind};
use super::{Script, Settings, trouble};
use crate::error::{Error, Result};
use crate::stop::Stop;
use sample::{Inputs, unknown};

/// Functions an effect script may define, with the number of their arguments; the last only with a memory.
const FUNCTIONS: [(&str, usize, &str); 3] = [
    ("about", 0, "fn about() { #{ title: \"..\", .. } }"),
    ("columns", 4, "fn columns(joint, now, memory, with) { [ .. ] }"),
    ("remember", 4, "fn remember(joint, now, memory, with) { #{ .. } }"),
];

/// An effect that a script states, with its settings in force.
#[derive(Debug, Clone)]
pub struct EffectScript {
    script: Script,
    about: EffectAbout,
    settings: Settings,
    needs_torque: bool,
    used: Usage,
    key: u64,
}

/// The columns of one joint, ready to be computed sample by sample; plain data that threads share.
#[derive(Debug, Clone)]
pub struct JointColumns {
    /// What the columns depend on; values are handed over in this order.
    pub inputs: Vec<Input>,
    columns: Flow,
    memory: Flow,
    /// Where the script's `columns` and `remember` stand.
    places: [(usize, usize); 2],
}

impl JointColumns {
    /// One value per parameter, from values of the inputs; `room` is room to work in.
    pub(crate) fn columns(
        &self,
        inputs: &[f64],
        room: &mut Vec<f64>,
        out: &mut [f64],
        clock: &mut Clock<'_>,
    ) -> Result<()> {
        let [place, _] = self.places;
        self.columns.run(inputs, room, out, clock).map_err(|halt| clock.error(halt, "columns", place))
    }

    /// The memory at this sample, from values of the inputs with the memory of the sample before.
    pub(crate) fn remember(
        &self,
        inputs: &[f64],
        room: &mut Vec<f64>,
        out: &mut [f64],
        clock: &mut Clock<'_>,
    ) -> Result<()> {
        let [_, place] = self.places;
        self.memory.run(inputs, room, out, clock).map_err(|halt| clock.error(halt, "remember", place))
    }

    /// Where the script says how its memory goes on.
    pub(crate) fn place_of_memory(&self) -> (usize, usize) {
        self.places[1]
    }
}

impl EffectScript {
    /// Reads what the script says about itself.
    ///
    /// # Errors
    /// With file, line and column when the script is none, or says something that cannot be.
    pub fn new(script: Script, with: &Settings) -> Result<Self> {
        let used = Usage::default();
        let read = || -> Result<(EffectAbout, Settings, bool)> {
            let limits = Limits { used: used.clone(), ..Limits::default() };
            let (machine, _) = machine(&script, &Rc::from([]), &limits)?;
            check(&machine)?;
            let about = about::read(&machine, machine.call("about", (), limits.seconds)?)?;
            let settings = machine.settings(with, &limits)?;
            if let Some(shape) = about.shapes.iter().find(|s| settings.contains_key(&s.symbol)) {
                let (line, column) = machine.place("about");
                return Err(Error::new(format!("`{}` is both a shape and a setting", shape.symbol))
                    .at(line, column)
                    .help("give one of them another name"));
            }
            let remembers = machine.dialect.functions.contains_key("remember");
            if remembers == about.memory.is_empty() {
                return Err(forgetful(&machine, remembers));
            }
            Ok((about, settings, machine.dialect.mentions.contains("load")))
        };
        let (about, settings, needs_torque) = read().map_err(|e: Error| e.in_file(script.file()))?;
        let key = key(&script);
        Ok(Self { script, about, settings, needs_torque, used, key })
    }

    /// What it has used up so far, but for work that counts by itself.
    pub fn used(&self) -> &Usage {
        &self.used
    }

    /// Begins to count what it does with data in the work that `stop` ends, within so many seconds.
    pub(crate) fn clock<'a>(&'a self, seconds: f64, stop: &'a Stop) -> Clock<'a> {
        Clock::start(&self.used, self.key, seconds, stop)
    }

    /// What the script says about itself.
    pub fn about(&self) -> &EffectAbout {
        &self.about
    }

    /// The settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The script's file, as it was named.
    pub fn file(&self) -> &Path {
        self.script.file()
    }

    /// The script.
    pub fn text(&self) -> &str {
        &self.script.text
    }

    /// Whether the script speaks of `load`, the torque of the model's rigid links.
    pub fn needs_torque(&self) -> bool {
        self.needs_torque
    }

    /// The columns of a joint of a robot whose joints have these names.
    ///
    /// # Errors
    /// With file, line and column when the script does not stop, returns something else than one number per
    /// parameter, or names a joint that is not there.
    pub fn joint(&self, joints: &[String], joint: usize, limits: &Limits) -> Result<JointColumns> {
        let lower = || -> Result<JointColumns> {
            let (machine, inputs) = machine(&self.script, &Rc::from(joints), limits)?;
            let mut trace =
                Trace { effect: self, machine: &machine, inputs: &inputs, limits, joint, runs: 0 };
            let columns = trace.flow("columns")?;
            let memory =
                if self.about.memory.is_empty() { Flow::default() } else { trace.flow("remember")? };
            let places = ["columns", "remember"].map(|function| machine.place(function));
            let kept = columns.size() + memory.size();
            if limits.used.bytes() + kept > MOST_BYTES {
                let (line, column) = places[0];
                return Err(trouble::stated(TOO_LARGE.into()).at(line, column));
            }
            limits.used.keep(kept);
            Ok(JointColumns { inputs: inputs.borrow().clone(), columns, memory, places })
        };
        lower().map_err(|e: Error| e.in_file(self.script.file()))
    }
}

/// Tells scripts apart, whoever reads them.
fn key(script: &Script) -> u64 {
    let mut hasher = DefaultHasher::new();
    (&script.file, &script.text).hash(&mut hasher);
    hasher.finish()
}

fn machine(script: &Script, joints: &Rc<[String]>, limits: &Limits) -> Result<(Machine, Inputs)> {
    let inputs = Inputs::default();
    let machine =
        script.compile(limits, |engine, shared| sample::register(engine, shared, &inputs, joints))?;
    Ok((machine, inputs))
}

fn check(machine: &Machine) -> Result<()> {
    for (name, arguments, signature) in FUNCTIONS {
        match machine.dialect.functions.get(name) {
            Some(defined) if defined.arguments.len() != arguments => {
                return Err(Error::new(format!("`{name}` takes {arguments} arguments"))
                    .at(defined.spot.0, defined.spot.1)
                    .help(format!("write `{signature}`")));
            }
            None if name != "remember" => {
                return Err(Error::new(format!("the script of an effect has no `{name}`"))
                    .at(1, 1)
                    .help(format!("write `{signature}`")));
            }
            _ => {}
        }
    }
    Ok(())
}

fn forgetful(machine: &Machine, remembers: bool) -> Error {
    let (what, place) = if remembers {
        ("`remember` is there, but `about` lists no memory", machine.place("remember"))
    } else {
        ("`about` lists a memory, but there is no `remember`", machine.place("about"))
    };
    Error::new(what).at(place.0, place.1).help(
        "memory: #{ heat: 0.0 } in `about` says what is kept and how it starts, and `fn remember(joint, now, memory, \
         with)` returns a map with what it is now",
    )
}

/// Running the script's functions for one joint.
struct Trace<'a> {
    effect: &'a EffectScript,
    machine: &'a Machine,
    inputs: &'a Inputs,
    limits: &'a Limits,
    joint: usize,
    runs: usize,
}

impl Trace<'_> {
    /// What `function` computes, over all ways through it.
    fn flow(&mut self, function: &'static str) -> Result<Flow> {
        let mut runs = self.runs;
        let too_many = || {
            let (line, column) = self.machine.place(function);
            Error::new(format!("`{function}` compares what is known at run time in too many combinations"))
                .at(line, column)
                .help("use `min`, `max`, `abs` or `sign`, or fewer `if`s")
        };
        let all = ways(self.machine, (&mut runs, self.limits.runs), too_many, || self.once(function))?;
        self.runs = runs;
        let taken: Vec<&Taken> = all.iter().map(|(taken, _)| taken).collect();
        let count = all.first().map_or(0, |(_, ids)| ids.len());
        let mut tracer = self.machine.shared.borrow_mut();
        let (line, column) = self.machine.place(function);
        let roots: Vec<Id> = (0..count)
            .map(|i| {
                let ids: Vec<Id> = all.iter().map(|(_, ids)| ids[i]).collect();
                choice(&mut tracer.graph, &taken, &ids, 0)
            })
            .collect::<Result<Vec<Id>, String>>()
            .map_err(|what| Error::new(what).at(line, column))?;
        Ok(Flow::new(&tracer.graph, &roots))
    }

    fn once(&self, function: &'static str) -> Result<Vec<Id>> {
        let arguments = (JointView(self.joint), Moment(self.joint), self.memory()?, self.with()?);
        let returned = self.machine.call(function, arguments, self.limits.seconds)?;
        let values = match function {
            "columns" => self.column_values(returned),
            _ => self.memory_values(returned),
        };
        let (line, column) = self.machine.place(function);
        if let Some((line, column)) = self.machine.shared.borrow().unused() {
            return Err(Error::new("this comparison decides nothing")
                .at(line, column)
                .help("compare after `if`, or ask `holds(relation)`"));
        }
        values.map_err(|e| if e.place().is_some() { e } else { e.at(line, column) })
    }

    fn memory(&self) -> Result<Map> {
        let mut tracer = self.machine.shared.borrow_mut();
        let names = self.effect.about.memory.iter().enumerate();
        names
            .map(|(i, (name, _))| Ok((name.as_str().into(), self.unknown(&mut tracer, Input::Memory(i))?)))
            .collect()
    }

    fn with(&self) -> Result<Map> {
        let mut with: Map =
            self.effect.settings.iter().map(|(name, value)| (name.as_str().into(), value.value())).collect();
        let mut tracer = self.machine.shared.borrow_mut();
        for (i, shape) in self.effect.about.shapes.iter().enumerate() {
            with.insert(shape.symbol.as_str().into(), self.unknown(&mut tracer, Input::Shape(i))?);
        }
        Ok(with)
    }

    fn unknown(&self, tracer: &mut super::tracer::Tracer, input: Input) -> Result<Dynamic> {
        unknown(tracer, self.inputs, input).map(Dynamic::from).map_err(Error::new)
    }

    /// One number per parameter, in their order; a single one may stand alone.
    fn column_values(&self, returned: Dynamic) -> Result<Vec<Id>> {
        let parameters = &self.effect.about.parameters;
        let found = kind(&returned);
        let list = match returned.try_cast_result::<Array>() {
            Ok(list) => list,
            Err(value) if parameters.len() == 1 => vec![value],
            Err(_) => return Err(Error::new(format!("`columns` returns {found}")).help(self.wanted())),
        };
        if list.len() != parameters.len() {
            return Err(Error::new(format!(
                "`columns` returns {} numbers for {} parameters",
                list.len(),
                parameters.len()
            ))
            .help(self.wanted()));
        }
        list.iter().map(|value| self.number("columns", value)).collect()
    }

    fn wanted(&self) -> String {
        let symbols: Vec<&str> = self.effect.about.parameters.iter().map(|p| p.symbol.as_str()).collect();
        format!("its last line is a list of numbers, one for each of {}", symbols.join(", "))
    }

    /// The new memory, whole.
    fn memory_values(&self, returned: Dynamic) -> Result<Vec<Id>> {
        let names: Vec<&str> = self.effect.about.memory.iter().map(|m| m.0.as_str()).collect();
        let wanted = || format!("its last line is a map with {}", names.join(", "));
        let found = kind(&returned);
        let Some(map) = returned.try_cast::<Map>() else {
            return Err(Error::new(format!("`remember` returns {found}")).help(wanted()));
        };
        let mut map: BTreeMap<String, Dynamic> = map.into_iter().map(|(k, v)| (k.to_string(), v)).collect();
        let values = names.iter().map(|name| match map.remove(*name) {
            Some(value) => self.number("remember", &value),
            None => Err(Error::new(format!("`remember` forgets `{name}`")).help(wanted())),
        });
        let values = values.collect::<Result<Vec<Id>>>()?;
        match map.keys().next() {
            Some(name) => {
                Err(Error::new(format!("`remember` returns `{name}`, which is not in memory")).help(wanted()))
            }
            None => Ok(values),
        }
    }

    fn number(&self, function: &str, value: &Dynamic) -> Result<Id> {
        if let Some(number) = value.read_lock::<Number>() {
            return Ok(number.0);
        }
        let operand = self.machine.shared.borrow_mut().operand(value);
        match operand {
            Some(id) => id.map_err(Error::new),
            None => Err(Error::new(format!("`{function}` returns {} among its numbers", kind(value)))
                .help("a comparison is true or false: write `if`, `sign(x)`, `min` or `max`")),
        }
    }
}
