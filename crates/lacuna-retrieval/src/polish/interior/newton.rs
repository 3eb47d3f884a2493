//! Newton's method along the central path.

use super::cholesky::{dot, factor, solve};
use super::program::{Program, Room};
use super::terms::Slopes;

/// Newton steps for one weight of the barrier.
const STEPS: usize = 200;
/// By how much the weight of the barrier falls from centre to centre.
const FALL: f64 = 0.05;
/// A centre is near enough when a Newton step promises less than this times the weight of the barrier.
const NEAR: f64 = 0.05;
/// Share of the way to the boundary that a step may take.
const SHARE: f64 = 0.99;

/// A point that moves along the central path of a program.
pub(super) struct Newton<'a, 'p> {
    program: &'a Program<'p>,
    pub x: Vec<f64>,
    gradient: Vec<f64>,
    hessian: Vec<f64>,
    factor: Vec<f64>,
    direction: Vec<f64>,
    trial: Vec<f64>,
    room: Room,
    /// Evaluations of the program.
    pub evaluations: u64,
}

impl<'a, 'p> Newton<'a, 'p> {
    /// Starts at `x`; `None` when that is not in the domain of the program.
    pub(super) fn new(program: &'a Program<'p>, x: Vec<f64>) -> Option<Self> {
        let n = program.size();
        let mut room = Room::default();
        program.value(&x, 0.0, &mut room)?;
        Some(Self {
            program,
            trial: x.clone(),
            x,
            gradient: vec![0.0; n],
            hessian: vec![0.0; n * n],
            factor: vec![0.0; n * n],
            direction: vec![0.0; n],
            room,
            evaluations: 1,
        })
    }

    /// Follows the path from the weight `mu` until the gap is `goal(cost)`; asks `stop` after every step.
    pub(super) fn follow(
        &mut self,
        mut mu: f64,
        goal: impl Fn(f64) -> f64,
        mut stop: impl FnMut(&[f64]) -> bool,
    ) {
        loop {
            for _ in 0..STEPS {
                let moved = self.step(mu);
                if stop(&self.x[..]) {
                    return;
                }
                if !moved {
                    break;
                }
            }
            let last = goal(self.program.cost(&self.x)) / self.program.degree();
            if mu <= last {
                return;
            }
            mu = (FALL * mu).max(0.99 * last);
        }
    }

    /// One step towards the centre; `false` when it is near enough or no further step helps.
    fn step(&mut self, mu: f64) -> bool {
        let n = self.program.size();
        let mut slopes = Slopes { size: n, gradient: &mut self.gradient, hessian: &mut self.hessian };
        self.program.slopes(&self.x, mu, &mut self.room, &mut slopes);
        self.evaluations += 1;
        if !self.solve() {
            return false;
        }
        let slope = dot(&self.gradient, &self.direction);
        // A slope that is not negative is rounding; written so that NaN ends here too.
        if !(-slope > NEAR * NEAR * mu) {
            return false;
        }
        self.search(mu, slope) && -slope > NEAR * mu
    }

    /// Newton direction; more and more of the diagonal is added where the Hessian is singular to rounding.
    fn solve(&mut self) -> bool {
        let n = self.program.size();
        let mut ridge = 0.0;
        for _ in 0..8 {
            self.factor.copy_from_slice(&self.hessian);
            for i in 0..n {
                let d = &mut self.factor[i * n + i];
                *d += ridge * d.abs().max(f64::MIN_POSITIVE);
            }
            if factor(&mut self.factor, n) {
                self.direction.iter_mut().zip(&self.gradient).for_each(|(d, g)| *d = -g);
                solve(&self.factor, n, &mut self.direction);
                self.program.equalities().restrict(&self.factor, n, &mut self.direction);
                return self.direction.iter().all(|d| d.is_finite());
            }
            ridge = if ridge > 0.0 { 100.0 * ridge } else { 1e-14 };
        }
        false
    }

    /// Backtracks from the longest step that stays inside until the value falls enough (Armijo).
    fn search(&mut self, mu: f64, slope: f64) -> bool {
        let Some(before) = self.program.value(&self.x, mu, &mut self.room) else { return false };
        let mut length = (SHARE * self.program.reach(&self.x, &self.direction)).min(1.0);
        for _ in 0..60 {
            for (t, (x, d)) in self.trial.iter_mut().zip(self.x.iter().zip(&self.direction)) {
                *t = x + length * d;
            }
            self.evaluations += 1;
            match self.program.value(&self.trial, mu, &mut self.room) {
                Some(value) if value <= before + 1e-4 * length * slope => {
                    std::mem::swap(&mut self.x, &mut self.trial);
                    return true;
                }
                _ => length *= 0.6,
            }
        }
        false
    }
}
