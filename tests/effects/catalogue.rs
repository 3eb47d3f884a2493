//! What every effect of the catalogue promises.

use std::collections::BTreeSet;
use std::path::Path;

use lacuna::conformance;
use lacuna::effects::{AtRest, CATALOGUE, ContactForce, Effect, Reach, RigidBody, Stage};
use lacuna::model::{Model, ModelBlock};
use lacuna::robot::Robot;
use lacuna::signals::Run;
use lacuna::text::{from_ron, to_ron};

use super::common::robot;
use super::motion::run;

/// Names that scenarios, model files and the command line use.
const NAMES: [&str; 26] = [
    "rigid_body",
    "viscous_friction",
    "coulomb_friction",
    "torque_offset",
    "sigmoid_friction",
    "stribeck_friction",
    "asymmetric_friction",
    "nonlinear_viscous_friction",
    "load_dependent_friction",
    "position_dependent_friction",
    "coupled_friction",
    "presliding_hysteresis",
    "backlash",
    "rotor_inertia",
    "joint_spring",
    "torque_ripple",
    "joint_elasticity",
    "joint_zero_error",
    "torque_gain",
    "time_delay",
    "torque_drift",
    "friction_drift",
    "thermal_friction",
    "base_tilt",
    "payload",
    "contact_force",
];

/// Every effect that a diagnosis tries, and one of each of the others.
fn instances(robot: &Robot) -> Vec<Box<dyn Effect>> {
    let mut all: Vec<Box<dyn Effect>> =
        CATALOGUE.iter().flat_map(|entry| (entry.candidates)(robot)).collect();
    all.push(Box::new(RigidBody::default()));
    let contact = ContactForce { from_s: 100.1, to_s: 100.3, link: None, point: [0.0; 3], log: None };
    all.push(Box::new(contact));
    all
}

fn warm_run(robot: &Robot) -> Run {
    let mut run = run(robot, 0.004, 600);
    for j in 1..=robot.dof() {
        run.channels
            .insert(format!("temperature{j}"), (0..600).map(|k| 20.0 + 0.05 * f64::from(k)).collect());
    }
    run
}

#[test]
fn every_name_is_there_once() {
    let names: Vec<&str> = CATALOGUE.iter().map(|entry| entry.about.name).collect();
    for name in NAMES {
        assert_eq!(names.iter().filter(|n| **n == name).count(), 1, "{name}");
    }
    let robot = robot("panda.ron");
    let tried: BTreeSet<&str> = instances(&robot).iter().map(|effect| effect.about().name).collect();
    assert!(NAMES.iter().all(|name| tried.contains(name)), "{tried:?}");
}

#[test]
fn every_effect_is_written_and_read_back() {
    for effect in instances(&robot("panda.ron")) {
        let text = to_ron(&effect).expect("writes");
        assert!(text.contains(&format!("\"{}\"", effect.about().name)), "{text}");
        let back: Box<dyn Effect> = from_ron(&text).expect("reads");
        assert_eq!(format!("{effect:?}"), format!("{back:?}"));
        let typo = text.replacen("(", "(no_such_setting: 1.0, ", 1).replace(", )", ")");
        let error = from_ron::<Box<dyn Effect>>(&typo).expect_err("a typo must not pass");
        assert!(error.to_string().contains("no_such_setting"), "{typo}: {error}");
    }
}

#[test]
fn every_effect_explains_itself() {
    for entry in CATALOGUE {
        let about = entry.about;
        assert!(about.title.len() > 20 && about.title.len() < 90, "{}: {}", about.name, about.title);
        assert!(about.text.len() > 80, "{} says too little", about.name);
        assert!(!about.text.contains("  "), "{} has a hole in its text", about.name);
        assert!(about.equation.contains("tau") && !about.parameters.is_empty(), "{}", about.name);
        assert!(!about.confused_with.is_empty() && !about.confused_with.contains("  "), "{}", about.name);
        let settings = instances(&robot("panda.ron"));
        for effect in settings.iter().filter(|e| e.about().name == about.name) {
            for shape in effect.shapes() {
                assert!(about.parameters.iter().any(|p| p.symbol.contains(shape.symbol)), "{}", shape.symbol);
            }
        }
    }
}

#[test]
fn columns_stay_where_the_terms_say() {
    for file in ["panda.ron", "two_link.ron", "six_axis.urdf"] {
        let robot = robot(file);
        let run = warm_run(&robot);
        for effect in instances(&robot) {
            let terms = effect.terms(&robot).expect("fits the robot");
            let symbols: BTreeSet<&String> = terms.iter().map(|term| &term.symbol).collect();
            assert_eq!(symbols.len(), terms.len(), "{effect:?}");
            let model = Model::new(&robot, vec![effect.clone()]).expect("fits the robot");
            let mut block = ModelBlock::new(&model, run.samples());
            model.fill(&run, 0..run.samples(), &mut block).expect("fills");
            let mut acts = vec![false; model.columns.len()];
            for joint in 0..robot.dof() {
                for (local, &column) in model.active[joint].iter().enumerate() {
                    let values = block.column(joint, local, run.samples());
                    assert!(values.iter().all(|y| y.is_finite()), "{effect:?}");
                    acts[column] |= values.iter().any(|y| y.abs() > 1e-9);
                }
            }
            // Half of space means nothing to an arm that moves in a plane.
            assert!(acts.iter().all(|a| *a) || file == "two_link.ron", "{effect:?} has an idle column");
        }
    }
}

#[test]
fn where_a_run_is_cut_does_not_matter() {
    let robot = robot("panda.ron");
    let run = warm_run(&robot);
    for effect in instances(&robot) {
        let model = Model::new(&robot, vec![effect.clone()]).expect("fits the robot");
        let mut whole = ModelBlock::new(&model, run.samples());
        model.fill(&run, 0..run.samples(), &mut whole).expect("fills");
        for range in [0..1, 1..7, 90..218, 591..600, 599..600] {
            let mut part = ModelBlock::new(&model, range.len());
            model.fill(&run, range.clone(), &mut part).expect("fills");
            for joint in 0..robot.dof() {
                for local in 0..model.active[joint].len() {
                    let expected = &whole.column(joint, local, run.samples())[range.clone()];
                    let size = expected.iter().fold(1.0_f64, |m, y| m.max(y.abs()));
                    for (a, b) in part.column(joint, local, range.len()).iter().zip(expected) {
                        assert!((a - b).abs() < 1e-12 * size, "{effect:?} {range:?}: {a} {b}");
                    }
                }
            }
        }
    }
}

#[test]
fn shapes_and_widths_go_in_and_come_out() {
    let robot = robot("panda.ron");
    for effect in instances(&robot) {
        let shapes = effect.shapes();
        for shape in &shapes {
            assert!(shape.trials.iter().all(|t| (shape.low..=shape.high).contains(t)), "{shape:?}");
            assert!((shape.low..=shape.high).contains(&shape.value), "{shape:?}");
        }
        let values: Vec<f64> = shapes.iter().map(|shape| 0.5 * (shape.value + shape.high)).collect();
        let other = effect.with_shapes(&values);
        let found: Vec<f64> = other.shapes().iter().map(|shape| shape.value).collect();
        assert_eq!(found, values, "{effect:?}");
        assert_eq!(other.terms(&robot).expect("fits"), effect.terms(&robot).expect("fits"));
        assert_eq!(effect.with_width(0.01).terms(&robot).expect("fits"), effect.terms(&robot).expect("fits"));
    }
}

#[test]
fn an_effect_with_a_shape_may_stand_there_twice() {
    let robot = robot("panda.ron");
    let wave = |k| -> Box<dyn Effect> {
        from_ron(&format!("{{\"torque_ripple\": (joints: Only([\"2\"]), k: {k})}}")).expect("reads")
    };
    let model = Model::new(&robot, vec![wave(3.0), wave(11.0)]).expect("fits the robot");
    let symbols: Vec<&str> = model.columns.iter().map(|c| c.about.symbol.as_str()).collect();
    assert_eq!(symbols, ["rs2", "rc2", "rs2'", "rc2'"]);
    let spring = || -> Box<dyn Effect> { from_ron("{\"joint_spring\": ()}").expect("reads") };
    assert!(Model::new(&robot, vec![spring(), spring()]).is_err(), "a spring twice is a mistake");
}

#[test]
fn every_example_keeps_the_promises_of_an_effect() {
    for file in ["panda.ron", "two_link.ron", "six_axis.urdf"] {
        for entry in CATALOGUE {
            let checked = conformance::effect(entry.about.example, &robot(file), Path::new("."), &[]);
            checked.unwrap_or_else(|e| panic!("{} on {file}: {e}", entry.about.name));
        }
    }
}

/// What is tried of an effect on a robot is what it says of its reach and of the stage of the search.
#[test]
fn what_is_tried_is_what_an_effect_says() {
    let robot = robot("panda.ron");
    for entry in CATALOGUE {
        let (about, tried) = (entry.about, (entry.candidates)(&robot));
        let by_search = matches!(about.stage, Stage::First | Stage::Usual);
        assert_eq!(!tried.is_empty(), by_search, "{}", about.name);
        let joints = |effect: &dyn Effect| -> BTreeSet<usize> {
            effect.terms(&robot).expect("fits").into_iter().flat_map(|term| term.joints).collect()
        };
        let sizes: BTreeSet<usize> = tried.iter().map(|effect| joints(effect.as_ref()).len()).collect();
        let own = |effect: &dyn Effect| effect.belongs_to(&robot).expect("fits");
        let named = tried.iter().filter(|effect| own(effect.as_ref()).is_some()).count();
        let of_another = tried.iter().filter(|e| e.sign_of(&robot).expect("fits").is_some()).count();
        let expected = |all: bool, one: usize, other: usize| all && named == one && of_another == other;
        let holds = match about.reach {
            _ if tried.is_empty() => true,
            Reach::Joint => expected(sizes == BTreeSet::from([1]), 0, 0),
            Reach::Pair => expected(sizes == BTreeSet::from([1]), 0, tried.len()),
            Reach::JointFeltByOthers => expected(!sizes.contains(&0), tried.len(), 0),
            Reach::JointOrAll => expected(sizes == BTreeSet::from([1, robot.dof()]), 0, 0),
            Reach::Robot => expected(tried.len() == 1 && !sizes.contains(&1), 0, 0),
        };
        assert!(
            holds,
            "{}: {:?}, but {} are tried on {sizes:?} joints",
            about.name,
            about.reach,
            tried.len()
        );
    }
    let stages = |stage: Stage| CATALOGUE.iter().filter(|e| e.about.stage == stage).count();
    assert_eq!(stages(Stage::InEveryModel), 1, "only rigid links are in every model");
}

/// Torque on every joint before and after an instant of reversal: what steps there must say so, and nothing else.
#[test]
fn what_steps_at_rest_says_so() {
    let robot = robot("panda.ron");
    let mut stepping: BTreeSet<&str> = BTreeSet::new();
    for effect in instances(&robot) {
        let mut run = warm_run(&robot);
        let samples = run.samples();
        // Nothing changes but the sign of the velocities, which are next to nothing.
        for rows in run.q.iter_mut().chain(&mut run.ddq) {
            let here = rows[0];
            rows.fill(here);
        }
        for rows in &mut run.dq {
            *rows = (0..samples).map(|k| if k % 2 == 0 { 1e-9 } else { -1e-9 }).collect();
        }
        run.friction_dq = Vec::new();
        if let Some(model) = &run.model {
            let mut model = (**model).clone();
            for rows in model.rigid.iter_mut().chain(&mut model.total) {
                let here = rows[0];
                rows.fill(here);
            }
            run.model = Some(std::sync::Arc::new(model));
        }
        let found = super::motion::columns(&robot, &run, effect.with_width(0.0).as_ref());
        let steps = found.iter().flatten().any(|rows| {
            let mean = |odd: usize| rows.iter().skip(300 + odd).step_by(2).sum::<f64>() / 150.0;
            (mean(0) - mean(1)).abs() > 0.01
        });
        stepping.extend(steps.then_some(effect.about().name));
    }
    let says = CATALOGUE.iter().map(|e| e.about).filter(|a| a.at_rest != AtRest::Smooth).map(|a| a.name);
    assert_eq!(stepping, says.collect::<BTreeSet<_>>());
}
