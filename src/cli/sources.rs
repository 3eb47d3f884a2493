use std::path::PathBuf;

/// Where a study comes from: flags that several commands share.
#[derive(Debug, Clone, clap::Args)]
pub(super) struct Sources {
    /// Scenario file (RON); or give --robot and --data.
    pub scenario: Option<PathBuf>,
    /// Robot file: URDF, or a Denavit-Hartenberg table in RON.
    #[arg(long, value_name = "FILE")]
    pub robot: Option<PathBuf>,
    /// Log to explain (CSV); repeat the flag for several.
    #[arg(long, value_name = "CSV")]
    pub data: Vec<PathBuf>,
    /// A log that is never fitted (CSV).
    #[arg(long, value_name = "CSV")]
    pub validate: Vec<PathBuf>,
    /// Column map for a log with foreign headers: a file, or the name of a shipped one.
    #[arg(long, value_name = "MAP")]
    pub columns: Option<PathBuf>,
    /// Gravity in the base frame [m/s²], instead of the robot file's.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    pub gravity: Option<String>,
}
