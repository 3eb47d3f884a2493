//! Least squares in constant memory: a triangle that absorbs rows.

mod lanes;
mod solve;
mod triangle;

pub use solve::{Solution, condition_number, product};
pub use triangle::Triangle;
