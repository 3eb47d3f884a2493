//! A Rosenbrock method that takes friction and feedback implicitly, so that steep friction needs no small steps.

use super::OwnSlope;
use super::simulation::Equation;

/// Makes the method L-stable: `1 - 1 / sqrt(2)`.
const GAMMA: f64 = 0.292_893_218_813_452_4;

/// Change of velocity by which the slope of friction is measured [rad/s, m/s].
const NUDGE: f64 = 1e-7;

/// ROS2 of Verwer, Spee, Blom and Hundsdorfer 1999: with `A` near the Jacobian of `y' = f(t, y)`,
/// `(1 - g h A) k1 = f(t, y)`, `(1 - g h A) k2 = f(t + h, y + h k1) - 2 k1`, `y += h (3 k1 + k2) / 2`.
///
/// It is of order two for any `A`. Here `A` holds what is stiff: each joint's slope of friction and feedback over
/// its own velocity and position, and the own states of effects. In front of the accelerations stands the mass
/// matrix, so `M + g h D + ..` with diagonal `D` is all there is to solve, and articulated bodies do that with
/// `g h D + ..` as additional rotor inertia.
#[derive(Debug, Clone)]
pub(super) struct Implicit {
    /// Rates of positions, velocities, own states in both stages.
    k1: Vec<f64>,
    k2: Vec<f64>,
    stage: Vec<f64>,
    rate_own: Vec<f64>,
    slopes: Vec<OwnSlope>,
    /// Additional inertia of every joint.
    grown: Vec<f64>,
    force: Vec<f64>,
    /// Loads as they are and with all velocities nudged.
    felt: Vec<f64>,
    nudged: Vec<f64>,
}

impl Implicit {
    /// For `n` joints and `own` states of effects.
    pub(super) fn new(n: usize, own: usize) -> Self {
        let state = || vec![0.0; 2 * n + own];
        let joints = || vec![0.0; n];
        Self {
            k1: state(),
            k2: state(),
            stage: state(),
            rate_own: vec![0.0; own],
            slopes: vec![OwnSlope::default(); own],
            grown: joints(),
            felt: joints(),
            force: joints(),
            nudged: joints(),
        }
    }

    /// Moves `state` from time `t` by `h`.
    pub(super) fn step(&mut self, t: f64, h: f64, state: &mut [f64], equation: &mut Equation) {
        let n = self.grown.len();
        equation.torques(t, state, &mut self.rate_own);
        self.linearise(t, h, state, equation);
        self.k1[..n].copy_from_slice(&state[n..2 * n]);
        self.k1[2 * n..].copy_from_slice(&self.rate_own);
        self.force.copy_from_slice(&equation.net);
        solve(&mut self.k1, &mut self.force, state, h, &self.grown, &self.slopes, equation, None);

        for (stage, (x, k)) in self.stage.iter_mut().zip(state.iter().zip(&self.k1)) {
            *stage = x + h * k;
        }
        equation.torques(t + h, &self.stage, &mut self.rate_own);
        for j in 0..n {
            self.k2[j] = self.stage[n + j] - 2.0 * self.k1[j];
        }
        for (i, rate) in self.rate_own.iter().enumerate() {
            self.k2[2 * n + i] = rate - 2.0 * self.k1[2 * n + i];
        }
        self.force.copy_from_slice(&equation.net);
        let first = &self.k1[n..2 * n];
        solve(
            &mut self.k2,
            &mut self.force,
            &self.stage,
            h,
            &self.grown,
            &self.slopes,
            equation,
            Some(first),
        );
        equation.dynamics.set_armature(&equation.armature);
        for (x, (k1, k2)) in state.iter_mut().zip(self.k1.iter().zip(&self.k2)) {
            *x += h * (1.5 * k1 + 0.5 * k2);
        }
    }

    /// Measures the slopes at the start of the step and sets the inertia that they amount to.
    fn linearise(&mut self, t: f64, h: f64, state: &[f64], equation: &mut Equation) {
        let n = self.grown.len();
        self.stage.copy_from_slice(state);
        self.stage[n..2 * n].iter_mut().for_each(|v| *v += NUDGE);
        self.felt.fill(0.0);
        self.nudged.fill(0.0);
        equation.add_loads(t, state, &mut self.felt);
        equation.add_loads(t, &self.stage, &mut self.nudged);
        let gh = GAMMA * h;
        for (j, grown) in self.grown.iter_mut().enumerate() {
            // Falling friction is left to the explicit part: it must not take inertia away.
            let friction = ((self.nudged[j] - self.felt[j]) / NUDGE).max(0.0);
            let control = &equation.control.loops[j];
            *grown = gh * (friction + control.damping) + gh * gh * control.stiffness;
        }
        self.slopes.fill(OwnSlope::default());
        equation.own_slopes(t, state, &mut self.slopes);
        for own in &self.slopes {
            let memory = 1.0 - gh * own.rate_per_own;
            self.grown[own.joint] += gh * gh * own.load_per_own * own.rate_per_velocity / memory;
        }
        let all = equation.armature.iter().zip(&self.grown);
        self.felt.iter_mut().zip(all).for_each(|(felt, (own, grown))| *felt = own + grown);
        equation.dynamics.set_armature(&self.felt);
    }
}

/// Solves one stage: `k` holds the right sides of positions and own states and receives the solution; `force` is
/// what acts at `state`. With the velocities' `first` solution it is the second stage.
#[allow(clippy::too_many_arguments)] // one equation with all its terms
fn solve(
    k: &mut [f64],
    force: &mut [f64],
    state: &[f64],
    h: f64,
    grown: &[f64],
    slopes: &[OwnSlope],
    equation: &mut Equation,
    first: Option<&[f64]>,
) {
    let (n, gh) = (grown.len(), GAMMA * h);
    for (j, force) in force.iter_mut().enumerate() {
        *force -= gh * equation.control.loops[j].stiffness * k[j];
        // The mass matrix in front of `-2 k1` is saved by solving for `k2 + 2 k1`.
        *force += 2.0 * first.map_or(0.0, |first| grown[j] * first[j]);
    }
    for (i, own) in slopes.iter().enumerate() {
        let memory = 1.0 - gh * own.rate_per_own;
        force[own.joint] -= gh * own.load_per_own * k[2 * n + i] / memory;
    }
    let (positions, rest) = k.split_at_mut(n);
    let (velocities, owns) = rest.split_at_mut(n);
    equation.dynamics.acceleration(&state[..n], &state[n..2 * n], force, velocities);
    for j in 0..n {
        velocities[j] -= 2.0 * first.map_or(0.0, |first| first[j]);
        positions[j] += gh * velocities[j];
    }
    for (own, rate) in slopes.iter().zip(owns) {
        let memory = 1.0 - gh * own.rate_per_own;
        *rate = (*rate + gh * own.rate_per_velocity * velocities[own.joint]) / memory;
    }
}
