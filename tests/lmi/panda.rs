//! The paper's two-step problem (Gaz et al. 2019, doi 10.1109/LRA.2019.2931248), written out by hand.

use std::path::Path;

use lacuna::constraints::{Barycentric, LinkSpace};
use lacuna::form::{Affine, Body, Form};
use lacuna::identify::BaseParameters;
use lacuna::retrieval::{Problem, Quadratic};
use lacuna::robot::Robot;
use lacuna::scenario::Published;
use nalgebra::{DMatrix, DVector};

/// Bounds of the centre of mass \[m\], links 1 to 7, axes x, y, z: Table VIII of the supplement.
pub const COM: [[(f64, f64); 3]; 7] = [
    [(-0.05, 0.05), (-0.05, 0.05), (-0.4, 0.05)],
    [(-0.05, 0.05), (-0.15, 0.05), (-0.05, 0.05)],
    [(-0.05, 0.15), (-0.05, 0.05), (-0.1, 0.05)],
    [(-0.15, 0.05), (-0.05, 0.15), (-0.05, 0.05)],
    [(-0.05, 0.05), (-0.05, 0.05), (-0.05, 0.05)],
    [(-0.05, 0.15), (-0.05, 0.05), (-0.05, 0.05)],
    [(-0.05, 0.05), (-0.05, 0.05), (0.04, 0.15)],
];
/// Lower bound of `c5z` in the authors' repository; the print says -0.05.
pub const C5Z_REPOSITORY: f64 = -0.35;
/// Coefficients whose relative deviation exceeds 30 %, which the paper leaves out.
const DROPPED: [&str; 2] = ["Jxy3", "Jxz6"];
const HEAVIEST: f64 = 10.0;
const TOTAL: (f64, f64) = (16.0, 20.0);

pub fn robot() -> Robot {
    Robot::open("robots/panda.ron").expect("the shipped robot reads")
}

/// Distance to the 41 kept coefficients.
pub fn objective(robot: &Robot) -> Quadratic {
    let base = BaseParameters::new(robot);
    let published = Published::open(Path::new("scenarios/panda_table3.ron")).expect("the table reads");
    let names: Vec<&str> = published.coefficients.iter().map(|c| c.0.as_str()).collect();
    let values = published.values(&base).expect("the table fits the robot");
    // The table's order is its own; `values` is in the order of `base`, whose pivots are stacked indices.
    let symbol = |i: usize| {
        let pivot = base.pivots[i];
        format!("{}{}", lacuna::robot::PARAMETER_NAMES[pivot % 10], pivot / 10 + 1)
    };
    let kept: Vec<usize> = (0..base.rank()).filter(|&i| !DROPPED.contains(&symbol(i).as_str())).collect();
    assert_eq!((kept.len(), names.len()), (41, 43));
    Quadratic {
        r: DMatrix::from_fn(kept.len(), base.map.ncols(), |i, j| base.map[(kept[i], j)]),
        d: DVector::from_iterator(kept.len(), kept.iter().map(|&i| values[i])),
        floor: 0.0,
        unit: "coefficients squared".to_string(),
    }
}

/// `lower <= c <= upper` on one axis, as two rows.
fn com_box(space: &LinkSpace, link: usize, axis: usize, (lower, upper): (f64, f64)) -> [Form; 2] {
    let (m, mc) = (space.mass(link), space.first_moment(link, axis));
    let name = format!("c{}{}", link + 1, ["x", "y", "z"][axis]);
    [
        Form::affine(format!("{name} >= {lower}"), "kg m", 1.0, mc.clone().plus(-lower, &m)),
        Form::affine(format!("{name} <= {upper}"), "kg m", 1.0, m.times(upper).plus(-1.0, &mc)),
    ]
}

/// `I <= 1` about the centre of mass, relaxed: `J_xx <= 1 + s_y + s_z` with `s = (lo + hi) mc - lo hi m`,
/// because `m c² <= s` in the box.
fn inertia_bound(space: &LinkSpace, link: usize, axis: usize, com: &[(f64, f64); 3]) -> Form {
    let mut row = Affine::constant(1.0).plus(-1.0, &space.inertia_at_origin(link, axis, axis));
    for other in (0..3).filter(|&other| other != axis) {
        let (lower, upper) = com[other];
        row =
            row.plus(lower + upper, &space.first_moment(link, other)).plus(-lower * upper, &space.mass(link));
    }
    Form::affine(format!("I{}{axis} <= 1", link + 1), "kg m^2", 1.0, row)
}

pub fn forms(space: &LinkSpace, com: &[[(f64, f64); 3]; 7]) -> Vec<Form> {
    let mut forms = Vec::new();
    let mut total = Affine::default();
    for (link, com) in com.iter().enumerate() {
        let body = Body::Psd { size: 4, lower: space.pseudo_inertia(link) };
        let mass = space.mass(link);
        total = total.plus(1.0, &mass);
        forms.push(Form::new(format!("link {} can exist", link + 1), "kg", 1.0, body));
        forms.push(Form::affine("m >= 0", "kg", 1.0, mass.clone()));
        forms.push(Form::affine("m <= 10", "kg", HEAVIEST, Affine::constant(HEAVIEST).plus(-1.0, &mass)));
        for axis in 0..3 {
            forms.extend(com_box(space, link, axis, com[axis]));
            forms.push(inertia_bound(space, link, axis, com));
        }
    }
    let (least, most) = TOTAL;
    forms.push(Form::affine("total >= 16", "kg", least, total.clone().plus(-1.0, &Affine::constant(least))));
    forms.push(Form::affine("total <= 20", "kg", most, Affine::constant(most).plus(-1.0, &total)));
    forms
}

/// The two-step problem with this lower bound of `c5z`.
pub fn problem(c5z: f64) -> Problem {
    let robot = robot();
    let space = LinkSpace::new(&robot, &[]);
    let mut com = COM;
    com[4][2].0 = c5z;
    let bounds = |name: &str| match name.as_bytes() {
        [b'm', ..] => (0.0, HEAVIEST),
        [b'c', link, axis] => com[usize::from(link - b'1')][usize::from(axis - b'x')],
        [b'I', _, a, b] if a == b => (0.0, 1.0),
        _ => (-1.0, 1.0),
    };
    let chart = Box::new(Barycentric::new(&space, bounds));
    Problem { objective: objective(&robot), forms: forms(&space, &com), chart, space: space.space, seed: 1 }
}
