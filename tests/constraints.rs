//! Constraints: forms hold on bodies that should pass and fail on those that should not, with margins in
//! their own unit; gradients, round trips and the catalogue through the conformance checks.

use std::path::Path;

use lacuna::conformance;
use lacuna::constraints::{self, CATALOGUE, Constraint, LinkSpace, search_space};
use lacuna::form::{Body, Form};
use lacuna::retrieval::Chart;
use lacuna::robot::{InertialParameters, Robot};
use lacuna::space::Parameter;
use lacuna::text;
use nalgebra::{Matrix3, Vector3};

use super::common;

#[path = "constraints/cases.rs"]
mod cases;
#[path = "constraints/examples.rs"]
mod examples;
#[path = "constraints/refusals.rs"]
mod refusals;

const FIXTURES: &str = "tests/fixtures";

/// A constraint as written in a scenario, loaded.
fn constraint(ron: &str) -> Box<dyn Constraint> {
    let mut constraint: Box<dyn Constraint> = text::from_ron(ron).expect(ron);
    constraint.load(Path::new(FIXTURES)).expect("its files load");
    constraint
}

/// The links' parameters and two friction coefficients.
fn space(robot: &Robot) -> LinkSpace {
    LinkSpace::new(robot, &["fv1", "fc1"].map(|name| Parameter::free(name, "N m")))
}

fn forms(ron: &str, robot: &Robot) -> Vec<Form> {
    constraint(ron).forms(robot, &space(robot)).expect(ron)
}

/// Unknowns of a robot whose links are all the same body, and whose friction coefficients are 0.5.
fn all_links(robot: &Robot, body: InertialParameters) -> Vec<f64> {
    robot.links.iter().flat_map(|_| body.0).chain([0.5, 0.5]).collect()
}

/// A solid box of uniform density: mass, centre, edge lengths.
fn brick(mass: f64, com: [f64; 3], [a, b, c]: [f64; 3]) -> InertialParameters {
    let inertia = Vector3::new(b * b + c * c, a * a + c * c, a * a + b * b) * (mass / 12.0);
    InertialParameters::from_barycentric(mass, com.into(), Matrix3::from_diagonal(&inertia))
}

/// Smallest reported margin.
fn margin(forms: &[Form], z: &[f64]) -> f64 {
    forms.iter().map(|f| f.reported_margin(z)).fold(f64::INFINITY, f64::min)
}

#[track_caller]
fn near(a: f64, b: f64) {
    assert!((a - b).abs() < 1e-12 * (1.0 + a.abs().max(b.abs())), "{a} is not {b}");
}

#[test]
fn every_constraint_of_the_catalogue_keeps_its_promises() {
    let samples = cases::all();
    let mut names: Vec<&str> = CATALOGUE.iter().map(|about| about().name).collect();
    // Scripts have their own tests: their promises depend on what the script says.
    for name in names.iter().filter(|name| **name != "script") {
        assert!(samples.iter().any(|c| c.ron.contains(&format!("\"{name}\""))), "no sample of {name}");
    }
    for case in samples {
        conformance::constraint(case.ron, &case.robot, Path::new(FIXTURES), &[case.good])
            .unwrap_or_else(|e| panic!("{}: {e}", case.ron));
    }
    names.sort_unstable();
    names.dedup();
    assert_eq!(names.len(), CATALOGUE.len(), "names are unique");
}

#[test]
fn the_good_pass_and_the_bad_fail_by_the_margin_that_geometry_says() {
    for case in cases::all() {
        let forms = forms(case.ron, &case.robot);
        let passed = margin(&forms, &case.good);
        assert!(passed >= 0.0, "{}: {passed}", case.ron);
        assert!(forms.iter().all(|f| f.violation(&case.good) <= 0.0));
        for (z, expected) in &case.bad {
            let failed = margin(&forms, z);
            assert!((failed - expected).abs() < 1e-9, "{}: margin {failed}, expected {expected}", case.ron);
            assert!(forms.iter().any(|f| f.violation(z) > 0.0));
        }
    }
}

#[test]
fn a_rod_is_on_the_border_of_the_triangle_inequality() {
    let robot = common::robot("two_link.ron");
    let forms = forms(r#"{"triangle_inequality": ()}"#, &robot);
    let rod = InertialParameters::from_barycentric(
        2.0,
        Vector3::new(0.1, 0.2, -0.3),
        Matrix3::from_diagonal(&Vector3::new(0.04, 0.04, 0.0)),
    );
    let z = all_links(&robot, rod);
    assert!(margin(&forms, &z).abs() < 1e-15);
    // tr(I)/2 - lambda_max of a brick is half the smallest sum of squares, m/12 times the smallest edge squared.
    let z = all_links(&robot, brick(3.0, [0.4, -0.1, 0.2], [0.1, 0.2, 0.3]));
    near(margin(&forms, &z), 3.0 / 12.0 * 0.01);
}

#[test]
fn margins_do_not_depend_on_the_frame_of_a_body() {
    let robot = common::robot("panda.ron");
    let forms = forms(r#"{"triangle_inequality": (links: Only(["link3"]))}"#, &robot);
    let own = robot.links[2].inertia.expect("has one");
    let moment = own.inertia_at_center_of_mass().expect("has mass");
    let expected = 0.5 * moment.trace() - moment.symmetric_eigenvalues().max();
    let mut z = robot.inertial_parameters().expect("has all");
    near(forms[0].reported_margin(&z), expected);
    let mut pose = robot.joints[3].before;
    pose.translation *= 3.0;
    z[20..30].copy_from_slice(&own.moved(&pose).0);
    assert!((forms[0].reported_margin(&z) - expected).abs() < 1e-14);
}

#[test]
fn a_link_without_mass_has_no_centre_of_mass_to_be_outside() {
    let robot = common::robot("two_link.ron");
    let forms = forms(r#"{"com_sphere": (links: All, center: (0.0, 0.0, 0.0), radius: 0.1)}"#, &robot);
    let mut z = all_links(&robot, InertialParameters::ZERO);
    assert!(margin(&forms, &z).abs() < 1e-18);
    z[1] = 1e-3;
    assert!(margin(&forms, &z) < -0.9e-3, "a first moment without mass is no body");
}

#[test]
fn the_papers_bounds_hold_for_its_parameters_and_give_its_search_space() -> lacuna::Result<()> {
    let robot = common::robot("panda.ron");
    let space = LinkSpace::new(&robot, &[]);
    let all = constraints::open(Path::new("scenarios/panda_bounds.ron"))?;
    let forms = constraints::forms(&robot, &space, &all)?;
    // 7 triangles, 2 sums, 14 masses, 42 coordinates, 84 inertias.
    assert_eq!(forms.len(), 149);
    let z = robot.inertial_parameters()?;
    let worst = forms.iter().min_by(|a, b| a.reported_margin(&z).total_cmp(&b.reported_margin(&z)));
    let worst = worst.expect("there are forms");
    // The published set is feasible; its tightest triangle is link 2's, +8.6e-7 with the printed digits.
    assert!(worst.label.starts_with("link2: triangle"), "{}", worst.label);
    assert!((worst.reported_margin(&z) - 8.6e-7).abs() < 2e-8, "{}", worst.reported_margin(&z));
    let total = forms.iter().find(|f| f.label.starts_with("total mass >=")).expect("is there");
    assert!((total.margin(&z) - 0.0621).abs() < 1e-4);
    let search = search_space(&robot, &space, &all)?;
    assert!(search.assumed.is_empty(), "{:?}", search.assumed);
    let bounds = &search.chart.space().parameters;
    assert_eq!(bounds.len(), 70);
    let of = |name: &str| bounds.iter().find(|p| p.name == name).map(|p| (p.lower, p.upper));
    assert_eq!(of("c7z"), Some((0.04, 0.15)));
    assert_eq!(of("c5z"), Some((-0.35, 0.05)));
    assert_eq!(of("I3xy"), Some((-1.0, 1.0)));
    Ok(())
}

#[test]
fn open_sides_of_the_search_space_are_closed_and_named() -> lacuna::Result<()> {
    let robot = common::robot("two_link.ron");
    let space = LinkSpace::new(&robot, &[]);
    let all = [
        constraint(r#"{"mass_range": (min: 0.0, max: 10.0)}"#),
        constraint(
            r#"{"com_cylinder": (links: Only(["link1"]), center: (0.0, -0.75, 0.0), axis: (0.0, 1.0, 0.0), radius: 0.15)}"#,
        ),
    ];
    let search = search_space(&robot, &space, &all)?;
    let of = |name: &str| {
        search.chart.space().parameters.iter().find(|p| p.name == name).expect("is there").clone()
    };
    near(of("c1x").upper, 0.15);
    near(of("c1y").lower, -1.5);
    assert!(search.assumed.iter().any(|a| a.starts_with("c1y from")), "endless along its axis");
    assert!(!search.assumed.iter().any(|a| a.starts_with("c1x") || a.starts_with("m1")));
    assert!(search.chart.space().parameters.iter().all(|p| p.lower.is_finite() && p.upper.is_finite()));
    Ok(())
}

/// The supplement's two-link robot: its parameters, the real and the published ones, lie in the shapes,
/// written as convex constraints instead of the paper's if-else rules (the misprinted ones corrected).
#[test]
fn the_cylinder_with_a_conical_tip_is_convex_and_equals_the_if_else_rule() {
    let robot = common::robot("two_link.ron");
    let tip = r#"{"com_cone": (links: Only(["link2"]), base: (-0.2, 0.0, 0.0), axis: (1.0, 0.0, 0.0), radius: 0.08,
                              top_radius: 0.02, height: 0.2, caps: false)}"#;
    let tube = r#"{"com_cylinder": (links: Only(["link2"]), center: (0.0, 0.0, 0.0), axis: (1.0, 0.0, 0.0), radius: 0.08)}"#;
    let forms = [forms(tip, &robot), forms(tube, &robot)].concat();
    assert!(forms.iter().all(Form::is_convex));
    for (x, y, z) in
        [(-0.5, 0.03, 0.04), (-0.2, 0.0, 0.079), (-0.1, 0.03, 0.0), (-0.05, 0.02, 0.04), (0.0, 0.015, 0.0)]
    {
        let allowed = if x < -0.2 { 0.08 } else { 0.08 + (0.02 - 0.08) * (0.2 + x) / 0.2 };
        let at = all_links(&robot, brick(2.0, [x, y, z], [0.1; 3]));
        let across = f64::hypot(y, z);
        near(margin(&forms, &at), f64::min(0.08, allowed) - across);
    }
}

#[test]
fn a_relaxed_inertia_bound_is_implied_and_touches_at_the_corners_of_the_box() {
    let robot = common::robot("two_link.ron");
    let ron = r#"{"parameter_bounds": (bounds: {"c1x": (-0.1, 0.2), "c1y": (0.0, 0.3), "c1z": (-0.2, -0.1),
                  "I1xx": (0.0, 0.5), "I1xy": (-0.1, 0.1)})}"#;
    let forms = forms(ron, &robot);
    let general: Vec<&Form> = forms.iter().filter(|f| !f.is_convex()).collect();
    assert_eq!(general.len(), 3, "I1xx <= 0.5 and both sides of I1xy");
    for corner in [[-0.1, 0.0, -0.2], [0.2, 0.3, -0.1], [-0.1, 0.3, -0.2], [0.2, 0.0, -0.1]] {
        let mut z = all_links(&robot, brick(2.0, corner, [0.1, 0.2, 0.3]));
        z[5] += 0.03;
        for form in &general {
            let Body::General { implied, .. } = &form.body else { panic!("general") };
            assert!(!implied.is_empty());
            near(margin(implied, &z), form.margin(&z));
        }
    }
}

#[test]
fn a_payload_can_be_taken_off_a_link_that_carries_it_and_from_no_lighter_one() {
    let robot = common::robot("two_link.ron");
    let ron = r#"{"known_payload": (link: "link2", mass: 1.5, com: (0.1, 0.0, 0.05),
                  inertia: (xx: 0.002, yy: 0.003, zz: 0.004))}"#;
    let forms = forms(ron, &robot);
    let payload = InertialParameters::from_barycentric(
        1.5,
        Vector3::new(0.1, 0.0, 0.05),
        Matrix3::from_diagonal(&Vector3::new(0.002, 0.003, 0.004)),
    );
    let own = brick(2.0, [-0.3, 0.0, 0.0], [0.6, 0.06, 0.08]);
    let z = all_links(&robot, own.combined(&payload));
    near(forms[0].reported_margin(&z), 2.0 / 12.0 * 0.06 * 0.06);
    assert!(margin(&forms, &all_links(&robot, own)) < 0.0);
}

#[test]
fn only_what_fits_into_the_ellipsoid_is_density_realisable() {
    let robot = common::robot("two_link.ron");
    let ron = r#"{"density_realisable": (links: All, center: (0.1, 0.0, 0.2), semi_axes: (0.1, 0.2, 0.3), rpy: (0.2, -0.4, 1.0))}"#;
    let forms = forms(ron, &robot);
    let turn = nalgebra::Rotation3::from_euler_angles(0.2, -0.4, 1.0);
    // A homogeneous ellipsoid has second moments m s²/5, so tr(P Q) = m (1 - 3 (scale²)/5).
    for (scale, expected) in
        [(1.0, 2.0 * 0.4), (1.2, 2.0 * (1.0 - 0.6 * 1.44)), (1.3, 2.0 * (1.0 - 0.6 * 1.69))]
    {
        let s = Vector3::new(0.1, 0.2, 0.3).map(|s: f64| (s * scale).powi(2)) * (2.0 / 5.0);
        let second = turn.matrix() * Matrix3::from_diagonal(&s) * turn.matrix().transpose();
        let inertia = Matrix3::identity() * second.trace() - second;
        let body = InertialParameters::from_barycentric(2.0, Vector3::new(0.1, 0.0, 0.2), inertia);
        let z = all_links(&robot, body);
        assert!((forms[0].reported_margin(&z) - expected).abs() < 1e-12);
        assert_eq!(margin(&forms, &z) >= 0.0, scale < 1.29);
    }
}
