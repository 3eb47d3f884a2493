//! Makes one data set, asks what is missing, and judges the answer.

use serde::{Deserialize, Serialize};

use super::judge::{self, Mark, Unseen};
use super::plan::Item;
use crate::diagnose::{Limits, Request, Start, diagnose, unseen_error};
use crate::error::{Error, Result};
use crate::log::Log;
use crate::scenario::HoldOut;
use crate::signals::{Run, Settings};
use crate::simulate::hidden::{Draw, Hidden, hidden};

/// One data set with the answer to it.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct Examination {
    /// Part of the examination.
    pub part: String,
    /// Place in it.
    pub number: usize,
    /// Seed of the data.
    pub seed: u64,
    /// What was to be hidden.
    pub wanted: Vec<String>,
    /// Why there is no data set, where it could not be made.
    pub excluded: Option<String>,
    /// What the answer was worth.
    pub mark: Option<Mark>,
}

/// Makes the data set of `item`, diagnoses it as `lacuna diagnose --auto --validate` would, and judges the answer.
///
/// # Errors
/// When simulation or diagnosis fails.
pub fn examine(item: &Item) -> Result<Examination> {
    let wanted = item.choices.iter().map(|c| format!("{} on joint{}", c.family.name, c.joint + 1)).collect();
    let mut result = Examination {
        part: item.part.name().to_string(),
        number: item.number,
        seed: item.seed,
        wanted,
        excluded: None,
        mark: None,
    };
    match hidden(&item.choices, item.seed)? {
        Draw::Excluded(reason) => result.excluded = Some(reason),
        Draw::Data(data) => result.mark = Some(marked(&data, item)?),
    }
    Ok(result)
}

fn marked(data: &Hidden, item: &Item) -> Result<Mark> {
    let request = |logs: &[Log], unseen: &Log| Request {
        robot: &data.robot,
        logs: logs.to_vec(),
        reference: data.reference.clone(),
        validate: vec![unseen.clone()],
        start: Start::Effects(data.baseline.clone()),
        settings: Settings::for_diagnosis(),
        choose_signals: true,
        folds: &|runs: &[Run]| HoldOut::Auto.folds(runs),
        add: Vec::new(),
        auto: true,
        nested: None,
        extra: Vec::new(),
        limits: Limits::default(),
        seed: item.seed,
    };
    let outcome = diagnose(request(&data.fit, &data.unseen), &mut |_| {})?;
    let without = unseen_error(&request(&data.fit_without, &data.unseen_without))?;
    let validation = outcome.diagnosis.validation.as_ref();
    let rms = validation.map(|v| &v.rms).ok_or_else(|| Error::new("no validation"))?;
    let side = |which: usize| -> Vec<f64> {
        data.robot.joints.iter().map(|j| rms.get(&j.name).map_or(f64::NAN, |r| r[which])).collect()
    };
    let (before, after) = (side(0), side(1));
    let unseen = Unseen { before: &before, after: &after, without: &without };
    Ok(judge::judge(&outcome.diagnosis, &data.secrets, &data.robot, &unseen, &judge::rules()?))
}
