//! Which cone, if any, expresses a margin: `(affine + sum of factor * norm) / mass`.

use std::sync::Arc;

use super::elementary::{Function, SMALLEST_MASS};
use super::graph::{Graph, Id, Op};
use super::program::{Program, children};
use crate::form::{Affine, Body, Form, General};

/// More pieces of a minimum than this stay together as one general form.
const MOST_PIECES: usize = 64;
/// Sums with more norms than this are not looked into.
const MOST_NORMS: usize = 8;
/// How deep minima are looked for.
const DEEPEST: usize = 12;

/// `(affine + sum of factor * |rows|) / mass`.
#[derive(Debug, Clone, PartialEq)]
struct Conic {
    affine: Affine,
    norms: Vec<(f64, Vec<Affine>)>,
    mass: Option<Affine>,
}

/// What is known of every node so far; children stand before their parents, so one pass does.
#[derive(Debug, Default)]
pub(super) struct Cones {
    known: Vec<Option<Conic>>,
}

impl Cones {
    /// Looks at every node up to `last`.
    fn extend(&mut self, graph: &mut Graph, last: Id) -> Result<(), String> {
        for i in self.known.len()..=last.0 as usize {
            let conic = self.new_node(graph, Id(i as u32));
            let conic = conic.filter(|c| c.norms.len() <= MOST_NORMS);
            // Sums alone are counted with their node.
            if let Some(conic) = conic.as_ref().filter(|c| !c.norms.is_empty() || c.mass.is_some()) {
                graph.charge(conic.size())?;
            }
            self.known.push(conic);
        }
        Ok(())
    }

    fn of(&mut self, graph: &mut Graph, id: Id) -> Result<Option<&Conic>, String> {
        self.extend(graph, id)?;
        Ok(self.get(id))
    }

    fn get(&self, id: Id) -> Option<&Conic> {
        self.known.get(id.0 as usize).and_then(Option::as_ref)
    }

    fn new_node(&self, graph: &Graph, id: Id) -> Option<Conic> {
        if let Some(row) = graph.affine(id) {
            return Some(Conic { affine: row.clone(), norms: Vec::new(), mass: None });
        }
        match &graph.node(id).op {
            Op::Add(a, b) => self.get(*a)?.clone().plus(self.get(*b)?.clone()),
            Op::Mul(a, b) => {
                let factor = graph.value(*a)?;
                Some(self.get(*b)?.clone().times(factor))
            }
            Op::Div(a, b) => {
                let Op::Apply(Function::Floor, mass) = graph.node(*b).op else { return None };
                let above = self.get(*a).filter(|c| c.mass.is_none())?.clone();
                Some(Conic { mass: graph.affine(mass).cloned(), ..above })
            }
            Op::Norm(rows) => {
                let (rows, mass) = self.over_one_mass(rows)?;
                Some(Conic { affine: Affine::default(), norms: vec![(1.0, rows)], mass })
            }
            _ => None,
        }
    }

    /// The numerators of several quotients by the same mass (or by none).
    fn over_one_mass(&self, ids: &[Id]) -> Option<(Vec<Affine>, Option<Affine>)> {
        let parts: Vec<&Conic> = ids.iter().map(|&r| self.get(r)).collect::<Option<_>>()?;
        let mass = parts.iter().find_map(|c| c.mass.clone());
        let numerator =
            |c: &Conic| c.clone().over(mass.as_ref()).filter(|c| c.norms.is_empty()).map(|c| c.affine);
        let rows: Vec<Affine> = parts.into_iter().map(numerator).collect::<Option<_>>()?;
        Some((rows, mass))
    }

    /// Why no cone expresses `id`, and where in the script.
    fn why(&self, graph: &Graph, mut id: Id) -> String {
        loop {
            let op = &graph.node(id).op;
            let decides = matches!(op, Op::Choose { .. } | Op::Greatest(..));
            let culprit = children(op).into_iter().find(|&c| self.get(c).is_none());
            match culprit.filter(|_| !decides) {
                Some(culprit) => id = culprit,
                None => return reason(graph, id),
            }
        }
    }
}

/// What a sum takes \[bytes\].
fn size_of_sum(row: &Affine) -> usize {
    size_of::<Affine>() + size_of::<(usize, f64)>() * row.terms.len()
}

impl Conic {
    /// What it takes \[bytes\].
    fn size(&self) -> usize {
        let norms = self.norms.iter().flat_map(|(_, rows)| rows);
        norms.chain(&self.mass).chain([&self.affine]).map(size_of_sum).sum()
    }

    /// Brings a constant over a mass.
    fn over(self, mass: Option<&Affine>) -> Option<Self> {
        match (mass, &self.mass) {
            (Some(mass), None) => (self.norms.is_empty() && self.affine.terms.is_empty()).then(|| Self {
                affine: mass.clone().times(self.affine.constant),
                norms: Vec::new(),
                mass: Some(mass.clone()),
            }),
            (wanted, present) => (wanted == present.as_ref()).then_some(self),
        }
    }

    fn plus(self, other: Self) -> Option<Self> {
        let mass = self.mass.clone().or_else(|| other.mass.clone());
        let (mut sum, other) = (self.over(mass.as_ref())?, other.over(mass.as_ref())?);
        sum.affine = sum.affine.plus(1.0, &other.affine);
        for (factor, rows) in other.norms {
            match sum.norms.iter_mut().find(|(_, known)| *known == rows) {
                Some((total, _)) => *total += factor,
                None => sum.norms.push((factor, rows)),
            }
        }
        Some(sum)
    }

    fn times(mut self, factor: f64) -> Self {
        self.affine = self.affine.times(factor);
        self.norms.iter_mut().for_each(|(weight, _)| *weight *= factor);
        self
    }

    /// The body that holds where this is not negative.
    fn body(self) -> Option<Body> {
        match self.norms.as_slice() {
            [] => Some(Body::Affine(self.affine)),
            [(factor, rows)] if *factor < 0.0 => {
                let rows = rows.iter().map(|r| r.clone().times(-factor)).collect();
                Some(Body::Norm { rows, bound: self.affine })
            }
            _ => None,
        }
    }
}

/// A margin per mass, in the unit the script states: a centre of mass in metres where the cone has `kg m`.
#[derive(Debug)]
struct PerMass {
    form: Form,
    mass: Affine,
}

impl General for PerMass {
    fn support(&self) -> Vec<usize> {
        let mut all = self.form.support();
        all.extend(self.mass.terms.iter().map(|t| t.0));
        all.sort_unstable();
        all.dedup();
        all
    }

    fn margin(&self, z: &[f64]) -> f64 {
        self.form.margin(z) / Function::Floor.at(self.mass.at(z))
    }

    fn gradient(&self, z: &[f64]) -> (f64, Vec<f64>) {
        let (above, slopes) = self.form.gradient(z);
        let mass = self.mass.at(z);
        let below = Function::Floor.at(mass);
        let mut row = Affine { terms: slopes, constant: 0.0 }.times(1.0 / below);
        if mass >= SMALLEST_MASS {
            row = row.plus(-above / (below * below), &self.mass);
        }
        let slope = |i| row.terms.iter().find(|t| t.0 == i).map_or(0.0, |t| t.1);
        (above / below, self.support().into_iter().map(slope).collect())
    }
}

/// What a form is called and measured in.
#[derive(Debug, Clone)]
pub(super) struct Naming {
    pub(super) label: String,
    pub(super) unit: String,
    pub(super) scale: f64,
}

impl Naming {
    /// What a form takes beside its body \[bytes\].
    fn size(&self) -> usize {
        2 * size_of::<Form>() + 4 * (self.label.len() + self.unit.len())
    }

    fn form(&self, body: Body) -> Form {
        Form::new(self.label.clone(), self.unit.clone(), self.scale, body)
    }

    fn form_over(&self, body: Body, mass: Option<Affine>) -> Form {
        let form = self.form(body);
        match mass {
            Some(mass) => Form { measure: Some(Arc::new(PerMass { form: form.clone(), mass })), ..form },
            None => form,
        }
    }
}

/// Forms that hold together exactly where `margin >= 0`.
pub(super) fn forms(
    graph: &mut Graph,
    cones: &mut Cones,
    margin: Id,
    naming: &Naming,
) -> Result<Vec<Form>, String> {
    let pieces = pieces(graph, margin, DEEPEST)?;
    let several = pieces.len() > 1;
    let named = |number: usize| Naming {
        label: if several { format!("{} ({})", naming.label, number + 1) } else { naming.label.clone() },
        ..naming.clone()
    };
    pieces.into_iter().enumerate().map(|(i, piece)| form(graph, cones, piece, &named(i))).collect()
}

fn form(graph: &mut Graph, cones: &mut Cones, margin: Id, naming: &Naming) -> Result<Form, String> {
    if let Some(conic) = cones.of(graph, margin)?.cloned() {
        // The form, and its copy where it is measured in another unit.
        graph.charge(naming.size() + 2 * conic.size())?;
        let mass = conic.mass.clone();
        if let Some(body) = conic.body() {
            return Ok(naming.form_over(body, mass));
        }
    }
    let function = Arc::new(Program::new(graph, margin));
    graph.charge(naming.size() + function.size())?;
    Ok(naming.form(Body::General { function, why: cones.why(graph, margin), implied: Vec::new() }))
}

/// The form of a semidefinite matrix, given by its lower triangle.
pub(super) fn psd(
    graph: &mut Graph,
    cones: &mut Cones,
    lower: &[Id],
    size: usize,
    naming: &Naming,
) -> Result<Form, String> {
    if let Some(&last) = lower.iter().max() {
        cones.extend(graph, last)?;
    }
    if let Some((lower, mass)) = cones.over_one_mass(lower) {
        graph.charge(naming.size() + 2 * lower.iter().map(size_of_sum).sum::<usize>())?;
        return Ok(naming.form_over(Body::Psd { size, lower }, mass));
    }
    let culprit = lower.iter().copied().find(|&id| cones.get(id).is_none_or(|c| !c.norms.is_empty()));
    let why = culprit.map_or_else(
        || "entries of the matrix are divided by different masses".to_string(),
        |id| cones.why(graph, id),
    );
    let least = graph.eigenvalue(lower, size, 0)?;
    let function = Arc::new(Program::new(graph, least));
    graph.charge(naming.size() + function.size())?;
    Ok(naming.form(Body::General { function, why, implied: Vec::new() }))
}

/// Margins that are together not negative exactly where `id` is: a minimum falls apart.
fn pieces(graph: &mut Graph, id: Id, depth: usize) -> Result<Vec<Id>, String> {
    if depth == 0 {
        return Ok(vec![id]);
    }
    let mut all = Vec::new();
    match graph.node(id).op {
        Op::Least(a, b) => {
            all = pieces(graph, a, depth - 1)?;
            all.extend(pieces(graph, b, depth - 1)?);
        }
        Op::Add(a, b) => {
            let (left, right) = (pieces(graph, a, depth - 1)?, pieces(graph, b, depth - 1)?);
            if left.len() * right.len() > 1 && left.len() * right.len() <= MOST_PIECES {
                for (&a, &b) in left.iter().flat_map(|a| right.iter().map(move |b| (a, b))) {
                    all.push(graph.add(a, b)?);
                }
            }
        }
        _ => {}
    }
    Ok(if all.is_empty() || all.len() > MOST_PIECES { vec![id] } else { all })
}

fn reason(graph: &Graph, id: Id) -> String {
    let node = graph.node(id);
    let reason = match &node.op {
        Op::Mul(..) => "a product of unknowns",
        Op::Div(..) => "a division by something else than a mass",
        Op::Power(..) => "a power of unknowns",
        Op::Norm(..) => "a norm of quantities divided by different masses",
        Op::Eigenvalue { .. } => "an eigenvalue (of principal moments, say; `psd(matrix)` is the convex way)",
        Op::Choose { test, .. } => {
            return format!("a choice by comparing unknowns{}", at(graph.node(*test).spot));
        }
        Op::Greatest(..) => "one of several alternatives is enough",
        Op::Least(..) => "a minimum inside another expression",
        Op::Apply(Function::Floor, _) => "a mass that divides",
        Op::Apply(function, _) => return format!("{} of unknowns{}", function.name(), at(node.spot)),
        Op::Add(..) | Op::Affine(..) => {
            "a norm bounded from below, several norms, or quotients by different masses in one sum"
        }
    };
    format!("{reason}{}", at(node.spot))
}

fn at((line, column): super::graph::Spot) -> String {
    if line == 0 { String::new() } else { format!(" (line {line}, column {column})") }
}
