//! The least eigenvalue of a small symmetric matrix, for the many violations that a search measures.

/// Least eigenvalue of the `n x n` matrix whose lower triangle stands in `a` by rows; destroys `a`.
pub(super) fn least_eigenvalue(a: &mut [f64], n: usize, room: &mut Vec<f64>) -> f64 {
    room.clear();
    room.resize(4 * n, 0.0);
    let (diagonal, rest) = room.split_at_mut(n);
    let (beside, vectors) = rest.split_at_mut(n);
    tridiagonal(a, n, diagonal, beside, vectors);
    if !ql(diagonal, beside) {
        return f64::NAN;
    }
    diagonal.iter().copied().fold(f64::INFINITY, f64::min)
}

/// Householder's reduction from the last row up (Golub and Van Loan, algorithm 8.3.1, mirrored); `beside[i]`
/// couples `i` and `i - 1`.
fn tridiagonal(a: &mut [f64], n: usize, diagonal: &mut [f64], beside: &mut [f64], vectors: &mut [f64]) {
    let (u, v) = vectors.split_at_mut(n);
    for i in (1..n).rev() {
        let row = &a[i * n..i * n + i];
        let square: f64 = row.iter().map(|x| x * x).sum();
        let last = row[i - 1];
        let alpha = if last > 0.0 { -square.sqrt() } else { square.sqrt() };
        beside[i] = alpha;
        let half = square - alpha * last;
        if i == 1 || half <= 0.0 {
            beside[i] = last;
            continue;
        }
        // The reflection 1 - u uᵀ / half, with u = row - alpha e.
        let u = &mut u[..i];
        u.copy_from_slice(row);
        u[i - 1] -= alpha;
        for (r, slot) in v[..i].iter_mut().enumerate() {
            *slot = (0..i).map(|c| a[r.max(c) * n + r.min(c)] * u[c]).sum::<f64>() / half;
        }
        let share = v[..i].iter().zip(u.iter()).map(|(x, y)| x * y).sum::<f64>() / (2.0 * half);
        v[..i].iter_mut().zip(u.iter()).for_each(|(x, y)| *x -= share * y);
        for r in 0..i {
            for c in 0..=r {
                a[r * n + c] -= v[r] * u[c] + u[r] * v[c];
            }
        }
    }
    (0..n).for_each(|i| diagonal[i] = a[i * n + i]);
}

/// Implicit QL steps (Golub and Van Loan, section 8.3.3; Bowdler et al. 1968): `d` becomes the eigenvalues.
/// `false` when it does not converge, as with entries that are not numbers.
fn ql(d: &mut [f64], e: &mut [f64]) -> bool {
    let n = d.len();
    e.rotate_left(1);
    for l in 0..n {
        for _ in 0..60 {
            let small = |m: &usize| e[*m].abs() <= f64::EPSILON * (d[*m].abs() + d[*m + 1].abs());
            let m = (l..n - 1).find(small).unwrap_or(n - 1);
            if m == l {
                break;
            }
            sweep(d, e, l, m);
        }
    }
    d.iter().all(|v| v.is_finite())
}

fn sweep(d: &mut [f64], e: &mut [f64], l: usize, m: usize) {
    let mut g = (d[l + 1] - d[l]) / (2.0 * e[l]);
    let r = (g * g + 1.0).sqrt();
    g = d[m] - d[l] + e[l] / (g + if g < 0.0 { -r } else { r });
    let (mut s, mut c, mut p) = (1.0, 1.0, 0.0);
    for i in (l..m).rev() {
        let (f, b) = (s * e[i], c * e[i]);
        let r = (f * f + g * g).sqrt();
        e[i + 1] = r;
        if r <= 0.0 {
            d[i + 1] -= p;
            e[m] = 0.0;
            return;
        }
        (s, c) = (f / r, g / r);
        g = d[i + 1] - p;
        let r = (d[i] - g) * s + 2.0 * c * b;
        p = s * r;
        d[i + 1] = g + p;
        g = c * r - b;
    }
    d[l] -= p;
    e[l] = g;
    e[m] = 0.0;
}

#[cfg(test)]
mod tests {
    use super::*;
    use lacuna_base::random::Stream;
    use nalgebra::DMatrix;

    #[test]
    fn agrees_with_a_full_decomposition() {
        let mut stream = Stream::new(11, 0);
        let mut room = Vec::new();
        for case in 0..400 {
            let n = 1 + case % 20;
            let mut full = DMatrix::from_fn(n, n, |_, _| stream.normal());
            full = &full + full.transpose();
            if case % 3 == 0 {
                // Rank one: repeated eigenvalues.
                let v = full.column(0).into_owned();
                full = &v * v.transpose();
            }
            let mut a: Vec<f64> = (0..n * n).map(|k| full[(k / n, k % n)]).collect();
            let found = least_eigenvalue(&mut a, n, &mut room);
            let truth = full.symmetric_eigenvalues().min();
            assert!((found - truth).abs() < 1e-12 * (1.0 + full.norm()), "{n}: {found} {truth}");
        }
        assert!(least_eigenvalue(&mut [f64::NAN, 0.0, 1.0, 1.0], 2, &mut room).is_nan());
    }
}
