//! What can be hidden: every twin of an effect of the catalogue, and shapes beyond it.

use std::sync::LazyLock;

pub use crate::plant::Scope;
use crate::plant::{Factor, PlantEffect, Product, TWINS, Twin, boxed, neighbour, phase};
use crate::random::Stream;

/// Number of joints of the robot.
const DOF: usize = 7;

/// Who could name it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Known {
    /// The catalogue has it.
    Catalogue,
    /// The catalogue has it not, but a short formula of joint positions and velocities does.
    Formula,
    /// No shipped library of shapes can write it down.
    Nobody,
}

/// A kind of hidden effect.
#[derive(Debug)]
pub struct Family {
    /// Name; in the catalogue where that has it.
    pub name: &'static str,
    /// Who could name it.
    pub known: Known,
    /// What part of a data set it changes.
    pub scope: Scope,
    /// A usual size, in the unit of the number that scales it.
    pub unit: f64,
    /// The largest size that is physical.
    pub limit: f64,
    /// Joints on which it cannot be told, and why.
    not_on: &'static [(usize, &'static str)],
    make: fn(usize, f64, &mut Stream) -> Vec<Box<dyn PlantEffect>>,
}

impl Family {
    /// The family of this name.
    pub fn named(name: &str) -> Option<&'static Self> {
        FAMILIES.iter().find(|family| family.name == name)
    }

    /// The plant's effects at `size` on `joint`, shapes drawn from `stream`.
    pub(super) fn effects(&self, joint: usize, size: f64, stream: &mut Stream) -> Vec<Box<dyn PlantEffect>> {
        (self.make)(joint, size, stream)
    }

    /// Why it cannot be told on this joint of a Panda whatever the motion, or `None` where it can.
    pub(super) fn excluded(&self, joint: usize) -> Option<String> {
        let (_, why) = self.not_on.iter().find(|(not, _)| *not == joint)?;
        Some(format!("{} on joint {} {why}", self.name, joint + 1))
    }

    /// What it depends on, as columns of a log.
    pub(super) fn variables(&self, joint: usize) -> Vec<String> {
        let (own, other, third) = (joint + 1, neighbour(joint) + 1, second(joint) + 1);
        match self.name {
            "detent" | "end_stop" => vec![format!("q{own}")],
            "product" | "piecewise" => vec![format!("q{other}"), format!("dq{own}")],
            "three_variables" => vec![format!("dq{own}"), format!("q{other}"), format!("q{third}")],
            "channel_driven" => vec!["pressure1".to_string(), format!("dq{own}")],
            "intermittent" => vec!["t".to_string()],
            _ => Vec::new(),
        }
    }
}

/// Scope of the family of this name.
pub(super) fn scope(name: &str) -> Scope {
    Family::named(name).map_or(Scope::Joint, |family| family.scope)
}

/// Another one: two before, or three after.
fn second(joint: usize) -> usize {
    joint.checked_sub(2).unwrap_or(joint + 3)
}

/// Middle of each joint's range, where shapes of position are placed \[rad\].
const MIDDLE: [f64; DOF] = [0.0, 0.0, 0.0, -1.57, 0.0, 1.87, 0.0];

fn near_middle(joint: usize, stream: &mut Stream) -> f64 {
    MIDDLE[joint] + stream.between(-0.4, 0.4)
}

/// A twin of the catalogue.
fn known(twin: &Twin) -> Family {
    let Twin { name, scope, unit, limit, not_on, make, .. } = *twin;
    Family { name, known: Known::Catalogue, scope, unit, limit, not_on, make }
}

const fn beyond(
    name: &'static str,
    known: Known,
    unit: f64,
    make: fn(usize, f64, &mut Stream) -> Vec<Box<dyn PlantEffect>>,
) -> Family {
    Family { name, known, scope: Scope::Joint, unit, limit: f64::INFINITY, not_on: &[], make }
}

/// Everything that can be hidden.
pub static FAMILIES: LazyLock<Vec<Family>> =
    LazyLock::new(|| TWINS.iter().map(known).chain(BEYOND).collect());

/// What the catalogue has not.
const BEYOND: [Family; 7] = [
    beyond("detent", Known::Formula, 0.5, |j, s, draw| {
        let (at, width) = (near_middle(j, draw), draw.between(0.06, 0.15));
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Detent { of: j + 1, at, width }] })
    }),
    beyond("end_stop", Known::Formula, 2.0, |j, s, draw| {
        let from = near_middle(j, draw) + 0.3;
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Beyond { of: j + 1, from }] })
    }),
    beyond("product", Known::Formula, 0.5, |j, s, draw| {
        let (k, phase) = (f64::from(1 + (draw.uniform() * 5.0) as u8), phase(draw));
        let wave = Factor::Wave { of: neighbour(j) + 1, k, phase };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Velocity(j + 1), wave] })
    }),
    beyond("piecewise", Known::Nobody, 0.5, |j, s, draw| {
        let of = neighbour(j);
        let a = near_middle(of, draw) - 0.3;
        let points = vec![(a - 0.4, 0.6), (a - 0.05, -1.0), (a + 0.25, 1.0), (a + 0.3, -0.2), (a + 0.9, 0.5)];
        let pieces = Factor::Pieces { of: of + 1, points };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Sign(j + 1), pieces] })
    }),
    beyond("three_variables", Known::Nobody, 0.6, |j, s, draw| {
        let wave = |of: usize, k: f64, phase: f64| Factor::Wave { of: of + 1, k, phase };
        let (one, two) = (wave(neighbour(j), 2.0, phase(draw)), wave(second(j), 3.0, phase(draw)));
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Velocity(j + 1), one, two] })
    }),
    beyond("channel_driven", Known::Nobody, 0.3, |j, s, draw| {
        let (period_s, phase) = (draw.between(5.0, 9.0), phase(draw));
        let channel = Factor::Channel { name: "pressure1".into(), period_s, phase, mean: 0.0 };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![Factor::Sign(j + 1), channel] })
    }),
    beyond("intermittent", Known::Nobody, 0.3, |j, s, draw| {
        // A loose connector: on and off in time, and nothing in the log says when.
        let switch = Factor::OnOff { period_s: draw.between(1.7, 3.1), phase: draw.uniform() };
        boxed(Product { joint: j + 1, amplitude: s, factors: vec![switch] })
    }),
];
