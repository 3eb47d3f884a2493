//! The `lacuna` command.

use std::process::ExitCode;

// The workbench speaks of the library's rooms as its own.
use lacuna::{
    check, constraints, diagnose, effects, error, export, log, model_file, report, retrieval, robot,
    scenario, signals, stop, study, text,
};

mod cli;
mod workbench;

fn main() -> ExitCode {
    #[cfg(feature = "nlopt")]
    lacuna_nlopt::install();
    cli::run()
}
