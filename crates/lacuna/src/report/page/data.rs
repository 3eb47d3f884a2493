//! What stands in the page as JSON: the numbers of the answer, and series as base64 of 32-bit floats.

use std::collections::BTreeMap;

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde::Serialize;
use serde_json::Value;

use super::Page;
use crate::effects::CATALOGUE;
use crate::error::{Error, Result};
use crate::report::pictures::{EffectShare, Partial, Pictures, Role, Trace, envelope};

/// Bytes that all series together may take; longer ones are kept as envelopes.
const BUDGET: usize = 2_500_000;
/// Stretches of one log at least: as many as a screen has columns.
const LEAST_STRETCHES: usize = 2_000;

/// Everything the page's script reads.
#[derive(Serialize)]
pub(super) struct Data {
    lacuna: &'static str,
    title: String,
    verdict: Vec<String>,
    diagnosis: Value,
    report: Value,
    pictures: Option<PicturesJson>,
    /// Parameters that data and constraints leave open.
    open: Vec<String>,
    /// Title, text and equation of every effect of the catalogue.
    catalogue: BTreeMap<&'static str, [&'static str; 3]>,
    glossary: Value,
}

impl Data {
    pub fn of(page: &Page<'_>) -> Result<Self> {
        let catalogue =
            CATALOGUE.iter().map(|e| (e.about.name, [e.about.title, e.about.text, e.about.equation]));
        let open = page.report.and_then(|r| r.intervals.as_deref()).unwrap_or_default().iter();
        Ok(Self {
            lacuna: env!("CARGO_PKG_VERSION"),
            title: page.title.to_string(),
            verdict: page.verdict(),
            diagnosis: without_timing(value(&page.diagnosis)?),
            report: without_diagnosis(without_timing(value(&page.report)?)),
            pictures: page.pictures.map(PicturesJson::of),
            open: open.filter(|i| i.is_open()).map(|i| i.parameter.clone()).collect(),
            catalogue: catalogue.collect(),
            glossary: serde_json::from_str(super::GLOSSARY).map_err(|e| trouble(&e))?,
        })
    }

    /// As JSON.
    pub fn value(&self) -> Result<Value> {
        value(self)
    }

    /// As text that ends no script element and opens no comment, whatever names it holds.
    pub fn text(&self) -> Result<String> {
        let text = serde_json::to_string(self).map_err(|e| trouble(&e))?;
        Ok(text
            .replace('<', "\\u003c")
            .replace('>', "\\u003e")
            .replace('&', "\\u0026")
            .replace('\u{2028}', "\\u2028")
            .replace('\u{2029}', "\\u2029"))
    }
}

fn value(of: &impl Serialize) -> Result<Value> {
    serde_json::to_value(of).map_err(|e| trouble(&e))
}

fn trouble(e: &serde_json::Error) -> Error {
    Error::new(format!("the page cannot be written: {e}"))
}

/// A report's diagnosis stands beside it.
fn without_diagnosis(mut of: Value) -> Value {
    if let Value::Object(fields) = &mut of {
        fields.remove("diagnosis");
    }
    of
}

/// The same input gives the same page: what the wall clock said stays out.
fn without_timing(mut of: Value) -> Value {
    if let Value::Object(fields) = &mut of {
        fields.remove("timing");
    }
    of
}

/// Base64 of 32-bit floats, little-endian.
#[derive(Serialize)]
#[serde(transparent)]
struct Floats(String);

impl Floats {
    fn of(values: impl Iterator<Item = f64>) -> Self {
        let bytes: Vec<u8> = values.flat_map(|x| (x as f32).to_le_bytes()).collect();
        Self(STANDARD.encode(bytes))
    }
}

/// A series: every value, or the envelope of stretches of `every` rows.
#[derive(Serialize)]
struct Series {
    every: usize,
    low: Floats,
    #[serde(skip_serializing_if = "Option::is_none")]
    high: Option<Floats>,
}

impl Series {
    fn of(values: &[f64], most: usize) -> Self {
        let small = envelope(values, most);
        let high = (small.every > 1).then(|| Floats::of(small.high.iter().copied()));
        Self { every: small.every, low: Floats::of(small.low.into_iter()), high }
    }

    fn all(columns: &[Vec<f64>], most: usize) -> Vec<Self> {
        columns.iter().map(|c| Self::of(c, most)).collect()
    }
}

/// How many stretches the series of one log may have so that all fit into the page.
fn stretches(p: &Pictures) -> usize {
    let of_log = |t: &Trace| {
        let (joints, models) = (p.joints.len(), p.models.len());
        let (series, points) = (joints * (1 + 2 * models), joints * (4 + models) + t.channels.len());
        // Four bytes are six letters of base64, nearly; an envelope has two numbers.
        6 * (2 * series + points)
    };
    (BUDGET / p.traces.iter().map(of_log).sum::<usize>().max(1)).max(LEAST_STRETCHES)
}

#[derive(Serialize)]
pub(super) struct PicturesJson {
    joints: Vec<[String; 3]>,
    models: Vec<(String, bool)>,
    traces: Vec<TraceJson>,
    effects: Vec<EffectJson>,
    ranking: Vec<RankedJson>,
    climb: Value,
}

/// Series of one log for pictures over time, and values at single rows for heat maps.
#[derive(Serialize)]
struct TraceJson {
    name: String,
    role: &'static str,
    start_s: f64,
    dt_s: f64,
    rows: usize,
    measured: Vec<Series>,
    models: Vec<Vec<Series>>,
    residuals: Vec<Vec<Series>>,
    /// Every so-many-th row, for heat maps.
    points: Points,
}

#[derive(Serialize)]
struct Points {
    every: usize,
    q: Vec<Floats>,
    dq: Vec<Floats>,
    ddq: Vec<Floats>,
    load: Vec<Floats>,
    channels: BTreeMap<String, Floats>,
    residuals: Vec<Vec<Floats>>,
}

#[derive(Serialize)]
struct EffectJson {
    effect: String,
    found: bool,
    joint: usize,
    partials: Vec<PartialJson>,
}

#[derive(Serialize)]
struct PartialJson {
    variable: String,
    unit: String,
    at: Floats,
    mean: Floats,
    low: Floats,
    high: Floats,
    curve: Floats,
    rows: Vec<usize>,
}

#[derive(Serialize)]
struct RankedJson {
    effect: String,
    joint: Option<String>,
    symbols: Vec<String>,
    gain_percent: f64,
    usefulness: f64,
    z: f64,
    rms: [f64; 2],
    rms_joint: String,
    passes: bool,
}

impl PicturesJson {
    fn of(p: &Pictures) -> Self {
        let ranked = |r: &crate::report::pictures::Ranked| RankedJson {
            effect: r.effect.clone(),
            joint: r.joint.clone(),
            symbols: r.symbols.clone(),
            gain_percent: r.gain_percent,
            usefulness: r.usefulness,
            z: r.z,
            rms: r.rms,
            rms_joint: r.rms_joint.clone(),
            passes: r.passes,
        };
        let most = stretches(p);
        Self {
            joints: p.joints.iter().map(|j| [j.name.clone(), j.position.into(), j.torque.into()]).collect(),
            models: p.models.iter().map(|m| (m.label.clone(), m.held_out)).collect(),
            traces: p.traces.iter().map(|t| TraceJson::of(t, p.models.len(), most)).collect(),
            effects: p.effects.iter().map(EffectJson::of).collect(),
            ranking: p.ranking.iter().map(ranked).collect(),
            climb: serde_json::to_value(&p.climb).unwrap_or(Value::Null),
        }
    }
}

impl TraceJson {
    fn of(t: &Trace, models: usize, most: usize) -> Self {
        let residuals: Vec<Vec<Vec<f64>>> = (0..models).map(|m| t.residual(m)).collect();
        let role = match t.role {
            Role::Fitted => "fitted",
            Role::Reference => "reference, fitted",
            Role::NeverFitted => "never fitted",
        };
        Self {
            name: t.name.clone(),
            role,
            start_s: t.rows.start,
            dt_s: t.rows.dt,
            rows: t.rows.count,
            measured: Series::all(&t.measured, most),
            models: t.models.iter().map(|m| Series::all(m, most)).collect(),
            residuals: residuals.iter().map(|r| Series::all(r, most)).collect(),
            points: Points::of(t, &residuals, most),
        }
    }
}

impl Points {
    fn of(t: &Trace, residuals: &[Vec<Vec<f64>>], most: usize) -> Self {
        let every = t.rows.count.div_ceil(most).max(1);
        let pick = |column: &Vec<f64>| Floats::of(column.iter().copied().step_by(every));
        let all = |columns: &[Vec<f64>]| -> Vec<Floats> { columns.iter().map(pick).collect() };
        Self {
            every,
            q: all(&t.q),
            dq: all(&t.dq),
            ddq: all(&t.ddq),
            load: all(&t.measured),
            channels: t.channels.iter().map(|(name, column)| (name.clone(), pick(column))).collect(),
            residuals: residuals.iter().map(|r| all(r)).collect(),
        }
    }
}

impl EffectJson {
    fn of(e: &EffectShare) -> Self {
        Self {
            effect: e.effect.clone(),
            found: e.found,
            joint: e.joint,
            partials: e.partials.iter().map(PartialJson::of).collect(),
        }
    }
}

impl PartialJson {
    fn of(p: &Partial) -> Self {
        let of = |value: fn(&crate::report::pictures::Bin) -> f64| Floats::of(p.bins.iter().map(value));
        Self {
            variable: p.variable.clone(),
            unit: p.unit.clone(),
            at: of(|b| b.at),
            mean: of(|b| b.mean),
            low: of(|b| b.low),
            high: of(|b| b.high),
            curve: of(|b| b.curve),
            rows: p.bins.iter().map(|b| b.rows).collect(),
        }
    }
}
