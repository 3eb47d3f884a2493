use std::path::PathBuf;

use lacuna::check::{self, Kind, Options};
use lacuna::{Error, Result};

use super::{Global, print, print_json};

/// Arguments of `lacuna check`.
#[derive(Debug, clap::Args)]
#[command(after_help = kinds())]
pub(super) struct Check {
    /// The file; what it is follows from its name and content.
    file: PathBuf,
    /// Robot to check a log or a script against.
    #[arg(long, value_name = "FILE")]
    robot: Option<PathBuf>,
    /// Log to check the robot against, or to try an effect script on.
    #[arg(long, value_name = "CSV")]
    data: Option<PathBuf>,
    /// Column map for a log with foreign headers: a file, or the name of a shipped one.
    #[arg(long, value_name = "MAP")]
    columns: Option<PathBuf>,
    /// Gravity in the base frame [m/s²], instead of the robot file's.
    #[arg(long, value_name = "X,Y,Z", allow_hyphen_values = true)]
    gravity: Option<String>,
}

impl Check {
    /// Exit code: 0 when nothing is wrong, 2 when the file is unusable. What makes it so is the error, unless the
    /// report that was printed says it already.
    pub(super) fn run(self, global: &Global) -> Result<u8> {
        let gravity = self.gravity.as_deref().map(gravity).transpose()?;
        let options = Options {
            robot: self.robot,
            data: self.data,
            columns: self.columns,
            gravity,
            ..Options::default()
        };
        let report = check::file(&self.file, &options);
        let told = report.kind.is_some() && !global.json;
        if global.json {
            print_json(&report)?
        } else if told {
            print(&report.text())?
        }
        match report.unusable() {
            Some(_) if told => Ok(2),
            Some(error) => Err(error.clone()),
            None => Ok(u8::from(!report.is_sound())),
        }
    }
}

pub(super) fn gravity(text: &str) -> Result<[f64; 3]> {
    let parts: Vec<f64> = text.split(',').filter_map(|part| part.trim().parse().ok()).collect();
    <[f64; 3]>::try_from(parts).ok().filter(|g| g.iter().all(|x| x.abs() <= 1e6)).ok_or_else(|| {
        Error::new(format!("--gravity \"{text}\": not three numbers"))
            .help("write for example --gravity 0,0,-9.81 [m/s², base frame]")
    })
}

/// The kinds of files, for the help text.
fn kinds() -> String {
    let lines: String = Kind::ALL.iter().map(|kind| format!("  {}\n", kind.text())).collect();
    format!("Kinds of files that are known:\n{}", lines.trim_end_matches('\n'))
}
