//! Numbers a scenario gives to a script under `with`, checked against those that the script says it has.

use std::collections::BTreeMap;

use rhai::{Array, Dynamic, Map};
use serde::{Deserialize, Serialize};

use super::engine::Machine;
use super::tracer::kind;
use crate::error::{Error, Result};

/// Settings by name.
pub type Settings = BTreeMap<String, Setting>;

/// A value that a scenario can give.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(untagged)]
pub enum Setting {
    /// `true`, `false`.
    Flag(bool),
    /// A whole number.
    Whole(i64),
    /// A number.
    Number(f64),
    /// A text.
    Text(String),
    /// Several of them.
    List(Vec<Setting>),
}

impl Setting {
    fn kind(&self) -> &'static str {
        match self {
            Self::Flag(_) => "true or false",
            Self::Whole(_) | Self::Number(_) => "a number",
            Self::Text(_) => "a text",
            Self::List(_) => "a list",
        }
    }

    /// The value for the script.
    pub(super) fn value(&self) -> Dynamic {
        match self {
            Self::Flag(flag) => Dynamic::from_bool(*flag),
            Self::Whole(whole) => Dynamic::from_int(*whole),
            Self::Number(number) => Dynamic::from_float(*number),
            Self::Text(text) => Dynamic::from(text.clone()),
            Self::List(list) => Dynamic::from_array(list.iter().map(Self::value).collect()),
        }
    }

    fn from_script(value: &Dynamic) -> Option<Self> {
        if let Ok(flag) = value.as_bool() {
            return Some(Self::Flag(flag));
        }
        if let Ok(whole) = value.as_int() {
            return Some(Self::Whole(whole));
        }
        if let Ok(number) = value.as_float() {
            return Some(Self::Number(number));
        }
        if let Ok(text) = value.as_immutable_string_ref() {
            return Some(Self::Text(text.to_string()));
        }
        value.read_lock::<Array>()?.iter().map(Self::from_script).collect::<Option<_>>().map(Self::List)
    }
}

impl std::fmt::Display for Setting {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Flag(flag) => write!(f, "{flag}"),
            Self::Whole(whole) => write!(f, "{whole}"),
            Self::Number(number) => write!(f, "{number:?}"),
            Self::Text(text) => write!(f, "{text:?}"),
            Self::List(list) => {
                let all: Vec<String> = list.iter().map(ToString::to_string).collect();
                write!(f, "[{}]", all.join(", "))
            }
        }
    }
}

/// What `fn settings()` of the script returned.
pub(super) fn own(machine: &Machine, returned: Dynamic) -> Result<Settings> {
    let (line, column) = machine.dialect.functions.get("settings").map_or((1, 1), |d| d.spot);
    let refuse = |what: String| {
        Error::new(what).at(line, column).help("return a map, as in `#{ min: 16.0, max: 20.0 }`")
    };
    let kind = kind(&returned);
    let Some(map) = returned.try_cast::<Map>() else {
        return Err(refuse(format!("`settings` returns {kind}")));
    };
    let one = |(name, value): (rhai::Identifier, Dynamic)| {
        let setting = Setting::from_script(&value);
        setting
            .map(|s| (name.to_string(), s))
            .ok_or_else(|| refuse(format!("the setting `{name}` is no number, text, flag or list")))
    };
    map.into_iter().map(one).collect()
}

/// The script's settings, with those of the scenario in their place.
pub(super) fn merge(mut own: Settings, with: &Settings) -> Result<Settings> {
    for (name, given) in with {
        let known: Vec<String> = own.keys().cloned().collect();
        let Some(slot) = own.get_mut(name) else {
            let help = match known.as_slice() {
                [] => "the script has none; `fn settings() { #{ name: value } }` gives it some".to_string(),
                _ => format!("known are {}", known.join(", ")),
            };
            return Err(Error::new(format!("the script has no setting `{name}`")).help(help));
        };
        *slot = match (&slot, given) {
            (Setting::Number(_), Setting::Whole(whole)) => Setting::Number(*whole as f64),
            (Setting::Whole(_), Setting::Number(number)) => Setting::Number(*number),
            (old, new) if old.kind() == new.kind() => new.clone(),
            (old, new) => {
                return Err(Error::new(format!(
                    "the setting `{name}` is {}, not {}",
                    old.kind(),
                    new.kind()
                ))
                .help("give it a value like the script's own in `fn settings()`"));
            }
        };
    }
    Ok(own)
}
