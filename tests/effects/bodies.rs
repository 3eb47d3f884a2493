//! Payload and contact, against a heavier robot and against virtual work.

use lacuna::effects::{ContactForce, Effect, Payload};
use lacuna::robot::{InertialParameters, Robot};
use nalgebra::{DMatrix, Matrix3, Vector3};

use super::common::robot;
use super::motion::{at, columns, run, torque};

fn body() -> InertialParameters {
    let inertia = Matrix3::new(0.011, 0.001, -0.002, 0.001, 0.013, 0.0005, -0.002, 0.0005, 0.009);
    InertialParameters::from_barycentric(1.7, Vector3::new(0.02, -0.05, 0.11), inertia)
}

#[test]
fn a_payload_is_a_heavier_last_link() {
    for (file, link) in [("panda.ron", None), ("six_axis.urdf", None), ("panda.ron", Some(4))] {
        let robot = robot(file);
        let index = link.unwrap_or(robot.dof()) - 1;
        let mut loaded = robot.clone();
        let own = robot.links[index].inertia.expect("has inertias");
        loaded.links[index].inertia = Some(own.combined(&body()));
        let run = run(&robot, 0.01, 150);
        let effect = Payload { link: link.map(|l: usize| l.to_string()), inertia: true };
        let found = columns(&robot, &run, &effect);
        assert_eq!(found.len(), 10);
        for k in 0..150 {
            let state = at(&robot, 0.01 * k as f64);
            let (with, without) = (torque(&loaded, &state), torque(&robot, &state));
            for joint in 0..robot.dof() {
                let made: f64 = (0..10).map(|p| body().0[p] * found[p][joint][k]).sum();
                let expected = with[joint] - without[joint];
                assert!((made - expected).abs() < 1e-9, "{file} joint {joint}: {made} {expected}");
            }
        }
    }
}

#[test]
fn four_columns_are_a_payload_without_inertia() {
    let robot = robot("panda.ron");
    let run = run(&robot, 0.01, 20);
    let ten = columns(&robot, &run, &Payload::default());
    let four = columns(&robot, &run, &Payload { link: None, inertia: false });
    assert_eq!(four, ten[..4]);
}

#[test]
fn mass_and_centre_of_mass_are_told_with_their_errors() {
    let robot = robot("panda.ron");
    let effect = Payload { link: None, inertia: false };
    let values = [2.0, 0.1, -0.06, 0.24];
    // Errors by the delta method are those of many draws when they are small.
    let root = DMatrix::from_row_slice(
        4,
        4,
        &[0.02, 0.0, 0.0, 0.0, 0.001, 0.002, 0.0, 0.0, -0.001, 0.0, 0.003, 0.0, 0.002, 0.001, 0.0, 0.001],
    );
    let told = effect.describe(&robot, &values, &(&root * root.transpose())).expect("describes");
    let names: Vec<&str> = told.iter().map(|d| d.name.as_str()).collect();
    assert_eq!(names, ["mass", "com_x", "com_y", "com_z"]);
    let expected = [2.0, 0.05, -0.03, 0.12];
    for (d, expected) in told.iter().zip(expected) {
        assert!((d.value - expected).abs() < 1e-12, "{d:?}");
    }
    // Along every column of the root, com moves by its derivative times that column; squares add up.
    for axis in 1..4 {
        let mut variance = 0.0;
        for column in root.column_iter() {
            let com = |h: f64| (values[axis] + h * column[axis]) / (values[0] + h * column[0]);
            variance += ((com(1e-4) - com(-1e-4)) / 2e-4_f64).powi(2);
        }
        let error = told[axis].standard_error.expect("is known");
        assert!((error - variance.sqrt()).abs() < 1e-6 * error, "{error} {}", variance.sqrt());
    }
}

#[test]
fn a_contact_does_the_work_of_its_force() {
    for file in ["panda.ron", "two_link.ron", "six_axis.urdf"] {
        let robot = robot(file);
        let run = run(&robot, 0.01, 100);
        let point = [0.03, -0.02, 0.05];
        let effect = ContactForce { from_s: 100.195, to_s: 100.605, link: None, point, log: None };
        let found = columns(&robot, &run, &effect);
        assert_eq!(found.len(), 3);
        let last = *robot.order.last().expect("has joints");
        let place = |q: &[f64]| {
            let pose = robot.link_pose(q, last);
            pose.rotation * Vector3::from(point) + pose.translation
        };
        for k in 0..100 {
            let [mut q, ..] = at(&robot, 0.01 * k as f64);
            for joint in 0..robot.dof() {
                let here = q[joint];
                q[joint] = here + 1e-6;
                let ahead = place(&q);
                q[joint] = here - 1e-6;
                let way = (ahead - place(&q)) / 2e-6;
                q[joint] = here;
                for axis in 0..3 {
                    let expected = if (20..61).contains(&k) { -way[axis] } else { 0.0 };
                    let y = found[axis][joint][k];
                    assert!((y - expected).abs() < 1e-8, "{file} joint {joint} sample {k}: {y} {expected}");
                }
            }
        }
    }
}

#[test]
fn a_contact_stays_in_its_log_and_in_its_time() {
    let robot: Robot = robot("two_link.ron");
    let run = run(&robot, 0.01, 100);
    let contact = |from_s, to_s, log: Option<&str>| ContactForce {
        from_s,
        to_s,
        link: None,
        point: [0.0; 3],
        log: log.map(str::to_string),
    };
    let elsewhere = contact(100.2, 100.6, Some("another log"));
    assert!(columns(&robot, &run, &elsewhere).concat().concat().iter().all(|y| y.abs() < 1e-15));
    let runs = [run];
    assert!(elsewhere.undecidable(&robot, &runs).is_some());
    assert!(contact(0.0, 1.0, None).undecidable(&robot, &runs).is_some());
    assert!(contact(100.2, 100.6, Some("motion")).undecidable(&robot, &runs).is_none());
    assert!(contact(3.0, 2.0, None).terms(&robot).is_err());
    let two: Vec<Box<dyn Effect>> =
        vec![Box::new(contact(100.2, 100.4, None)), Box::new(contact(100.6, 100.8, None))];
    assert!(lacuna::model::Model::new(&robot, two).is_ok(), "two contacts can stand side by side");
}
