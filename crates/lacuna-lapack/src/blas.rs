//! The products, as BLAS exports them.

use std::ffi::{c_char, c_int};

use crate::matrix::{View, ViewMut};
use crate::{extent, letter, products, size, slice, slice_mut, span, transposed, triangle};

macro_rules! products {
    ($t:ty, $gemm:ident, $gemv:ident, $symv:ident, $syrk:ident, $syr2k:ident) => {
        /// `C = alpha op(A) op(B) + beta C`.
        ///
        /// # Safety
        /// The conventions of BLAS `gemm`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gemm(
            transa: *const c_char,
            transb: *const c_char,
            m: *const c_int,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $t,
            a: *const $t,
            lda: *const c_int,
            b: *const $t,
            ldb: *const c_int,
            beta: *const $t,
            c: *mut $t,
            ldc: *const c_int,
        ) {
            // SAFETY: BLAS callers pass valid pointers to scalars and to matrices of the sizes they state.
            unsafe {
                let (m, n, k) = (size(*m), size(*n), size(*k));
                let (turn_a, turn_b) = (transposed(letter(transa)), transposed(letter(transb)));
                let (lda, ldb, ldc) = (size(*lda), size(*ldb), size(*ldc));
                let (ra, ca) = if turn_a { (k, m) } else { (m, k) };
                let (rb, cb) = if turn_b { (n, k) } else { (k, n) };
                let a = View::new(slice(a, extent(ra, ca, lda)), lda).transposed_if(turn_a);
                let b = View::new(slice(b, extent(rb, cb, ldb)), ldb).transposed_if(turn_b);
                let mut c = ViewMut::new(slice_mut(c, extent(m, n, ldc)), ldc);
                products::gemm((m, n, k), *alpha, a, b, *beta, &mut c);
            }
        }

        /// `y = alpha op(A) x + beta y`.
        ///
        /// # Safety
        /// The conventions of BLAS `gemv`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gemv(
            trans: *const c_char,
            m: *const c_int,
            n: *const c_int,
            alpha: *const $t,
            a: *const $t,
            lda: *const c_int,
            x: *const $t,
            incx: *const c_int,
            beta: *const $t,
            y: *mut $t,
            incy: *const c_int,
        ) {
            // SAFETY: as in `gemm`.
            unsafe {
                let (m, n, lda) = (size(*m), size(*n), size(*lda));
                let turn = transposed(letter(trans));
                let a = View::new(slice(a, extent(m, n, lda)), lda).transposed_if(turn);
                let (rows, columns) = if turn { (n, m) } else { (m, n) };
                let x = (slice(x, span(columns, *incx)), *incx as isize);
                let y = (slice_mut(y, span(rows, *incy)), *incy as isize);
                products::matrix_vector((rows, columns), *alpha, |i, j| a.at(i, j), x, *beta, y);
            }
        }

        /// `y = alpha A x + beta y`, `A` symmetric.
        ///
        /// # Safety
        /// The conventions of BLAS `symv`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $symv(
            uplo: *const c_char,
            n: *const c_int,
            alpha: *const $t,
            a: *const $t,
            lda: *const c_int,
            x: *const $t,
            incx: *const c_int,
            beta: *const $t,
            y: *mut $t,
            incy: *const c_int,
        ) {
            // SAFETY: as in `gemm`.
            unsafe {
                let (n, lda, stored) = (size(*n), size(*lda), triangle(letter(uplo)));
                let a = View::new(slice(a, extent(n, n, lda)), lda);
                let x = (slice(x, span(n, *incx)), *incx as isize);
                let y = (slice_mut(y, span(n, *incy)), *incy as isize);
                let entry = |i, j| {
                    let (i, j) = stored.place(i, j);
                    a.at(i, j)
                };
                products::matrix_vector((n, n), *alpha, entry, x, *beta, y);
            }
        }

        /// One triangle of `C = alpha op(A) op(A)ᵀ + beta C`.
        ///
        /// # Safety
        /// The conventions of BLAS `syrk`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $syrk(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $t,
            a: *const $t,
            lda: *const c_int,
            beta: *const $t,
            c: *mut $t,
            ldc: *const c_int,
        ) {
            // SAFETY: as in `gemm`.
            unsafe {
                let (n, k, lda, ldc) = (size(*n), size(*k), size(*lda), size(*ldc));
                let turn = transposed(letter(trans));
                let (rows, columns) = if turn { (k, n) } else { (n, k) };
                let a = View::new(slice(a, extent(rows, columns, lda)), lda).transposed_if(turn);
                let mut c = ViewMut::new(slice_mut(c, extent(n, n, ldc)), ldc);
                products::syrk(triangle(letter(uplo)), (n, k), *alpha, a, *beta, &mut c);
            }
        }

        /// One triangle of `C = alpha (op(A) op(B)ᵀ + op(B) op(A)ᵀ) + beta C`.
        ///
        /// # Safety
        /// The conventions of BLAS `syr2k`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $syr2k(
            uplo: *const c_char,
            trans: *const c_char,
            n: *const c_int,
            k: *const c_int,
            alpha: *const $t,
            a: *const $t,
            lda: *const c_int,
            b: *const $t,
            ldb: *const c_int,
            beta: *const $t,
            c: *mut $t,
            ldc: *const c_int,
        ) {
            // SAFETY: as in `gemm`.
            unsafe {
                let (n, k, lda, ldb, ldc) = (size(*n), size(*k), size(*lda), size(*ldb), size(*ldc));
                let turn = transposed(letter(trans));
                let (rows, columns) = if turn { (k, n) } else { (n, k) };
                let a = View::new(slice(a, extent(rows, columns, lda)), lda).transposed_if(turn);
                let b = View::new(slice(b, extent(rows, columns, ldb)), ldb).transposed_if(turn);
                let mut c = ViewMut::new(slice_mut(c, extent(n, n, ldc)), ldc);
                products::syr2k(triangle(letter(uplo)), (n, k), *alpha, (a, b), *beta, &mut c);
            }
        }
    };
}

products!(f64, dgemm_, dgemv_, dsymv_, dsyrk_, dsyr2k_);
products!(f32, sgemm_, sgemv_, ssymv_, ssyrk_, ssyr2k_);
