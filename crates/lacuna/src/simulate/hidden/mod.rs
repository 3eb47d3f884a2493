//! Data sets with something hidden in them, for testing a diagnosis: a Panda with realistic friction, sensors and
//! noise, random motions, and effects of a chosen strength on a chosen joint.
//!
//! Strength is what a diagnosis can live on: the root mean square of that part of an effect's torque that the
//! baseline cannot absorb by refitting, over the baseline's residual with nothing hidden (its signs as sharp as the
//! plant's), on the joint that
//! shows it most, in a band of 8 Hz.

mod families;
mod panda;
mod strength;

pub use families::{FAMILIES, Family, Known, Scope};

use crate::effects::{CoulombFriction, Effect, Joints, RigidBody, TorqueOffset, ViscousFriction};
use crate::error::{Error, Result};
use crate::excitation::{FourierMotion, Ramped};
use crate::log::Log;
use crate::plant::PlantEffect;
use crate::random::Stream;
use crate::robot::Robot;

use panda::Ground;
use strength::Yardstick;

/// Logs to fit.
const FIT_LOGS: u64 = 3;
/// Period of the random motions \[s\], five harmonics each.
const PERIOD: f64 = 13.3;
/// Length of run-up and run-out \[s\].
const RAMP: f64 = 0.5;

/// What is to be hidden.
#[derive(Debug, Clone, Copy)]
pub struct Choice {
    /// Which effect.
    pub family: &'static Family,
    /// Index of the joint; effects of the whole robot ignore it.
    pub joint: usize,
    /// Its strength over noise.
    pub strength: f64,
}

/// A data set with hidden effects.
#[derive(Debug)]
pub struct Hidden {
    /// The robot, as its file has it.
    pub robot: Robot,
    /// What a diagnosis starts from: nothing that is hidden is in it.
    pub baseline: Vec<Box<dyn Effect>>,
    /// Logs to fit; what is hidden is in all of them, but for a contact, which is in the first.
    pub fit: Vec<Log>,
    /// Logs of the robot before something changed; empty unless the hidden effect needs two states.
    pub reference: Vec<Log>,
    /// A log of another motion that is never fitted.
    pub unseen: Log,
    /// The logs to fit as they are with nothing hidden: same motions, same noise.
    pub fit_without: Vec<Log>,
    /// The unseen log with nothing hidden.
    pub unseen_without: Log,
    /// What was hidden, in the order of the choices.
    pub secrets: Vec<Secret>,
    /// Residual of the baseline with nothing hidden and signs as sharp as they are, per joint, in a band of 8 Hz [N m].
    pub noise: Vec<f64>,
}

/// One hidden effect.
#[derive(Debug)]
pub struct Secret {
    /// Name of its family.
    pub family: &'static str,
    /// Index of its joint; `None` for the whole robot.
    pub joint: Option<usize>,
    /// Strength that was asked for.
    pub strength: f64,
    /// Its size in the unit of its family.
    pub size: f64,
    /// Names of the variables that it depends on, as columns of a log are called (`q3`, `pressure1`).
    pub variables: Vec<String>,
    /// The plant's effects, with all numbers.
    pub effects: Vec<Box<dyn PlantEffect>>,
}

impl Secret {
    /// Start and end \[s\], for what happens in an interval only.
    pub fn interval(&self) -> Option<(f64, f64)> {
        self.effects.iter().find_map(|effect| effect.interval())
    }
}

/// Answer of [`hidden`].
#[derive(Debug)]
pub enum Draw {
    /// A data set.
    Data(Box<Hidden>),
    /// This cannot be hidden with this strength on this joint, and why.
    Excluded(String),
}

/// A data set with `choices` hidden in it (none, one, or several), all random draws from `seed`.
///
/// # Errors
/// When a joint does not exist, a strength is not positive, or a simulation fails.
pub fn hidden(choices: &[Choice], seed: u64) -> Result<Draw> {
    let robot = panda::robot()?;
    for choice in choices {
        if choice.joint >= robot.dof() || !(choice.strength.is_finite() && choice.strength > 0.0) {
            let what = format!("{} on joint {} at {}", choice.family.name, choice.joint + 1, choice.strength);
            return Err(Error::new(what).help("joints are 0 to 6, strengths are positive"));
        }
        if let Some(reason) = choice.family.excluded(choice.joint) {
            return Ok(Draw::Excluded(reason));
        }
    }
    let ground = Ground::draw(choices, seed);
    let plant = ground.plant(robot.clone())?;
    // Noise is what is left with signs as sharp as they are; whoever diagnoses has to find that out.
    let (baseline, sharp) = (baseline(&robot, choices, 0.0), baseline(&robot, choices, ground.width));
    let motions = (0..FIT_LOGS).map(|number| Ok((motion(&robot, seed, number)?, noise_seed(seed, number))));
    let yardstick = Yardstick::new(&plant, &sharp, motions.collect::<Result<_>>()?)?;
    let mut secrets = Vec::new();
    for (number, choice) in choices.iter().enumerate() {
        match secret(choice, &yardstick, seed, number)? {
            Ok(secret) => secrets.push(secret),
            Err(reason) => return Ok(Draw::Excluded(reason)),
        }
    }
    record(&yardstick, baseline, secrets, seed)
}

/// Sizes one effect by its strength, or says why that cannot be.
fn secret(
    choice: &Choice,
    yardstick: &Yardstick<'_>,
    seed: u64,
    number: usize,
) -> Result<Result<Secret, String>> {
    let Choice { family, joint, strength } = *choice;
    let effects = |size: f64| family.effects(joint, size, &mut shapes(seed, number));
    let size = match family.scope {
        // An event is sized by its force: 2 N are one unit.
        Scope::Event => strength * family.unit,
        _ => yardstick.size(family, effects, joint, strength)?,
    };
    if !(size.is_finite() && size <= family.limit) {
        let what = format!("{} on joint {}", family.name, joint + 1);
        return Ok(Err(format!("{what} would need {size:.3}, beyond what is physical ({})", family.limit)));
    }
    Ok(Ok(Secret {
        family: family.name,
        joint: (family.scope == Scope::Joint).then_some(joint),
        strength,
        size,
        variables: family.variables(joint),
        effects: effects(size),
    }))
}

fn record(
    yardstick: &Yardstick<'_>,
    baseline: Vec<Box<dyn Effect>>,
    secrets: Vec<Secret>,
    seed: u64,
) -> Result<Draw> {
    let plant = yardstick.plant;
    let two_states = secrets.iter().any(|s| families::scope(s.family) == Scope::TwoLogs);
    let states = if two_states { 2 * FIT_LOGS } else { FIT_LOGS };
    let log = |number: u64, with: &dyn Fn(&Secret) -> bool| -> Result<Log> {
        let chosen: Vec<&dyn PlantEffect> =
            secrets.iter().filter(|s| with(s)).flat_map(|s| &s.effects).map(AsRef::as_ref).collect();
        // With nothing hidden the first motions have been recorded to measure the noise.
        if let Some(there) = yardstick.logs.get(number as usize).filter(|_| chosen.is_empty()) {
            return Ok(named(there.clone(), number));
        }
        let motion = motion(&plant.robot, seed, number)?;
        let log = plant.simulate_among(&chosen, &motion, motion.total_s(), noise_seed(seed, number))?.log;
        Ok(named(log, number))
    };
    let event = |s: &Secret| families::scope(s.family) == Scope::Event;
    let all = |number: u64| log(number, &|s| number == 0 || !event(s));
    let without = |number: u64| log(number, &|_| false);
    let (with, clean) = rayon::join(
        || -> Result<(Vec<Log>, Log)> {
            Ok(((0..FIT_LOGS).map(all).collect::<Result<_>>()?, log(2 * FIT_LOGS, &|s| !event(s))?))
        },
        || -> Result<(Vec<Log>, Log)> {
            Ok(((0..states).map(without).collect::<Result<_>>()?, without(2 * FIT_LOGS)?))
        },
    );
    let ((fit, unseen), (mut fit_without, unseen_without)) = (with?, clean?);
    let reference = fit_without.split_off(FIT_LOGS as usize);
    let robot = plant.robot.clone();
    Ok(Draw::Data(Box::new(Hidden {
        robot,
        baseline,
        fit,
        reference,
        unseen,
        fit_without,
        unseen_without,
        secrets,
        noise: yardstick.noise.clone(),
    })))
}

fn named(log: Log, number: u64) -> Log {
    Log { name: format!("log {}", number + 1), ..log }
}

/// Random motion number `number` of a data set.
fn motion(robot: &Robot, seed: u64, number: u64) -> Result<Ramped<FourierMotion>> {
    let own = noise_seed(seed, 1000 + number);
    let amplitude = Stream::new(own, 99).between(0.5, 0.8);
    Ramped::new(FourierMotion::random(robot, own, 5, PERIOD, amplitude)?, PERIOD, RAMP)
}

/// A seed of its own for every use.
fn noise_seed(seed: u64, number: u64) -> u64 {
    // An odd factor far from small integers keeps neighbours apart; the generator mixes the rest.
    seed.wrapping_mul(0x9E37_79B9_7F4A_7C15).wrapping_add(number)
}

/// Random shape parameters of the effect with this number.
fn shapes(seed: u64, number: usize) -> Stream {
    Stream::new(noise_seed(seed, 2000 + number as u64), 0)
}

/// The classical model without what is hidden, its signs smoothed over `width` [rad/s].
fn baseline(robot: &Robot, choices: &[Choice], width: f64) -> Vec<Box<dyn Effect>> {
    let others = |family: &str| {
        let hidden = |j: usize| choices.iter().any(|c| c.family.name == family && c.joint == j);
        if !(0..robot.dof()).any(hidden) {
            return Joints::All;
        }
        let names = robot.joints.iter().enumerate().filter(|(j, _)| !hidden(*j));
        Joints::Only(names.map(|(_, joint)| joint.name.clone()).collect())
    };
    vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction { joints: others(ViscousFriction::ABOUT.name) }),
        Box::new(CoulombFriction { joints: others(CoulombFriction::ABOUT.name), width }),
        Box::new(TorqueOffset { joints: others(TorqueOffset::ABOUT.name) }),
    ]
}
