//! One simulated motion: the controlled plant integrated in time, and what comes of it.

use super::controller::{Reference, Tuned};
use super::effect::Moment;
use super::survey::Survey;
use super::{ForwardDynamics, Plant, RungeKutta4, WorldFrame};
use crate::error::{Error, Result};
use crate::excitation::Motion;
use crate::log::Log;

/// Most steps between two samples before a simulation is called too stiff.
const MOST_SUB_STEPS: usize = 1000;

/// A simulated motion: what was measured, and what was so.
#[derive(Debug, Clone, PartialEq)]
pub struct Simulation {
    /// What sensors and reader wrote down.
    pub log: Log,
    /// Where each row of the log comes from.
    pub rows: Vec<Row>,
    /// The motion itself, on the sensors' clock.
    pub truth: Truth,
    /// Root mean square of the tracking error of each joint [rad, m].
    pub tracking_rms: Vec<f64>,
    /// Integration steps between two samples.
    pub sub_steps: usize,
}

/// One row of a simulated log.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// Time written into the log \[s\].
    pub stamp: f64,
    /// Index of the sample in [`Truth`] that was read.
    pub sample: usize,
}

/// The motion without noise. Joint quantities are stored joint by joint: `q[j][k]` is joint `j` at sample
/// `k`. Torque and acceleration fulfil the equation of motion to rounding at every sample.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Truth {
    /// Time \[s\].
    pub t: Vec<f64>,
    /// Positions [rad, m].
    pub q: Vec<Vec<f64>>,
    /// Velocities [rad/s, m/s].
    pub dq: Vec<Vec<f64>>,
    /// Accelerations [rad/s², m/s²].
    pub ddq: Vec<Vec<f64>>,
    /// Torques of the drives, all effects included [N m, N].
    pub tau: Vec<Vec<f64>>,
    /// The part of `tau` that effects beside rigid bodies (and rotors) take [N m, N].
    pub load: Vec<Vec<f64>>,
}

/// The plant as a differential equation with its workspace. The state is `q`, `dq`, then effects' states.
struct Equation<'a> {
    plant: &'a Plant,
    motion: &'a dyn Motion,
    control: Tuned,
    dynamics: ForwardDynamics,
    world: WorldFrame,
    /// Number of states of every effect.
    states: Vec<usize>,
    wanted: Reference,
    tau: Vec<f64>,
    load: Vec<f64>,
    net: Vec<f64>,
}

impl Equation<'_> {
    fn rate(&mut self, t: f64, state: &[f64], rate: &mut [f64]) {
        let n = self.tau.len();
        let ((q, rest), (rate_q, rate_rest)) = (state.split_at(n), rate.split_at_mut(n));
        let ((dq, mut own), (rate_dq, mut rate_own)) = (rest.split_at(n), rate_rest.split_at_mut(n));
        self.motion.at(t, &mut self.wanted.q, &mut self.wanted.dq, &mut self.wanted.ddq);
        self.world.gravity_torque(q, &mut self.tau);
        self.control.add_tracking(&self.wanted, q, dq, &mut self.tau);
        self.load.fill(0.0);
        for (effect, &count) in self.plant.effects.iter().zip(&self.states) {
            let (mine, others) = own.split_at(count);
            let (my_rates, other_rates) = rate_own.split_at_mut(count);
            let now = Moment { t, q, dq, tau: &self.tau, own: mine };
            effect.add_load(&now, &mut self.load);
            effect.rates(&now, my_rates);
            (own, rate_own) = (others, other_rates);
        }
        self.net
            .iter_mut()
            .zip(self.tau.iter().zip(&self.load))
            .for_each(|(net, (tau, load))| *net = tau - load);
        rate_q.copy_from_slice(dq);
        self.dynamics.acceleration(q, dq, &self.net, rate_dq);
    }
}

/// Runs `plant` along `motion`; see [`Plant::simulate`].
pub(super) fn run(plant: &Plant, motion: &dyn Motion, duration: f64, seed: u64) -> Result<Simulation> {
    let n = plant.robot.dof();
    let dt = plant.sensors.sampling_time_s;
    let mut armature = vec![0.0; n];
    plant.effects.iter().for_each(|effect| effect.add_armature(&mut armature));
    let mut dynamics = ForwardDynamics::new(&plant.robot, &plant.parameters)?;
    let mut world = WorldFrame::new(&plant.robot, &plant.parameters)?;
    dynamics.set_armature(&armature);
    world.set_armature(&armature);
    let survey = Survey::along(motion, duration, &plant.effects, &mut dynamics, &mut world);
    let control = plant.controller.tune(&survey);
    let sub_steps = match plant.sub_steps {
        Some(given) => given,
        None => enough_steps(dt * survey.fastest_rate(&control))?,
    };
    let equation = Equation {
        plant,
        motion,
        control,
        dynamics,
        world,
        states: plant.effects.iter().map(|effect| effect.states(n)).collect(),
        wanted: Reference::new(n),
        tau: vec![0.0; n],
        load: vec![0.0; n],
        net: vec![0.0; n],
    };
    // The small excess keeps a duration that is a whole number of samples from losing the last one.
    let samples = (duration / dt + 1e-6).floor() as usize + 1;
    let (truth, tracking_rms) = integrate(equation, samples, sub_steps)?;
    let (log, rows) = plant.sensors.record(&plant.robot.name, &truth, seed);
    Ok(Simulation { log, rows, truth, tracking_rms, sub_steps })
}

/// Steps per sample that keep a Runge-Kutta step within the time in which the plant can change.
fn enough_steps(rate_times_sampling: f64) -> Result<usize> {
    let steps = rate_times_sampling.ceil().max(2.0);
    if steps <= MOST_SUB_STEPS as f64 {
        return Ok(steps as usize);
    }
    // Also for a rate that is not a number.
    let what = format!("the plant is too stiff to simulate: it asks for {steps} steps per sample");
    Err(Error::new(what)
        .help("soften friction near rest (a larger `width`), lower the gains, or check the inertias for near-zero ones"))
}

fn integrate(mut equation: Equation, samples: usize, sub_steps: usize) -> Result<(Truth, Vec<f64>)> {
    let n = equation.tau.len();
    let dt = equation.plant.sensors.sampling_time_s;
    let step = dt / sub_steps as f64;
    let mut state = vec![0.0; 2 * n + equation.states.iter().sum::<usize>()];
    let mut rate = state.clone();
    let mut method = RungeKutta4::new(state.len());
    let start = &mut equation.wanted;
    equation.motion.at(0.0, &mut start.q, &mut start.dq, &mut start.ddq);
    state[..n].copy_from_slice(&start.q);
    state[n..2 * n].copy_from_slice(&start.dq);
    let (mut truth, mut square) = (Truth::with_capacity(n, samples), vec![0.0; n]);
    for k in 0..samples {
        let t = k as f64 * dt;
        equation.rate(t, &state, &mut rate);
        truth.push(t, &state, &rate, &equation)?;
        for (j, square) in square.iter_mut().enumerate() {
            *square += (equation.wanted.q[j] - state[j]).powi(2);
        }
        for sub in 0..sub_steps {
            method.step(t + sub as f64 * step, step, &mut state, |t, x, out| equation.rate(t, x, out));
        }
    }
    Ok((truth, square.iter().map(|s| (s / samples as f64).sqrt()).collect()))
}

impl Truth {
    fn with_capacity(n: usize, samples: usize) -> Self {
        let columns = || vec![Vec::with_capacity(samples); n];
        let t = Vec::with_capacity(samples);
        Self { t, q: columns(), dq: columns(), ddq: columns(), tau: columns(), load: columns() }
    }

    fn push(&mut self, t: f64, state: &[f64], rate: &[f64], equation: &Equation) -> Result<()> {
        let n = self.q.len();
        if let Some(i) = state.iter().chain(rate).position(|x| !x.is_finite()) {
            // Beyond the joints' own states stand those of effects.
            let joint = equation.plant.robot.joints.get(i % state.len() % n).map_or("?", |j| &j.name);
            return Err(Error::new(format!("the simulation diverged before t = {t} s, at joint `{joint}`"))
                .help("give more `sub_steps`, lower gains, or check the inertias of the plant"));
        }
        self.t.push(t);
        for j in 0..n {
            self.q[j].push(state[j]);
            self.dq[j].push(state[n + j]);
            self.ddq[j].push(rate[n + j]);
            self.tau[j].push(equation.tau[j]);
            self.load[j].push(equation.load[j]);
        }
        Ok(())
    }
}
