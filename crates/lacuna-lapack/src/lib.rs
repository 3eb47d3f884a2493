//! The BLAS and LAPACK symbols that clarabel's semidefinite cone calls, answered in Rust, so that nothing
//! has to be installed and nothing but Rust is linked. Say `extern crate lacuna_lapack as _;` somewhere, or
//! the linker leaves them out; and do not link another BLAS into the same program.
//!
//! Eleven routines in two precisions: `gemm gemv symv syrk syr2k potrf potrs gesv syevr gesdd gesvd`, with
//! the meaning and the Fortran calling convention of the reference implementation (32-bit integers), for what
//! clarabel asks: all eigenvalues, thin singular vectors. Anything else is refused through `info`. Products
//! are plain sums and decompositions are Jacobi's, so results have the same bits on every processor. They are
//! meant for small matrices (up to some fifty rows).
//!
//! This is the only crate of the workspace with `unsafe`: here, where foreign pointers become slices.

mod blas;
mod factors;
mod jacobi;
mod lapack;
mod matrix;
mod products;
mod scalar;
#[cfg(test)]
mod tests;

use std::ffi::{c_char, c_int};

pub use blas::*;
pub use lapack::*;
use products::Triangle;

/// A dimension; negative ones count as none.
fn size(n: c_int) -> usize {
    usize::try_from(n).unwrap_or(0)
}

/// How much memory a matrix spans.
fn extent(rows: usize, columns: usize, stride: usize) -> usize {
    if rows == 0 || columns == 0 { 0 } else { stride * (columns - 1) + rows }
}

/// How much memory a vector spans.
fn span(n: usize, step: c_int) -> usize {
    if n == 0 { 0 } else { (n - 1) * step.unsigned_abs() as usize + 1 }
}

/// A letter argument, in upper case.
///
/// # Safety
/// `letter` points to a readable byte.
unsafe fn letter(letter: *const c_char) -> u8 {
    // SAFETY: the caller's promise.
    unsafe { *letter }.to_ne_bytes()[0].to_ascii_uppercase()
}

fn transposed(letter: u8) -> bool {
    letter != b'N'
}

fn triangle(letter: u8) -> Triangle {
    if letter == b'L' { Triangle::Lower } else { Triangle::Upper }
}

/// # Safety
/// `data` is readable for `length` entries that nobody writes meanwhile.
unsafe fn slice<'a, T>(data: *const T, length: usize) -> &'a [T] {
    // SAFETY: the caller's promise; nothing is read where nothing is asked for.
    if length == 0 { &[] } else { unsafe { std::slice::from_raw_parts(data, length) } }
}

/// # Safety
/// `data` is readable and writable for `length` entries that nobody else touches meanwhile.
unsafe fn slice_mut<'a, T>(data: *mut T, length: usize) -> &'a mut [T] {
    // SAFETY: the caller's promise; nothing is read where nothing is asked for.
    if length == 0 { &mut [] } else { unsafe { std::slice::from_raw_parts_mut(data, length) } }
}
