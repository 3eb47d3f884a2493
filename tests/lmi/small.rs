//! Random small problems whose optimum is known, because it was chosen first: multipliers and slacks that
//! complement each other make the Karush-Kuhn-Tucker conditions hold at a point of our choice.

use lacuna::form::{Affine, Body, Form};
use lacuna::retrieval::{Identity, Problem, Quadratic};
use lacuna::space::{Parameter, Space};
use nalgebra::{DMatrix, DVector};
use rand::{RngExt, SeedableRng};
use rand_xoshiro::Xoshiro256PlusPlus;

const UNKNOWNS: usize = 4;
const BOUND: f64 = 10.0;

pub struct Known {
    /// Where the optimum is.
    pub z: Vec<f64>,
    pub problem: Problem,
    pub optimum: f64,
}

pub struct Dice(Xoshiro256PlusPlus);

impl Dice {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    pub fn roll(&mut self) -> f64 {
        self.0.random_range(-1.0..1.0)
    }

    /// A random row with this value at `z`.
    fn row(&mut self, z: &[f64], value: f64) -> Affine {
        let terms: Vec<(usize, f64)> = (0..UNKNOWNS).map(|i| (i, self.roll())).collect();
        let linear = Affine { terms, constant: 0.0 };
        let at = linear.at(z);
        linear.plus(1.0, &Affine::constant(value - at))
    }
}

fn add(g: &mut DVector<f64>, y: f64, row: &Affine) {
    row.terms.iter().for_each(|&(i, f)| g[i] += y * f);
}

/// A problem with this many residuals (any number) and `n = 4` unknowns.
pub fn known(seed: u64, residuals: usize) -> Known {
    let mut dice = Dice::new(seed);
    let z: Vec<f64> = (0..UNKNOWNS).map(|_| dice.roll()).collect();
    let mut g = DVector::zeros(UNKNOWNS);
    let mut forms = boxes();
    // One active row, one inactive.
    let (active, idle) = (dice.row(&z, 0.0), dice.row(&z, 0.5));
    add(&mut g, 0.7 + 0.3 * dice.roll(), &active);
    forms.push(Form::affine("active", "", 1.0, active));
    forms.push(Form::affine("idle", "", 1.0, idle));
    forms.push(touching_norm(&mut dice, &z, &mut g));
    forms.push(touching_matrix(&mut dice, &z, &mut g, 2 + (seed % 4) as usize));
    let r = DMatrix::from_fn(residuals, UNKNOWNS, |_, _| dice.roll());
    // Residual w at the optimum: 2 rᵀw = g, plus a part that r does not reach.
    let svd = r.transpose().svd(true, true);
    let pull = svd.solve(&(0.5 * &g), 1e-12).expect("an SVD with vectors");
    let any = DVector::from_fn(residuals, |_, _| 0.1 * dice.roll());
    let apart = &any - svd.solve(&(r.transpose() * &any), 1e-12).expect("an SVD with vectors");
    let w = pull + apart;
    // With fewer residuals than unknowns g must lie in the span of rᵀ: keep what fits, as a linear bound.
    let left = 2.0 * r.transpose() * &w - &g;
    if left.norm() > 1e-9 {
        let wall = Affine { terms: left.iter().copied().enumerate().collect(), constant: 0.0 };
        let at = wall.at(&z);
        forms.push(Form::affine("wall", "", 1.0, wall.plus(1.0, &Affine::constant(-at))));
    }
    let d = &r * DVector::from_column_slice(&z) - &w;
    let objective = Quadratic { r, d, floor: 0.25, unit: String::new() };
    let space = space();
    let chart = Box::new(Identity { space: space.clone() });
    Known { problem: Problem { space, objective, forms, chart, seed }, optimum: w.norm_squared() + 0.25, z }
}

pub fn space() -> Space {
    let mut space = Space::default();
    space
        .push_group("all", (0..UNKNOWNS).map(|i| Parameter::free(format!("z{i}"), "").within(-BOUND, BOUND)));
    space
}

fn boxes() -> Vec<Form> {
    let wall = |i: usize, sign: f64| {
        let row = Affine::constant(BOUND).plus(sign, &Affine::variable(i));
        Form::affine(format!("z{i} {sign}"), "", BOUND, row)
    };
    (0..UNKNOWNS).flat_map(|i| [wall(i, 1.0), wall(i, -1.0)]).collect()
}

fn touching_norm(dice: &mut Dice, z: &[f64], g: &mut DVector<f64>) -> Form {
    let values = [dice.roll(), dice.roll(), dice.roll()];
    let length = values.iter().map(|v| v * v).sum::<f64>().sqrt();
    let rows: Vec<Affine> = values.iter().map(|&v| dice.row(z, v)).collect();
    let bound = dice.row(z, length);
    let y = 0.4;
    add(g, y, &bound);
    rows.iter().zip(values).for_each(|(row, v)| add(g, -y * v / length, row));
    Form::new("norm", "", 1.0, Body::Norm { rows, bound })
}

/// A matrix that is singular at `z` along `v`, pressed with `y v vᵀ`.
fn touching_matrix(dice: &mut Dice, z: &[f64], g: &mut DVector<f64>, size: usize) -> Form {
    let v = DVector::from_fn(size, |_, _| dice.roll()).normalize();
    let half = DMatrix::from_fn(size, size, |_, _| dice.roll());
    let keep = DMatrix::identity(size, size) - &v * v.transpose();
    let at = &keep * &half * half.transpose() * &keep;
    let mut lower = Vec::new();
    for (i, j) in (0..size).flat_map(|i| (0..=i).map(move |j| (i, j))) {
        let row = dice.row(z, at[(i, j)]);
        add(g, 0.6 * v[i] * v[j] * if i == j { 1.0 } else { 2.0 }, &row);
        lower.push(row);
    }
    Form::new("matrix", "", 1.0, Body::Psd { size, lower })
}
