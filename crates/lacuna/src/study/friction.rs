//! The friction path: the rigid part frozen, the sigmoid of eq. 25 fitted to what is left.

use rayon::prelude::*;

use crate::effects::{RigidBody, SigmoidFriction, SigmoidParameters};
use crate::error::Result;
use crate::identify::{STEEPEST, SigmoidFit, fit_sigmoid};
use crate::model::Model;
use crate::predict::predict;
use crate::report::{FrictionResult, NamedValue};
use crate::robot::JointKind;
use crate::scenario::PublishedFriction;
use crate::signals::Run;

use super::statics::FromPoses;
use super::{Study, published};

impl Study<'_> {
    pub(super) fn friction_path(
        &mut self,
        runs: &[Run],
        poses: Option<&FromPoses>,
    ) -> Result<Vec<FrictionResult>> {
        let Some(path) = &self.scenario.friction else { return Ok(Vec::new()) };
        let (file, search) = (path.coefficients.clone(), path.search);
        let given = self.published_friction()?;
        let rigid = Model::new(&self.robot, vec![Box::new(RigidBody::default())])?;
        let base = crate::identify::BaseParameters::new(&self.robot);
        let x = match (&file, poses) {
            (Some(file), _) => published(&self.folder, file, &base)?.1,
            (None, Some(poses)) => poses.coefficients.clone(),
            (None, None) => return Ok(Vec::new()),
        };
        self.say("sigmoid friction joint by joint");
        let prediction = predict(&rigid, runs, &x)?;
        let joints: Vec<usize> =
            (0..self.robot.dof()).filter(|&j| self.robot.joints[j].kind == JointKind::Revolute).collect();
        let results: Vec<FrictionResult> = joints
            .into_par_iter()
            .map(|j| {
                let (mut velocity, mut rest) = (Vec::new(), Vec::new());
                for (run, predicted) in runs.iter().zip(&prediction) {
                    velocity.extend_from_slice(&run.to_rows(&run.dq[j]));
                    let measured = run.to_rows(&run.tau[j]);
                    rest.extend(measured.iter().zip(&predicted[j]).map(|(m, p)| m - p));
                }
                let fit = match &given {
                    Some(all) => SigmoidFit::of(all[j], &velocity, &rest),
                    None => fit_sigmoid(&velocity, &rest, search),
                };
                let named = |name: &str, value: f64, unit: &str| NamedValue {
                    name: name.to_string(),
                    value,
                    unit: unit.to_string(),
                };
                FrictionResult {
                    joint: self.robot.joints[j].name.clone(),
                    effect: SigmoidFriction::ABOUT.name.to_string(),
                    parameters: vec![
                        named("phi1", fit.parameters.phi1, "N m"),
                        named("phi2", fit.parameters.phi2, "s/rad"),
                        named("phi3", fit.parameters.phi3, "rad/s"),
                    ],
                    rms: [fit.rms_without, fit.rms_with],
                }
            })
            .collect();
        for result in results.iter().filter(|r| r.parameters[1].value > 0.99 * STEEPEST) {
            self.warn(format!(
                "friction of {} is as steep as the search allows: a jump at standstill; its phi2 is no measurement",
                result.joint
            ));
        }
        Ok(results)
    }

    /// Friction parameters that the scenario takes as they are.
    fn published_friction(&self) -> Result<Option<Vec<SigmoidParameters>>> {
        let Some(file) = self.scenario.friction.as_ref().and_then(|f| f.published.as_ref()) else {
            return Ok(None);
        };
        let path = self.folder.join(file);
        let parameters = PublishedFriction::open(&path)?.parameters(self.robot.dof());
        parameters.map(Some).map_err(|e| e.in_file(&path))
    }
}
