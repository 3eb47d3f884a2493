//! Dahl's state against its differential equation, integrated by brute force.

use lacuna::effects::{Joints, PreslidingHysteresis};
use lacuna::model::{Model, ModelBlock};
use lacuna::signals::Run;

use super::common::robot;
use super::motion::{columns, run};

fn effect(s: f64, width: f64) -> PreslidingHysteresis {
    PreslidingHysteresis { joints: Joints::Only(vec!["4".to_string()]), s, width }
}

/// Small reversals on top of a slow motion, as in a wrist that dithers.
fn dithering() -> Run {
    let mut run = run(&robot("panda.ron"), 0.004, 1500);
    for k in 0..1500 {
        let t = 0.004 * k as f64;
        run.dq[3][k] = 0.03 * (0.9 * t).cos() + 0.05 * (7.0 * t + 0.3).cos();
    }
    run
}

/// `dz/dt = s (v - |v| z)` by the classical Runge-Kutta scheme, velocity linear between samples.
fn brute_force(v: &[f64], dt: f64, s: f64) -> Vec<f64> {
    const STEPS: usize = 400;
    let rate = |v: f64, z: f64| s * (v - v.abs() * z);
    let mut z = v[0].signum();
    let mut all = vec![z];
    for pair in v.windows(2) {
        let h = dt / STEPS as f64;
        for step in 0..STEPS {
            let at = |part: f64| pair[0] + (pair[1] - pair[0]) * (step as f64 + part) / STEPS as f64;
            let k1 = rate(at(0.0), z);
            let k2 = rate(at(0.5), z + 0.5 * h * k1);
            let k3 = rate(at(0.5), z + 0.5 * h * k2);
            let k4 = rate(at(1.0), z + h * k3);
            z += h * (k1 + 2.0 * k2 + 2.0 * k3 + k4) / 6.0;
        }
        all.push(z);
    }
    all
}

#[test]
fn the_state_solves_dahls_equation() {
    let run = dithering();
    for s in [15.0, 150.0, 1000.0] {
        let column = &columns(&robot("panda.ron"), &run, &effect(s, 0.0))[0][3];
        let state = brute_force(&run.dq[3], run.dt, s);
        let (mut worst, mut lag) = (0.0_f64, 0.0_f64);
        for k in 0..run.samples() {
            let found = column[k] + run.dq[3][k].signum();
            worst = worst.max((found - state[k]).abs());
            lag = lag.max(column[k].abs());
        }
        assert!(worst < 2e-5, "s = {s}: {worst}");
        assert!(lag > 0.5, "the motion shows no hysteresis at s = {s}");
    }
}

#[test]
fn where_a_run_is_cut_does_not_matter() {
    let run = dithering();
    for s in [15.0, 300.0] {
        let model = Model::new(&robot("panda.ron"), vec![Box::new(effect(s, 0.01))]).expect("fits the robot");
        let mut whole = ModelBlock::new(&model, run.samples());
        model.fill(&run, 0..run.samples(), &mut whole).expect("fills");
        let whole = whole.column(3, 0, run.samples()).to_vec();
        for range in [0..1, 3..700, 700..701, 901..1500, 1499..1500] {
            let mut part = ModelBlock::new(&model, range.len());
            model.fill(&run, range.clone(), &mut part).expect("fills");
            for (k, y) in range.clone().zip(part.column(3, 0, range.len())) {
                assert!((y - whole[k]).abs() < 1e-14, "s = {s}, sample {k} of {range:?}");
            }
        }
    }
}

#[test]
fn a_stiff_bristle_is_a_sign() {
    let run = dithering();
    let column = &columns(&robot("panda.ron"), &run, &effect(1e9, 0.0))[0][3];
    let off = column.iter().filter(|y| y.abs() > 1e-3).count();
    assert!(off < 5, "{off} samples differ from the sign");
}
