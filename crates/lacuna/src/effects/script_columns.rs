//! Columns of a scripted effect: its programs over the samples of a run, and its memory along the run.

use std::sync::{Arc, Mutex, PoisonError};

use super::Stretch;
use crate::error::{Error, Result};
use crate::robot::Robot;
use crate::script::{Clock, EffectScript, Input, JointColumns, Limits, MOST_BYTES};
use crate::signals::Run;

/// Memories of joints over whole runs that are kept at a time.
const KEPT: usize = 64;
/// A run is known again by every so-many-th sample of what the memory depends on.
const EVERY: usize = 61;

/// A script's programs on a robot.
#[derive(Debug, Clone)]
pub(crate) struct Lowered {
    names: Arc<[String]>,
    pub(crate) joints: Arc<[Part]>,
}

/// Those of one joint.
#[derive(Debug)]
pub(crate) struct Part {
    pub(crate) joint: usize,
    pub(crate) programs: JointColumns,
}

impl Lowered {
    pub(super) fn new(
        script: &EffectScript,
        robot: &Robot,
        joints: Vec<usize>,
        limits: &Limits,
    ) -> Result<Self> {
        let names: Vec<String> = robot.joints.iter().map(|j| j.name.clone()).collect();
        let part = |joint| Ok(Part { joint, programs: script.joint(&names, joint, limits)? });
        let joints: Vec<Part> = joints.into_iter().map(part).collect::<Result<_>>()?;
        Ok(Self { names: names.into(), joints: joints.into() })
    }

    pub(super) fn is_for(&self, robot: &Robot) -> bool {
        self.names.len() == robot.joints.len()
            && self.names.iter().zip(&robot.joints).all(|(a, b)| *a == b.name)
    }
}

/// Memories along runs, from before.
#[derive(Debug, Default)]
pub(crate) struct Traces(Mutex<Vec<(Key, Arc<Vec<f64>>)>>);

/// What a memory depends on, as bits.
type Key = (usize, Vec<u64>);

/// Where the values of an input come from.
enum Source<'a> {
    Samples(&'a [f64]),
    Time,
    Constant(f64),
    Memory(usize),
}

impl Part {
    /// One column per parameter over the samples of the stretch. The memory begins with the run, so columns do
    /// not depend on how a run is cut into stretches.
    pub(super) fn over(
        &self,
        script: &EffectScript,
        at: &Stretch<'_>,
        shapes: &[f64],
        traces: &Traces,
        clock: &mut Clock<'_>,
    ) -> Result<Vec<Vec<f64>>> {
        let sources = self.sources(at, shapes).map_err(|e| e.in_file(script.file()))?;
        let width = script.about().memory.len();
        let memory =
            self.memory(script, at.run, &sources, traces, clock).map_err(|e| e.in_file(script.file()))?;
        let (mut inputs, mut room) = (vec![0.0; sources.len()], Vec::new());
        let mut values = vec![0.0; script.about().parameters.len()];
        let mut columns = vec![Vec::with_capacity(at.range.len()); values.len()];
        for k in at.range.clone() {
            fill(&mut inputs, &sources, at.run, k, &memory[k * width..(k + 1) * width]);
            self.programs
                .columns(&inputs, &mut room, &mut values, clock)
                .map_err(|e| e.in_file(script.file()))?;
            if let Some(bad) = values.iter().position(|v| !v.is_finite()) {
                return Err(not_a_number(script, at, self.joint, k, bad));
            }
            columns.iter_mut().zip(&values).for_each(|(column, v)| column.push(*v));
        }
        Ok(columns)
    }

    fn sources<'a>(&self, at: &Stretch<'a>, shapes: &[f64]) -> Result<Vec<Source<'a>>> {
        let run = at.run;
        let source = |input: &Input| -> Result<Source<'a>> {
            Ok(match input {
                Input::Time => Source::Time,
                Input::Step => Source::Constant(run.dt),
                Input::Position(j) => Source::Samples(&run.q[*j]),
                Input::Velocity(j) => Source::Samples(&run.dq[*j]),
                Input::SharpVelocity(j) => Source::Samples(run.friction_dq(*j)),
                Input::Acceleration(j) => Source::Samples(&run.ddq[*j]),
                Input::Load(j) => Source::Samples(&run.model.as_deref().ok_or_else(no_load)?.rigid[*j]),
                Input::Channel { name, joint } => Source::Samples(channel(at.robot, run, name, *joint)?),
                Input::Memory(i) => Source::Memory(*i),
                Input::Shape(i) => Source::Constant(shapes[*i]),
            })
        };
        self.programs.inputs.iter().map(source).collect()
    }

    /// The memory at every sample of the run, one sample after the other.
    fn memory(
        &self,
        script: &EffectScript,
        run: &Run,
        sources: &[Source<'_>],
        traces: &Traces,
        clock: &mut Clock<'_>,
    ) -> Result<Arc<Vec<f64>>> {
        let first: Vec<f64> = script.about().memory.iter().map(|m| m.1).collect();
        if first.is_empty() {
            return Ok(Arc::default());
        }
        let key = (self.joint, fingerprint(run, sources));
        if let Some(known) = traces.find(&key) {
            return Ok(known);
        }
        let width = first.len();
        let room_needed = width.saturating_mul(size_of::<f64>() * run.samples());
        if room_needed > MOST_BYTES {
            let (line, column) = self.programs.place_of_memory();
            return Err(too_much_memory(width, run).at(line, column));
        }
        let (mut inputs, mut room) = (vec![0.0; sources.len()], Vec::new());
        let mut all = Vec::with_capacity(width * run.samples());
        let mut now = first;
        for k in 0..run.samples() {
            if k > 0 {
                fill(&mut inputs, sources, run, k, &all[(k - 1) * width..]);
                self.programs.remember(&inputs, &mut room, &mut now, clock)?;
            }
            all.extend_from_slice(&now);
        }
        let all = Arc::new(all);
        traces.keep(key, all.clone());
        Ok(all)
    }

    /// What the run has not that the script asks for.
    pub(super) fn lacks(&self, robot: &Robot, run: &Run) -> Option<String> {
        self.programs.inputs.iter().find_map(|input| match input {
            Input::Channel { name, joint } => {
                channel(robot, run, name, *joint).err().map(|e| e.message().to_string())
            }
            _ => None,
        })
    }
}

impl Traces {
    fn find(&self, key: &Key) -> Option<Arc<Vec<f64>>> {
        let kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        kept.iter().find(|(known, _)| known == key).map(|(_, trace)| trace.clone())
    }

    fn keep(&self, key: Key, trace: Arc<Vec<f64>>) {
        let mut kept = self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let size = |trace: &Arc<Vec<f64>>| trace.len() * size_of::<f64>();
        let mut total: usize = kept.iter().map(|(_, trace)| size(trace)).sum::<usize>() + size(&trace);
        while !kept.is_empty() && (kept.len() >= KEPT || total > MOST_BYTES) {
            total -= size(&kept.remove(0).1);
        }
        kept.push((key, trace));
    }
}

fn fill(inputs: &mut [f64], sources: &[Source<'_>], run: &Run, k: usize, memory: &[f64]) {
    for (input, source) in inputs.iter_mut().zip(sources) {
        *input = match source {
            Source::Samples(column) => column[k],
            Source::Time => k as f64 * run.dt,
            Source::Constant(value) => *value,
            Source::Memory(i) => memory[*i],
        };
    }
}

fn fingerprint(run: &Run, sources: &[Source<'_>]) -> Vec<u64> {
    let mut bits = vec![run.samples() as u64, run.dt.to_bits()];
    for source in sources {
        match source {
            Source::Samples(column) => bits.extend(column.iter().step_by(EVERY).map(|x| x.to_bits())),
            Source::Constant(value) => bits.push(value.to_bits()),
            Source::Time | Source::Memory(_) => {}
        }
    }
    bits
}

fn channel<'a>(robot: &Robot, run: &'a Run, name: &str, joint: usize) -> Result<&'a [f64]> {
    let own =
        [format!("{name}{}", joint + 1), format!("{name}_{}", robot.joints[joint].name), name.to_string()];
    own.iter().find_map(|n| run.channels.get(n)).map(Vec::as_slice).ok_or_else(|| {
        let known: Vec<&str> = run.channels.keys().map(String::as_str).collect();
        let known = if known.is_empty() { "no channels".to_string() } else { known.join(", ") };
        Error::new(format!("the log has no channel `{name}` or `{}`", own[0]))
            .help(format!("`{}` has {known}", run.name))
    })
}

fn too_much_memory(width: usize, run: &Run) -> Error {
    Error::new(format!(
        "the script needs more than 256 MB: it remembers {width} numbers at each of {} samples",
        run.samples()
    ))
    .help("remember less, or give a shorter log")
}

fn no_load() -> Error {
    Error::new("this effect depends on the torque of the rigid links, which is not known here")
        .help("fit rigid_body together with it")
}

fn not_a_number(script: &EffectScript, at: &Stretch<'_>, joint: usize, k: usize, parameter: usize) -> Error {
    let symbol = &script.about().parameters[parameter].symbol;
    Error::new(format!(
        "the column of `{symbol}` is not a finite number for joint `{}` at t = {} s",
        at.robot.joints[joint].name,
        k as f64 * at.run.dt
    ))
    .in_file(script.file())
    .help("a square root, logarithm or division goes wrong, or the memory grows without end; guard it by `max` or `if`")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_run_is_known_by_what_the_memory_depends_on() {
        let run = Run { dt: 0.1, q: vec![vec![0.0, 1.0]], ..Run::default() };
        let column = [0.5, 0.25];
        let with = |value| fingerprint(&run, &[Source::Samples(&column), Source::Constant(value)]);
        assert_eq!(with(1.0), with(1.0));
        assert_ne!(with(1.0), with(2.0));
    }
}
