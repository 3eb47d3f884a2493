//! What every part of lacuna rests on: errors that name place and remedy, text in and out, seeded random numbers,
//! robots, logs and motions. Nothing here identifies, fits or simulates.

pub mod error;
pub mod excitation;
pub mod log;
pub mod random;
pub mod robot;
pub mod stop;
pub mod text;

pub use error::{Error, Result};
