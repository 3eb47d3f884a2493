//! Margins in a constraint's own unit, where its form has another one.
//!
//! A centre of mass is first moment over mass, inertia about it is a Schur complement: neither is linear in
//! the unknowns, but both are what a user wants to read. Where a link has no mass to speak of they mean
//! nothing, and the form's own margin is reported.

use std::sync::Arc;

use nalgebra::{Matrix3, SymmetricEigen, Vector3};

use crate::form::{Affine, Body, Form, General};

/// Mass \[kg\] below which a link has no centre of mass, as in [`crate::robot::InertialParameters`].
pub(super) const LIGHTEST: f64 = 1e-6;

/// The form with margins reported by `measure` where `mass` is at least [`LIGHTEST`]; there both must have
/// the same sign.
pub(super) fn measured(form: Form, mass: Affine, measure: Arc<dyn General>) -> Form {
    let body = Form { measure: None, ..form.clone() };
    let others = measure.support().into_iter().chain(mass.terms.iter().map(|t| t.0));
    let support = union(body.support().into_iter().chain(others));
    Form { measure: Some(Arc::new(WhereMassive { mass, body, measure, support })), ..form }
}

/// A form that is homogeneous in mass and first moment, reported per unit of mass.
pub(super) fn per_mass(form: Form, mass: Affine) -> Form {
    let body = Form { measure: None, ..form.clone() };
    let support = union(body.support().into_iter().chain(mass.terms.iter().map(|t| t.0)));
    measured(form, mass.clone(), Arc::new(PerMass { body, mass, support }))
}

/// A 4 x 4 pseudo-inertia (lower triangle by rows) is positive semidefinite; reported is the smallest
/// eigenvalue of the second moment about the centre of mass, which is `tr(I)/2 - lambda_max(I)` there
/// (Gaz et al. 2019, eq. 16 and 32).
pub(super) fn is_body(label: String, lower: Vec<Affine>) -> Form {
    let form = Form::new(label, "kg m^2", 1.0, Body::Psd { size: 4, lower: lower.clone() });
    let mass = lower[9].clone();
    let support = form.support();
    measured(form, mass, Arc::new(LeastSecondMoment { lower, support }))
}

fn union(indices: impl Iterator<Item = usize>) -> Vec<usize> {
    let mut all: Vec<usize> = indices.collect();
    all.sort_unstable();
    all.dedup();
    all
}

/// The slopes in `sum`, one per member of `support`.
fn dense(sum: &[(usize, f64)], support: &[usize]) -> Vec<f64> {
    support.iter().map(|i| sum.iter().filter(|(k, _)| k == i).map(|(_, f)| f).sum()).collect()
}

#[derive(Debug)]
struct WhereMassive {
    mass: Affine,
    body: Form,
    measure: Arc<dyn General>,
    support: Vec<usize>,
}

impl General for WhereMassive {
    fn support(&self) -> Vec<usize> {
        self.support.clone()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        if self.mass.at(z) >= LIGHTEST { self.measure.margin(z) } else { self.body.margin(z) }
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let (margin, slopes) = if self.mass.at(z) >= LIGHTEST {
            let (margin, slopes) = self.measure.gradient(z);
            (margin, self.measure.support().into_iter().zip(slopes).collect())
        } else {
            self.body.gradient(z)
        };
        (margin, dense(&slopes, &self.support))
    }
}

#[derive(Debug)]
struct PerMass {
    body: Form,
    mass: Affine,
    support: Vec<usize>,
}

impl General for PerMass {
    fn support(&self) -> Vec<usize> {
        self.support.clone()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.body.margin(z) / self.mass.at(z)
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let (margin, terms) = self.body.gradient(z);
        let mass = self.mass.at(z);
        let ratio = margin / mass;
        let slope = Affine { terms, constant: 0.0 }.plus(-ratio, &self.mass).times(1.0 / mass);
        (ratio, dense(&slope.terms, &self.support))
    }
}

/// Smallest eigenvalue of the Schur complement `S - w wᵀ / m` of `[[S, w], [wᵀ, m]]`.
#[derive(Debug)]
struct LeastSecondMoment {
    lower: Vec<Affine>,
    support: Vec<usize>,
}

impl LeastSecondMoment {
    /// First moment, mass, second moment about the centre of mass.
    fn parts(&self, z: &[f64]) -> (Vector3<f64>, f64, Matrix3<f64>) {
        let at = |i: usize| self.lower[i].at(z);
        let w = Vector3::new(at(6), at(7), at(8));
        let m = at(9);
        let s = Matrix3::new(at(0), at(1), at(3), at(1), at(2), at(4), at(3), at(4), at(5));
        (w, m, s - w * w.transpose() / m)
    }
}

impl General for LeastSecondMoment {
    fn support(&self) -> Vec<usize> {
        self.support.clone()
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.parts(z).2.symmetric_eigenvalues().min()
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let (w, m, schur) = self.parts(z);
        let eigen = SymmetricEigen::new(schur);
        let least = eigen.eigenvalues.imin();
        let v = eigen.eigenvectors.column(least);
        // vᵀ(S - w wᵀ/m)v varies like uᵀ P u with u = (v, -v·w/m) held fixed.
        let u = [v[0], v[1], v[2], -v.dot(&w) / m];
        let mut sum = Affine::default();
        for i in 0..4 {
            for j in 0..=i {
                let weight = if i == j { u[i] * u[j] } else { 2.0 * u[i] * u[j] };
                sum = sum.plus(weight, &self.lower[i * (i + 1) / 2 + j]);
            }
        }
        (eigen.eigenvalues[least], dense(&sum.terms, &self.support))
    }
}

/// An element of the inertia tensor about the centre of mass against a bound: `sign (I_ab - bound)`.
#[derive(Debug, Clone, Copy)]
pub(super) struct InertiaBound {
    /// Index of the link's mass; its other parameters follow.
    pub mass: usize,
    /// Row and column of the element, 0 to 2, row not above column.
    pub element: (usize, usize),
    /// 1 for a lower bound, -1 for an upper bound.
    pub sign: f64,
    /// The bound [kg m²].
    pub bound: f64,
}

impl InertiaBound {
    fn tensor_index(&self) -> usize {
        const PLACE: [[usize; 3]; 3] = [[4, 5, 6], [5, 7, 8], [6, 8, 9]];
        self.mass + PLACE[self.element.0][self.element.1]
    }

    /// The two first moments whose product stands in the element, and the sign it has there.
    fn pairs(&self) -> [(usize, usize, f64); 2] {
        let (a, b) = self.element;
        let first = |axis: usize| self.mass + 1 + axis;
        if a == b {
            let (c, d) = ((a + 1) % 3, (a + 2) % 3);
            [(first(c), first(c), -1.0), (first(d), first(d), -1.0)]
        } else {
            [(first(a), first(b), 1.0), (first(a), first(b), 0.0)]
        }
    }
}

impl General for InertiaBound {
    fn support(&self) -> Vec<usize> {
        let pairs = self.pairs();
        let used = pairs.iter().filter(|p| p.2.abs() > 0.0).flat_map(|p| [p.0, p.1]);
        union(used.chain([self.mass, self.tensor_index()]))
    }

    fn margin(&self, z: &[f64]) -> f64 {
        let mass = z[self.mass].max(LIGHTEST);
        let moved: f64 = self.pairs().iter().map(|&(i, j, sign)| sign * z[i] * z[j]).sum();
        self.sign * (z[self.tensor_index()] + moved / mass - self.bound)
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let mass = z[self.mass].max(LIGHTEST);
        let mut slopes = vec![(self.tensor_index(), self.sign)];
        for (i, j, sign) in self.pairs() {
            let factor = self.sign * sign / mass;
            slopes.extend([(i, factor * z[j]), (j, factor * z[i])]);
            if z[self.mass] >= LIGHTEST {
                slopes.push((self.mass, -factor * z[i] * z[j] / mass));
            }
        }
        (self.margin(z), dense(&slopes, &self.support()))
    }
}
