//! Identification from static poses.

use crate::effects::RigidBody;
use crate::error::{Error, Result};
use crate::excitation::random_configurations;
use crate::identify::{BaseParameters, StaticFit, parameter_name, relative_deviations};
use crate::kernels::{Chain, static_regressor};
use crate::linalg::product;
use crate::log::StaticPoses;
use crate::model::Model;
use crate::model_file::ModelFile;
use crate::random::Stream;
use crate::report::{Coefficient, DropCounts, Identification, finite};
use crate::robot::PARAMETER_UNITS;
use crate::scenario::{Poses, Published, find_poses};

use super::{Study, published, too_few_rows};

/// Noise is drawn this often to see which coefficients are dropped by chance.
const DRAWS: usize = 200;
/// Most entries of mass matrices and gravity torques that are read out.
const MOST_READ: usize = 10_000_000;
/// Random streams of the seed; the first few belong to the configurations, one per joint.
const NOISE_STREAM: usize = 1000;
const DRAW_STREAM: usize = 1001;

/// What the poses gave.
pub(super) struct FromPoses {
    pub report: Identification,
    pub model: ModelFile,
    /// Values used for the frozen rigid part: dropped coefficients are 0.
    pub coefficients: Vec<f64>,
}

impl Study<'_> {
    pub(super) fn identify_from_poses(&mut self) -> Result<Option<FromPoses>> {
        let (poses, published, noise, read_from) = match &self.scenario.poses {
            None => return Ok(None),
            Some(Poses::File(file)) => {
                let path = find_poses(&self.folder, file)?;
                (StaticPoses::open(&path, &self.robot)?, None, None, Some(path))
            }
            Some(Poses::ReadOut { coefficients, count, noise_percent }) => {
                let (file, count, percent) = (coefficients.clone(), *count, *noise_percent);
                self.say(&format!("reading out M and g at {count} random configurations"));
                let base = BaseParameters::new(&self.robot);
                let (published, values) = published(&self.folder, &file, &base)?;
                let read = (self.robot.dof() * (self.robot.dof() + 3)) / 2 * count;
                if read > MOST_READ {
                    let what = format!("`count` asks for {read} numbers of M and g");
                    let help = format!("at most {MOST_READ} are read out: ask for fewer configurations");
                    return Err(Error::new(what).help(help));
                }
                let q = random_configurations(&self.robot, count, self.seed)?;
                let clean = read_out(&Chain::new(&self.robot), &base.lift(&values), q, &published.source);
                let sigma = StaticFit::new(&self.robot, &clean)?.deviation_implied_by(percent);
                let noisy = with_noise(&clean, sigma, self.seed);
                (noisy, Some(published), Some((clean, sigma, percent)), None)
            }
        };
        self.say("identifying base parameters from static poses");
        let fit = StaticFit::new(&self.robot, &poses).map_err(|e| match read_from {
            Some(path) => e.in_file(path),
            None => e,
        })?;
        if let Some(warning) = too_few_rows(fit.rows, fit.coefficients.len()) {
            self.warn(warning);
        }
        let mut report = self.static_report(&fit, &poses, published.as_ref())?;
        if let Some((clean, sigma, percent)) = &noise {
            report.signals.push(format!(
                "read-outs of the published model with white noise of {percent} % ({sigma:.3e} per row)"
            ));
            report.dropped_over_draws = self.drop_counts(clean, &fit, *sigma);
        }
        let kept: Vec<f64> = fit
            .coefficients
            .iter()
            .zip(&report.coefficients)
            .map(|(&value, c)| if c.kept { value } else { 0.0 })
            .collect();
        let model = Model::new(&self.robot, vec![Box::new(RigidBody::default())])?;
        let deviations = fit.standard_deviations(fit.residual_deviation());
        let origin = format!("static poses: {}", poses.name);
        let model = ModelFile::new(&model, &kept, &deviations, self.scenario.signals.clone(), origin);
        Ok(Some(FromPoses { report, model, coefficients: kept }))
    }

    fn static_report(
        &self,
        fit: &StaticFit,
        poses: &StaticPoses,
        published: Option<&Published>,
    ) -> Result<Identification> {
        let deviations = fit.standard_deviations(fit.residual_deviation());
        let percents = relative_deviations(&fit.coefficients, &deviations);
        let limit = self.scenario.drop_above_percent.unwrap_or(f64::INFINITY);
        let known = published.map(|p| p.values(&fit.base)).transpose()?;
        let coefficients = (0..fit.coefficients.len())
            .map(|i| Coefficient {
                expression: fit.base.expression(i),
                symbol: parameter_name(fit.base.pivots[i]),
                unit: PARAMETER_UNITS[fit.base.pivots[i] % 10].to_string(),
                value: finite(fit.coefficients[i]),
                relative_sd_percent: finite(percents[i]),
                robust_sd_percent: None,
                kept: percents[i] <= limit,
                published: known.as_ref().map(|k| k[i]),
            })
            .collect();
        let silent: Vec<String> = fit
            .silent_gravity
            .iter()
            .map(|j| format!("g{} carries nothing and is left out", j + 1))
            .collect();
        Ok(Identification {
            label: "static poses".to_string(),
            mode: "static".to_string(),
            data: vec![format!("{} ({} poses)", poses.name, poses.rows())],
            signals: silent,
            split: None,
            weighting: "ordinary".to_string(),
            rows: fit.rows,
            rank: fit.base.rank(),
            condition_number: fit.condition_number,
            relative_error_percent: fit.relative_error_percent(),
            held_out_relative_error_percent: None,
            joints: Vec::new(),
            coefficients,
            not_excited: Vec::new(),
            dropped_over_draws: None,
            validation: Vec::new(),
        })
    }

    /// Which coefficients fall to the threshold depends on the draw of the noise; so draw often.
    fn drop_counts(&mut self, clean: &StaticPoses, fit: &StaticFit, sigma: f64) -> Option<DropCounts> {
        let above_percent = self.scenario.drop_above_percent?;
        self.say(&format!("drawing the noise {DRAWS} times"));
        let counts = drop_counts(&self.robot, clean, fit, sigma, self.seed, DRAWS, above_percent);
        let dropped = counts
            .into_iter()
            .enumerate()
            .filter(|(_, count)| *count > 0)
            .map(|(i, count)| (fit.base.expression(i), count))
            .collect();
        Some(DropCounts { draws: DRAWS, above_percent, dropped })
    }
}

/// Read-outs of `M` and `g` of a model with the given link parameters.
pub(super) fn read_out(chain: &Chain, parameters: &[f64], q: Vec<Vec<f64>>, name: &str) -> StaticPoses {
    let n = chain.dof();
    let triangle = n * (n + 1) / 2;
    let count = q.first().map_or(0, Vec::len);
    let mut m = vec![Vec::with_capacity(count); triangle];
    let mut g = vec![Vec::with_capacity(count); n];
    for pose in 0..count {
        let at: Vec<f64> = q.iter().map(|q| q[pose]).collect();
        let rows = static_regressor(chain, &at);
        for (row, y) in rows.chunks_exact(parameters.len()).enumerate() {
            let value = y.iter().zip(parameters).map(|(y, p)| y * p).sum();
            let column = if row < triangle { &mut m[row] } else { &mut g[row - triangle] };
            column.push(value);
        }
    }
    StaticPoses { name: name.to_string(), q, g, m, dropped: Default::default() }
}

/// The same read-outs with white noise on every row that carries something.
fn with_noise(clean: &StaticPoses, sigma: f64, seed: u64) -> StaticPoses {
    let mut gauss = Stream::new(seed, NOISE_STREAM);
    let mut noisy = clean.clone();
    for column in noisy.m.iter_mut().chain(&mut noisy.g) {
        let silent = column.iter().all(|x| x.abs() < 1e-12);
        for x in column.iter_mut().filter(|_| !silent) {
            *x += sigma * gauss.normal();
        }
    }
    noisy
}

/// How often each coefficient exceeds the threshold over many draws of the noise.
///
/// The regressor stays, so instead of refitting, the estimate is disturbed as the noise disturbs it: the
/// coefficients by a Gaussian with their covariance, the residual variance being that of the draw.
fn drop_counts(
    robot: &crate::robot::Robot,
    clean: &StaticPoses,
    fit: &StaticFit,
    sigma: f64,
    seed: u64,
    draws: usize,
    above_percent: f64,
) -> Vec<usize> {
    let mut counts = vec![0; fit.coefficients.len()];
    let Ok(exact) = StaticFit::new(robot, clean) else { return counts };
    let Some(root) = fit.inverse.clone().cholesky().map(|c| c.l()) else { return counts };
    let deviations = fit.standard_deviations(sigma);
    let mut gauss = Stream::new(seed, DRAW_STREAM);
    for _ in 0..draws {
        let z = nalgebra::DMatrix::from_fn(counts.len(), 1, |_, _| gauss.normal());
        let moved = product(&root, &z) * sigma;
        for (i, count) in counts.iter_mut().enumerate() {
            let value = exact.coefficients[i] + moved[i];
            if 100.0 * deviations[i] > above_percent * value.abs() {
                *count += 1;
            }
        }
    }
    counts
}
