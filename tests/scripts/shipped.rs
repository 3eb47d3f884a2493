//! What the scripts of `constraints/` mean.

use std::path::Path;

use lacuna::constraints::{Constraint, Explanation, LinkSpace, Links, Scripted, explain};
use lacuna::form::{Body, Form};
use lacuna::robot::{InertialParameters, Robot};
use lacuna::script::{Script, Setting, Settings};
use nalgebra::{Matrix3, Vector3};

use super::two_link;

fn shipped(name: &str) -> Script {
    Script::open(&Path::new("constraints").join(name)).expect("the script is there")
}

/// Forms of a shipped script for one link of the two-link robot.
fn forms(name: &str, link: &str, with: Settings) -> Vec<Form> {
    let (robot, space) = two_link();
    let mut constraint = Scripted::from_script(shipped(name), with);
    constraint.links = Links::Only(vec![link.to_string()]);
    constraint.forms(&robot, &space).expect("a shipped script lowers")
}

/// The two-link robot with another body as link 2.
fn with_second(mass: f64, com: [f64; 3]) -> Vec<f64> {
    let (robot, _) = two_link();
    let mut z = robot.inertial_parameters().expect("known");
    let link = InertialParameters::from_barycentric(mass, Vector3::from(com), Matrix3::identity() * 0.01);
    z[10..20].copy_from_slice(link.as_slice());
    z
}

fn holds(forms: &[Form], z: &[f64]) -> bool {
    forms.iter().all(|f| f.violation(z) <= 1e-12)
}

#[test]
fn every_shipped_script_is_explained() {
    let mut count = 0;
    for entry in std::fs::read_dir("constraints").expect("the folder is there") {
        let path = entry.expect("reads").path();
        if path.extension().is_none_or(|e| e != "rhai") {
            continue;
        }
        for robot in ["robots/two_link.ron", "robots/panda.ron"] {
            let robot = Robot::open(robot).expect("reads");
            let told = explain(&path, &robot).unwrap_or_else(|e| panic!("{e}"));
            assert!(told.rules.iter().all(|r| r.line > 1 && !r.forms.is_empty()), "{}", path.display());
        }
        count += 1;
    }
    assert_eq!(count, 7);
}

#[test]
fn total_mass_of_the_panda_is_affine_in_all_links() {
    let robot = Robot::open("robots/panda.ron").expect("reads");
    let told: Explanation = explain(Path::new("constraints/total_mass.rhai"), &robot).expect("explains");
    assert_eq!(told.links.len(), 7);
    assert_eq!(told.settings, [("max".to_string(), "20.0".into()), ("min".to_string(), "16.0".into())]);
    for form in told.rules.iter().flat_map(|r| &r.forms) {
        assert_eq!((form.kind, form.unit.as_str()), ("affine", "kg"));
        assert!(form.engines.contains(&"lmi"));
    }
    let forms = Scripted::from_script(shipped("total_mass.rhai"), Settings::new())
        .forms(&robot, &LinkSpace::new(&robot, &[]))
        .expect("lowers");
    let mut z = vec![0.0; 70];
    (0..7).for_each(|link| z[10 * link] = 2.5);
    assert!((forms[0].margin(&z) - 1.5).abs() < 1e-12, "17.5 - 16 kg");
    assert!((forms[1].margin(&z) - 2.5).abs() < 1e-12, "20 - 17.5 kg");
    assert!((forms[0].scale - 16.0).abs() < 1e-12 && (forms[1].scale - 20.0).abs() < 1e-12);
}

#[test]
fn the_cylinder_is_a_cone_measured_in_metres() {
    let forms = forms("cylinder.rhai", "link1", Settings::new());
    assert!(matches!(forms[0].body, Body::Norm { .. }), "{:?}", forms[0]);
    assert!(forms[1..].iter().all(|f| matches!(f.body, Body::Affine(_))));
    // p_real of the paper: com (0.01, -0.75, -0.02), radius 0.15.
    let (robot, _) = two_link();
    let z = robot.inertial_parameters().expect("known");
    let expected = 0.15 - 0.01_f64.hypot(0.02);
    assert!((forms[0].reported_margin(&z) - expected).abs() < 1e-12);
    assert_eq!(forms[0].unit, "m");
    // The body is multiplied by the mass of 8 kg.
    assert!((forms[0].margin(&z) - 8.0 * expected).abs() < 1e-12);
    let mut massless = z.clone();
    massless[..10].fill(0.0);
    assert!(holds(&forms, &massless), "a link without mass has its centre nowhere");
}

#[test]
fn cone_tip_with_if_and_with_min_are_the_same_shape() {
    let by_if = forms("cone_tip.rhai", "link2", Settings::new());
    let by_min = forms("cone_tip_convex.rhai", "link2", Settings::new());
    assert!(
        matches!(&by_if[0].body, Body::General { why, .. } if why.contains("line 19, column 26")),
        "{:?}",
        by_if[0]
    );
    assert!(by_min.len() == 2 && by_min.iter().all(|f| matches!(f.body, Body::Norm { .. })));
    let mut inside = 0;
    for i in 0..60 {
        for k in 0..30 {
            let (x, y) = (-0.5 + 0.01 * f64::from(i), 0.0007 + 0.004 * f64::from(k));
            let z = with_second(3.0, [x, 0.8 * y, 0.6 * y]);
            // Retyped from the supplement: r2 = 0.08, r3 = 0.02, l2' = 0.2.
            let radius = if x < -0.2 { 0.08 } else { 0.08 + (0.02 - 0.08) * (0.2 + x) / 0.2 };
            assert!((by_if[0].reported_margin(&z) - (radius - y)).abs() < 1e-12);
            assert_eq!(holds(&by_if, &z), y <= radius, "if: {x} {y}");
            assert_eq!(holds(&by_min, &z), y <= radius, "min: {x} {y}");
            inside += usize::from(y <= radius);
        }
    }
    assert!((200..1700).contains(&inside), "the grid crosses the surface: {inside}");
}

#[test]
fn the_l_is_not_convex() {
    let forms = forms("l_shape.rhai", "link2", Settings::new());
    assert_eq!(forms.iter().filter(|f| !f.is_convex()).count(), 1);
    let (one, other) = (with_second(2.0, [-0.4, 0.0, 0.0]), with_second(2.0, [0.0, 0.0, 0.4]));
    let between: Vec<f64> = one.iter().zip(&other).map(|(a, b)| 0.5 * (a + b)).collect();
    assert!(holds(&forms, &one) && holds(&forms, &other));
    assert!(!holds(&forms, &between), "the corner is empty");
    let convex: Vec<Form> = forms.iter().filter(|f| f.is_convex()).cloned().collect();
    assert!(holds(&convex, &between), "the box around it is a relaxation");
    // 0.15 m from either arm: x = -0.2 is 0.15 beyond the second arm, z = 0.2 beyond the first.
    let l = forms.iter().find(|f| !f.is_convex()).expect("the L");
    assert!((l.reported_margin(&between) + 0.15).abs() < 1e-12, "{}", l.reported_margin(&between));
}

#[test]
fn symmetry_is_linear() {
    for normal in ["x", "y", "z"] {
        let with = Settings::from([("normal".into(), Setting::Text(normal.into()))]);
        let forms = forms("symmetric.rhai", "link2", with);
        assert_eq!(forms.len(), 6);
        assert!(forms.iter().all(|f| matches!(f.body, Body::Affine(_))));
        let axis = ["x", "y", "z"].iter().position(|a| *a == normal).expect("an axis");
        let mut com = [0.2, 0.2, 0.2];
        com[axis] = 0.0;
        assert!(holds(&forms, &with_second(2.0, com)), "mirrored along {normal}");
        com[axis] = 0.01;
        assert!(!holds(&forms, &with_second(2.0, com)), "off the plane along {normal}");
    }
}

#[test]
fn the_conditional_rule_applies_to_heavy_links_only() {
    let forms = forms("heavy_near_joint.rhai", "link2", Settings::new());
    assert_eq!(forms.len(), 2);
    assert!(holds(&forms, &with_second(3.9, [0.3, 0.0, 0.0])));
    assert!(!holds(&forms, &with_second(4.1, [0.3, 0.0, 0.0])));
    assert!(holds(&forms, &with_second(4.1, [0.05, 0.0, 0.0])));
    assert!(!holds(&forms, &with_second(1.0, [0.6, 0.0, 0.0])), "the other rule is for all");
}

#[test]
fn the_true_two_link_robot_satisfies_its_shapes() {
    let (robot, _) = two_link();
    let z = robot.inertial_parameters().expect("known");
    assert!(holds(&forms("cylinder.rhai", "link1", Settings::new()), &z));
    assert!(holds(&forms("cone_tip.rhai", "link2", Settings::new()), &z));
}
