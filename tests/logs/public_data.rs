//! Public logs, where they are at hand: the folder is named by `LACUNA_DATA`.

use super::*;
use lacuna::log::StaticPoses;
use std::time::Instant;

fn data(path: &str) -> Option<PathBuf> {
    let Some(folder) = std::env::var_os("LACUNA_DATA") else {
        println!("skipped: LACUNA_DATA is not set");
        return None;
    };
    Some(PathBuf::from(folder).join(path))
}

/// All numbers of a clean table, row by row, the slow way.
fn naive(path: &PathBuf) -> Vec<Vec<f64>> {
    let text = std::fs::read_to_string(path).expect("the data are text");
    let row = |line: &str| line.split(',').map(|x| x.parse().expect("a number")).collect();
    text.lines().skip(1).map(row).collect()
}

#[test]
fn the_panda_log_reads_exactly_and_fast() -> lacuna::Result<()> {
    let Some(path) = data("panda/exciting.csv") else { return Ok(()) };
    let robot = chain(7);
    let log = Log::open(&path, &robot, None)?;
    assert_eq!(log.rows(), 20_544);
    assert!(log.dropped.is_empty() && log.channels.is_empty());
    let dq = log.dq.as_ref().expect("dq is logged");
    for (k, row) in naive(&path).iter().enumerate() {
        let ours: Vec<f64> =
            std::iter::once(&log.t).chain(&log.q).chain(dq).chain(&log.tau).map(|c| c[k]).collect();
        assert_same(&ours, row);
    }
    let best = (0..10)
        .map(|_| {
            let start = Instant::now();
            let rows = Log::open(&path, &robot, None).map_or(0, |log| log.rows());
            assert_eq!(rows, 20_544);
            start.elapsed()
        })
        .min()
        .unwrap_or_default();
    println!("{best:?}, {:.1} ns per number", best.as_secs_f64() * 1e9 / (20_544.0 * 22.0));
    Ok(())
}

#[test]
fn the_static_poses_read_exactly() -> lacuna::Result<()> {
    let Some(path) = data("panda/static_1010.csv") else { return Ok(()) };
    let poses = StaticPoses::open(&path, &chain(7))?;
    assert_eq!((poses.rows(), poses.m.len()), (1010, 28));
    for (k, row) in naive(&path).iter().enumerate() {
        let ours: Vec<f64> = poses.q.iter().chain(&poses.g).chain(&poses.m).map(|c| c[k]).collect();
        assert_same(&ours, row);
    }
    Ok(())
}

#[test]
fn the_ur10e_currents_give_the_torques() -> lacuna::Result<()> {
    let Some(path) = data("ur10e/unloaded_a.csv") else { return Ok(()) };
    let robot = chain(6);
    let log = Log::open(&path, &robot, None)?;
    let map = ColumnMap {
        torque: ColumnMap::parse(
            "(torque: (current: \"current{1}\", gains: [14.87, 13.26, 11.13, 10.62, 11.03, 11.47]))",
        )?
        .torque,
        ..ColumnMap::default()
    };
    let mapped = Log::open(&path, &robot, Some(&map))?;
    assert_eq!(mapped.q, log.q);
    assert_eq!(mapped.channels["current3"], log.channels["current3"]);
    for (ours, theirs) in mapped.tau.iter().flatten().zip(log.tau.iter().flatten()) {
        assert!((ours - theirs).abs() < 1e-3, "{ours} is not {theirs}");
    }
    Ok(())
}
