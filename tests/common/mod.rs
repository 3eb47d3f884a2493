//! What several test files share.

#![allow(dead_code)] // every test file uses only a part

use std::path::PathBuf;

use lacuna::robot::Robot;

/// A file of the folder that `LACUNA_DATA` names; says that the test is skipped when there is none.
pub fn data(file: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LACUNA_DATA") else {
        println!("skipped: LACUNA_DATA is not set, {file} is not here");
        return None;
    };
    let path = PathBuf::from(folder).join(file);
    if !path.is_file() {
        println!("skipped: {file} is not in the folder that LACUNA_DATA names");
        return None;
    }
    Some(path)
}

/// A shipped robot.
pub fn robot(file: &str) -> Robot {
    Robot::open(PathBuf::from("robots").join(file)).expect("shipped robots read")
}

/// A JSON list of numbers.
pub fn json_numbers(value: &serde_json::Value) -> Vec<f64> {
    value.as_array().map(|a| a.iter().filter_map(serde_json::Value::as_f64).collect()).unwrap_or_default()
}
