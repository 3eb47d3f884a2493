//! A study that people work on in a browser: one process on this machine, one study in its folder, as many tabs
//! as one likes.
//!
//! Nothing is computed in the page, and hardly anything here: logs are read, models fitted, effects searched and
//! link parameters retrieved by the same calls that the command line makes. One thread does what was asked for
//! ([`work`](self)), one searches in the background for what is missing; the page is told when the state changes and
//! fetches it. Every finished step lies in the folder, with a scenario that repeats it from the command line.

mod bench;
mod constraints;
mod files;
mod folder;
mod http;
mod inputs;
mod logs;
mod page;
mod pictures;
mod progress;
mod region;
mod retrieve;
mod saved;
mod scan;
mod scripts;
mod state;
mod study;
#[cfg(test)]
mod tests;
mod work;
mod written;

use std::net::{Ipv4Addr, TcpListener};
use std::path::PathBuf;
use std::sync::Arc;

use crate::error::{Error, Result};

use bench::Bench;
use http::Door;
use work::Job;

/// What a workbench is opened with.
#[derive(Debug, Clone, Default)]
pub struct Options {
    /// Scenario to work on; instead of robot and logs.
    pub scenario: Option<PathBuf>,
    /// Robot file.
    pub robot: Option<PathBuf>,
    /// Logs to fit.
    pub data: Vec<PathBuf>,
    /// Logs that are never fitted.
    pub validate: Vec<PathBuf>,
    /// Column map of the logs: a file, or the name of a shipped one.
    pub columns: Option<PathBuf>,
    /// Gravity instead of the robot file's [m/s², base frame].
    pub gravity: Option<[f64; 3]>,
    /// Folder of the study; `out/workbench/<name>` when not given.
    pub folder: Option<PathBuf>,
    /// Whether to go on with the study that lies in the folder.
    pub resume: bool,
    /// Port; any free one when 0.
    pub port: u16,
    /// Seed of every random draw.
    pub seed: Option<u64>,
}

/// A workbench that is ready to be served.
pub struct Workbench {
    bench: Arc<Bench>,
    listener: TcpListener,
    door: Door,
}

impl Workbench {
    /// Takes the study's folder, made where it is not there, and a port of this machine; nothing outside of it can connect.
    ///
    /// # Errors
    /// When something else lies in the folder, another process has it, it cannot be written to, something that was named cannot be read, or the port is taken.
    pub fn open(options: &Options) -> Result<Self> {
        let listener = TcpListener::bind((Ipv4Addr::LOCALHOST, options.port)).map_err(|e| {
            Error::new(format!("cannot listen on port {}: {e}", options.port))
                .help("give another --port, or leave it out for any free one")
        })?;
        let port = listener.local_addr().map_err(|e| Error::new(format!("cannot listen: {e}")))?.port();
        let door = Door::new(port)?;
        let study = inputs::study(options)?;
        Ok(Self { bench: Bench::start(study)?, listener, door })
    }

    /// The address to open, with a token that is good for one browser.
    pub fn address(&self) -> String {
        self.door.address()
    }

    /// Where the study lies.
    pub fn folder(&self) -> PathBuf {
        self.bench.folder()
    }

    /// Files outside of its folder that the study reads, links followed; none of them is read before it is served.
    pub fn reads(&self) -> Vec<PathBuf> {
        folder::reads(&self.bench.study())
    }

    /// Serves the page until the process ends.
    ///
    /// # Errors
    /// When the system does not let it.
    pub fn serve(self) -> Result<()> {
        self.bench.ask(Job::Open { again: false });
        http::serve(self.bench, self.listener, self.door)
    }
}
