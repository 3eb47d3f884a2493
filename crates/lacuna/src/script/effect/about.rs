//! What `fn about()` of an effect script says: words for people, parameters, shapes and memory.

use rhai::{Array, Dynamic, Map};

use crate::error::{Error, Result};
use crate::script::engine::Machine;
use crate::script::tracer::kind;

/// An effect in its author's words.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct EffectAbout {
    /// One line.
    pub title: String,
    /// What it is and how it shows in data.
    pub text: String,
    /// Torque as a formula.
    pub equation: String,
    /// Effects it is easily mistaken for.
    pub confused_with: String,
    /// Joints it is meant for, by name; all of them where none is named.
    pub joints: Vec<String>,
    /// Linear parameters, one column each.
    pub parameters: Vec<EffectParameter>,
    /// Numbers that the columns depend on nonlinearly.
    pub shapes: Vec<EffectShape>,
    /// What is remembered from sample to sample, with the values at the first.
    pub memory: Vec<(String, f64)>,
}

/// A linear parameter.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectParameter {
    /// Symbol; a joint's number is appended unless it is `common`.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// What it means.
    pub meaning: String,
    /// Least value that can be physics; minus infinity where any can.
    pub min: f64,
    /// Largest value that can be physics; infinity where any can.
    pub max: f64,
    /// Whether all joints have the same one.
    pub common: bool,
}

/// A number that the columns depend on nonlinearly.
#[derive(Debug, Clone, PartialEq)]
pub struct EffectShape {
    /// Symbol.
    pub symbol: String,
    /// Unit.
    pub unit: String,
    /// What it means.
    pub meaning: String,
    /// Its value until it is fitted.
    pub value: f64,
    /// Least value that makes sense.
    pub min: f64,
    /// Largest value that makes sense.
    pub max: f64,
    /// Values a search starts from.
    pub trials: Vec<f64>,
}

const KEYS: [&str; 8] =
    ["title", "text", "equation", "confused_with", "joints", "parameters", "shapes", "memory"];
const PARAMETER: [&str; 6] = ["symbol", "unit", "meaning", "min", "max", "common"];
const SHAPE: [&str; 7] = ["symbol", "unit", "meaning", "value", "min", "max", "trials"];

/// A map that is taken apart key by key; what it lacks or has too much is an error at `fn about()`.
struct Fields {
    map: Map,
    what: String,
    place: (usize, usize),
}

/// Reads what `fn about()` returned.
pub(super) fn read(machine: &Machine, returned: Dynamic) -> Result<EffectAbout> {
    let place = machine.place("about");
    let mut fields = Fields::new(returned, "what `about` returns".into(), place, &KEYS)?;
    let about = EffectAbout {
        title: fields.text("title")?,
        text: fields.text("text")?,
        equation: fields.text("equation")?,
        confused_with: fields.text_or("confused_with", "")?,
        joints: joints(&mut fields)?,
        parameters: fields
            .list("parameters")?
            .into_iter()
            .map(|p| parameter(p, place))
            .collect::<Result<_>>()?,
        shapes: fields.list("shapes")?.into_iter().map(|s| shape(s, place)).collect::<Result<_>>()?,
        memory: memory(&mut fields)?,
    };
    if about.parameters.is_empty() {
        return Err(fields.refuse("the effect has no parameters").help(
            "every column needs one, as in parameters: [#{ symbol: \"k\", unit: \"N m\", meaning: \"..\" }]",
        ));
    }
    let symbols: Vec<&String> =
        about.parameters.iter().map(|p| &p.symbol).chain(about.shapes.iter().map(|s| &s.symbol)).collect();
    match (1..symbols.len()).find(|&k| symbols[..k].contains(&symbols[k])) {
        Some(k) => Err(fields.refuse(&format!("the symbol `{}` stands twice", symbols[k]))),
        None => Ok(about),
    }
}

fn joints(fields: &mut Fields) -> Result<Vec<String>> {
    let names = fields.list("joints")?.into_iter().map(|name| name.into_string().map_err(|_| ()));
    names
        .collect::<Result<_, ()>>()
        .map_err(|()| fields.refuse("`joints` is a list of names, as in joints: [\"joint2\"]"))
}

fn parameter(value: Dynamic, place: (usize, usize)) -> Result<EffectParameter> {
    let mut fields = Fields::new(value, "a parameter".into(), place, &PARAMETER)?;
    let symbol = fields.symbol()?;
    fields.what = format!("the parameter `{symbol}`");
    let (min, max) = fields.limits(f64::NEG_INFINITY, f64::INFINITY)?;
    Ok(EffectParameter {
        unit: fields.text("unit")?,
        meaning: fields.text("meaning")?,
        min,
        max,
        common: fields.flag("common")?,
        symbol,
    })
}

fn shape(value: Dynamic, place: (usize, usize)) -> Result<EffectShape> {
    let mut fields = Fields::new(value, "a shape".into(), place, &SHAPE)?;
    let symbol = fields.symbol()?;
    fields.what = format!("the shape `{symbol}`");
    let value = fields.number("value", None)?;
    let (min, max) = fields.limits(f64::NAN, f64::NAN)?;
    if !(min <= value && value <= max) {
        return Err(fields.refuse(&format!("its value {value} lies outside of {min} to {max}")));
    }
    let trials: Vec<f64> = fields
        .list("trials")?
        .iter()
        .map(|v| plain(v).ok_or(""))
        .collect::<Result<_, _>>()
        .map_err(|_| fields.refuse("`trials` are plain numbers, as in trials: [0.1, 1.0]"))?;
    if let Some(outside) = trials.iter().find(|t| !(min <= **t && **t <= max)) {
        return Err(fields.refuse(&format!("the trial {outside} lies outside of {min} to {max}")));
    }
    let trials = if trials.is_empty() { vec![value] } else { trials };
    let (unit, meaning) = (fields.text("unit")?, fields.text("meaning")?);
    Ok(EffectShape { symbol, unit, meaning, value, min, max, trials })
}

fn memory(fields: &mut Fields) -> Result<Vec<(String, f64)>> {
    let Some(value) = fields.map.remove("memory") else { return Ok(Vec::new()) };
    let wrong = "`memory` is a map of plain numbers, as in memory: #{ heat: 0.0 }";
    let map = value.try_cast::<Map>().ok_or_else(|| fields.refuse(wrong))?;
    map.into_iter()
        .map(|(name, value)| Some((name.to_string(), plain(&value)?)))
        .collect::<Option<_>>()
        .ok_or_else(|| fields.refuse(wrong))
}

/// A finite number without unknowns.
fn plain(value: &Dynamic) -> Option<f64> {
    let number = value.as_float().ok().or_else(|| value.as_int().ok().map(|whole| whole as f64));
    number.filter(|x| x.is_finite())
}

impl Fields {
    fn new(value: Dynamic, what: String, place: (usize, usize), known: &[&str]) -> Result<Self> {
        let found = kind(&value);
        let mut fields = Self { map: Map::new(), what, place };
        fields.map = value.try_cast::<Map>().ok_or_else(|| {
            fields.refuse(&format!("a map is needed, not {found}")).help("maps are written #{ name: value }")
        })?;
        match fields.map.keys().find(|key| !known.contains(&key.as_str())) {
            Some(key) => {
                let text = format!("`{key}` is unknown");
                Err(fields.refuse(&text).help(format!("known are {}", known.join(", "))))
            }
            None => Ok(fields),
        }
    }

    fn refuse(&self, text: &str) -> Error {
        Error::new(format!("{}: {text}", self.what)).at(self.place.0, self.place.1).help(
            "`fn about()` returns #{ title: \"..\", text: \"..\", equation: \"..\", parameters: [..] }, and where \
             needed shapes: [..] and memory: #{ .. }",
        )
    }

    fn text(&mut self, key: &str) -> Result<String> {
        match self.map.remove(key) {
            // Texts over several lines are broken where the reader's page wants it.
            Some(value) => match value.into_string() {
                Ok(text) => Ok(text.split_whitespace().collect::<Vec<_>>().join(" ")),
                Err(_) => Err(self.refuse(&format!("`{key}` is a text"))),
            },
            None => Err(self.refuse(&format!("`{key}` is missing"))),
        }
    }

    fn text_or(&mut self, key: &str, default: &str) -> Result<String> {
        if self.map.contains_key(key) { self.text(key) } else { Ok(default.into()) }
    }

    /// A name that can stand in reports and files.
    fn symbol(&mut self) -> Result<String> {
        let symbol = self.text("symbol")?;
        let fine = symbol.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
            && symbol.starts_with(|c: char| c.is_ascii_alphabetic())
            && !symbol.ends_with(|c: char| c.is_ascii_digit());
        if fine {
            return Ok(symbol);
        }
        let text = format!("the symbol `{symbol}` is not made of letters, or ends in a digit");
        Err(self.refuse(&text).help("a joint's number is appended to it: `k` becomes `k3`"))
    }

    fn number(&mut self, key: &str, default: Option<f64>) -> Result<f64> {
        match (self.map.remove(key), default) {
            (Some(value), _) => {
                plain(&value).ok_or_else(|| self.refuse(&format!("`{key}` is a plain number")))
            }
            (None, Some(default)) => Ok(default),
            (None, None) => Err(self.refuse(&format!("`{key}` is missing"))),
        }
    }

    /// `min` and `max`; needed where the default is not a number.
    fn limits(&mut self, low: f64, high: f64) -> Result<(f64, f64)> {
        let min = self.number("min", Some(low).filter(|x| !x.is_nan()))?;
        let max = self.number("max", Some(high).filter(|x| !x.is_nan()))?;
        if min <= max {
            Ok((min, max))
        } else {
            Err(self.refuse(&format!("min {min} is larger than max {max}")))
        }
    }

    fn flag(&mut self, key: &str) -> Result<bool> {
        match self.map.remove(key) {
            Some(value) => value.as_bool().map_err(|_| self.refuse(&format!("`{key}` is true or false"))),
            None => Ok(false),
        }
    }

    fn list(&mut self, key: &str) -> Result<Array> {
        match self.map.remove(key) {
            Some(value) => value
                .try_cast::<Array>()
                .ok_or_else(|| self.refuse(&format!("`{key}` is a list, as in [..]"))),
            None => Ok(Array::new()),
        }
    }
}
