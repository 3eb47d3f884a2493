//! Logs and static poses: what reads, what is refused, and with which words.

#[path = "logs/bad.rs"]
mod bad;
#[path = "logs/maps.rs"]
mod maps;
#[path = "logs/property.rs"]
mod property;
#[path = "logs/public_data.rs"]
mod public_data;
#[path = "logs/reads.rs"]
mod reads;
#[path = "logs/script.rs"]
mod script;

use lacuna::log::{ColumnMap, Log};
use lacuna::robot::{Joint, JointKind, Limits, Link, Pose, Robot};
use nalgebra::Vector3;
use std::path::PathBuf;

/// A chain of revolute joints of these names.
fn arm(names: &[&str]) -> Robot {
    let joint = |(i, name): (usize, &&str)| Joint {
        name: (*name).to_owned(),
        kind: JointKind::Revolute,
        parent: i.checked_sub(1),
        before: Pose::identity(),
        axis: Vector3::z(),
        after: Pose::identity(),
        limits: Limits::default(),
    };
    Robot {
        name: "arm".to_owned(),
        gravity: Vector3::new(0.0, 0.0, -9.81),
        joints: names.iter().enumerate().map(joint).collect(),
        links: names.iter().map(|n| Link { name: format!("{n}_link"), inertia: None }).collect(),
        order: (0..names.len()).collect(),
        frames: Vec::new(),
        remarks: Vec::new(),
    }
}

/// `joint1` to `joint<n>`.
fn chain(joints: usize) -> Robot {
    let names: Vec<String> = (1..=joints).map(|i| format!("joint{i}")).collect();
    arm(&names.iter().map(String::as_str).collect::<Vec<_>>())
}

fn fixture(name: &str) -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("tests/fixtures/logs").join(name)
}

fn read(text: impl AsRef<[u8]>, robot: &Robot) -> lacuna::Result<Log> {
    Log::from_reader(text.as_ref(), "log.csv", robot, None)
}

fn read_mapped(text: impl AsRef<[u8]>, robot: &Robot, map: &str) -> lacuna::Result<Log> {
    let map = ColumnMap::parse(map)?;
    Log::from_reader(text.as_ref(), "log.csv", robot, Some(&map))
}

fn gzip(bytes: &[u8]) -> Vec<u8> {
    use std::io::Write;
    let mut packed = flate2::write::GzEncoder::new(Vec::new(), flate2::Compression::best());
    packed.write_all(bytes).expect("memory takes all bytes");
    packed.finish().expect("memory takes all bytes")
}

/// Exactly the same numbers.
#[track_caller]
fn assert_same(found: &[f64], expected: &[f64]) {
    let bits = |x: &[f64]| x.iter().map(|v| v.to_bits()).collect::<Vec<_>>();
    assert_eq!(bits(found), bits(expected), "{found:?} is not {expected:?}");
}
