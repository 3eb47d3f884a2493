use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::intervals::{Interval, Intervals};
use super::measure::{InertiaBound, measured, per_mass};
use super::{About, Bound, COORDINATES, Constraint, LinkSpace, range_forms};
use crate::error::{Error, Result};
use crate::form::{Affine, Body, Form};
use crate::robot::{PARAMETERS_PER_LINK, Robot};

/// Lower and upper bounds on single parameters (Gaz et al. 2019, LB and UB of Algorithm 1).
#[derive(Debug, Clone, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ParameterBounds {
    /// Limits by parameter name.
    pub bounds: Intervals,
}

impl ParameterBounds {
    /// See [`About`].
    pub const ABOUT: About = About {
        name: "parameter_bounds",
        title: "lower and upper bounds on single parameters, by name",
        text: "Bounds on mass, centre of mass and inertia about it, with the names of the paper's tables (m1, c1x, \
               I1xx), on link-frame parameters (mx1, Jxx1), or on any other parameter of the model: friction that \
               must not be negative is (0.0, inf). Bounds on mass and centre of mass and lower bounds on the \
               diagonal of the inertia are convex. Other bounds on inertia are not; engines that need convexity \
               get the tightest linear bound that follows from them together with finite bounds on the same \
               link's centre of mass in the same entry, so give those too.",
        condition: "lower <= parameter <= upper",
        settings: &[(
            "bounds",
            "kg, m, kg m^2",
            "{\"name\": (lower, upper), ..}; -inf or inf for no limit on that side",
        )],
        example: r#"{"parameter_bounds": (bounds: {"m1": (0.1, 10.0), "c1z": (-0.3, 0.3), "I1xx": (0.0, inf)})}"#,
        form: "affine and norm: every engine; off-diagonal inertia and upper bounds on its diagonal are general: \
               engines that search, a linear relaxation for the others",
    };
}

/// What a name stands for; links and axes from 0.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Coordinate {
    Mass(usize),
    Com(usize, usize),
    Inertia(usize, (usize, usize)),
    Unknown(usize),
}

fn find(space: &LinkSpace, name: &str) -> Result<Coordinate> {
    const ELEMENTS: [(usize, usize); 6] = [(0, 0), (0, 1), (0, 2), (1, 1), (1, 2), (2, 2)];
    for link in 0..space.links {
        let number = link + 1;
        let place = COORDINATES.iter().position(|(head, tail, _)| format!("{head}{number}{tail}") == name);
        match place {
            Some(0) => return Ok(Coordinate::Mass(link)),
            Some(k @ 1..=3) => return Ok(Coordinate::Com(link, k - 1)),
            Some(k) => return Ok(Coordinate::Inertia(link, ELEMENTS[k - 4])),
            None => {}
        }
    }
    space.space.index(name).map(Coordinate::Unknown).ok_or_else(|| {
        let others = &space.space.parameters[PARAMETERS_PER_LINK * space.links..];
        let others: String = others.iter().map(|p| format!(", {}", p.name)).collect();
        Error::new(format!("parameter_bounds: no parameter `{name}`")).help(format!(
            "known are m1, c1x, c1y, c1z, I1xx, I1xy, I1xz, I1yy, I1yz, I1zz and the same for links up to {n}; in the \
             link frame mx1, my1, mz1, Jxx1, Jxy1, Jxz1, Jyy1, Jyz1, Jzz1 up to {n}{others}",
            n = space.links
        ))
    })
}

#[typetag::serde(name = "parameter_bounds")]
impl Constraint for ParameterBounds {
    fn about(&self) -> About {
        Self::ABOUT
    }

    fn forms(&self, _robot: &Robot, space: &LinkSpace) -> Result<Vec<Form>> {
        let mut forms = Vec::new();
        for (name, interval) in &self.bounds.0 {
            if interval.lower > interval.upper {
                let text = format!("{name}: lower {} is above upper {}", interval.lower, interval.upper);
                return Err(Error::new(text).help("swap them"));
            }
            let lower = Some(interval.lower).filter(|x| x.is_finite());
            let upper = Some(interval.upper).filter(|x| x.is_finite());
            match find(space, name)? {
                Coordinate::Mass(link) => {
                    let what = format!("{}: {name}", space.names[link]);
                    forms.extend(range_forms(&what, "kg", &space.mass(link), lower, upper));
                }
                Coordinate::Com(link, axis) => forms.extend(com_forms(space, name, link, axis, lower, upper)),
                Coordinate::Inertia(link, element) => {
                    let bounds = [(lower, 1.0), (upper, -1.0)];
                    let sides = bounds.into_iter().filter_map(|(bound, sign)| Some((bound?, sign)));
                    forms.extend(sides.map(|side| self.inertia_form(space, name, link, element, side)));
                }
                Coordinate::Unknown(index) => {
                    let unit = &space.space.parameters[index].unit;
                    forms.extend(range_forms(name, unit, &Affine::variable(index), lower, upper));
                }
            }
        }
        Ok(forms)
    }

    fn bounds(&self, _robot: &Robot, space: &LinkSpace) -> Result<Vec<Bound>> {
        let mut bounds = Vec::new();
        for (name, Interval { lower, upper }) in &self.bounds.0 {
            let in_link_frame = match find(space, name)? {
                Coordinate::Unknown(index) => index < PARAMETERS_PER_LINK * space.links,
                _ => false,
            };
            if !in_link_frame {
                bounds.push(Bound { name: name.clone(), lower: *lower, upper: *upper });
            }
        }
        Ok(bounds)
    }
}

/// `lower m <= m c <= upper m`, reported in metres.
fn com_forms(
    space: &LinkSpace,
    name: &str,
    link: usize,
    axis: usize,
    lower: Option<f64>,
    upper: Option<f64>,
) -> Vec<Form> {
    let mass = space.mass(link);
    let form = |relation: &str, bound: f64, sign: f64| {
        let row = space.first_moment(link, axis).plus(-bound, &mass).times(sign);
        let label = format!("{}: {name} {relation} {bound} m", space.names[link]);
        per_mass(Form::affine(label, "m", bound, row), mass.clone())
    };
    let least = lower.map(|bound| form(">=", bound, 1.0));
    least.into_iter().chain(upper.map(|bound| form("<=", bound, -1.0))).collect()
}

impl ParameterBounds {
    /// One side of a bound on an element of the inertia about the centre of mass.
    fn inertia_form(
        &self,
        space: &LinkSpace,
        name: &str,
        link: usize,
        element: (usize, usize),
        (bound, sign): (f64, f64),
    ) -> Form {
        let relation = if sign > 0.0 { ">=" } else { "<=" };
        let label = format!("{}: {name} {relation} {bound} kg m^2", space.names[link]);
        let function = Arc::new(InertiaBound { mass: PARAMETERS_PER_LINK * link, element, sign, bound });
        if element.0 == element.1 && sign > 0.0 {
            let form = Form::new(label, "kg m^2", bound, least_moment(space, link, element.0, bound));
            return measured(form, space.mass(link), function);
        }
        let implied = self.relaxed(space, link, element, (bound, sign)).into_iter();
        let implied = implied.map(|row| Form::affine(format!("{label}, relaxed"), "kg m^2", bound, row));
        let body = Body::General {
            function,
            why:
                "inertia about the centre of mass is not linear in the unknowns, and this side is not convex"
                    .into(),
            implied: implied.collect(),
        };
        Form::new(label, "kg m^2", bound, body)
    }

    /// Linear conditions that the bound implies, given the bounds on the centre of mass: `m c_a c_b` between
    /// McCormick's envelopes, `m c_a²` below its chord.
    fn relaxed(
        &self,
        space: &LinkSpace,
        link: usize,
        (a, b): (usize, usize),
        (bound, sign): (f64, f64),
    ) -> Vec<Affine> {
        let com = |axis: usize| {
            let name = format!("c{}{}", link + 1, ["x", "y", "z"][axis]);
            self.bounds.get(&name).filter(Interval::is_finite)
        };
        let (m, mc) = (space.mass(link), |axis: usize| space.first_moment(link, axis));
        // `q mc_a + p mc_b - p q m` touches `m c_a c_b` where c_a = p and where c_b = q.
        let touching =
            |(a, p): (usize, f64), (b, q): (usize, f64)| mc(a).times(q).plus(p, &mc(b)).plus(-p * q, &m);
        let element = space.inertia_at_origin(link, a, b).plus(-1.0, &Affine::constant(bound)).times(sign);
        if a == b {
            let (c, d) = ((a + 1) % 3, (a + 2) % 3);
            let (Some(e), Some(f)) = (com(c), com(d)) else { return Vec::new() };
            // Upper bound: J - m c_c² - m c_d² <= hi with each square below its chord.
            let chord = |axis: usize, i: Interval| touching((axis, i.lower), (axis, i.upper));
            return vec![element.plus(-sign, &chord(c, e)).plus(-sign, &chord(d, f))];
        }
        let (Some(e), Some(f)) = (com(a), com(b)) else { return Vec::new() };
        let corners = if sign < 0.0 {
            // J + m c_a c_b <= hi: the product is above these two planes.
            [(e.lower, f.lower), (e.upper, f.upper)]
        } else {
            [(e.lower, f.upper), (e.upper, f.lower)]
        };
        let row = |(p, q): (f64, f64)| element.clone().plus(sign, &touching((a, p), (b, q)));
        corners.into_iter().map(row).collect()
    }
}

/// `I_aa >= bound` about the centre of mass: `(J_aa - bound) m >= |m c across a|²`, a second-order cone.
fn least_moment(space: &LinkSpace, link: usize, a: usize, bound: f64) -> Body {
    let spare = space.inertia_at_origin(link, a, a).plus(-1.0, &Affine::constant(bound));
    let mass = space.mass(link);
    let across = [(a + 1) % 3, (a + 2) % 3].map(|axis| space.first_moment(link, axis).times(2.0));
    let rows = across.into_iter().chain([spare.clone().plus(-1.0, &mass)]).collect();
    Body::Norm { rows, bound: spare.plus(1.0, &mass) }
}
