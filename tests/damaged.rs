//! Damaged meshes, lists of constraints and checkpoints are read or refused with their name: nothing panics,
//! and nothing is half believed. `PROPTEST_CASES` sets how many cases are tried.

use std::path::{Path, PathBuf};

use lacuna::constraints::{self, Mesh};
use lacuna::retrieval::checkpoint::{Checkpoint, Origin, Outcome};
use lacuna::retrieval::{Identity, Problem, Quadratic};
use lacuna::space::{Parameter, Space};
use nalgebra::{DMatrix, DVector};
use proptest::prelude::*;
use proptest::sample::Index;

fn cases(usual: u32) -> ProptestConfig {
    let given = std::env::var("PROPTEST_CASES").ok().and_then(|n| n.parse().ok());
    ProptestConfig { cases: given.unwrap_or(usual), failure_persistence: None, ..ProptestConfig::default() }
}

fn folder(name: &str) -> PathBuf {
    let folder = std::env::temp_dir().join(format!("lacuna-damaged-{name}-{}", std::process::id()));
    std::fs::create_dir_all(&folder).expect("a folder");
    folder
}

/// A few bytes changed, put in, or cut off from the end.
fn damage(bytes: &mut Vec<u8>, changes: &[(Index, u8, u8)]) {
    for (place, byte, kind) in changes {
        if bytes.is_empty() {
            return;
        }
        let place = place.index(bytes.len());
        match kind % 4 {
            0 | 1 => bytes[place] = *byte,
            2 => bytes.insert(place, *byte),
            _ => bytes.truncate(place),
        }
    }
}

fn changes() -> impl Strategy<Value = Vec<(Index, u8, u8)>> {
    prop::collection::vec((any::<Index>(), any::<u8>(), any::<u8>()), 1..6)
}

/// Loads these bytes as a mesh: a refusal names the file.
fn load(bytes: &[u8], name: &str) -> Result<(), TestCaseError> {
    let folder = folder(name);
    std::fs::write(folder.join("part.stl"), bytes).expect("written");
    if let Err(error) = Mesh::new("part.stl").load(&folder) {
        let place = error.place().map(|p| p.file.clone());
        prop_assert_eq!(place.as_deref(), Some("part.stl"), "{}", error);
        prop_assert!(
            error.to_string().contains("\n  help: ") || error.place().is_some_and(|p| p.line.is_some())
        );
    }
    Ok(())
}

/// A tetrahedron as a binary file.
fn binary() -> Vec<u8> {
    let corners = [[0.0_f32, 0.0, 0.0], [0.1, 0.0, 0.0], [0.0, 0.1, 0.0], [0.0, 0.0, 0.1]];
    let mut bytes = vec![b' '; 80];
    bytes.extend(4_u32.to_le_bytes());
    for left_out in 0..4 {
        bytes.extend([0; 12]);
        for (_, corner) in corners.iter().enumerate().filter(|(i, _)| *i != left_out) {
            corner.iter().for_each(|x| bytes.extend(x.to_le_bytes()));
        }
        bytes.extend([0; 2]);
    }
    bytes
}

#[test]
fn a_mesh_whose_triangle_count_lies_is_refused_with_both_numbers() {
    let folder = folder("lies");
    for claimed in [0_u32, 3, 5, 85_899_345, u32::MAX] {
        let mut bytes = binary();
        bytes[80..84].copy_from_slice(&claimed.to_le_bytes());
        std::fs::write(folder.join("part.stl"), &bytes).expect("written");
        let error = Mesh::new("part.stl").load(&folder).expect_err("it lies").to_string();
        let says = [format!("{claimed} triangles"), format!("{} bytes", bytes.len()), "part.stl".into()];
        assert!(says.iter().all(|part| error.contains(part)) && error.contains("help: "), "{error}");
    }
    std::fs::write(folder.join("part.stl"), binary()).expect("written");
    Mesh::new("part.stl").load(&folder).expect("the honest one is read");
    std::fs::remove_dir_all(folder).expect("it was there");
}

fn checkpointed() -> (Origin, Vec<Option<Outcome>>) {
    let mut space = Space::default();
    space.push_group("all", [Parameter::free("x", "m").within(-1.0, 1.0)]);
    let problem = Problem {
        objective: Quadratic {
            r: DMatrix::from_element(1, 1, 1.0),
            d: DVector::from_element(1, 0.5),
            floor: 0.0,
            unit: String::new(),
        },
        forms: Vec::new(),
        chart: Box::new(Identity { space: space.clone() }),
        space,
        seed: 7,
    };
    let outcome = |x: f64| Outcome { z: vec![x], objective: x * x, violation: 0.0, evaluations: 100 };
    (Origin::new("penalty", "settings".into(), &problem), vec![Some(outcome(0.25)), None, Some(outcome(0.5))])
}

proptest! {
    #![proptest_config(cases(96))]

    #[test]
    fn any_bytes_are_a_mesh_or_none(bytes in prop::collection::vec(any::<u8>(), 0..400)) {
        load(&bytes, "bytes")?;
        load(&[b"solid x\n", bytes.as_slice()].concat(), "text")?;
    }

    #[test]
    fn damaged_meshes_are_read_or_refused(changes in changes()) {
        for (bytes, name) in [(binary(), "binary"), (std::fs::read("tests/fixtures/meshes/box.stl").expect("there"), "ascii")] {
            let mut bytes = bytes;
            damage(&mut bytes, &changes);
            load(&bytes, name)?;
        }
    }

    #[test]
    fn damaged_lists_of_constraints_are_read_or_refused(changes in changes()) {
        let folder = folder("constraints");
        let mut bytes = std::fs::read("scenarios/panda_bounds.ron").expect("it is there");
        damage(&mut bytes, &changes);
        let path = folder.join("bounds.ron");
        std::fs::write(&path, &bytes).expect("written");
        if let Err(error) = constraints::open(Path::new(&path)) {
            prop_assert!(error.place().is_some_and(|p| p.file.ends_with("bounds.ron")), "{}", error);
        }
    }

    #[test]
    fn damaged_checkpoints_are_refused_or_mean_the_same(changes in changes()) {
        let folder = folder("checkpoint");
        let (origin, runs) = checkpointed();
        let checkpoint = Checkpoint { folder: folder.clone(), resume: true };
        checkpoint.save("penalty", &origin, &runs).expect("written");
        let path = checkpoint.file("penalty");
        let honest = checkpoint.load("penalty", &origin).expect("its own");
        prop_assert_eq!(honest.len(), 2);
        let mut bytes = std::fs::read(&path).expect("it is there");
        damage(&mut bytes, &changes);
        std::fs::write(&path, &bytes).expect("written");
        match checkpoint.load("penalty", &origin) {
            Ok(read) => prop_assert_eq!(format!("{:?}", read), format!("{honest:?}")),
            Err(error) => prop_assert!(error.place().is_some(), "{}", error),
        }
    }
}
