//! Promises of a constraint.

use std::path::Path;

use nalgebra::{Matrix3, Vector3};

use super::must;
use crate::constraints::{About, Constraint, LinkSpace};
use crate::error::{Error, Result};
use crate::form::{Body, Form};
use crate::random::Stream;
use crate::robot::{InertialParameters, Robot};
use crate::space::Parameter;
use crate::text;

/// Bodies drawn at random, and neighbours tried of each given point.
const POINTS: usize = 24;

/// Checks a constraint as a scenario writes it (`{"total_mass": (min: 16.0)}`), on a robot: that
///
/// - it explains itself, gives an example of itself, and both the example and `ron` survive being written and read
///   again;
/// - its forms have labels, units and positive scales, and use unknowns that exist;
/// - every gradient is that of its margin, by finite differences (at a kink, one between those of its sides);
/// - a margin reported in its own unit has the sign of the form's;
/// - what a general form implies holds wherever all forms of the constraint do;
/// - bounds on coordinates name coordinates, and hold wherever all forms do.
///
/// Points are random bodies, the robot file's own inertias and their neighbours, and `points` (unknowns of
/// [`LinkSpace`], friction coefficients `fv1` and `fc1` last) with theirs: give some where it holds.
/// Files are looked for in `folder`.
///
/// # Errors
/// With the first promise that is broken, the form and the point.
pub fn constraint(ron: &str, robot: &Robot, folder: &Path, points: &[Vec<f64>]) -> Result<()> {
    let others = ["fv1", "fc1"].map(|name| Parameter::free(name, "N m"));
    let space = LinkSpace::new(robot, &others);
    let read = |ron: &str| -> Result<Box<dyn Constraint>> {
        let mut constraint: Box<dyn Constraint> = text::from_ron(ron)?;
        constraint.load(folder)?;
        Ok(constraint)
    };
    let first = read(ron)?;
    explains_itself(&first.about())?;
    gives_an_example(&first.about())?;
    let written = written(first.as_ref())?;
    let second = read(&written)?;
    let (forms, again) = (first.forms(robot, &space)?, second.forms(robot, &space)?);
    let points = sample(robot, &space, points)?;
    well_made(&forms, &space)?;
    same(&forms, &again, &points)?;
    for form in &forms {
        points.iter().try_for_each(|z| honest(form, z))?;
    }
    implies(&forms, &points)?;
    bounded(first.as_ref(), robot, &space, &forms, &points)
}

/// What it writes of itself, which can be read again under the name that it gives itself.
fn written(constraint: &dyn Constraint) -> Result<String> {
    let (name, written) = (constraint.about().name, text::to_ron(&constraint)?);
    text::from_ron::<Box<dyn Constraint>>(&written).map_err(|e| {
        Error::new(format!("what it writes cannot be read again: {}", e.message())).help(written.clone())
    })?;
    must(written.contains(&format!("\"{name}\"")), || {
        format!("its name in RON is not `{name}`, the one it gives itself: {written}")
    })?;
    Ok(written)
}

/// The example is an entry of this very constraint; files that it names need not be there.
fn gives_an_example(about: &About) -> Result<()> {
    let wrong =
        |what: String| Error::new(format!("the example of {} {what}", about.name)).help(about.example);
    let example: Box<dyn Constraint> =
        text::from_ron(about.example).map_err(|e| wrong(format!("cannot be read: {}", e.message())))?;
    let of = example.about().name;
    if of != about.name {
        return Err(wrong(format!("is one of `{of}`")));
    }
    written(example.as_ref()).map(drop).map_err(|e| wrong(e.message().to_string()))
}

fn explains_itself(about: &About) -> Result<()> {
    let name = about.name;
    let plain = |c: char| c.is_ascii_lowercase() || c.is_ascii_digit() || c == '_';
    must(!name.is_empty() && name.chars().all(plain), || format!("its name `{name}` is not in snake_case"))?;
    for (what, said) in [("title", about.title), ("text", about.text), ("condition", about.condition)] {
        must(!said.trim().is_empty(), || format!("{name} has no {what}"))?;
    }
    must(!about.form.trim().is_empty(), || format!("{name} does not say which engines take it"))?;
    must(about.text.split_whitespace().count() >= 10, || {
        format!("the text of {name} does not explain it: say what it means and when to use it")
    })?;
    let mute = about.settings.iter().find(|(setting, _, meaning)| setting.is_empty() || meaning.is_empty());
    must(mute.is_none(), || format!("a setting of {name} has no name or no meaning"))
}

/// Random bodies, the file's own, the caller's, and neighbours of the last two.
fn sample(robot: &Robot, space: &LinkSpace, given: &[Vec<f64>]) -> Result<Vec<Vec<f64>>> {
    let mut stream = Stream::new(20190731, 0);
    let mut points: Vec<Vec<f64>> = (0..POINTS)
        .map(|_| {
            let mut z: Vec<f64> = (0..space.links).flat_map(|_| random_body(&mut stream).0).collect();
            z.extend([stream.between(0.1, 2.0), stream.between(0.1, 2.0)]);
            z
        })
        .collect();
    let mut centres = given.to_vec();
    if let Ok(mut own) = robot.inertial_parameters() {
        own.extend([0.5, 0.5]);
        centres.push(own);
    }
    for centre in centres {
        must(centre.len() == space.space.len(), || {
            format!("a point has {} numbers, the space {}", centre.len(), space.space.len())
        })?;
        for step in [0.0, 1e-3, 0.03].into_iter().chain([0.1; POINTS]) {
            points.push(centre.iter().map(|x| x * (1.0 + step * stream.between(-1.0, 1.0))).collect());
        }
    }
    Ok(points)
}

/// A body of up to 5 kg within some 30 cm of its link frame.
fn random_body(stream: &mut Stream) -> InertialParameters {
    let spread = Matrix3::from_fn(|_, _| stream.between(-0.1, 0.1));
    let second = spread * spread.transpose();
    let com = Vector3::from_fn(|_, _| stream.between(-0.3, 0.3));
    let mass = stream.between(0.2, 5.0);
    InertialParameters::from_barycentric(mass, com, (Matrix3::identity() * second.trace() - second) * mass)
}

fn well_made(forms: &[Form], space: &LinkSpace) -> Result<()> {
    must(!forms.is_empty(), || "it has no forms, so it says nothing".into())?;
    for (i, form) in forms.iter().enumerate() {
        must(!form.label.trim().is_empty(), || format!("form {i} has no label"))?;
        must(!forms[..i].iter().any(|f| f.label == form.label), || {
            format!("two forms are called `{}`: reports could not tell them apart", form.label)
        })?;
        must(!form.unit.is_empty(), || format!("`{}` has no unit; write \"1\" for none", form.label))?;
        must(form.scale.is_finite() && form.scale > 0.0, || {
            format!("the scale of `{}` is {}, not a positive number", form.label, form.scale)
        })?;
        let support = form.support();
        must(support.windows(2).all(|w| w[0] < w[1]), || {
            format!("the support of `{}` is not ascending: {support:?}", form.label)
        })?;
        must(support.last().is_none_or(|&last| last < space.space.len()), || {
            format!("`{}` uses an unknown that does not exist: {support:?}", form.label)
        })?;
        if let Body::General { why, implied, .. } = &form.body {
            must(!why.trim().is_empty(), || format!("`{}` does not say why it is general", form.label))?;
            must(implied.iter().all(Form::is_convex), || {
                format!("`{}` implies a form that is not convex itself", form.label)
            })?;
        }
    }
    Ok(())
}

fn same(forms: &[Form], again: &[Form], points: &[Vec<f64>]) -> Result<()> {
    let alike = |(a, b): (&Form, &Form)| {
        a.label == b.label
            && points.iter().all(|z| a.reported_margin(z).to_bits() == b.reported_margin(z).to_bits())
    };
    must(forms.len() == again.len() && forms.iter().zip(again).all(alike), || {
        "written to RON and read again it means something else".into()
    })
}

/// Gradients of margin and measure, and their signs.
fn honest(form: &Form, z: &[f64]) -> Result<()> {
    let (margin, gradient) = form.gradient(z);
    let indices: Vec<usize> = gradient.iter().map(|g| g.0).collect();
    let slopes: Vec<f64> = gradient.iter().map(|g| g.1).collect();
    differs_rightly(&form.label, z, (margin, &indices, &slopes), |z| form.margin(z))?;
    let Some(measure) = &form.measure else { return Ok(()) };
    let (own, slopes) = measure.gradient(z);
    let label = format!("{}, as reported", form.label);
    differs_rightly(&label, z, (own, &measure.support(), &slopes), |z| measure.margin(z))?;
    // Right on the border rounding decides, so only clear contradictions count.
    let clear = own.abs() > 1e-9 * form.scale && margin.abs() > 1e-9;
    must(!clear || (own > 0.0) == (margin > 0.0), || {
        format!("`{}` reports {own:.3e}, but its form's margin is {margin:.3e}", form.label)
    })
}

fn differs_rightly(
    label: &str,
    z: &[f64],
    (margin, support, slopes): (f64, &[usize], &[f64]),
    function: impl Fn(&[f64]) -> f64,
) -> Result<()> {
    let here = function(z);
    must(here.is_finite(), || format!("the margin of `{label}` is {here} at {z:?}"))?;
    must((margin - here).abs() <= 1e-12 * (1.0 + here.abs()), || {
        format!("`{label}` gives {margin} with its gradient, but {here} without")
    })?;
    must(support.len() == slopes.len(), || {
        format!("`{label}` has {} slopes for {} unknowns", slopes.len(), support.len())
    })?;
    for (&i, &slope) in support.iter().zip(slopes) {
        let step = 1e-6 * z[i].abs().max(1e-2);
        let moved = |d: f64| {
            let mut z = z.to_vec();
            z[i] += d;
            function(&z)
        };
        let (up, down) = ((moved(step) - here) / step, (here - moved(-step)) / step);
        let slack = 1e-4 * (1.0 + slopes.iter().fold(0.0, |a: f64, s| a.max(s.abs())));
        must(slope >= up.min(down) - slack && slope <= up.max(down) + slack, || {
            format!(
                "the slope of `{label}` in unknown {i} is {slope:.6e}, by differences {up:.6e} or {down:.6e}"
            )
        })?;
    }
    for i in (0..z.len()).filter(|i| !support.contains(i)) {
        let mut moved = z.to_vec();
        moved[i] += 0.1 + z[i].abs();
        must(function(&moved).to_bits() == here.to_bits(), || {
            format!("`{label}` changes with unknown {i}, which is not in its support")
        })?;
    }
    Ok(())
}

fn holds(forms: &[Form], z: &[f64]) -> bool {
    forms.iter().all(|form| form.reported_margin(z) >= 0.0)
}

fn implies(forms: &[Form], points: &[Vec<f64>]) -> Result<()> {
    for form in forms {
        let Body::General { implied, .. } = &form.body else { continue };
        for z in points.iter().filter(|z| holds(forms, z)) {
            let broken = implied.iter().find(|f| f.reported_margin(z) < -1e-9 * f.scale);
            must(broken.is_none(), || {
                let other = broken.map_or("", |f| f.label.as_str());
                format!("`{}` holds, but `{other}`, which it says it implies, does not: at {z:?}", form.label)
            })?;
        }
    }
    Ok(())
}

fn bounded(
    constraint: &dyn Constraint,
    robot: &Robot,
    space: &LinkSpace,
    forms: &[Form],
    points: &[Vec<f64>],
) -> Result<()> {
    use crate::retrieval::Chart;
    let chart = crate::constraints::Barycentric::new(space, |_| (f64::NEG_INFINITY, f64::INFINITY));
    for bound in constraint.bounds(robot, space)? {
        let index = chart.space().index(&bound.name);
        let Some(index) = index else {
            return Err(Error::new(format!("it bounds `{}`, which is no coordinate", bound.name)));
        };
        for z in points.iter().filter(|z| holds(forms, z)) {
            let value = chart.coordinates(z)[index];
            let slack = 1e-9 * (1.0 + value.abs());
            must(value >= bound.lower - slack && value <= bound.upper + slack, || {
                format!("it holds where {} is {value}, outside the bounds it gives", bound.name)
            })?;
        }
    }
    Ok(())
}
