//! Two links of known parameters whose centre of mass must lie in an L: truly non-convex, optimum 0.

use std::sync::Arc;

use lacuna::constraints::{Barycentric, LinkSpace};
use lacuna::form::{Affine, Body, Form, General};
use lacuna::identify::BaseParameters;
use lacuna::retrieval::{Problem, Quadratic};
use lacuna::robot::{InertialParameters, Robot};
use nalgebra::{DMatrix, DVector, Matrix3, Vector3};

/// The two bars of the L in x and y [m]: lower and upper corner.
const BARS: [[[f64; 2]; 2]; 2] = [[[-0.4, -0.02], [0.0, 0.02]], [[-0.4, -0.02], [-0.36, 0.3]]];
/// The truth of both links: mass [kg], centre of mass [m], inertia [kg m²] (a box about its middle).
const TRUTH: [(f64, [f64; 3], [f64; 3]); 2] =
    [(5.0, [-0.3, 0.01, 0.005], [0.02, 0.15, 0.14]), (3.0, [-0.37, 0.12, 0.01], [0.05, 0.04, 0.08])];

/// The centre of mass of a link lies in one of the bars.
#[derive(Debug)]
pub struct InL {
    link: usize,
}

impl InL {
    /// Sides of a bar as conditions on (m, mx, my): the least counts.
    fn sides(bar: [[f64; 2]; 2]) -> [[f64; 3]; 4] {
        let [[x0, y0], [x1, y1]] = bar;
        [[-x0, 1.0, 0.0], [x1, -1.0, 0.0], [-y0, 0.0, 1.0], [y1, 0.0, -1.0]]
    }
}

impl General for InL {
    fn support(&self) -> Vec<usize> {
        (10 * self.link..10 * self.link + 3).collect()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.gradient(z).0
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let at = |side: &[f64; 3]| side.iter().zip(&z[10 * self.link..]).map(|(f, z)| f * z).sum::<f64>();
        let least = |bar| {
            Self::sides(bar)
                .into_iter()
                .map(|s| (at(&s), s))
                .min_by(|a, b| a.0.total_cmp(&b.0))
                .expect("four sides")
        };
        let best = BARS.into_iter().map(least).max_by(|a, b| a.0.total_cmp(&b.0)).expect("two bars");
        (best.0, best.1.to_vec())
    }
}

/// Stacked unknowns of the truth.
pub fn truth() -> Vec<f64> {
    let link = |(mass, com, [x, y, z]): (f64, [f64; 3], [f64; 3])| {
        InertialParameters::from_barycentric(
            mass,
            Vector3::from(com),
            Matrix3::from_diagonal(&Vector3::new(x, y, z)),
        )
        .0
    };
    TRUTH.into_iter().flat_map(link).collect()
}

/// Exact coefficients of the truth; with or without the L for the second link.
pub fn two_link(seed: u64, l_shaped: bool) -> Problem {
    let robot = Robot::open("robots/two_link.ron").expect("the shipped robot reads");
    let space = LinkSpace::new(&robot, &[]);
    let base = BaseParameters::new(&robot);
    let mut forms = Vec::new();
    for link in 0..2 {
        let mass = space.mass(link);
        forms.push(Form::affine(
            format!("mass {link}"),
            "kg",
            10.0,
            Affine::constant(10.0).plus(-1.0, &mass),
        ));
        let lower = space.pseudo_inertia(link);
        forms.push(Form::new(format!("body {link}"), "mixed", 1.0, Body::Psd { size: 4, lower }));
    }
    if l_shaped {
        let function = Arc::new(InL { link: 1 });
        let why = "one of two bars".into();
        forms.push(Form::new("L", "kg m", 0.1, Body::General { function, why, implied: vec![] }));
    }
    let bounds = |name: &str| match name.as_bytes() {
        [b'm', ..] => (0.0, 10.0),
        [b'c', ..] => (-1.0, 1.0),
        [.., a, b] if a == b => (0.0, 1.0),
        _ => (-1.0, 1.0),
    };
    let d = DVector::from_vec(base.coefficients(&truth()));
    let r: DMatrix<f64> = base.map.clone();
    let objective = Quadratic { r, d, floor: 0.0, unit: "mixed".into() };
    Problem { chart: Box::new(Barycentric::new(&space, bounds)), space: space.space, objective, forms, seed }
}
