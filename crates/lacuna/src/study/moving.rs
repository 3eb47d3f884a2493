//! Identification from logs of a moving robot.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};
use crate::excitation::Ramped;
use crate::identify::{
    Errors, Evidence, Fit, Settled, Weighting, fit, fit_huber, held_out, relative_deviations, settle,
    with_robust_sd,
};
use crate::log::{ColumnMap, Log};
use crate::model::Model;
use crate::model_file::ModelFile;
use crate::plant::Plant;
use crate::predict::{predict, prediction_errors};
use crate::report::{Coefficient, Identification, Validation, finite, joint_errors};
use crate::scenario::{Logs, Simulated, find_log};
use crate::signals::{Run, prepare, thinned};
use crate::simulate;

use super::{Study, too_few_rows};

/// What all logs gave.
#[derive(Default)]
pub(super) struct Gathered {
    /// The identification, where there are logs to fit.
    pub fitted: Option<FromLogs>,
    /// Logs that are only predicted.
    pub held: Vec<Run>,
    /// All logs, where a diagnosis is asked for.
    pub to_diagnose: Option<super::diagnosis::Logs>,
}

impl Gathered {
    /// What models are compared on, and whether it was fitted: the logs that were not, where there are any.
    pub fn to_compare(&self) -> (&[Run], bool) {
        let runs = self.fitted.as_ref().map_or(&[][..], |fitted| &fitted.runs);
        if self.held.is_empty() { (runs, true) } else { (&self.held, false) }
    }

    /// What friction is fitted to.
    pub fn to_fit(&self) -> &[Run] {
        self.fitted.as_ref().map_or(&self.held, |fitted| &fitted.runs)
    }
}

/// What the fitted logs gave.
pub(super) struct FromLogs {
    pub report: Identification,
    pub model: ModelFile,
    pub runs: Vec<Run>,
    /// The fitted model, for what comes after.
    pub fitted: Model,
    /// Its parameters.
    pub x: Vec<f64>,
    /// Everything least squares knows of the logs.
    pub evidence: Evidence,
}

struct Prepared {
    runs: Vec<Run>,
    lines: Vec<String>,
    names: Vec<String>,
}

impl Study<'_> {
    pub(super) fn identify_from_logs(&mut self) -> Result<Gathered> {
        let Some((fitted, validated)) = self.logs()? else { return Ok(Gathered::default()) };
        let to_diagnose = self.scenario.diagnosis.then(|| (fitted.clone(), validated.clone()));
        let held = self.prepare_all(&validated)?.runs;
        let fitted = if fitted.is_empty() { None } else { Some(self.identify_from(&fitted, &held)?) };
        Ok(Gathered { fitted, held, to_diagnose })
    }

    fn identify_from(&mut self, logs: &[Log], held: &[Run]) -> Result<FromLogs> {
        let mut data = self.prepare_all(logs)?;
        let model = Model::new(&self.robot, self.scenario.effects.clone())?;
        self.say(&format!("fitting {} parameters", model.columns.len()));
        let folds = self.scenario.hold_out.folds(&data.runs)?;
        let weighting = self.scenario.weighting;
        let settled = settle(&model, &mut data.runs, &folds, weighting)?;
        self.warn_of_wandering(&settled);
        let evidence = settled.evidence;
        let fitted = match weighting {
            Weighting::Huber => fit_huber(&model, &data.runs, &folds, &evidence)?,
            other => fit(&model, &evidence, None, other)?,
        };
        let fitted = with_robust_sd(&model, &data.runs, &evidence, fitted)?;
        let out = held_out(&model, &evidence, weighting)?;
        self.warn_of_fit(&model, &fitted);
        let mut report = self.moving_report(&model, &fitted, &out, &data)?;
        report.split = Some(folds.description.clone());
        report.validation = validate(&model, &fitted, held)?;
        let origin = format!("logs: {}", data.names.join(", "));
        let file =
            ModelFile::new(&model, &fitted.x, &fitted.robust_sd, self.scenario.signals.clone(), origin);
        Ok(FromLogs { report, model: file, runs: data.runs, fitted: model, x: fitted.x, evidence })
    }

    /// Logs to fit and logs to predict.
    fn logs(&mut self) -> Result<Option<(Vec<Log>, Vec<Log>)>> {
        let Some(logs) = &self.scenario.logs else { return Ok(None) };
        match logs {
            Logs::Simulated(_) => Ok(Some((vec![self.simulated()?], Vec::new()))),
            Logs::Files { fit, validate, columns, missing } => {
                let map = columns.as_ref().map(|c| ColumnMap::open(self.folder.join(c))).transpose()?;
                let open = |path: &Path| {
                    thinned(Log::open(path, &self.robot, map.as_ref())?, &self.scenario.signals)
                };
                if !self.data.is_empty() {
                    let fitted: Vec<Log> = self.data.iter().map(|p| open(p)).collect::<Result<_>>()?;
                    return Ok(Some((fitted, Vec::new())));
                }
                let found = |file: &PathBuf| find_log(&self.folder, file, missing.as_deref());
                let all = |files: &[PathBuf]| -> Result<Vec<Log>> {
                    files.iter().map(|file| open(&found(file)?)).collect()
                };
                Ok(Some((all(fit)?, all(validate)?)))
            }
        }
    }

    fn simulated(&mut self) -> Result<Log> {
        let Some(Logs::Simulated(simulated)) = self.scenario.logs.take() else {
            return Err(Error::new("the scenario simulates nothing"));
        };
        let Simulated { motion, duration_s, ramp_s, effects, controller, sensors } = *simulated;
        self.say(&format!("simulating {} s of motion", duration_s + 2.0 * ramp_s));
        let motion = simulate::motion(&self.robot, &motion, self.seed)?;
        let ramped = Ramped::new(motion, duration_s, ramp_s)?;
        let mut plant = Plant::new(self.robot.clone())?;
        (plant.effects, plant.controller, plant.sensors) = (effects, controller, sensors);
        let mut log = plant.simulate(&ramped, ramped.total_s(), self.seed)?.log;
        log.name = "simulated run".to_string();
        Ok(log)
    }

    fn prepare_all(&mut self, logs: &[Log]) -> Result<Prepared> {
        let mut all = Prepared { runs: Vec::new(), lines: Vec::new(), names: Vec::new() };
        for log in logs {
            self.say(&format!("preparing the signals of {}", log.name));
            let (run, report) = prepare(log, &self.scenario.signals)?;
            all.lines.extend(report.lines());
            all.names.push(log.name.clone());
            all.runs.push(Run { stop: self.stop.clone(), ..run });
        }
        Ok(all)
    }

    fn warn_of_fit(&mut self, model: &Model, fit: &Fit) {
        if let Some(warning) = too_few_rows(fit.rows, model.columns.len()) {
            self.warn(warning);
        }
        if !fit.unexcited.is_empty() {
            let names: Vec<_> =
                fit.unexcited.iter().map(|&c| model.columns[c].about.symbol.as_str()).collect();
            self.warn(format!("this motion does not excite {}; left at zero", names.join(", ")));
        }
    }

    fn warn_of_wandering(&mut self, settled: &Settled) {
        if settled.wanders() {
            self.warn(format!(
                "effects built from the model's torque did not settle: the last round moved it by {:.2} %",
                100.0 * settled.change
            ));
        }
    }

    fn moving_report(
        &self,
        model: &Model,
        fit: &Fit,
        out: &Errors,
        data: &Prepared,
    ) -> Result<Identification> {
        let mode = self.scenario.signals.mode;
        let errors = prediction_errors(&data.runs, &predict(model, &data.runs, &fit.x)?);
        let names: Vec<String> = model.robot.joints.iter().map(|j| j.name.clone()).collect();
        Ok(Identification {
            label: "exciting trajectory".to_string(),
            mode: mode.name().to_string(),
            data: data.names.clone(),
            signals: data.lines.clone(),
            split: None,
            weighting: format!("{:?}", self.scenario.weighting).to_lowercase(),
            rows: fit.rows,
            rank: model.base.as_ref().map_or(0, |b| b.rank()),
            condition_number: fit.condition_number,
            relative_error_percent: fit.errors.pooled_percent,
            held_out_relative_error_percent: finite(out.pooled_percent),
            joints: joint_errors(&names, &errors, Some(out)),
            coefficients: coefficients(model, fit, self.scenario.drop_above_percent),
            not_excited: fit.unexcited.iter().map(|&c| model.columns[c].about.symbol.clone()).collect(),
            dropped_over_draws: None,
            validation: Vec::new(),
        })
    }
}

/// Predicts runs that were never fitted.
fn validate(model: &Model, fit: &Fit, held: &[Run]) -> Result<Vec<Validation>> {
    let names: Vec<String> = model.robot.joints.iter().map(|j| j.name.clone()).collect();
    let one = |run: &Run| {
        let runs = std::slice::from_ref(run);
        let errors = prediction_errors(runs, &predict(model, runs, &fit.x)?);
        Ok(Validation {
            data: run.name.clone(),
            relative_error_percent: errors.pooled_percent,
            joints: joint_errors(&names, &errors, None),
        })
    };
    held.iter().map(one).collect()
}

fn coefficients(model: &Model, fit: &Fit, drop_above_percent: Option<f64>) -> Vec<Coefficient> {
    let classical = relative_deviations(&fit.x, &fit.classical_sd);
    let robust = relative_deviations(&fit.x, &fit.robust_sd);
    let limit = drop_above_percent.unwrap_or(f64::INFINITY);
    model
        .columns
        .iter()
        .enumerate()
        .map(|(i, column)| Coefficient {
            expression: column.expression.clone(),
            symbol: column.about.symbol.clone(),
            unit: column.about.unit.to_string(),
            value: finite(fit.x[i]),
            relative_sd_percent: finite(classical[i]),
            robust_sd_percent: finite(robust[i]),
            kept: !fit.unexcited.contains(&i) && classical[i] <= limit,
            published: None,
        })
        .collect()
}
