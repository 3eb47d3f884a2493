//! One simulated motion: the controlled plant integrated in time, and what comes of it.

use std::collections::BTreeMap;

use super::controller::{Reference, Tuned};
use super::effect::{Moment, Observed, PlantEffect};
use super::implicit::Implicit;
use super::kinematics::bodies;
use super::survey::Survey;
use super::{ForwardDynamics, Kinematics, Method, Plant, RungeKutta4, WorldFrame};
use lacuna_base::error::{Error, Result};
use lacuna_base::excitation::Motion;
use lacuna_base::log::Log;

/// Most steps between two samples before a simulation is called too stiff.
const MOST_SUB_STEPS: usize = 1000;

/// Most integration steps of a simulation; they take hours.
const MOST_STEPS: f64 = 1e9;

/// Longest step of the implicit method \[s\]. Stable at any step; but axes that are nearly parallel (the first and the third of a
/// Panda) are stiff against each other, and at 1 ms their velocities lag their accelerations enough to look like a
/// viscous coupling of 0.07 N m s/rad.
const IMPLICIT_STEP: f64 = 1.25e-4;

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
    /// What else sensors could see of the effects (temperatures), by name.
    pub channels: BTreeMap<String, Vec<f64>>,
}

/// The plant as a differential equation with its workspace. The state is `q`, `dq`, then effects' states.
pub(super) struct Equation<'a> {
    plant: &'a Plant,
    effects: &'a [&'a dyn PlantEffect],
    motion: &'a dyn Motion,
    pub(super) control: Tuned,
    pub(super) dynamics: ForwardDynamics,
    pub(super) armature: Vec<f64>,
    arm: Kinematics,
    world: WorldFrame,
    /// In which order effects are evaluated, and where the own states of each lie.
    order: Vec<usize>,
    states: Vec<std::ops::Range<usize>>,
    wanted: Reference,
    pub(super) tau: Vec<f64>,
    load: Vec<f64>,
    /// What is left for links and rotors [N m, N].
    pub(super) net: Vec<f64>,
}

impl Equation<'_> {
    /// Torques of drives and effects at `state`; writes the rates of own states.
    pub(super) fn torques(&mut self, t: f64, state: &[f64], rate_own: &mut [f64]) {
        let n = self.tau.len();
        let (q, dq) = (&state[..n], &state[n..2 * n]);
        self.motion.at(t, &mut self.wanted.q, &mut self.wanted.dq, &mut self.wanted.ddq);
        self.world.gravity_torque(q, &mut self.tau);
        self.control.add_tracking(&self.wanted, q, dq, &mut self.tau);
        let mut load = std::mem::take(&mut self.load);
        load.fill(0.0);
        self.add_loads(t, state, &mut load);
        for (effect, own) in self.effects.iter().zip(&self.states) {
            effect.rates(&self.moment(t, state, own), &mut rate_own[own.clone()]);
        }
        for (net, (tau, load)) in self.net.iter_mut().zip(self.tau.iter().zip(&load)) {
            *net = tau - load;
        }
        self.load = load;
    }

    /// Adds what effects take under the torques that are at hand.
    pub(super) fn add_loads(&self, t: f64, state: &[f64], load: &mut [f64]) {
        for &i in &self.order {
            self.effects[i].add_load(&self.moment(t, state, &self.states[i]), load);
        }
    }

    fn moment<'b>(&'b self, t: f64, state: &'b [f64], own: &std::ops::Range<usize>) -> Moment<'b> {
        let n = self.tau.len();
        let (q, dq, all) = (&state[..n], &state[n..2 * n], &state[2 * n..]);
        Moment { t, q, dq, tau: &self.tau, own: &all[own.clone()], arm: &self.arm }
    }

    /// How own states hang together with their joints.
    pub(super) fn own_slopes(&self, t: f64, state: &[f64], slopes: &mut [super::OwnSlope]) {
        for (effect, own) in self.effects.iter().zip(&self.states) {
            effect.own_slopes(&self.moment(t, state, own), &mut slopes[own.clone()]);
        }
    }

    /// Number of all effects' own states.
    pub(super) fn own_states(&self) -> usize {
        self.states.last().map_or(0, |last| last.end)
    }

    fn rate(&mut self, t: f64, state: &[f64], rate: &mut [f64]) {
        let n = self.tau.len();
        let (rate_q, rate_rest) = rate.split_at_mut(n);
        let (rate_dq, rate_own) = rate_rest.split_at_mut(n);
        self.torques(t, state, rate_own);
        rate_q.copy_from_slice(&state[n..2 * n]);
        self.dynamics.acceleration(&state[..n], &state[n..2 * n], &self.net, rate_dq);
    }
}

/// Runs `plant` along `motion`; see [`Plant::simulate`].
pub(super) fn run(
    plant: &Plant,
    effects: &[&dyn PlantEffect],
    motion: &dyn Motion,
    duration: f64,
    seed: u64,
) -> Result<Simulation> {
    let dt = plant.sensors.sampling_time_s;
    let (equation, survey) = equation(plant, effects, motion, duration)?;
    let sub_steps = match (plant.sub_steps, plant.method) {
        (Some(given), _) => given,
        (None, Method::RungeKutta) => enough_steps(dt * survey.fastest_rate(&equation.control))?,
        (None, Method::Implicit) => enough_steps(dt / IMPLICIT_STEP - 1e-9)?,
    };
    // The small excess keeps a duration that is a whole number of samples from losing the last one.
    let samples = (duration / dt + 1e-6).floor() as usize + 1;
    if samples as f64 * sub_steps as f64 > MOST_STEPS {
        let what = format!("`duration_s` asks for {samples} samples of {sub_steps} integration steps each");
        return Err(Error::new(what).help(format!(
            "at most {MOST_STEPS:.0e} steps are made: shorten the motion, or sample less often"
        )));
    }
    let (truth, tracking_rms) = integrate(equation, samples, sub_steps)?;
    let mut seen = Observed {
        dt,
        q: truth.q.clone(),
        dq: truth.dq.clone(),
        tau: truth.tau.clone(),
        transmitted: difference(&truth.tau, &truth.load),
    };
    effects.iter().for_each(|effect| effect.observe(&mut seen));
    let (log, rows) = plant.sensors.record(&plant.robot.name, &truth, &seen, seed);
    Ok(Simulation { log, rows, truth, tracking_rms, sub_steps })
}

fn difference(a: &[Vec<f64>], b: &[Vec<f64>]) -> Vec<Vec<f64>> {
    let of = |(a, b): (&Vec<f64>, &Vec<f64>)| a.iter().zip(b).map(|(x, y)| x - y).collect();
    a.iter().zip(b).map(of).collect()
}

/// The plant's equation of motion with a controller tuned for `motion`, and the survey it was tuned by.
fn equation<'a>(
    plant: &'a Plant,
    effects: &'a [&'a dyn PlantEffect],
    motion: &'a dyn Motion,
    duration: f64,
) -> Result<(Equation<'a>, Survey)> {
    let n = plant.robot.dof();
    let arm = Kinematics::new(&plant.robot)?;
    let (mut robot, mut links) = (plant.robot.clone(), bodies(&plant.robot, &plant.parameters)?);
    let (mut armature, mut states, mut end) = (vec![0.0; n], Vec::new(), 0);
    for effect in effects {
        effect.add_armature(&mut armature);
        effect.change_robot(&mut robot.gravity, &mut links);
        states.push(end..end + effect.states(n));
        end += effect.states(n);
    }
    let changed: Vec<f64> = links.iter().flat_map(|link| link.0).collect();
    let mut dynamics = ForwardDynamics::new(&robot, &changed)?;
    let mut world = WorldFrame::new(&plant.robot, &plant.parameters)?;
    dynamics.set_armature(&armature);
    world.set_armature(&armature);
    let survey = Survey::along(motion, duration, effects, &arm, &mut dynamics, &mut world);
    let mut order: Vec<usize> = (0..effects.len()).collect();
    order.sort_by_key(|&i| effects[i].comes_last());
    let equation = Equation {
        plant,
        effects,
        motion,
        control: plant.controller.tune(&survey),
        dynamics,
        armature,
        arm,
        world,
        order,
        states,
        wanted: Reference::new(n),
        tau: vec![0.0; n],
        load: vec![0.0; n],
        net: vec![0.0; n],
    };
    Ok((equation, survey))
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
    let mut state = vec![0.0; 2 * n + equation.own_states()];
    let mut rate = state.clone();
    let mut runge_kutta = RungeKutta4::new(state.len());
    let mut implicit = Implicit::new(n, equation.own_states());
    let method = equation.plant.method;
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
            let t = t + sub as f64 * step;
            match method {
                Method::Implicit => implicit.step(t, step, &mut state, &mut equation),
                Method::RungeKutta => {
                    runge_kutta.step(t, step, &mut state, |t, x, out| equation.rate(t, x, out));
                }
            }
        }
    }
    Ok((truth, square.iter().map(|s| (s / samples as f64).sqrt()).collect()))
}

impl Truth {
    fn with_capacity(n: usize, samples: usize) -> Self {
        let columns = || vec![Vec::with_capacity(samples); n];
        let t = Vec::with_capacity(samples);
        let (q, dq, ddq, tau, load) = (columns(), columns(), columns(), columns(), columns());
        Self { t, q, dq, ddq, tau, load, channels: BTreeMap::new() }
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
        for (effect, own) in equation.effects.iter().zip(&equation.states) {
            effect.measure(&equation.moment(t, state, own), &mut |name, value| {
                self.channels.entry(name.to_string()).or_default().push(value);
            });
        }
        Ok(())
    }
}
