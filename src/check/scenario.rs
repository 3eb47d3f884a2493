//! What a scenario will do, and whether what it names is there.

use std::path::{Path, PathBuf};

use super::file::{Options, against, describe, open_robot};
use super::report::{Problem, Report, Section};
use crate::error::{Error, Result};
use crate::identify::BaseParameters;
use crate::log::{ColumnMap, StaticPoses};
use crate::robot::Robot;
use crate::scenario::{Logs, Poses, Published, PublishedFriction, Scenario};
use crate::text;

/// A scenario being looked at.
struct Look<'a> {
    folder: PathBuf,
    options: &'a Options,
    report: &'a mut Report,
}

pub(super) fn examine(path: &Path, options: &Options, report: &mut Report) -> Result<()> {
    // Read without its own checks first, so that what it names is looked at even where these fail.
    let scenario: Scenario = text::from_ron(&text::read(path)?).map_err(|e| e.in_file(path))?;
    if let Err(error) = Scenario::open(path) {
        report.problems.push(Problem::new(error, true));
    }
    report.sections.push(Section::wrapped("what it will do", steps(&scenario)));
    report.sections.push(Section::wrapped("signal step", signals(&scenario)));
    report.next = vec![format!("lacuna scenario {}", path.display())];
    let folder = path.parent().unwrap_or(Path::new(".")).to_path_buf();
    let mut look = Look { folder, options, report };
    let gravity = options.gravity.or(scenario.gravity);
    let robot = look.robot(&scenario, gravity);
    look.files(&scenario, robot.as_ref());
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
    let fit = format!("fit {} ({:?} least squares)", effects.join(" + "), scenario.weighting);
    match &scenario.logs {
        Some(Logs::Files { fit: files, validate, .. }) => {
            let names: Vec<String> = files.iter().map(|f| f.display().to_string()).collect();
            if !names.is_empty() {
                lines.push(format!("{fit} to {}", names.join(", ")));
                lines.push(format!("hold rows out: {:?}", scenario.hold_out));
            }
            lines.extend(validate.iter().map(|f| format!("predict {}, never fitted", f.display())));
        }
        Some(Logs::Simulated(s)) => {
            let physics = s.effects.len();
            lines.push(format!(
                "simulate {} s of motion with {physics} effects beside rigid links",
                s.duration_s
            ));
            lines.push(format!("{fit} to that; hold rows out: {:?}", scenario.hold_out));
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
    lines.push("write report.json and model.ron; every random draw follows from its seed".into());
    lines
}

fn signals(scenario: &Scenario) -> Vec<String> {
    let s = &scenario.signals;
    vec![format!(
        "mode {}, band {} Hz, Butterworth order {} both ways, velocity {:?}, clock {:?}, {} s trimmed",
        s.mode.name(),
        s.band_hz,
        s.order,
        s.velocity_from,
        s.clock,
        s.trim_s
    )]
}

impl Look<'_> {
    fn problem(&mut self, error: Error) {
        self.report.problems.push(Problem::new(error, false));
    }

    /// The value, or a problem more.
    fn taken<T>(&mut self, result: Result<T>) -> Option<T> {
        result.map_err(|e| self.problem(e)).ok()
    }

    fn robot(&mut self, scenario: &Scenario, gravity: Option<[f64; 3]>) -> Option<(Robot, Option<Robot>)> {
        let opened = open_robot(&self.folder.join(&scenario.robot), gravity);
        let pair = self.taken(opened)?;
        describe(&pair.0, self.report);
        for effect in &scenario.effects {
            if let Err(error) = effect.terms(&pair.0) {
                self.problem(error);
            }
        }
        Some(pair)
    }

    fn files(&mut self, scenario: &Scenario, robot: Option<&(Robot, Option<Robot>)>) {
        let mut coefficients = Vec::new();
        match &scenario.poses {
            Some(Poses::File(file)) => {
                if let (Some(path), Some((robot, _))) = (self.find(file, None), robot) {
                    let opened = StaticPoses::open(&path, robot);
                    self.taken(opened);
                }
            }
            Some(Poses::ReadOut { coefficients: file, .. }) => coefficients.push(file),
            None => {}
        }
        coefficients.extend(scenario.friction.iter().filter_map(|f| f.coefficients.as_ref()));
        let published = scenario.friction.as_ref().and_then(|f| f.published.as_ref());
        if let (Some(file), Some((robot, _))) = (published, robot) {
            let path = self.folder.join(file);
            let opened = PublishedFriction::open(&path);
            let opened = opened.and_then(|f| f.parameters(robot.dof()).map_err(|e| e.in_file(&path)));
            self.taken(opened);
        }
        coefficients.dedup();
        for file in coefficients {
            self.coefficients(&self.folder.join(file), robot.map(|(r, _)| r));
        }
        match &scenario.logs {
            Some(Logs::Files { fit, validate, columns, missing }) => {
                let map = columns.as_ref().map(|c| ColumnMap::open(self.folder.join(c)));
                let map = match map.map(|m| self.taken(m)) {
                    Some(None) => return,
                    Some(Some(map)) => Some(map),
                    None => None,
                };
                let given: Vec<PathBuf> = self.options.data.iter().cloned().collect();
                let files = if given.is_empty() {
                    fit.iter().chain(validate).collect()
                } else {
                    given.iter().collect::<Vec<_>>()
                };
                for file in files {
                    self.log(file, map.as_ref(), missing.as_deref(), robot);
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

    fn log(
        &mut self,
        file: &Path,
        map: Option<&ColumnMap>,
        missing: Option<&str>,
        robot: Option<&(Robot, Option<Robot>)>,
    ) {
        let (Some(path), Some((robot, other))) = (self.find(file, missing), robot) else { return };
        let next = self.report.next.clone();
        let checked = against(robot, other.as_ref(), &path, map, self.report);
        self.taken(checked);
        self.report.next = next;
    }

    fn coefficients(&mut self, path: &Path, robot: Option<&Robot>) {
        let Some(published) = self.taken(Published::open(path)) else { return };
        let Some(robot) = robot else { return };
        let values = published.values(&BaseParameters::new(robot)).map_err(|e| e.in_file(path));
        self.taken(values);
    }

    /// A file beside the scenario, in `LACUNA_DATA`, or as it is named.
    fn find(&mut self, file: &Path, missing: Option<&str>) -> Option<PathBuf> {
        let in_data = || std::env::var_os("LACUNA_DATA").map(|d| Path::new(&d).join(file));
        let places = [Some(self.folder.join(file)), in_data(), Some(file.to_path_buf())];
        let found = places.into_iter().flatten().find(|p| p.is_file());
        if found.is_none() {
            let otherwise = "put it beside the scenario or into the folder that LACUNA_DATA names";
            let help = missing.map_or_else(|| otherwise.to_string(), |m| format!("{m}\n  {otherwise}"));
            self.problem(Error::new("the file is not there").in_file(file).help(help));
        }
        found
    }
}
