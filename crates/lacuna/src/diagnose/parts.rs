//! What the model at hand is made of: effects with their columns, and nuisance columns that nobody names.

use std::sync::Arc;

use super::candidates::{Candidate, Identity, local_joint};
use super::data::{Column, Data};
use super::present::Columns;
use crate::effects::{AtRest, Effect};
use crate::error::Result;
use crate::identify::BaseParameters;
use crate::model::Model;
use crate::robot::{JointKind, Robot};

/// Relative step for slopes with respect to nonlinear parameters.
const STEP: f64 = 0.02;

/// An effect in the model.
#[derive(Debug, Clone)]
pub(super) struct Part {
    pub effect: Box<dyn Effect>,
    /// The joint it acts on, where it is one.
    pub joint: Option<usize>,
    /// What tells it from the same effect elsewhere.
    pub identity: Identity,
    /// Whether it was found here, or was there from the start.
    pub found: bool,
    /// Terms that are fitted: all of them, or the leading ones of base parameters.
    terms: Vec<usize>,
    columns: Vec<Arc<Column>>,
    /// Linear parameters when it was found, for the slopes.
    values: Vec<f64>,
    /// Slopes with respect to its nonlinear parameters, so that later tests allow for their re-estimation.
    slopes: Vec<Arc<Column>>,
    removed: bool,
}

impl Part {
    /// A part of the starting model.
    pub fn given(data: &Data, effect: Box<dyn Effect>) -> Result<Self> {
        let terms = if effect.is_rigid_body() {
            BaseParameters::new(&data.robot).pivots
        } else {
            (0..effect.terms(&data.robot)?.len()).collect()
        };
        let joint = local_joint(effect.as_ref(), &data.robot)?;
        let identity = Identity::of(effect.as_ref(), &data.robot)?;
        let mut part = Self {
            effect,
            joint,
            identity,
            found: false,
            terms,
            columns: vec![],
            values: vec![],
            slopes: vec![],
            removed: false,
        };
        part.build(data)?;
        Ok(part)
    }

    /// A part found here, with its linear parameters for the slopes of the nonlinear ones.
    pub fn found(data: &Data, effect: Box<dyn Effect>, joint: Option<usize>, values: &[f64]) -> Result<Self> {
        let terms = (0..values.len()).collect();
        let identity = Identity::of(effect.as_ref(), &data.robot)?;
        let mut part = Self {
            effect,
            joint,
            identity,
            found: true,
            terms,
            columns: vec![],
            values: values.to_vec(),
            slopes: vec![],
            removed: false,
        };
        part.build(data)?;
        Ok(part)
    }

    fn build(&mut self, data: &Data) -> Result<()> {
        let all = if self.found {
            data.candidate_columns(self.effect.as_ref())?
        } else {
            data.columns_of(self.effect.as_ref(), Some(&self.terms))?
        };
        let mut all: Vec<Option<Column>> = all.into_iter().map(Some).collect();
        self.columns = self.terms.iter().filter_map(|&t| all[t].take()).map(Arc::new).collect();
        if self.found {
            self.slopes = self.slopes_at(data, &self.values)?;
        }
        Ok(())
    }

    fn slopes_at(&self, data: &Data, values: &[f64]) -> Result<Vec<Arc<Column>>> {
        let shapes = self.effect.shapes();
        let now: Vec<f64> = shapes.iter().map(|s| s.value).collect();
        let mut slopes = Vec::new();
        for (k, shape) in shapes.iter().enumerate() {
            let step = STEP * shape.value.abs().max(0.05 * (shape.high - shape.low));
            // A difference may become one-sided at the end of the range, but never leaves it.
            let ends = [now[k] + step, now[k] - step].map(|x| x.clamp(shape.low, shape.high));
            let moved = ends.map(|value| {
                let mut moved = now.clone();
                moved[k] = value;
                self.effect.with_shapes(&moved)
            });
            let columns = data.candidate_columns_of_each(&[moved[0].as_ref(), moved[1].as_ref()])?;
            let factor = 1.0 / (ends[0] - ends[1]).max(1e-12);
            slopes.push(Arc::new(difference(&columns[0], &columns[1], values, factor)));
        }
        Ok(slopes)
    }
}

/// `sum over columns of value * (up - down) * factor`.
fn difference(up: &[Column], down: &[Column], values: &[f64], factor: f64) -> Column {
    let mut joints: Vec<usize> = up.iter().flat_map(|c| c.parts.iter().map(|(j, _)| *j)).collect();
    joints.sort_unstable();
    joints.dedup();
    let rows = |joint: usize| -> Vec<f64> {
        let mut sum: Vec<f64> = Vec::new();
        for ((up, down), value) in up.iter().zip(down).zip(values) {
            let (Some(a), Some(b)) = (up.part(joint), down.part(joint)) else { continue };
            sum.resize(a.len(), 0.0);
            for (s, (a, b)) in sum.iter_mut().zip(a.iter().zip(b)) {
                *s += factor * value * (a - b);
            }
        }
        sum
    };
    Column { parts: joints.into_iter().map(|j| (j, rows(j))).collect(), in_interval: false }
}

/// A column that is nobody's physics.
#[derive(Debug, Clone)]
struct Nuisance {
    of: Doubt,
    joint: usize,
    column: Arc<Column>,
}

/// What a nuisance allows for.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Doubt {
    /// How the column of a sign changes with its width [rad/s].
    Width(f64),
    /// First moments of the first links, which only a leaning base shows: sine (0) and cosine (1) of the joint's angle.
    Lean(usize),
}

/// All parts of the model at hand.
#[derive(Debug, Clone)]
pub(super) struct Parts {
    parts: Vec<Part>,
    /// Width of the smoothed sign of each joint [rad/s].
    pub widths: Vec<f64>,
    nuisances: Vec<Nuisance>,
    /// Whether a leaning base shows first moments of the first link as well.
    leans: bool,
    /// Whether candidates exist in some of the runs only; the effects that were there may then change too.
    two_logs: bool,
}

impl Parts {
    /// The starting model. Where a sign is smoothed, the change of the columns with its width is taken in
    /// as a nuisance: a sign sharper or softer than the model's must not look like physics.
    pub fn new(data: &Data, effects: Vec<Box<dyn Effect>>, widths: Vec<f64>) -> Result<Self> {
        let parts: Vec<Part> = effects.into_iter().map(|e| Part::given(data, e)).collect::<Result<_>>()?;
        let mut this = Self {
            parts,
            widths,
            nuisances: Vec::new(),
            leans: false,
            two_logs: data.changed.iter().any(|c| !c),
        };
        this.renew_nuisances(data, false)?;
        Ok(this)
    }

    /// Nuisances of the parts as they are; on the `same` data, those that stay are not computed again.
    fn renew_nuisances(&mut self, data: &Data, same: bool) -> Result<()> {
        let mut joints: Vec<usize> = Vec::new();
        for part in self.live().map(|(_, p)| p).filter(|p| p.effect.about().at_rest == AtRest::Step) {
            joints.extend(part.effect.terms(&data.robot)?.iter().flat_map(|t| t.joints.clone()));
        }
        joints.sort_unstable();
        joints.dedup();
        let mut wanted: Vec<(Doubt, usize)> =
            joints.into_iter().map(|joint| (Doubt::Width(self.widths[joint]), joint)).collect();
        if self.leans && self.has_tilt() {
            wanted
                .extend(upright(data).into_iter().flat_map(|j| [0, 1].map(|phase| (Doubt::Lean(phase), j))));
        }
        let nuisance = |(of, joint): (Doubt, usize)| {
            let there = self.nuisances.iter().find(|n| same && n.joint == joint && n.of == of);
            let column = there.map_or_else(|| Arc::new(doubted(data, joint, of)), |n| n.column.clone());
            Nuisance { of, joint, column }
        };
        self.nuisances = wanted.into_iter().map(nuisance).collect();
        Ok(())
    }

    /// Whether a leaning base is part of the model.
    pub fn has_tilt(&self) -> bool {
        self.live().any(|(_, p)| is_tilt(p))
    }

    /// From now on a leaning base may show where the first link has its mass; answers whether that is new.
    pub fn allow_for_lean(&mut self, data: &Data) -> Result<bool> {
        let new = !self.leans;
        self.leans = true;
        self.renew_nuisances(data, true)?;
        Ok(new)
    }

    fn live(&self) -> impl Iterator<Item = (usize, &Part)> {
        self.parts.iter().enumerate().filter(|(_, p)| !p.removed)
    }

    /// Adds a part; its joint keeps the nuisance that it has.
    pub fn add(&mut self, part: Part) -> usize {
        self.parts.push(part);
        self.parts.len() - 1
    }

    pub fn remove(&mut self, part: usize) {
        self.parts[part].removed = true;
    }

    /// Puts the same effect with other shapes into the place of a part.
    pub fn replace(&mut self, part: usize, data: &Data, effect: Box<dyn Effect>) -> Result<()> {
        self.parts[part].effect = effect;
        self.parts[part].build(data)
    }

    pub fn get(&self, part: usize) -> &Part {
        &self.parts[part]
    }

    pub fn joint(&self, part: usize) -> Option<usize> {
        self.parts[part].joint
    }

    /// Computes columns again: all of them, or those that depend on the model's torque.
    pub fn rebuild(&mut self, data: &Data, only_model_dependent: bool) -> Result<()> {
        for part in self.parts.iter_mut().filter(|p| !p.removed) {
            if !only_model_dependent || part.effect.needs_torque() {
                part.build(data)?;
            }
        }
        self.renew_nuisances(data, only_model_dependent)
    }

    /// Whether a part depends on the model's torque.
    pub fn need_torque(&self) -> bool {
        self.live().any(|(_, p)| p.effect.needs_torque())
    }

    /// All columns: effects first, then slopes, then nuisances.
    pub fn columns(&self) -> Columns {
        self.columns_without(&[])
    }

    /// All columns but those of some parts.
    pub fn columns_without(&self, parts: &[usize]) -> Columns {
        let kept = || self.live().filter(move |(k, _)| !parts.contains(k)).map(|(_, p)| p);
        let leans = kept().any(is_tilt);
        let of_a_lean = |n: &&Nuisance| matches!(n.of, Doubt::Lean(_));
        let held_back: Vec<Arc<Column>> =
            self.nuisances.iter().filter(|n| !of_a_lean(n)).map(|n| n.column.clone()).collect();
        // What a lean shows of the first link is as real as the lean, and not held back.
        let lean = self.nuisances.iter().filter(of_a_lean).filter(|_| leans).map(|n| n.column.clone());
        let effects = kept().flat_map(|p| p.columns.iter().cloned());
        let slopes = kept().flat_map(|p| p.slopes.iter().cloned());
        let nuisances = held_back.len();
        Columns { columns: effects.chain(slopes).chain(lean).chain(held_back).collect(), nuisances }
    }

    /// Columns of one part.
    pub fn own_columns(&self, part: usize) -> Vec<Arc<Column>> {
        self.parts[part].columns.clone()
    }

    /// Where the columns of a part stand among all columns.
    pub fn place(&self, part: usize) -> std::ops::Range<usize> {
        let before: usize = self.live().take_while(|(k, _)| *k != part).map(|(_, p)| p.columns.len()).sum();
        before..before + self.parts[part].columns.len()
    }

    /// Whether a candidate is part of the model already.
    pub fn has(&self, candidate: &Candidate) -> bool {
        self.live().any(|(_, p)| p.identity.covers(&candidate.identity) && (p.found || !self.two_logs))
    }

    /// The effects, in the order of their columns.
    pub fn effects(&self) -> Vec<Box<dyn Effect>> {
        self.live().map(|(_, p)| p.effect.clone()).collect()
    }

    /// The effects that act in all runs, in the order of their columns.
    pub fn shared_effects(&self) -> Vec<Box<dyn Effect>> {
        self.live().filter(|(_, p)| !(p.found && self.two_logs)).map(|(_, p)| p.effect.clone()).collect()
    }

    /// Live parts.
    pub fn numbers(&self) -> Vec<usize> {
        self.live().map(|(k, _)| k).collect()
    }

    /// The same model for everybody else, with its values out of `x`.
    pub fn model(&self, robot: &Robot, x: &[f64]) -> Result<(Model, Vec<f64>)> {
        let model = Model::new(robot, self.shared_effects())?;
        let values = x[..model.columns.len()].to_vec();
        Ok((model, values))
    }

    /// Name and joint, for people.
    pub fn title(&self, part: usize, robot: &Robot) -> String {
        let part = &self.parts[part];
        let joint = part.identity.joint.map_or_else(String::new, |j| format!(" on {}", robot.joints[j].name));
        format!("{}{joint}", part.effect.about().name)
    }
}

fn doubted(data: &Data, joint: usize, of: Doubt) -> Column {
    data.column_of(joint, |run, out| match of {
        // A difference over a factor of four: a slope at one width is too local.
        Doubt::Width(width) => {
            for (y, v) in out.iter_mut().zip(run.friction_dq(joint)) {
                *y = libm::tanh(2.0 * v / width) - libm::tanh(0.5 * v / width);
            }
        }
        Doubt::Lean(phase) => {
            let wave = [libm::sin, libm::cos][phase];
            out.iter_mut().zip(&run.q[joint]).for_each(|(y, q)| *y = wave(*q));
        }
    })
}

/// The joint at the base, where it turns about the vertical: gravity does nothing to the link it carries as long as the
/// base does not lean.
pub(super) fn upright(data: &Data) -> Option<usize> {
    let robot = &data.robot;
    let first = *robot.order.iter().find(|&&j| robot.joints[j].parent.is_none())?;
    let joint = &robot.joints[first];
    let axis = joint.before.rotation * joint.axis;
    let size = robot.gravity.norm();
    let upright = size > 0.0 && axis.dot(&robot.gravity).abs() > 0.99 * size;
    (upright && joint.kind == JointKind::Revolute).then_some(first)
}

fn is_tilt(part: &Part) -> bool {
    part.effect.about().special.leans
}
