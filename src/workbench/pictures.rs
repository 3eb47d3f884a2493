//! The data of the page's pictures: one model, or two beside each other, as the report's page takes them.

use std::sync::Arc;

use serde_json::Value;

use super::bench::Bench;
use super::study::{Step, Study};
use super::work;
use crate::diagnose::{self, Fitted};
use crate::error::{Error, Result};
use crate::report::page::Page;
use crate::report::pictures::{Compared, Pictures};

/// Which models are wanted; those on show where none is named.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Pair {
    pub step: Option<usize>,
    pub against: Option<usize>,
}

/// What a page needs, taken out of the study so that nobody waits while it is written.
pub(super) struct Shown {
    title: String,
    pub step: Arc<Fitted>,
    pub against: Option<Arc<Fitted>>,
    labels: [String; 2],
    step_data: Step,
    climb: Vec<diagnose::Step>,
    report: Option<Arc<Value>>,
}

impl Shown {
    /// The models that are asked for.
    ///
    /// # Errors
    /// When one of them is not there, or not fitted yet.
    pub fn of(bench: &Bench, pair: Pair) -> Result<Self> {
        let study = bench.study();
        let id = pair.step.or(study.shown).ok_or_else(|| Error::new("there is no model yet"))?;
        let against = if pair.step.is_some() { pair.against } else { pair.against.or(study.against) };
        let find = |id: usize| study.step(id).ok_or_else(|| Error::new(format!("there is no step {id}")));
        let fitted = |step: &Step| {
            step.fitted.clone().ok_or_else(|| Error::new(format!("step {} is being fitted", step.id)))
        };
        let step = find(id)?;
        let other = against.filter(|a| *a != id).map(find).transpose()?;
        Ok(Self {
            title: study.name.clone(),
            step: fitted(step)?,
            against: other.map(fitted).transpose()?,
            labels: [other.map_or_else(String::new, work::label), work::label(step)],
            step_data: step.clone(),
            climb: climb(&study, id),
            report: study.retrieval.as_ref().and_then(|r| r.report.clone()),
        })
    }

    /// As the report's page takes it.
    ///
    /// # Errors
    /// When a number cannot be written as JSON.
    pub fn page(&self) -> Result<Value> {
        let pictures = self.pictures();
        let mut data = self.as_page(&pictures).data()?;
        if let Some(report) = &self.report {
            let mut report = report.as_ref().clone();
            if let Value::Object(fields) = &mut report {
                fields.remove("timing");
                fields.remove("diagnosis");
            }
            data["report"] = report;
        }
        Ok(data)
    }

    /// The report of what is shown, as a page of its own.
    ///
    /// # Errors
    /// When a number cannot be written as JSON.
    pub fn html(&self) -> Result<String> {
        let pictures = self.pictures();
        self.as_page(&pictures).html()
    }

    fn as_page<'a>(&'a self, pictures: &'a Pictures) -> Page<'a> {
        let diagnosis = self.step_data.scan.as_ref().map(|s| &s.diagnosis);
        Page { title: &self.title, diagnosis, report: None, pictures: Some(pictures) }
    }

    /// Both models' torque beside the measurement.
    pub fn pictures(&self) -> Pictures {
        let mut pictures = self.step.pictures.clone();
        let compared = |label: &String| Compared { label: label.clone(), held_out: true };
        pictures.models = vec![compared(&self.labels[1])];
        pictures.climb.clone_from(&self.climb);
        pictures.ranking = self.step_data.ranking.as_deref().cloned().unwrap_or_default();
        let Some(against) = &self.against else { return pictures };
        pictures.models.insert(0, compared(&self.labels[0]));
        for (trace, other) in pictures.traces.iter_mut().zip(&against.pictures.traces) {
            trace.models.splice(0..0, other.models.iter().cloned());
        }
        pictures
    }
}

/// The error of every step on the way to `id`.
fn climb(study: &Study, id: usize) -> Vec<diagnose::Step> {
    let steps = study.path(id).into_iter().filter_map(|id| study.step(id));
    steps
        .map(|step| diagnose::Step {
            effect: step.added.as_ref().map_or_else(|| work::label(step), |a| a.effect.clone()),
            joints: step.added.as_ref().map_or_else(Vec::new, |a| a.joints.clone()),
            held_out_relative_error_percent: step.numbers.held_out_percent,
            rms: step.numbers.joints.iter().map(|j| (j.name.clone(), j.held_out_rms)).collect(),
        })
        .collect()
}
