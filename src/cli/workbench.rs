use crate::workbench::{Options, Workbench as Open};
use lacuna::{Error, Result};
use serde_json::json;

use super::interrupt::Interrupt;
use super::sources::Sources;
use super::{Global, print, print_json, say};

/// Flags of `lacuna workbench`.
#[derive(Debug, clap::Args)]
pub(super) struct Workbench {
    #[command(flatten)]
    from: Sources,
    /// Port of this machine to listen on; any free one when not given.
    #[arg(long, value_name = "N", default_value_t = 0)]
    port: u16,
}

impl Workbench {
    /// Serves the page until the process is ended.
    pub(super) fn run(self, global: &Global) -> Result<bool> {
        give_memory_back();
        if self.from.scenario.is_some() && (self.from.robot.is_some() || !self.from.data.is_empty()) {
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
        let named = self.from.scenario.is_some() || self.from.robot.is_some() || !self.from.data.is_empty();
        if resume && (named || !self.from.validate.is_empty()) {
            return Err(Error::new("--resume goes on with the files of the study")
                .help("leave scenario, --robot, --data and --validate away"));
        }
        let options = Options {
            scenario: self.from.scenario,
            robot: self.from.robot,
            data: self.from.data,
            validate: self.from.validate,
            columns: self.from.columns,
            gravity: self.from.gravity.as_deref().map(super::check::gravity).transpose()?,
            folder: global.resume.clone().or_else(|| global.out.clone()),
            resume,
            port: self.port,
            seed: global.seed,
        };
        // What is finished stands in the folder, so it ends at once.
        Interrupt::install(global.quiet)?;
        let bench = Open::open(&options)?;
        let folder = bench.folder().display().to_string();
        if global.json {
            print_json(&json!({"address": bench.address(), "folder": folder}))?;
        } else {
            print(&format!("workbench  {}\n", bench.address()))?;
        }
        let reads = bench.reads();
        if resume && !reads.is_empty() {
            eprintln!("files outside of the folder that this study reads:");
            reads.iter().for_each(|file| eprintln!("  {}", file.display()));
        }
        if !global.quiet {
            say(&format!(
                "open it in a browser of this machine; it is good for one, once.\nthe study lies in {folder}; Ctrl-C ends, \
                 --resume {folder} goes on"
            ));
        }
        bench.serve()?;
        Ok(true)
    }
}

/// Starts the program once more in its own place, with an allocator that gives blocks of long logs back.
///
/// That of the GNU C library keeps what it has, and more of it with every large block that was freed: a million samples
/// then take twice the memory. It listens to the environment alone, and only at the start.
#[cfg(all(target_os = "linux", target_env = "gnu"))]
fn give_memory_back() {
    use std::os::unix::process::CommandExt;
    const LARGEST_KEPT: (&str, &str) = ("MALLOC_MMAP_THRESHOLD_", "262144");
    if std::env::var_os(LARGEST_KEPT.0).is_some() {
        return;
    }
    if let Ok(program) = std::env::current_exe() {
        let again = std::env::args_os().skip(1);
        // It only returns where it could not be done; then it goes on with more memory.
        let _ = std::process::Command::new(program).args(again).env(LARGEST_KEPT.0, LARGEST_KEPT.1).exec();
    }
}

/// Elsewhere allocators give memory back by themselves.
#[cfg(not(all(target_os = "linux", target_env = "gnu")))]
fn give_memory_back() {}
