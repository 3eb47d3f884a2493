//! What a script of an effect says, and what it makes of a log.

use std::path::Path;

use super::file::{Options, open_robot};
use super::report::{Report, Section, number};
use crate::effects::{Effect, Joints, ScriptedEffect, classic};
use crate::error::Result;
use crate::identify::{Fit, Weighting, fit, held_out, settle, with_robust_sd};
use crate::log::{ColumnMap, Log};
use crate::model::Model;
use crate::robot::Robot;
use crate::script::{EffectScript, Setting};
use crate::signals::{Folds, Run, Settings, prepare};
use crate::stop::Stop;

pub(super) fn examine(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    let effect = ScriptedEffect::open(path, Joints::All)?;
    report.sections.push(Section::wrapped("what it says", words(effect.script()?)));
    report.sections.push(Section::wrapped("what is fitted", parameters(effect.script()?)));
    let Some(robot) = &options.robot else {
        report.remarks.push("read, but `columns` was not run: joints are those of a robot".into());
        report.next =
            vec![format!("lacuna check {} --robot ROBOT --data LOG.csv", path.display()), "tries it".into()];
        return Ok(());
    };
    let robot = open_robot(robot, options.gravity)?.0;
    let lowered = effect.lowered(&robot, &options.stop)?;
    let joints = lowered.joints.len();
    report.sections.push(Section::wrapped(
        "on the robot",
        vec![format!(
            "{joints} joints, {} parameters; `columns` ran for each joint",
            effect.terms(&robot)?.len()
        )],
    ));
    let Some(data) = &options.data else {
        report.next = vec![format!("the same with --data LOG.csv: tries it on a log of `{}`", robot.name)];
        return Ok(());
    };
    let map = options.columns.as_ref().map(ColumnMap::open).transpose()?;
    let log = Log::open(data, &robot, map.as_ref())?;
    report.sections.push(on_log(&effect, &robot, &log, &options.stop)?);
    report.next = vec![
        format!("in a scenario: effects: [.., {{\"script\": (path: \"{}\")}}]", path.display()),
        "with the path from there, and `joints: Only([..])`, `with: {..}` as needed".into(),
    ];
    Ok(())
}

fn words(script: &EffectScript) -> Vec<String> {
    let about = script.about();
    let mut lines = vec![about.title.clone(), about.text.clone(), format!("equation: {}", about.equation)];
    if !about.confused_with.is_empty() {
        lines.push(format!("easily mistaken for {}", about.confused_with));
    }
    let setting = |(name, value): (&String, &Setting)| format!("{name} = {value}");
    let settings: Vec<String> = script.settings().iter().map(setting).collect();
    if !settings.is_empty() {
        lines.push(format!("settings: {}", settings.join("; ")));
    }
    lines
}

fn parameters(script: &EffectScript) -> Vec<String> {
    let about = script.about();
    let mut lines = Vec::new();
    for p in &about.parameters {
        let limits = match (p.min.is_finite(), p.max.is_finite()) {
            (true, true) => format!(", {} to {}", p.min, p.max),
            (true, false) => format!(", at least {}", p.min),
            (false, true) => format!(", at most {}", p.max),
            (false, false) => String::new(),
        };
        let whose = if p.common { "one for all joints" } else { "one per joint" };
        lines.push(format!("{} [{}]: {}; {whose}{limits}", p.symbol, p.unit, p.meaning));
    }
    for s in &about.shapes {
        lines.push(format!(
            "{} [{}]: {}; shape, {} unless fitted, {} to {}",
            s.symbol, s.unit, s.meaning, s.value, s.min, s.max
        ));
    }
    let memory: Vec<String> =
        about.memory.iter().map(|(name, first)| format!("{name} from {first}")).collect();
    if !memory.is_empty() {
        lines.push(format!("remembers {}", memory.join(", ")));
    }
    lines
}

/// Classical model with and without the effect, fitted and held out.
fn on_log(effect: &ScriptedEffect, robot: &Robot, log: &Log, stop: &Stop) -> Result<Section> {
    let run = Run { stop: stop.clone(), ..prepare(log, &Settings::default())?.0 };
    let title = format!("tried on {}", log.name);
    let mut runs = [run];
    if let Some(lacking) = effect.undecidable(robot, &runs) {
        return Ok(Section::wrapped(title, vec![format!("cannot be tried: {lacking}")]));
    }
    let folds = Folds::choose(&[&runs[0]])?;
    let mut effects = classic();
    let (_, before) = fitted(&Model::new(robot, effects.clone())?, &mut runs, &folds)?;
    effects.push(effect.boxed());
    let model = Model::new(robot, effects)?;
    let (found, after) = fitted(&model, &mut runs, &folds)?;
    let mut lines = vec![
        format!(
            "held-out relative error {} % with rigid body, viscous and Coulomb friction and offset, {} % with the \
             effect on every joint",
            number(before, 4),
            number(after, 4)
        ),
        format!("({}, ordinary least squares, 5 Hz, inputs filtered)", folds.description),
    ];
    let last = model.effects.len() - 1;
    let mut values = Vec::new();
    for (i, column) in model.columns.iter().enumerate().filter(|(_, c)| c.effect == last) {
        let (value, sd) = (found.x[i], found.robust_sd[i]);
        values.push(value);
        let idle = if found.unexcited.contains(&i) { "; this motion does not show it" } else { "" };
        lines.push(format!(
            "{} = {} +- {} {}{idle}",
            column.about.symbol,
            number(value, 4),
            number(sd, 2),
            column.about.unit
        ));
    }
    lines.extend(effect.implausible(robot, &values).map(|why| format!("no physics: {why}")));
    Ok(Section::wrapped(title, lines))
}

/// The fit, and the held-out relative error [%].
fn fitted(model: &Model, runs: &mut [Run], folds: &Folds) -> Result<(Fit, f64)> {
    let settled = settle(model, runs, folds, Weighting::Ordinary)?;
    let found = fit(model, &settled.evidence, None, Weighting::Ordinary)?;
    let found = with_robust_sd(model, runs, &settled.evidence, found)?;
    Ok((found, held_out(model, &settled.evidence, Weighting::Ordinary)?.pooled_percent))
}
