//! Very long logs: what is kept of them, and what is said of it.

use lacuna::log::Log;
use lacuna::signals::{Mode, Settings, thinned};

use super::{even_log, prepared};

/// Two joints at 1 kHz, with a hum of 400 Hz on the torque that every fourth sample alone would fold to 100 Hz.
fn humming(seconds: usize) -> Log {
    let mut log = even_log(1000 * seconds, 1);
    for (k, tau) in log.tau[0].iter_mut().enumerate() {
        *tau += 5.0 * libm::sin(std::f64::consts::TAU * 0.4 * k as f64);
    }
    log
}

#[test]
fn thinning_keeps_the_motion_and_folds_nothing_into_the_band() {
    let log = humming(20);
    let settings = Settings { mode: Mode::Parallel, thin_to_hz: Some(250.0), ..Settings::default() };
    let thin = thinned(log.clone(), &settings).expect("it can be thinned");
    assert_eq!((thin.rows(), thin.row_keys()), (5000, log.row_keys()), "its rows are known by their keys");
    for k in (500..4500).step_by(7) {
        assert!((thin.t[k] - log.t[4 * k]).abs() < 1e-9);
        let clean = libm::cos(log.t[4 * k]);
        assert!((thin.tau[0][k] - clean).abs() < 0.03, "{k}: {} {clean}", thin.tau[0][k]);
        assert!((thin.q[1][k] - log.q[1][4 * k]).abs() < 1e-4);
    }
    let (run, report) = prepared(&log, &settings);
    assert_eq!(run, prepared(&thin, &settings).0, "thinned before or meanwhile");
    let told = report.thinned.as_ref().expect("it says so");
    assert_eq!((told.every, report.rows_read, report.samples), (4, 20_000, 20_000));
    assert!((told.from_hz - 1000.0).abs() < 1e-6 && (told.to_hz - 250.0).abs() < 1e-6, "{told:?}");
    assert!(report.lines().iter().any(|l| l.contains("every 4th sample (250 Hz of 1000 Hz) kept")));
    // In the band nothing is lost: the rows are those of the whole log.
    let whole = prepared(&log, &Settings { thin_to_hz: None, ..settings.clone() }).0;
    let (thin, all) = (run.to_rows(&run.tau[0]), whole.to_rows(&whole.tau[0]));
    let close = |(a, b): (&f64, &f64)| (a - b).abs() < 2e-3;
    assert!((run.rows().dt - whole.rows().dt).abs() < 1e-9 && thin.iter().zip(all.iter()).all(close));
}

#[test]
fn only_very_long_logs_are_thinned_unasked_and_never_where_the_inputs_are_filtered() {
    let parallel = Settings { mode: Mode::Parallel, ..Settings::default() };
    let (short, report) = prepared(&humming(20), &parallel);
    assert!(report.thinned.is_none() && (short.dt - 1e-3).abs() < 1e-12);
    let long = even_log(1_100_000, 1);
    let inputs = thinned(long.clone(), &Settings::default()).expect("nothing to do");
    assert!(inputs.thinned.is_none());
    let (run, report) = prepared(&thinned(long, &parallel).expect("it can be thinned"), &parallel);
    let told = report.thinned.expect("it says so");
    assert_eq!((told.every, report.rows_read), (8, 1_100_000));
    // Two rows per period of 5 Hz would be 12 samples of 8 ms each; ten thousand rows take 13.
    assert!((run.dt - 8e-3).abs() < 1e-12 && (told.rows_hz - 1.0 / 0.104).abs() < 1e-9, "{told:?}");
    let fast = Settings { thin_to_hz: Some(10.0), ..parallel };
    let refused = thinned(even_log(5000, 1), &fast).expect_err("the cut-offs would not fit").to_string();
    assert!(refused.contains("thin_to_hz") && refused.contains("15.0 Hz"), "{refused}");
}
