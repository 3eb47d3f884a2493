//! All that least squares needs to know of the data, in constant memory: one triangle per fold and joint.

use crate::error::{Error, Result};
use crate::linalg::{Triangle, subtract_product};
use crate::model::Model;
use crate::signals::{Folds, Run};

use super::rows::{RowView, over_rows_in_turn};

/// Gives each row a weight from its joint and its residual under the parameters at hand; for robust fits.
pub type RowWeight<'a> = dyn Fn(usize, f64) -> f64 + Sync + 'a;

/// One triangle per fold and joint. The rows of a joint only have the columns that can move it, so joints
/// are kept apart: it is several times cheaper, per-joint weights cost nothing afterwards, and errors of
/// any parameter vector are known per joint and fold without touching the data again.
#[derive(Debug, Clone)]
pub struct Evidence {
    /// `triangles[fold][joint]`: columns are `Model::active[joint]`, then the torque.
    pub triangles: Vec<Vec<Triangle>>,
}

impl Evidence {
    /// Streams all rows of `runs` into triangles.
    ///
    /// # Errors
    /// When a run lacks something that an effect needs.
    pub fn collect(model: &Model, runs: &[Run], folds: &Folds) -> Result<Self> {
        Self::gather(model, runs, folds, None)
    }

    /// The same with every row scaled by the square root of a weight that depends on its residual under `x`.
    ///
    /// # Errors
    /// As [`Evidence::collect`].
    pub fn collect_weighted(
        model: &Model,
        runs: &[Run],
        folds: &Folds,
        x: &[f64],
        weight: &RowWeight<'_>,
    ) -> Result<Self> {
        Self::gather(model, runs, folds, Some((x, weight)))
    }

    fn gather(
        model: &Model,
        runs: &[Run],
        folds: &Folds,
        robust: Option<(&[f64], &RowWeight<'_>)>,
    ) -> Result<Self> {
        check_extent(model, folds.count)?;
        let empty = || Self::empty(model, usize::from(folds.count));
        let offsets = first_rows(runs);
        let fold_of = |run: usize, row: usize| usize::from(folds.fold[offsets[run] + row]);
        let mut all = empty();
        over_rows_in_turn(
            model,
            runs,
            || (empty(), Scratch::default()),
            |(evidence, scratch), view| {
                view.split_by(
                    |row| fold_of(view.run, row),
                    |fold, part| {
                        for (joint, triangle) in evidence.triangles[fold].iter_mut().enumerate() {
                            triangle.absorb(scratch.load(model, part, joint, robust), part.rows.len());
                        }
                        Ok(())
                    },
                )
            },
            |(part, _)| {
                for (sum, add) in all.triangles.iter_mut().flatten().zip(part.triangles.iter().flatten()) {
                    if add.rows() > 0 {
                        sum.merge_same(add);
                    }
                }
            },
        )?;
        Ok(all)
    }

    fn empty(model: &Model, folds: usize) -> Self {
        let fold = model.active.iter().map(|a| Triangle::new(a.len() + 1)).collect();
        Self { triangles: vec![fold; folds] }
    }

    /// Number of joints.
    pub fn joints(&self) -> usize {
        self.triangles.first().map_or(0, Vec::len)
    }

    /// All folds but `left_out` together, per joint.
    pub fn merged(&self, left_out: Option<usize>) -> Vec<Triangle> {
        let mut sum: Vec<Triangle> = self.triangles[0].iter().map(|t| Triangle::new(t.columns())).collect();
        for (fold, triangles) in self.triangles.iter().enumerate() {
            if Some(fold) != left_out {
                for (s, t) in sum.iter_mut().zip(triangles) {
                    s.merge_same(t);
                }
            }
        }
        sum
    }
}

/// Most numbers in the triangles of all folds, and folds that are never too many.
const MOST_IN_TRIANGLES: usize = 50_000_000;
const USUAL_FOLDS: u16 = 8;

/// Refuses more folds than memory has room for.
fn check_extent(model: &Model, folds: u16) -> Result<()> {
    let of_fold: usize = model.active.iter().map(|columns| (columns.len() + 1).pow(2)).sum();
    let most = (MOST_IN_TRIANGLES / of_fold.max(1)).max(usize::from(USUAL_FOLDS));
    if usize::from(folds) <= most {
        return Ok(());
    }
    Err(Error::new(format!("`folds` is {folds}, and each keeps {of_fold} sums of this model"))
        .help(format!("give at most {most}; {USUAL_FOLDS} are usual")))
}

/// Number of the first row of every run when all rows are counted through.
fn first_rows(runs: &[Run]) -> Vec<usize> {
    let mut next = 0;
    runs.iter()
        .map(|run| {
            let first = next;
            next += run.rows().count;
            first
        })
        .collect()
}

/// Sum of squared residuals of `x` over the rows of one joint's triangle.
pub fn residual_squares(model: &Model, joint: usize, triangle: &Triangle, x: &[f64]) -> f64 {
    let mut local: Vec<f64> = model.active[joint].iter().map(|&c| x[c]).collect();
    local.push(-1.0);
    triangle.squares(&local)
}

#[derive(Default)]
struct Scratch {
    room: Vec<f64>,
}

impl Scratch {
    /// Copies the rows of one joint, padded, torque last, and scales them when the fit is robust.
    fn load(
        &mut self,
        model: &Model,
        part: &RowView<'_>,
        joint: usize,
        robust: Option<(&[f64], &RowWeight<'_>)>,
    ) -> &mut [f64] {
        let (rows, width) = (part.rows.len(), model.active[joint].len());
        let block = Triangle::block(&mut self.room, width + 1, rows);
        let length = Triangle::padded(rows);
        for (local, column) in block.chunks_exact_mut(length).enumerate() {
            let from = if local < width { part.column(joint, local) } else { part.tau(joint) };
            column[..rows].copy_from_slice(from);
            column[rows..].fill(0.0);
        }
        if let Some((x, weight)) = robust {
            let residual = residuals(model, part, joint, x);
            let roots: Vec<f64> = residual.into_iter().map(|r| weight(joint, r).sqrt()).collect();
            for column in block.chunks_exact_mut(length) {
                column.iter_mut().zip(&roots).for_each(|(y, root)| *y *= root);
            }
        }
        block
    }
}

/// Torque minus model in the rows of one joint.
pub(super) fn residuals(model: &Model, part: &RowView<'_>, joint: usize, x: &[f64]) -> Vec<f64> {
    let mut rest = part.tau(joint).to_vec();
    let terms = model.active[joint].iter().enumerate().map(|(local, &c)| (x[c], part.column(joint, local)));
    subtract_product(&mut rest, terms);
    rest
}
