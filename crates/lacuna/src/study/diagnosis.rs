//! What is missing beside the scenario's effects: the same diagnosis as of the scenario alone.

use super::Study;
use crate::diagnose::{Diagnosis, Limits, Request, Start, diagnose};
use crate::error::{Error, Result};
use crate::log::Log;
use crate::scenario::{HoldOut, Scenario};
use crate::signals::{Mode, Run};

/// Logs that were fitted, and logs that were only predicted.
pub(super) type Logs = (Vec<Log>, Vec<Log>);

impl Study<'_> {
    /// Diagnoses the logs where the scenario asks for it.
    pub(super) fn diagnosis(&mut self, logs: Option<Logs>) -> Result<Option<Diagnosis>> {
        if !self.scenario.diagnosis {
            return Ok(None);
        }
        let (logs, validate) = logs.filter(|(fitted, _)| !fitted.is_empty()).ok_or_else(|| {
            Error::new("there is no log to diagnose")
                .help("give the scenario `logs`, or leave `diagnosis` out")
        })?;
        let Scenario { effects, candidates, signals, hold_out, .. } = &self.scenario;
        let hold_out: HoldOut = *hold_out;
        let folds = |runs: &[Run]| hold_out.folds(runs);
        let request = Request {
            robot: &self.robot,
            logs,
            reference: Vec::new(),
            validate,
            start: Start::Effects(effects.clone()),
            settings: signals.clone().in_parallel(),
            choose_signals: signals.mode != Mode::Parallel,
            folds: &folds,
            add: Vec::new(),
            auto: false,
            nested: None,
            extra: candidates.clone(),
            limits: Limits::default(),
            seed: self.seed,
        };
        let mut diagnosis = diagnose(request, &mut *self.progress)?.diagnosis;
        // The clock has one place in a report.
        diagnosis.timing.clear();
        Ok(Some(diagnosis))
    }
}
