//! One sample of every constraint: a set of parameters that passes and some that fail, with the margin that
//! plain geometry gives.

use lacuna::robot::Robot;

use super::common;
use super::{all_links, brick};

pub struct Case {
    pub ron: &'static str,
    pub robot: Robot,
    pub good: Vec<f64>,
    /// Unknowns and the smallest margin there.
    pub bad: Vec<(Vec<f64>, f64)>,
}

/// A case on the two-link robot whose links are all a brick with its centre at `good`, or at the `bad`.
fn located(ron: &'static str, good: [f64; 3], bad: &[([f64; 3], f64)]) -> Case {
    let robot = common::robot("two_link.ron");
    let at = |com: [f64; 3]| all_links(&robot, brick(2.5, com, [0.1, 0.2, 0.3]));
    let (good, bad) = (at(good), bad.iter().map(|(com, margin)| (at(*com), *margin)).collect());
    Case { ron, robot, good, bad }
}

/// The parameters of the robot's file, and friction coefficients of 0.5.
fn own(robot: &Robot) -> Vec<f64> {
    let links = robot.inertial_parameters().expect("has inertias");
    links.into_iter().chain([0.5, 0.5]).collect()
}

/// A case on the Panda with the published parameters; `bad` sets single unknowns.
fn panda(ron: &'static str, bad: &[(&[(usize, f64)], f64)]) -> Case {
    let robot = common::robot("panda.ron");
    let good = own(&robot);
    let changed = |changes: &[(usize, f64)]| {
        let mut z = good.clone();
        changes.iter().for_each(|&(i, x)| z[i] = x);
        z
    };
    let bad = bad.iter().map(|(changes, margin)| (changed(changes), *margin)).collect();
    Case { ron, robot, good, bad }
}

/// A case on the two-link robot whose links are cubes of these masses at the origin.
fn weights(ron: &'static str, good: [f64; 2], bad: &[([f64; 2], f64)]) -> Case {
    let robot = common::robot("two_link.ron");
    let of = |m: [f64; 2]| {
        let mut z = m.map(|m| brick(m, [0.0; 3], [0.1; 3]).0).concat();
        z.extend([0.5, 0.5]);
        z
    };
    let bad = bad.iter().map(|(masses, margin)| (of(*masses), *margin)).collect();
    Case { ron, robot, good: of(good), bad }
}

pub fn all() -> Vec<Case> {
    [bodies(), masses(), shapes(), relations(), scripts()].into_iter().flatten().collect()
}

fn bodies() -> Vec<Case> {
    vec![
        // A thin plate has Izz = Ixx + Iyy; making Izz larger by 0.01 misses by half of that.
        Case {
            bad: vec![(plate(0.01), -0.005)],
            ..located(r#"{"triangle_inequality": ()}"#, [0.1, 0.0, 0.3], &[])
        },
        Case {
            bad: vec![(plate(0.02), -0.01)],
            ..located(r#"{"pseudo_inertia": ()}"#, [0.1, 0.0, 0.3], &[])
        },
        // A brick about its own frame has the second moments m s²/12 and m as eigenvalues.
        located(r#"{"pseudo_inertia": (margin: 1e-3)}"#, [0.0; 3], &[]),
        located(r#"{"pseudo_inertia": (links: Only(["link2"]), margin: 1e-2)}"#, [0.0; 3], &[])
            .failing_thin(),
        Case {
            bad: vec![(plate(0.0), -0.4)],
            ..located(
                r#"{"density_realisable": (links: All, center: (0.0, 0.0, 0.0), semi_axes: (0.2, 0.2, 0.3))}"#,
                [0.0, 0.0, 0.05],
                &[],
            )
        },
    ]
}

impl Case {
    /// Its bad point is a brick 0.03 m thin: eigenvalue 2.5 (0.03)²/12 against 0.01.
    fn failing_thin(mut self) -> Self {
        self.good = all_links(&self.robot, brick(2.5, [0.0; 3], [0.3, 0.4, 0.5]));
        self.bad =
            vec![(all_links(&self.robot, brick(2.5, [0.0; 3], [0.03, 0.4, 0.5])), 2.5 * 9e-4 / 12.0 - 0.01)];
        self
    }
}

/// Plates of 1 kg in the xy plane with second moments of 0.028 kg m² along x and y, the first one with `extra`
/// moment of inertia about z. In an ellipsoid with half-axes of 0.2 m, tr(P Q) = 1 - 2 (0.028 / 0.04).
fn plate(extra: f64) -> Vec<f64> {
    let robot = common::robot("two_link.ron");
    let edge = 0.336_f64.sqrt();
    let mut z = all_links(&robot, brick(1.0, [0.0; 3], [edge, edge, 0.0]));
    z[9] += extra;
    z
}

fn masses() -> Vec<Case> {
    vec![
        weights(r#"{"positive_mass": ()}"#, [1.0, 1e-5], &[([1.0, 0.0], -1e-6), ([-2.0, 1.0], -2.000001)]),
        weights(
            r#"{"positive_mass": (links: Only(["2"]), at_least: 0.1)}"#,
            [0.0, 0.2],
            &[([1.0, 0.05], -0.05)],
        ),
        weights(
            r#"{"mass_range": (min: 1.0, max: 5.0)}"#,
            [1.0, 5.0],
            &[([0.5, 2.0], -0.5), ([2.0, 9.0], -4.0)],
        ),
        weights(r#"{"mass_range": (links: Only(["link1"]), max: 5.0)}"#, [-1.0, 50.0], &[([5.5, 2.0], -0.5)]),
        weights(
            r#"{"total_mass": (min: 16.0, max: 20.0)}"#,
            [8.0, 9.0],
            &[([8.0, 7.5], -0.5), ([1.0, 20.0], -1.0)],
        ),
        weights(r#"{"total_mass": (links: Only(["link2"]), min: 3.0)}"#, [0.0, 4.0], &[([9.0, 2.0], -1.0)]),
        weights(
            r#"{"mass_ratio": (link: "link1", to: "link2", min: 2.0, max: 3.0)}"#,
            [5.0, 2.0],
            &[([3.0, 2.0], -0.5), ([8.0, 2.0], -1.0)],
        ),
        weights(
            r#"{"mass_order": (heaviest_first: ["link1", "link2"], gap: 0.5)}"#,
            [3.0, 2.0],
            &[([3.0, 2.75], -0.25)],
        ),
    ]
}

fn shapes() -> Vec<Case> {
    vec![
        located(
            r#"{"com_box": (links: All, lower: (-0.1, -0.2, 0.0), upper: (0.1, 0.2, 0.4))}"#,
            [0.05, 0.1, 0.1],
            &[([0.13, 0.0, 0.1], -0.03), ([0.0, -0.25, 0.1], -0.05), ([0.0, 0.0, -0.02], -0.02)],
        ),
        located(
            r#"{"com_sphere": (links: Only(["link1", "link2"]), center: (0.1, 0.0, 0.0), radius: 0.05)}"#,
            [0.12, 0.03, 0.0],
            &[([0.1, 0.03, 0.04 + 0.03], 0.05 - 0.0058_f64.sqrt()), ([0.2, 0.0, 0.0], -0.05)],
        ),
        located(
            r#"{"com_cylinder": (links: All, center: (0.0, -0.75, 0.0), axis: (0.0, 2.0, 0.0), radius: 0.15, height: 1.5)}"#,
            [0.05, -1.2, 0.08],
            &[([0.12, -0.7, 0.16], -0.05), ([0.0, 0.1, 0.0], -0.1), ([0.0, -1.6, 0.0], -0.1)],
        ),
        located(
            r#"{"com_cylinder": (links: All, center: (0.0, 0.0, 0.1), axis: (1.0, 1.0, 0.0), radius: 0.05)}"#,
            [3.0, 3.0, 0.12],
            &[([1.0, 1.0, 0.2], -0.05)],
        ),
        located(
            r#"{"com_cone": (links: All, base: (0.0, 0.0, 0.1), axis: (0.0, 0.0, 1.0), radius: 0.1, top_radius: 0.0, height: 0.5)}"#,
            [0.0, 0.04, 0.3],
            &[([0.06, 0.08, 0.35], -0.05), ([0.0, 0.0, 0.05], -0.05)],
        ),
        located(
            r#"{"com_ellipsoid": (links: All, center: (0.0, 0.0, 0.1), semi_axes: (0.1, 0.2, 0.3), rpy: (0.0, 0.0, 1.5707963267948966))}"#,
            [0.15, 0.0, 0.1],
            // Turned by a right angle, the long half-axis of 0.2 m lies along x; the margin is in units of 0.1.
            &[([0.3, 0.0, 0.1], -0.05), ([0.0, 0.15, 0.1], -0.05), ([0.0, 0.0, 0.7], -0.1)],
        ),
        located(
            r#"{"com_hull": (links: All, mesh: (path: "meshes/box.stl"))}"#,
            [0.05, 0.02, 0.25],
            &[([0.15, 0.0, 0.1], -0.05), ([0.0, 0.0, 0.31], -0.01), ([0.0, -0.07, 0.1], -0.02)],
        ),
        located(
            r#"{"com_hull": (links: Only(["link1"]), mesh: (path: "meshes/box.stl", scale: 0.5, xyz: (0.1, 0.0, 0.0), rpy: (0.0, 1.5707963267948966, 0.0)))}"#,
            // The box's z, half as long, points along the link's x from 0.1 to 0.25, and its x along -z.
            [0.2, 0.02, 0.04],
            &[([0.28, 0.0, 0.0], -0.03), ([0.09, 0.0, 0.0], -0.01), ([0.2, 0.0, -0.06], -0.01)],
        ),
        located(
            r#"{"com_union": (links: All, shapes: [Box(lower: (0.0, -0.05, -0.05), upper: (0.4, 0.05, 0.05)),
                Box(lower: (0.3, -0.05, -0.05), upper: (0.4, 0.05, 0.35)), Sphere(center: (0.35, 0.0, 0.5), radius: 0.1)])}"#,
            [0.35, 0.0, 0.2],
            &[([0.2, 0.0, 0.15], -0.1), ([0.1, 0.0, 0.25], -0.2), ([0.35, 0.3, 0.5], -0.2)],
        ),
        located(
            r#"{"com_union": (links: Only(["link2"]), shapes: [Hull(mesh: (path: "meshes/box.stl")),
                Cylinder(center: (0.0, 0.0, 0.5), axis: (0.0, 0.0, 1.0), radius: 0.01, height: 0.4)])}"#,
            [0.0, 0.005, 0.6],
            &[([0.0, 0.03, 0.35], -0.02)],
        ),
    ]
}

fn relations() -> Vec<Case> {
    let urdf = common::robot("six_axis.urdf");
    let fingers = ["left_finger", "right_finger"]
        .map(|name| 10 * urdf.links.iter().position(|l| l.name == name).expect("the robot has fingers"));
    let own = own(&urdf);
    let with = |i: usize, by: f64| {
        let mut z = own.clone();
        z[i] += by;
        z
    };
    vec![
        Case {
            ron: r#"{"mirrored_links": (links: ("left_finger", "right_finger"), along: Y)}"#,
            good: own.clone(),
            bad: vec![
                (with(fingers[0], 0.01), 1e-6 - 0.01),
                (with(fingers[1] + 2, 0.002), 1e-6 - 0.002),
                (with(fingers[1] + 5, 1e-4), 1e-6 - 1e-4),
            ],
            robot: urdf,
        },
        Case {
            ron: r#"{"equal_links": (links: ("link1", "2"), tolerance: 1e-3)}"#,
            ..weights("", [2.0, 2.0], &[([2.0, 2.5], 1e-3 - 0.5)])
        },
        Case {
            ron: r#"{"known_payload": (link: "link2", mass: 1.0, com: (0.0, 0.0, 0.0))}"#,
            ..weights("", [1.0, 3.0], &[([1.0, 0.5], -0.5)])
        },
        panda(
            r#"{"parameter_bounds": (bounds: {"m2": (0.0, 10.0), "c3z": (-0.1, 0.05), "I4xx": (0.0, 1.0),
                "I4yz": (-1.0, 1.0), "I5xx": (0.0, 0.04), "c5x": (-0.05, 0.05), "c5y": (-0.05, 0.05), "c5z": (-0.35, 0.05),
                "I5xy": (-0.005, inf), "Jzz1": (0.0, 2.0), "mx6": (-inf, 0.2)})}"#,
            &[(&[(10, -0.5)], -0.5), (&[(9, 2.5)], -0.5), (&[(51, 0.3)], -0.1)],
        ),
        Case {
            ron: r#"{"parameter_bounds": (bounds: {"fv1": (0.0, inf), "fc1": (0.0, 3.0), "c1y": (-1.42, 0.08), "I1yy": (0.01, 1.0)})}"#,
            ..located("", [0.0, -0.5, 0.0], &[])
        },
    ]
}

/// The shipped scripts, through the `script` constraint.
fn scripts() -> Vec<Case> {
    vec![
        weights(
            r#"{"script": (path: "../../constraints/total_mass.rhai", with: {"max": 18})}"#,
            [8.0, 9.0],
            &[([8.0, 7.5], -0.5), ([1.0, 20.0], -3.0)],
        ),
        located(
            r#"{"script": (path: "../../constraints/cylinder.rhai", links: Only(["link1"]))}"#,
            [0.05, -1.2, 0.08],
            &[([0.12, -0.7, 0.16], -0.05), ([0.0, 0.1, 0.0], -0.1), ([0.0, -1.6, 0.0], -0.1)],
        ),
        // Radius 0.08 m in the cylinder; halfway along the cone 0.05 m.
        located(
            r#"{"script": (path: "../../constraints/cone_tip.rhai", links: Only(["link2"]))}"#,
            [-0.5, 0.03, 0.04],
            &[([-0.5, 0.06, 0.08], -0.02), ([-0.1, 0.06, 0.08], -0.05)],
        ),
        located(
            r#"{"script": (path: "../../constraints/cone_tip_convex.rhai", links: Only(["link2"]))}"#,
            [-0.5, 0.03, 0.04],
            &[([-0.5, 0.06, 0.08], -0.02), ([-0.1, 0.06, 0.08], -0.05)],
        ),
        located(
            r#"{"script": (path: "../../constraints/l_shape.rhai", links: Only(["link2"]))}"#,
            [-0.4, 0.01, 0.02],
            &[([-0.2, 0.0, 0.2], -0.15), ([0.0, 0.1, 0.4], -0.05)],
        ),
        located(
            r#"{"script": (path: "../../constraints/symmetric.rhai", links: Only(["link2"]))}"#,
            [0.2, 0.0, 0.2],
            &[([0.2, 0.01, 0.2], 0.001 - 0.01)],
        ),
        located(
            r#"{"script": (path: "../../constraints/heavy_near_joint.rhai", with: {"heavy": 2.0})}"#,
            [0.05, 0.0, 0.03],
            &[([0.3, 0.0, 0.0], -0.2), ([0.0, 0.6, 0.0], -0.5)],
        ),
    ]
}
