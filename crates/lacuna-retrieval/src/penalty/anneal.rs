//! Simulated annealing by coordinate moves whose widths adapt themselves (after Corana et al. 1987).

use super::walk::Walk;
use crate::space::Parameter;
use lacuna_base::random::Stream;

/// Moves at one temperature; also how often the caller is asked whether to stop.
const BLOCK: usize = 256;
/// A width grows by this when a move is taken and shrinks by [`SHRINK`] when not; they balance where about
/// 30 % of the moves are taken.
const GROW: f64 = 1.25;
const SHRINK: f64 = 0.91;
/// Least width, relative to the distance of the bounds.
const FINEST: f64 = 1e-8;

/// Temperatures, in units of the objective, and number of proposals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Schedule {
    /// Temperature at the start.
    pub hot: f64,
    /// Temperature at the end.
    pub cold: f64,
    /// Moves tried.
    pub proposals: usize,
}

/// Anneals a point within bounds; `stop` is asked now and then. Returns the number of moves tried.
pub fn anneal(
    walk: &mut Walk<'_>,
    bounds: &[Parameter],
    schedule: Schedule,
    stream: &mut Stream,
    stop: &dyn Fn() -> bool,
) -> u64 {
    let free: Vec<usize> = (0..bounds.len()).filter(|&c| bounds[c].upper > bounds[c].lower).collect();
    let reach: Vec<f64> = bounds.iter().map(|b| b.upper - b.lower).collect();
    let mut widths: Vec<f64> = reach.iter().map(|w| 0.25 * w).collect();
    let blocks = schedule.proposals.div_ceil(BLOCK);
    if free.is_empty() || blocks == 0 {
        return 0;
    }
    let fall = libm::pow(schedule.cold / schedule.hot, 1.0 / blocks as f64);
    let mut temperature = schedule.hot;
    for block in 0..blocks {
        for _ in 0..BLOCK {
            let c = free[(stream.uniform() * free.len() as f64) as usize];
            let u = stream.between(-1.0, 1.0);
            let value = reflect(walk.coordinates()[c] + widths[c] * u, bounds[c].lower, bounds[c].upper);
            // Metropolis turned round: the draw says how much worse a move may be.
            let worse = -temperature * libm::log(1.0 - stream.uniform());
            let taken = walk.try_move(c, value, walk.value() + worse);
            let factor = if taken { GROW } else { SHRINK };
            widths[c] = (widths[c] * factor).clamp(FINEST * reach[c], reach[c]);
        }
        temperature *= fall;
        if stop() {
            return ((block + 1) * BLOCK) as u64;
        }
    }
    (blocks * BLOCK) as u64
}

/// Folds a value that has left its bounds by less than their distance back inside.
fn reflect(value: f64, lower: f64, upper: f64) -> f64 {
    let folded = if value < lower {
        2.0 * lower - value
    } else if value > upper {
        2.0 * upper - value
    } else {
        value
    };
    folded.clamp(lower, upper)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::penalty::walk::Ground;
    use crate::penalty::{PenaltyForm, testing};

    #[test]
    fn finds_the_nearest_point_of_a_disc() {
        let problem = testing::disc();
        let ground = Ground::new(&problem);
        let bounds = &problem.chart.space().parameters;
        let mut stream = Stream::new(1, 0);
        let mut walk = Walk::new(&ground, PenaltyForm::Linear, 20.0, vec![-1.0, 0.3, 1.5]);
        let schedule = Schedule { hot: 1.0, cold: 1e-9, proposals: 40_000 };
        anneal(&mut walk, bounds, schedule, &mut stream, &|| false);
        // On z = x² with x y = 1/4: checked against a fine grid over x and y.
        let mut best = f64::INFINITY;
        for i in 0..=2000 {
            for j in 0..=2000 {
                let (x, y) = (f64::from(i) * 1e-3 - 1.0, f64::from(j) * 1e-3 - 1.0);
                if x * x + y * y <= 1.0 && x + y <= 1.2 && x * y <= 0.25 {
                    let z = x * x;
                    best = best.min((x - 2.0).powi(2) + (y - 1.0).powi(2) + (z + 1.0).powi(2));
                }
            }
        }
        // Moves along single coordinates creep where constraints meet; that is what the polish is for.
        assert!((walk.value() - best).abs() < 2e-2, "{} {best}", walk.value());
    }

    #[test]
    fn moves_stay_within_bounds() {
        assert!((reflect(1.2, -1.0, 1.0) - 0.8).abs() < 1e-12);
        assert!((reflect(-1.2, -1.0, 1.0) + 0.8).abs() < 1e-12);
        assert!((reflect(-9.0, -1.0, 1.0) - 1.0).abs() < 1e-12);
    }
}
