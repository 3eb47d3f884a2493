//! Promises of an effect.

use std::collections::BTreeSet;
use std::path::Path;
use std::sync::Arc;

use super::must;
use crate::effects::{About, Columns, Effect, Stretch, Term};
use crate::error::{Error, Result};
use crate::kernels::Chain;
use crate::robot::Robot;
use crate::signals::{ModelTorque, Run};
use crate::text;

/// Samples of the made-up motion, and its sampling time \[s\].
const SAMPLES: usize = 400;
const DT: f64 = 0.01;
/// Lengths that the motion is cut into.
const CUTS: [usize; 4] = [1, 7, 128, SAMPLES];

/// Checks an effect as a scenario writes it (`{"viscous_friction": ()}`), on a robot: that
///
/// - it explains itself: words, a typical cause, an example that reads as this effect, what values beyond a bound would
///   mean; the shapes of the example lie within these bounds;
/// - it survives being written and read again, meaning the same;
/// - its terms have units and symbols of their own, and name joints that exist;
/// - it fills one column per term and joint, in the joints that the term names and no others, with finite
///   numbers that are the same each time and do not depend on how a run is cut into stretches;
/// - its columns do not depend on the measured torque, only on the model's ([`crate::effects::BuiltFrom`]);
/// - shapes lie within their limits, take new values, and leave the others alone.
///
/// The motion is made up: sinusoids of every joint within 1 rad, with a channel for each name in `channels`.
/// Files are looked for in `folder`.
///
/// # Errors
/// With the first promise that is broken.
pub fn effect(ron: &str, robot: &Robot, folder: &Path, channels: &[&str]) -> Result<()> {
    let read = |ron: &str| -> Result<Box<dyn Effect>> {
        let mut effect: Box<dyn Effect> = text::from_ron(ron)?;
        effect.load(folder)?;
        Ok(effect)
    };
    let first = read(ron)?;
    explains_itself(&first.about())?;
    let written = text::to_ron(&first)?;
    gives_an_example(&first.about(), &written)?;
    let second = read(&written).map_err(|e| {
        Error::new(format!("what it writes cannot be read again: {}", e.message())).help(written.clone())
    })?;
    let mut run = motion(robot, channels);
    if first.needs_torque() {
        run.model = Some(Arc::new(model(robot)));
    }
    let terms = first.terms(robot)?;
    well_made(&terms, robot)?;
    let columns = Given::of(first.as_ref(), &terms, robot, &run, SAMPLES)?;
    columns.finite(&terms)?;
    for length in CUTS {
        let cut = Given::of(first.as_ref(), &terms, robot, &run, length)?;
        must(cut == columns, || {
            format!("its columns change when a run is cut into stretches of {length} samples")
        })?;
    }
    let again = second.terms(robot)?;
    must(again == terms && Given::of(second.as_ref(), &terms, robot, &run, SAMPLES)? == columns, || {
        "written to RON and read again it means something else".into()
    })?;
    run.tau.iter_mut().flatten().for_each(|tau| *tau = 1.0 - 2.0 * *tau);
    must(Given::of(first.as_ref(), &terms, robot, &run, SAMPLES)? == columns, || {
        "its columns change with the measured torque: what is to be explained would explain itself".into()
    })?;
    shaped(first.as_ref())
}

fn explains_itself(about: &About) -> Result<()> {
    let name = about.name;
    must(!name.is_empty() && !name.contains(char::is_whitespace), || {
        format!("its name `{name}` has spaces")
    })?;
    for (what, said) in [
        ("title", about.title),
        ("text", about.text),
        ("equation", about.equation),
        ("usual cause", about.cause),
        ("motion that tells it apart", about.separation.motion),
        ("example", about.example),
    ] {
        must(!said.trim().is_empty(), || format!("{name} has no {what}"))?;
    }
    must(about.text.split_whitespace().count() >= 10, || {
        format!("the text of {name} does not explain it: say what it is and how it shows in data")
    })?;
    let mute = about
        .parameters
        .iter()
        .find(|p| [p.symbol, p.unit, p.meaning].iter().any(|said| said.trim().is_empty()));
    must(mute.is_none() && !about.parameters.is_empty(), || {
        format!("{name} does not name its parameters with symbol, unit (\"1\" for none) and meaning")
    })
}

/// The example reads as the effect that was `written`, comes back the same, and its shapes may be as they are; bounds of
/// all parameters say what a value beyond would be.
fn gives_an_example(about: &About, written: &str) -> Result<()> {
    let name = about.name;
    let example: Box<dyn Effect> = text::from_ron(about.example)
        .map_err(|e| Error::new(format!("the example of {name} cannot be read: {}", e.message())))?;
    let again = text::to_ron(&example)?;
    let tag = |ron: &str| ron.split_once(':').map(|(tag, _)| tag.trim_matches(['{', ' ', '\n']).to_string());
    must(tag(&again) == tag(written), || format!("the example of {name} is one of another effect: {again}"))?;
    let back: Box<dyn Effect> = text::from_ron(&again)?;
    must(format!("{back:?}") == format!("{example:?}"), || {
        format!("the example of {name} means something else when it is written and read again")
    })?;
    for p in about.parameters {
        let (least, most) =
            (p.least.map_or(f64::NEG_INFINITY, |b| b.at), p.most.map_or(f64::INFINITY, |b| b.at));
        must(least < most, || format!("no value of `{}` can be between {least} and {most}", p.symbol))?;
        let mute = [p.least, p.most].into_iter().flatten().any(|b| b.beyond.trim().is_empty());
        must(!mute, || format!("{name} does not say what `{}` beyond its bounds would mean", p.symbol))?;
        let outside =
            example.shapes().into_iter().find(|s| s.symbol == p.symbol && p.broken(s.value).is_some());
        must(outside.is_none(), || format!("`{}` in the example of {name} is out of its bounds", p.symbol))?;
    }
    Ok(())
}

/// Sinusoids whose periods fit no common one, and everything that a log may have beside them.
fn motion(robot: &Robot, channels: &[&str]) -> Run {
    let wave = |j: usize, k: usize, shift: f64| {
        libm::sin(0.011 * (j + 2) as f64 * k as f64 + shift + 0.7 * j as f64)
    };
    let of = |size: f64, shift: f64| -> Vec<Vec<f64>> {
        (0..robot.dof()).map(|j| (0..SAMPLES).map(|k| size * wave(j, k, shift)).collect()).collect()
    };
    let channel =
        |name: &&str| ((*name).to_string(), (0..SAMPLES).map(|k| 20.0 + 5.0 * wave(1, k, 0.4)).collect());
    Run {
        name: "made up".into(),
        dt: DT,
        q: of(0.9, 0.1),
        dq: of(1.1, 1.6),
        ddq: of(1.4, 3.2),
        tau: of(5.0, 0.3),
        channels: channels.iter().map(channel).collect(),
        ..Run::default()
    }
}

/// A torque that a model might make of the motion.
fn model(robot: &Robot) -> ModelTorque {
    let rows = |shift: f64| -> Vec<Vec<f64>> {
        let row =
            |j: usize| (0..SAMPLES).map(|k| 3.0 * libm::sin(0.02 * k as f64 + j as f64 + shift)).collect();
        (0..robot.dof()).map(row).collect()
    };
    let links = (0..10 * robot.dof()).map(|i| 0.1 + 0.01 * i as f64).collect();
    ModelTorque { links, rigid: rows(0.0), total: rows(0.5) }
}

fn well_made(terms: &[Term], robot: &Robot) -> Result<()> {
    must(!terms.is_empty(), || "it has no terms, so there is nothing to fit".into())?;
    let mut seen = BTreeSet::new();
    for term in terms {
        let symbol = &term.symbol;
        must(seen.insert(symbol), || {
            format!("two terms are called `{symbol}`: reports could not tell them apart")
        })?;
        must(!symbol.trim().is_empty() && !term.unit.trim().is_empty(), || {
            format!("the term `{symbol}` has no symbol or no unit; write \"1\" for none")
        })?;
        must(!term.joints.is_empty(), || format!("`{symbol}` acts on no joint"))?;
        let once: BTreeSet<usize> = term.joints.iter().copied().collect();
        must(once.len() == term.joints.len(), || format!("`{symbol}` names a joint twice"))?;
        must(once.iter().all(|&j| j < robot.dof()), || {
            format!("`{symbol}` acts on a joint that does not exist")
        })?;
    }
    Ok(())
}

/// Columns as bits, `[term][joint]`; empty where a term has none.
#[derive(PartialEq, Eq)]
struct Given(Vec<Vec<Vec<u64>>>);

impl Given {
    fn of(effect: &dyn Effect, terms: &[Term], robot: &Robot, run: &Run, length: usize) -> Result<Self> {
        let chain = Chain::new(robot);
        let mut all = vec![vec![Vec::new(); robot.dof()]; terms.len()];
        for first in (0..SAMPLES).step_by(length) {
            let range = first..(first + length).min(SAMPLES);
            let at = Stretch { robot, chain: &chain, run, range: range.clone() };
            let mut offered: BTreeSet<(usize, usize)> = BTreeSet::new();
            let mut trouble = None;
            let mut wanted = |term: usize, joint: usize, fill: &mut dyn FnMut(&mut [f64])| {
                let fits = terms.get(term).is_some_and(|t| t.joints.contains(&joint));
                if !fits || !offered.insert((term, joint)) {
                    trouble.get_or_insert((term, joint, fits));
                    return;
                }
                let mut slot = vec![0.0; range.len()];
                fill(&mut slot);
                all[term][joint].extend(slot.iter().map(|x| x.to_bits()));
            };
            effect.columns(&at, &mut Columns { wanted: &mut wanted, scratch: &mut None })?;
            if let Some((term, joint, fits)) = trouble {
                let why = if fits { "twice" } else { "which that term does not name" };
                return Err(Error::new(format!(
                    "it fills the column of term {term} in joint {joint}, {why}"
                )));
            }
            // A column that is not offered is zero.
            for (term, joint) in
                terms.iter().enumerate().flat_map(|(t, term)| term.joints.iter().map(move |&j| (t, j)))
            {
                if !offered.contains(&(term, joint)) {
                    all[term][joint].extend(vec![0.0_f64.to_bits(); range.len()]);
                }
            }
        }
        Ok(Self(all))
    }

    fn finite(&self, terms: &[Term]) -> Result<()> {
        for (columns, term) in self.0.iter().zip(terms) {
            let bad = columns.iter().flatten().any(|bits| !f64::from_bits(*bits).is_finite());
            must(!bad, || format!("the column of `{}` has what is no number", term.symbol))?;
        }
        Ok(())
    }
}

fn shaped(effect: &dyn Effect) -> Result<()> {
    let shapes = effect.shapes();
    for (k, shape) in shapes.iter().enumerate() {
        let inside = |x: f64| shape.low <= x && x <= shape.high;
        must(inside(shape.value), || {
            format!("the shape `{}` has a value outside of its limits", shape.symbol)
        })?;
        must(!shape.trials.is_empty() && shape.trials.iter().all(|t| inside(*t)), || {
            format!("the trials of the shape `{}` are none, or outside of its limits", shape.symbol)
        })?;
        let mut values: Vec<f64> = shapes.iter().map(|s| s.value).collect();
        values[k] = 0.5 * (shape.value + shape.high.min(shape.value + 1.0));
        let now: Vec<u64> = effect.with_shapes(&values).shapes().iter().map(|s| s.value.to_bits()).collect();
        must(now == values.iter().map(|v| v.to_bits()).collect::<Vec<u64>>(), || {
            format!("`with_shapes` does not set `{}`, or sets others with it", shape.symbol)
        })?;
    }
    Ok(())
}
