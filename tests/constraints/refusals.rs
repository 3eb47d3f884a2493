//! What a constraint refuses, and what it says then.

use std::path::Path;

use lacuna::Error;
use lacuna::constraints::{self, Constraint, LinkSpace, search_space};
use lacuna::robot::Robot;
use lacuna::text;

use super::common;
use super::constraint;

fn unread(ron: &str) -> String {
    let read = text::from_ron::<Vec<Box<dyn Constraint>>>(&format!("[\n  {ron}\n]"));
    read.map(|_| ()).expect_err(ron).to_string()
}

fn unfit(ron: &str, robot: &Robot) -> String {
    let space = LinkSpace::new(robot, &[]);
    let all = [constraint(ron)];
    constraints::forms(robot, &space, &all).map(|_| ()).expect_err(ron).to_string()
}

fn unloaded(ron: &str, folder: &Path) -> Error {
    let mut constraint: Box<dyn Constraint> = text::from_ron(ron).expect(ron);
    constraint.load(folder).expect_err(ron)
}

#[test]
fn slips_of_the_pen_are_shown_where_they_stand() {
    for (ron, place, what) in [
        (r#"{"total_mas": (min: 1.0)}"#, "2:5", "total_mass"),
        (r#"{"total_mass": (minimum: 1.0)}"#, "2:19", "`min`"),
        (r#"{"total_mass": (min: inf)}"#, "2:", "leave the field out"),
        (r#"{"com_sphere": (links: All, center: (0.0, 0.0, 0.0))}"#, "2:", "radius"),
        (r#"{"com_sphere": (links: All, center: (0.0, 0.0, 0.0), radius: -0.1)}"#, "2:", "`radius` is -0.1"),
        (r#"{"com_sphere": (links: All, center: (0.0, NaN, 0.0), radius: 0.1)}"#, "2:", "`center` is NaN"),
        (r#"{"com_sphere": (links: ["link1"], center: (0.0, 0.0, 0.0), radius: 0.1)}"#, "2:26", "`All`"),
        (r#"{"com_sphere": (center: (0.0, 0.0, 0.0), radius: 0.1)}"#, "2:", "links"),
        (
            r#"{"com_cylinder": (links: All, center: (0.0, 0.0, 0.0), axis: (0.0, 0.0, 0.0), radius: 0.1)}"#,
            "2:",
            "no direction",
        ),
        (
            r#"{"com_ellipsoid": (links: All, center: (0.0, 0.0, 0.0), semi_axes: (0.1, 0.0, 0.1))}"#,
            "2:",
            "`semi_axes` is 0",
        ),
        (r#"{"com_union": (links: All, shapes: [Ball(radius: 1.0)])}"#, "2:", "Sphere"),
        (
            r#"{"parameter_bounds": (bounds: {"m1": (10.0, 0.0)})}"#,
            "2:",
            "lower limit 10 is above the upper limit 0",
        ),
        (r#"{"parameter_bounds": (bounds: {"m1": (0.0, 1.0), "m1": (0.0, 2.0)})}"#, "2:", "bounded twice"),
        (r#"{"parameter_bounds": (bounds: {"m1": (inf, inf)})}"#, "2:", "no number lies between"),
        (r#"{"mirrored_links": (links: ("a", "b"), along: W)}"#, "2:", "`X`"),
    ] {
        let message = unread(ron);
        assert!(message.contains(&format!(":{place}")) && message.contains(what), "{ron}\n{message}");
    }
}

#[test]
fn what_does_not_fit_the_robot_is_named_with_what_is_known() {
    let panda = common::robot("panda.ron");
    for (ron, what) in [
        (r#"{"mass_range": (links: Only(["link9"]), min: 1.0)}"#, "mass_range: no link `link9`"),
        (
            r#"{"mass_range": (links: Only(["link9"]), min: 1.0)}"#,
            "link1, link2, link3, link4, link5, link6, link7, or numbers 1 to 7",
        ),
        (r#"{"mass_range": (links: Only(["flange"]), min: 1.0)}"#, "it is fixed to `link7`"),
        (r#"{"mass_range": (links: Only(["3", "link3"]), min: 1.0)}"#, "named twice"),
        (r#"{"mass_range": (links: Only([]), min: 1.0)}"#, "list of links is empty"),
        (r#"{"mass_range": ()}"#, "neither `min` nor `max`"),
        (r#"{"total_mass": (min: 20.0, max: 16.0)}"#, "min 20 kg is above max 16 kg"),
        (r#"{"mass_ratio": (link: "1", to: "link1", min: 1.0)}"#, "with itself"),
        (r#"{"mass_order": (heaviest_first: ["link1"])}"#, "at least two links"),
        (r#"{"mass_order": (heaviest_first: ["link1", "2", "1"])}"#, "twice"),
        (
            r#"{"com_box": (links: All, lower: (0.0, 0.2, 0.0), upper: (1.0, 0.1, 1.0))}"#,
            "in y, lower 0.2 m is above upper 0.1 m",
        ),
        (
            r#"{"com_cone": (links: All, base: (0.0, 0.0, 0.0), axis: (0.0, 0.0, 1.0), radius: 0.0, top_radius: 0.0, height: 1.0)}"#,
            "no radius",
        ),
        (r#"{"com_union": (links: All, shapes: [])}"#, "no shapes"),
        (r#"{"equal_links": (links: ("link1", "1"))}"#, "the same link"),
        (
            r#"{"known_payload": (link: "link7", mass: 1.0, com: (0.0, 0.0, 0.1), inertia: (xx: 0.1))}"#,
            "triangle inequality",
        ),
        (r#"{"parameter_bounds": (bounds: {"I8xx": (0.0, 1.0)})}"#, "no parameter `I8xx`"),
        (r#"{"parameter_bounds": (bounds: {"fv3": (0.0, inf)})}"#, "known are m1, c1x"),
    ] {
        let message = unfit(ron, &panda);
        assert!(message.contains(what), "{ron}\n{message}");
    }
    let six = common::robot("six_axis.urdf");
    let message = unfit(r#"{"mass_range": (links: Only(["base"]), min: 1.0)}"#, &six);
    assert!(message.contains("fixed to the base"), "{message}");
}

#[test]
fn contradictory_bounds_are_named() {
    let robot = common::robot("panda.ron");
    let space = LinkSpace::new(&robot, &[]);
    let all = [
        constraint(r#"{"mass_range": (links: Only(["link2"]), min: 3.0)}"#),
        constraint(r#"{"parameter_bounds": (bounds: {"m2": (0.0, 2.0)})}"#),
    ];
    let message = search_space(&robot, &space, &all).map(|_| ()).expect_err("contradiction").to_string();
    assert!(message.contains("m2 must be at least 3 and at most 2"), "{message}");
}

#[test]
fn meshes_that_are_none_are_refused_with_their_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let write = |name: &str, bytes: &[u8]| std::fs::write(folder.path().join(name), bytes).expect("writes");
    let mut lying = vec![0_u8; 84 + 50];
    lying[80..84].copy_from_slice(&1_000_000_u32.to_le_bytes());
    write("lying.stl", &lying);
    write("broken.stl", b"solid a\nfacet\n vertex 0 0 zero\nendsolid");
    let corner = |x: f64, y: f64| format!(" vertex {x} {y} 1\n");
    let flat = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0)].concat();
    write("flat.stl", format!("solid a\n{flat}endsolid a\n").as_bytes());
    let hull = |path: &str| format!(r#"{{"com_hull": (links: All, mesh: (path: "{path}"))}}"#);
    for (path, what) in [
        ("lying.stl", "says that it has 1000000 triangles, which take 50000084 bytes, but it has 134"),
        ("broken.stl", "broken.stl:3:2: a vertex is not three finite numbers"),
        ("flat.stl", "lie in one plane"),
        ("absent.stl", "absent.stl: cannot read the file"),
        ("../absent.stl", "leaves the scenario's repository or folder"),
        ("/etc/hostname", "absolute"),
    ] {
        let message = unloaded(&hull(path), folder.path()).to_string();
        assert!(message.contains(what) && message.starts_with(path), "{path}\n{message}");
    }
    let few = r#"{"com_hull": (links: All, mesh: (path: "meshes/box.stl", faces: 5))}"#;
    let error = text::from_ron::<Box<dyn Constraint>>(few).map(|_| ()).expect_err("too few");
    assert!(error.to_string().contains("`faces` is 5"), "{error}");
    let robot = common::robot("panda.ron");
    let unloaded: Box<dyn Constraint> = text::from_ron(&hull("meshes/box.stl")).expect("reads");
    let error = unloaded.forms(&robot, &LinkSpace::new(&robot, &[])).map(|_| ()).expect_err("not loaded");
    assert!(error.to_string().contains("was not loaded"));
}

#[test]
fn a_list_of_constraints_is_refused_with_file_and_place() {
    let folder = tempfile::tempdir().expect("a folder");
    let path = folder.path().join("rules.ron");
    std::fs::write(&path, "[\n  {\"mass_range\": (mim: 1.0)},\n]").expect("writes");
    let message = constraints::open(&path).map(|_| ()).expect_err("a typo").to_string();
    assert!(message.contains("rules.ron:2:") && message.contains("mim"), "{message}");
}
