//! The supplement's two-link robot: exact data leave both masses open.

use lacuna::constraints::{Barycentric, LinkSpace};
use lacuna::form::{Affine, Body, Form};
use lacuna::identify::BaseParameters;
use lacuna::retrieval::{
    Interval, LmiEngine, Problem, Quadratic, Quantity, RetrievalEngine, Slack, audit, intervals,
};
use lacuna::robot::Robot;
use nalgebra::DVector;

use super::quiet;

/// Radii \[m\] of link 1, of link 2 and of its tip: Table VI of the supplement.
const RADII: [f64; 3] = [0.15, 0.08, 0.02];
/// Length \[m\] of the truncated cone at the end of link 2.
const CONE: f64 = 0.2;
/// Bounds of Table VII; centres of mass without bounds get the radius of the link.
const HEAVIEST: [f64; 2] = [10.0, 5.0];
const COM: [[(f64, f64); 3]; 2] =
    [[(-0.15, 0.15), (-1.42, 0.08), (-0.15, 0.15)], [(-0.8, 0.0), (-0.08, 0.08), (-0.08, 0.08)]];

fn at_least(label: &str, row: Affine) -> Form {
    Form::affine(label, "kg m", 1.0, row)
}

fn link_forms(space: &LinkSpace, link: usize) -> Vec<Form> {
    let m = space.mass(link);
    let heaviest = Affine::constant(HEAVIEST[link]);
    let body = Body::Psd { size: 4, lower: space.pseudo_inertia(link) };
    let mut forms = vec![
        Form::new("exists", "kg", 1.0, body),
        at_least("m >= 0", m.clone()),
        at_least("m <= heaviest", heaviest.plus(-1.0, &m)),
    ];
    let com = COM[link];
    for axis in 0..3 {
        let (mc, (lower, upper)) = (space.first_moment(link, axis), com[axis]);
        forms.push(at_least("c >= lower", mc.clone().plus(-lower, &m)));
        forms.push(at_least("c <= upper", m.clone().times(upper).plus(-1.0, &mc)));
        let mut inertia = Affine::constant(1.0).plus(-1.0, &space.inertia_at_origin(link, axis, axis));
        for other in (0..3).filter(|&other| other != axis) {
            let (lower, upper) = com[other];
            inertia = inertia.plus(lower + upper, &space.first_moment(link, other)).plus(-lower * upper, &m);
        }
        forms.push(at_least("I <= 1", inertia));
    }
    forms
}

fn problem() -> (Problem, LinkSpace, Vec<f64>) {
    let robot = Robot::open("robots/two_link.ron").expect("the shipped robot reads");
    let space = LinkSpace::new(&robot, &[]);
    let base = BaseParameters::new(&robot);
    let truth = robot.inertial_parameters().expect("the file has inertias");
    let mut forms: Vec<Form> = (0..2).flat_map(|link| link_forms(&space, link)).collect();
    let round = |link: usize, axes: [usize; 2], bound: Affine| {
        let rows = axes.iter().map(|&axis| space.first_moment(link, axis)).collect();
        Form::new("within its radius", "kg m", 1.0, Body::Norm { rows, bound })
    };
    let (m1, m2) = (space.mass(0), space.mass(1));
    let slope = (RADII[2] - RADII[1]) / CONE;
    forms.push(round(0, [0, 2], m1.times(RADII[0])));
    forms.push(round(1, [1, 2], m2.clone().times(RADII[1])));
    // The radius r2 + (r3 - r2)(0.2 + c2x) / 0.2 beyond c2x = -0.2.
    forms.push(round(1, [1, 2], m2.times(RADII[2]).plus(slope, &space.first_moment(1, 0))));
    let d = DVector::from_vec(base.coefficients(&truth));
    let objective = Quadratic { r: base.map, d, floor: 0.0, unit: String::new() };
    let bounds = |name: &str| match name.as_bytes() {
        [b'm', link] => (0.0, HEAVIEST[usize::from(link - b'1')]),
        [b'c', link, axis] => COM[usize::from(link - b'1')][usize::from(axis - b'x')],
        [b'I', _, a, b] if a == b => (0.0, 1.0),
        _ => (-1.0, 1.0),
    };
    let chart = Box::new(Barycentric::new(&space, bounds));
    (Problem { space: space.space.clone(), objective, forms, chart, seed: 1 }, space, truth)
}

#[test]
fn exact_data_leave_the_masses_open() {
    let (problem, space, truth) = problem();
    assert!(audit(&problem, &truth).feasible && problem.objective.value(&truth) < 1e-25);
    let found = LmiEngine::default().retrieve(&problem, &quiet).expect("it solves");
    let audit = audit(&problem, &found.z);
    assert!(audit.feasible && audit.objective < 1e-12, "{} {}", audit.objective, audit.violation);
    assert!(found.lower_bound.is_some_and(|b| (0.0..=audit.objective).contains(&b)));

    let quantities = space.quantities();
    let ranges =
        intervals(&problem, Slack::default().level(audit.objective), &quantities).expect("it solves");
    let range = |name: &str| -> (f64, f64) {
        let r: &Interval = ranges.iter().find(|r| r.parameter == name).expect("it is asked for");
        (r.low.expect("bounded"), r.high.expect("bounded"))
    };
    let near = |(low, high): (f64, f64), (a, b): (f64, f64), by: f64| {
        assert!((low - a).abs() < by && (high - b).abs() < by, "[{low}, {high}] is not [{a}, {b}]");
    };
    near(range("m1"), (0.0, 10.0), 1e-6);
    near(range("m2"), (2.9302, 5.0), 1e-4);
    // The truth lies in every interval, and what the data determine has no width.
    for (quantity, r) in quantities.iter().zip(&ranges) {
        let value = quantity.numerator.at(&truth)
            / quantity.denominator.as_ref().map_or(1.0, |(denominator, _)| denominator.at(&truth));
        let inside = r.low.is_some_and(|l| l <= value + 1e-6) && r.high.is_some_and(|h| h >= value - 1e-6);
        assert!(inside, "{} = {value} is not in {r:?}", r.parameter);
    }
    near(range("Jxy2"), (0.0, 0.0), 1e-5);
}

#[test]
fn a_ratio_reaches_exactly_as_far_as_its_bisection() {
    // Centre of mass of link 2 by bisection on a sign: max of mc - v m changes sign at the largest c = v.
    let (problem, space, truth) = problem();
    let level = Slack::default().level(problem.objective.value(&truth));
    let (m, mc) = (space.mass(1), space.first_moment(1, 0));
    let ask = |numerator: Affine, denominator| {
        let quantity = Quantity { name: "x".to_string(), unit: String::new(), numerator, denominator };
        intervals(&problem, level, &[quantity]).expect("it solves").remove(0).high.expect("bounded")
    };
    let exact = ask(mc.clone(), Some((m.clone(), 1e-3)));
    let (mut low, mut high) = (-0.8, 0.0);
    for _ in 0..25 {
        let middle = 0.5 * (low + high);
        if ask(mc.clone().plus(-middle, &m), None) > 0.0 { low = middle } else { high = middle }
    }
    assert!((exact - low).abs() < 1e-5, "{exact} {low}");
}
