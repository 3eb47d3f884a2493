//! Standard deviations that survive autocorrelated residuals.

use nalgebra::DMatrix;

use crate::error::Result;
use crate::linalg::dots;
use crate::model::Model;
use crate::signals::Run;

use super::evidence::residuals;
use super::rows::over_rows;

/// Bandwidth of the Bartlett kernel \[s\]: residuals further apart count as independent.
pub const BANDWIDTH_S: f64 = 1.0;
/// Scores are summed over pieces this long \[s\] before the kernel is applied.
const PIECE_S: f64 = 0.05;

/// Long-run variance of the scores `Yᵀ W² r` (Newey and West 1987, Bartlett kernel of
/// [`BANDWIDTH_S`]): the middle of the sandwich `(YᵀW²Y)⁻¹ S (YᵀW²Y)⁻¹`.
///
/// The Bartlett sum over pieces equals the mean over all windows one bandwidth long of the outer product
/// of the windows' score sums, which needs one pass and no lags. Runs never share a window.
///
/// # Errors
/// When a run lacks something an effect needs.
pub fn score_variance(model: &Model, runs: &[Run], x: &[f64], weights: &[f64]) -> Result<DMatrix<f64>> {
    let p = model.columns.len();
    let pieces = score_pieces(model, runs, x, weights)?;
    let window = (BANDWIDTH_S / PIECE_S).round() as usize;
    let mut total = DMatrix::zeros(p, p);
    for run in 0..runs.len() {
        let scores: Vec<&[f64]> =
            pieces.iter().filter(|(r, _, _)| *r == run).map(|(_, _, s)| s.as_slice()).collect();
        let mut sum = vec![0.0; p];
        for end in 0..scores.len() + window - 1 {
            if end < scores.len() {
                sum.iter_mut().zip(scores[end]).for_each(|(s, v)| *s += v);
            }
            if end >= window {
                sum.iter_mut().zip(scores[end - window]).for_each(|(s, v)| *s -= v);
            }
            let window_sum = nalgebra::DVectorView::from_slice(&sum, p);
            total.ger(1.0 / window as f64, &window_sum, &window_sum, 1.0);
        }
    }
    Ok(total)
}

type Piece = (usize, usize, Vec<f64>);

/// Scores summed over consecutive pieces of every run, in order: `(run, piece number, score)`.
fn score_pieces(model: &Model, runs: &[Run], x: &[f64], weights: &[f64]) -> Result<Vec<Piece>> {
    let p = model.columns.len();
    let per_piece: Vec<usize> =
        runs.iter().map(|r| ((PIECE_S / r.rows().dt).round() as usize).max(1)).collect();
    let parts = over_rows(model, runs, Vec::<Piece>::new, |pieces, view| {
        view.split_by(
            |row| row / per_piece[view.run],
            |number, part| {
                if pieces.last().is_none_or(|last| (last.0, last.1) != (view.run, number)) {
                    pieces.push((view.run, number, vec![0.0; p]));
                }
                let Some((_, _, score)) = pieces.last_mut() else { return Ok(()) };
                for (joint, weight) in weights.iter().enumerate() {
                    let residual = residuals(model, part, joint, x);
                    let w = weight * weight;
                    let active = &model.active[joint];
                    let columns = (0..active.len()).map(|local| part.column(joint, local));
                    let mut places = active.iter();
                    dots(&residual, columns, |dot| {
                        if let Some(&column) = places.next() {
                            score[column] += w * dot;
                        }
                    });
                }
                Ok(())
            },
        )
    })?;
    let mut all: Vec<Piece> = Vec::new();
    for piece in parts.into_iter().flatten() {
        match all.last_mut() {
            Some(last) if (last.0, last.1) == (piece.0, piece.1) => {
                last.2.iter_mut().zip(&piece.2).for_each(|(s, v)| *s += v);
            }
            _ => all.push(piece),
        }
    }
    Ok(all)
}
