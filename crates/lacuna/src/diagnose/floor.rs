//! The noise that no model can explain, joint by joint.

use super::data::Data;
use super::present::rms;
use crate::signals::{Run, ZeroPhase, detect_period};

/// Below this frequency torque may be physics \[Hz\].
const NOISE_ABOVE_HZ: f64 = 15.0;
/// No floor is taken to be lower than this part of the torque.
const LEAST_PART: f64 = 1e-4;

/// Noise floor of each joint in the band of the rows.
#[derive(Debug, Clone)]
pub(super) struct Floor {
    /// Used to weigh gains [N m, N].
    pub rms: Vec<f64>,
    /// From repetitions of a periodic motion, where there are any.
    pub repeat: Option<Vec<f64>>,
}

impl Floor {
    /// From the residuals of the model at hand and the raw torque.
    pub fn new(data: &Data, residual: &[Vec<f64>], band_hz: f64) -> Self {
        let repeat = repeat_floor(data, residual);
        let rms = (0..data.dof())
            .map(|j| {
                let least = LEAST_PART * rms(&data.tau[j]);
                let found = match &repeat {
                    Some(repeat) => repeat[j],
                    None => white_noise(data, j, band_hz).unwrap_or_else(|| rms(&residual[j])),
                };
                found.max(least).max(1e-9)
            })
            .collect();
        Self { rms, repeat }
    }
}

/// Differences between residuals at equal phases of a periodic motion, over the root of two.
fn repeat_floor(data: &Data, residual: &[Vec<f64>]) -> Option<Vec<f64>> {
    let mut squares = vec![0.0; data.dof()];
    let mut count = 0;
    for ((run, rows), range) in data.runs.iter().zip(&data.rows).zip(data.run_ranges()) {
        let Some(period) = detect_period(run) else { continue };
        let shift = period / rows.dt;
        let (whole, part) = (shift as usize, shift - libm::floor(shift));
        if rows.count <= whole + 1 {
            continue;
        }
        for k in 0..rows.count - whole - 1 {
            for (square, residual) in squares.iter_mut().zip(residual) {
                let e = &residual[range.clone()];
                let later = e[k + whole] * (1.0 - part) + e[k + whole + 1] * part;
                *square += 0.5 * (later - e[k]) * (later - e[k]);
            }
            count += 1;
        }
    }
    // Fewer than this many rows of overlap say nothing.
    (count > 50).then(|| squares.iter().map(|s| (s / f64::from(count)).sqrt()).collect())
}

/// White noise of the raw torque above the motion's frequencies, scaled to the band: a lower bound.
fn white_noise(data: &Data, joint: usize, band_hz: f64) -> Option<f64> {
    let mut noises: Vec<f64> = data.runs.iter().filter_map(|run| of_run(run, joint, band_hz)).collect();
    noises.sort_by(f64::total_cmp);
    noises.get(noises.len() / 2).copied()
}

fn of_run(run: &Run, joint: usize, band_hz: f64) -> Option<f64> {
    let highest = 0.5 / run.dt;
    if highest < 1.5 * NOISE_ABOVE_HZ || run.row_filter.is_none() {
        return None;
    }
    let slow = ZeroPhase::butterworth(4, NOISE_ABOVE_HZ, run.dt).ok()?;
    let mut smooth = run.tau[joint].clone();
    slow.apply(&mut smooth);
    let fast: Vec<f64> = run.tau[joint].iter().zip(&smooth).map(|(a, b)| a - b).collect();
    let inner = fast.len() / 20..fast.len() - fast.len() / 20;
    Some(rms(&fast[inner]) * (band_hz / (highest - NOISE_ABOVE_HZ)).sqrt())
}
