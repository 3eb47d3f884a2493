//! Every mistake in a robot file is answered with line, column and a remedy, and none with a panic.

use lacuna::Error;
use lacuna::robot::Robot;
use proptest::prelude::*;

const URDF: &str = include_str!("fixtures/robots/good.urdf");
const TABLE: &str = include_str!("fixtures/robots/good.ron");

/// `text` with its first `from` replaced.
fn with(text: &str, from: &str, to: &str) -> String {
    assert!(text.contains(from), "the fixture has no {from:?}");
    text.replacen(from, to, 1)
}

fn assert_error(error: &Error, place: (usize, usize), message: &str) {
    let found = error.place().map(|p| (p.line, p.column));
    assert_eq!(found, Some((Some(place.0), Some(place.1))), "{error}");
    assert!(error.message().contains(message), "{error}\nexpected: {message}");
    assert!(error.to_string().contains("help: "), "{error}");
}

fn check_urdf(from: &str, to: &str, place: (usize, usize), message: &str) {
    let error = Robot::from_urdf(&with(URDF, from, to)).expect_err(message);
    assert_error(&error, place, message);
}

fn check_table(from: &str, to: &str, place: (usize, usize), message: &str) {
    let error = Robot::from_dh(&with(TABLE, from, to)).expect_err(message);
    assert_error(&error, place, message);
}

fn remarks(text: &str) -> Vec<(Option<usize>, String)> {
    let robot = Robot::from_urdf(text).expect("reads");
    robot.remarks.into_iter().map(|r| (r.line, r.text)).collect()
}

#[test]
fn the_fixtures_are_good() {
    let urdf = Robot::from_urdf(URDF).expect("URDF");
    assert_eq!((urdf.dof(), urdf.links[0].inertia.is_some(), urdf.links[1].inertia), (2, true, None));
    let table = Robot::from_dh(TABLE).expect("table");
    assert_eq!((table.dof(), table.remarks.len()), (2, 0));
    assert_eq!(table.joints[1].limits, lacuna::robot::Limits::default());
    let upper = table.joints[0].limits.upper.expect("upper limit");
    assert!((upper - 60_f64.to_radians()).abs() < 1e-15);
}

#[test]
fn numbers() {
    for to in ["\"0 0\"", "\"0 0 1 0\"", "\"0 0 x\"", "\"0 NaN 1\"", "\"0 inf 1\"", "\"1e999 0 0\"", "\"\""] {
        check_urdf("\"0 0 1\"", to, (16, 11), "three finite numbers");
    }
    check_urdf("\"0 0 1\"", "\"0 0.0 0\"", (16, 11), "no direction");
    check_urdf("rpy=\"0 0 0.5\"", "rpy=\"0 0 0,5\"", (15, 27), "three finite numbers");
    check_urdf("value=\"1.5\"", "value=\"1,5\"", (7, 13), "finite number");
    check_urdf("value=\"1.5\"", "value=\"-inf\"", (7, 13), "finite number");
    check_urdf("damping=\"0\"", "damping=\"low\"", (18, 15), "finite number");
    check_urdf("upper=\"1\"", "upper=\"nan\"", (17, 23), "not a number");
    check_urdf("lower=\"-1\"", "lower=\"1.5\"", (17, 12), "above the upper limit");
    let error = Robot::from_urdf(&with(URDF, "value=\"1.5\"", "value=\"1,5\"")).expect_err("comma");
    assert!(error.to_string().contains("decimals with a point"), "{error}");
}

#[test]
fn missing_and_unknown_attributes_and_elements() {
    check_urdf("name=\"hinge\" ", "", (12, 3), "no attribute `name`");
    check_urdf("\"hinge\"", "\" \"", (12, 10), "empty name");
    check_urdf("type=\"revolute\"", "", (12, 3), "no attribute `type`");
    check_urdf("revolute", "hinge", (12, 23), "not a type of joint");
    check_urdf("revolute", "floating", (12, 23), "floating");
    check_urdf("revolute", "planar", (12, 23), "planar");
    check_urdf("<parent link=\"base\"/>", "", (12, 3), "no <parent>");
    check_urdf("<child link=\"arm\"/>", "", (12, 3), "no <child>");
    check_urdf(" link=\"arm\"", "", (14, 5), "no attribute `link`");
    check_urdf("axis xyz", "axis xzy", (16, 5), "no attribute `xyz`");
    check_urdf("rpy=\"0 0 0.5\"", "quat_xyzw=\"0 0 0 1\"", (15, 27), "quaternions");
    check_urdf("<mass value=\"1.5\"/>", "", (5, 5), "no <mass>");
    check_urdf("mass value", "mass kg", (7, 7), "no attribute `value`");
    check_urdf("iyz=\"0\" ", "", (8, 7), "no attribute `iyz`");
    check_urdf("<axis", "<mimic joint=\"slide\"/><axis", (16, 5), "mimics");
}

#[test]
fn trees_that_are_none() {
    check_urdf("parent link=\"base\"", "parent link=\"bass\"", (13, 13), "no link called `bass`");
    check_urdf("child link=\"arm\"", "child link=\"Arm\"", (14, 12), "no link called `Arm`");
    check_urdf("link name=\"arm\"", "link name=\"base\"", (4, 9), "two links are called `base`");
    check_urdf("\"slide\"", "\"hinge\"", (22, 10), "two joints are called `hinge`");
    check_urdf(
        "<link name=\"tool\"/>",
        "<link name=\"tool\"/><link name=\"loose\"/>",
        (21, 22),
        "hang on no joint",
    );
    check_urdf("child link=\"tool\"", "child link=\"arm\"", (24, 12), "hangs on two joints");
    check_urdf("parent link=\"arm\"", "parent link=\"tool\"", (22, 3), "form a loop");
    check_urdf("parent link=\"base\"", "parent link=\"tool\"", (12, 3), "`hinge`, `slide` form a loop");
    check_urdf("child link=\"tool\"", "child link=\"base\"", (12, 3), "`hinge`, `slide` form a loop");
    let all_fixed = with(&with(URDF, "revolute", "fixed"), "prismatic", "fixed");
    assert_error(&Robot::from_urdf(&all_fixed).expect_err("fixed"), (2, 1), "no movable joint");
}

#[test]
fn texts_that_are_no_urdf() {
    let check = |text: &str, place, message: &str| {
        assert_error(&Robot::from_urdf(text).expect_err(message), place, message);
    };
    check("", (1, 1), "no element");
    check("lower, upper\n1, 2\n", (1, 1), "not well-formed XML");
    check("<robot name='r'/>", (1, 1), "no <link>");
    check("<?xml version='1.0'?>\n<mujoco/>", (2, 1), "<mujoco>");
    check(&URDF[..URDF.len() - 10], (26, 11), "ends before");
    check(&with(URDF, "</robot>", "</Robot>"), (27, 1), "expected 'robot' tag");
    check(&with(URDF, "\"arm\"", "\"arm"), (5, 5), "not well-formed XML: expected '\"' not '<'");
    check(&with(URDF, "<robot", "<!DOCTYPE robot [<!ENTITY a 'b'>]>\n<robot"), (2, 1), "DTD");
    let deep = ["<robot name='r'>", &"<a>".repeat(200_000), &"</a>".repeat(200_000), "</robot>"].concat();
    check(&deep, (1, 1), "no <link>");
    check(&"<a>".repeat(200_000), (1, 600_001), "ends before");
}

#[test]
fn xacro_is_named() {
    let declared = with(URDF, "<robot", "<robot xmlns:xacro=\"http://www.ros.org/wiki/xacro\"");
    assert!(Robot::from_urdf(&declared).is_ok(), "an expanded file may keep the declaration");
    for text in [&declared, URDF] {
        let error = Robot::from_urdf(&with(text, "<axis", "<xacro:x/><axis")).expect_err("xacro");
        assert!(
            error.to_string().contains("16:") && error.to_string().contains("expand it first"),
            "{error}"
        );
    }
    let error = Robot::from_urdf(&with(URDF, "\"1.5\"", "\"${mass}\"")).expect_err("xacro");
    assert!(error.to_string().contains("expand it first"), "{error}");
}

#[test]
fn mesh_paths_stay_in_the_folder() {
    for path in ["../arm.stl", "meshes/../../arm.stl", "..\\arm.stl", "./../arm.stl"] {
        check_urdf("meshes/arm.stl", path, (10, 29), "leaves the folder");
    }
    for path in ["../../meshes/arm.stl", "../meshes/../../arm.stl", "../../etc/passwd"] {
        check_urdf("meshes/arm.stl", path, (10, 29), "leaves the folder");
    }
    for path in [
        "../meshes/arm.stl",
        "a/../b.stl",
        "package://arm/../b.stl",
        "file:///x/b.stl",
        "/x/b.stl",
        "a..b.stl",
    ] {
        assert!(Robot::from_urdf(&with(URDF, "meshes/arm.stl", path)).is_ok(), "{path}");
    }
}

#[test]
fn what_other_tools_forgive_is_forgiven() {
    let same = |text: String| {
        let (a, b) = (Robot::from_urdf(URDF).expect("good"), Robot::from_urdf(&text).expect("forgiven"));
        assert_eq!((a.joints, a.links, a.frames, a.order), (b.joints, b.links, b.frames, b.order));
    };
    same(format!("\u{feff}{}", URDF.replace('\n', "\r\n")));
    same(format!("\n<!-- first -->\n{URDF}"));
    same(with(URDF, "the tool", "---- the -- tool ----"));
    same(with(URDF, "<axis", "<drake:acceleration drake:max=\"3\"></drake:acceleration><axis"));
    same(with(URDF, "<robot", "<robot xmlns=\"http://www.ros.org\" xmlns:xsi=\"http://x.org/y\""));
    same(with(URDF, "<axis", "<axis rpy=\"0 0 0\""));
    same(with(URDF, "</robot>", "<gazebo reference='arm'><inertial/><joint/></gazebo></robot>"));
    same(with(URDF, "</robot>", "<transmission name='t'><joint name='hinge'/></transmission></robot>"));
    let renamed = |name: &str| Robot::from_urdf(&URDF.replace("\"arm\"", name)).expect("reads");
    assert_eq!(renamed("\"Unterarm links é 臂\"").links[0].name, "Unterarm links é 臂");
    let unlimited = with(URDF, "lower=\"-1\" upper=\"1\"", "lower=\"-inf\" upper=\"1e308\"");
    assert_eq!(Robot::from_urdf(&unlimited).expect("reads").joints[0].limits.lower, None);
    // Exporters write a zero axis into fixed joints.
    let fixed = with(&with(URDF, "prismatic", "fixed"), "\"1 0 0\"", "\"0 0 0\"");
    assert_eq!(Robot::from_urdf(&fixed).expect("reads").dof(), 1);
}

#[test]
fn remarks_name_their_line() {
    assert_eq!(
        remarks(URDF),
        [(Some(21), "link `tool` has no inertia, nor has anything fixed to it".into())]
    );
    let damped = remarks(&with(URDF, "damping=\"0\"", "damping=\"0.7\""));
    assert!(damped[0].0 == Some(18) && damped[0].1.contains("damping=0.7 not added"), "{damped:?}");
    let misspelt = remarks(&with(URDF, "<dynamics", "<dinamics"));
    assert!(misspelt[0].0 == Some(18) && misspelt[0].1.contains("<dinamics>"), "{misspelt:?}");
}

#[test]
fn implausible_inertias_are_named() {
    let doubt = |from: &str, to: &str, expected: &str| {
        let remarks = remarks(&with(URDF, from, to));
        let (line, text) = &remarks[0];
        assert_eq!(*line, Some(5), "{remarks:?}");
        assert!(text.starts_with("link `arm`: ") && text.contains(expected), "{text}\nexpected: {expected}");
    };
    doubt("\"1.5\"", "\"-1.5\"", "negative mass");
    doubt("\"1.5\"", "\"0\"", "inertia but no mass");
    doubt("ixx=\"0.01\"", "ixx=\"-0.01\"", "not positive definite");
    doubt("ixy=\"0\"", "ixy=\"0.02\"", "not positive definite");
    doubt("izz=\"0.02\"", "izz=\"0.031\"", "triangle inequality");
    doubt("\"0.1 0 0\"", "\"100 0 0\"", "centre of mass");
    doubt("\"1.5\"", "\"0.0015\"", "radius of gyration");
    let tensor = "ixx=\"0.01\" ixy=\"0\" ixz=\"0\" iyy=\"0.02\" iyz=\"0\" izz=\"0.02\"";
    doubt(tensor, "ixx=\"1\" ixy=\"0\" ixz=\"0\" iyy=\"1\" iyz=\"0\" izz=\"1\"", "default");
    doubt(tensor, "ixx=\"0\" ixy=\"0\" ixz=\"0\" iyy=\"0\" iyz=\"0\" izz=\"0\"", "point mass");
    // On the border: a rod, whose smallest moment is 0, and a plate, rounded in the last digit.
    for moments in ["ixx=\"0\" iyy=\"0.02\" izz=\"0.02\"", "ixx=\"0.01\" iyy=\"0.02\" izz=\"0.03000001\""] {
        let plausible = with(URDF, tensor, &format!("{moments} ixy=\"0\" ixz=\"0\" iyz=\"0\""));
        assert_eq!(remarks(&plausible).len(), 1, "{:?}", remarks(&plausible));
    }
}

#[test]
fn tables() {
    check_table("    convention: Modified,\n", "", (20, 1), "`convention` is missing");
    check_table("    gravity: (0.0, 0.0, -9.81),\n", "", (20, 1), "`gravity` is missing");
    check_table("Modified", "Craig", (4, 17), "expected either `Modified` or `Standard`");
    check_table("gravity", "g", (5, 5), "expected one of `name`, `convention`, `gravity`");
    check_table("(0.0, 0.0, -9.81)", "(0.0, -9.81)", (5, 25), "length 3");
    check_table("-9.81", "NaN", (5, 25), "not a usable number");
    check_table("alpha: 0.0, d: 0.2", "d: 0.2", (16, 9), "`alpha` is missing");
    check_table("alpha: 0.0, d: 0.2", "alfa: 0.0, d: 0.2", (10, 21), "expected one of");
    check_table("theta: 30.0", "theta: \"30\"", (10, 47), "a number is expected");
    check_table("lower: -60.0", "lower: 61.0", (11, 76), "above the upper limit");
    check_table("com: (0.1, 0.0, 0.0),", "", (15, 13), "`com` is missing");
    check_table("zz: 0.02", "zz: inf", (14, 77), "not a usable number");
    check_table("Prismatic", "Linear", (18, 31), "expected either `Revolute` or `Prismatic`");
    check_table("name: \"slide\"", "name: \"hinge\"", (18, 9), "two joints are called `hinge`");
    check_table("link: 2", "link: 3", (20, 14), "the table has 2");
    let negative = with(TABLE, "mass: 1.5", "mass: -1.5");
    let remarks = Robot::from_dh(&negative).expect("reads").remarks;
    assert!(remarks[0].line == Some(8) && remarks[0].text.contains("negative mass"), "{remarks:?}");
}

#[test]
fn texts_that_are_no_table() {
    let check = |text: &str, message: &str| {
        let error = Robot::from_dh(text).expect_err(message);
        assert!(error.message().contains(message), "{error}");
        assert!(error.place().is_some_and(|p| p.line.is_some() && p.column.is_some()), "{error}");
    };
    check("", "empty");
    check(URDF, "an opening `(` is expected");
    check(&TABLE[..TABLE.len() - 3], "Unexpected end");
    check("(convention: Modified, gravity: (0, 0, -9.81), rows: [])", "no rows");
    for bracket in ["(", "[", "{x:", "Some("] {
        check(&format!("(rows: {}", bracket.repeat(100_000)), "");
        check(&format!("(rows: [(a: {}", bracket.repeat(100_000)), "");
    }
    check(&format!("(rows: {}", "[".repeat(100_000)), "nested too deeply");
    check(&"/*".repeat(100_000), "");
}

/// Flips, deletes, doubles or cuts bytes, and keeps what is still UTF-8.
fn mutated(text: &'static str) -> impl Strategy<Value = String> {
    let change = (0..4_u8, any::<prop::sample::Index>(), any::<u8>());
    proptest::collection::vec(change, 1..6).prop_map(move |changes| {
        let mut bytes = text.as_bytes().to_vec();
        for (kind, place, byte) in changes {
            let i = place.index(bytes.len());
            match kind {
                0 => bytes[i] ^= 1 << (byte % 8),
                1 => drop(bytes.drain(i..(i + usize::from(byte)).min(bytes.len()))),
                2 => bytes.insert(i, byte),
                _ => bytes.truncate(i + 1),
            }
            if bytes.is_empty() {
                bytes.push(byte);
            }
        }
        String::from_utf8_lossy(&bytes).into_owned()
    })
}

proptest! {
    #![proptest_config(ProptestConfig { cases: 200, failure_persistence: None, ..ProptestConfig::default() })]

    #[test]
    fn mutations_never_panic(urdf in mutated(URDF), table in mutated(TABLE)) {
        for robot in [Robot::from_urdf(&urdf), Robot::from_dh(&table)] {
            match robot {
                Ok(robot) => {
                    prop_assert!(robot.order.len() == robot.dof() && robot.links.len() == robot.dof());
                    let numbers = robot.inertial_parameters_or_zero();
                    prop_assert!(numbers.iter().all(|x| x.is_finite()));
                }
                Err(error) => prop_assert!(error.place().is_some_and(|p| p.line.is_some()), "{}", error),
            }
        }
    }
}
