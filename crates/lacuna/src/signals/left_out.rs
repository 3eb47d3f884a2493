//! Rows that say nothing about the model of a joint. Where it stands still, friction is whatever holds it, up to its
//! largest, and the sign of its velocity is that of noise. Where its torque stays at a limit, it is not measured.

use super::RowFilter;

/// Positions are averaged over this time before their range is taken \[s\].
const BIN_S: f64 = 0.01;
/// A joint stands when it stays within the range below for this long \[s\].
const WINDOW_S: f64 = 0.2;
/// Range of a standing joint: so many times the noise of its averaged positions, but within these limits [rad, m].
/// The highest is 3 mrad/s over the window: slower is creeping.
const OF_NOISE: f64 = 6.0;
const RANGE: (f64, f64) = (2e-4, 6e-4);
/// A joint that stands for more than this part of a run does not move in it.
const ALL: f64 = 0.9;
/// Part of a row's filter window at rest from which on the row counts as standing.
const TOUCHED: f64 = 0.1;

/// A torque is at a limit when it has its largest or smallest value in this part of the samples at least,
const OFTEN: f64 = 0.01;
/// and so many times as often as the value next to it: the top of a coarse but smooth curve has not.
const BEYOND_NEXT: usize = 8;

/// Rows of one joint that are of no use; empty when there are none.
pub(super) fn unusable(q: &[f64], tau: &[f64], dt: f64, rows: &RowFilter) -> Vec<bool> {
    let (still, limited) = (standing(q, dt), at_limit(tau));
    if still.is_empty() && limited.is_empty() {
        return Vec::new();
    }
    let is = |flags: &[bool], k: usize| flags.get(k).copied().unwrap_or(false);
    let share: Vec<f64> =
        (0..q.len()).map(|k| if is(&still, k) || is(&limited, k) { 1.0 } else { 0.0 }).collect();
    rows.apply(&share).into_iter().map(|share| share > TOUCHED).collect()
}

/// Samples at which a joint stands; empty when it never does, or always.
fn standing(q: &[f64], dt: f64) -> Vec<bool> {
    let per_bin = ((BIN_S / dt) as usize).max(1);
    let bins: Vec<f64> = q.chunks(per_bin).map(|bin| bin.iter().sum::<f64>() / bin.len() as f64).collect();
    let window = (libm::round(WINDOW_S / (per_bin as f64 * dt)) as usize).max(3);
    let range = (OF_NOISE * noise(&bins)).clamp(RANGE.0, RANGE.1);
    let mut still = vec![false; bins.len()];
    for first in 0..(bins.len() + 1).saturating_sub(window) {
        let part = first..first + window;
        let (low, high) = super::extremes(&bins[part.clone()]);
        if high - low < range {
            still[part].fill(true);
        }
    }
    let count = still.iter().filter(|s| **s).count();
    if count == 0 || count as f64 > ALL * still.len() as f64 {
        return Vec::new();
    }
    (0..q.len()).map(|k| still[k / per_bin]).collect()
}

/// Samples at which a torque stays at a limit, as a saturated drive or sensor makes it; empty when there is none.
pub(crate) fn at_limit(tau: &[f64]) -> Vec<bool> {
    let (low, high) = super::extremes(tau);
    let mut all = Vec::new();
    for limit in [low, high] {
        let at = |x: f64| (x - limit).abs() <= 0.0;
        let count = tau.iter().filter(|x| at(**x)).count();
        let next = tau
            .iter()
            .copied()
            .filter(|x| !at(*x))
            .min_by(|a, b| (a - limit).abs().total_cmp(&(b - limit).abs()));
        let Some(next) = next else { return Vec::new() };
        let beside = tau.iter().filter(|x| (**x - next).abs() <= 0.0).count();
        if count as f64 >= OFTEN * tau.len() as f64 && count >= BEYOND_NEXT * beside {
            all.resize(tau.len(), false);
            all.iter_mut().zip(tau).filter(|(_, x)| at(**x)).for_each(|(flag, _)| *flag = true);
        }
    }
    all
}

/// Standard deviation of white noise on a smooth series, from the median of its second differences.
fn noise(x: &[f64]) -> f64 {
    let second = x.windows(3).map(|w| (w[2] - 2.0 * w[1] + w[0]).abs()).collect();
    // A normal variate's median is 0.6745 of its deviation; the second difference has the root of six times that.
    super::median(second).unwrap_or(0.0) / (0.6745 * 6.0_f64.sqrt())
}

#[cfg(test)]
mod tests {
    use super::{at_limit, unusable};
    use crate::signals::{RowFilter, ZeroPhase};

    const DT: f64 = 0.002;

    fn rows(samples: usize) -> RowFilter {
        let filter = ZeroPhase::butterworth(4, 8.0, DT).expect("a filter");
        RowFilter { filter, range: 0..samples, every: 1 }
    }

    /// A move from 2 s to 4 s of 6 s.
    fn moved(t: f64) -> f64 {
        let s = ((t - 2.0) / 2.0).clamp(0.0, 1.0);
        0.8 * (s - libm::sin(std::f64::consts::TAU * s) / std::f64::consts::TAU)
    }

    #[test]
    fn a_dwell_is_found_with_noise_and_without() {
        for noise in [0.0, 5e-5] {
            let q: Vec<f64> =
                (0..3000).map(|k| moved(k as f64 * DT) + noise * libm::sin(k as f64 * 77.7)).collect();
            let found = unusable(&q, &[], DT, &rows(3000));
            let part = |from: usize, to: usize| found[from..to].iter().filter(|s| **s).count();
            assert_eq!(part(0, 950), 950);
            assert_eq!(part(2050, 3000), 950);
            assert_eq!(part(1200, 1800), 0);
        }
    }

    #[test]
    fn turning_round_is_not_standing_and_never_moving_leaves_nothing_out() {
        let waves: Vec<f64> = (0..3000).map(|k| 0.3 * libm::sin(k as f64 * DT)).collect();
        assert!(unusable(&waves, &[], DT, &rows(3000)).iter().filter(|s| **s).count() < 10);
        assert!(unusable(&[0.7; 3000], &[], DT, &rows(3000)).is_empty());
    }

    #[test]
    fn a_torque_at_a_limit_is_no_measurement_but_a_coarse_one_is() {
        let smooth = |k: usize| 5.0 * libm::sin(k as f64 * 0.004) + 2.0 * libm::sin(k as f64 * 0.011);
        let clipped: Vec<f64> = (0..3000).map(|k| smooth(k).clamp(-6.0, 4.0)).collect();
        let found = at_limit(&clipped);
        assert!((0..3000).all(|k| found[k] != (-6.0..4.0).contains(&smooth(k))));
        let coarse: Vec<f64> = (0..3000).map(|k| libm::round(smooth(k) / 0.2) * 0.2).collect();
        assert!(at_limit(&coarse).is_empty());
        assert!(at_limit(&[1.0; 100]).is_empty() && at_limit(&[]).is_empty());
    }
}
