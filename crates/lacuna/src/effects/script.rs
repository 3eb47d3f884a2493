use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use std::sync::{Arc, Mutex, PoisonError};

use serde::{Deserialize, Serialize};

use super::about::*;
use super::script_columns::{Lowered, Traces};
use super::{Columns, Effect, Joints, Shape, Stretch, Term};
use crate::error::{Error, Result};
use crate::robot::Robot;
use crate::script::{EffectParameter, EffectScript, Limits, Script, Settings};
use crate::signals::Run;
use crate::stop::Stop;
use crate::text::{self, files};

/// An effect that a rhai file states; see [`crate::script`].
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(try_from = "Written", into = "Written")]
pub struct ScriptedEffect {
    written: Written,
    loaded: Option<Arc<EffectScript>>,
    told: About,
    lowered: Arc<Mutex<Option<Lowered>>>,
    traces: Arc<Traces>,
}

/// As it stands in a file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Written {
    /// The file, relative to the scenario.
    path: PathBuf,
    /// Joints it acts on.
    #[serde(default)]
    joints: Joints,
    /// Values in place of the script's own settings.
    #[serde(default)]
    with: Settings,
    /// Values in place of the script's own shapes.
    #[serde(default)]
    shapes: BTreeMap<String, f64>,
    /// Time that the script may take in a whole study, all it does counted together \[s\].
    #[serde(default = "usual", skip_serializing_if = "is_usual")]
    seconds: f64,
    /// The script itself, in finished models, which are used far from the scenario.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    text: Option<String>,
}

fn usual() -> f64 {
    Limits::default().seconds
}

fn is_usual(seconds: &f64) -> bool {
    seconds.to_bits() == usual().to_bits()
}

impl ScriptedEffect {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "script",
        title: "an effect from a rhai file, no compiler needed",
        text: "A file with `fn about()`, which names parameters with units and limits, and `fn columns(joint, now, \
               memory, with)`, which says what torque a unit of each makes at one sample; with `fn remember(..)` it \
               has a memory. It runs once per joint before the fit and is never interpreted again. The files in \
               `effects/` are examples to start from; `lacuna check FILE --robot R --data A.csv` explains a script \
               and tries it on a log.",
        equation: "tau_j = sum of parameters times the columns that the script states",
        parameters: &[Parameter::new(
            "any",
            "as it says",
            "what `fn about()` of the script names, with units and limits",
        )],
        cause: "whatever its author knows of",
        confused_with: "whatever its author says",
        separation: Separation::OTHER,
        example: r#"{"script": (path: "effects/quadratic_friction.rhai")}"#,
        drawn_against: Variable::Velocity,
        at_rest: AtRest::Smooth,
        reach: Reach::Joint,
        stage: Stage::Given,
        imitated_by: &[],
        special: Special::NONE,
    };

    /// The effect of a script file on these joints.
    ///
    /// # Errors
    /// When the file cannot be read, or the script is refused; with line and column.
    pub fn open(path: &Path, joints: Joints) -> Result<Self> {
        Self::from_text(path, text::read(path)?, joints)
    }

    /// The effect of a script from memory; `path` names it in messages.
    ///
    /// # Errors
    /// When the script is refused; with line and column.
    pub fn from_text(path: &Path, text: String, joints: Joints) -> Result<Self> {
        let (with, shapes) = (Settings::new(), BTreeMap::new());
        let (path, seconds) = (path.to_path_buf(), usual());
        Self::new(Written { path, joints, with, shapes, seconds, text: Some(text) })
    }

    fn new(written: Written) -> Result<Self> {
        if !(written.seconds > 0.0 && written.seconds.is_finite()) {
            return Err(Error::new("`seconds` of a script must be positive").in_file(&written.path));
        }
        let (lowered, traces) = (Arc::default(), Arc::default());
        let mut effect = Self { written, loaded: None, told: Self::ABOUT, lowered, traces };
        if let Some(text) = effect.written.text.clone() {
            effect.read(text)?;
        }
        Ok(effect)
    }

    fn read(&mut self, text: String) -> Result<()> {
        let path = &self.written.path;
        let script = EffectScript::new(Script::new(path.clone(), text.clone()), &self.written.with)?;
        for (symbol, value) in &self.written.shapes {
            let known: Vec<&str> = script.about().shapes.iter().map(|s| s.symbol.as_str()).collect();
            let Some(shape) = script.about().shapes.iter().find(|s| s.symbol == *symbol) else {
                return Err(Error::new(format!("the script has no shape `{symbol}`"))
                    .in_file(path)
                    .help(format!("known are: {}", known.join(", "))));
            };
            if !(shape.min <= *value && *value <= shape.max) {
                return Err(Error::new(format!(
                    "the shape `{symbol}` is {value}, outside of {} to {} {}",
                    shape.min, shape.max, shape.unit
                ))
                .in_file(path)
                .help("give it a value within the script's limits"));
            }
        }
        self.told = told(path, &script);
        self.written.text = Some(text);
        self.loaded = Some(Arc::new(script));
        Ok(())
    }

    /// The script, once it is loaded.
    ///
    /// # Errors
    /// When it is not.
    pub fn script(&self) -> Result<&EffectScript> {
        self.loaded.as_deref().ok_or_else(|| {
            Error::new("the script has not been read yet")
                .in_file(&self.written.path)
                .help("name it in a scenario, or give its text")
        })
    }

    /// Values of the shapes, in the script's order.
    fn shape_values(&self, script: &EffectScript) -> Vec<f64> {
        let shapes = script.about().shapes.iter();
        shapes.map(|s| self.written.shapes.get(&s.symbol).copied().unwrap_or(s.value)).collect()
    }

    /// Joints it acts on: those named for it, else those that the script says it is meant for.
    fn joints(&self, robot: &Robot) -> Result<Vec<usize>> {
        let meant = &self.script()?.about().joints;
        if self.written.joints != Joints::All || meant.is_empty() {
            return self.written.joints.indices(robot);
        }
        Joints::Only(meant.clone()).indices(robot).map_err(|e| e.in_file(&self.written.path))
    }

    /// Runs the script for every joint of its own on `robot`.
    ///
    /// # Errors
    /// With file, line and column when it does not stop, returns something else than one number per parameter,
    /// or names a joint that is not there.
    pub fn try_on(&self, robot: &Robot) -> Result<()> {
        self.lowered(robot, &Stop::default()).map(drop)
    }

    /// What its columns are made of on `robot`, from before where that is known.
    pub(crate) fn lowered(&self, robot: &Robot, stop: &Stop) -> Result<Lowered> {
        let script = self.script()?;
        let mut kept = self.lowered.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(known) = kept.as_ref().filter(|known| known.is_for(robot)) {
            return Ok(known.clone());
        }
        let (used, stop) = (script.used().clone(), stop.clone());
        let limits = Limits { seconds: self.written.seconds, used, stop, ..Limits::default() };
        let lowered = Lowered::new(script, robot, self.joints(robot)?, &limits)?;
        *kept = Some(lowered.clone());
        Ok(lowered)
    }
}

impl TryFrom<Written> for ScriptedEffect {
    type Error = Error;

    fn try_from(written: Written) -> Result<Self> {
        Self::new(written)
    }
}

impl From<ScriptedEffect> for Written {
    fn from(effect: ScriptedEffect) -> Self {
        let mut written = effect.written;
        // With the text at hand the path only gives it a name, and files are not to tell of other folders.
        if written.text.is_some() && written.path.is_absolute() {
            written.path = written.path.file_name().map(PathBuf::from).unwrap_or_default();
        }
        written
    }
}

#[typetag::serde(name = "script")]
impl Effect for ScriptedEffect {
    /// In its author's words, and by the name of its file, once it is loaded.
    fn about(&self) -> About {
        self.told
    }

    fn load(&mut self, folder: &Path) -> Result<()> {
        if self.loaded.is_some() {
            return Ok(());
        }
        let text = text::read(&files::inside(folder, &self.written.path)?)?;
        self.read(text)
    }

    fn terms(&self, robot: &Robot) -> Result<Vec<Term>> {
        let joints = self.joints(robot)?;
        let terms = |parameter: &EffectParameter| -> Vec<Term> {
            let unit = lasting(&parameter.unit);
            if parameter.common {
                return vec![Term { symbol: parameter.symbol.clone(), unit, joints: joints.clone() }];
            }
            let one =
                |&j: &usize| Term { symbol: format!("{}{}", parameter.symbol, j + 1), unit, joints: vec![j] };
            joints.iter().map(one).collect()
        };
        Ok(self.script()?.about().parameters.iter().flat_map(terms).collect())
    }

    fn columns(&self, at: &Stretch<'_>, out: &mut Columns<'_>) -> Result<()> {
        let script = self.script()?;
        let lowered = self.lowered(at.robot, &at.run.stop)?;
        let mut clock = script.clock(self.written.seconds, &at.run.stop);
        let shapes = self.shape_values(script);
        let count = lowered.joints.len();
        for (place, part) in lowered.joints.iter().enumerate() {
            let columns = part.over(script, at, &shapes, &self.traces, &mut clock)?;
            let mut first = 0;
            for (parameter, column) in script.about().parameters.iter().zip(&columns) {
                let term = if parameter.common { first } else { first + place };
                first += if parameter.common { 1 } else { count };
                out.column(term, part.joint, |slot| slot.copy_from_slice(column));
            }
        }
        Ok(())
    }

    fn boxed(&self) -> Box<dyn Effect> {
        Box::new(self.clone())
    }

    /// The effect once per joint, or as one where joints share a parameter.
    fn one_by_one(&self, robot: &Robot) -> Result<Vec<Box<dyn Effect>>> {
        if self.script()?.about().parameters.iter().any(|p| p.common) {
            return Ok(vec![self.boxed()]);
        }
        let of = |joint: usize| -> Box<dyn Effect> {
            let mut one = self.clone();
            one.written.joints = Joints::Only(vec![robot.joints[joint].name.clone()]);
            one.lowered = Arc::default();
            Box::new(one)
        };
        Ok(self.joints(robot)?.into_iter().map(of).collect())
    }

    fn shapes(&self) -> Vec<Shape> {
        let Some(script) = &self.loaded else { return Vec::new() };
        let values = self.shape_values(script).into_iter();
        let shape = |(s, value): (&crate::script::EffectShape, f64)| Shape {
            symbol: lasting(&s.symbol),
            unit: lasting(&s.unit),
            value,
            low: s.min,
            high: s.max,
            trials: s.trials.clone(),
        };
        script.about().shapes.iter().zip(values).map(shape).collect()
    }

    fn with_shapes(&self, values: &[f64]) -> Box<dyn Effect> {
        let mut other = self.clone();
        if let Some(script) = &self.loaded {
            let symbols = script.about().shapes.iter().map(|s| s.symbol.clone());
            other.written.shapes = symbols.zip(values.iter().copied()).collect();
        }
        Box::new(other)
    }

    fn implausible(&self, _robot: &Robot, values: &[f64]) -> Option<String> {
        let parameters = &self.loaded.as_ref()?.about().parameters;
        let shared = parameters.iter().filter(|p| p.common).count();
        let joints = values.len().saturating_sub(shared) / (parameters.len() - shared).max(1);
        let mut rest = values.iter();
        for parameter in parameters {
            for &value in rest.by_ref().take(if parameter.common { 1 } else { joints }) {
                if !(parameter.min <= value && value <= parameter.max) {
                    let (symbol, unit) = (&parameter.symbol, &parameter.unit);
                    return Some(format!(
                        "{symbol} = {value:.4} {unit}, outside of the script's {} to {}",
                        parameter.min, parameter.max
                    ));
                }
            }
        }
        None
    }

    fn undecidable(&self, robot: &Robot, runs: &[Run]) -> Option<String> {
        // What is wrong with the script itself is said where its columns are asked for.
        let stop = runs.first().map(|run| run.stop.clone()).unwrap_or_default();
        let lowered = self.lowered(robot, &stop).ok()?;
        runs.iter().find_map(|run| lowered.joints.iter().find_map(|part| part.lacks(robot, run)))
    }
}

/// What the script says about itself, to stand beside the effects that are compiled in.
fn told(path: &Path, script: &EffectScript) -> About {
    let about = script.about();
    let name = path.file_name().map_or("script".into(), |name| name.to_string_lossy());
    let parameters = about.parameters.iter().map(|p| (&p.symbol, &p.unit, &p.meaning));
    let shapes = about.shapes.iter().map(|s| (&s.symbol, &s.unit, &s.meaning));
    let built_from = if script.needs_torque() { BuiltFrom::ModelTorque } else { BuiltFrom::Motion };
    About {
        name: lasting(&name),
        title: lasting(&about.title),
        text: lasting(&about.text),
        equation: lasting(&about.equation),
        parameters: lasting_list(
            parameters.chain(shapes).map(|(s, u, m)| Parameter::new(lasting(s), lasting(u), lasting(m))),
        ),
        confused_with: lasting(&about.confused_with),
        special: Special { built_from, ..Special::NONE },
        ..ScriptedEffect::ABOUT
    }
}

/// Lists of parameters last as long as the program; each different one is kept once.
fn lasting_list(parameters: impl Iterator<Item = Parameter>) -> &'static [Parameter] {
    static KEPT: Mutex<Vec<&'static [Parameter]>> = Mutex::new(Vec::new());
    let parameters: Vec<Parameter> = parameters.collect();
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = kept.iter().find(|known| **known == parameters.as_slice()) {
        return known;
    }
    let new: &'static [Parameter] = Box::leak(parameters.into_boxed_slice());
    kept.push(new);
    new
}

/// Names of units and symbols last as long as the program; each different one is kept once.
fn lasting(text: &str) -> &'static str {
    static KEPT: Mutex<BTreeSet<&'static str>> = Mutex::new(BTreeSet::new());
    let mut kept = KEPT.lock().unwrap_or_else(PoisonError::into_inner);
    if let Some(known) = kept.get(text) {
        return known;
    }
    let new: &'static str = Box::leak(text.to_string().into_boxed_str());
    kept.insert(new);
    new
}
