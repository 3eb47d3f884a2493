//! Exported models: what other tools read is the same robot.

use std::path::Path;
use std::process::{Command, Output};

use lacuna::effects::{CoulombFriction, Effect, RigidBody, TorqueOffset, ViscousFriction};
use lacuna::export::{Friction, Parameters, json, mjcf, urdf};
use lacuna::identify::{BaseParameters, parameter_name};
use lacuna::kernels::{Chain, State, Workspace, inverse_dynamics};
use lacuna::model_file::{ModelFile, ParameterValue};
use lacuna::robot::{InertialParameters, Joint, JointKind, Limits, Link, Pose, Robot};
use nalgebra::{Matrix3, Quaternion, UnitQuaternion, Vector3};

use super::common;

/// Numbers that are the same in every run, from -1 to 1.
struct Draw(u64);

impl Draw {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6364136223846793005).wrapping_add(1442695040888963407);
        (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0
    }

    fn vector(&mut self, size: f64) -> Vector3<f64> {
        Vector3::from_fn(|_, _| size * self.next())
    }
}

/// Bodies with nothing special about them.
fn bodies(robot: &Robot) -> Parameters {
    let mut draw = Draw(7);
    let mut body = |_: &Link| {
        let spread = Matrix3::from_fn(|_, _| 0.1 * draw.next());
        let second = spread * spread.transpose();
        let mass = 2.0 + draw.next();
        let inertia = (Matrix3::identity() * second.trace() - second) * mass;
        InertialParameters::from_barycentric(mass, draw.vector(0.2), inertia)
    };
    Parameters {
        links: robot.links.iter().map(&mut body).collect(),
        friction: vec![Friction::default(); robot.dof()],
        left_out: Vec::new(),
        listed: 10 * robot.dof(),
    }
}

/// Torques at some states, one after the other.
fn torques(robot: &Robot, parameters: &[f64]) -> Vec<f64> {
    let n = robot.dof();
    let chain = Chain::new(robot);
    let mut ws = Workspace::new(&chain, 0.0);
    let mut draw = Draw(99);
    let mut all = Vec::new();
    for _ in 0..50 {
        let [q, dq, ddq] = [3.0, 2.0, 5.0].map(|size| (0..n).map(|_| size * draw.next()).collect::<Vec<_>>());
        let mut tau = vec![0.0; n];
        inverse_dynamics(&chain, &mut ws, State::new(&q, &dq, &ddq), parameters, &mut tau);
        all.extend(tau);
    }
    all
}

#[track_caller]
fn same_torques(a: &[f64], b: &[f64]) {
    assert_eq!(a.len(), b.len());
    let worst = a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
    let largest = a.iter().fold(0.0, |m: f64, x| m.max(x.abs()));
    assert!(largest > 1.0, "the states load the joints");
    assert!(worst < 1e-9, "torques differ by {worst:.1e} N m");
}

fn stacked(parameters: &Parameters) -> Vec<f64> {
    parameters.links.iter().flat_map(|l| l.0).collect()
}

fn six_axis() -> String {
    std::fs::read_to_string("robots/six_axis.urdf").expect("the shipped robot reads")
}

#[test]
fn a_urdf_gives_the_torques_back() -> lacuna::Result<()> {
    for (name, original) in [
        ("panda.ron", None),
        ("two_link.ron", None),
        ("six_axis.urdf", None),
        ("six_axis.urdf", Some(six_axis())),
    ] {
        let robot = common::robot(name);
        let parameters = bodies(&robot);
        let exported = urdf(&robot, &parameters, original.as_deref())?;
        let again = Robot::from_urdf(&exported.text)?.with_gravity(robot.gravity);
        let names = |r: &Robot| r.joints.iter().map(|j| j.name.clone()).collect::<Vec<_>>();
        assert_eq!(names(&robot), names(&again), "{name}");
        same_torques(
            &torques(&robot, &stacked(&parameters)),
            &torques(&again, &again.inertial_parameters()?),
        );
        for frame in &robot.frames {
            let found = again.frames.iter().find(|f| f.name == frame.name).expect("named frames stay");
            let q: Vec<f64> = (0..robot.dof()).map(|j| 0.3 * j as f64 - 0.7).collect();
            let place = |r: &Robot, f: &lacuna::robot::Frame| {
                f.link.map_or(f.pose, |l| r.link_pose(&q, l).then(&f.pose))
            };
            let (a, b) = (place(&robot, frame), place(&again, found));
            assert!((a.translation - b.translation).norm() + (a.rotation - b.rotation).norm() < 1e-12);
        }
        let limits =
            |r: &Robot| r.joints.iter().map(|j| (j.limits.lower, j.limits.upper)).collect::<Vec<_>>();
        assert_eq!(limits(&robot), limits(&again), "{name}");
    }
    Ok(())
}

#[test]
fn an_original_keeps_everything_but_inertias() -> lacuna::Result<()> {
    let (robot, original) = (common::robot("six_axis.urdf"), six_axis());
    let exported = urdf(&robot, &bodies(&robot), Some(&original))?;
    // Lines of inertial elements apart, the original is still there, in order.
    let mut written = exported.text.lines();
    let mut inside = false;
    for line in original.lines() {
        inside |= line.contains("<inertial>");
        if !inside {
            assert!(written.any(|w| w == line), "lost: {line}");
        }
        inside &= !line.contains("</inertial>");
    }
    assert!(exported.text.contains("<!-- inertia is part of link `forearm` -->"));
    let note = exported.notes.iter().find(|n| n.contains("part of the moving link")).expect("is said");
    assert!(note.ends_with("cable_guide, hand"), "{note}");
    // The base does not move; its inertia is nobody's business.
    assert!(exported.text.contains("<mass value=\"5\"/>"));
    Ok(())
}

#[test]
fn links_without_inertia_get_one_and_friction_finds_its_place() -> lacuna::Result<()> {
    let original = "<robot name=\"r\">\n  <link name=\"base\"/>\n  <link name=\"a\"/>\n  <link name=\"b\"></link>\n  \
        <link name=\"c\">\n    <visual/>\n  </link>\n\
        <joint name=\"ja\" type=\"continuous\"><parent link=\"base\"/><child link=\"a\"/></joint>\n\
        <joint name=\"jb\" type=\"continuous\"><parent link=\"a\"/><child link=\"b\"/><axis xyz=\"0 1 0\"/>\n  \
        <dynamics friction=\"9\"/></joint>\n\
        <joint name=\"jc\" type=\"continuous\"><parent link=\"b\"/><child link=\"c\"/><axis xyz=\"0 0 1\"/></joint>\n\
        </robot>\n";
    let robot = Robot::from_urdf(original)?;
    let mut parameters = bodies(&robot);
    parameters.friction[0] = Friction { viscous: Some(0.5), coulomb: Some(0.25) };
    parameters.friction[1].viscous = Some(0.125);
    parameters.friction[2].coulomb = Some(-0.1);
    let exported = urdf(&robot, &parameters, Some(original))?;
    let again = Robot::from_urdf(&exported.text)?;
    same_torques(&torques(&robot, &stacked(&parameters)), &torques(&again, &again.inertial_parameters()?));
    assert!(exported.text.contains("<dynamics damping=\"0.5\" friction=\"0.25\"/>"), "{}", exported.text);
    assert!(
        exported.text.contains("<dynamics damping=\"0.125\" friction=\"9.0\"/>"),
        "what is not known stays"
    );
    assert_eq!(exported.text.matches("<dynamics").count(), 2);
    assert!(exported.notes.iter().any(|n| n.contains("`jc`: Coulomb friction -1.000e-1 is negative")));
    Ok(())
}

#[test]
fn another_robots_urdf_is_refused() {
    let robot = common::robot("panda.ron");
    let error = urdf(&robot, &bodies(&robot), Some(&six_axis())).expect_err("not its URDF");
    assert!(error.to_string().contains("no link `link1`"), "{error}");
}

/// Reads what this crate writes, with MuJoCo's meaning: a body's frame at zero position in its parent's, a
/// joint that turns it about a point and axis in its own frame.
fn read_mjcf(text: &str) -> Robot {
    let document = roxmltree::Document::parse(text).expect("well-formed");
    let numbers = |node: roxmltree::Node, name: &str| -> Vec<f64> {
        node.attribute(name).expect(name).split(' ').map(|x| x.parse().expect("a number")).collect()
    };
    let vector = |node, name: &str| Vector3::from_vec(numbers(node, name));
    let child = |node: roxmltree::Node<'_, '_>, tag: &str| {
        node.children().find(|n| n.has_tag_name(tag)).map(|n| n.id()).expect("is there")
    };
    let option = document.descendants().find(|n| n.has_tag_name("option")).expect("has options");
    let nodes: Vec<_> = document.descendants().filter(|n| n.has_tag_name("body")).collect();
    let name = |node: roxmltree::Node| node.attribute("name").expect("is named").to_string();
    let (mut joints, mut links) = (Vec::new(), Vec::new());
    for node in &nodes {
        let q = numbers(*node, "quat");
        let q = UnitQuaternion::from_quaternion(Quaternion::new(q[0], q[1], q[2], q[3]));
        let place = Pose { rotation: q.to_rotation_matrix().into_inner(), translation: vector(*node, "pos") };
        let joint = document.get_node(child(*node, "joint")).expect("a node");
        let anchor = Pose { translation: vector(joint, "pos"), ..Pose::identity() };
        joints.push(Joint {
            name: name(joint),
            kind: if joint.attribute("type") == Some("slide") {
                JointKind::Prismatic
            } else {
                JointKind::Revolute
            },
            parent: node.parent().and_then(|p| nodes.iter().position(|n| *n == p)),
            before: place.then(&anchor),
            axis: vector(joint, "axis"),
            after: anchor.inverse(),
            limits: Limits::default(),
        });
        let body = document.get_node(child(*node, "inertial")).expect("a node");
        let m = numbers(body, "fullinertia");
        let inertia = Matrix3::new(m[0], m[3], m[4], m[3], m[1], m[5], m[4], m[5], m[2]);
        let mass = numbers(body, "mass")[0];
        let inertia = InertialParameters::from_barycentric(mass, vector(body, "pos"), inertia);
        links.push(Link { name: name(*node), inertia: Some(inertia) });
    }
    let order = (0..joints.len()).collect();
    let gravity = vector(option, "gravity");
    Robot { name: "read".into(), gravity, joints, links, order, frames: Vec::new(), remarks: Vec::new() }
}

#[test]
fn an_mjcf_gives_the_torques_back() -> lacuna::Result<()> {
    for name in ["panda.ron", "two_link.ron", "six_axis.urdf"] {
        let robot = common::robot(name);
        let mut parameters = bodies(&robot);
        parameters.friction[0] = Friction { viscous: Some(0.5), coulomb: Some(0.25) };
        let exported = mjcf(&robot, &parameters)?;
        assert!(exported.text.contains("damping=\"0.5\" frictionloss=\"0.25\""));
        let read = read_mjcf(&exported.text);
        // Bodies nest, so they stand in the order of the tree, not in that of the joints.
        let place = |j: &Joint| robot.joints.iter().position(|k| k.name == j.name).expect("known");
        let n = robot.dof();
        let mut again = Robot { name: robot.name.clone(), ..robot.clone() };
        again.gravity = read.gravity;
        for (joint, link) in read.joints.iter().zip(&read.links) {
            let i = place(joint);
            let parent = joint.parent.map(|p| place(&read.joints[p]));
            again.joints[i] = Joint { parent, ..joint.clone() };
            again.links[i] = link.clone();
        }
        assert_eq!(read.joints.len(), n);
        same_torques(
            &torques(&robot, &stacked(&parameters)),
            &torques(&again, &again.inertial_parameters()?),
        );
    }
    Ok(())
}

fn value(symbol: String, value: f64) -> ParameterValue {
    ParameterValue { symbol, value, unit: "1".into(), standard_error: None, stands_for: None }
}

/// A model file with all link parameters and classic friction.
fn model(robot: &Robot, parameters: &[f64]) -> ModelFile {
    let effects: Vec<Box<dyn Effect>> = vec![
        Box::new(RigidBody::default()),
        Box::new(ViscousFriction::default()),
        Box::new(CoulombFriction::default()),
        Box::new(TorqueOffset::default()),
    ];
    let links = parameters.iter().enumerate().map(|(i, &x)| value(parameter_name(i), x));
    let friction = (1..=robot.dof())
        .flat_map(|j| [("fv", 0.5), ("fc", 0.25), ("fo", 0.125)].map(|(s, x)| value(format!("{s}{j}"), x)));
    ModelFile {
        lacuna: "test".into(),
        robot: robot.name.clone(),
        origin: "a test".into(),
        signals: Default::default(),
        effects,
        parameters: links.chain(friction).collect(),
    }
}

#[test]
fn json_carries_what_the_other_formats_cannot() -> lacuna::Result<()> {
    let robot = common::robot("panda.ron");
    let file = model(&robot, &robot.inertial_parameters()?);
    let parameters = Parameters::read(&file, &robot)?;
    assert_eq!((parameters.listed, parameters.left_out.as_slice()), (70, ["torque_offset"].as_slice()));
    let text = json(&robot, &parameters, &file)?.text;
    let document: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let link = &document["links"][1];
    assert_eq!(link["name"], "link2");
    assert!((link["mass"].as_f64().expect("a number") - 0.646926).abs() < 1e-15);
    let inertia = common::json_numbers(&link["inertia"]);
    for (found, published) in inertia.iter().zip([0.007962, -0.003925, 0.010254, 0.02811, 0.000704, 0.025995])
    {
        assert!((found - published).abs() < 1e-15);
    }
    assert_eq!(document["joints"][6]["parent"], "link6");
    assert_eq!(document["parameters"][0]["symbol"], "fv1");
    let notes = urdf(&robot, &parameters, None)?.notes;
    assert!(notes.iter().any(|n| n.contains("cannot say torque_offset")), "{notes:?}");
    assert!(notes.iter().any(|n| n.contains("-9.80665")), "{notes:?}");
    Ok(())
}

fn export(folder: &Path, file: &ModelFile, arguments: &[&str]) -> Output {
    let model = folder.join("model.ron");
    file.write(&model).expect("writes");
    let mut command = Command::new(env!("CARGO_BIN_EXE_lacuna"));
    command.arg("export").arg(&model).args(arguments).output().expect("runs")
}

#[test]
fn the_command_writes_refuses_and_is_forced() -> lacuna::Result<()> {
    let folder = tempfile::tempdir().expect("a folder");
    let robot = common::robot("panda.ron");
    let own = robot.inertial_parameters()?;
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();

    let out = folder.path().join("panda.urdf");
    let out_name = out.display().to_string();
    // The robot is found by its name in `robots`.
    let done = export(folder.path(), &model(&robot, &own), &["--format", "urdf", "--out", &out_name]);
    assert_eq!(done.status.code(), Some(0), "{}", text(&done.stderr));
    assert!(done.stdout.is_empty());
    let again = Robot::open(&out)?.with_gravity(robot.gravity);
    same_torques(&torques(&robot, &own), &torques(&again, &again.inertial_parameters()?));

    let mut sick = own.clone();
    sick[10] = -0.5;
    sick[49] += 1.0;
    let arguments = ["--robot", "robots/panda.ron", "--format", "mjcf"];
    let refused = export(folder.path(), &model(&robot, &sick), &arguments);
    assert_eq!(refused.status.code(), Some(1));
    assert!(refused.stdout.is_empty());
    let message = text(&refused.stderr);
    assert!(
        message.contains("link `link2`: its mass is -5.0") && message.contains("link `link5`"),
        "{message}"
    );
    let mut thin = own.clone();
    thin[49] += 1.0;
    let forced = export(folder.path(), &model(&robot, &thin), &[arguments.as_slice(), &["--force"]].concat());
    assert_eq!(forced.status.code(), Some(0));
    assert!(
        text(&forced.stderr)
            .contains("not physical: link `link5`: its inertia breaks the triangle inequality")
    );

    let base = BaseParameters::new(&robot);
    let lifted = base.lift(&base.coefficients(&own));
    let mut file = model(&robot, &lifted);
    file.parameters.retain(|p| p.value.abs() > 0.0);
    let refused = export(folder.path(), &file, &arguments);
    assert_eq!(refused.status.code(), Some(1));
    assert!(text(&refused.stderr).contains("base parameters give the right torque but belong to no body"));
    let forced = export(folder.path(), &file, &[arguments.as_slice(), &["--force"]].concat());
    assert_eq!(forced.status.code(), Some(2), "a first moment without mass cannot be written");

    let lost = export(folder.path(), &ModelFile { robot: "nobody".into(), ..file }, &["--format", "json"]);
    assert_eq!(lost.status.code(), Some(2));
    assert!(text(&lost.stderr).contains("--robot FILE"));
    Ok(())
}
