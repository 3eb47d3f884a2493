use std::path::PathBuf;

use lacuna::{Error, Result};

use super::Global;

/// Arguments of `lacuna check`.
#[derive(Debug, clap::Args)]
pub(super) struct Check {
    /// Scenario, robot, log, column map or model.
    file: PathBuf,
    /// Robot to check a log against.
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Log to check the robot against.
    #[arg(long, value_name = "CSV")]
    data: Option<PathBuf>,
}

impl Check {
    pub(super) fn run(self, _global: &Global) -> Result<bool> {
        Err(Error::new("not here yet").in_file(&self.file))
    }
}
