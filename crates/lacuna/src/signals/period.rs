//! Does a motion repeat?

use super::Run;

/// Coarse step of the search \[s\].
const STEP: f64 = 0.02;
/// Longest period looked for \[s\].
const LONGEST: f64 = 200.0;
/// Largest share of the motion that may differ from one period to the next (squared).
const SAME: f64 = 0.01;
/// Share that must differ in between: the motion has to go somewhere first.
const APART: f64 = 0.3;

/// Period of the motion \[s\], where the log shows at least 1.3 of it; `None` for a motion that does
/// not repeat (or after more than 200 s).
///
/// The measure is the normalised squared difference of the positions of all joints with themselves
/// one lag later (one minus their autocorrelation; A. de Cheveigné and H. Kawahara, "YIN", J. Acoust.
/// Soc. Am. 111, 2002): a period is a lag where it falls below one per cent after having been large.
pub fn detect_period(run: &Run) -> Option<f64> {
    let motion = Positions::new(run)?;
    let coarse = (libm::round(STEP / run.dt) as usize).max(1);
    let longest = ((motion.len as f64 / 1.3) as usize).min((LONGEST / run.dt) as usize);
    let lags: Vec<usize> = (coarse..=longest).step_by(coarse).collect();
    let difference: Vec<f64> = lags.iter().map(|&lag| motion.difference(lag, 500)).collect();
    let apart = difference.iter().position(|&d| d > APART)?;
    let smallest = difference[apart..].iter().copied().fold(f64::INFINITY, f64::min);
    // Multiples of the period are as good as it is: take the first dip that is nearly the deepest.
    let enough = (4.0 * smallest + 1e-4).min(SAME);
    let inside = apart + difference[apart..].iter().position(|&d| d <= enough)?;
    let dip = (inside..lags.len()).take_while(|&i| difference[i] <= 2.0 * enough);
    let best = dip.min_by(|&a, &b| difference[a].total_cmp(&difference[b]))?;
    // A dip that is still falling at the longest lag is none yet.
    (best + 1 < lags.len()).then(|| motion.refined(lags[best], coarse) * run.dt)
}

/// Positions of the joints that move, with the inverse variance of each.
struct Positions<'a> {
    joints: Vec<(&'a [f64], f64)>,
    len: usize,
}

impl<'a> Positions<'a> {
    fn new(run: &'a Run) -> Option<Self> {
        let range = run.row_filter.as_ref().map_or(0..run.samples(), |rows| rows.range.clone());
        let joint = |q: &'a Vec<f64>| {
            let q = q.get(range.clone())?;
            let mean = q.iter().sum::<f64>() / q.len() as f64;
            let variance = q.iter().map(|x| (x - mean) * (x - mean)).sum::<f64>() / q.len() as f64;
            (variance > 1e-6).then_some((q, 1.0 / variance))
        };
        let joints: Vec<_> = run.q.iter().filter_map(joint).collect();
        (!joints.is_empty() && range.len() > 10).then_some(Self { joints, len: range.len() })
    }

    /// Squared difference to itself `lag` samples later, as a share of the variance on both sides;
    /// judged at about `points` places. One where too little moves to judge.
    fn difference(&self, lag: usize, points: usize) -> f64 {
        let overlap = self.len.saturating_sub(lag);
        let stride = (overlap / points).max(1);
        let (mut apart, mut spread, mut places) = (0.0, 0.0, 0.0);
        for &(q, weight) in &self.joints {
            let (mut square, mut sums, mut squares, mut n) = (0.0, [0.0; 2], 0.0, 0.0);
            for k in (0..overlap).step_by(stride) {
                let (a, b) = (q[k], q[k + lag]);
                square += (b - a) * (b - a);
                sums = [sums[0] + a, sums[1] + b];
                squares += a * a + b * b;
                n += 1.0;
            }
            apart += weight * square;
            spread += weight * (squares - (sums[0] * sums[0] + sums[1] * sums[1]) / n);
            places += 2.0 * n;
        }
        if spread > 0.1 * places { apart / spread } else { 1.0 }
    }

    /// The lag \[samples\] of the smallest difference near `lag`, by a parabola through it.
    fn refined(&self, lag: usize, reach: usize) -> f64 {
        let longest = self.len.saturating_sub(2);
        let near: Vec<usize> = (lag.saturating_sub(reach).max(1)..=(lag + reach).min(longest)).collect();
        let d: Vec<f64> = near.iter().map(|&l| self.difference(l, 4000)).collect();
        let best = (0..d.len()).min_by(|&a, &b| d[a].total_cmp(&d[b])).unwrap_or(0);
        let centre = near.get(best).map_or(lag as f64, |&l| l as f64);
        if best == 0 || best + 1 >= d.len() {
            return centre;
        }
        let curvature = d[best - 1] - 2.0 * d[best] + d[best + 1];
        if curvature > 0.0 { centre + 0.5 * (d[best - 1] - d[best + 1]) / curvature } else { centre }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn run(seconds: f64, motion: impl Fn(usize, f64) -> f64) -> Run {
        let dt = 0.004;
        let times: Vec<f64> = (0..(seconds / dt) as usize).map(|k| k as f64 * dt).collect();
        let q = (0..3).map(|j| times.iter().map(|&t| motion(j, t)).collect()).collect();
        Run { dt, q, ..Run::default() }
    }

    fn fourier(j: usize, t: f64, period: f64) -> f64 {
        (1..=4).map(|l| libm::sin((l * (j + 2)) as f64 + std::f64::consts::TAU * l as f64 * t / period)).sum()
    }

    #[test]
    fn finds_the_period_when_a_third_of_it_repeats() {
        let period = detect_period(&run(14.0, |j, t| fourier(j, t, 10.0))).expect("it repeats");
        assert!((period - 10.0).abs() < 1e-3, "{period}");
        assert_eq!(detect_period(&run(12.0, |j, t| fourier(j, t, 10.0))), None);
    }

    #[test]
    fn of_several_periods_it_takes_one() {
        let period = detect_period(&run(47.0, |j, t| fourier(j, t, 3.7))).expect("it repeats");
        assert!((period - 3.7).abs() < 1e-3, "{period}");
    }

    #[test]
    fn a_motion_that_does_not_repeat_has_none() {
        let chirp = run(30.0, |j, t| libm::sin((0.4 + 0.03 * t) * t + j as f64));
        assert_eq!(detect_period(&chirp), None);
        let tones = run(30.0, |j, t| {
            libm::sin(1.3 * t + j as f64) + libm::sin(1.3 * 1.618_034 * t) + libm::sin(1.3 * 2.62 * t)
        });
        assert_eq!(detect_period(&tones), None);
        assert_eq!(detect_period(&run(30.0, |j, t| (j as f64 + 1.0) * 0.1 * t)), None);
        assert_eq!(detect_period(&run(30.0, |_, _| 0.5)), None);
        assert_eq!(detect_period(&Run::default()), None);
    }
}
