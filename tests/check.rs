//! `check`: right pairs of log and robot are left in peace, every single mistake is named.

#[path = "check/files.rs"]
mod files;
#[path = "check/mistakes.rs"]
mod mistakes;

use std::path::{Path, PathBuf};
use std::sync::OnceLock;

use lacuna::check::{Findings, log_against_robot};
use lacuna::excitation::{FourierMotion, Ramped, panda_table_ii};
use lacuna::log::Log;
use lacuna::plant::{
    CoulombFriction, Method, PerJoint, Plant, Reader, Sensors, SigmoidFriction, ViscousFriction,
};
use lacuna::robot::{JointKind, Robot};
use lacuna::{Error, Result};

fn shipped(name: &str) -> Result<Robot> {
    Robot::open(Path::new(env!("CARGO_MANIFEST_DIR")).join("robots").join(name))
}

fn sensors(torque_noise: f64) -> Sensors {
    Sensors {
        sampling_time_s: 2e-3,
        position_noise: PerJoint::all(1e-5),
        velocity_noise: PerJoint::all(1e-3),
        torque_noise: PerJoint::all(torque_noise),
        ..Sensors::default()
    }
}

fn simulate_panda(robot: Robot, seed: u64) -> Result<Log> {
    let mut plant = Plant::new(robot)?.with_effect(SigmoidFriction::panda()).with_sensors(sensors(0.05));
    plant.sensors.reader = Some(Reader { period_s: 2e-3, stall_s: 4e-3, ..Reader::default() });
    let motion = Ramped::new(panda_table_ii(), 14.0, 0.5)?;
    Ok(plant.simulate(&motion, motion.total_s(), seed)?.log)
}

fn simulate(robot: &Robot, seed: u64) -> Result<Log> {
    let mut plant = Plant::new(robot.clone())?
        .with_effect(ViscousFriction { coefficients: PerJoint::all(0.3) })
        .with_effect(CoulombFriction::new(PerJoint::all(0.2)))
        .with_sensors(sensors(0.02));
    // Steep friction at a millisecond per step: explicitly it takes a hundred times as many on light links.
    plant.method = Method::Implicit;
    let motion = FourierMotion::random(robot, seed, 5, 8.0, 0.7)?;
    let motion = Ramped::new(motion, 12.0, 0.5)?;
    Ok(plant.simulate(&motion, motion.total_s(), seed)?.log)
}

fn panda() -> Result<&'static (Robot, Log)> {
    static PAIR: OnceLock<Result<(Robot, Log)>> = OnceLock::new();
    let make = || {
        let robot = shipped("panda.ron")?;
        let log = simulate_panda(robot.clone(), 3)?;
        Ok((robot, log))
    };
    PAIR.get_or_init(make).as_ref().map_err(Error::clone)
}

/// The same kinematics without the file's inertias: nothing but refitting can tell.
fn bare(robot: &Robot) -> Robot {
    let mut robot = robot.clone();
    robot.links.iter_mut().for_each(|link| link.inertia = None);
    robot
}

fn show(what: &str, f: &Findings) {
    println!(
        "{what}: as is {:.2} % (held out {:.2} %), own inertias {:?}, corrected {:.2} %, {} rows, {}",
        f.relative_error_percent,
        f.held_out_relative_error_percent,
        f.own_inertias_error_percent,
        f.corrected_relative_error_percent,
        f.rows,
        f.folds
    );
    for x in &f.findings {
        println!(
            "  {:?} {}: {} {:?} {:?}",
            x.severity, x.kind, x.text, x.error_percent, x.held_out_error_percent
        );
        println!("     also {:?}", x.also_possible);
        println!("     remedy {}", x.remedy);
    }
    if let Some(map) = &f.column_map {
        println!("{map}");
    }
}

fn checked(what: &str, robot: &Robot, log: &Log) -> Result<Findings> {
    let start = std::time::Instant::now();
    let findings = log_against_robot(robot, log, None)?;
    show(what, &findings);
    println!("  took {:.2} s", start.elapsed().as_secs_f64());
    Ok(findings)
}

fn silent(what: &str, robot: &Robot, log: &Log) -> Result<()> {
    let found = checked(what, robot, log)?;
    assert!(found.findings.is_empty(), "{what}: {:?}", found.findings);
    assert!(found.column_map.is_none());
    Ok(())
}

fn data() -> Option<PathBuf> {
    let folder = std::env::var_os("LACUNA_DATA").map(PathBuf::from);
    if folder.is_none() {
        println!("skipped: set LACUNA_DATA to the folder of measured data");
    }
    folder
}

#[test]
fn right_pairs_are_left_in_peace() -> Result<()> {
    let (robot, log) = panda()?;
    silent("panda", robot, log)?;
    silent("panda without inertias", &bare(robot), log)?;
    Ok(())
}

#[test]
fn right_pairs_of_other_robots_are_left_in_peace() -> Result<()> {
    for name in ["two_link.ron", "six_axis.urdf"] {
        let mut robot = shipped(name)?;
        for joint in &mut robot.joints {
            joint.limits.lower.get_or_insert(-2.5);
            joint.limits.upper.get_or_insert(2.5);
        }
        let log = simulate(&robot, 5)?;
        silent(name, &robot, &log)?;
        silent(&format!("{name} without inertias"), &bare(&robot), &log)?;
    }
    Ok(())
}

#[test]
fn right_pairs_of_real_robots_are_left_in_peace() -> Result<()> {
    let Some(data) = data() else { return Ok(()) };
    let robot = shipped("panda.ron")?;
    let log = Log::open(data.join("panda/exciting.csv"), &robot, None)?;
    silent("real panda", &robot, &log)?;
    silent("real panda without inertias", &bare(&robot), &log)?;
    let robot = Robot::open(data.join("ur10e/robot.urdf"))?;
    for name in ["unloaded_a", "unloaded_b", "unloaded_c", "loaded_c"] {
        let log = Log::open(data.join(format!("ur10e/{name}.csv")), &robot, None)?;
        // Without inertias refitting alone can tell; with them there is one thing more to stumble over.
        silent(&format!("{name} without inertias"), &bare(&robot), &log)?;
        if name.ends_with("_c") {
            silent(name, &robot, &log)?;
        }
    }
    Ok(())
}
