use std::path::PathBuf;

use lacuna::workbench::{Options, Workbench as Open};
use lacuna::{Error, Result};
use serde_json::json;

use super::{Global, print, print_json};

/// Flags of `lacuna workbench`.
#[derive(Debug, clap::Args)]
pub(super) struct Workbench {
    /// Scenario file (RON); or give --robot and --data; or neither, and drop files into the page.
    scenario: Option<PathBuf>,
    /// Robot file: URDF, or a Denavit-Hartenberg table in RON.
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Log to explain (CSV); repeat the flag for several.
    #[arg(long, value_name = "CSV")]
    data: Vec<PathBuf>,
    /// A log that is never fitted (CSV).
    #[arg(long, value_name = "CSV")]
    validate: Vec<PathBuf>,
    /// Column map for a log with foreign headers: a file, or the name of a shipped one.
    #[arg(long, value_name = "MAP")]
    columns: Option<PathBuf>,
    /// Gravity in the base frame [m/s²], instead of the robot file's.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    gravity: Option<String>,
    /// Port of this machine to listen on; any free one when not given.
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
}

impl Workbench {
    /// Serves the page until the process is ended.
    pub(super) fn run(self, global: &Global) -> Result<bool> {
        if self.scenario.is_some() && (self.robot.is_some() || !self.data.is_empty()) {
            return Err(Error::new("both a scenario and --robot or --data are given")
                .help("give the scenario, or --robot and --data"));
        }
        if let (Some(out), Some(resume)) = (&global.out, &global.resume)
            && out != resume
        {
            return Err(Error::new("--out and --resume name different folders")
                .help("a resumed study goes on in its own folder: leave --out away"));
        }
        let resume = global.resume.is_some();
        let named = self.scenario.is_some() || self.robot.is_some() || !self.data.is_empty();
        if resume && (named || !self.validate.is_empty()) {
            return Err(Error::new("--resume goes on with the files of the study")
                .help("leave scenario, --robot, --data and --validate away"));
        }
        let options = Options {
            scenario: self.scenario,
            robot: self.robot,
            data: self.data,
            validate: self.validate,
            columns: self.columns,
            gravity: self.gravity.as_deref().map(super::check::gravity).transpose()?,
            folder: global.resume.clone().or_else(|| global.out.clone()),
            resume,
            port: self.port,
            seed: global.seed,
        };
        let bench = Open::open(&options)?;
        let folder = bench.folder().display().to_string();
        if global.json {
            print_json(&json!({"address": bench.address(), "folder": folder}))?;
        } else {
            print(&format!("workbench  {}\n", bench.address()))?;
        }
        if !global.quiet {
            eprintln!(
                "open it in a browser of this machine; it is good for one, once.\nthe study lies in {folder}; Ctrl-C ends, \
                 --resume {folder} goes on"
            );
        }
        bench.serve()?;
        Ok(true)
    }
}
