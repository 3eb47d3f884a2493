//! Every symbol through its foreign interface, against the plain definition.

mod decompositions;

use super::*;
use std::ptr::null_mut;

/// Numbers without structure in `[-1, 1)`.
fn numbers(count: usize, seed: u64) -> Vec<f64> {
    let mut state = seed.wrapping_mul(0x9E37_79B9_7F4A_7C15) | 1;
    (0..count)
        .map(|_| {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
        })
        .collect()
}

fn byte(letter: u8) -> c_char {
    c_char::from_ne_bytes([letter])
}

fn close(a: f64, b: f64) -> bool {
    (a - b).abs() < 1e-13 * (1.0 + b.abs())
}

/// Entry of `op(A)` for a column-major matrix with the stride 6.
fn entry(a: &[f64], turned: bool, i: usize, j: usize) -> f64 {
    if turned { a[j + 6 * i] } else { a[i + 6 * j] }
}

#[test]
fn gemm_in_all_transpositions() {
    let (m, n, k, ld) = (3, 4, 5, 6);
    let (a, b) = (numbers(36, 1), numbers(36, 2));
    for (ta, tb) in [(false, false), (true, false), (false, true), (true, true)] {
        for beta in [0.0, 0.7] {
            let mut c = numbers(36, 3);
            let old = c.clone();
            if beta == 0.0 {
                c.fill(f64::NAN);
            }
            let job = |turned| byte(if turned { b'T' } else { b'N' });
            // SAFETY: all matrices have the stated sizes.
            unsafe {
                dgemm_(
                    &job(ta),
                    &job(tb),
                    &m,
                    &n,
                    &k,
                    &1.5,
                    a.as_ptr(),
                    &ld,
                    b.as_ptr(),
                    &ld,
                    &beta,
                    c.as_mut_ptr(),
                    &ld,
                );
            }
            for (i, j) in (0..3).flat_map(|i| (0..4).map(move |j| (i, j))) {
                let sum: f64 = (0..5).map(|l| entry(&a, ta, i, l) * entry(&b, tb, l, j)).sum();
                assert!(close(
                    c[i + 6 * j],
                    1.5 * sum + if beta > 0.0 { beta * old[i + 6 * j] } else { 0.0 }
                ));
            }
            assert!(beta == 0.0 || close(c[3], old[3]), "below the matrix nothing is written");
        }
    }
}

#[test]
fn vectors_with_steps_and_symmetric_matrices() {
    let (a, x) = (numbers(36, 4), numbers(12, 5));
    for turned in [false, true] {
        let (rows, columns) = if turned { (4, 3) } else { (3, 4) };
        let mut y = numbers(12, 6);
        let old = y.clone();
        // SAFETY: all matrices have the stated sizes.
        unsafe {
            let job = byte(if turned { b'T' } else { b'N' });
            dgemv_(&job, &3, &4, &2.0, a.as_ptr(), &6, x.as_ptr(), &2, &0.5, y.as_mut_ptr(), &-3);
        }
        for i in 0..rows {
            let sum: f64 = (0..columns).map(|j| entry(&a, turned, i, j) * x[2 * j]).sum();
            let place = 3 * (rows - 1 - i);
            assert!(close(y[place], 2.0 * sum + 0.5 * old[place]));
        }
    }
    for uplo in [b'U', b'L'] {
        let mut y = vec![f64::NAN; 4];
        // SAFETY: all matrices have the stated sizes.
        unsafe { dsymv_(&byte(uplo), &4, &1.0, a.as_ptr(), &6, x.as_ptr(), &1, &0.0, y.as_mut_ptr(), &1) };
        for (i, &y) in y.iter().enumerate() {
            let stored = |j: usize| if (uplo == b'U') == (i <= j) { a[i + 6 * j] } else { a[j + 6 * i] };
            assert!(close(y, (0..4).map(|j| stored(j) * x[j]).sum()));
        }
    }
}

#[test]
fn rank_updates_touch_one_triangle() {
    let (a, b) = (numbers(36, 7), numbers(36, 8));
    for (uplo, turned) in [(b'U', false), (b'L', false), (b'U', true), (b'L', true)] {
        let (mut c, mut d) = (numbers(36, 9), numbers(36, 9));
        let old = c.clone();
        let job = byte(if turned { b'T' } else { b'N' });
        // SAFETY: all matrices have the stated sizes.
        unsafe {
            dsyrk_(&byte(uplo), &job, &4, &3, &0.3, a.as_ptr(), &6, &2.0, c.as_mut_ptr(), &6);
            dsyr2k_(
                &byte(uplo),
                &job,
                &4,
                &3,
                &0.3,
                a.as_ptr(),
                &6,
                b.as_ptr(),
                &6,
                &2.0,
                d.as_mut_ptr(),
                &6,
            );
        }
        for (i, j) in (0..4).flat_map(|i| (0..4).map(move |j| (i, j))) {
            let product = |x: &[f64], y: &[f64]| -> f64 {
                (0..3).map(|l| entry(x, turned, i, l) * entry(y, turned, j, l)).sum()
            };
            let at = i + 6 * j;
            let inside = if uplo == b'U' { i <= j } else { i >= j };
            let (one, two) = (product(&a, &a), product(&a, &b) + product(&b, &a));
            assert!(close(c[at], if inside { 0.3 * one + 2.0 * old[at] } else { old[at] }));
            assert!(close(d[at], if inside { 0.3 * two + 2.0 * old[at] } else { old[at] }));
        }
    }
}

/// `B Bᵀ` plus a little, positive definite, and a right-hand side.
fn definite(n: usize, seed: u64) -> Vec<f64> {
    let b = numbers(n * n, seed);
    let product = |i, j| (0..n).map(|k| b[i + n * k] * b[j + n * k]).sum::<f64>();
    let mut a: Vec<f64> = (0..n * n).map(|at| product(at % n, at / n)).collect();
    (0..n).for_each(|i| a[i + n * i] += 1e-3);
    a
}

#[test]
fn cholesky_factors_and_solves() {
    for uplo in [b'U', b'L'] {
        let a = definite(5, 10);
        let (mut factor, mut b) = (a.clone(), numbers(10, 11));
        let rhs = b.clone();
        let mut status = 7;
        // SAFETY: all matrices have the stated sizes.
        unsafe {
            dpotrf_(&byte(uplo), &5, factor.as_mut_ptr(), &5, &mut status);
            assert_eq!(status, 0);
            dpotrs_(&byte(uplo), &5, &2, factor.as_ptr(), &5, b.as_mut_ptr(), &5, &mut status);
        }
        for (i, c) in (0..5).flat_map(|i| (0..2).map(move |c| (i, c))) {
            let product: f64 = (0..5).map(|j| a[i + 5 * j] * b[j + 5 * c]).sum();
            assert!((product - rhs[i + 5 * c]).abs() < 1e-10);
        }
        let mut indefinite = vec![1.0, 2.0, 2.0, 1.0];
        // SAFETY: all matrices have the stated sizes.
        unsafe { dpotrf_(&byte(uplo), &2, indefinite.as_mut_ptr(), &2, &mut status) };
        assert_eq!(status, 2, "the pivot that fails");
    }
}

#[test]
fn lu_solves_and_names_a_zero_pivot() {
    // A zero in the first place: without row exchanges this fails.
    let mut a = numbers(25, 12);
    a[0] = 0.0;
    let (mut factor, mut b, mut pivots, mut status) = (a.clone(), numbers(5, 13), vec![0; 5], 7);
    let rhs = b.clone();
    // SAFETY: all matrices have the stated sizes.
    unsafe {
        dgesv_(&5, &1, factor.as_mut_ptr(), &5, pivots.as_mut_ptr(), b.as_mut_ptr(), &5, &mut status);
    }
    assert_eq!(status, 0);
    for (i, &right) in rhs.iter().enumerate() {
        assert!(((0..5).map(|j| a[i + 5 * j] * b[j]).sum::<f64>() - right).abs() < 1e-12);
    }
    let mut singular = vec![1.0, 2.0, 2.0, 4.0];
    // SAFETY: all matrices have the stated sizes.
    unsafe {
        dgesv_(&2, &1, singular.as_mut_ptr(), &2, pivots.as_mut_ptr(), b.as_mut_ptr(), &2, &mut status);
    }
    assert_eq!(status, 2);
}

#[test]
fn single_precision_is_there() {
    let (a, mut c) = ([1.0_f32, 2.0, 3.0, 4.0], [0.0_f32; 4]);
    let (mut w, mut z, mut found, mut work, mut iwork, mut status) = ([0.0; 2], [0.0; 4], 0, [0.0], [0], 7);
    // SAFETY: all matrices have the stated sizes.
    unsafe {
        let no = byte(b'N');
        sgemm_(&no, &no, &2, &2, &2, &1.0, a.as_ptr(), &2, a.as_ptr(), &2, &0.0, c.as_mut_ptr(), &2);
        assert!(c.iter().zip([7.0_f32, 10.0, 15.0, 22.0]).all(|(a, b)| (a - b).abs() < 1e-5));
        let mut symmetric = [2.0_f32, 1.0, 1.0, 2.0];
        ssyevr_(
            &no,
            &byte(b'A'),
            &byte(b'U'),
            &2,
            symmetric.as_mut_ptr(),
            &2,
            &0.0,
            &0.0,
            &0,
            &0,
            &0.0,
            &mut found,
            w.as_mut_ptr(),
            z.as_mut_ptr(),
            &2,
            null_mut(),
            work.as_mut_ptr(),
            &1,
            iwork.as_mut_ptr(),
            &1,
            &mut status,
        );
    }
    assert!((w[0] - 1.0).abs() < 1e-6 && (w[1] - 3.0).abs() < 1e-6 && status == 0);
}
