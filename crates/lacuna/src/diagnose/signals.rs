//! Choosing the signal step: what predicts held-out data best under a plain model, before physics is blamed.

use super::entry::Request;
use super::ladder::Ladder;
use crate::effects::{CoulombFriction, Effect, Joints, RigidBody, TorqueOffset, ViscousFriction};
use crate::error::Result;
use crate::identify::{Evidence, Weighting, held_out};
use crate::log::Log;
use crate::model::Model;
use crate::robot::Robot;
use crate::signals::{Folds, Mode, Run, Settings, SignalReport, VelocityFrom, prepare};

/// Cut-offs tried for positions and velocities before they are differentiated \[Hz\].
const POSITION_HZ: [f64; 9] = [4.0, 2.0, 3.0, 6.0, 8.0, 12.0, 1.5, 20.0, 30.0];
/// Cut-offs tried for the velocities of columns with a sign \[Hz\], beside that of the positions.
const FRICTION_HZ: [f64; 3] = [15.0, 40.0, 100.0];
/// Widths of the smoothed sign that the signal step may cause [rad/s]; a wider one is physics.
pub(super) const WIDTHS: [f64; 5] = [0.01, 0.002, 0.005, 0.02, 0.04];

/// The softest of them.
pub(super) const SOFTEST: f64 = 0.04;

/// Logs prepared with the settings that predict best.
pub(super) struct Chosen {
    pub settings: Settings,
    pub runs: Vec<Run>,
    pub reports: Vec<SignalReport>,
    pub folds: Folds,
    /// Width of the smoothed sign of each joint [rad/s].
    pub widths: Vec<f64>,
}

/// Logs through the signal step.
pub(super) fn prepared(logs: &[Log], settings: &Settings) -> Result<(Vec<Run>, Vec<SignalReport>)> {
    let both: Vec<_> = logs.iter().map(|log| one_prepared(log, settings)).collect::<Result<_>>()?;
    Ok(both.into_iter().unzip())
}

/// A log through the signal step; where a joint stands still its rows are left out.
pub(super) fn one_prepared(log: &Log, settings: &Settings) -> Result<(Run, SignalReport)> {
    let (run, report) = prepare(log, settings)?;
    Ok((Run { leaves_out: true, ..run }, report))
}

/// What is being chosen for.
pub(super) struct Choice<'a> {
    pub robot: &'a Robot,
    pub logs: &'a [Log],
    pub settings: Settings,
    /// Whether cut-offs and source of the velocity are chosen too, or taken from the settings.
    pub free: bool,
    pub folds: &'a dyn Fn(&[Run]) -> Result<Folds>,
    /// Whether every log has velocities, those to validate too.
    pub logged: bool,
}

impl Choice<'_> {
    /// Chooses source of the velocity, its cut-off, then cut-off and width of the sign, by held-out error.
    pub fn decide(self, say: &mut dyn FnMut(&str)) -> Result<Chosen> {
        let mut settings = Settings { mode: Mode::Parallel, ..self.settings.clone() };
        let dof = self.robot.dof();
        let usual = vec![WIDTHS[0]; dof];
        let folds = (self.folds)(&prepared(self.logs, &settings)?.0)?;
        if self.free {
            say("choosing the source and the cut-off of velocities");
            let own = [settings.velocity_from];
            let sources: &[VelocityFrom] = if self.logged && settings.velocity_from == VelocityFrom::Auto {
                &[VelocityFrom::Velocity, VelocityFrom::Position]
            } else {
                &own
            };
            let tried = |from: VelocityFrom, hz: f64| Settings {
                velocity_from: from,
                position_cutoff_hz: hz,
                ..settings.clone()
            };
            let mut best: Option<(f64, Settings)> = None;
            for &from in sources {
                for hz in POSITION_HZ {
                    let candidate = tried(from, hz);
                    let Ok((runs, _)) = prepared(self.logs, &candidate) else { continue };
                    let error: f64 = self.errors(&runs, &folds, &usual)?.iter().map(|r| libm::log(*r)).sum();
                    if best.as_ref().is_none_or(|(least, _)| error < *least) {
                        best = Some((error, candidate));
                    }
                }
            }
            if let Some((_, chosen)) = best {
                settings = chosen;
            }
        }
        say("choosing the smoothing of the sign");
        let (settings, widths) = self.sign(settings, &folds)?;
        let (runs, reports) = prepared(self.logs, &settings)?;
        Ok(Chosen { settings, runs, reports, folds, widths })
    }

    /// Cut-offs and sources of the velocity in signs. Positions may make better accelerations than logged velocities do
    /// and worse signs: their steps are small beside the motion, not beside a reversal.
    fn choices_of_sign(&self, settings: &Settings) -> Vec<Settings> {
        let mut all = vec![settings.clone()];
        if settings.friction_cutoff_hz.is_some() {
            return all;
        }
        let auto = settings.friction_velocity_from == VelocityFrom::Auto;
        let other = self.free && auto && self.logged && settings.velocity_from == VelocityFrom::Position;
        let sources = [Some(settings.friction_velocity_from), other.then_some(VelocityFrom::Velocity)];
        for friction_velocity_from in sources.into_iter().flatten() {
            for hz in FRICTION_HZ.into_iter().filter(|hz| *hz > settings.position_cutoff_hz) {
                let friction_cutoff_hz = Some(hz);
                all.push(Settings { friction_cutoff_hz, friction_velocity_from, ..settings.clone() });
            }
        }
        all
    }

    /// Cut-off of the velocity in signs, and its width joint by joint.
    fn sign(&self, settings: Settings, folds: &Folds) -> Result<(Settings, Vec<f64>)> {
        let dof = self.robot.dof();
        let mut best: Option<(f64, Settings, Vec<f64>)> = None;
        for candidate in self.choices_of_sign(&settings) {
            let Ok((runs, _)) = prepared(self.logs, &candidate) else { continue };
            let mut least = vec![(f64::INFINITY, WIDTHS[0]); dof];
            for width in WIDTHS {
                let errors = self.errors(&runs, folds, &vec![width; dof])?;
                for (least, error) in least.iter_mut().zip(errors) {
                    if error < least.0 {
                        *least = (error, width);
                    }
                }
            }
            let error: f64 = least.iter().map(|(r, _)| libm::log(*r)).sum();
            if best.as_ref().is_none_or(|(smallest, _, _)| error < *smallest) {
                best = Some((error, candidate, least.into_iter().map(|(_, w)| w).collect()));
            }
        }
        Ok(best.map_or_else(|| (settings, vec![WIDTHS[0]; dof]), |(_, s, w)| (s, w)))
    }

    /// Held-out rms of each joint under rigid body, viscous and Coulomb friction and offset.
    fn errors(&self, runs: &[Run], folds: &Folds, widths: &[f64]) -> Result<Vec<f64>> {
        let model = Model::new(self.robot, plain(self.robot, widths))?;
        let evidence = Evidence::collect(&model, runs, folds)?;
        let silent = |j: usize| runs.iter().all(|run| run.tau[j].iter().all(|x| x.abs() <= 0.0));
        let rms = held_out(&model, &evidence, Weighting::Joint)?.rms;
        Ok(rms.iter().enumerate().map(|(j, r)| if silent(j) { 1.0 } else { r.max(1e-12) }).collect())
    }
}

/// Least improvement of the mean logarithm of held-out rms for which the signal step is changed once more.
const WORTH: f64 = 0.01;

/// Looks at the cut-off of positions again with everything in the model that was found: a plain model may have
/// wanted it lower (or higher) than the physics in the data can bear. `None` when it may stay.
pub(super) fn again(
    request: &Request<'_>,
    chosen: &Chosen,
    ladder: &Ladder,
    logs: &[Log],
) -> Result<Option<Chosen>> {
    if !request.choose_signals || ladder.rungs.is_empty() {
        return Ok(None);
    }
    let error = |ladder: &Ladder| ladder.rms().iter().map(|r| libm::log(r.max(1e-12))).sum::<f64>();
    let mut order = POSITION_HZ;
    order.sort_by(f64::total_cmp);
    let now = chosen.settings.position_cutoff_hz;
    let up: Vec<f64> = order.iter().copied().filter(|hz| *hz > now).collect();
    let down: Vec<f64> = order.iter().rev().copied().filter(|hz| *hz < now).collect();
    let mut best: (f64, Option<Chosen>) = (error(ladder) - WORTH * request.robot.dof() as f64, None);
    for direction in [up, down] {
        for hz in direction {
            let settings = Settings { position_cutoff_hz: hz, ..chosen.settings.clone() };
            let (runs, reports) = prepared(logs, &settings)?;
            let there = error(&ladder.on(request.data(chosen, runs.clone())?)?);
            if there >= best.0 {
                break;
            }
            let (folds, widths) = (chosen.folds.clone(), chosen.widths.clone());
            best = (there, Some(Chosen { settings, runs, reports, folds, widths }));
        }
        if best.1.is_some() {
            break;
        }
    }
    Ok(best.1)
}

/// Rigid body, viscous and Coulomb friction and offset on every joint, with these widths of the sign.
pub(super) fn plain(robot: &Robot, widths: &[f64]) -> Vec<Box<dyn Effect>> {
    let mut effects: Vec<Box<dyn Effect>> = vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(TorqueOffset::default()),
    ];
    for (joint, &width) in robot.joints.iter().zip(widths) {
        let joints = Joints::Only(vec![joint.name.clone()]);
        effects.push(Box::new(CoulombFriction { joints, width }));
    }
    effects
}
