//! What a scenario will do, and whether what it names is there.

use std::path::{Path, PathBuf};

use super::file::{Options, against, describe, open_robot};
use super::report::{Problem, Report, Section};
use crate::constraints::{self, LinkSpace};
use crate::error::{Error, Result};
use crate::identify::BaseParameters;
use crate::identify::Weighting;
use crate::log::{ColumnMap, StaticPoses};
use crate::model::Model;
use crate::robot::Robot;
use crate::scenario::{
    Choice, HoldOut, Logs, Objective, Poses, Published, PublishedFriction, Scenario, find_log, find_poses,
};
use crate::signals::{ClockChoice, VelocityFrom};
use crate::space::Parameter;
use crate::text;

/// A scenario being looked at.
struct Look<'a> {
    path: &'a Path,
    folder: PathBuf,
    options: &'a Options,
    report: &'a mut Report,
}

pub(super) fn examine(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    // Read without its own checks first, so that what it names is looked at even where these fail.
    let mut scenario: Scenario = text::from_ron(&text::read(path)?).map_err(|e| e.in_file(path))?;
    if let Err(error) = Scenario::open(path) {
        report.problems.push(Problem::new(error, true));
    }
    report.sections.push(Section::wrapped("what it will do", steps(&scenario)));
    if scenario.logs.is_some() {
        report.sections.push(Section::wrapped("signal step", signals(&scenario)));
    }
    report.next = vec![format!("lacuna scenario {}", path.display())];
    let folder = path.parent().unwrap_or(Path::new(".")).to_path_buf();
    let mut look = Look { path, folder, options, report };
    let gravity = options.gravity.or(scenario.gravity);
    let folder = look.folder.clone();
    let mut effects = std::mem::take(&mut scenario.effects);
    effects.retain_mut(|effect| look.taken(effect.load(&folder)).is_some());
    scenario.effects = effects;
    for candidate in &mut scenario.candidates {
        look.taken(candidate.load(&folder));
    }
    let robot = look.robot(&scenario, gravity);
    look.files(&scenario, robot.as_ref());
    look.constraints(&mut scenario, robot.as_ref().map(|(r, _)| r));
    if !look.report.problems.is_empty() {
        look.report.next = vec!["mend what is marked x, and check again".into()];
    }
    Ok(())
}

fn steps(scenario: &Scenario) -> Vec<String> {
    let mut lines = Vec::new();
    match &scenario.poses {
        Some(Poses::File(file)) => lines.push(format!("identify from the static poses in {}", file.display())),
        Some(Poses::ReadOut { coefficients, count, noise_percent }) => lines.push(format!(
            "read M and g out of {} at {count} random poses with {noise_percent} % noise, and identify from that",
            coefficients.display()
        )),
        None => {}
    }
    let effects: Vec<&str> = scenario.effects.iter().map(|e| e.about().name).collect();
    let weighting = match scenario.weighting {
        Weighting::Ordinary => "ordinary least squares",
        Weighting::Joint => "least squares, joints weighed by their residuals",
        Weighting::Huber => "robust least squares",
    };
    let fit = format!("fit {} ({weighting})", effects.join(" + "));
    match &scenario.logs {
        Some(Logs::Files { fit: files, validate, .. }) => {
            let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
            if !names.is_empty() {
                lines.push(format!("{fit} to {}", names.join(", ")));
                lines.push(held_out(scenario.hold_out));
            }
            lines.extend(validate.iter().map(|f| format!("predict {}, never fitted", f.display())));
        }
        Some(Logs::Simulated(s)) => {
            let physics: Vec<&str> = s.effects.iter().map(|e| e.typetag_name()).collect();
            let physics = if physics.is_empty() { "nothing".to_owned() } else { physics.join(" + ") };
            lines.push(format!("simulate {} s of motion with {physics} beside rigid links", s.duration_s));
            lines.push(format!("{fit} to that"));
            lines.push(held_out(scenario.hold_out));
        }
        None => {}
    }
    if let Some(friction) = &scenario.friction {
        let from = friction.coefficients.as_ref().map_or("the poses".into(), |c| c.display().to_string());
        lines.push(match &friction.published {
            None => format!("freeze the rigid part of {from} and fit sigmoid friction to the rest"),
            Some(file) => format!("take the friction of {} as it is", file.display()),
        });
    }
    if !scenario.engines.is_empty() {
        lines.push(retrieval(scenario));
    }
    if scenario.intervals.is_some() {
        lines
            .push("find what data and constraints leave open of masses, centres of mass and inertias".into());
    }
    lines.extend(scenario.choice.as_ref().map(|choice| match choice {
        Choice::Uniform => "among equally good answers take the one with mass spread most evenly".into(),
        Choice::Smallest => "among equally good answers take the smallest".into(),
        Choice::Nearest { prior } => {
            let prior = prior.as_ref().map_or("the robot file".into(), |file| file.display().to_string());
            format!("among equally good answers take the nearest to the inertias of {prior}")
        }
    }));
    lines.push("write report.json and model.ron; every random draw follows from its seed".into());
    lines
}

fn held_out(hold_out: HoldOut) -> String {
    match hold_out {
        HoldOut::Auto => {
            "hold out equal phases where the motion repeats, else blocks, and predict them".into()
        }
        HoldOut::SamePhase { period_s, folds } => {
            format!("hold out equal phases of a period of {period_s} s in {folds} folds, and predict them")
        }
        HoldOut::Contiguous { block_s, folds } => {
            format!("hold out blocks of {block_s} s in {folds} folds, and predict them")
        }
    }
}

fn retrieval(scenario: &Scenario) -> String {
    let engines: Vec<&str> = scenario.engines.iter().map(|e| e.label()).collect();
    let mut under: Vec<String> =
        scenario.presets.iter().map(|file| format!("those of {}", file.display())).collect();
    under.extend(scenario.constraints.iter().map(|c| c.about().name.to_string()));
    let under = if under.is_empty() { "no constraint".to_owned() } else { under.join(", ") };
    let from = scenario.retrieve_from.as_ref().map_or(String::new(), |f| format!(" from {}", f.display()));
    format!("retrieve feasible link parameters{from} with {} under {under}", engines.join(" and "))
}

fn signals(scenario: &Scenario) -> Vec<String> {
    let s = &scenario.signals;
    let velocity = match s.velocity_from {
        VelocityFrom::Auto => "velocity as logged, from position where there is none",
        VelocityFrom::Position => "velocity from position",
        VelocityFrom::Velocity => "velocity as logged",
    };
    let clock = match s.clock {
        ClockChoice::Auto => "clock rebuilt where the data prove it",
        ClockChoice::Stamps => "clock as the time stamps say",
        ClockChoice::Rebuilt => "clock rebuilt",
    };
    vec![format!(
        "mode {}, band {} Hz, Butterworth order {} both ways, {velocity}, {clock}, {} s trimmed",
        s.mode.name(),
        s.band_hz,
        s.order,
        s.trim_s
    )]
}

/// What is retrieved beside link parameters: in one step, the parameters of all other effects.
fn others(scenario: &Scenario, robot: &Robot) -> Vec<Parameter> {
    if scenario.objective == Objective::Coefficients {
        return Vec::new();
    }
    let effects = scenario.effects.iter().filter(|e| !e.is_rigid_body());
    let terms = effects.filter_map(|e| e.terms(robot).ok()).flatten();
    terms.map(|t| Parameter::free(t.symbol, t.unit)).collect()
}

impl Look<'_> {
    fn problem(&mut self, error: Error) {
        self.report.problems.push(Problem::new(error, false));
    }

    /// The value, or a problem more.
    fn taken<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|e| self.problem(text::placed(e, self.path))).ok()
    }

    fn robot(&mut self, scenario: &Scenario, gravity: Option<[f64; 3]>) -> Option<(Robot, Option<Robot>)> {
        let opened = open_robot(&self.folder.join(&scenario.robot), gravity);
        let pair = self.taken(opened)?;
        describe(&pair.0, self.report);
        let model = Model::new(&pair.0, scenario.effects.clone());
        self.taken(model.map_err(|e| text::placed(e, self.path)));
        Some(pair)
    }

    fn files(&mut self, scenario: &Scenario, robot: Option<&(Robot, Option<Robot>)>) {
        let mut coefficients = Vec::new();
        match &scenario.poses {
            Some(Poses::File(file)) => {
                let path = find_poses(&self.folder, file).map_err(|e| text::placed(e, self.path));
                let path = self.taken(path);
                if let (Some(path), Some((robot, _))) = (path, robot) {
                    let opened = StaticPoses::open(&path, robot);
                    self.taken(opened);
                }
            }
            Some(Poses::ReadOut { coefficients: file, .. }) => coefficients.push(file),
            None => {}
        }
        coefficients.extend(scenario.friction.iter().filter_map(|f| f.coefficients.as_ref()));
        coefficients.extend(&scenario.retrieve_from);
        let published = scenario.friction.as_ref().and_then(|f| f.published.as_ref());
        if let (Some(file), Some((robot, _))) = (published, robot) {
            let path = self.folder.join(file);
            let opened = PublishedFriction::open(&path);
            let opened = opened.and_then(|f| f.parameters(robot.dof()).map_err(|e| e.in_file(&path)));
            self.taken(opened);
        }
        let prior = match &scenario.choice {
            Some(Choice::Nearest { prior }) => prior.as_ref(),
            _ => None,
        };
        for (file, (robot, _)) in prior.into_iter().chain(&scenario.beside).zip(robot.into_iter().cycle()) {
            let path = self.folder.join(file);
            let prior = Robot::open(&path).and_then(|p| p.prior_for(robot).map_err(|e| e.in_file(&path)));
            self.taken(prior);
        }
        coefficients.dedup();
        for file in coefficients {
            self.coefficients(&self.folder.join(file), robot.map(|(r, _)| r));
        }
        self.logs(scenario, robot);
    }

    fn logs(&mut self, scenario: &Scenario, robot: Option<&(Robot, Option<Robot>)>) {
        match &scenario.logs {
            Some(Logs::Files { fit, validate, columns, missing }) => {
                let map = columns.as_ref().map(|c| ColumnMap::open(self.folder.join(c)));
                let map = match map.map(|m| self.taken(m)) {
                    Some(None) => return,
                    Some(Some(map)) => Some(map),
                    None => None,
                };
                if let Some(given) = &self.options.data {
                    self.log(given, map.as_ref(), robot);
                    return;
                }
                for file in fit.iter().chain(validate) {
                    let found = find_log(&self.folder, file, missing.as_deref());
                    if let Some(path) = self.taken(found.map_err(|e| text::placed(e, self.path))) {
                        self.log(&path, map.as_ref(), robot);
                    }
                }
            }
            Some(Logs::Simulated(simulated)) => {
                if let Some((robot, _)) = robot {
                    let checked = simulated.effects.iter().try_for_each(|e| e.check(robot.dof()));
                    self.taken(checked);
                    let checked = simulated.sensors.check(robot.dof());
                    self.taken(checked);
                    let checked = simulated.controller.check(robot.dof());
                    self.taken(checked);
                }
            }
            None => {}
        }
    }

    /// Every constraint on its own, so that one that is wrong does not hide the next.
    fn constraints(&mut self, scenario: &mut Scenario, robot: Option<&Robot>) {
        let folder = self.folder.clone();
        let mut all = std::mem::take(&mut scenario.constraints);
        all.retain_mut(|constraint| self.taken(constraint.load(&folder)).is_some());
        for preset in &scenario.presets {
            let opened = constraints::open(&folder.join(preset));
            all.extend(self.taken(opened).into_iter().flatten());
        }
        let Some(robot) = robot else { return };
        let space = LinkSpace::new(robot, &others(scenario, robot));
        let mut conditions = Vec::new();
        for constraint in &all {
            let name = constraint.about().name;
            let lowered = constraint.forms(robot, &space).map_err(|e| e.within(name));
            if let Some(forms) = self.taken(lowered) {
                let general = forms.iter().filter(|f| !f.is_convex()).count();
                let left_out =
                    if general == 0 { String::new() } else { format!(", {general} of them not for `lmi`") };
                let s = if forms.len() == 1 { "" } else { "s" };
                conditions.push(format!("{name}: {} condition{s}{left_out}", forms.len()));
            }
        }
        self.report.sections.push(Section::wrapped("what link parameters must satisfy", conditions));
    }

    fn log(&mut self, path: &Path, map: Option<&ColumnMap>, robot: Option<&(Robot, Option<Robot>)>) {
        let Some((robot, other)) = robot else { return };
        let next = self.report.next.clone();
        let checked = against(robot, other.as_ref(), path, map, self.report);
        self.taken(checked);
        self.report.next = next;
    }

    fn coefficients(&mut self, path: &Path, robot: Option<&Robot>) {
        let Some(published) = self.taken(Published::open(path)) else { return };
        let Some(robot) = robot else { return };
        let values = published.values(&BaseParameters::new(robot)).map_err(|e| e.in_file(path));
        self.taken(values);
    }
}
