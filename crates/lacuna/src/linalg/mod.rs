//! Least squares in constant memory: a triangle that absorbs rows.

mod lanes;
mod solve;
mod triangle;

pub(crate) use lanes::{dots, subtract_product};
pub(crate) use solve::solved;
pub use solve::{Solution, condition_number, product};
pub use triangle::Triangle;

/// Bytes of a cache line, and of the widest vector register: loads that straddle two take twice the time.
const LINE: usize = 64;
/// Numbers in a cache line.
pub(crate) const LINE_LENGTH: usize = LINE / size_of::<f64>();

/// Index below [`LINE_LENGTH`] of the first entry of `room` that begins a cache line.
pub(crate) fn line_start(room: &[f64]) -> usize {
    room.as_ptr().align_offset(LINE).min(LINE_LENGTH - 1)
}
