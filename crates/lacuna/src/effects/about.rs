//! What an effect says about itself. Diagnosis, pictures, exports and people ask here, and nobody asks by name.

use serde::Serialize;

use super::{Own, Shape, Term};

/// What an effect says about itself; printed by `lacuna list effects NAME`. All of it has to be said, since what a
/// search may believe hangs on it; only [`Special`] is what few effects have.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct About {
    /// Name in RON, JSON and on the command line.
    pub name: &'static str,
    /// One line for the catalogue.
    pub title: &'static str,
    /// What it is and how it shows in data.
    pub text: &'static str,
    /// Torque on joint j as a formula.
    pub equation: &'static str,
    /// Linear parameters and shapes, with the values that can be physics.
    pub parameters: &'static [Parameter],
    /// What usually causes it in a robot.
    pub cause: &'static str,
    /// Effects it is easily mistaken for, and why.
    pub confused_with: &'static str,
    /// The motion that tells it from these.
    pub separation: Separation,
    /// An entry of a scenario's `effects`, in RON.
    pub example: &'static str,
    /// The variable it is drawn against.
    pub drawn_against: Variable,
    /// What it does where a joint turns round.
    pub at_rest: AtRest,
    /// What it acts on, and so where a diagnosis tries it.
    pub reach: Reach,
    /// At which stage of the search it is tried.
    pub stage: Stage,
    /// What imitates it without being physics; a search is careful there.
    pub imitated_by: &'static [Imitation],
    /// What few effects have.
    pub special: Special,
}

impl About {
    /// A motion in which two effects differ: what one of them knows of the other, else what the more particular of
    /// both asks for.
    pub fn motion_between(&self, other: &Self) -> &'static str {
        let beside = |a: &Self, b: &Self| {
            a.separation.beside.iter().find(|(name, _)| *name == b.name).map(|(_, motion)| *motion)
        };
        let first =
            if other.separation.asks < self.separation.asks { other.separation } else { self.separation };
        beside(self, other).or_else(|| beside(other, self)).unwrap_or(first.motion)
    }

    /// Whether something imitates it.
    pub fn is_imitated_by(&self, what: Imitation) -> bool {
        self.imitated_by.contains(&what)
    }

    /// What values of the linear parameters, in the order of `terms`, or of the shapes would mean, where they cannot be.
    pub fn impossible(&self, terms: &[Term], shapes: &[Shape], values: &[f64]) -> Option<&'static str> {
        self.broken(terms, shapes, values, false)
    }

    /// What they probably mean, where they can be and are odd.
    pub fn suspect(&self, terms: &[Term], shapes: &[Shape], values: &[f64]) -> Option<&'static str> {
        self.broken(terms, shapes, values, true)
    }

    /// The first bound that is broken, of those that are `odd` or not: least values first.
    fn broken(&self, terms: &[Term], shapes: &[Shape], values: &[f64], odd: bool) -> Option<&'static str> {
        let is_shape = |p: &&Parameter| shapes.iter().any(|s| p.symbol == s.symbol);
        let linear: Vec<&Parameter> = self.parameters.iter().filter(|p| !is_shape(p)).collect();
        let of_term = |symbol: &str| match linear.as_slice() {
            [only] => Some(*only),
            _ => self.parameter(symbol),
        };
        let of_terms = terms.iter().zip(values).filter_map(|(term, x)| Some((of_term(&term.symbol)?, *x)));
        let of_shapes = shapes.iter().filter_map(|s| Some((self.parameter(s.symbol)?, s.value)));
        let all: Vec<(&Parameter, f64)> = of_terms.chain(of_shapes).collect();
        let low = all.iter().filter_map(|(p, x)| p.least.filter(|bound| !(*x >= bound.at)));
        let high = all.iter().filter_map(|(p, x)| p.most.filter(|bound| !(*x <= bound.at)));
        low.chain(high).find(|bound| bound.odd == odd).map(|bound| bound.beyond)
    }

    /// The parameter that a term or shape called `symbol` is one of; terms end in the number of their joint.
    fn parameter(&self, symbol: &str) -> Option<&'static Parameter> {
        let called = |p: &&Parameter| p.symbol.split(", ").any(|own| symbol.starts_with(own));
        self.parameters.iter().filter(called).max_by_key(|p| p.symbol.len())
    }
}

/// A linear parameter or shape of an effect.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Parameter {
    /// Symbol as in the equation; several that belong together are separated by commas.
    pub symbol: &'static str,
    /// Unit; `1` for none.
    pub unit: &'static str,
    /// What it means.
    pub meaning: &'static str,
    /// Least value that can be, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub least: Option<Bound>,
    /// Largest value that can be, where there is one.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub most: Option<Bound>,
}

/// An end of what can be.
#[derive(Debug, Clone, Copy, PartialEq, Serialize)]
pub struct Bound {
    /// The last value that can be, in the parameter's unit.
    pub at: f64,
    /// What a value beyond would mean.
    pub beyond: &'static str,
    /// Whether a value beyond cannot be physics, or is only odd: possible, but probably something else.
    pub odd: bool,
}

impl Parameter {
    /// A parameter that may have any value.
    pub const fn new(symbol: &'static str, unit: &'static str, meaning: &'static str) -> Self {
        Self { symbol, unit, meaning, least: None, most: None }
    }

    /// The same with a least value that can be physics, and what less would mean.
    #[must_use]
    pub const fn at_least(self, at: f64, beyond: &'static str) -> Self {
        Self { least: Some(Bound { at, beyond, odd: false }), ..self }
    }

    /// The same with a largest value that can be physics, and what more would mean.
    #[must_use]
    pub const fn at_most(self, at: f64, beyond: &'static str) -> Self {
        Self { most: Some(Bound { at, beyond, odd: false }), ..self }
    }

    /// The same with values from `-size` to `size`, and what others would mean.
    #[must_use]
    pub const fn within(self, size: f64, beyond: &'static str) -> Self {
        self.at_least(-size, beyond).at_most(size, beyond)
    }

    /// The same with a value below which it probably is something else, and what.
    #[must_use]
    pub const fn odd_below(self, at: f64, beyond: &'static str) -> Self {
        Self { least: Some(Bound { at, beyond, odd: true }), ..self }
    }

    /// The bound that a value is beyond, if any; what is no number is beyond any.
    pub fn broken(&self, value: f64) -> Option<Bound> {
        let low = self.least.filter(|bound| !(value >= bound.at));
        low.or_else(|| self.most.filter(|bound| !(value <= bound.at)))
    }
}

/// The motion that tells an effect from those it is confused with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Separation {
    /// What such a motion must offer.
    pub asks: Asks,
    /// The motion in words.
    pub motion: &'static str,
    /// Effects that ask for a motion of their own, by name.
    pub beside: &'static [(&'static str, &'static str)],
}

impl Separation {
    /// Crawling and fast.
    pub const SPEEDS: Self = Self::new(Asks::Speeds, "a wider range of speeds, from crawling to full speed");
    /// Far, with gravity on either side.
    pub const FAR: Self = Self::new(
        Asks::Far,
        "a large range of that joint, and poses with opposite signs of the gravity torque",
    );
    /// The same way at two speeds.
    pub const TWICE: Self =
        Self::new(Asks::Twice, "the whole range of the joint at two different speeds, in both directions");
    /// Long, or cold and warm.
    pub const LONG: Self =
        Self::new(Asks::Long, "a longer log, or the same motion cold and warm, with temperatures logged");
    /// Nothing in particular.
    pub const OTHER: Self =
        Self::new(Asks::Other, "a motion of that joint with other speeds and in other poses");

    /// A motion in words.
    pub const fn new(asks: Asks, motion: &'static str) -> Self {
        Self { asks, motion, beside: &[] }
    }
}

/// What a motion must offer to tell an effect from others. Where two effects ask for different ones, the one that
/// stands first here is more particular and serves both.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Asks {
    /// Reversals below some speed.
    SlowReversals,
    /// A load that is known.
    KnownLoad,
    /// Fast motion of one joint.
    Fast,
    /// The same speeds under different loads.
    Loads,
    /// A long way, gravity on either side.
    Far,
    /// Many speeds.
    Speeds,
    /// The same way at different speeds.
    Twice,
    /// A long time.
    Long,
    /// Anything else.
    Other,
}

/// The variable that an effect is made of, as far as it is one.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Variable {
    /// The joint's position.
    Position,
    /// The joint's velocity.
    Velocity,
    /// The joint's acceleration.
    Acceleration,
    /// The measured torque of the joint.
    Load,
    /// Time.
    Time,
}

impl Variable {
    /// Its name in pictures: `dq3`, `load`, `time`.
    pub fn of_joint(self, joint: usize) -> String {
        match self {
            Self::Position => format!("q{}", joint + 1),
            Self::Velocity => format!("dq{}", joint + 1),
            Self::Acceleration => format!("ddq{}", joint + 1),
            Self::Load => "load".to_string(),
            Self::Time => "time".to_string(),
        }
    }
}

/// What an effect does where a joint turns round.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum AtRest {
    /// It passes through rest without a step.
    Smooth,
    /// It steps, at every reversal the same way. Nobody knows how sharply, so a search allows for a sharper or softer
    /// step beside it.
    Step,
    /// It steps by an amount that changes its own sign (along the way, with time, with another joint), of which the
    /// sharpness of the step says little.
    ChangingStep,
}

/// What an effect acts on, and so where a diagnosis tries it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Reach {
    /// The torque of a joint; tried on every joint alone.
    Joint,
    /// The torque of a joint, by the motion of another; tried on pairs.
    Pair,
    /// A fault of a joint that others feel; tried on every joint alone.
    JointFeltByOthers,
    /// The torque of a joint, or of all of them by one parameter; tried on every joint alone and on all together.
    JointOrAll,
    /// A claim about the whole robot; tried once.
    Robot,
}

/// At which stage of a search an effect is tried.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Stage {
    /// Never, because every model has it: the rigid links, whose parameters are reduced to those that show.
    InEveryModel,
    /// With the others, but taken first: while plain friction is missing, everything else looks strange.
    First,
    /// With all others.
    Usual,
    /// Before all others, as what happens between two times only.
    Event,
    /// Only where somebody gives it.
    Given,
}

/// What imitates an effect without being physics.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Imitation {
    /// Noise of the acceleration: the effect must survive a position filter of half the cut-off.
    AccelerationNoise,
    /// A causal filter, a bus, or the log's clock: on all joints it is mended in the logs before anything else is
    /// looked for, and less than the clock can tell is not told.
    Clock,
    /// Any course over time: the effect is no more than a curve, and gives way to a formula that fits better.
    CourseOfTime,
}

/// What columns are computed from.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum BuiltFrom {
    /// The motion, and what else was logged.
    Motion,
    /// The model's own torque as well ([`super::Stretch::model_torque`]): fitted in turns with it until both agree.
    ModelTorque,
    /// The model's own torque, of which it changes what sensors say (a gain, a delay): not part of
    /// [`crate::signals::ModelTorque::total`], because it is built from that.
    Measurement,
}

/// What few effects have; the others write [`Special::NONE`].
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Special {
    /// What its columns are computed from.
    pub built_from: BuiltFrom,
    /// What everybody who reads its numbers must know.
    pub caveat: Option<&'static str>,
    /// Whether gravity comes from another side with it, which shows where the first link has its mass.
    pub leans: bool,
    /// It is a wave over the joint's position times this factor of its velocity: formulas of that form are left to it.
    pub wave: Option<Own>,
    /// What other programs can take of it.
    pub exports: Exports,
}

impl Special {
    /// Built from motion, and nothing else to say.
    pub const NONE: Self = Self {
        built_from: BuiltFrom::Motion,
        caveat: None,
        leans: false,
        wave: None,
        exports: Exports::NOWHERE,
    };
}

/// As what other programs can take an effect; empty where they cannot.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
pub struct Exports {
    /// MuJoCo.
    pub mujoco: &'static str,
    /// Isaac Lab.
    pub isaaclab: &'static str,
    /// Gazebo.
    pub gazebo: &'static str,
    /// Drake.
    pub drake: &'static str,
    /// Code in C.
    pub c: &'static str,
    /// Which number of a joint its parameter is in robot files.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub joint: Option<OfJoint>,
}

impl Exports {
    /// Nobody takes it.
    pub const NOWHERE: Self = Self { mujoco: "", isaaclab: "", gazebo: "", drake: "", c: "", joint: None };
}

/// Numbers of a joint in robot files.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum OfJoint {
    /// Torque per velocity.
    Damping,
    /// Dry friction.
    Friction,
}
