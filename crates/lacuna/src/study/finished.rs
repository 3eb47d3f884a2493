//! The finished model of a study that retrieved link parameters.

use crate::effects::{Effect, Joints, RigidBody, SigmoidFriction};
use crate::error::Result;
use crate::model_file::{ModelFile, ParameterValue};
use crate::report::FrictionResult;
use crate::scenario::Objective;

use super::Study;
use super::moving::FromLogs;
use super::retrieval::{FromEngines, rigid_first};
use super::statics::FromPoses;

impl Study<'_> {
    /// The chosen parameters, else the best feasible ones, with the friction that belongs to them; `None`
    /// when no engine found any.
    pub(super) fn retrieved_model(
        &self,
        engines: &FromEngines,
        moving: Option<&FromLogs>,
        poses: Option<&FromPoses>,
        friction: &[FrictionResult],
    ) -> Result<Option<ModelFile>> {
        let Some((best, candidate)) = engines.best() else { return Ok(None) };
        let chosen = engines.candidates.iter().find(|c| c.is_chosen());
        let candidate = chosen.unwrap_or(candidate);
        let how = if chosen.is_some() { "chosen among equally good ones" } else { &best.label };
        let poses = poses.filter(|_| self.scenario.objective == Objective::Coefficients);
        let identified = poses.map(|p| &p.model).or(moving.map(|m| &m.model)).map(|m| m.origin.clone());
        let from = self.scenario.retrieve_from.as_ref().map(|file| file.display().to_string());
        let from = from.or(identified).unwrap_or_default();
        let origin = format!("link parameters retrieved ({how}) from {from}");
        let (effects, others) = match moving {
            Some(moving) if friction.is_empty() || !candidate.others.is_empty() => (
                self.scenario.effects.clone(),
                fitted_friction(moving, (!candidate.others.is_empty()).then_some(&candidate.others)),
            ),
            _ => self.sigmoid_effects(friction)?,
        };
        let signals = self.scenario.signals.clone();
        Ok(Some(ModelFile::with_links(&self.robot, &candidate.links, effects, others, signals, origin)))
    }

    /// The rigid body and the friction path's sigmoids.
    #[allow(clippy::type_complexity)] // a list of effects and one of values
    fn sigmoid_effects(
        &self,
        friction: &[FrictionResult],
    ) -> Result<(Vec<Box<dyn Effect>>, Vec<ParameterValue>)> {
        let mut effects: Vec<Box<dyn Effect>> = vec![Box::new(RigidBody::default())];
        if friction.is_empty() {
            return Ok((effects, Vec::new()));
        }
        let values = |name: &str| -> Vec<f64> {
            let of =
                |f: &FrictionResult| f.parameters.iter().find(|p| p.name == name).map_or(0.0, |p| p.value);
            friction.iter().map(of).collect()
        };
        let joints = Joints::Only(friction.iter().map(|f| f.joint.clone()).collect());
        let sigmoid = SigmoidFriction { joints, phi2: values("phi2"), phi3: values("phi3") };
        let terms = sigmoid.terms(&self.robot)?;
        let others =
            terms.iter().zip(values("phi1")).map(|(term, value)| plain(&term.symbol, value, term.unit));
        let others = others.collect();
        effects.push(Box::new(sigmoid));
        Ok((effects, others))
    }
}

/// Parameters beside the rigid body's: these, or those of the fit.
fn fitted_friction(moving: &FromLogs, retrieved: Option<&Vec<f64>>) -> Vec<ParameterValue> {
    let model = &moving.fitted;
    let (order, rank) = rigid_first(model);
    let value = |(k, &c): (usize, &usize)| {
        let about = &model.columns[c].about;
        plain(&about.symbol, retrieved.map_or(moving.x[c], |values| values[k]), about.unit)
    };
    order[rank..].iter().enumerate().map(value).collect()
}

fn plain(symbol: &str, value: f64, unit: &str) -> ParameterValue {
    ParameterValue {
        symbol: symbol.to_string(),
        value,
        unit: unit.to_string(),
        standard_error: None,
        stands_for: None,
    }
}
