//! Robot files in, robots out: kinematics, merged inertias, and an answer to every bad input.

use std::path::{Path, PathBuf};

use lacuna::robot::{InertialParameters, JointKind, Pose, Robot, implausible_inertias};
use nalgebra::{Matrix3, Vector3};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

fn file(path: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join(path)
}

fn shipped(name: &str) -> Robot {
    Robot::open(file("robots").join(name)).expect("a shipped robot reads")
}

fn positions(robot: &Robot, rng: &mut Xoshiro256PlusPlus) -> Vec<f64> {
    (0..robot.dof()).map(|_| rng.random_range(-3.0..3.0)).collect()
}

fn distance(a: &Pose, b: &Pose) -> f64 {
    (a.rotation - b.rotation).amax().max((a.translation - b.translation).amax())
}

#[test]
fn panda_table_and_urdf_agree() {
    let table = shipped("panda.ron");
    let urdf = Robot::open(file("tests/fixtures/robots/panda_kinematics.urdf")).expect("reads");
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(1);
    for _ in 0..50 {
        let q = positions(&table, &mut rng);
        for link in 0..7 {
            assert!(distance(&table.link_pose(&q, link), &urdf.link_pose(&q, link)) < 1e-14);
        }
    }
    let flange = |robot: &Robot| robot.frames.iter().find(|f| f.name == "flange").cloned().expect("flange");
    assert_eq!(flange(&table).pose, flange(&urdf).pose);
    assert_eq!(flange(&table).link, Some(6));
}

#[test]
fn panda_reaches_its_known_ready_pose() {
    // At zero the arm is stretched upwards: 0.333 + 0.316 + 0.384 - 0.107 above the base, 0.088 ahead.
    let panda = shipped("panda.ron");
    let flange = panda.link_pose(&[0.0; 7], 6).then(&panda.frames[0].pose);
    assert!((flange.translation - Vector3::new(0.088, 0.0, 0.926)).amax() < 1e-15);
    assert_eq!(flange.rotation, Matrix3::from_diagonal(&Vector3::new(1.0, -1.0, -1.0)));
}

#[test]
fn shipped_robots_are_what_they_claim() {
    let panda = shipped("panda.ron");
    assert_eq!((panda.dof(), panda.name.as_str()), (7, "panda"));
    assert_eq!(panda.gravity, Vector3::new(0.0, 0.0, -9.80665));
    assert_eq!(panda.joints[3].limits.upper, Some(-0.0698));
    let mass: f64 = panda.links.iter().filter_map(|l| l.inertia).map(|i| i.mass()).sum();
    assert!((mass - 16.0621).abs() < 5e-5, "{mass}");
    assert_eq!(panda.remarks, []);
    assert_eq!(implausible_inertias(&panda), []);

    let two = shipped("two_link.ron");
    assert_eq!((two.dof(), two.gravity.z), (2, -9.81));
    assert_eq!(two.remarks, []);

    let six = shipped("six_axis.urdf");
    assert_eq!(six.dof(), 8);
    assert_eq!(six.joint_index("wrist_1"), Some(2), "document order");
    assert_eq!(six.order, [0, 1, 3, 2, 4, 5, 6, 7]);
    assert_eq!(six.joints[6].kind, JointKind::Prismatic);
    assert_eq!(six.remarks.len(), 1, "{:?}", six.remarks);
    assert!(six.remarks[0].text.contains("damping"), "{:?}", six.remarks);
}

#[test]
fn two_link_coefficients_are_those_of_the_paper() {
    // The eight combinations that the torques depend on (in print rounded to three digits; the
    // sixth is printed with 0.8 m2, but only l2² = 0.64 is identifiable).
    let robot = shipped("two_link.ron");
    let [one, two] = [0, 1].map(|i| robot.links[i].inertia.expect("inertia"));
    let (m2, j1, j2) = (two.mass(), one.inertia_at_origin(), two.inertia_at_origin());
    let found = [
        j1[(1, 1)] + j2[(1, 1)] - 0.64 * m2,
        j2[(0, 0)] - j2[(1, 1)] + 0.64 * m2,
        j2[(0, 1)],
        j2[(0, 2)],
        j2[(1, 2)],
        j2[(2, 2)] - 0.64 * m2,
        two.first_moment().x + 0.8 * m2,
        two.first_moment().y,
    ];
    let printed = [-1.816, 1.86, 0.0, 0.0, 0.0, -1.85, 2.1, 0.0];
    for (found, printed) in found.iter().zip(printed) {
        assert!((found - printed).abs() < 1e-12, "{found} {printed}");
    }
}

/// The same planar arm in both conventions: frames differ, joint axes and the tip do not.
#[test]
fn conventions_describe_the_same_arm() {
    let rows = "rows: [(a: 0.0, alpha: 0.0, d: 0.0, theta: 0.2), (a: 0.5, alpha: 0.0, d: 0.1, theta: 0.0)]";
    let modified = format!(
        "(convention: Modified, gravity: (0, 0, -9.81), {rows}, \
         frames: [(name: \"tip\", a: 0.3, alpha: 0, d: 0, theta: 0)])"
    );
    let standard = "(convention: Standard, gravity: (0, 0, -9.81), rows: [(a: 0.5, alpha: 0, d: 0.1, theta: 0.2), \
                    (a: 0.3, alpha: 0, d: 0, theta: 0)])";
    let modified = Robot::from_dh(&modified).expect("modified");
    let standard = Robot::from_dh(standard).expect("standard");
    let mut rng = Xoshiro256PlusPlus::seed_from_u64(2);
    for _ in 0..20 {
        let q = positions(&modified, &mut rng);
        let tip = modified.link_pose(&q, 1).then(&modified.frames[0].pose);
        assert!(distance(&tip, &standard.link_pose(&q, 1)) < 1e-15);
        assert!(distance(&modified.link_pose(&q, 1), &standard.link_pose(&q, 1)) > 0.1);
    }
}

/// Standard tables against the textbook matrix (Spong, Hutchinson and Vidyasagar, eq. 3.10).
#[test]
fn standard_rows_are_the_textbook_matrix() {
    let text = "(convention: Standard, angles: Degrees, gravity: (0, 0, -9.81), rows: [\
                (a: 0.3, alpha: 90, d: 0.2, theta: 30), \
                (a: -0.1, alpha: -35, d: 0.4, theta: 0, kind: Prismatic)])";
    let robot = Robot::from_dh(text).expect("reads");
    let matrix = |a: f64, alpha: f64, d: f64, theta: f64| {
        let ((st, ct), (sa, ca)) = (theta.sin_cos(), alpha.sin_cos());
        let rotation = Matrix3::new(ct, -st * ca, st * sa, st, ct * ca, -ct * sa, 0.0, sa, ca);
        Pose { rotation, translation: Vector3::new(a * ct, a * st, d) }
    };
    let q = [0.7, 0.25];
    let first = matrix(0.3, 90_f64.to_radians(), 0.2, 30_f64.to_radians() + q[0]);
    let second = first.then(&matrix(-0.1, -35_f64.to_radians(), 0.4 + q[1], 0.0));
    assert!(distance(&robot.link_pose(&q, 0), &first) < 1e-15);
    assert!(distance(&robot.link_pose(&q, 1), &second) < 1e-15);
}

#[test]
fn degrees_and_radians_are_the_same_to_the_last_bit() {
    let table = |angles: &str, right: &str| {
        let text = format!(
            "(convention: Modified, angles: {angles}, gravity: (0, 0, -9.81), \
             rows: [(a: 0.1, alpha: {right}, d: 0.2, theta: -{right})])"
        );
        Robot::from_dh(&text).expect("reads")
    };
    assert_eq!(table("Degrees", "90"), table("Radians", "1.5707963267948966"));
}

/// A bar of 2 kg with a box of 1 kg fixed to its end and turned by 90 degrees about z.
#[test]
fn fixed_links_are_merged() {
    let text = r#"<robot name="bar">
      <joint name="glue" type="fixed"><parent link="bar"/><child link="box"/>
        <origin xyz="1 0 0" rpy="0 0 1.5707963267948966"/><axis xyz="0 0 0"/></joint>
      <joint name="hinge" type="continuous"><parent link="base"/><child link="bar"/><axis xyz="0 0 1"/></joint>
      <link name="box"><inertial><origin xyz="0 0.5 0"/><mass value="1"/>
        <inertia ixx="0.1" ixy="0.01" ixz="0" iyy="0.2" iyz="0" izz="0.25"/></inertial></link>
      <link name="bar"><inertial><origin xyz="0.5 0 0"/><mass value="2"/>
        <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.2" iyz="0" izz="0.2"/></inertial></link>
      <link name="base"/></robot>"#;
    let robot = Robot::from_urdf(text).expect("reads");
    // The box's centre lies at (1 - 0.5, 0, 0); its x and y moments swap and ixy changes sign.
    let box_ = InertialParameters::from_barycentric(
        1.0,
        Vector3::new(0.5, 0.0, 0.0),
        Matrix3::new(0.2, -0.01, 0.0, -0.01, 0.1, 0.0, 0.0, 0.0, 0.25),
    );
    let bar = InertialParameters::from_barycentric(
        2.0,
        Vector3::new(0.5, 0.0, 0.0),
        Matrix3::from_diagonal(&Vector3::new(0.01, 0.2, 0.2)),
    );
    let merged = robot.links[0].inertia.expect("inertia");
    for (found, expected) in merged.as_slice().iter().zip(bar.combined(&box_).as_slice()) {
        assert!((found - expected).abs() < 1e-15, "{merged:?}");
    }
    let names: Vec<_> = robot.frames.iter().map(|f| (f.name.as_str(), f.link)).collect();
    assert_eq!(names, [("box", Some(0)), ("base", None)]);
    assert_eq!(robot.frames[0].pose.translation, Vector3::x());
}

#[test]
fn files_that_cannot_be_read_are_named() {
    let folder = tempfile::tempdir().expect("a temporary folder");
    let missing = Robot::open(folder.path().join("none.urdf")).expect_err("missing").to_string();
    assert!(missing.contains("none.urdf") && missing.contains("help: "), "{missing}");

    let latin = folder.path().join("latin.urdf");
    std::fs::write(&latin, b"<robot>\n  <!-- \xe9 -->\n</robot>").expect("writes");
    let latin = Robot::open(latin).expect_err("not UTF-8").to_string();
    assert!(latin.contains("latin.urdf:2:8: ") && latin.contains("UTF-8"), "{latin}");

    let table = folder.path().join("wrong.ron");
    std::fs::write(&table, "(convention: Modified)").expect("writes");
    let table = Robot::open(table).expect_err("no gravity").to_string();
    assert!(table.contains("wrong.ron:1:22: the field `gravity` is missing"), "{table}");
}

#[test]
fn real_ur10e_reads() {
    let Ok(data) = std::env::var("LACUNA_DATA") else {
        println!("skipped: LACUNA_DATA is not set");
        return;
    };
    let robot = Robot::open(Path::new(&data).join("ur10e/robot.urdf")).expect("reads");
    assert_eq!(robot.dof(), 6);
    assert_eq!(robot.joint_index("shoulder_pan_joint"), Some(0));
    assert!(robot.inertial_parameters().is_ok());
}
