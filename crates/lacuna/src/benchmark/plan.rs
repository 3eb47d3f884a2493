//! Which draws a part of the examination consists of.

use crate::random::Stream;
use crate::simulate::hidden::{Choice, FAMILIES, Family, Known, Scope};

/// Joints of the robot that effects are hidden in.
const JOINTS: usize = 7;
/// Force of a hidden contact in units of 2 N.
const CONTACT: f64 = 1.0;

/// A part of the examination.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Part {
    /// Nothing is hidden.
    Nothing,
    /// One effect of the catalogue at three times the noise.
    Strong,
    /// One effect of the catalogue as large as the noise.
    Even,
    /// One effect of the catalogue at 0.4 times the noise.
    Weak,
    /// Two effects of the catalogue at twice the noise.
    Pairs,
    /// A contact of 2 N in an interval.
    Contact,
    /// What the catalogue has not, at three times the noise.
    Outside,
    /// A few of each, for a quick look.
    Small,
}

/// All parts, with the name that the command line knows and the number of rounds of a full run.
pub const PARTS: [(Part, &str, usize); 8] = [
    (Part::Nothing, "nothing", 100),
    (Part::Strong, "strong", 3),
    (Part::Even, "even", 3),
    (Part::Weak, "weak", 3),
    (Part::Pairs, "pairs", 16),
    (Part::Contact, "contact", 5),
    (Part::Outside, "outside", 5),
    (Part::Small, "small", 1),
];

impl Part {
    /// The part of this name.
    pub fn named(name: &str) -> Option<Self> {
        PARTS.iter().find(|(_, known, _)| *known == name).map(|(part, _, _)| *part)
    }

    /// Its name.
    pub fn name(self) -> &'static str {
        PARTS.iter().find(|(part, _, _)| *part == self).map_or("", |(_, name, _)| name)
    }

    /// Rounds of a full run: data sets where nothing or a contact or a pair is hidden, otherwise seeds for
    /// every family.
    pub fn rounds(self) -> usize {
        PARTS.iter().find(|(part, _, _)| *part == self).map_or(1, |(_, _, rounds)| *rounds)
    }
}

/// One data set to be made and examined.
#[derive(Debug, Clone)]
pub struct Item {
    /// The part it belongs to.
    pub part: Part,
    /// Its place in that part.
    pub number: usize,
    /// Seed of its data.
    pub seed: u64,
    /// What is hidden.
    pub choices: Vec<Choice>,
}

/// The draws of a part: everything random comes from `seed`.
pub fn plan(part: Part, rounds: usize, seed: u64) -> Vec<Item> {
    match part {
        Part::Nothing => repeated(part, rounds, seed, |_| Vec::new()),
        Part::Strong => each(part, rounds, seed, 3.0, single),
        Part::Even => each(part, rounds, seed, 1.0, single),
        Part::Weak => each(part, rounds, seed, 0.4, single),
        Part::Pairs => repeated(part, rounds, seed, pair),
        Part::Contact => repeated(part, rounds, seed, |_| {
            FAMILIES
                .iter()
                .find(|family| family.scope == Scope::Event)
                .map(|family| Choice { family, joint: 0, strength: CONTACT })
                .into_iter()
                .collect()
        }),
        Part::Outside => each(part, rounds, seed, 3.0, |f| f.known != Known::Catalogue),
        Part::Small => small(rounds, seed),
    }
}

/// One or two of every part.
fn small(rounds: usize, seed: u64) -> Vec<Item> {
    let some = |part: Part, count: usize, every: usize| -> Vec<Item> {
        plan(part, rounds, seed).into_iter().step_by(every).take(count).collect()
    };
    let mut all = some(Part::Nothing, 1, 1);
    all.extend(some(Part::Strong, 2, 11));
    all.extend(some(Part::Outside, 1, 1));
    all
}

/// One effect of the catalogue in all logs.
fn single(family: &Family) -> bool {
    family.known == Known::Catalogue && family.scope != Scope::Event
}

fn repeated(part: Part, rounds: usize, seed: u64, choices: impl Fn(&mut Stream) -> Vec<Choice>) -> Vec<Item> {
    let item = |number: usize| {
        let own = seed_of(part, number, seed);
        Item { part, number, seed: own, choices: choices(&mut Stream::new(own, 7)) }
    };
    (0..rounds).map(item).collect()
}

fn each(part: Part, rounds: usize, seed: u64, strength: f64, wanted: impl Fn(&Family) -> bool) -> Vec<Item> {
    let families: Vec<&'static Family> = FAMILIES.iter().filter(|f| wanted(f)).collect();
    let item = |number: usize| {
        let own = seed_of(part, number, seed);
        let joint = any_joint(&mut Stream::new(own, 7));
        Item {
            part,
            number,
            seed: own,
            choices: vec![Choice { family: families[number % families.len()], joint, strength }],
        }
    };
    (0..rounds * families.len()).map(item).collect()
}

/// Two different effects of single joints, on different joints.
fn pair(stream: &mut Stream) -> Vec<Choice> {
    let families: Vec<&'static Family> =
        FAMILIES.iter().filter(|f| f.known == Known::Catalogue && f.scope == Scope::Joint).collect();
    let draw =
        |count: usize, stream: &mut Stream| ((stream.uniform() * count as f64) as usize).min(count - 1);
    let first = draw(families.len(), stream);
    let second = (first + 1 + draw(families.len() - 1, stream)) % families.len();
    let joint = any_joint(stream);
    let other = (joint + 1 + draw(JOINTS - 1, stream)) % JOINTS;
    vec![
        Choice { family: families[first], joint, strength: 2.0 },
        Choice { family: families[second], joint: other, strength: 2.0 },
    ]
}

fn any_joint(stream: &mut Stream) -> usize {
    ((stream.uniform() * JOINTS as f64) as usize).min(JOINTS - 1)
}

/// A seed of its own for every data set.
fn seed_of(part: Part, number: usize, seed: u64) -> u64 {
    let index = PARTS.iter().position(|(known, _, _)| *known == part).unwrap_or(0);
    Stream::new(seed, 1000 * index + number).bits()
}

#[cfg(test)]
mod tests {
    use super::{PARTS, Part, plan};
    use crate::simulate::hidden::Known;

    #[test]
    fn every_part_has_its_draws_and_a_seed_repeats_them() {
        for (part, name, rounds) in PARTS {
            assert_eq!(Part::named(name), Some(part));
            let (one, two) = (plan(part, rounds, 5), plan(part, rounds, 5));
            assert!(one.len() >= rounds);
            let seeds = |items: &[super::Item]| items.iter().map(|i| i.seed).collect::<Vec<_>>();
            assert_eq!(seeds(&one), seeds(&two));
            assert_ne!(seeds(&one), seeds(&plan(part, rounds, 6)));
        }
    }

    #[test]
    fn pairs_are_two_effects_on_two_joints() {
        for item in plan(Part::Pairs, 50, 1) {
            let [one, two] = item.choices.as_slice() else { panic!("two choices") };
            assert!(one.joint != two.joint && one.family.name != two.family.name);
        }
    }

    #[test]
    fn outside_is_outside() {
        let items = plan(Part::Outside, 1, 1);
        assert!(items.iter().all(|i| i.choices[0].family.known != Known::Catalogue));
        assert!(items.iter().filter(|i| i.choices[0].family.known == Known::Nobody).count() >= 4);
    }
}
