//! The signal step on simulated readers with known truth, and on real logs where `LACUNA_DATA` names
//! a folder that has them.

#[path = "signals/thinning.rs"]
mod thinning;

use std::path::PathBuf;

use lacuna::log::Log;
use lacuna::signals::{
    ClockChoice, Folds, Mode, Run, Settings, SignalReport, VelocityFrom, detect_period, prepare,
};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn motion(joint: usize, t: f64) -> [f64; 2] {
    let (a, w) = ([0.8, 0.5][joint], [2.1, 3.3][joint]);
    let slow = 1.0 - libm::exp(-t * t * 4.0); // starts from rest
    let slow_rate = 8.0 * t * libm::exp(-t * t * 4.0);
    let (s, c) = (libm::sin(w * t), libm::cos(w * t));
    [a * slow * s, a * (slow_rate * s + slow * w * c)]
}

/// A log of two joints whose row `k` shows the state at `ticks[k]` ms and is stamped `stamps[k]`.
fn log(ticks: &[f64], stamps: Vec<f64>, noise: f64) -> Log {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(7);
    let last = ticks.last().copied().unwrap_or(0.0) as usize;
    let mut draw =
        |scale: f64| (0..=last).map(|_| scale * (random.random::<f64>() - 0.5)).collect::<Vec<_>>();
    let (q_noise, dq_noise, tau_noise) = (draw(noise), draw(20.0 * noise), draw(1e3 * noise));
    let mut log = Log { name: "simulated.csv".into(), t: stamps, ..Log::default() };
    let state = |j: usize, i: usize, noise: &[f64]| -> Vec<f64> {
        ticks.iter().map(|&n| motion(j, 1e-3 * n)[i] + noise[n as usize]).collect()
    };
    log.q = (0..2).map(|j| state(j, 0, &q_noise)).collect();
    log.dq = Some((0..2).map(|j| state(j, 1, &dq_noise)).collect());
    let tau =
        |j: usize| ticks.iter().map(|&n| libm::cos(1e-3 * n + j as f64) + tau_noise[n as usize]).collect();
    log.tau = (0..2).map(tau).collect();
    log
}

fn even_log(rows: usize, dt_ms: usize) -> Log {
    let ticks: Vec<f64> = (0..rows).map(|k| (k * dt_ms) as f64).collect();
    let stamps = (0..rows).map(|k| (k * dt_ms) as f64 * 1e-3).collect();
    log(&ticks, stamps, 1e-5)
}

/// Polls a 1 kHz state every 0.65 to 1.45 ms, with a late stamp; sometimes it sleeps 6 ms.
fn asynchronous(seconds: f64) -> (Log, Vec<f64>) {
    let mut random = Xoshiro256PlusPlus::seed_from_u64(11);
    let (mut now, mut ticks, mut stamps) = (0.3e-3, Vec::new(), Vec::new());
    while now < seconds {
        ticks.push(libm::floor(now * 1e3));
        stamps.push(now + 0.02 + 2e-4 * random.random::<f64>());
        now += 0.65e-3 + 0.8e-3 * random.random::<f64>();
        now += if random.random::<f64>() < 0.002 { 6e-3 } else { 0.0 };
    }
    (log(&ticks, stamps, 2e-5), ticks)
}

/// Nothing filtered away, nothing trimmed: what the resampling made of the rows.
fn barely_filtered() -> Settings {
    Settings { mode: Mode::Parallel, trim_s: 0.0, ..Settings::default() }
}

fn prepared(log: &Log, settings: &Settings) -> (Run, SignalReport) {
    prepare(log, settings).expect("a usable log")
}

#[test]
fn the_clock_of_an_asynchronous_reader_is_rebuilt_exactly() {
    let (log, ticks) = asynchronous(8.0);
    let (run, report) = prepared(&log, &barely_filtered());
    assert_eq!(report.clock.used, "rebuilt");
    assert!((run.dt - 1e-3).abs() < 1e-15, "{}", run.dt);
    let repeats = ticks.windows(2).filter(|w| w[1] - w[0] < 0.5).count();
    assert_eq!(report.rows_dropped["stale"], repeats);
    assert!(repeats > 200);
    // The torque is untouched in this mode, so every logged one must stand at its own tick, counted
    // from the end; at rest, in the first 0.1 s, nothing but the stamps can tell.
    let last = ticks[ticks.len() - 1];
    for (row, tick) in ticks.iter().enumerate().filter(|(_, tick)| **tick >= 100.0) {
        let sample = run.samples() - 1 - (last - tick) as usize;
        assert_eq!(run.tau[0][sample].to_bits(), log.tau[0][row].to_bits(), "row {row}");
    }
    let total = (last - ticks[0]) as usize + 1;
    assert!(report.samples.abs_diff(total) <= 2, "{} of {total}", report.samples);
    let (before, after) =
        (report.clock.velocity_mismatch_stamps.unwrap_or(0.0), report.clock.velocity_mismatch_used);
    assert!(before > 5.0 * after.unwrap_or(f64::INFINITY), "{:?}", report.clock);
}

#[test]
fn a_velocity_in_other_units_proves_nothing() {
    let (mut log, _) = asynchronous(4.0);
    for dq in log.dq.iter_mut().flatten().flatten() {
        *dq = dq.to_degrees();
    }
    let (_, report) = prepared(&log, &barely_filtered());
    assert_ne!(report.clock.used, "rebuilt");
}

#[test]
fn without_velocities_the_stamps_stay() {
    let (mut log, _) = asynchronous(4.0);
    log.dq = None;
    let (_, report) = prepared(&log, &barely_filtered());
    assert_eq!(report.clock.used, "stamps");
    assert_eq!(report.source_of_velocity, "position");
    let forced = Settings { clock: ClockChoice::Rebuilt, ..barely_filtered() };
    let error = prepare(&log, &forced).expect_err("there is nothing to rebuild it from").to_string();
    assert!(error.contains("simulated.csv") && error.contains("help"), "{error}");
}

#[test]
fn a_regular_log_is_not_touched_before_the_filter() {
    for dt_ms in [1, 8, 10] {
        let log = even_log(2000, dt_ms);
        let (run, report) = prepared(&log, &barely_filtered());
        assert_eq!((report.clock.used, report.samples_filled), ("even", 0));
        assert!(report.rows_dropped.is_empty(), "{:?}", report.rows_dropped);
        let same = |a: &[f64], b: &[f64]| a.iter().zip(b).all(|(a, b)| a.to_bits() == b.to_bits());
        assert!(run.tau.iter().zip(&log.tau).all(|(a, b)| a.len() == b.len() && same(a, b)));
    }
}

#[test]
fn a_noise_free_rest_is_kept_and_a_stuck_logger_is_not() {
    let mut rest = even_log(4000, 1);
    let freeze = |log: &mut Log| {
        let dq = log.dq.iter_mut().flatten();
        for column in log.q.iter_mut().chain(dq).chain(&mut log.tau) {
            let value = column[1500];
            column[1500..2000].fill(value);
        }
    };
    freeze(&mut rest);
    let (_, report) = prepared(&rest, &barely_filtered());
    assert_eq!(report.rows_dropped["stale"], 499, "the logger was stuck while the robot moved");
    assert_eq!(report.segments.len(), 2);

    freeze(&mut rest);
    for column in rest.dq.iter_mut().flatten() {
        column[1500..2000].fill(0.0);
    }
    let (_, report) = prepared(&rest, &barely_filtered());
    assert!(report.rows_dropped.is_empty(), "velocity zero is a rest: {:?}", report.rows_dropped);
}

#[test]
fn rows_out_of_order_and_wild_stamps_are_left_out_alone() {
    let clean = even_log(3000, 1);
    let mut log = clean.clone();
    log.t[500] = 1e9; // one wild stamp must not cost the rows after it
    log.t[800] = 0.1;
    log.t[901] = log.t[900];
    log.q[1][1000] = f64::NAN;
    let (run, report) = prepared(&log, &barely_filtered());
    let dropped = |why: &str| report.rows_dropped.get(why).copied().unwrap_or(0);
    assert_eq!((dropped("out of order"), dropped("time repeats"), dropped("not a number")), (2, 1, 1));
    assert_eq!((report.samples, report.samples_filled), (3000, 4));
    for k in [500, 800, 901, 1000] {
        let middle = 0.5 * (clean.tau[0][k - 1] + clean.tau[0][k + 1]);
        assert!((run.tau[0][k] - middle).abs() < 1e-12, "row {k} is filled linearly");
    }
    let untouched = (0..3000).filter(|k| ![500, 800, 901, 1000].contains(k));
    assert!(untouched.into_iter().all(|k| run.tau[0][k].to_bits() == clean.tau[0][k].to_bits()));
}

#[test]
fn at_a_long_gap_the_longest_stretch_is_kept() {
    let mut log = even_log(3000, 1);
    log.t[1200..].iter_mut().for_each(|t| *t += 3000.0);
    let (run, report) = prepared(&log, &barely_filtered());
    assert_eq!(report.segments.len(), 2);
    assert_eq!((report.segments[0].used, report.segments[1].used), (false, true));
    assert_eq!(report.rows_dropped["outside the longest stretch"], 1200);
    assert!((run.start - 3001.2).abs() < 1e-9);
    assert_eq!(run.samples(), 1800);
}

#[test]
fn differentiation_recovers_the_motion() {
    let ticks: Vec<f64> = (0..6000).map(f64::from).collect();
    let stamps = ticks.iter().map(|n| n * 1e-3).collect();
    let log = log(&ticks, stamps, 0.0);
    for velocity_from in [VelocityFrom::Position, VelocityFrom::Velocity] {
        let settings = Settings { velocity_from, band_hz: 20.0, trim_s: 1.0, ..Settings::default() };
        let (run, report) = prepared(&log, &settings);
        assert_eq!((run.samples(), report.rows_used), (4000, 4000));
        for k in (0..4000).step_by(97) {
            let t = run.start + k as f64 * run.dt;
            let rate = (motion(1, t + 1e-5)[1] - motion(1, t - 1e-5)[1]) / 2e-5;
            assert!((run.q[1][k] - motion(1, t)[0]).abs() < 1e-5);
            assert!((run.dq[1][k] - motion(1, t)[1]).abs() < 1e-4);
            assert!((run.ddq[1][k] - rate).abs() < 1e-3, "{velocity_from:?} {t}: {} {rate}", run.ddq[1][k]);
        }
    }
}

#[test]
fn parallel_rows_match_torque_filtered_trimmed_and_decimated() {
    let log = even_log(6000, 1);
    let inputs = prepared(&log, &Settings { decimate: Some(40), ..Settings::default() }).0;
    let (parallel, report) = prepared(&log, &Settings { mode: Mode::Parallel, ..Settings::default() });
    assert_eq!((parallel.samples(), report.decimate), (6000, 40));
    assert_eq!(parallel.rows().count, report.rows_used);
    assert_eq!(parallel.to_rows(&parallel.tau[1]).as_ref(), &inputs.tau[1]);
    assert_eq!(parallel.rows(), inputs.rows());
}

#[test]
fn settings_that_do_not_fit_the_log_say_so() {
    let log = even_log(1000, 10);
    for settings in
        [Settings { band_hz: 50.0, ..Settings::default() }, Settings { trim_s: 5.0, ..Settings::default() }]
    {
        let error = prepare(&log, &settings).expect_err("must be refused").to_string();
        assert!(error.contains("simulated.csv") && error.contains("help"), "{error}");
    }
    // What no log can mend is not blamed on the log.
    let steep = prepare(&log, &Settings { order: 12, ..Settings::default() }).expect_err("must be refused");
    assert!(steep.place().is_none() && steep.message().contains("`order` is 12"), "{steep}");
    assert!(prepare(&Log::default(), &Settings::default()).is_err());
    assert!(prepare(&even_log(2, 1), &Settings::default()).is_err());
}

#[test]
fn reports_fit_the_screen_and_json() {
    let (log, _) = asynchronous(4.0);
    let (_, report) = prepared(&log, &Settings { mode: Mode::Parallel, ..Settings::default() });
    let lines = report.lines();
    assert!((4..=8).contains(&lines.len()), "{lines:#?}");
    assert!(lines.iter().all(|line| line.chars().count() <= 80));
    let json = serde_json::to_value(&report).expect("plain data");
    assert_eq!(json["mode"], "parallel");
    assert_eq!(json["clock"]["used"], "rebuilt");
}

proptest::proptest! {
    #![proptest_config(proptest::prelude::ProptestConfig::with_cases(300))]
    #[test]
    fn whatever_the_log_holds_the_answer_is_a_motion_or_a_message(
        rows in proptest::collection::vec((-1e3..1e3f64, -3.0..3.0f64, 0..9u8), 0..200),
        velocities in proptest::bool::ANY,
    ) {
        let mut log = Log { name: "wild.csv".into(), q: vec![vec![]], tau: vec![vec![]], ..Log::default() };
        for (k, (time, value, kind)) in rows.iter().enumerate() {
            let even = 0.01 * k as f64;
            log.t.push(match kind { 0 => *time, 1 => f64::NAN, 2 => even - 0.01, 3 => even + 1e-9 * time, _ => even });
            log.q[0].push(match kind { 4 => f64::INFINITY, 5 => 0.0, _ => *value });
            log.tau[0].push(if *kind == 5 { 0.0 } else { -value });
        }
        log.dq = velocities.then(|| log.q.clone());
        for settings in [barely_filtered(), Settings { trim_s: 0.05, ..Settings::default() }] {
            match prepare(&log, &settings) {
                Ok((run, report)) => {
                    let all = run.q.iter().chain(&run.dq).chain(&run.ddq).chain(&run.tau);
                    assert!(all.flatten().all(|x| x.is_finite()));
                    let left_out: usize = report.rows_dropped.values().sum();
                    assert!(left_out < report.rows_read);
                    detect_period(&run);
                }
                Err(error) => assert!(error.to_string().contains("wild.csv"), "{error}"),
            }
        }
    }
}

// ---- real logs ----

fn data(file: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LACUNA_DATA") else {
        println!("skipped: LACUNA_DATA is not set");
        return None;
    };
    Some(PathBuf::from(folder).join(file)).filter(|path| path.exists())
}

/// A table of numbers with a header line, column by column.
fn table(path: &PathBuf) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("a readable file");
    let mut columns: Vec<Vec<f64>> = Vec::new();
    for line in text.lines().skip(1) {
        let row: Vec<f64> = line.split(',').map(|x| x.parse().expect("a number")).collect();
        columns.resize(row.len(), Vec::new());
        columns.iter_mut().zip(row).for_each(|(c, x)| c.push(x));
    }
    columns
}

fn real_log(path: &PathBuf, joints: usize, tau_from: usize) -> Log {
    let c = table(path);
    let part = |from: usize| c[from..from + joints].to_vec();
    Log {
        name: path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned()),
        t: c[0].clone(),
        q: part(1),
        dq: Some(part(1 + joints)),
        tau: part(tau_from),
        ..Log::default()
    }
}

#[test]
fn panda_clock_agrees_with_the_reference() {
    let Some(path) = data("panda/exciting.csv") else { return };
    let log = real_log(&path, 7, 15);
    let (run, report) = prepared(&log, &Settings::default());
    println!("{}\n{}", report.lines().join("\n"), serde_json::to_string(&report.clock).expect("plain data"));
    assert_eq!(report.clock.used, "rebuilt");
    assert!((run.dt - 1e-3).abs() < 1e-15);
    // The stamps span 20.9991 s. The reference counts 26 ticks fewer: 21 in the first 80 ms, where the
    // robot hardly moves, one at the end, the others at records that were written while they were read.
    assert!(report.samples.abs_diff(21000) <= 2, "{}", report.samples);
    assert_eq!(report.rows_dropped["stale"], 1257);
    let mismatch = |x: Option<f64>| x.expect("velocities are logged");
    assert!(mismatch(report.clock.velocity_mismatch_stamps) > 0.15);
    assert!(mismatch(report.clock.velocity_mismatch_used) < 0.012);
    compare_ticks(&log, &table(&data("panda/exciting_ticks.csv").expect("beside the log")));
    let tail = real_log(&data("panda/validation.csv").expect("beside the log"), 7, 15);
    assert_eq!(prepared(&tail, &Settings::default()).1.clock.used, "rebuilt");
}

/// Compares tick by tick: the torque is untouched in `Parallel`, so a row is found by its values.
fn compare_ticks(log: &Log, reference: &[Vec<f64>]) {
    let (run, _) = prepared(log, &Settings { mode: Mode::Parallel, ..Settings::default() });
    let mut sample = 0;
    let (mut rows, mut differ, mut before) = (0, Vec::new(), 0.0);
    for row in (120..log.rows()).filter(|&row| reference[2][row] < 0.5) {
        let shows = |k: &usize| (0..7).all(|j| run.tau[j][*k].to_bits() == log.tau[j][row].to_bits());
        let Some(found) = (sample..run.samples().min(sample + 400)).find(shows) else { continue };
        sample = found + 1;
        let difference = found as f64 - reference[1][row];
        if rows > 0 && (before - difference).abs() > 0.5 {
            differ.push((row, difference - before));
        }
        before = difference;
        rows += 1;
    }
    println!("{rows} rows found; steps that differ (row, ticks): {differ:?}");
    assert!(rows > 19_100 && differ.len() <= 15, "{rows} {differ:?}");
    assert!(differ.iter().all(|(_, ticks)| ticks.abs() < 1.5));
}

#[test]
fn panda_motion_repeats_after_its_period() {
    let Some(path) = data("panda/exciting.csv") else { return };
    for settings in
        [Settings::default(), Settings { mode: Mode::Parallel, trim_s: 1.0, ..Settings::default() }]
    {
        let (run, _) = prepared(&real_log(&path, 7, 15), &settings);
        let period = detect_period(&run).expect("it repeats");
        println!("period {period}");
        assert!((period - 13.333).abs() < 0.002, "{period}");
        let folds = Folds::choose(&[&run]).expect("long enough");
        assert_eq!((folds.count, folds.fold.len()), (8, run.rows().count));
        assert!(folds.description.contains("same-phase"));
    }
}

/// A robot that waits before its motion: stiction holds any torque while it does.
#[test]
fn what_stands_still_before_the_motion_is_left_out() {
    let moving = even_log(6000, 1);
    let wait = |column: &[f64]| [vec![column[0]; 3000], column.to_vec()].concat();
    let each = |columns: &[Vec<f64>]| -> Vec<Vec<f64>> { columns.iter().map(|c| wait(c)).collect() };
    let dq = moving.dq.as_ref().map(|dq| dq.iter().map(|c| [vec![0.0; 3000], c.clone()].concat()).collect());
    let t = (0..9000).map(|k| 1e-3 * f64::from(k)).collect();
    let waiting = Log { t, q: each(&moving.q), dq, tau: each(&moving.tau), ..moving.clone() };
    let settings = Settings { trim_s: 0.5, ..Settings::default() };
    let (run, report) = prepared(&waiting, &settings);
    let dropped = report.rows_dropped["standing still at the ends"];
    // What is trimmed anyway may stand still; it leaves its place within a few hundredths of a second.
    assert!((2500..2700).contains(&dropped), "{dropped}");
    assert!((run.start - 3.0).abs() < 0.2, "{}", run.start);
    let (_, report) = prepared(&moving, &settings);
    assert!(!report.rows_dropped.contains_key("standing still at the ends"), "{:?}", report.rows_dropped);
}

/// One row that jumps while all else stands is no motion; and what creeps slower than anything can be told stays whole
/// or loses its ends, but is prepared.
#[test]
fn creeping_and_a_jump_are_no_motion_from_rest() {
    let t: Vec<f64> = (0..3000).map(|k| 0.01 * f64::from(k)).collect();
    let dropped = |q: Vec<f64>| {
        let log = Log {
            name: "creep.csv".into(),
            t: t.clone(),
            q: vec![q],
            tau: vec![t.clone()],
            ..Log::default()
        };
        let (run, report) = prepared(&log, &Settings::default());
        assert!(run.samples() > 100, "{:?}", report.rows_dropped);
        report.rows_dropped.get("standing still at the ends").copied().unwrap_or(0)
    };
    let creep = |travel: f64| t.iter().map(|t| travel * t / 30.0).collect::<Vec<f64>>();
    let mut jump = vec![0.3; 3000];
    jump[1500] = 0.4;
    assert_eq!((dropped(jump), dropped(creep(0.06))), (0, 0));
    assert!(dropped(creep(2.5e-3)) < 1500);
}

#[test]
fn ur10e_stamps_are_believed() {
    for file in ["unloaded_a.csv", "unloaded_b.csv", "unloaded_c.csv", "loaded_c.csv"] {
        let Some(path) = data(&format!("ur10e/{file}")) else { return };
        let (run, report) = prepared(&real_log(&path, 6, 19), &Settings::default());
        println!("{}\nperiod {:?}", report.lines().join("\n"), detect_period(&run));
        assert_eq!(report.clock.used, "stamps");
        assert!((run.dt - 0.01).abs() < 1e-12);
        // Two of them stand still before their motion; nothing else is left out of any.
        let mut dropped = report.rows_dropped.clone();
        let stood = dropped.remove("standing still at the ends").unwrap_or(0);
        assert!(dropped.values().sum::<usize>() <= 1, "{dropped:?}");
        assert_eq!(stood > 0, file.ends_with("_c.csv"), "{stood} rows of {file}");
    }
}
