//! A small problem with every kind of form, for tests.

use std::sync::Arc;

use nalgebra::{DMatrix, DVector};

use crate::form::{Affine, Body, Form, General};
use crate::space::{Parameter, Space};
use crate::{Identity, Problem, Quadratic};

/// `x y <= limit`.
#[derive(Debug)]
struct Product(f64);

impl General for Product {
    fn support(&self) -> Vec<usize> {
        vec![0, 1]
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.0 - z[0] * z[1]
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        (self.margin(z), vec![-z[1], -z[0]])
    }
}

/// The point nearest to (2, 1, -1) within the unit disc of x and y, with x + y <= 1.2 and z >= x².
pub(crate) fn disc() -> Problem {
    let mut space = Space::default();
    let member = |name: &str| Parameter::free(name, "m").within(-2.0, 2.0);
    space.push_group("plane", [member("x"), member("y")]);
    space.push_group("height", [member("z")]);
    let v = Affine::variable;
    let one = Affine::constant(1.0);
    let product =
        Body::General { function: Arc::new(Product(0.25)), why: "a product".into(), implied: vec![] };
    let forms = vec![
        Form::new("disc", "m", 1.0, Body::Norm { rows: vec![v(0), v(1)], bound: one.clone() }),
        Form::affine("line", "m", 1.2, v(0).plus(1.0, &v(1)).times(-1.0).plus(1.2, &one)),
        Form::new("parabola", "m", 1.0, Body::Psd { size: 2, lower: vec![one, v(0), v(2)] }),
        Form::new("product", "m^2", 0.25, product),
    ];
    let objective = Quadratic {
        r: DMatrix::identity(3, 3),
        d: DVector::from_vec(vec![2.0, 1.0, -1.0]),
        floor: 0.0,
        unit: "m^2".into(),
    };
    Problem { chart: Box::new(Identity { space: space.clone() }), space, objective, forms, seed: 1 }
}
