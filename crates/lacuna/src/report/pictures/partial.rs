//! Partial residuals: what an effect is seen in. The effect's own torque is put back onto the residual of the
//! whole model and both are drawn against a variable; the points follow the curve where the effect is right
//! and leave it where its shape is wrong (R. D. Cook, "Exploring partial residual plots", Technometrics 35,
//! 1993).

/// Stretches of a variable at most.
const BINS: usize = 40;
/// Rows of a stretch at least.
const LEAST_ROWS: usize = 12;
/// The spread is drawn from this part of the rows to the opposite one.
const SPREAD: f64 = 0.1;

/// Partial residual of an effect on one joint against one variable.
#[derive(Debug, Clone, PartialEq)]
pub struct Partial {
    /// Variable (`q3`, `dq3`, `ddq3`, `load`, `time`, or the name of a channel).
    pub variable: String,
    /// Unit of the variable; empty for a channel, whose unit the log does not say.
    pub unit: String,
    /// From the smallest value of the variable to the largest, each with equally many rows.
    pub bins: Vec<Bin>,
}

/// The rows with neighbouring values of a variable.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bin {
    /// Mean of the variable.
    pub at: f64,
    /// Mean of residual plus effect [N m, N].
    pub mean: f64,
    /// A tenth of the rows lies below.
    pub low: f64,
    /// A tenth of the rows lies above.
    pub high: f64,
    /// Mean of the effect alone: the fitted curve [N m, N].
    pub curve: f64,
    /// Number of rows.
    pub rows: usize,
}

/// Sorts rows by `variable` into stretches of equally many and sums up `residual + effect` in each.
pub fn binned(variable: &[f64], residual: &[f64], effect: &[f64]) -> Vec<Bin> {
    let mut order: Vec<usize> = (0..variable.len()).filter(|&k| variable[k].is_finite()).collect();
    order.sort_by(|&a, &b| variable[a].total_cmp(&variable[b]).then(a.cmp(&b)));
    let count = (order.len() / LEAST_ROWS).clamp(1, BINS);
    let edge = |k: usize| k * order.len() / count;
    let bin = |k: usize| {
        let rows = &order[edge(k)..edge(k + 1)];
        let mut put_back: Vec<f64> = rows.iter().map(|&k| residual[k] + effect[k]).collect();
        put_back.sort_by(f64::total_cmp);
        let mean = |of: &dyn Fn(usize) -> f64| rows.iter().map(|&k| of(k)).sum::<f64>() / rows.len() as f64;
        let at = |part: f64| put_back[(part * (put_back.len() - 1) as f64) as usize];
        Bin {
            at: mean(&|k| variable[k]),
            mean: mean(&|k| residual[k] + effect[k]),
            low: at(SPREAD),
            high: at(1.0 - SPREAD),
            curve: mean(&|k| effect[k]),
            rows: rows.len(),
        }
    };
    (0..count).filter(|&k| edge(k + 1) > edge(k)).map(bin).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn noise(k: usize) -> f64 {
        libm::sin(12.9898 * k as f64 * k as f64)
    }

    #[test]
    fn a_right_effect_runs_through_its_points_and_a_wrong_one_does_not() {
        let x: Vec<f64> = (0..4000).map(|k| libm::sin(0.01 * k as f64)).collect();
        let truth: Vec<f64> = x.iter().map(|x| 2.0 * x * x.abs()).collect();
        let wrong: Vec<f64> = x.iter().map(|x| 1.6 * x).collect();
        let right: Vec<f64> = (0..x.len()).map(|k| 0.1 * noise(k)).collect();
        let bins = binned(&x, &right, &truth);
        assert_eq!(bins.len(), 40);
        assert!(bins.windows(2).all(|w| w[0].at < w[1].at));
        assert!(bins.iter().all(|b| (b.mean - b.curve).abs() < 0.04), "{bins:?}");
        assert!(bins.iter().all(|b| b.low <= b.mean && b.mean <= b.high));
        // With a straight line instead, the points still show the true shape.
        let left: Vec<f64> = truth.iter().zip(&wrong).map(|(a, b)| a - b).collect();
        let bins = binned(&x, &left, &wrong);
        let off = bins.iter().map(|b| (b.mean - b.curve).abs()).fold(0.0, f64::max);
        assert!(off > 0.2, "{off}");
        assert!(bins.iter().all(|b| (b.mean - 2.0 * b.at * b.at.abs()).abs() < 0.05));
    }

    #[test]
    fn every_row_is_counted_once_and_rows_without_a_value_never() {
        let mut x: Vec<f64> = (0..1003).map(noise).collect();
        x[7] = f64::NAN;
        let zero = vec![0.0; x.len()];
        let bins = binned(&x, &zero, &zero);
        assert_eq!(bins.iter().map(|b| b.rows).sum::<usize>(), 1002);
        assert!(binned(&[], &[], &[]).is_empty());
    }
}
