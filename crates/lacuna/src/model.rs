//! A model: a robot and the effects that make its torque, lowered to numbered columns.

use std::ops::Range;

use crate::effects::{Columns, Effect, Stretch, Term};
use crate::error::{Error, Result};
use crate::identify::BaseParameters;
use crate::kernels::{Chain, RegressorBlock};
use crate::robot::Robot;
use crate::signals::Run;

/// Samples of rigid links computed at once.
const STRETCH: usize = 256;

/// One column of the regressor: a linear parameter that is fitted.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Column {
    /// Which effect of the model.
    pub effect: usize,
    /// Which of that effect's terms.
    pub term: usize,
    /// Symbol, unit and joints it reaches.
    pub about: Term,
    /// What the parameter stands for: a grouped expression for base parameters, else the symbol.
    pub expression: String,
}

/// A robot with its effects. Rigid-body parameters appear as base parameters only, so the columns are
/// independent for a rich enough motion.
#[derive(Debug, Clone)]
pub struct Model {
    /// The robot.
    pub robot: Robot,
    /// Constants of its kernels.
    pub chain: Chain,
    /// The effects, in the order given.
    pub effects: Vec<Box<dyn Effect>>,
    /// Base parameters, when `rigid_body` is among the effects.
    pub base: Option<BaseParameters>,
    /// All fitted columns, effect by effect.
    pub columns: Vec<Column>,
    /// `active[j]`: the columns that can change the torque of joint `j`, ascending.
    pub active: Vec<Vec<usize>>,
    /// `slots[effect][term]`: the column number, where the term is fitted.
    slots: Vec<Vec<Option<usize>>>,
}

impl Model {
    /// Lowers `effects` on `robot`.
    ///
    /// # Errors
    /// When an effect does not fit the robot, or stands there twice.
    pub fn new(robot: &Robot, effects: Vec<Box<dyn Effect>>) -> Result<Self> {
        let mut columns: Vec<Column> = Vec::new();
        let mut slots = Vec::new();
        let mut base = None;
        for (number, effect) in effects.iter().enumerate() {
            let terms = effect.terms(robot)?;
            let rigid = effect.is_rigid_body();
            let found = rigid.then(|| BaseParameters::new(robot));
            let mut slot = vec![None; terms.len()];
            for (term, mut about) in terms.into_iter().enumerate() {
                if !effect.shapes().is_empty() {
                    about.symbol = unused(&columns, about.symbol);
                }
                let expression = match &found {
                    None => about.symbol.clone(),
                    Some(found) => match found.pivots.iter().position(|&p| p == term) {
                        Some(i) => found.expression(i),
                        None => continue,
                    },
                };
                if let Some(twin) = columns.iter().find(|c| c.about.symbol == about.symbol) {
                    return Err(Error::new(format!(
                        "`{}` would have the parameter `{}` twice",
                        effect.about().name,
                        twin.about.symbol
                    ))
                    .help("list every effect once, and every joint once in it"));
                }
                slot[term] = Some(columns.len());
                columns.push(Column { effect: number, term, about, expression });
            }
            slots.push(slot);
            base = base.or(found);
        }
        let reaches =
            |j: usize| (0..columns.len()).filter(|&c| columns[c].about.joints.contains(&j)).collect();
        let active = (0..robot.dof()).map(reaches).collect();
        Ok(Self { chain: Chain::new(robot), robot: robot.clone(), effects, base, columns, active, slots })
    }

    /// Whether `effect` is part of the model.
    pub fn has(&self, effect: &str) -> bool {
        self.effects.iter().any(|e| e.about().name == effect)
    }

    /// Whether an effect is built from the model's own torque ([`crate::effects::BuiltFrom`]).
    pub fn needs_torque(&self) -> bool {
        self.effects.iter().any(|e| e.needs_torque())
    }

    /// Adds the torque that some of the effects make with the values `x`, at every sample of `run`:
    /// `torque[joint][sample]` [N m, N].
    ///
    /// # Errors
    /// When the run lacks something one of these effects needs.
    pub fn add_torque(
        &self,
        x: &[f64],
        run: &Run,
        torque: &mut [Vec<f64>],
        which: impl Fn(&dyn Effect) -> bool,
    ) -> Result<()> {
        let mut room = vec![0.0; run.samples()];
        let mut scratch = None;
        for (number, effect) in self.effects.iter().enumerate().filter(|(_, e)| which(e.as_ref())) {
            let slots = &self.slots[number];
            for range in stretches(effect.as_ref(), 0..run.samples()) {
                run.stop.check()?;
                let mut wanted = |term: usize, joint: usize, fill: &mut dyn FnMut(&mut [f64])| {
                    let Some(column) = slots[term] else { return };
                    let room = &mut room[..range.len()];
                    room.fill(0.0);
                    fill(room);
                    torque[joint][range.clone()].iter_mut().zip(room).for_each(|(t, y)| *t += x[column] * *y);
                };
                let at = Stretch { robot: &self.robot, chain: &self.chain, run, range: range.clone() };
                effect.columns(&at, &mut Columns { wanted: &mut wanted, scratch: &mut scratch })?;
            }
        }
        Ok(())
    }

    /// Fills `block` with the columns of `run` over `range`.
    ///
    /// # Errors
    /// When the run lacks something an effect needs.
    pub fn fill(&self, run: &Run, range: Range<usize>, block: &mut ModelBlock) -> Result<()> {
        run.stop.check()?;
        block.reset(range.len());
        for (number, effect) in self.effects.iter().enumerate() {
            let slots = &self.slots[number];
            let (joints, stride) = (&mut block.joints, block.stride);
            let active = &self.active;
            for part in stretches(effect.as_ref(), range.clone()) {
                let first = part.start - range.start;
                let mut wanted = |term: usize, joint: usize, fill: &mut dyn FnMut(&mut [f64])| {
                    let Some(column) = slots[term] else { return };
                    if let Ok(local) = active[joint].binary_search(&column) {
                        fill(&mut joints[joint][local * stride + first..][..part.len()]);
                    }
                };
                let at = Stretch { robot: &self.robot, chain: &self.chain, run, range: part.clone() };
                effect.columns(&at, &mut Columns { wanted: &mut wanted, scratch: &mut block.scratch })?;
            }
        }
        Ok(())
    }
}

/// What of `range` an effect computes at once: rigid links look at one sample only and have many columns, which stay
/// in the cache in pieces.
fn stretches(effect: &dyn Effect, range: Range<usize>) -> impl Iterator<Item = Range<usize>> {
    let step = if effect.is_rigid_body() { STRETCH } else { range.len().max(1) };
    range.clone().step_by(step).map(move |first| first..(first + step).min(range.end))
}

/// `symbol`, or `symbol'`, `symbol''` where it is taken: an effect with a shape may stand there again with
/// another one (two waves of torque ripple on one joint).
fn unused(columns: &[Column], mut symbol: String) -> String {
    while columns.iter().any(|c| c.about.symbol == symbol) {
        symbol.push('\'');
    }
    symbol
}

/// Columns of a model over a stretch of samples, joint by joint: `joints[j]` holds the columns of
/// `Model::active[j]` one after the other, each `stride` long.
#[derive(Debug, Clone)]
pub struct ModelBlock {
    /// Column data of every joint.
    pub joints: Vec<Vec<f64>>,
    /// Length of a column.
    pub stride: usize,
    scratch: Option<RegressorBlock>,
}

impl ModelBlock {
    /// Room for up to `stride` samples.
    pub fn new(model: &Model, stride: usize) -> Self {
        let joints = model.active.iter().map(|a| vec![0.0; a.len() * stride]).collect();
        Self { joints, stride, scratch: Some(RegressorBlock::new(&model.chain, stride.min(STRETCH))) }
    }

    fn reset(&mut self, rows: usize) {
        assert!(rows <= self.stride, "the stretch is longer than the block");
        for joint in &mut self.joints {
            joint.fill(0.0);
        }
    }

    /// Column `local` (an index into `Model::active[joint]`) over the first `rows` samples.
    pub fn column(&self, joint: usize, local: usize, rows: usize) -> &[f64] {
        &self.joints[joint][local * self.stride..local * self.stride + rows]
    }
}
