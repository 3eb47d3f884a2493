//! The classical Runge-Kutta method of order four with a fixed step.

/// Workspace of the method for states of one length.
#[derive(Debug, Clone)]
pub struct RungeKutta4 {
    rates: [Vec<f64>; 4],
    stage: Vec<f64>,
}

impl RungeKutta4 {
    /// For states of `length` numbers.
    pub fn new(length: usize) -> Self {
        Self { rates: std::array::from_fn(|_| vec![0.0; length]), stage: vec![0.0; length] }
    }

    /// Moves `state` from time `t` by `step` along `rate(t, state, out)`, which writes the derivative.
    ///
    /// # Panics
    /// When `state` does not have the length that the workspace was made for.
    pub fn step(
        &mut self,
        t: f64,
        step: f64,
        state: &mut [f64],
        mut rate: impl FnMut(f64, &[f64], &mut [f64]),
    ) {
        let [k1, k2, k3, k4] = &mut self.rates;
        let stage = &mut self.stage;
        rate(t, state, k1);
        let mut towards = |fraction: f64, slope: &[f64], out: &mut [f64]| {
            for (s, (x, k)) in stage.iter_mut().zip(state.iter().zip(slope)) {
                *s = x + fraction * step * k;
            }
            rate(t + fraction * step, stage, out);
        };
        towards(0.5, k1, k2);
        towards(0.5, k2, k3);
        towards(1.0, k3, k4);
        for (i, x) in state.iter_mut().enumerate() {
            *x += step / 6.0 * (k1[i] + 2.0 * k2[i] + 2.0 * k3[i] + k4[i]);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::super::{ForwardDynamics, WorldFrame};
    use super::*;
    use lacuna_base::error::Result;
    use lacuna_base::robot::Robot;
    use lacuna_base::robot::samples;

    /// Free fall of `robot` under viscous damping `d` on every joint: relative change of the energy, work
    /// of the dampers included, after one second in `steps` steps.
    fn energy_error(robot: &Robot, damping: f64, steps: usize) -> Result<f64> {
        let parameters = robot.inertial_parameters()?;
        let n = robot.dof();
        let mut dynamics = ForwardDynamics::new(robot, &parameters)?;
        let mut world = WorldFrame::new(robot, &parameters)?;
        let mut state = vec![0.0; 2 * n + 1];
        for j in 0..n {
            (state[j], state[n + j]) = (0.3 + 0.2 * j as f64, 0.5 - 0.1 * j as f64);
        }
        let mut energy = |state: &[f64]| world.energy(&state[..n], &state[n..2 * n]);
        let before = energy(&state);
        let mut method = RungeKutta4::new(state.len());
        let mut tau = vec![0.0; n];
        let h = 1.0 / steps as f64;
        let mut turnover = 0.0_f64;
        for k in 0..steps {
            method.step(k as f64 * h, h, &mut state, |_, x, rate| {
                let (q, dq) = (&x[..n], &x[n..2 * n]);
                tau.iter_mut().zip(dq).for_each(|(t, v)| *t = -damping * v);
                dynamics.acceleration(q, dq, &tau, &mut rate[n..2 * n]);
                rate[..n].copy_from_slice(dq);
                rate[2 * n] = damping * dq.iter().map(|v| v * v).sum::<f64>();
            });
            turnover = turnover.max(energy(&state).kinetic);
        }
        if damping > 0.0 {
            assert!(state[2 * n] > 0.1 * turnover, "the dampers must have something to do");
        }
        Ok((energy(&state).total() + state[2 * n] - before.total()).abs() / turnover)
    }

    #[test]
    fn free_motion_keeps_its_energy_and_dampers_take_what_they_work() -> Result<()> {
        for robot in
            [samples::two_link(), samples::two_link_far_frames(), samples::seven_joint(), samples::branched()]
        {
            for damping in [0.0, 0.4] {
                let error = energy_error(&robot, damping, 20_000)?;
                assert!(error < 1e-9, "{} with damping {damping}: {error:e}", robot.name);
            }
        }
        Ok(())
    }

    #[test]
    fn halving_the_step_divides_the_error_by_sixteen() -> Result<()> {
        // Against the exact solution of an oscillator: (cos t, -sin t).
        let error = |steps: u32| {
            let (mut method, mut state) = (RungeKutta4::new(2), [1.0, 0.0]);
            let h = 2.0 / f64::from(steps);
            (0..steps).for_each(|k| {
                method.step(f64::from(k) * h, h, &mut state, |_, x, rate| (rate[0], rate[1]) = (x[1], -x[0]));
            });
            (state[0] - 2.0_f64.cos()).hypot(state[1] + 2.0_f64.sin())
        };
        for steps in [20, 40, 80] {
            let order = (error(steps) / error(2 * steps)).log2();
            assert!((order - 4.0).abs() < 0.1, "order {order} at {steps} steps");
        }
        Ok(())
    }

    #[test]
    fn robots_converge_with_order_four() -> Result<()> {
        for robot in [samples::two_link(), samples::seven_joint()] {
            let end = |steps: u32| -> Result<Vec<f64>> {
                let n = robot.dof();
                let mut dynamics = ForwardDynamics::new(&robot, &robot.inertial_parameters()?)?;
                let (mut method, mut state) = (RungeKutta4::new(2 * n), vec![0.3; 2 * n]);
                let (h, tau) = (0.5 / f64::from(steps), vec![0.0; n]);
                for k in 0..steps {
                    method.step(f64::from(k) * h, h, &mut state, |_, x, rate| {
                        dynamics.acceleration(&x[..n], &x[n..], &tau, &mut rate[n..]);
                        rate[..n].copy_from_slice(&x[n..]);
                    });
                }
                Ok(state)
            };
            let apart =
                |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| (x - y).powi(2)).sum::<f64>().sqrt();
            let (coarse, middle, fine) = (end(400)?, end(800)?, end(1600)?);
            let order = (apart(&coarse, &middle) / apart(&middle, &fine)).log2();
            assert!((order - 4.0).abs() < 0.25, "{}: order {order}", robot.name);
        }
        Ok(())
    }

    #[test]
    fn time_enters_the_stages() {
        // x' = 4 t^3 is integrated exactly by Simpson's rule up to degree three.
        let (mut method, mut state) = (RungeKutta4::new(1), [0.0]);
        method.step(1.0, 2.0, &mut state, |t, _, rate| rate[0] = 4.0 * t * t * t);
        assert!((state[0] - 80.0).abs() < 1e-12, "{state:?}");
    }
}
