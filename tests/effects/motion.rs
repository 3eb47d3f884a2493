//! A smooth motion known at every time, and the columns of an effect over it.

use std::sync::Arc;

use lacuna::effects::Effect;
use lacuna::kernels::{Chain, State, Workspace, inverse_dynamics};
use lacuna::model::Model;
use lacuna::robot::Robot;
use lacuna::signals::{ModelTorque, Run};

/// Position, velocity and acceleration of joint `j` at time `t`: two sines that come to rest nowhere together.
pub fn joint_at(j: usize, t: f64) -> [f64; 3] {
    let mut state = [0.3 * (j as f64 - 3.0), 0.0, 0.0];
    for (amplitude, rate, phase) in [(0.5, 1.7 + 0.31 * j as f64, 0.4 * j as f64), (0.2, 4.3, 1.1 * j as f64)]
    {
        state[0] += amplitude * libm::sin(rate * t + phase);
        state[1] += amplitude * rate * libm::cos(rate * t + phase);
        state[2] -= amplitude * rate * rate * libm::sin(rate * t + phase);
    }
    state
}

/// Positions, velocities and accelerations of all joints at time `t`.
pub fn at(robot: &Robot, t: f64) -> [Vec<f64>; 3] {
    std::array::from_fn(|k| (0..robot.dof()).map(|j| joint_at(j, t)[k]).collect())
}

/// Inverse dynamics with the robot file's own inertias.
pub fn torque(robot: &Robot, [q, dq, ddq]: &[Vec<f64>; 3]) -> Vec<f64> {
    let chain = Chain::new(robot);
    let mut tau = vec![0.0; robot.dof()];
    let links = robot.inertial_parameters_or_zero();
    inverse_dynamics(&chain, &mut Workspace::new(&chain, 0.0), State::new(q, dq, ddq), &links, &mut tau);
    tau
}

/// The motion sampled at `dt`, with the torque of the rigid links, friction of 0.5 N m s/rad, and a model
/// that knows both.
pub fn run(robot: &Robot, dt: f64, samples: usize) -> Run {
    let n = robot.dof();
    let mut run = Run { name: "motion".to_string(), dt, start: 100.0, ..Run::default() };
    let mut model = ModelTorque { links: robot.inertial_parameters_or_zero(), ..ModelTorque::default() };
    for list in [&mut run.q, &mut run.dq, &mut run.ddq, &mut model.rigid, &mut model.total] {
        *list = vec![Vec::with_capacity(samples); n];
    }
    for k in 0..samples {
        let state = at(robot, k as f64 * dt);
        let tau = torque(robot, &state);
        for j in 0..n {
            run.q[j].push(state[0][j]);
            run.dq[j].push(state[1][j]);
            run.ddq[j].push(state[2][j]);
            model.rigid[j].push(tau[j]);
            model.total[j].push(tau[j] + 0.5 * state[1][j]);
        }
    }
    run.tau = model.total.clone();
    run.model = Some(Arc::new(model));
    run
}

/// Column of each term: `columns[term][joint][sample]`.
pub fn columns(robot: &Robot, run: &Run, effect: &dyn Effect) -> Vec<Vec<Vec<f64>>> {
    let model = Model::new(robot, vec![effect.boxed()]).expect("fits the robot");
    let unit = |term: usize| {
        let mut x = vec![0.0; model.columns.len()];
        x[term] = 1.0;
        let mut column = vec![vec![0.0; run.samples()]; robot.dof()];
        model.add_torque(&x, run, &mut column, |_| true).expect("computes");
        column
    };
    (0..model.columns.len()).map(unit).collect()
}
