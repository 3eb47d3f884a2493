//! Eigenvalues and singular values.

use super::*;

fn eigen(a: &[f64], n: usize, jobz: u8, uplo: u8) -> (Vec<f64>, Vec<f64>) {
    let (mut a, mut w, mut z) = (a.to_vec(), vec![0.0; n], vec![0.0; n * n]);
    let (mut found, mut work, mut iwork, mut status) = (0, [0.0], [0], 7);
    let rows = n as c_int;
    for length in [-1, 1] {
        // SAFETY: all matrices have the stated sizes.
        unsafe {
            dsyevr_(
                &byte(jobz),
                &byte(b'A'),
                &byte(uplo),
                &rows,
                a.as_mut_ptr(),
                &rows,
                &0.0,
                &0.0,
                &0,
                &0,
                &-1.0,
                &mut found,
                w.as_mut_ptr(),
                z.as_mut_ptr(),
                &rows,
                null_mut(),
                work.as_mut_ptr(),
                &length,
                iwork.as_mut_ptr(),
                &length,
                &mut status,
            );
        }
        assert_eq!(status, 0);
        assert!(work[0] >= 1.0 && iwork[0] >= 1);
    }
    assert_eq!(found, rows);
    (w, z)
}

#[test]
fn eigenvalues_of_symmetric_matrices() {
    for n in [1, 2, 4, 7, 12] {
        let half = numbers(n * n, 14 + n as u64);
        let a: Vec<f64> = (0..n * n).map(|at| half[at] + half[at / n + n * (at % n)]).collect();
        for uplo in [b'U', b'L'] {
            let (values, vectors) = eigen(&a, n, b'V', uplo);
            assert_eq!(eigen(&a, n, b'N', uplo).0, values);
            assert!(values.windows(2).all(|w| w[0] <= w[1]));
            for (i, k) in (0..n).flat_map(|i| (0..n).map(move |k| (i, k))) {
                let image: f64 = (0..n).map(|j| a[i + n * j] * vectors[j + n * k]).sum();
                assert!((image - values[k] * vectors[i + n * k]).abs() < 1e-13);
                let dot: f64 = (0..n).map(|j| vectors[j + n * i] * vectors[j + n * k]).sum();
                assert!((dot - f64::from(u8::from(i == k))).abs() < 1e-14);
            }
        }
    }
}

#[test]
fn tiny_eigenvalues_of_graded_matrices_are_relatively_exact() {
    // diag(d) (1 + 0.1 off-diagonal) diag(d) with d = 1, 1e-4, 1e-8: determinant and hence the product of
    // the eigenvalues is known to all digits; a method that is only backward stable loses the smallest.
    let d = [1.0, 1e-4, 1e-8];
    let a: Vec<f64> =
        (0..9).map(|at| d[at % 3] * d[at / 3] * if at % 3 == at / 3 { 1.0 } else { 0.1 }).collect();
    let determinant = 1e-24 * (1.0 - 3.0 * 0.01 + 2.0 * 0.001);
    let (values, _) = eigen(&a, 3, b'N', b'U');
    assert!((values.iter().product::<f64>() / determinant - 1.0).abs() < 1e-13);
    assert!((values[0] / 1e-16 - 1.0).abs() < 0.1);
}

#[test]
fn not_a_number_comes_back_and_does_not_hang() {
    let (values, _) = eigen(&[f64::NAN; 16], 4, b'V', b'U');
    assert!(values.iter().all(|v| v.is_nan()));
}

#[test]
fn eigenvalues_by_range_are_refused() {
    let mut status = 0;
    let (mut a, mut w, mut z, mut found, mut work, mut iwork) = ([1.0], [0.0], [0.0], 0, [0.0], [0]);
    // SAFETY: all matrices have the stated sizes.
    unsafe {
        dsyevr_(
            &byte(b'N'),
            &byte(b'I'),
            &byte(b'U'),
            &1,
            a.as_mut_ptr(),
            &1,
            &0.0,
            &0.0,
            &1,
            &1,
            &0.0,
            &mut found,
            w.as_mut_ptr(),
            z.as_mut_ptr(),
            &1,
            null_mut(),
            work.as_mut_ptr(),
            &1,
            iwork.as_mut_ptr(),
            &1,
            &mut status,
        );
    }
    assert_eq!(status, -2);
}

type Decomposed = (Vec<f64>, Vec<f64>, Vec<f64>);

/// Thin singular value decomposition through both symbols, which must agree.
fn singular(a: &[f64], m: usize, n: usize) -> Decomposed {
    let thin = m.min(n);
    let (rows, columns, inner) = (m as c_int, n as c_int, thin as c_int);
    let run = |divide: bool| {
        let (mut a, mut s) = (a.to_vec(), vec![0.0; thin]);
        let (mut u, mut vt) = (vec![0.0; m * thin], vec![0.0; thin * n]);
        let (mut work, mut iwork, mut status, job) = ([0.0], [0], 7, byte(b'S'));
        for length in [-1, 1] {
            let (a, s, u, vt) = (a.as_mut_ptr(), s.as_mut_ptr(), u.as_mut_ptr(), vt.as_mut_ptr());
            let (work, iwork, status) = (work.as_mut_ptr(), iwork.as_mut_ptr(), &raw mut status);
            // SAFETY: all matrices have the stated sizes.
            unsafe {
                if divide {
                    dgesdd_(
                        &job, &rows, &columns, a, &rows, s, u, &rows, vt, &inner, work, &length, iwork,
                        status,
                    );
                } else {
                    dgesvd_(
                        &job, &job, &rows, &columns, a, &rows, s, u, &rows, vt, &inner, work, &length, status,
                    );
                }
            }
        }
        assert_eq!(status, 0);
        (u, s, vt)
    };
    let result = run(true);
    assert_eq!(result, run(false));
    result
}

fn check_singular(a: &[f64], m: usize, n: usize) -> Vec<f64> {
    let thin = m.min(n);
    let (u, s, vt) = singular(a, m, n);
    assert!(s.windows(2).all(|w| w[0] >= w[1]) && s.iter().all(|&s| s >= 0.0));
    for (i, j) in (0..m).flat_map(|i| (0..n).map(move |j| (i, j))) {
        let product: f64 = (0..thin).map(|k| u[i + m * k] * s[k] * vt[k + thin * j]).sum();
        assert!((product - a[i + m * j]).abs() < 1e-13);
    }
    for (k, l) in (0..thin).flat_map(|k| (0..thin).map(move |l| (k, l))) {
        let left: f64 = (0..m).map(|i| u[i + m * k] * u[i + m * l]).sum();
        let right: f64 = (0..n).map(|j| vt[k + thin * j] * vt[l + thin * j]).sum();
        let unit = f64::from(u8::from(k == l));
        assert!((left - unit).abs() < 1e-13 && (right - unit).abs() < 1e-13, "orthonormal {k} {l}");
    }
    s
}

#[test]
fn singular_values_and_vectors() {
    for (m, n) in [(1, 1), (4, 4), (7, 4), (4, 7), (10, 10)] {
        check_singular(&numbers(m * n, (m + 31 * n) as u64), m, n);
    }
    // Rank one: the vectors of the vanishing values are still orthonormal.
    let (x, y) = (numbers(5, 20), numbers(4, 21));
    let outer: Vec<f64> = (0..20).map(|at| x[at % 5] * y[at / 5]).collect();
    assert!(check_singular(&outer, 5, 4)[1..].iter().all(|s| s.abs() < 1e-15));
    assert!(check_singular(&[0.0; 12], 3, 4).iter().all(|s| s.abs() < 1e-300));
}
