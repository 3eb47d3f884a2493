//! The two-link robot of the supplement of Gaz et al. 2019, with its scripted shapes, and a scripted shape that is
//! not convex: what a study identifies, what engines retrieve, and what joints then carry.

use super::common;

use std::ops::ControlFlow;
use std::path::Path;

use common::robot;
use lacuna::constraints::{self, LinkSpace, forms, search_space};
use lacuna::excitation::Motion;
use lacuna::identify::BaseParameters;
use lacuna::kernels::{Chain, State, Workspace, inverse_dynamics, wrench};
use lacuna::retrieval::penalty::PenaltyEngine;
use lacuna::retrieval::{Audit, LmiEngine, Problem, Quadratic, RetrievalEngine, audit};
use lacuna::robot::{InertialParameters, Robot};
use lacuna::scenario::{Commanded, Logs, Scenario};
use lacuna::study::{self, Options};
use nalgebra::{DVector, Matrix3};

/// Coefficients of the true parameters (supplement, section VI-C), sorted. The sixth is printed with 0.8 m2 in
/// place of 0.64 m2 = l2^2 m2, which no torque can show.
const PUBLISHED: [f64; 8] = [-1.85, -1.816, 0.0, 0.0, 0.0, 0.0, 1.86, 2.1];

/// Retrieved parameters of Table VII: mass, centre of mass, inertia about it (xx, xy, xz, yy, yz, zz).
const TABLE_VII: [(f64, [f64; 3], [f64; 6]); 2] = [
    (4.5788, [-0.016124, -0.74408, -3.8e-4], [0.61296, 0.071738, -0.0099797, 0.022982, 0.031154, 0.6172]),
    (3.7828, [-0.24487, 6.16e-6, -3.66e-3], [0.019819, -4.525e-6, -0.0077412, 0.35386, -5.9342e-5, 0.34412]),
];

fn scenario(name: &str) -> Scenario {
    Scenario::open(&Path::new("scenarios").join(name)).expect("shipped scenarios read")
}

fn truth() -> Vec<f64> {
    robot("two_link.ron").inertial_parameters().expect("has inertias")
}

fn published() -> Vec<f64> {
    let link = |(mass, com, [xx, xy, xz, yy, yz, zz]): (f64, [f64; 3], [f64; 6])| {
        let inertia = Matrix3::new(xx, xy, xz, xy, yy, yz, xz, yz, zz);
        InertialParameters::from_barycentric(mass, com.into(), inertia).0
    };
    TABLE_VII.into_iter().flat_map(link).collect()
}

/// The retrieval of a shipped scenario, from the exact coefficients of the true parameters.
fn problem(name: &str, seed: u64) -> Problem {
    posed(scenario(name), seed)
}

fn posed(mut scenario: Scenario, seed: u64) -> Problem {
    let robot = robot("two_link.ron");
    let folder = Path::new("scenarios");
    scenario.constraints.iter_mut().for_each(|c| c.load(folder).expect("its files load"));
    for preset in &scenario.presets {
        scenario.constraints.extend(constraints::open(&folder.join(preset)).expect("presets read"));
    }
    let space = LinkSpace::new(&robot, &[]);
    let base = BaseParameters::new(&robot);
    let d = DVector::from_vec(base.coefficients(&truth()));
    let objective = Quadratic { r: base.map.clone(), d, floor: 0.0, unit: "squared coefficients".into() };
    let search = search_space(&robot, &space, &scenario.constraints).expect("bounds agree");
    assert!(search.assumed.is_empty(), "{:?}", search.assumed);
    let forms = forms(&robot, &space, &scenario.constraints).expect("they fit the robot");
    Problem { space: space.space.clone(), objective, forms, chart: Box::new(search.chart), seed }
}

fn solve(engine: &dyn RetrievalEngine, problem: &Problem) -> (Vec<f64>, Audit) {
    let found = engine.retrieve(problem, &|_| ControlFlow::Continue(())).expect("the engine runs");
    let audit = audit(problem, &found.z);
    (found.z, audit)
}

/// One run of the default engine from the random start that belongs to `seed`.
fn searched(name: &str, seed: u64) -> (Vec<f64>, Audit) {
    one_run(&problem(name, seed))
}

fn one_run(problem: &Problem) -> (Vec<f64>, Audit) {
    solve(&PenaltyEngine { runs: 1, ..PenaltyEngine::default() }, problem)
}

#[test]
fn a_study_identifies_the_published_coefficients_and_retrieves_feasible_links() {
    let outcome = study::run(Path::new("scenarios/two_link.ron"), Options::new(&mut |_| {}));
    let report = outcome.expect("runs").report;
    let identified = report.identification.expect("identifies");
    assert_eq!(identified.rank, 8);
    let mut values: Vec<f64> = identified.coefficients.iter().filter_map(|c| c.value).collect();
    values.sort_by(f64::total_cmp);
    println!("condition number {:.2}, {values:?}", identified.condition_number);
    for (value, published) in values.iter().zip(PUBLISHED) {
        assert!((value - published).abs() < 1e-6, "{values:?}");
    }
    let published = &report.beside[0];
    assert!(published.label == "table7" && published.feasible, "{}", published.label);
    assert!((published.objective - 3.7e-8).abs() < 0.1e-8, "{:e}", published.objective);
    let wrenches = report.comparison.expect("compares").wrenches;
    for (label, forces) in &wrenches {
        println!("{label}: {:.1} {:.1} N", forces["joint1"][0], forces["joint2"][0]);
    }
    let share = |joint: &str| wrenches["table7"][joint][0] / wrenches["given"][joint][0];
    assert!((share("joint1") - 0.76).abs() < 0.02 && (share("joint2") - 1.26).abs() < 0.03, "{wrenches:?}");
    let retrieved = report.retrievals.expect("retrieves");
    assert_eq!(retrieved.len(), 2);
    for r in &retrieved {
        println!("{}: {:e} violation {:?}", r.label, r.objective, r.violation);
        assert!(r.feasible && r.objective < 1e-9, "{}: {:e}", r.label, r.objective);
        inside(r.links[0].com.expect("a mass"), r.links[1].com.expect("a mass"));
    }
}

/// Both shapes of the supplement, retyped: r1 = 0.15, r2 = 0.08, r3 = 0.02, l2' = 0.2 m.
#[track_caller]
fn inside(first: [f64; 3], second: [f64; 3]) {
    const ROUNDING: f64 = 1e-9;
    assert!(first[0].hypot(first[2]) <= 0.15 + ROUNDING, "link 1: {first:?}");
    let x = second[0];
    let radius = if x < -0.2 { 0.08 } else { 0.08 + (0.02 - 0.08) * (0.2 + x) / 0.2 };
    assert!(second[1].hypot(second[2]) <= radius + ROUNDING, "link 2: {second:?}");
}

#[test]
fn true_and_published_parameters_are_feasible() {
    let problem = problem("two_link.ron", 0);
    let exact = audit(&problem, &truth());
    assert!(exact.violation <= 0.0 && exact.objective < 1e-24, "{exact:?}");
    // Four digits are printed: the coefficients agree to 1.3e-4, and the objective is 3.7e-8.
    let printed = audit(&problem, &published());
    assert!(printed.violation <= 0.0, "{printed:?}");
    assert!((printed.objective - 3.7e-8).abs() < 0.1e-8, "{:e}", printed.objective);
}

#[test]
fn the_truth_is_matched_from_every_start_within_the_shapes() {
    for seed in 0..10 {
        let (z, audit) = searched("two_link.ron", seed);
        assert!(
            audit.feasible && audit.objective < 1e-9,
            "{seed}: {:e} {}",
            audit.objective,
            audit.violation
        );
        let com = |link: usize| std::array::from_fn(|axis| z[10 * link + 1 + axis] / z[10 * link]);
        inside(com(0), com(1));
    }
}

/// Mean size of the forces in both joints \[N\], and all torques, along the scenario's own sinusoidal motion.
fn carried(parameters: &[f64]) -> ([f64; 2], Vec<f64>) {
    let robot: Robot = robot("two_link.ron");
    let Some(Logs::Simulated(simulated)) = scenario("two_link.ron").logs else { panic!("it simulates") };
    let Commanded::Sinusoidal(motion) = simulated.motion else { panic!("it is sinusoidal") };
    let chain = Chain::new(&robot);
    let mut workspace = Workspace::new(&chain, 0.0);
    let (mut sums, mut torques) = ([0.0; 2], Vec::new());
    let count = 310;
    for k in 0..count {
        let (mut q, mut dq, mut ddq, mut tau) = ([0.0; 2], [0.0; 2], [0.0; 2], [0.0; 2]);
        motion.at(0.05 * k as f64, &mut q, &mut dq, &mut ddq);
        inverse_dynamics(&chain, &mut workspace, State::new(&q, &dq, &ddq), parameters, &mut tau);
        torques.extend(tau);
        for (joint, sum) in sums.iter_mut().enumerate() {
            *sum += wrench(&workspace, joint).0.iter().map(|f| f * f).sum::<f64>().sqrt() / count as f64;
        }
    }
    (sums, torques)
}

fn farthest(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

#[test]
fn feasible_parameters_load_the_joints_like_the_true_ones() {
    let ([first, second], torque) = carried(&truth());
    // 11 kg and 3 kg hang on the joints; figure 10 of the supplement is about such sizes.
    assert!((first - 108.0).abs() < 1.0 && (second - 29.8).abs() < 0.6, "{first} {second}");
    let (published, its_torque) = carried(&published());
    println!("true {first:.1} {second:.1} N, published {published:.1?}");
    assert!((published[0] - 82.1).abs() < 1.0 && (published[1] - 37.4).abs() < 0.6, "{published:?}");
    assert!(farthest(&torque, &its_torque) < 2e-3, "the same torque: {:e}", farthest(&torque, &its_torque));
    let starts = (0..3).map(|seed| (format!("penalty from start {seed}"), searched("two_link.ron", seed).0));
    let lmi = ("lmi".to_string(), solve(&LmiEngine::default(), &problem("two_link.ron", 0)).0);
    for (who, z) in starts.chain([lmi]) {
        let (found, its_torque) = carried(&z);
        println!("retrieved by {who}: {found:.1?} N, masses {:.2} {:.2} kg", z[0], z[10]);
        assert!(farthest(&torque, &its_torque) < 1e-3);
        // m1 is anywhere in [0, 10], m2 in [2.93, 5]: so are the forces, with a tenth for acceleration.
        assert!((2.93 * 9.81 * 0.9..15.0 * 9.81 * 1.1).contains(&found[0]), "{found:?}");
        assert!((2.93 * 9.81 * 0.9..5.0 * 9.81 * 1.1).contains(&found[1]), "{found:?}");
    }
}

#[test]
fn infeasible_parameters_load_the_joints_without_limit() {
    let robot = robot("two_link.ron");
    let base = BaseParameters::new(&robot);
    let ([first, _], torque) = carried(&truth());
    // What the map from parameters to coefficients cannot see, out of all parameters alike.
    let all = DVector::from_element(20, 1.0);
    let gram = &base.map * base.map.transpose();
    let seen = gram.cholesky().expect("full rank").solve(&(&base.map * &all));
    let unseen = (all - base.map.transpose() * seen).normalize();
    let mut last = 0.0;
    for shift in [1e6, 1e8] {
        let moved: Vec<f64> = truth().iter().zip(unseen.iter()).map(|(p, n)| p + shift * n).collect();
        let ([force, _], its_torque) = carried(&moved);
        let ratio = force / first;
        println!(
            "shift {shift:e}: force ratio {ratio:.3e}, torque error {:.1e}",
            farthest(&torque, &its_torque)
        );
        assert!(ratio > 0.01 * shift / 10.0, "{ratio}");
        // Rounding in numbers as large as the shift is all that the torque shows.
        assert!(farthest(&torque, &its_torque) < 1e-13 * shift, "{:e}", farthest(&torque, &its_torque));
        assert!(last <= 0.0 || (ratio / last - 100.0).abs() < 0.01, "the ratio grows with the shift");
        last = ratio;
    }
}

#[test]
fn a_relaxation_leaves_the_l_and_the_search_does_not() {
    let study = problem("l_shape.ron", 0);
    let exact = audit(&study, &truth());
    assert!(exact.violation <= 0.0 && exact.objective < 1e-24, "the optimum is 0: {exact:?}");
    let (z, relaxed) = solve(&LmiEngine::default(), &study);
    println!("lmi: {:e} violation {:.3}, com {:.3?}", relaxed.objective, relaxed.violation, &z[10..14]);
    assert!(relaxed.objective < 1e-9 && relaxed.violation > 0.01, "{} {:?}", relaxed.violation, &z[10..14]);
    // It keeps to the box around the L: only the choice between the arms is broken.
    let broken: Vec<&str> =
        relaxed.constraints.iter().filter(|c| c.margin < -1e-9).map(|c| c.label.as_str()).collect();
    assert_eq!(broken, ["link2: in one arm of the L"]);
    let good = (0..10).filter(|&seed| {
        let (_, audit) = searched("l_shape.ron", seed);
        println!("{seed}: {:.2e} {:.0e}", audit.objective, audit.violation);
        audit.violation <= 0.0 && audit.objective < 1e-6
    });
    assert!(good.count() >= 9);
}

#[test]
fn an_arm_that_looks_good_and_is_not_is_left_again() {
    // With the beam 2 cm thinner no centre of mass in it has the true coefficients: it is a trap for searches.
    let text = std::fs::read_to_string("scenarios/l_shape.ron").expect("it is there");
    let (thick, thin) = ("[-0.5, -0.05, 0.05], \"second_high\"", "[-0.5, -0.05, 0.07], \"second_high\"");
    assert_eq!(text.matches(thick).count(), 1);
    let good = (0..10).filter(|&seed| {
        let scenario = lacuna::text::from_ron(&text.replace(thick, thin)).expect("reads");
        let (z, audit) = one_run(&posed(scenario, seed));
        println!("{seed}: {:.2e} {:.0e} com {:.3?}", audit.objective, audit.violation, &z[11..14]);
        audit.violation <= 0.0 && audit.objective < 1e-6
    });
    assert!(good.count() >= 9);
}
