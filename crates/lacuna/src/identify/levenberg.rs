//! Levenberg-Marquardt for three unknowns and many residuals.

use nalgebra::{Matrix3, Vector3};

/// Damping is raised this often in a row before the search gives up.
const TRIES: usize = 30;
/// Steps at most.
const STEPS: usize = 300;

/// Minimises a sum of squares. `model(x, rows)` calls `rows(gradient, residual)` for every residual, where
/// `gradient` is that of the *prediction*. Returns the best point and the number of evaluations.
pub(super) fn levenberg_marquardt(
    start: [f64; 3],
    mut model: impl FnMut(&[f64; 3], &mut dyn FnMut([f64; 3], f64)),
) -> ([f64; 3], usize) {
    let mut evaluate = |x: &[f64; 3]| {
        let (mut normal, mut slope, mut squares) = (Matrix3::zeros(), Vector3::zeros(), 0.0);
        model(x, &mut |g, r| {
            let g = Vector3::from(g);
            normal += g * g.transpose();
            slope += g * r;
            squares += r * r;
        });
        (normal, slope, squares)
    };
    let mut x = start;
    let (mut normal, mut slope, mut squares) = evaluate(&x);
    let mut evaluations = 1;
    let mut damping = 1e-3;
    for _ in 0..STEPS {
        let mut better = false;
        for _ in 0..TRIES {
            let scale = Matrix3::from_diagonal(&normal.diagonal().map(|d| d.max(1e-30)));
            let Some(step) = (normal + scale * damping).lu().solve(&slope) else { break };
            let next = [x[0] + step.x, x[1] + step.y, x[2] + step.z];
            let trial = evaluate(&next);
            evaluations += 1;
            if trial.2 < squares {
                let small = (0..3).all(|i| (next[i] - x[i]).abs() <= 1e-14 * (1e-3 + x[i].abs()));
                (normal, slope, squares) = trial;
                x = next;
                damping = (damping * 0.2).max(1e-15);
                better = !small;
                break;
            }
            damping *= 5.0;
        }
        if !better {
            break;
        }
    }
    (x, evaluations)
}
