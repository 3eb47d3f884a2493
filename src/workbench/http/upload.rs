//! Files that are dropped into the page: kept under names of ours, within limits, piece by piece.

use std::fs::File;
use std::io::Write;
use std::path::Path;

use axum::body::Body;
use axum::extract::{Query, State};
use axum::http::StatusCode;
use axum::response::Response;
use serde::Deserialize;
use serde_json::json;
use tokio_stream::StreamExt;

use super::{Shared, reply};
use crate::error::{Error, Result};
use crate::log::ColumnMap;
use crate::model_file::ModelFile;
use crate::robot::Robot;
use crate::text;
use crate::text::output::{Output, Temporary};
use crate::workbench::bench::Bench;
use crate::workbench::inputs::{add_log, first};
use crate::workbench::study::{RobotFile, Role, Root};
use crate::workbench::work::Job;

/// Largest robot, map or model [bytes].
const SMALL: u64 = 4 << 20;
/// Largest log [bytes].
const LARGE: u64 = 1 << 30;
/// Logs of a study at most.
const MOST_LOGS: usize = 16;
/// Longest name that is shown.
const LONGEST_NAME: usize = 120;

/// What a file is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(super) enum Kind {
    Robot,
    Log,
    Validate,
    Model,
    Map,
}

/// What is said of a file beside its content.
#[derive(Debug, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct About {
    kind: Kind,
    #[serde(default)]
    name: String,
}

/// Takes a file in.
pub(super) async fn take(
    State(shared): State<Shared>,
    about: Result<Query<About>, axum::extract::rejection::QueryRejection>,
    body: Body,
) -> Response {
    let Ok(Query(about)) = about else {
        let error = Error::new("what kind of file is it?").help("kind=robot, log, validate, model or map");
        return reply::failed(StatusCode::BAD_REQUEST, &error);
    };
    if shared.bench.is_retrieving() {
        return super::actions::busy();
    }
    let logs = shared.bench.study().logs.len();
    if matches!(about.kind, Kind::Log | Kind::Validate) && logs >= MOST_LOGS {
        let error = Error::new(format!("the study has {MOST_LOGS} logs already")).help("remove one first");
        return reply::failed(StatusCode::PAYLOAD_TOO_LARGE, &error);
    }
    let limit = if matches!(about.kind, Kind::Log | Kind::Validate) { LARGE } else { SMALL };
    let place = match receive(&shared.bench.output(), body, limit).await {
        Ok(place) => place,
        Err((status, error)) => return reply::failed(status, &error),
    };
    let bench = shared.bench.clone();
    reply::apart(move || {
        let kept = keep(&bench, &about, place.path());
        // What was not kept is of no use to anybody.
        drop(place);
        reply::of(kept.map(|file| json!({"version": bench.changed(), "file": file})))
    })
    .await
}

/// Writes the body to a file in the folder.
async fn receive(output: &Output, body: Body, limit: u64) -> Result<Temporary, (StatusCode, Error)> {
    let trouble = |e: std::io::Error| {
        (StatusCode::INTERNAL_SERVER_ERROR, Error::new(format!("cannot write the file: {e}")))
    };
    let (mut file, place) = output.temporary("upload").map_err(|e| (StatusCode::INTERNAL_SERVER_ERROR, e))?;
    let mut pieces = body.into_data_stream();
    let mut size = 0_u64;
    while let Some(piece) = pieces.next().await {
        let piece =
            piece.map_err(|e| (StatusCode::BAD_REQUEST, Error::new(format!("the upload broke off: {e}"))))?;
        size += piece.len() as u64;
        if size > limit {
            let error = Error::new(format!("the file is larger than {} MB", limit >> 20));
            return Err((StatusCode::PAYLOAD_TOO_LARGE, error.help("name it on the command line instead")));
        }
        file.write_all(&piece).map_err(trouble)?;
    }
    if size == 0 {
        return Err((StatusCode::UNPROCESSABLE_ENTITY, Error::new("the file is empty")));
    }
    Ok(place)
}

/// Gives a file its place and its part in the study.
fn keep(bench: &Bench, about: &About, place: &Path) -> Result<String> {
    let shown: String = about.name.chars().filter(|c| !c.is_control()).take(LONGEST_NAME).collect();
    let output = bench.output();
    let said = |e: Error| e.in_file(if shown.is_empty() { "the file" } else { &shown });
    match about.kind {
        Kind::Robot => robot(bench, place, &output).map_err(said),
        Kind::Log | Kind::Validate => {
            let role = if about.kind == Kind::Log { Role::Fit } else { Role::Validate };
            log(bench, place, &output, &shown, role)
        }
        Kind::Map => {
            let map = text::read(place).map_err(said)?;
            ColumnMap::parse(&map).map_err(said)?;
            let mut study = bench.study();
            study.columns = Some(map);
            bench.renew(study);
            Ok("columns.ron".to_string())
        }
        Kind::Model => {
            let model = ModelFile::parse(&text::read(place).map_err(said)?).map_err(said)?;
            let name = output.first_free(numbered("start_model", "ron"), &[]);
            output.keep(place, &name)?;
            bench.ask(Job::Begin(Root::Effects(model.effects)));
            Ok(name)
        }
    }
}

/// `stem.ending`, `stem_2.ending` and so on.
fn numbered(stem: &'static str, ending: &'static str) -> impl Iterator<Item = String> {
    std::iter::once(format!("{stem}.{ending}")).chain((2..).map(move |k| format!("{stem}_{k}.{ending}")))
}

fn robot(bench: &Bench, place: &Path, output: &Output) -> Result<String> {
    let text = text::read(place)?;
    let is_urdf = text.trim_start_matches('\u{feff}').trim_start().starts_with('<');
    let name = output.first_free(numbered("robot", if is_urdf { "urdf" } else { "ron" }), &[]);
    // Read under the name that it will have: what it is follows from that.
    let trial = output.temporary_folder("trial")?;
    let file = trial.path().join(&name);
    std::fs::rename(place, &file)
        .map_err(|e| Error::new(format!("cannot write here: {e}")).in_file(&file))?;
    Robot::open(&file)?;
    output.keep(&file, &name)?;
    let mut study = bench.study();
    study.robot = Some(RobotFile { path: study.folder.join(&name), robot: None, problem: None });
    // Models are of a robot: another one begins anew.
    study.steps = vec![first(Root::Classic)];
    (study.shown, study.against, study.retrieval) = (None, None, None);
    study.signals.widths.clear();
    bench.renew(study);
    Ok(name)
}

fn log(bench: &Bench, place: &Path, output: &Output, shown: &str, role: Role) -> Result<String> {
    let mut magic = [0_u8; 2];
    let packed = File::open(place).and_then(|mut f| std::io::Read::read_exact(&mut f, &mut magic)).is_ok()
        && magic == [0x1F, 0x8B];
    let mut study = bench.study();
    let ending = if packed { "csv.gz" } else { "csv" };
    let free = |k: &usize| !["csv", "csv.gz"].iter().any(|e| output.is_taken(&format!("log_{k}.{e}")));
    let number = (1..).find(free).unwrap_or(0);
    let file = format!("log_{number}.{ending}");
    output.keep(place, &file)?;
    let name = if shown.is_empty() { file.clone() } else { shown.to_string() };
    let path = study.folder.join(&file);
    add_log(&mut study, path, Some(name), role)?;
    bench.renew(study);
    Ok(file)
}
