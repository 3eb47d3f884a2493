//! Examples of everything that a list of an input can hold: effects, physics of plants, constraints, engines.

use std::collections::BTreeSet;
use std::ops::ControlFlow;
use std::path::{Path, PathBuf};

use lacuna::conformance;
use lacuna::constraints::{Constraint, LinkSpace, forms};
use lacuna::effects::{CATALOGUE, Effect};
use lacuna::form::{Affine, Form};
use lacuna::model::Model;
use lacuna::retrieval::{Identity, Problem, Quadratic, RetrievalEngine, catalogue};
use lacuna::robot::Robot;
use lacuna::simulate;
use lacuna::space::{Parameter, Space};
use lacuna::text;
use nalgebra::{DMatrix, DVector};

use super::inputs::{here, robot};
use super::walk::{Input, Refused};

pub fn all() -> Vec<Input> {
    [effects(), plants(), constraints(), engines()].into_iter().flatten().collect()
}

/// Names under which plug-ins of a folder are written.
pub fn names_in(folder: &str) -> BTreeSet<String> {
    let mut names = BTreeSet::new();
    let mut open = vec![here().join(folder)];
    while let Some(path) = open.pop() {
        if path.is_dir() {
            open.extend(
                std::fs::read_dir(&path).expect("folders read").map(|e| e.expect("entries read").path()),
            );
        } else if path.extension().is_some_and(|e| e == "rs") {
            let source = std::fs::read_to_string(&path).expect("sources read");
            let source = source.split("#[cfg(test)]").next().unwrap_or_default();
            let names_of =
                source.split("typetag::serde(name = \"").skip(1).filter_map(|s| s.split('"').next());
            names.extend(names_of.map(str::to_owned));
        }
    }
    names
}

/// What it writes of itself, with all fields.
fn in_full<T: serde::de::DeserializeOwned + serde::Serialize>(written: &str) -> String {
    let value: T = text::from_ron(written).unwrap_or_else(|e| panic!("{written}: {e}"));
    text::to_ron(&value).unwrap_or_else(|e| panic!("{written}: {e}"))
}

fn effects() -> Vec<Input> {
    let robot = robot();
    let mut written: Vec<String> = CATALOGUE
        .iter()
        .filter_map(|entry| (entry.candidates)(&robot).into_iter().next())
        .map(|effect| text::to_ron(&effect).expect("effects are written"))
        .collect();
    let more = [
        r#"{"rigid_body": ()}, {"rotor_inertia": (joints: Only(["2"]))}"#,
        r#"{"contact_force": (from_s: 1, to_s: 2, point: (0, 0, 0.1))}"#,
        r#"{"friction_drift": (course: Settling(time_s: 5), width: 0.01)}"#,
        r#"{"thermal_friction": (warmth: Elapsed(time_s: 5), reference: 20, width: 0.01)}"#,
        r#"{"script": (path: "effects/end_stop.rhai", with: {"high": 2.0, "low": -2.0})}"#,
        r#"{"script": (path: "effects/warm_friction.rhai", shapes: {"warm_up": 120})}"#,
        r#"{"formula": (joint: "joint1", variable: "q2", shape: Wave(k: 3), width: 0.01)}"#,
        r#"{"formula": (joint: "joint1", variable: "q2", shape: Above(a: 3))}"#,
        r#"{"formula": (joint: "joint1", variable: "q2", shape: Bump(a: 3, w: 1))}"#,
        r#"{"formula": (joint: "joint1", variable: "dq2", shape: Detent(a: 3, w: 1))}"#,
    ];
    written.extend(more.map(str::to_owned));
    written.into_iter().map(|text| Input::new("effects", "effect", list(&text), take_effects)).collect()
}

fn list(entries: &str) -> String {
    format!("[\n{entries}\n]\n").replace(", ", ",\n")
}

fn take_effects(written: &str) -> Result<(), Refused> {
    let mut effects: Vec<Box<dyn Effect>> = text::from_ron(written).map_err(Refused::Read)?;
    effects.iter_mut().try_for_each(|effect| effect.load(&here())).map_err(Refused::Use)?;
    if written.contains("\"script\"") && effects.iter().any(|e| e.about().name == "script") {
        return Ok(());
    }
    let robot = robot();
    Model::new(&robot, effects.clone()).map_err(Refused::Use)?;
    for effect in &effects {
        let one = text::to_ron(effect).map_err(Refused::Use)?;
        // What is left of a column is numbers, whatever its shape is.
        let promised = conformance::effect(&one, &robot, &here(), &["temperature1", "temperature2"]);
        if let Err(error) = promised
            && error.message().contains("finite")
        {
            return Err(Refused::Broken(error.to_string()));
        }
    }
    Ok(())
}

/// Every physics, for a robot of two joints.
const PLANTS: [&str; 29] = [
    r#"{"viscous_friction": (coefficients: [0.3, 0.2])}"#,
    r#"{"coulomb_friction": (levels: [0.3], width: 0.01)}"#,
    r#"{"torque_offset": (offsets: [0.3])}"#,
    r#"{"sigmoid_friction": (phi1: [0.5], phi2: [5], phi3: [0.04])}"#,
    r#"{"rotor_inertia": (inertias: [0.1])}"#,
    r#"{"stribeck_friction": (levels: [0.4], velocities: [0.1])}"#,
    r#"{"asymmetric_friction": (viscous_forward: [0.5], viscous_backward: [0.2], coulomb_forward: [0.3],
        coulomb_backward: [0.1])}"#,
    r#"{"nonlinear_viscous_friction": (coefficients: [0.3], exponent: 2.5)}"#,
    r#"{"load_dependent_friction": (ratios: [0.05], viscous_ratios: [0.02])}"#,
    r#"{"position_dependent_friction": (levels: [0.2], harmonics: [3], phases: [0.4])}"#,
    r#"{"coupled_friction": (joint: 2, from: 1, viscous: 0.3, coulomb: 0.1)}"#,
    r#"{"presliding_hysteresis": (levels: [0.3], stiffness: [400])}"#,
    r#"{"backlash": (gaps: [0.002])}"#,
    r#"{"joint_spring": (stiffness: [2.0], rest: [0.1])}"#,
    r#"{"torque_ripple": (amplitudes: [0.3], harmonics: [12], phases: [1])}"#,
    r#"{"torque_drift": (rates: [0.01])}"#,
    r#"{"friction_drift": (coulomb: [0.2], viscous: [0.1], time_s: 8)}"#,
    r#"{"thermal_friction": (coulomb: [-0.004], viscous: [-0.02], heating: [0.2], cooling_s: 30, start: [2])}"#,
    r#"{"base_tilt": (x: 0.005, y: -0.003)}"#,
    r#"{"payload": (mass: 1.5, com: (0.02, 0.01, 0.08), inertia: (0.002, 0, 0, 0.003, 0, 0.001), link: 2)}"#,
    r#"{"contact_force": (force: (3, -2, 5), from_s: 0.05, to_s: 0.1, point: (0.0, 0.1, 0.2), link: 2)}"#,
    r#"{"torque_gain": (gains: [0.05])}"#,
    r#"{"time_delay": (delays_s: [0.0043])}"#,
    r#"{"joint_zero_error": (errors: [0.02])}"#,
    r#"{"joint_elasticity": (compliance: [0.0001])}"#,
    r#"{"product": (joint: 1, amplitude: 0.4, factors: [Velocity(2), Wave(of: 1, k: 3, phase: 0.8), Position(2)])}"#,
    r#"{"product": (joint: 1, amplitude: 0.4, factors: [Bump(of: 2, at: 0.1, width: 0.3), Sign(1), Speed(1)])}"#,
    r#"{"product": (joint: 1, amplitude: 0.4, factors: [Detent(of: 2, at: 0.1, width: 0.3), Beyond(of: 1, from: 0.1),
        Below(of: 1, to: 0.5), Pieces(of: 1, points: [(0, 1), (1, 2)])])}"#,
    r#"{"product": (joint: 1, amplitude: 0.4, factors: [Channel(name: "p", period_s: 3, phase: 1, mean: 2),
        OnOff(period_s: 0.5, phase: 0.2)])}"#,
];

fn plants() -> Vec<Input> {
    let full = |written: &str| in_full::<Box<dyn lacuna::plant::PlantEffect>>(written);
    PLANTS
        .iter()
        .map(|written| {
            let robot = here().join("robots/two_link.ron");
            let before = format!("(robot: {robot:?}, sensors: (sampling_time_s: 0.005), effects: [\n");
            let after = "\n], logs: [(name: \"a\", duration_s: 0.1, ramp_s: 0.02,\n\
                motion: Random(harmonics: 2, period_s: 1.0, amplitude: 0.2))])\n";
            let text = full(written).replace(", ", ",\n");
            let around = (before, after.to_owned());
            Input { around, ..Input::new("plant", "physics", text, take_experiment) }
        })
        .collect()
}

/// Reads and runs an experiment.
pub fn take_experiment(written: &str) -> Result<(), Refused> {
    let folder = tempfile::tempdir().expect("a folder");
    let file: PathBuf = folder.path().join("plant.ron");
    std::fs::write(&file, written).expect("written");
    simulate::Experiment::open(&file).map_err(Refused::Read)?;
    let done = simulate::run(&file, None).map_err(Refused::Use)?;
    let logs = done.logs.iter().map(|simulation| &simulation.log);
    let sound = logs.flat_map(|log| log.q.iter().chain(&log.tau).flatten()).all(|x| x.is_finite());
    if sound { Ok(()) } else { Err(Refused::Broken("the log is not finite".into())) }
}

/// Every constraint, for a robot of two links.
const CONSTRAINTS: [&str; 26] = [
    r#"{"pseudo_inertia": (margin: 0.01)}, {"triangle_inequality": ()}"#,
    r#"{"density_realisable": (links: All, center: (0.1, 0.2, 0.3), semi_axes: (0.2, 0.2, 0.3), rpy: (0.1, 0.2, 0.3))}"#,
    r#"{"positive_mass": (at_least: 0.1)}"#,
    r#"{"mass_range": (min: 1.0, max: 5.0)}"#,
    r#"{"total_mass": (min: 16.0, max: 20.0)}"#,
    r#"{"mass_ratio": (link: "link1", to: "link2", min: 2.0, max: 3.0)}"#,
    r#"{"mass_order": (heaviest_first: ["link1", "link2"], gap: 0.5)}"#,
    r#"{"com_box": (links: All, lower: (-0.1, -0.2, 0.0), upper: (0.1, 0.2, 0.4))}"#,
    r#"{"com_sphere": (links: All, center: (0.1, 0.0, 0.0), radius: 0.05)}"#,
    r#"{"com_cylinder": (links: All, center: (0.0, -0.75, 0.0), axis: (0.0, 2.0, 0.0), radius: 0.15, height: 1.5)}"#,
    r#"{"com_cone": (links: All, base: (0.0, 0.0, 0.1), axis: (0.0, 0.0, 1.0), radius: 0.1, top_radius: 0.0, height: 0.5)}"#,
    r#"{"com_ellipsoid": (links: All, center: (0.0, 0.0, 0.1), semi_axes: (0.1, 0.2, 0.3), rpy: (0.0, 0.0, 1.57))}"#,
    r#"{"com_hull": (links: All, mesh: (path: "tests/fixtures/meshes/box.stl", scale: 0.5, xyz: (0.1, 0, 0), rpy: (0, 1, 0), faces: 20))}"#,
    r#"{"com_union": (links: All, shapes: [Box(lower: (0.0, -0.05, -0.05), upper: (0.4, 0.05, 0.05)), Sphere(center: (0, 0, 0.5), radius: 0.1)])}"#,
    r#"{"com_union": (links: All, shapes: [Cylinder(center: (0, 0, 0), axis: (0, 0, 1), radius: 0.1, height: 1)])}"#,
    r#"{"com_union": (links: All, shapes: [Cone(base: (0, 0, 0), axis: (0, 0, 1), radius: 0.1, top_radius: 0, height: 1)])}"#,
    r#"{"com_union": (links: All, shapes: [Ellipsoid(center: (0, 0, 0), semi_axes: (0.1, 0.2, 0.3), rpy: (0, 0, 1))])}"#,
    r#"{"com_union": (links: All, shapes: [Hull(mesh: (path: "tests/fixtures/meshes/box.stl", scale: 2))])}"#,
    r#"{"equal_links": (links: ("link1", "link2"), tolerance: 0.001)}"#,
    r#"{"mirrored_links": (links: ("link1", "link2"), along: Y, tolerance: 0.001)}"#,
    r#"{"known_payload": (link: "link2", mass: 1.0, com: (0.1, 0.2, 0.3), inertia: (xx: 0.1, xy: 0, xz: 0, yy: 0.1, yz: 0, zz: 0.1))}"#,
    r#"{"parameter_bounds": (bounds: {"m1": (0.0, 10.0), "c1y": (-1.42, inf), "I1yy": (0.01, 1.0)})}"#,
    r#"{"script": (path: "constraints/total_mass.rhai", with: {"max": 18}, seconds: 2)}"#,
    r#"{"script": (path: "constraints/heavy_near_joint.rhai", with: {"heavy": 2.0})}"#,
    r#"{"com_sphere": (links: Only(["2"]), center: (0.1, 0.0, 0.0), radius: 0.05)}"#,
    r#"{"mass_range": (links: Only(["2"]), min: 1.0, max: 5.0)}"#,
];

fn constraints() -> Vec<Input> {
    let full = |written: &str| in_full::<Vec<Box<dyn Constraint>>>(&format!("[{written}]"));
    CONSTRAINTS
        .iter()
        .map(|written| {
            Input::new("constraints", "constraint", full(written).replace(", ", ",\n"), take_constraints)
        })
        .collect()
}

fn take_constraints(written: &str) -> Result<(), Refused> {
    let mut all: Vec<Box<dyn Constraint>> = text::from_ron(written).map_err(Refused::Read)?;
    all.iter_mut().try_for_each(|c| c.load(&here())).map_err(Refused::Use)?;
    let robot = robot();
    let space = LinkSpace::new(&robot, &[]);
    forms(&robot, &space, &all).map_err(Refused::Use)?;
    all.iter().try_for_each(|c| c.bounds(&robot, &space).map(|_| ())).map_err(Refused::Use)
}

fn engines() -> Vec<Input> {
    let example = |about: &catalogue::EngineAbout| {
        let engine = catalogue::engine(about.name).expect("it is in the catalogue");
        let text = text::to_ron(&engine).expect("engines are written");
        Input::new("retrieval", about.name, text, take_engine)
    };
    catalogue::CATALOGUE.iter().map(example).collect()
}

/// Reads an engine and starts it; it is asked to stop as soon as it asks.
fn take_engine(written: &str) -> Result<(), Refused> {
    let engine: Box<dyn RetrievalEngine> = text::from_ron(written).map_err(Refused::Read)?;
    if engine.available().is_err() {
        return Ok(());
    }
    engine.retrieve(&problem(), &|_| ControlFlow::Break(())).map(|_| ()).map_err(Refused::Use)
}

/// Two shares that are nonnegative and together at most 1.
fn problem() -> Problem {
    let mut space = Space::default();
    let member = |i: usize| Parameter::free(format!("x{i}"), "").within(0.0, 1.0);
    space.push_group("shares", (0..2).map(member));
    let sum = Affine::constant(1.0).plus(-1.0, &Affine::variable(0)).plus(-1.0, &Affine::variable(1));
    let objective = Quadratic {
        r: DMatrix::identity(2, 2),
        d: DVector::from_column_slice(&[0.7, 0.9]),
        floor: 0.0,
        unit: String::new(),
    };
    let forms = vec![Form::affine("at most one", "", 1.0, sum)];
    Problem { chart: Box::new(Identity { space: space.clone() }), space, objective, forms, seed: 4 }
}

/// A shipped robot.
pub fn shipped(name: &str) -> Robot {
    Robot::open(Path::new(&here().join("robots").join(name))).expect("shipped robots read")
}
