//! The program from outside: commands, what they print and write, the workbench over a socket. One binary, for each
//! one more costs a link of everything.

mod common;
#[path = "command_line/folder.rs"]
mod folder;

#[path = "bad_input.rs"]
mod bad_input;
#[path = "check.rs"]
mod check;
#[path = "command_line.rs"]
mod command_line;
#[path = "diagnose.rs"]
mod diagnose;
#[path = "diagnose_input.rs"]
mod diagnose_input;
#[path = "export.rs"]
mod export;
#[path = "interrupted.rs"]
mod interrupted;
#[path = "report_page.rs"]
mod report_page;
#[path = "retrieval.rs"]
mod retrieval;
#[path = "retrieval_input.rs"]
mod retrieval_input;
#[path = "simulate.rs"]
mod simulate;
#[path = "workbench.rs"]
mod workbench;
