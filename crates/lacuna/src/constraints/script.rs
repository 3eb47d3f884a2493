//! Rules from a script; see [`crate::script`].

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use nalgebra::{Matrix3, Vector3};
use serde::{Deserialize, Serialize};

use super::{About, Constraint, LinkSpace, Links};
use crate::error::{Error, Result};
use crate::form::{Body as FormBody, Form};
use crate::robot::{InertialParameters, PARAMETERS_PER_LINK, Robot};
use crate::script::{Body, Limits, Lowered, Script, Settings, Subject, Usage};
use crate::stop::Stop;
use crate::text::bounds::Seconds;
use crate::text::{self, files};

/// Rules that a rhai file states.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Scripted {
    /// The file, relative to the scenario.
    pub path: PathBuf,
    /// Values in place of the script's own settings.
    #[serde(default)]
    pub with: Settings,
    /// Links it is asked about.
    #[serde(default)]
    pub links: Links,
    /// Wall clock that the script may use in a whole study \[s\].
    #[serde(default = "ten", deserialize_with = "Seconds::read")]
    pub seconds: f64,
    #[serde(skip)]
    loaded: Option<Script>,
    #[serde(skip)]
    cancel: Option<Arc<AtomicBool>>,
    #[serde(skip)]
    stop: Stop,
    #[serde(skip)]
    used: Usage,
}

fn ten() -> f64 {
    Limits::default().seconds
}

impl Scripted {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "script",
        title: "rules from a rhai file, no compiler needed",
        text: "A file with `fn constrain(robot, links, with)` for the whole robot, or \
               `fn constrain_link(robot, link, with)` for every link, that returns a list of rules: comparisons \
               of masses, centres of mass, inertias and what is computed from them. It runs before the search, \
               once for every way through its `if`s, and is never interpreted again. The files in \
               `constraints/` are examples to start from; `lacuna check FILE --robot R` shows what a script \
               means.",
        condition: "whatever the script returns",
        settings: &[
            ("path", "", "the file, relative to the scenario"),
            ("with", "", "values in place of those that its `fn settings()` returns"),
            (
                "links",
                "",
                "links it is asked about: `All`, which is also meant when not given, or `Only([..])`",
            ),
            ("seconds", "s", "wall clock the script may use"),
        ],
        example: r#"{"script": (path: "constraints/total_mass.rhai", with: {"min": 16.0, "max": 20.0})}"#,
        form: "affine, norm or semidefinite where a cone expresses the rule (every engine), else general \
               (`penalty`, `penalty_paper`, `nlopt`)",
    };

    /// Rules of a script from memory.
    pub fn from_script(script: Script, with: Settings) -> Self {
        Self {
            path: PathBuf::new(),
            with,
            links: Links::All,
            seconds: ten(),
            loaded: Some(script),
            cancel: None,
            stop: Stop::default(),
            used: Usage::default(),
        }
    }

    /// Setting the flag from another thread stops the script.
    #[must_use]
    pub fn cancelled_by(self, flag: Arc<AtomicBool>) -> Self {
        Self { cancel: Some(flag), ..self }
    }

    fn limits(&self) -> Limits {
        let (cancel, stop, used) = (self.cancel.clone(), self.stop.clone(), self.used.clone());
        Limits { seconds: self.seconds, cancel, stop, used, ..Limits::default() }
    }

    fn lower(&self, robot: &Robot, space: &LinkSpace) -> Result<Lowered> {
        let Some(script) = &self.loaded else {
            return Err(Error::new("the script has not been read yet").in_file(&self.path));
        };
        if !(self.seconds > 0.0 && self.seconds.is_finite()) {
            return Err(Error::new("`seconds` of a script must be positive")
                .in_file(&self.path)
                .help("10 are usual"));
        }
        let subject = subject(robot, space, &self.links)?;
        let lowered = script.lower(&subject, &self.with, &self.limits())?;
        let (z, _) = sample(robot, space);
        for rule in &lowered.rules {
            let wrong = lowered.forms[rule.forms.clone()].iter().find(|f| !f.reported_margin(&z).is_finite());
            if let Some(form) = wrong {
                return Err(Error::new(format!(
                    "the margin of `{}` is not a number for the links of the robot file",
                    form.label
                ))
                .in_file(script.file())
                .at(rule.place.0, rule.place.1)
                .help(
                    "a square root, logarithm or division goes wrong; guard it by `max(x, 0.0)` or an `if`",
                ));
            }
        }
        Ok(lowered)
    }
}

#[typetag::serde(name = "script")]
impl Constraint for Scripted {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn load(&mut self, folder: &Path) -> Result<()> {
        let text = text::read(&files::inside(folder, &self.path)?)?;
        self.loaded = Some(Script::new(self.path.clone(), text));
        Ok(())
    }

    fn ends_with(&mut self, stop: &Stop) {
        self.stop.clone_from(stop);
    }

    fn forms(&self, robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        self.lower(robot, space).map(|lowered| lowered.forms)
    }
}

/// The robot as a script sees it.
///
/// # Errors
/// When `links` names one that the robot has not.
fn subject(robot: &Robot, space: &LinkSpace, links: &Links) -> Result<Subject> {
    const PLACES: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    let body = |i: usize| Body {
        name: space.names[i].clone(),
        mass: space.mass(i),
        first_moment: std::array::from_fn(|axis| space.first_moment(i, axis)),
        inertia_at_origin: PLACES.map(|(row, column)| space.inertia_at_origin(i, row, column)),
    };
    Ok(Subject {
        name: robot.name.clone(),
        gravity: robot.gravity.into(),
        bodies: (0..space.links).map(body).collect(),
        chosen: links.indices(robot)?,
        unknowns: space.space.parameters.iter().map(|p| p.name.clone()).collect(),
    })
}

/// A point to try rules at: the links of the robot file, a small ball of 1 kg where it has none; and what it is.
fn sample(robot: &Robot, space: &LinkSpace) -> (Vec<f64>, String) {
    let com = Vector3::new(0.01, -0.02, 0.03);
    let ball = InertialParameters::from_barycentric(1.0, com, Matrix3::identity() * 0.01);
    let mut z = vec![0.0; space.space.len()];
    for (link, slot) in robot.links.iter().zip(z.chunks_mut(PARAMETERS_PER_LINK)) {
        slot.copy_from_slice(link.inertia.as_ref().unwrap_or(&ball).as_slice());
    }
    let unknown = robot.links.iter().filter(|l| l.inertia.is_none()).count();
    let text = match unknown {
        0 => "the links of the robot file".to_string(),
        _ => format!("the links of the robot file; {unknown} without inertia taken as balls of 1 kg"),
    };
    (z, text)
}

/// What a script means, for people.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Explanation {
    /// The file.
    pub script: String,
    /// Name of the robot.
    pub robot: String,
    /// Settings and their values.
    pub settings: Vec<(String, String)>,
    /// Links that any rule depends on.
    pub links: Vec<String>,
    /// Times the script ran: one for every link and way through its comparisons of unknowns.
    pub runs: usize,
    /// The point at which the margins were computed.
    pub sample: String,
    /// The rules, in the script's order.
    pub rules: Vec<RuleExplanation>,
}

/// One rule.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct RuleExplanation {
    /// Its label.
    pub label: String,
    /// Line in the script.
    pub line: usize,
    /// Column in the script.
    pub column: usize,
    /// Its forms, which hold together exactly where the rule does.
    pub forms: Vec<FormExplanation>,
}

/// One form.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct FormExplanation {
    /// Its label.
    pub label: String,
    /// `affine`, `norm`, `psd` or `general`.
    pub kind: &'static str,
    /// Why no cone expresses it.
    pub why: Option<String>,
    /// Engines that take it as it is.
    pub engines: Vec<&'static str>,
    /// Links it depends on.
    pub links: Vec<String>,
    /// Its margin at the sample point; not negative where it holds.
    pub margin: f64,
    /// Unit of the margin.
    pub unit: String,
    /// Whether it holds at the sample point.
    pub holds: bool,
}

/// What the script at `path` means for `robot`, with its own settings.
///
/// # Errors
/// When the script is refused; with file, line, column and what is known.
pub fn explain(path: &Path, robot: &Robot) -> Result<Explanation> {
    explain_until(path, robot, &Stop::default())
}

/// The same in work that may be stopped.
pub(crate) fn explain_until(path: &Path, robot: &Robot, stop: &Stop) -> Result<Explanation> {
    let script = Script::open(path)?;
    let space = LinkSpace::new(robot, &[]);
    let mut constraint = Scripted::from_script(script, Settings::default());
    constraint.ends_with(stop);
    let lowered = constraint.lower(robot, &space)?;
    let (z, sample) = sample(robot, &space);
    let rules = lowered.rules.iter().map(|rule| RuleExplanation {
        label: rule.label.clone(),
        line: rule.place.0,
        column: rule.place.1,
        forms: lowered.forms[rule.forms.clone()].iter().map(|f| explain_form(f, &space, &z)).collect(),
    });
    Ok(Explanation {
        script: path.display().to_string(),
        robot: robot.name.clone(),
        settings: lowered.settings.iter().map(|(name, value)| (name.clone(), value.to_string())).collect(),
        links: links_of(lowered.forms.iter().flat_map(Form::support).collect(), &space),
        runs: lowered.runs,
        sample,
        rules: rules.collect(),
    })
}

fn links_of(mut unknowns: Vec<usize>, space: &LinkSpace) -> Vec<String> {
    unknowns.iter_mut().for_each(|i| *i /= PARAMETERS_PER_LINK);
    unknowns.sort_unstable();
    unknowns.dedup();
    unknowns.into_iter().filter_map(|i| space.names.get(i).cloned()).collect()
}

fn explain_form(form: &Form, space: &LinkSpace, z: &[f64]) -> FormExplanation {
    let (kind, why) = match &form.body {
        FormBody::Affine(_) => ("affine", None),
        FormBody::Norm { .. } => ("norm", None),
        FormBody::Psd { .. } => ("psd", None),
        FormBody::General { why, .. } => ("general", Some(why.clone())),
    };
    let mut engines = vec!["penalty", "penalty_paper", "nlopt"];
    if form.is_convex() {
        engines.insert(2, "lmi");
    }
    let margin = form.reported_margin(z);
    FormExplanation {
        label: form.label.clone(),
        kind,
        why,
        engines,
        links: links_of(form.support(), space),
        margin,
        unit: form.unit.clone(),
        holds: margin >= 0.0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::form::Affine;

    fn two_link() -> (Robot, LinkSpace) {
        let robot = Robot::open("../../robots/two_link.ron").expect("the robot reads");
        let space = LinkSpace::new(&robot, &[]);
        (robot, space)
    }

    #[test]
    fn reads_from_ron_and_stays_in_its_folder() {
        let text = r#"{"script": (path: "total_mass.rhai", with: {"max": 20, "min": 16.0})}"#;
        let mut constraint: Box<dyn Constraint> = crate::text::from_ron(text).expect("RON");
        constraint.load(Path::new("../../constraints")).expect("loads");
        let (robot, space) = two_link();
        let forms = constraint.forms(&robot, &space).expect("lowers");
        assert_eq!(forms.len(), 2);
        assert!((forms[0].margin(&sample(&robot, &space).0) + 5.0).abs() < 1e-12, "8 + 3 - 16 kg");

        let mut out: Box<dyn Constraint> =
            crate::text::from_ron(r#"{"script": (path: "../../../../etc/passwd")}"#).expect("RON");
        let error = out.load(Path::new("../../constraints")).expect_err("leaves the repository");
        assert!(error.to_string().contains("leaves"), "{error}");
        let wrong = crate::text::from_ron::<Box<dyn Constraint>>(r#"{"script": (path: "x", wiht: {})}"#);
        assert!(wrong.expect_err("unknown field").to_string().contains("wiht"));
    }

    #[test]
    fn an_unknown_link_is_refused_with_the_known_ones() {
        let (robot, space) = two_link();
        let error = subject(&robot, &space, &Links::Only(vec!["elbow".into()])).expect_err("no such link");
        assert!(error.to_string().contains("link1, link2"), "{error}");
    }

    #[test]
    fn the_sample_is_the_robot_itself() {
        let (robot, space) = two_link();
        let (z, _) = sample(&robot, &space);
        assert!((Affine::variable(0).at(&z) - 8.0).abs() < 1e-15);
    }
}
