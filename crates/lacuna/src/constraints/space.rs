//! The unknowns of link-parameter retrieval, and the coordinates to search them in.

use nalgebra::{Matrix3, Vector3};

use crate::form::{Affine, Body};
use crate::retrieval::{BodyMatrix, Chart, Quantity, Side};
use crate::robot::{InertialParameters, PARAMETER_NAMES, PARAMETER_UNITS, PARAMETERS_PER_LINK, Robot};
use crate::space::{Parameter, Space};

/// Below this mass \[kg\] a range of the centre of mass is not asked for: it would be anywhere.
const LIGHTEST: f64 = 1e-3;

/// Unknowns `z`: the ten [`InertialParameters`] of every link (one group per link, in the order of the
/// robot's links), then any other linear parameters of the torque (friction), one group.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkSpace {
    /// Names and units of the unknowns; without bounds.
    pub space: Space,
    /// Number of links.
    pub links: usize,
    /// Names of the links.
    pub names: Vec<String>,
}

impl LinkSpace {
    /// The unknowns of `robot` with `others` behind them.
    pub fn new(robot: &Robot, others: &[Parameter]) -> Self {
        let mut space = Space::default();
        for (link, about) in robot.links.iter().enumerate() {
            let number = link + 1;
            let member = |(name, unit): (&&str, &str)| Parameter::free(format!("{name}{number}"), unit);
            space.push_group(about.name.clone(), PARAMETER_NAMES.iter().zip(PARAMETER_UNITS).map(member));
        }
        if !others.is_empty() {
            space.push_group("others", others.to_vec());
        }
        let names = robot.links.iter().map(|l| l.name.clone()).collect();
        Self { space, links: robot.dof(), names }
    }

    /// Mass of a link \[kg\].
    pub fn mass(&self, link: usize) -> Affine {
        Affine::variable(PARAMETERS_PER_LINK * link)
    }

    /// Component `axis` (0, 1, 2) of mass times centre of mass [kg m].
    pub fn first_moment(&self, link: usize, axis: usize) -> Affine {
        Affine::variable(PARAMETERS_PER_LINK * link + 1 + axis)
    }

    /// Element of the inertia tensor about the link origin [kg m²].
    pub fn inertia_at_origin(&self, link: usize, row: usize, column: usize) -> Affine {
        const PLACE: [[usize; 3]; 3] = [[4, 5, 6], [5, 7, 8], [6, 8, 9]];
        Affine::variable(PARAMETERS_PER_LINK * link + PLACE[row][column])
    }

    /// Lower triangle by rows of the pseudo-inertia `[[tr(J)/2 1 - J, mc], [mcᵀ, m]]`.
    pub fn pseudo_inertia(&self, link: usize) -> Vec<Affine> {
        let j = |a: usize, b: usize| self.inertia_at_origin(link, a, b);
        let mut lower = Vec::with_capacity(10);
        for a in 0..3 {
            for b in 0..=a {
                if a == b {
                    let half = j(0, 0).plus(1.0, &j(1, 1)).plus(1.0, &j(2, 2)).times(0.5);
                    lower.push(half.plus(-1.0, &j(a, a)));
                } else {
                    lower.push(j(a, b).times(-1.0));
                }
            }
        }
        lower.extend((0..3).map(|axis| self.first_moment(link, axis)));
        lower.push(self.mass(link));
        lower
    }

    /// What people ask of a link: mass, centre of mass (where the link weighs a gram or more) and
    /// inertia about the link origin, for every link.
    pub fn quantities(&self) -> Vec<Quantity> {
        let axes = ["x", "y", "z"];
        let mut all = Vec::with_capacity(PARAMETERS_PER_LINK * self.links);
        let quantity = |name: String, unit: &str, numerator, denominator| Quantity {
            name,
            unit: unit.to_string(),
            numerator,
            denominator,
        };
        for link in 0..self.links {
            let number = link + 1;
            all.push(quantity(format!("m{number}"), "kg", self.mass(link), None));
            for (axis, letter) in axes.iter().enumerate() {
                let per_mass = Some((self.mass(link), LIGHTEST));
                all.push(quantity(
                    format!("c{number}{letter}"),
                    "m",
                    self.first_moment(link, axis),
                    per_mass,
                ));
            }
            for (row, column) in [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)] {
                let name = format!("J{}{}{number}", axes[row], axes[column]);
                all.push(quantity(name, "kg m^2", self.inertia_at_origin(link, row, column), None));
            }
        }
        all
    }

    /// The links' pseudo-inertias, as tie-breaks compare them.
    pub fn bodies(&self) -> Vec<BodyMatrix> {
        let body = |(link, name): (usize, &String)| BodyMatrix {
            name: name.clone(),
            size: 4,
            lower: self.pseudo_inertia(link),
        };
        self.names.iter().enumerate().map(body).collect()
    }

    /// Inertial parameters of a link at `z`.
    pub fn link(&self, z: &[f64], link: usize) -> InertialParameters {
        let at = PARAMETERS_PER_LINK * link;
        InertialParameters(std::array::from_fn(|i| z[at + i]))
    }
}

/// Names of the barycentric coordinates of a link, in order; the link's number follows the first letter(s)
/// as in the paper's tables: `m1`, `c1x`, `I1xx`.
pub const COORDINATES: [(&str, &str, &str); PARAMETERS_PER_LINK] = [
    ("m", "", "kg"),
    ("c", "x", "m"),
    ("c", "y", "m"),
    ("c", "z", "m"),
    ("I", "xx", "kg m^2"),
    ("I", "xy", "kg m^2"),
    ("I", "xz", "kg m^2"),
    ("I", "yy", "kg m^2"),
    ("I", "yz", "kg m^2"),
    ("I", "zz", "kg m^2"),
];

/// Search coordinates of a link: mass, centre of mass, inertia about it (the `p` of Gaz et al. 2019, eq. 27,
/// link by link); others unchanged.
#[derive(Debug, Clone, PartialEq)]
pub struct Barycentric {
    space: Space,
    links: usize,
}

impl Barycentric {
    /// Coordinates over the unknowns of `links`, with `bounds(name)` for each coordinate name (`m1`, `c1x`,
    /// `I1xx`, or the name of another parameter).
    pub fn new(links: &LinkSpace, bounds: impl Fn(&str) -> (f64, f64)) -> Self {
        let mut space = Space::default();
        for (link, name) in links.names.iter().enumerate() {
            let members = COORDINATES.iter().map(|(head, tail, unit)| {
                let name = format!("{head}{}{tail}", link + 1);
                let (lower, upper) = bounds(&name);
                Parameter::free(name, *unit).within(lower, upper)
            });
            space.push_group(name.clone(), members.collect::<Vec<_>>());
        }
        let others = &links.space.parameters[PARAMETERS_PER_LINK * links.links..];
        if !others.is_empty() {
            let bounded = others.iter().map(|p| {
                let (lower, upper) = bounds(&p.name);
                p.clone().within(lower, upper)
            });
            space.push_group("others", bounded.collect::<Vec<_>>());
        }
        Self { space, links: links.links }
    }
}

impl Chart for Barycentric {
    fn space(&self) -> &Space {
        &self.space
    }

    fn group_to_unknowns(&self, group: usize, p: &[f64], z: &mut [f64]) {
        if group >= self.links {
            z.copy_from_slice(p);
            return;
        }
        let com = Vector3::new(p[1], p[2], p[3]);
        let inertia = Matrix3::new(p[4], p[5], p[6], p[5], p[7], p[8], p[6], p[8], p[9]);
        z.copy_from_slice(InertialParameters::from_barycentric(p[0], com, inertia).as_slice());
    }

    fn group_to_coordinates(&self, group: usize, z: &[f64], p: &mut [f64]) {
        if group >= self.links {
            p.copy_from_slice(z);
            return;
        }
        let link = InertialParameters(std::array::from_fn(|i| z[i]));
        let com = link.center_of_mass().unwrap_or_else(Vector3::zeros);
        let inertia = link.inertia_at_center_of_mass().unwrap_or_else(|| link.inertia_at_origin());
        p[0] = link.mass();
        p[1..4].copy_from_slice(com.as_slice());
        let entries = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
        p[4..10].iter_mut().zip(entries).for_each(|(slot, at)| *slot = inertia[at]);
    }

    fn reach(&self) -> Option<Vec<f64>> {
        let largest: Vec<f64> =
            self.space.parameters.iter().map(|p| p.lower.abs().max(p.upper.abs())).collect();
        let mut reach = largest.clone();
        for (p, z) in largest
            .chunks_exact(PARAMETERS_PER_LINK)
            .zip(reach.chunks_exact_mut(PARAMETERS_PER_LINK))
            .take(self.links)
        {
            let com = Vector3::new(p[1], p[2], p[3]);
            let inertia = Matrix3::new(p[4], p[5], p[6], p[5], p[7], p[8], p[6], p[8], p[9]);
            let largest = InertialParameters::from_barycentric(p[0], com, inertia);
            z.copy_from_slice(largest.as_slice());
            // Products of inertia can add up where they cancel for positive centres of mass.
            for (k, a, b) in [(5, 0, 1), (6, 0, 2), (8, 1, 2)] {
                z[k] = inertia[(a, b)] + p[0] * com[a] * com[b];
            }
        }
        Some(reach)
    }

    /// Mass; centre of mass as `mc - lower m >= 0`; a diagonal element of the inertia from below, which is
    /// the Schur complement of `[[J - lower, mb, mc], [mb, m, 0], [mc, 0, m]]`. The other bounds of the
    /// inertia are not convex.
    fn convex_bound(&self, coordinate: usize, side: Side) -> Option<Body> {
        let about = &self.space.parameters[coordinate];
        let row = |value: Affine, unit: &Affine| match side {
            Side::Lower => value.plus(-about.lower, unit),
            Side::Upper => value.times(-1.0).plus(about.upper, unit),
        };
        let one = Affine::constant(1.0);
        let (link, member) = (coordinate / PARAMETERS_PER_LINK, coordinate % PARAMETERS_PER_LINK);
        let at = |k: usize| Affine::variable(PARAMETERS_PER_LINK * link + k);
        match member {
            _ if link >= self.links => Some(Body::Affine(row(Affine::variable(coordinate), &one))),
            0 => Some(Body::Affine(row(at(0), &one))),
            1..=3 => Some(Body::Affine(row(at(member), &at(0)))),
            // A fixed element has no interior that a Schur complement could describe.
            4 | 7 | 9 if side == Side::Lower && about.lower < about.upper => {
                let across = match member {
                    4 => [2, 3],
                    7 => [1, 3],
                    _ => [1, 2],
                };
                let [b, c] = across.map(at);
                let lower = vec![row(at(member), &one), b, at(0), c, Affine::default(), at(0)];
                Some(Body::Psd { size: 3, lower })
            }
            _ => None,
        }
    }
}
