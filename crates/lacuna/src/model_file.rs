//! A finished model as a file: effects, numbers, and how they were found. Written by studies, read by
//! `compare`, and meant to be read and edited by people.

use std::path::Path;

use serde::{Deserialize, Serialize};

use crate::effects::Effect;
use crate::error::{Error, Result};
use crate::identify::parameter_name;
use crate::model::{Column, Model};
use crate::robot::{PARAMETER_UNITS, Robot};
use crate::signals::Settings;
use crate::text::{self, names::list};

/// A finished model.
#[derive(Debug, Clone, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ModelFile {
    /// Version that wrote it.
    pub lacuna: String,
    /// Name of the robot.
    pub robot: String,
    /// How it was found, for people.
    pub origin: String,
    /// The signal step it was fitted with.
    pub signals: Settings,
    /// What makes the torque.
    pub effects: Vec<Box<dyn Effect>>,
    /// Values; link parameters that are not listed are zero.
    pub parameters: Vec<ParameterValue>,
}

/// One number of a model.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterValue {
    /// Symbol: `Jxx2` (a link parameter) or the effect's own (`fc3`).
    pub symbol: String,
    /// Value.
    pub value: f64,
    /// Unit.
    pub unit: String,
    /// Standard error, where known.
    #[serde(default)]
    pub standard_error: Option<f64>,
    /// What the number stands for when it leads a base parameter.
    #[serde(default)]
    pub stands_for: Option<String>,
}

impl ModelFile {
    /// From a fitted model.
    pub fn new(model: &Model, x: &[f64], errors: &[f64], signals: Settings, origin: String) -> Self {
        let value = |(i, column): (usize, &Column)| ParameterValue {
            symbol: column.about.symbol.clone(),
            value: x[i],
            unit: column.about.unit.to_string(),
            standard_error: errors.get(i).copied().filter(|e| e.is_finite()),
            stands_for: (column.expression != column.about.symbol).then(|| column.expression.clone()),
        };
        Self {
            lacuna: env!("CARGO_PKG_VERSION").to_string(),
            robot: model.robot.name.clone(),
            origin,
            signals,
            effects: model.effects.clone(),
            parameters: model.columns.iter().enumerate().map(value).collect(),
        }
    }

    /// With parameters of every link, ten each, and those of the other effects.
    pub fn with_links(
        robot: &Robot,
        links: &[f64],
        effects: Vec<Box<dyn Effect>>,
        others: Vec<ParameterValue>,
        signals: Settings,
        origin: String,
    ) -> Self {
        let value = |(i, &value): (usize, &f64)| ParameterValue {
            symbol: parameter_name(i),
            value,
            unit: PARAMETER_UNITS[i % PARAMETER_UNITS.len()].to_string(),
            standard_error: None,
            stands_for: None,
        };
        Self {
            lacuna: env!("CARGO_PKG_VERSION").to_string(),
            robot: robot.name.clone(),
            origin,
            signals,
            effects,
            parameters: links.iter().enumerate().map(value).chain(others).collect(),
        }
    }

    /// Reads a model file.
    ///
    /// # Errors
    /// With file, line and column.
    pub fn open(path: &Path) -> Result<Self> {
        Self::parse(&text::read(path)?).map_err(|e| e.in_file(path))
    }

    /// Reads the text of a model file.
    ///
    /// # Errors
    /// With line and column.
    pub fn parse(text: &str) -> Result<Self> {
        let shape = "`lacuna scenario` writes models, as model.ron in its --out folder";
        let file: Self = text::from_ron(text).map_err(|e| e.or_help(shape))?;
        file.check().map_err(|e| text::located(e, text))?;
        Ok(file)
    }

    fn check(&self) -> Result<()> {
        self.signals.check()?;
        if self.effects.is_empty() {
            return Err(Error::new("`effects` names none").help("a model has at least one effect"));
        }
        let mut seen = std::collections::BTreeSet::new();
        for p in &self.parameters {
            if !seen.insert(&p.symbol) {
                return Err(
                    Error::new(format!("the parameter `{}` stands twice", p.symbol)).help("keep one of them")
                );
            }
            if !p.value.is_finite() {
                return Err(Error::new(format!("the parameter `{}` is {}", p.symbol, p.value))
                    .help("give a finite number"));
            }
        }
        Ok(())
    }

    /// Writes it, whole or not at all.
    ///
    /// # Errors
    /// When the folder cannot be written to.
    pub fn write(&self, path: &Path) -> Result<()> {
        text::write_whole(path, text::to_ron(self)?.as_bytes())
    }

    /// The model on `robot`, with one value per column.
    ///
    /// # Errors
    /// When it is a model of another robot, an effect does not fit, or a parameter is unknown or lacking.
    pub fn on(&self, robot: &Robot) -> Result<(Model, Vec<f64>)> {
        if self.robot != robot.name {
            let what = format!("this is a model of the `robot` `{}`, not of `{}`", self.robot, robot.name);
            return Err(Error::new(what).help(
                "give the model its own robot; where that was only renamed, write the new name into the model",
            ));
        }
        let model = Model::new(robot, self.effects.clone())?;
        let mut links = vec![0.0; 10 * robot.dof()];
        let names: Vec<String> = (0..links.len()).map(parameter_name).collect();
        let mut x = vec![0.0; model.columns.len()];
        for p in &self.parameters {
            let rigid = names.iter().position(|n| *n == p.symbol);
            let own = model.columns.iter().position(|c| c.about.symbol == p.symbol);
            match (rigid, own) {
                (Some(i), _) if model.base.is_some() => links[i] = p.value,
                (_, Some(i)) => x[i] = p.value,
                _ => {
                    let known: Vec<&str> = model.columns.iter().map(|c| c.about.symbol.as_str()).collect();
                    return Err(Error::new(format!(
                        "no effect of this model has a parameter `{}`",
                        p.symbol
                    ))
                    .help(format!("known are {}", list(known))));
                }
            }
        }
        let given = |c: &&Column| self.parameters.iter().any(|p| p.symbol == c.about.symbol);
        let rigid = |c: &Column| model.effects[c.effect].is_rigid_body();
        if let Some(lost) = model.columns.iter().find(|c| !rigid(c) && !given(c)) {
            return Err(Error::new(format!("`parameters` holds no value of `{}`", lost.about.symbol))
                .help("give every parameter of every effect; only link parameters may be left out"));
        }
        if let Some(base) = &model.base {
            let first = model.columns.iter().position(rigid).unwrap_or(0);
            for (i, value) in base.coefficients(&links).into_iter().enumerate() {
                x[first + i] = value;
            }
        }
        Ok((model, x))
    }
}
