//! What the page is told of the study.

use serde_json::{Value, json};

use super::bench::Bench;
use super::study::{LogFile, Scan, Step, Study};
use super::{constraints, files, retrieve, work, written};
use crate::check::Severity;
use crate::diagnose::Missing;
use crate::effects::{CATALOGUE, RigidBody, Stage};
use crate::error::Error;
use crate::log::ColumnMap;
use crate::report::pictures::{JointUnits, Ranked};

/// Candidates that are listed at most.
const MOST: usize = 60;

/// The whole state.
pub(super) fn of(bench: &Bench) -> Value {
    let (version, job) = (bench.version(), bench.job());
    let study = bench.study();
    let shown = study.on_show();
    let against = study.against.filter(|id| shown.is_some() && study.step(*id).is_some_and(Step::is_there));
    let scan = shown.and_then(|s| s.scan.as_deref());
    json!({
        "version": version,
        "lacuna": env!("CARGO_PKG_VERSION"),
        "study": study.name,
        "folder": study.folder.display().to_string(),
        "robot": robot(&study),
        "logs": study.logs.iter().map(log).collect::<Vec<_>>(),
        "columns": columns(&study),
        "signals": signals(&study),
        "folds": shown.and_then(|s| s.fitted.as_ref()).map(|f| &f.folds),
        "steps": study.steps.iter().filter(|s| s.is_there()).map(step).collect::<Vec<_>>(),
        "shown": shown.map(|s| s.id),
        "against": against,
        "path": shown.map_or_else(Vec::new, |s| study.path(s.id)),
        "candidates": shown.map_or_else(Vec::new, candidates),
        "diagnosis": scan.map(|s| json!(s.diagnosis)),
        "verdict": scan.map_or(&[][..], |s| s.verdict.as_slice()),
        "catalogue": catalogue(&study),
        "job": job,
        "trouble": study.trouble.as_ref().map(error),
        "constraints": {"text": study.constraints, "problems": constraint_problems(&study)},
        "constraint_kinds": constraints::kinds(&study.folder, study.robot().map(std::convert::AsRef::as_ref)),
        "engine_kinds": retrieve::kinds(),
        "retrieval": retrieval(&study),
        "scripts": scripts(&study),
        "commands": written::commands(&study),
        "files": files::names(&study),
    })
}

/// An error as the page shows it.
pub(super) fn error(e: &Error) -> Value {
    let text = e.to_string();
    let help = text.split_once("\n  help: ").map(|(_, help)| help.to_string());
    let place = e.place();
    let file = place.map(|p| p.file.rsplit(['/', '\\']).next().unwrap_or_default()).filter(|f| !f.is_empty());
    json!({"text": e.brief(), "help": help, "file": file,
           "line": place.and_then(|p| p.line), "column": place.and_then(|p| p.column)})
}

/// The same as one of several problems.
pub(super) fn problem(e: &Error) -> Value {
    let mut one = error(e);
    one["severity"] = json!("error");
    one
}

fn robot(study: &Study) -> Value {
    let Some(file) = &study.robot else { return Value::Null };
    let name = file.path.file_name().map(|n| n.to_string_lossy().into_owned());
    let problems: Vec<Value> = file.problem.iter().map(problem).collect();
    let Some(robot) = &file.robot else {
        return json!({"name": null, "file": name, "joints": [], "remarks": [], "problems": problems});
    };
    let joint = |j: JointUnits| json!({"name": j.name, "position": j.position, "torque": j.torque});
    let remark = |r: &crate::robot::Remark| {
        r.line.map_or_else(|| r.text.clone(), |line| format!("line {line}: {}", r.text))
    };
    json!({
        "name": robot.name,
        "file": name,
        "joints": JointUnits::of(robot).into_iter().map(joint).collect::<Vec<_>>(),
        "gravity": [robot.gravity.x, robot.gravity.y, robot.gravity.z],
        "remarks": robot.remarks.iter().map(remark).collect::<Vec<_>>(),
        "problems": problems,
    })
}

fn log(log: &LogFile) -> Value {
    let seen = log.seen.clone().unwrap_or_default();
    let finding = |f: &crate::check::Finding| {
        json!({"severity": f.severity, "text": f.text, "remedy": f.remedy, "also_possible": f.also_possible,
               "error_percent": f.error_percent})
    };
    let findings = log.findings.as_deref();
    let defect = findings.is_some_and(|f| f.findings.iter().any(|f| f.severity == Severity::Defect));
    json!({
        "id": log.id,
        "name": log.name,
        "role": log.role,
        "read": log.seen.is_some(),
        "usable": log.seen.is_some() && seen.problem.is_none(),
        "rows": seen.rows,
        "seconds": seen.seconds,
        "rate_hz": seen.rate_hz,
        "dropped": seen.dropped,
        "columns": seen.columns,
        "sample": seen.sample,
        "problems": seen.problem.iter().map(problem).collect::<Vec<_>>(),
        "remarks": seen.remarks,
        "checked": findings.is_some(),
        "sound": findings.map(|_| !defect),
        "findings": findings.map_or_else(Vec::new, |f| f.findings.iter().map(finding).collect()),
        "suggested_map": findings.and_then(|f| f.column_map.as_ref()),
    })
}

fn columns(study: &Study) -> Value {
    let problems: Vec<Value> = study
        .columns
        .iter()
        .filter_map(|text| ColumnMap::parse(text).err())
        .map(|e| problem(&e.in_file("columns.ron")))
        .collect();
    json!({"text": study.columns, "problems": problems, "shipped": ColumnMap::ready().collect::<Vec<_>>()})
}

fn signals(study: &Study) -> Value {
    if study.on_show().is_none() {
        return Value::Null;
    }
    let (s, chosen) = (&study.signals.settings, study.signals.chosen);
    json!({
        "mode": s.mode.name(), "band_hz": s.band_hz, "position_cutoff_hz": s.position_cutoff_hz,
        "friction_cutoff_hz": s.friction_cutoff_hz, "velocity_from": format!("{:?}", s.velocity_from).to_lowercase(),
        "trim_s": s.trim_s, "sign_width": study.signals.widths, "chosen": chosen,
    })
}

fn step(step: &Step) -> Value {
    let numbers = &step.numbers;
    let joint = |j: &super::study::JointNumbers| {
        let percent = crate::report::finite(100.0 * j.held_out_rms / j.torque_rms);
        json!({"name": j.name, "torque_rms": j.torque_rms, "held_out_rms": j.held_out_rms,
               "repeat_floor_rms": j.repeat_floor_rms, "relative_error_percent": percent})
    };
    let mut effects: Vec<&str> = step.effects.iter().map(|e| e.about().name).collect();
    effects.dedup();
    let parameters = step.fitted.as_ref().map_or(&[][..], |f| f.model.parameters.as_slice());
    json!({
        "id": step.id,
        "parent": step.parent,
        "label": work::label(step),
        "added": step.added,
        "effects": effects,
        "friction": step.effects.iter().any(|e| e.about().stage == Stage::First),
        "fitted": step.fitted.is_some(),
        "held_out_percent": numbers.held_out_percent,
        "joints": numbers.joints.iter().map(joint).collect::<Vec<_>>(),
        "validation_percent": numbers.unseen_percent,
        "validation_rms": numbers.unseen_rms,
        "parameters": parameters,
        "ranked": step.ranking.is_some(),
        "scanned": step.scan.is_some(),
    })
}

/// Every effect that may be added.
fn catalogue(study: &Study) -> Vec<Value> {
    let own = written::candidates(study).unwrap_or_default();
    let shipped = CATALOGUE.iter().map(|entry| entry.about);
    shipped
        .chain(own.iter().map(|e| e.about()))
        .map(|a| json!({"name": a.name, "title": a.title, "text": a.text, "equation": a.equation, "example": a.example}))
        .collect()
}

/// What may be added to a step: what a search found, then what one scoring of the catalogue ranks.
fn candidates(step: &Step) -> Vec<Value> {
    let mut all = Vec::new();
    let mut named: Vec<(String, Vec<String>)> = Vec::new();
    if let Some(scan) = step.scan.as_deref() {
        let d = &scan.diagnosis;
        for (rank, list) in [("missing", &d.missing), ("minor", &d.minor)] {
            for m in list.iter().filter(|m| m.effect != RigidBody::ABOUT.name) {
                named.push((m.effect.clone(), m.joints.clone()));
                all.push(found(m, rank));
            }
        }
        all.extend(formulas(scan));
    }
    let is_named = |r: &Ranked| {
        let on = |joints: &[String]| r.joint.as_ref().map_or(joints.is_empty(), |j| joints.contains(j));
        named.iter().any(|(effect, joints)| *effect == r.effect && on(joints))
    };
    let ranking = step.ranking.as_deref().map_or(&[][..], Vec::as_slice);
    let scanned = step.scan.is_some();
    all.extend(ranking.iter().filter(|r| !is_named(r)).map(|r| ranked(r, scanned)));
    all.truncate(MOST);
    all
}

fn about(effect: &str) -> (String, String, String) {
    let known = CATALOGUE.iter().find(|e| e.about.name == effect).map(|e| e.about);
    let told = known.map(|a| (a.title.to_string(), a.equation.to_string(), a.text.to_string()));
    told.unwrap_or_else(|| ("an effect of your own".to_string(), String::new(), String::new()))
}

fn found(m: &Missing, rank: &str) -> Value {
    let (title, _, text) = about(&m.effect);
    let most = m.held_out_rms.iter().max_by(|a, b| (a.1[0] - a.1[1]).total_cmp(&(b.1[0] - b.1[1])));
    json!({
        "effect": m.effect, "title": title, "joints": m.joints, "rank": rank,
        "add": {"effect": m.effect, "joints": m.joints},
        "gain_percent": m.gain_percent, "z": m.z, "equation": m.equation, "about": text,
        "rms": most.map(|(_, rms)| rms), "rms_joint": most.map(|(joint, _)| joint),
        "parameters": m.parameters, "also_possible": m.also_possible, "where": m.place, "passes": true,
    })
}

/// Structure without a name that a formula expresses.
fn formulas(scan: &Scan) -> Vec<Value> {
    let all = scan.diagnosis.unexplained.iter().zip(&scan.proposed);
    all.filter_map(|(u, proposed)| {
        let (file, _) = proposed.as_ref()?;
        Some(json!({
            "effect": "formula", "title": "no effect of the catalogue: a formula that fits",
            "joints": [u.joint], "rank": "missing", "add": {"effect": file, "joints": [u.joint]},
            "gain_percent": u.gain_percent, "z": u.z, "equation": u.formula,
            "about": format!("the error of {} depends on {}", u.joint, u.depends_on.join(", ")),
            "rms": null, "rms_joint": null, "parameters": [], "also_possible": u.nearest, "passes": true,
        }))
    })
    .collect()
}

fn ranked(r: &Ranked, scanned: bool) -> Value {
    let (title, equation, text) = about(&r.effect);
    let joints: Vec<&String> = r.joint.iter().collect();
    // A full search has the last word on what is missing.
    let rank = if r.passes && !scanned { "missing" } else { "other" };
    json!({
        "effect": r.effect, "title": title, "joints": joints, "rank": rank,
        "add": {"effect": r.effect, "joints": joints},
        "gain_percent": r.gain_percent, "z": r.z, "equation": equation, "about": text,
        "rms": r.rms, "rms_joint": r.rms_joint, "parameters": [], "also_possible": [], "symbols": r.symbols,
        "passes": r.passes,
    })
}

fn constraint_problems(study: &Study) -> Vec<Value> {
    let robot = study.robot().map(std::convert::AsRef::as_ref);
    let wrong = constraints::parse(&study.constraints, &study.folder, robot).err();
    wrong.iter().map(|e| problem(&e.clone().in_file("constraints.ron"))).collect()
}

fn retrieval(study: &Study) -> Value {
    let Some(r) = &study.retrieval else { return Value::Null };
    let last = r.history.last();
    let part = |name: &str| r.report.as_ref().map_or(Value::Null, |report| report[name].clone());
    let results = r.report.as_ref().map_or_else(|| json!([]), |report| report["retrievals"].clone());
    json!({
        "running": r.running, "step": r.step, "engines": r.engines, "engine": r.engine,
        "objective": last.map(|h| h[1]), "violation": last.map(|h| h[2]),
        "history": r.history, "stopped": r.stopped,
        "results": if results.is_null() { json!([]) } else { results },
        "conflict": part("conflict"), "intervals": part("intervals"), "warnings": part("warnings"),
    })
}

fn scripts(study: &Study) -> Vec<Value> {
    let title = |script: &super::study::ScriptFile| {
        let line = script.text.lines().find_map(|l| l.trim().strip_prefix("//"));
        line.map_or_else(|| script.file.clone(), |l| l.trim_matches(['/', ' ']).to_string())
    };
    let one = |s: &super::study::ScriptFile| {
        json!({"file": s.file, "kind": s.kind, "title": title(s), "text": s.text, "proposed": s.proposed,
               "problems": []})
    };
    study.scripts.iter().map(one).collect()
}
