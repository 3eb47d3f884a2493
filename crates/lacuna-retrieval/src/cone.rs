//! Conic programs: affine rows in cones and a linear cost, solved by clarabel.

// Semidefinite cones call BLAS and LAPACK; unnamed, this crate's symbols would not be linked.
extern crate lacuna_lapack as _;

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::mpsc;

use clarabel::algebra::CscMatrix;
use clarabel::solver::{DefaultInfo, DefaultSettings, DefaultSolver, IPSolver, SolverStatus, SupportedConeT};

use crate::form::{Affine, Body, Form};
use lacuna_base::error::{Error, Result};

/// Semidefinite matrices are padded to this size: clarabel's own code for smaller ones uses the C
/// library's arc tangent, whose last bit depends on the processor.
const SMALLEST_MATRIX: usize = 4;

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    Zero,
    Nonnegative,
    SecondOrder,
    Semidefinite(usize),
}

/// Rows that lie in one cone.
#[derive(Debug, Clone)]
struct Block {
    kind: Kind,
    rows: Vec<Affine>,
}

/// Minimise a linear cost over unknowns whose rows lie in cones.
#[derive(Debug, Clone, Default)]
pub(super) struct Program {
    unknowns: usize,
    /// Factor of every unknown in the cost.
    pub cost: Vec<(usize, f64)>,
    blocks: Vec<Block>,
}

/// How hard to try.
#[derive(Debug, Clone, Copy)]
pub(super) struct Effort {
    /// Gap and feasibility, relative and absolute.
    pub tolerance: f64,
    /// Iterations at most.
    pub iterations: u32,
}

impl Default for Effort {
    fn default() -> Self {
        Self { tolerance: 1e-10, iterations: 200 }
    }
}

/// How a solve ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Ending {
    /// To tolerance.
    Solved,
    /// To a reduced tolerance of 5e-5.
    Nearly,
    /// No point satisfies the rows.
    Infeasible,
    /// The cost falls without bound.
    Unbounded,
    /// Asked to stop.
    Stopped,
    /// Before it reached the tolerance; the point may still be good.
    Early,
}

/// What a solve gave.
#[derive(Debug, Clone)]
pub(super) struct Outcome {
    pub x: Vec<f64>,
    /// One entry per block in the order they were added, with entries as [`super::Multiplier`] wants them.
    pub duals: Vec<Vec<f64>>,
    pub ending: Ending,
    /// Solver's own word for it.
    pub status: String,
    pub iterations: u32,
}

impl Program {
    pub fn new(unknowns: usize) -> Self {
        Self { unknowns, ..Self::default() }
    }

    /// A further unknown; its index.
    pub fn unknown(&mut self) -> usize {
        self.unknowns += 1;
        self.unknowns - 1
    }

    /// Makes every row homogeneous: its constant becomes the factor of this unknown.
    pub fn homogenise(&mut self, unknown: usize) {
        for row in self.blocks.iter_mut().flat_map(|block| &mut block.rows) {
            let constant = std::mem::take(&mut row.constant);
            row.terms.push((unknown, constant));
        }
    }

    /// Number of blocks so far: the index of the next one.
    pub fn blocks(&self) -> usize {
        self.blocks.len()
    }

    pub fn zero(&mut self, row: Affine) {
        self.blocks.push(Block { kind: Kind::Zero, rows: vec![row] });
    }

    pub fn nonnegative(&mut self, row: Affine) {
        self.blocks.push(Block { kind: Kind::Nonnegative, rows: vec![row] });
    }

    /// `|rows| <= bound`.
    pub fn second_order(&mut self, bound: Affine, rows: Vec<Affine>) {
        let rows = std::iter::once(bound).chain(rows).collect();
        self.blocks.push(Block { kind: Kind::SecondOrder, rows });
    }

    /// The body holds with a margin of at least `margin`; `false` when no cone expresses it.
    pub fn form(&mut self, form: &Form, margin: &Affine) -> bool {
        let less = |row: &Affine| row.clone().plus(-form.scale, margin);
        match &form.body {
            Body::Affine(row) => self.nonnegative(less(row)),
            Body::Norm { rows, bound } => self.second_order(less(bound), rows.clone()),
            Body::Psd { size: 1, lower } => self.nonnegative(less(&lower[0])),
            Body::Psd { size, lower } => {
                let mut rows = lower.clone();
                (0..*size).map(diagonal).for_each(|k| rows[k] = less(&rows[k]));
                self.blocks.push(Block { kind: Kind::Semidefinite(*size), rows });
            }
            Body::General { .. } => return false,
        }
        true
    }

    /// Solves; `watch` hears of every iteration and may end it with `false`.
    ///
    /// # Errors
    /// When the solver refuses the numbers (not finite).
    pub fn solve(&self, effort: Effort, watch: Option<&mut dyn FnMut(u32) -> bool>) -> Result<Outcome> {
        let layout = Layout::new(self);
        let mut solver = layout.solver(self, effort)?;
        match watch {
            None => solver.solve(),
            Some(watch) => solve_watched(&mut solver, watch),
        }
        let solution = &solver.solution;
        Ok(Outcome {
            x: solution.x.clone(),
            duals: layout.duals(self, &solution.z),
            ending: match solution.status {
                SolverStatus::Solved => Ending::Solved,
                SolverStatus::PrimalInfeasible | SolverStatus::AlmostPrimalInfeasible => Ending::Infeasible,
                SolverStatus::DualInfeasible | SolverStatus::AlmostDualInfeasible => Ending::Unbounded,
                SolverStatus::AlmostSolved => Ending::Nearly,
                SolverStatus::CallbackTerminated => Ending::Stopped,
                _ => Ending::Early,
            },
            status: format!("{:?}", solution.status),
            iterations: solution.iterations,
        })
    }
}

/// The solver calls back from its own thread; the watcher stays in the caller's, whose references it holds.
fn solve_watched(solver: &mut DefaultSolver<f64>, watch: &mut dyn FnMut(u32) -> bool) {
    let (sender, receiver) = mpsc::channel();
    let stop = Arc::new(AtomicBool::new(false));
    let heard = Arc::clone(&stop);
    solver.set_termination_callback(move |info: &DefaultInfo<f64>| {
        // The watcher is gone only when the caller unwinds: then stop as well.
        sender.send(info.iterations).is_err() || heard.load(Ordering::Relaxed)
    });
    std::thread::scope(|scope| {
        scope.spawn(|| {
            solver.solve();
            // Dropping the callback closes the channel, which ends the loop below.
            solver.unset_termination_callback();
        });
        for iteration in receiver {
            if !watch(iteration) {
                stop.store(true, Ordering::Relaxed);
            }
        }
    });
}

/// Place of the `k`-th diagonal entry in a lower triangle by rows.
fn diagonal(k: usize) -> usize {
    k * (k + 3) / 2
}

/// Where each block's rows stand for the solver: equalities first, then inequalities, then the rest.
struct Layout {
    /// First row of every block.
    starts: Vec<usize>,
    rows: usize,
    cones: Vec<SupportedConeT<f64>>,
}

impl Layout {
    fn new(program: &Program) -> Self {
        let mut starts = vec![0; program.blocks.len()];
        let (mut rows, mut cones) = (0, Vec::new());
        let mut place = |wanted: &dyn Fn(Kind) -> bool| {
            let first = rows;
            for (start, block) in starts.iter_mut().zip(&program.blocks).filter(|(_, b)| wanted(b.kind)) {
                *start = rows;
                rows += match block.kind {
                    Kind::Semidefinite(size) => {
                        let size = size.max(SMALLEST_MATRIX);
                        cones.push(SupportedConeT::PSDTriangleConeT(size));
                        size * (size + 1) / 2
                    }
                    Kind::SecondOrder => {
                        cones.push(SupportedConeT::SecondOrderConeT(block.rows.len()));
                        block.rows.len()
                    }
                    Kind::Zero | Kind::Nonnegative => 1,
                };
            }
            match rows - first {
                0 => {}
                count if wanted(Kind::Zero) => cones.push(SupportedConeT::ZeroConeT(count)),
                count if wanted(Kind::Nonnegative) => cones.push(SupportedConeT::NonnegativeConeT(count)),
                _ => {}
            }
        };
        place(&|kind| kind == Kind::Zero);
        place(&|kind| kind == Kind::Nonnegative);
        place(&|kind| matches!(kind, Kind::SecondOrder | Kind::Semidefinite(_)));
        Self { starts, rows, cones }
    }

    /// clarabel's form: `A x + s = b`, `s` in the cones; semidefinite entries off the diagonal times root 2.
    fn solver(&self, program: &Program, effort: Effort) -> Result<DefaultSolver<f64>> {
        let (mut b, mut triplets) = (vec![0.0; self.rows], (Vec::new(), Vec::new(), Vec::new()));
        for (block, &start) in program.blocks.iter().zip(&self.starts) {
            for (k, row) in block.rows.iter().enumerate() {
                let weight = weight(block.kind, k);
                b[start + k] = weight * row.constant;
                for &(column, factor) in row.terms.iter().filter(|t| t.1.abs() > 0.0) {
                    triplets.0.push(start + k);
                    triplets.1.push(column);
                    triplets.2.push(-weight * factor);
                }
            }
            if let Kind::Semidefinite(size) = block.kind {
                (size..SMALLEST_MATRIX).for_each(|k| b[start + diagonal(k)] = 1.0);
            }
        }
        let mut q = vec![0.0; program.unknowns];
        program.cost.iter().for_each(|&(i, factor)| q[i] += factor);
        if let Some(bad) = b.iter().chain(&triplets.2).chain(&q).find(|v| !v.is_finite()) {
            return Err(Error::new(format!("a constraint or the objective holds the number {bad}"))
                .help("every bound and every datum must be a finite number"));
        }
        let a = CscMatrix::new_from_triplets(self.rows, program.unknowns, triplets.0, triplets.1, triplets.2);
        let p = CscMatrix::zeros((program.unknowns, program.unknowns));
        let settings = DefaultSettings {
            verbose: false,
            max_iter: effort.iterations,
            tol_gap_abs: effort.tolerance,
            tol_gap_rel: effort.tolerance,
            tol_feas: effort.tolerance,
            max_threads: 1,
            direct_solve_method: "qdldl".to_string(),
            presolve_enable: false,
            // It would cut the padding off again.
            chordal_decomposition_enable: false,
            ..DefaultSettings::default()
        };
        DefaultSolver::new(&p, &q, &a, &b, &self.cones, settings)
            .map_err(|e| Error::new(format!("the conic solver refuses the problem: {e}")))
    }

    fn duals(&self, program: &Program, z: &[f64]) -> Vec<Vec<f64>> {
        let block = |(block, &start): (&Block, &usize)| {
            (0..block.rows.len()).map(|k| z[start + k] / weight(block.kind, k)).collect()
        };
        program.blocks.iter().zip(&self.starts).map(block).collect()
    }
}

/// Factor of the `k`-th row of a block.
fn weight(kind: Kind, k: usize) -> f64 {
    let on_diagonal = || (0..=k).any(|i| diagonal(i) == k);
    if matches!(kind, Kind::Semidefinite(_)) && !on_diagonal() { std::f64::consts::SQRT_2 } else { 1.0 }
}
