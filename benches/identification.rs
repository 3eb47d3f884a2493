//! Time and memory of identification: a million samples, one real log, and the steps in between.
//!
//! `cargo bench --bench identification`, with `LACUNA_DATA=<folder with panda/exciting.csv>` for the
//! public log. Prints the best of a few runs, wall clock, and the process's peak memory (Linux).

use std::hint::black_box;
use std::path::Path;
use std::time::Instant;

use lacuna::Result;
use lacuna::effects::classic;
use lacuna::excitation::{Motion, panda_table_ii};
use lacuna::identify::{Evidence, Weighting, fit, fit_huber, held_out, with_robust_sd};
use lacuna::kernels::{Samples, inverse_dynamics_batch};
use lacuna::log::Log;
use lacuna::model::Model;
use lacuna::predict::predict;
use lacuna::robot::Robot;
use lacuna::signals::{Folds, Run, ZeroPhase};
use lacuna::study;
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const MILLION: usize = 1_000_000;

fn main() -> Result<()> {
    let robot = Robot::open("robots/panda.ron")?;
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    println!("Seven joints, {threads} threads unless said otherwise\n");
    csv(&robot)?;
    filter()?;
    public_log()?;
    million(&robot, threads)
}

/// Best of `times` runs, printed with a note.
fn timed<T>(what: &str, times: usize, note: &str, mut work: impl FnMut() -> Result<T>) -> Result<T> {
    let (mut best, mut last) = (f64::INFINITY, None);
    for _ in 0..times {
        drop(last.take());
        let start = Instant::now();
        last = Some(black_box(work()?));
        best = best.min(start.elapsed().as_secs_f64());
    }
    let time = if best < 1.0 { format!("{:8.2} ms", best * 1e3) } else { format!("{best:8.2} s ") };
    println!("{what:<58} {time}   {note}");
    last.ok_or_else(|| lacuna::Error::new("nothing was run"))
}

fn csv(robot: &Robot) -> Result<()> {
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(3);
    let mut text = String::from("t");
    for name in ["q", "dq", "tau"] {
        (1..=7).for_each(|j| text += &format!(",{name}{j}"));
    }
    for row in 0..20_000 {
        text += &format!("\n{:.3}", f64::from(row) * 1e-3);
        (0..21).for_each(|_| text += &format!(",{:.7}", rng.random_range(-3.0..3.0)));
    }
    let what = format!("CSV from memory, 20 000 rows x 22, {:.1} MB", text.len() as f64 * 1e-6);
    timed(&what, 10, "", || Log::from_reader(text.as_bytes(), "memory", robot, None))?;
    Ok(())
}

fn filter() -> Result<()> {
    let low_pass = ZeroPhase::butterworth(4, 5.0, 1e-3)?;
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(4);
    let signal: Vec<f64> = (0..100_000).map(|_| rng.random_range(-1.0..1.0)).collect();
    timed("zero-phase filter of order 4, 100 000 samples", 10, "", || {
        let mut copy = signal.clone();
        low_pass.apply(&mut copy);
        Ok(copy)
    })?;
    Ok(())
}

fn public_log() -> Result<()> {
    const WHAT: &str = "scenarios/panda_log.ron";
    let there =
        std::env::var_os("LACUNA_DATA").is_some_and(|d| Path::new(&d).join("panda/exciting.csv").exists());
    if !there {
        println!("{WHAT:<58}  skipped    set LACUNA_DATA");
        return Ok(());
    }
    let run = || {
        let mut quiet = |_: &str| {};
        let options = study::Options::new(&mut quiet);
        study::run(Path::new(WHAT), options)
    };
    let outcome = timed(&format!("{WHAT}, all steps"), 3, "aim: < 1 s", run)?;
    for (step, seconds) in &outcome.report.timing {
        println!("    {step:<54} {:8.2} ms   (last run)", seconds * 1e3);
    }
    Ok(())
}

/// A million samples of the paper's exciting motion with classical friction and noise.
fn synthetic(model: &Model, samples: usize) -> Result<Run> {
    let (n, dt) = (model.robot.dof(), 1e-3);
    let motion = panda_table_ii();
    let mut state = [(); 3].map(|()| vec![vec![0.0; samples]; n]);
    let mut at = [(); 3].map(|()| vec![0.0; n]);
    for k in 0..samples {
        let [q, dq, ddq] = &mut at;
        motion.at(k as f64 * dt, q, dq, ddq);
        for (columns, now) in state.iter_mut().zip(&at) {
            columns.iter_mut().zip(now).for_each(|(column, value)| column[k] = *value);
        }
    }
    let [q, dq, ddq] = state;
    let parameters = model.robot.inertial_parameters()?;
    let mut tau = inverse_dynamics_batch(&model.chain, Samples { q: &q, dq: &dq, ddq: &ddq }, &parameters);
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(5);
    for (tau, dq) in tau.iter_mut().zip(&dq) {
        for (t, v) in tau.iter_mut().zip(dq) {
            *t += 0.3 * v + 0.2 * v.signum() + 0.05 + rng.random_range(-0.1..0.1);
        }
    }
    Ok(Run { name: "synthetic".into(), dt, q, dq, ddq, tau, ..Run::default() })
}

fn million(robot: &Robot, threads: usize) -> Result<()> {
    let model = Model::new(robot, classic())?;
    let runs = [synthetic(&model, MILLION)?];
    let held = peak_mb();
    println!("\n1 000 000 samples, {} columns, 7 000 000 rows", model.columns.len());
    let whole = Folds { fold: vec![0; MILLION], count: 1, description: "one".into() };
    let folds = Folds::contiguous(&[runs[0].rows()], 2.0, 8)?;
    let note = format!("aim: < 6 s on 2 threads, all three steps; {threads} threads here");
    let evidence = timed("streaming QR", 3, &note, || Evidence::collect(&model, &runs, &whole))?;
    let fitted = timed("fit", 3, "", || fit(&model, &evidence, None, Weighting::Ordinary))?;
    let robust = || with_robust_sd(&model, &runs, &evidence, fitted.clone());
    timed("standard deviations robust to autocorrelation", 3, "", robust)?;
    let after = peak_mb();
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().expect("a pool of one thread");
    one.install(|| timed("streaming QR, one thread", 2, "", || Evidence::collect(&model, &runs, &whole)))?;
    let split = timed("streaming QR, 8 folds", 2, "", || Evidence::collect(&model, &runs, &folds))?;
    timed("held-out error, 8 folds", 2, "", || held_out(&model, &split, Weighting::Ordinary))?;
    timed("robust (Huber) fit", 1, "", || fit_huber(&model, &runs, &whole, &evidence))?;
    timed("prediction", 2, "", || predict(&model, &runs, &fitted.x))?;
    println!(
        "peak memory: {held:.0} MB with the motion alone, {after:.0} MB after the fit (aim: < 300 MB); \
         relative error {:.4} %, condition number {:.1}",
        fitted.errors.pooled_percent, fitted.condition_number
    );
    Ok(())
}

/// Largest resident memory of this process so far [MB]; NaN where the system does not tell.
fn peak_mb() -> f64 {
    let status = std::fs::read_to_string("/proc/self/status").unwrap_or_default();
    let line = status.lines().find_map(|l| l.strip_prefix("VmHWM:"));
    let kilobytes = line.and_then(|l| l.trim().trim_end_matches("kB").trim().parse::<f64>().ok());
    kilobytes.map_or(f64::NAN, |kb| kb * 1024e-6)
}
