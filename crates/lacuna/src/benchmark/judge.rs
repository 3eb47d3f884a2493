//! Whether an answer is right: compares a diagnosis with what was hidden.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::diagnose::{Diagnosis, Missing};
use crate::error::{Error, Result};
use crate::robot::Robot;
use crate::simulate::hidden::{Family, Known, Scope, Secret};

/// Least overlap over union of a contact's interval.
const OVERLAP: f64 = 0.6;
/// A formula is the exact term when it has the hidden variables and leaves the unseen error within this factor
/// of what nothing hidden leaves.
const EXACT: f64 = 1.10;

/// One thing that a diagnosis says.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// Name of the effect, or `unknown`.
    pub effect: String,
    /// Joint; `None` for the whole robot.
    pub joint: Option<String>,
    /// Variables, for an unknown.
    pub depends_on: Vec<String>,
    /// Its significance.
    pub z: f64,
    /// Part of the held-out squared error that it explains \[%\].
    pub gain_percent: f64,
    /// Whether it is right.
    pub right: bool,
}

/// What one answer was worth.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Mark {
    /// What was hidden: family, joint, strength, size.
    pub hidden: Vec<(String, Option<String>, f64, f64)>,
    /// What was said, in order.
    pub answers: Vec<Answer>,
    /// Whether the first answer is right.
    pub first: bool,
    /// Whether a right one is among the first three.
    pub among_three: bool,
    /// How many of the hidden effects were named.
    pub named: usize,
    /// How many answers name nothing that was hidden.
    pub extras: usize,
    /// Whether the first answer is on the right joint.
    pub joint: bool,
    /// For what the catalogue has not: joint and a hidden variable.
    pub variable: bool,
    /// For what a formula can express: the exact term first.
    pub exact: bool,
    /// Error on the unseen log before and after, over the error with nothing hidden, on the joint that shows most; no
    /// number where another log cannot show it.
    #[serde(deserialize_with = "number")]
    pub before: f64,
    /// After.
    #[serde(deserialize_with = "number")]
    pub after: f64,
}

/// JSON has no word for what is not a number but `null`.
fn number<'de, D: serde::Deserializer<'de>>(from: D) -> std::result::Result<f64, D::Error> {
    Ok(Option::<f64>::deserialize(from)?.unwrap_or(f64::NAN))
}

/// Accepted answers besides the name itself.
pub type Marks = BTreeMap<String, Vec<String>>;

/// The rules that count answers as right.
pub(super) fn rules() -> Result<Marks> {
    ron::from_str(include_str!("answers.ron")).map_err(|e| Error::new(format!("answers.ron: {e}")))
}

/// Errors on the unseen log by joint.
pub(super) struct Unseen<'a> {
    pub before: &'a [f64],
    pub after: &'a [f64],
    /// With nothing hidden.
    pub without: &'a [f64],
}

/// Judges one diagnosis.
pub(super) fn judge(
    found: &Diagnosis,
    secrets: &[Secret],
    robot: &Robot,
    unseen: &Unseen<'_>,
    rules: &Marks,
) -> Mark {
    let name = |joint: Option<usize>| joint.map(|j| robot.joints[j].name.clone());
    let mut answers = listed(found);
    for answer in &mut answers {
        answer.right = secrets.iter().any(|s| is_right(answer, s, name(s.joint).as_deref(), found, rules));
    }
    let named = secrets
        .iter()
        .filter(|s| answers.iter().any(|a| is_right(a, s, name(s.joint).as_deref(), found, rules)))
        .count();
    let place = answers.iter().position(|a| a.right);
    let first = answers.first();
    let on_joint =
        first.is_some_and(|a| secrets.iter().any(|s| s.joint.is_none() || name(s.joint) == a.joint));
    let variable = first.is_some_and(|a| a.right && a.effect == "unknown");
    let (before, after) = ratios(unseen, secrets);
    let exact = variable && after <= EXACT && first.is_some_and(|a| same_variables(a, secrets));
    Mark {
        hidden: secrets.iter().map(|s| (s.family.to_string(), name(s.joint), s.strength, s.size)).collect(),
        first: place == Some(0),
        among_three: place.is_some_and(|p| p < 3),
        named,
        extras: answers.iter().filter(|a| !a.right).count(),
        joint: on_joint,
        variable,
        exact,
        before,
        after,
        answers,
    }
}

/// Everything a diagnosis says, the first thing first: where the worst joint's cause is unknown, that is first.
fn listed(found: &Diagnosis) -> Vec<Answer> {
    let of = |m: &Missing| -> Vec<Answer> {
        let answer = |joint: Option<&String>| Answer {
            effect: m.effect.clone(),
            joint: joint.cloned(),
            depends_on: Vec::new(),
            z: m.z,
            gain_percent: m.gain_percent,
            right: false,
        };
        if m.joints.is_empty() {
            vec![answer(None)]
        } else {
            m.joints.iter().map(|j| answer(Some(j))).collect()
        }
    };
    let unknown: Vec<Answer> = found
        .unexplained
        .iter()
        .map(|u| Answer {
            effect: "unknown".to_string(),
            joint: Some(u.joint.clone()),
            depends_on: u.depends_on.clone(),
            z: u.z,
            gain_percent: u.gain_percent,
            right: false,
        })
        .collect();
    let named: Vec<Answer> = found.missing.iter().chain(&found.minor).flat_map(of).collect();
    let unknown_first = found.first.as_ref().is_some_and(|f| f.cause == "unknown");
    if unknown_first { [unknown, named].concat() } else { [named, unknown].concat() }
}

fn is_right(answer: &Answer, secret: &Secret, joint: Option<&str>, found: &Diagnosis, rules: &Marks) -> bool {
    let Some(family) = Family::named(secret.family) else { return false };
    let on_joint = joint.is_none() || answer.joint.as_deref() == joint;
    if family.known != Known::Catalogue {
        let shared = |v: &String| {
            answer.depends_on.contains(v) || (v == "t" && answer.depends_on.iter().any(|d| d == "time"))
        };
        return answer.effect == "unknown" && on_joint && telling(secret).any(shared);
    }
    if family.scope == Scope::Event {
        return answer.effect == secret.family
            && found.events.iter().any(|e| overlaps((e.from_s, e.to_s), secret));
    }
    let also = rules.get(secret.family).is_some_and(|list| list.contains(&answer.effect));
    on_joint && (answer.effect == secret.family || also)
}

/// The variables that tell an effect: where there are others, its joint's own velocity does not count.
fn telling(secret: &Secret) -> impl Iterator<Item = &String> {
    let several = secret.variables.len() > 1;
    secret.variables.iter().filter(move |v| !several || !v.starts_with("dq"))
}

fn same_variables(answer: &Answer, secrets: &[Secret]) -> bool {
    secrets.iter().any(|s| {
        telling(s).all(|v| answer.depends_on.contains(v)) && answer.depends_on.len() == telling(s).count()
    })
}

/// Whether an interval is the hidden contact's.
fn overlaps(found: (f64, f64), secret: &Secret) -> bool {
    let Some((from, to)) = secret.interval() else { return false };
    let both = (found.1.min(to) - found.0.max(from)).max(0.0);
    let either = found.1.max(to) - found.0.min(from);
    both >= OVERLAP * either
}

/// Unseen error before and after over that with nothing hidden: on the hidden effect's joint, or where it shows most.
fn ratios(unseen: &Unseen<'_>, secrets: &[Secret]) -> (f64, f64) {
    // What changed between two logs is no part of the model that predicts another log.
    if secrets.iter().any(|s| Family::named(s.family).is_some_and(|f| f.scope == Scope::TwoLogs)) {
        return (f64::NAN, f64::NAN);
    }
    let ratio = |of: &[f64], j: usize| of[j] / unseen.without[j];
    let own: Vec<usize> = secrets.iter().filter_map(|s| s.joint).collect();
    let joints: Vec<usize> = if own.is_empty() { (0..unseen.before.len()).collect() } else { own };
    let most =
        joints.into_iter().max_by(|&a, &b| ratio(unseen.before, a).total_cmp(&ratio(unseen.before, b)));
    most.map_or((f64::NAN, f64::NAN), |j| (ratio(unseen.before, j), ratio(unseen.after, j)))
}

#[cfg(test)]
mod tests {
    use super::Mark;

    #[test]
    fn a_mark_without_numbers_comes_back_from_a_record() {
        let mark = Mark {
            hidden: vec![("payload".to_string(), None, 3.0, 1.0)],
            answers: Vec::new(),
            first: false,
            among_three: false,
            named: 0,
            extras: 0,
            joint: false,
            variable: false,
            exact: false,
            before: f64::NAN,
            after: 1.5,
        };
        let text = serde_json::to_string(&mark).expect("it is written");
        let again: Mark = serde_json::from_str(&text).expect("it is read");
        assert!(again.before.is_nan() && again.after.to_bits() == 1.5_f64.to_bits());
    }
}
