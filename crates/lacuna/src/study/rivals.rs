//! Sets of parameters that were not retrieved here and stand beside those that were: the inertias of the robot
//! file, and of other files of the same robot.

use std::collections::BTreeSet;

use crate::constraints::LinkSpace;
use crate::error::{Error, Result};
use crate::robot::Robot;
use crate::text;

use super::Study;
use super::retrieval::{CHOSEN, GIVEN};

/// Parameters with the name of their rows.
pub(super) struct Rival {
    pub label: String,
    pub status: String,
    pub z: Vec<f64>,
}

impl Study<'_> {
    /// The robot file's own inertias, where it has all, then those of the files that the scenario names; none
    /// where more than links is retrieved, for files of robots say nothing about that.
    pub(super) fn rivals(&self, space: &LinkSpace, taken: &BTreeSet<String>) -> Result<Vec<Rival>> {
        let alone = space.space.len() == 10 * space.links;
        if !alone && !self.scenario.beside.is_empty() {
            return Err(Error::new(
                "`beside` has nothing to compare: friction is retrieved along with links",
            )
            .help("leave it out, or use `objective: Coefficients`"));
        }
        let own = self.robot.inertial_parameters().ok().filter(|_| alone).map(|z| Rival {
            label: GIVEN.to_string(),
            status: "not retrieved: the inertias of the robot file".to_string(),
            z,
        });
        let mut rivals: Vec<Rival> = own.into_iter().collect();
        let mut labels = taken.clone();
        for file in &self.scenario.beside {
            let path = self.folder.join(file);
            let robot = Robot::open(&path)?;
            let label = robot.name.clone();
            if [GIVEN, CHOSEN].contains(&label.as_str()) || !labels.insert(label.clone()) {
                return Err(Error::new(format!("`{label}` would name two rows of the comparison"))
                    .in_file(&path)
                    .help("give the robot in this file another name, or the engine another `label`"));
            }
            let z = robot.prior_for(&self.robot).map_err(|e| text::placed(e, &path))?;
            let status = format!("not retrieved: the inertias of {}", file.display());
            rivals.push(Rival { label, status, z });
        }
        Ok(rivals)
    }
}
