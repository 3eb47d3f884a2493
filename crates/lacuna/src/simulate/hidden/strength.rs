//! How strong a hidden effect is for whoever looks for it.

use rayon::prelude::*;

use super::{Family, Scope};
use crate::effects::Effect;
use crate::error::{Error, Result};
use crate::excitation::{FourierMotion, Ramped};
use crate::identify::{Evidence, Weighting, fit, fit_with_weights};
use crate::log::Log;
use crate::model::Model;
use crate::plant::{Plant, PlantEffect};
use crate::signals::{Folds, Run, Settings, prepare};

/// Strengths are measured when they are this large at least, so that noise does not blur them.
const CLEAR: f64 = 4.0;
/// Strength that a second look aims at.
const AIM: f64 = 8.0;
/// Looks at most.
const LOOKS: usize = 4;

/// Measures what the baseline leaves of an effect on the motions that will be fitted, with the same noise each time.
pub(super) struct Yardstick<'a> {
    pub(super) plant: &'a Plant,
    model: Model,
    /// Motions, each with the seed of its noise.
    motions: Vec<(Ramped<FourierMotion>, u64)>,
    /// Residual of the baseline with nothing hidden [N m].
    pub(super) noise: Vec<f64>,
    /// Logs of the motions with nothing hidden, and their runs.
    pub(super) logs: Vec<Log>,
    runs: Vec<Run>,
}

impl<'a> Yardstick<'a> {
    pub(super) fn new(
        plant: &'a Plant,
        baseline: &[Box<dyn Effect>],
        motions: Vec<(Ramped<FourierMotion>, u64)>,
    ) -> Result<Self> {
        let model = Model::new(&plant.robot, baseline.to_vec())?;
        let (noise, logs, runs) = (Vec::new(), Vec::new(), Vec::new());
        let mut yardstick = Self { plant, model, motions, noise, logs, runs };
        (yardstick.logs, yardstick.runs) = yardstick.simulated(&[])?.into_iter().unzip();
        yardstick.noise = yardstick.residual(yardstick.runs.clone())?;
        Ok(yardstick)
    }

    /// Size at which `effects` of `family` on `joint` have this strength.
    pub(super) fn size(
        &self,
        family: &Family,
        effects: impl Fn(f64) -> Vec<Box<dyn PlantEffect>>,
        joint: usize,
        strength: f64,
    ) -> Result<f64> {
        // Where two states are compared, the first one pins down what is known of the robot.
        let two = family.scope == Scope::TwoLogs;
        let reference: &[Run] = if two { &self.runs } else { &[] };
        let mut size = family.unit;
        for look in 0..LOOKS {
            let mut runs: Vec<Run> =
                self.simulated(&effects(size))?.into_iter().map(|(_, run)| run).collect();
            runs.extend_from_slice(reference);
            let residual = self.residual(runs)?;
            let of = |j: usize| (residual[j].powi(2) / self.noise[j].powi(2) - 1.0).max(0.0).sqrt();
            let seen = match family.scope {
                Scope::Joint => of(joint),
                _ => (0..residual.len()).map(of).fold(0.0, f64::max),
            };
            if (CLEAR..=3.0 * AIM).contains(&seen) || look + 1 == LOOKS {
                return Ok(if seen > 0.0 { size * strength / seen } else { f64::INFINITY });
            }
            // What cannot be seen at all is looked at ten times larger.
            size *= (AIM / seen.max(0.1 * AIM)).clamp(0.02, 10.0);
        }
        Err(Error::new("no look was taken at the effect"))
    }

    /// The plant along all motions, through the signal step.
    fn simulated(&self, effects: &[Box<dyn PlantEffect>]) -> Result<Vec<(Log, Run)>> {
        let settings = Settings::for_diagnosis();
        let run = |(motion, seed): &(Ramped<FourierMotion>, u64)| {
            let log = self.plant.simulate_with(effects, motion, motion.total_s(), *seed)?.log;
            let run = prepare(&log, &settings)?.0;
            Ok((log, run))
        };
        self.motions.par_iter().map(run).collect()
    }

    /// Residual rms of the baseline by joint, in its band [N m].
    fn residual(&self, runs: Vec<Run>) -> Result<Vec<f64>> {
        let folds = Folds::choose(&runs.iter().collect::<Vec<_>>())?;
        let evidence = Evidence::collect(&self.model, &runs, &folds)?;
        if self.noise.is_empty() {
            return Ok(fit(&self.model, &evidence, None, Weighting::Joint)?.errors.rms);
        }
        // Weights of the noise, whatever is hidden: what a fit leaves of an effect is then in proportion to its size.
        let weights: Vec<f64> = self.noise.iter().map(|noise| 1.0 / noise).collect();
        Ok(fit_with_weights(&self.model, &evidence, &weights)?.errors.rms)
    }
}
