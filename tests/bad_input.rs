//! What a person gets to see who gives the program bad input: where, what, and what to do; exit code 2,
//! nothing on stdout and no file.

#[path = "bad_input/logs.rs"]
mod logs;
#[path = "bad_input/models.rs"]
mod models;
#[path = "bad_input/names.rs"]
mod names;
#[path = "bad_input/paths.rs"]
mod paths;
#[path = "bad_input/robots.rs"]
mod robots;
#[path = "bad_input/ron.rs"]
mod ron;
#[path = "bad_input/scenarios.rs"]
mod scenarios;

use super::folder;
