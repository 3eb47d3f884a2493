//! The paper's friction path (Gaz et al. 2019, section IV-B): with the rigid part frozen, the sigmoid of
//! eq. 25 is fitted, joint by joint, to what is left of the torque.

use argmin::core::{CostFunction, Executor, State};
use argmin::solver::neldermead::NelderMead;
use serde::{Deserialize, Serialize};

use crate::effects::{SigmoidParameters, logistic};

use super::levenberg::levenberg_marquardt;

/// How the three parameters are searched.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, Deserialize)]
pub enum Search {
    /// Simplex search, as the paper does.
    NelderMead,
    /// Levenberg-Marquardt with exact derivatives.
    #[default]
    Gradient,
}

/// Sigmoid friction of one joint, fitted.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SigmoidFit {
    /// Parameters.
    pub parameters: SigmoidParameters,
    /// Root mean square of what the rigid part leaves [N m].
    pub rms_without: f64,
    /// Root mean square with the sigmoid [N m].
    pub rms_with: f64,
    /// Evaluations of the sum of squares.
    pub evaluations: usize,
}

impl SigmoidFit {
    /// How well known parameters fit pairs of velocity [rad/s] and remaining torque [N m].
    pub fn of(parameters: SigmoidParameters, velocity: &[f64], torque: &[f64]) -> Self {
        let data = Data { velocity, torque };
        let none = SigmoidParameters { phi1: 0.0, ..parameters };
        let rms = |p: &SigmoidParameters| data.mean_square(p).sqrt();
        Self { parameters, rms_without: rms(&none), rms_with: rms(&parameters), evaluations: 0 }
    }
}

/// Steepest sigmoid that is looked for [s/rad]; steeper ones are a sign function at any sampled speed.
pub(crate) const STEEPEST: f64 = 1e4;
/// Starting steepness and shift, in the spread of the published values (Table I of the supplement).
const STARTS: [(f64, f64); 6] =
    [(5.0, 0.0), (20.0, 0.02), (20.0, -0.02), (60.0, 0.0), (150.0, 0.0), (2.0, 0.1)];

/// Points that the search from every start looks at; only the best start is refined on all of them.
const SURVEY: usize = 2000;

/// Fits eq. 25 to pairs of velocity [rad/s] and remaining torque [N m], from several starts; the best wins.
///
/// All starts are searched on an evenly thinned set of pairs, which at the sampling rates of robot logs
/// says nearly as much as all of them; the best is then searched again on all pairs.
pub fn fit_sigmoid(velocity: &[f64], torque: &[f64], search: Search) -> SigmoidFit {
    let data = Data { velocity, torque };
    let every = (velocity.len() / SURVEY).max(1);
    let thin = |x: &[f64]| -> Vec<f64> { x.iter().step_by(every).copied().collect() };
    let (few_velocities, few_torques) = (thin(velocity), thin(torque));
    let survey = Data { velocity: &few_velocities, torque: &few_torques };
    let zero = SigmoidParameters { phi1: 0.0, phi2: 1.0, phi3: 0.0 };
    let mut best = (survey.mean_square(&zero), zero);
    let mut evaluations = 0;
    let mut descend = |data: &Data<'_>, start: SigmoidParameters| {
        let (found, count) = match search {
            Search::NelderMead => nelder_mead(data, start),
            Search::Gradient => gradient(data, start),
        };
        evaluations += count;
        (data.mean_square(&found), found)
    };
    for (phi2, phi3) in STARTS {
        let found = descend(&survey, survey.with_best_amplitude(phi2, phi3));
        if found.0 < best.0 {
            best = found;
        }
    }
    let start = (data.mean_square(&best.1), best.1);
    let (mean_square, parameters) =
        if best.1.phi1.abs() > 0.0 { better(descend(&data, best.1), start) } else { start };
    SigmoidFit {
        parameters: upright(parameters),
        rms_without: data.mean_square(&zero).sqrt(),
        rms_with: mean_square.sqrt(),
        evaluations,
    }
}

fn better(a: (f64, SigmoidParameters), b: (f64, SigmoidParameters)) -> (f64, SigmoidParameters) {
    if a.0 <= b.0 { a } else { b }
}

/// Eq. 25 is unchanged when amplitude and steepness change sign together; the positive one is reported.
fn upright(p: SigmoidParameters) -> SigmoidParameters {
    if p.phi2 < 0.0 { SigmoidParameters { phi1: -p.phi1, phi2: -p.phi2, phi3: p.phi3 } } else { p }
}

struct Data<'a> {
    velocity: &'a [f64],
    torque: &'a [f64],
}

impl Data<'_> {
    fn mean_square(&self, p: &SigmoidParameters) -> f64 {
        let at_rest = logistic(p.phi2 * p.phi3);
        let squares = self.velocity.iter().zip(self.torque).map(|(&v, &t)| {
            let r = t - p.phi1 * (logistic(p.phi2 * (v + p.phi3)) - at_rest);
            r * r
        });
        squares.sum::<f64>() / self.velocity.len().max(1) as f64
    }

    /// The amplitude is linear, so every start begins with its best value.
    fn with_best_amplitude(&self, phi2: f64, phi3: f64) -> SigmoidParameters {
        let unit = SigmoidParameters { phi1: 1.0, phi2, phi3 };
        let (mut up, mut down) = (0.0, 0.0);
        for (&v, &t) in self.velocity.iter().zip(self.torque) {
            let s = unit.shape(v);
            up += s * t;
            down += s * s;
        }
        SigmoidParameters { phi1: if down > 0.0 { up / down } else { 0.0 }, phi2, phi3 }
    }
}

/// Searched as (phi1, ln phi2, phi3), so that steepness stays positive and its scale does not matter.
fn unpack(x: &[f64]) -> SigmoidParameters {
    SigmoidParameters { phi1: x[0], phi2: libm::exp(x[1]).min(STEEPEST), phi3: x[2] }
}

impl CostFunction for &Data<'_> {
    type Param = Vec<f64>;
    type Output = f64;

    fn cost(&self, x: &Vec<f64>) -> Result<f64, argmin::core::Error> {
        // A finite number however wild the step: the simplex hangs on infinite costs.
        Ok(self.mean_square(&unpack(x)).min(1e300))
    }
}

fn nelder_mead(data: &Data<'_>, start: SigmoidParameters) -> (SigmoidParameters, usize) {
    let mut center = vec![start.phi1, libm::log(start.phi2), start.phi3];
    let mut evaluations = 0;
    // Restarted from its own result: a simplex that has collapsed too early gets out again.
    for _ in 0..3 {
        let steps = [0.1 * center[0].abs().max(0.1), 0.3, 0.02];
        let mut simplex = vec![center.clone()];
        for (i, step) in steps.into_iter().enumerate() {
            let mut corner = center.clone();
            corner[i] += step;
            simplex.push(corner);
        }
        // The spread of the costs is judged against their size; an exact fit goes on until it stalls.
        let tolerance = 1e-10 * data.mean_square(&unpack(&center));
        let Ok(solver) = NelderMead::new(simplex).with_sd_tolerance(tolerance) else { break };
        let before = data.mean_square(&unpack(&center));
        let run = Executor::new(data, solver).configure(|s| s.max_iters(400)).timer(false).run();
        let Ok(result) = run else { break };
        let state = result.state();
        evaluations += state.get_func_counts().get("cost_count").copied().unwrap_or(0) as usize;
        if let Some(found) = state.get_best_param() {
            center.clone_from(found);
        }
        if data.mean_square(&unpack(&center)) > before * (1.0 - 1e-9) {
            break;
        }
    }
    (unpack(&center), evaluations)
}

fn gradient(data: &Data<'_>, start: SigmoidParameters) -> (SigmoidParameters, usize) {
    let x = [start.phi1, libm::log(start.phi2), start.phi3];
    let (found, evaluations) = levenberg_marquardt(x, |x, rows| {
        let p = unpack(x);
        let b = logistic(p.phi2 * p.phi3);
        let db = b * (1.0 - b);
        for (&v, &t) in data.velocity.iter().zip(data.torque) {
            let a = logistic(p.phi2 * (v + p.phi3));
            let da = a * (1.0 - a);
            let slope2 = p.phi1 * (da * (v + p.phi3) - db * p.phi3) * p.phi2;
            let slope3 = p.phi1 * p.phi2 * (da - db);
            rows([a - b, slope2, slope3], t - p.phi1 * (a - b));
        }
    });
    (unpack(&found), evaluations)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Table I of the supplement to Gaz et al. 2019 (revised version): phi1, phi2, phi3 of joints 1 to 7.
    const TABLE_I: [[f64; 3]; 7] = [
        [0.54615, 5.1181, 0.039533],
        [0.87224, 9.0657, 0.025882],
        [0.64068, 10.136, -0.046070],
        [1.2794, 5.5903, 0.036194],
        [0.83904, 8.3469, 0.026226],
        [0.30301, 17.133, -0.021047],
        [0.56489, 10.336, 0.0035526],
    ];

    fn recovered(search: Search, tolerance: f64) {
        let velocity: Vec<f64> = (0..4000).map(|k| libm::sin(0.01 * f64::from(k)) * 1.1).collect();
        for [phi1, phi2, phi3] in TABLE_I {
            let truth = SigmoidParameters { phi1, phi2, phi3 };
            let torque: Vec<f64> = velocity
                .iter()
                .map(|&v| phi1 / (1.0 + (-phi2 * (v + phi3)).exp()) - phi1 / (1.0 + (-phi2 * phi3).exp()))
                .collect();
            let found = fit_sigmoid(&velocity, &torque, search).parameters;
            for (a, b) in [(found.phi1, truth.phi1), (found.phi2, truth.phi2), (found.phi3, truth.phi3)] {
                assert!((a - b).abs() <= tolerance * b.abs(), "{search:?}: {found:?} against {truth:?}");
            }
        }
    }

    #[test]
    fn published_friction_comes_back_by_gradient() {
        recovered(Search::Gradient, 1e-9);
    }

    #[test]
    fn published_friction_comes_back_by_simplex() {
        recovered(Search::NelderMead, 1e-6);
    }

    #[test]
    fn no_friction_gives_no_amplitude() {
        let velocity: Vec<f64> = (0..100).map(|k| f64::from(k) * 0.01 - 0.5).collect();
        let fit = fit_sigmoid(&velocity, &vec![0.0; 100], Search::Gradient);
        assert!(fit.rms_with < 1e-12 && fit.rms_without < 1e-12);
    }
}
