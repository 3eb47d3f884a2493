//! Where the measurements are that a scenario names.

use std::path::{Path, PathBuf};

use crate::error::{Error, Result};

/// Beside the scenario, which is in `folder`, or in the folder that `LACUNA_DATA` names.
fn find(folder: &Path, file: &Path) -> Option<PathBuf> {
    let in_data = || std::env::var_os("LACUNA_DATA").map(|d| Path::new(&d).join(file));
    [Some(folder.join(file)), in_data()].into_iter().flatten().find(|p| p.is_file())
}

/// Where a log is that a scenario in `folder` names: beside the scenario, or in the folder that `LACUNA_DATA` names.
///
/// # Errors
/// When it is not there; `missing` is what the scenario says of where to get it.
pub fn find_log(folder: &Path, file: &Path, missing: Option<&str>) -> Result<PathBuf> {
    find(folder, file).ok_or_else(|| {
        let otherwise =
            "put it beside the scenario, or into the folder that LACUNA_DATA names, or give --data LOG.csv";
        let help = missing.map_or_else(|| otherwise.to_string(), |m| format!("{m}\n  {otherwise}"));
        Error::new(format!("there is no log `{}`", file.display())).help(help)
    })
}

/// Where static poses are that a scenario in `folder` names, looked for like logs.
///
/// # Errors
/// When they are not there.
pub fn find_poses(folder: &Path, file: &Path) -> Result<PathBuf> {
    find(folder, file).ok_or_else(|| {
        Error::new(format!("there is no file of static poses `{}`", file.display()))
            .help("put it beside the scenario, or into the folder that LACUNA_DATA names")
    })
}
