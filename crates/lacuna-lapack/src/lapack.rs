//! Factors and decompositions, as LAPACK exports them.

use std::ffi::{c_char, c_int};

use crate::matrix::{Owned, View, ViewMut};
use crate::scalar::Scalar;
use crate::{extent, factors, jacobi, letter, size, slice, slice_mut, triangle};

fn info(result: Result<(), usize>) -> c_int {
    result.map_or_else(|pivot| c_int::try_from(pivot).unwrap_or(c_int::MAX), |()| 0)
}

/// Writes thin singular vectors and values where LAPACK's callers want them.
fn write_svd<T: Scalar>(
    a: Owned<T>,
    vectors: bool,
    s: &mut [T],
    u: &mut ViewMut<'_, T>,
    vt: &mut ViewMut<'_, T>,
) {
    let svd = jacobi::svd(a);
    s.copy_from_slice(&svd.s);
    if vectors {
        for j in 0..svd.s.len() {
            (0..svd.u.rows).for_each(|i| u.set(i, j, svd.u.at(i, j)));
            (0..svd.v.rows).for_each(|i| vt.set(j, i, svd.v.at(i, j)));
        }
    }
}

macro_rules! solvers {
    ($t:ty, $potrf:ident, $potrs:ident, $gesv:ident) => {
        /// Cholesky factor in place.
        ///
        /// # Safety
        /// The conventions of LAPACK `potrf`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $potrf(
            uplo: *const c_char,
            n: *const c_int,
            a: *mut $t,
            lda: *const c_int,
            info_out: *mut c_int,
        ) {
            // SAFETY: LAPACK callers pass valid pointers to scalars and to matrices of the sizes they state.
            unsafe {
                let (n, lda) = (size(*n), size(*lda));
                let mut a = ViewMut::new(slice_mut(a, extent(n, n, lda)), lda);
                *info_out = info(factors::cholesky(triangle(letter(uplo)), n, &mut a));
            }
        }

        /// Solves with a Cholesky factor.
        ///
        /// # Safety
        /// The conventions of LAPACK `potrs`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $potrs(
            uplo: *const c_char,
            n: *const c_int,
            nrhs: *const c_int,
            a: *const $t,
            lda: *const c_int,
            b: *mut $t,
            ldb: *const c_int,
            info_out: *mut c_int,
        ) {
            // SAFETY: as in `potrf`.
            unsafe {
                let (n, columns, lda, ldb) = (size(*n), size(*nrhs), size(*lda), size(*ldb));
                let a = View::new(slice(a, extent(n, n, lda)), lda);
                let mut b = ViewMut::new(slice_mut(b, extent(n, columns, ldb)), ldb);
                let stored = triangle(letter(uplo));
                factors::cholesky_solve(stored, (n, columns), |i, j| a.at(i, j), &mut b);
                *info_out = 0;
            }
        }

        /// Solves by LU factors with row exchanges.
        ///
        /// # Safety
        /// The conventions of LAPACK `gesv`.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gesv(
            n: *const c_int,
            nrhs: *const c_int,
            a: *mut $t,
            lda: *const c_int,
            ipiv: *mut c_int,
            b: *mut $t,
            ldb: *const c_int,
            info_out: *mut c_int,
        ) {
            // SAFETY: as in `potrf`.
            unsafe {
                let (n, columns, lda, ldb) = (size(*n), size(*nrhs), size(*lda), size(*ldb));
                let mut a = ViewMut::new(slice_mut(a, extent(n, n, lda)), lda);
                let mut b = ViewMut::new(slice_mut(b, extent(n, columns, ldb)), ldb);
                let pivots = slice_mut(ipiv, n);
                *info_out = info(factors::lu_solve((n, columns), &mut a, pivots, &mut b));
            }
        }
    };
}

macro_rules! decompositions {
    ($t:ty, $syevr:ident, $gesdd:ident, $gesvd:ident) => {
        /// All eigenvalues of a symmetric matrix, ascending, and with `jobz = V` its eigenvectors.
        ///
        /// # Safety
        /// The conventions of LAPACK `syevr`; `range` must be `A`, else `info` is -2.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $syevr(
            jobz: *const c_char,
            range: *const c_char,
            uplo: *const c_char,
            n: *const c_int,
            a: *mut $t,
            lda: *const c_int,
            _vl: *const $t,
            _vu: *const $t,
            _il: *const c_int,
            _iu: *const c_int,
            _abstol: *const $t,
            m: *mut c_int,
            w: *mut $t,
            z: *mut $t,
            ldz: *const c_int,
            _isuppz: *mut c_int,
            work: *mut $t,
            lwork: *const c_int,
            iwork: *mut c_int,
            liwork: *const c_int,
            info_out: *mut c_int,
        ) {
            // SAFETY: as in `potrf`; `z` is touched only where eigenvectors are asked for.
            unsafe {
                *info_out = if letter(range) == b'A' { 0 } else { -2 };
                if *info_out != 0 || *lwork == -1 || *liwork == -1 {
                    *work = Scalar::from_length(1);
                    *iwork = 1;
                    return;
                }
                let (rows, lda, ldz, stored) = (size(*n), size(*lda), size(*ldz), triangle(letter(uplo)));
                let a = View::new(slice(a.cast_const(), extent(rows, rows, lda)), lda);
                let whole = Owned::from_fn(rows, rows, |i, j| {
                    let (i, j) = stored.place(i, j);
                    a.at(i, j)
                });
                let (values, vectors) = jacobi::symmetric_eigen(whole);
                slice_mut(w, rows).copy_from_slice(&values);
                if letter(jobz) == b'V' {
                    let mut z = ViewMut::new(slice_mut(z, extent(rows, rows, ldz)), ldz);
                    (0..rows).for_each(|j| (0..rows).for_each(|i| z.set(i, j, vectors.at(i, j))));
                }
                *m = *n;
            }
        }

        /// Singular values, descending, and with `jobz = S` thin singular vectors.
        ///
        /// # Safety
        /// The conventions of LAPACK `gesdd`; `jobz` must be `S` or `N`, else `info` is -1.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gesdd(
            jobz: *const c_char,
            m: *const c_int,
            n: *const c_int,
            a: *mut $t,
            lda: *const c_int,
            s: *mut $t,
            u: *mut $t,
            ldu: *const c_int,
            vt: *mut $t,
            ldvt: *const c_int,
            work: *mut $t,
            lwork: *const c_int,
            _iwork: *mut c_int,
            info_out: *mut c_int,
        ) {
            // SAFETY: `gesvd` has the same conventions for the same pointers.
            unsafe { $gesvd(jobz, jobz, m, n, a, lda, s, u, ldu, vt, ldvt, work, lwork, info_out) }
        }

        /// Singular values, descending, and with `jobu = jobvt = S` thin singular vectors.
        ///
        /// # Safety
        /// The conventions of LAPACK `gesvd`; the jobs must be both `S` or both `N`, else `info` is -1.
        #[unsafe(no_mangle)]
        pub unsafe extern "C" fn $gesvd(
            jobu: *const c_char,
            jobvt: *const c_char,
            m: *const c_int,
            n: *const c_int,
            a: *mut $t,
            lda: *const c_int,
            s: *mut $t,
            u: *mut $t,
            ldu: *const c_int,
            vt: *mut $t,
            ldvt: *const c_int,
            work: *mut $t,
            lwork: *const c_int,
            info_out: *mut c_int,
        ) {
            // SAFETY: as in `potrf`; `u` and `vt` are touched only where vectors are asked for.
            unsafe {
                let job = letter(jobu);
                *info_out = if job == letter(jobvt) && (job == b'S' || job == b'N') { 0 } else { -1 };
                if *info_out != 0 || *lwork == -1 {
                    *work = Scalar::from_length(1);
                    return;
                }
                let (m, n, lda) = (size(*m), size(*n), size(*lda));
                let (thin, vectors) = (m.min(n), job == b'S');
                let a = View::new(slice(a.cast_const(), extent(m, n, lda)), lda);
                let whole = Owned::from_fn(m, n, |i, j| a.at(i, j));
                let (ldu, ldvt) = (size(*ldu), size(*ldvt));
                let room = |rows, columns, stride| if vectors { extent(rows, columns, stride) } else { 0 };
                let mut u = ViewMut::new(slice_mut(u, room(m, thin, ldu)), ldu);
                let mut vt = ViewMut::new(slice_mut(vt, room(thin, n, ldvt)), ldvt);
                write_svd(whole, vectors, slice_mut(s, thin), &mut u, &mut vt);
            }
        }
    };
}

solvers!(f64, dpotrf_, dpotrs_, dgesv_);
solvers!(f32, spotrf_, spotrs_, sgesv_);
decompositions!(f64, dsyevr_, dgesdd_, dgesvd_);
decompositions!(f32, ssyevr_, sgesdd_, sgesvd_);
