//! What is asked for: changes of the study, and work on it.

use std::sync::Arc;

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::{IntoResponse, Response};
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::{Value, json};

use super::body::{Body, Object};
use super::{Shared, reply};
use crate::error::{Error, Result};
use crate::log::ColumnMap;
use crate::workbench::bench::Bench;
use crate::workbench::retrieve::Order;
use crate::workbench::scripts::{self, Draft};
use crate::workbench::study::{Addition, Role, Root};
use crate::workbench::work::Job;
use crate::workbench::{constraints as list, folder, scan};

/// The answer where a retrieval works on what would change.
pub(super) fn busy() -> Response {
    let error = Error::new("a retrieval is running").help("stop it first; its best so far is kept");
    reply::failed(StatusCode::CONFLICT, &error)
}

/// Reads the body and acts on it, unless a retrieval is running.
async fn act<T: DeserializeOwned + Send + 'static>(
    shared: Shared,
    body: Body<T>,
    act: impl FnOnce(&Arc<Bench>, T) -> Result<Value> + Send + 'static,
) -> Response {
    match body {
        Err(e) => e.into_response(),
        Ok(_) if shared.bench.is_retrieving() => busy(),
        Ok(Object(body)) => {
            reply::apart(move || {
                shared.bench.study().trouble = None;
                reply::of(act(&shared.bench, body).map(|mut answer| {
                    answer["version"] = json!(shared.bench.changed());
                    answer
                }))
            })
            .await
        }
    }
}

fn done() -> Result<Value> {
    Ok(json!({}))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct Nothing {}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct OfLog {
    log: usize,
}

/// Takes a log out of the study.
pub(super) async fn remove(State(shared): State<Shared>, body: Body<OfLog>) -> Response {
    act(shared, body, |bench, OfLog { log }| {
        let mut study = bench.study();
        let place = study.logs.iter().position(|l| l.id == log).ok_or_else(|| no_log(log))?;
        let gone = study.logs.remove(place);
        folder::discard(&study, &gone.path);
        if !study.is_ready() {
            (study.shown, study.against) = (None, None);
        }
        bench.renew(study);
        done()
    })
    .await
}

fn no_log(id: usize) -> Error {
    Error::new(format!("there is no log {id}"))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NewRole {
    log: usize,
    role: Role,
}

/// What a log is used for.
pub(super) async fn role(State(shared): State<Shared>, body: Body<NewRole>) -> Response {
    act(shared, body, |bench, NewRole { log, role }| {
        let mut study = bench.study();
        let own = study.logs.iter_mut().find(|l| l.id == log).ok_or_else(|| no_log(log))?;
        own.role = role;
        bench.renew(study);
        done()
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NewColumns {
    #[serde(default)]
    text: Option<String>,
    #[serde(default)]
    shipped: Option<String>,
}

/// Another column map, or none.
pub(super) async fn columns(State(shared): State<Shared>, body: Body<NewColumns>) -> Response {
    act(shared, body, |bench, new| {
        let text = match (new.text, new.shipped) {
            (Some(text), None) => {
                ColumnMap::parse(&text).map_err(|e| e.in_file("columns.ron"))?;
                Some(text)
            }
            (None, Some(name)) => {
                // A name, never a path.
                let known = ColumnMap::ready().any(|ready| ready == name);
                let map = known.then(|| ColumnMap::open(&name)).transpose()?;
                let map =
                    map.ok_or_else(|| Error::new(format!("there is no shipped column map `{name}`")))?;
                Some(crate::text::to_ron(&map)?)
            }
            (None, None) => None,
            (Some(_), Some(_)) => return Err(Error::new("give either `text` or `shipped`")),
        };
        let mut study = bench.study();
        study.columns = text;
        bench.renew(study);
        done()
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NewModel {
    model: String,
}

/// Another model to begin with.
pub(super) async fn model(State(shared): State<Shared>, body: Body<NewModel>) -> Response {
    act(shared, body, |bench, NewModel { model }| {
        let root = match model.as_str() {
            "rigid" => Root::Rigid,
            "classic" => Root::Classic,
            _ => return Err(Error::new(format!("there is no model `{model}`")).help("rigid or classic")),
        };
        bench.stop_search();
        bench.ask(Job::Begin(root));
        done()
    })
    .await
}

/// Adds an effect to the model on show.
pub(super) async fn add(State(shared): State<Shared>, body: Body<Addition>) -> Response {
    act(shared, body, |bench, addition| {
        if bench.study().on_show().is_none() {
            return Err(
                Error::new("there is no model to add an effect to").help("give a robot and a log first")
            );
        }
        // The search beside the model that was on show is of no more use.
        bench.stop_search();
        bench.ask(Job::Add(addition, true));
        done()
    })
    .await
}

/// Shows the model before the last addition.
pub(super) async fn undo(State(shared): State<Shared>, body: Body<Nothing>) -> Response {
    act(shared, body, |bench, _| {
        let mut study = bench.study();
        let parent = study.shown.and_then(|id| study.step(id)).and_then(|s| s.parent);
        let parent = parent.ok_or_else(|| Error::new("there is nothing to undo"))?;
        let before = study.step(parent).and_then(|s| s.parent);
        (study.shown, study.against) = (Some(parent), before);
        drop(study);
        turn_to(bench, parent)
    })
    .await
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NewShown {
    step: usize,
    #[serde(default)]
    against: Option<usize>,
}

/// Shows a model, alone or beside another.
pub(super) async fn show(State(shared): State<Shared>, body: Body<NewShown>) -> Response {
    act(shared, body, |bench, NewShown { step, against }| {
        let mut study = bench.study();
        for id in [Some(step), against].into_iter().flatten() {
            study.step(id).ok_or_else(|| Error::new(format!("there is no step {id}")))?;
        }
        let same = study.shown == Some(step);
        (study.shown, study.against) = (Some(step), against.filter(|a| *a != step));
        if same {
            return done();
        }
        drop(study);
        turn_to(bench, step)
    })
    .await
}

/// The folder follows what is on show, and so does the search.
fn turn_to(bench: &Bench, step: usize) -> Result<Value> {
    bench.stop_search();
    folder::save(&bench.study())?;
    bench.ask(Job::Look(step));
    done()
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NewSearch {
    #[serde(default)]
    auto: bool,
}

/// Searches beside the model on show; adds what is found if so.
pub(super) async fn diagnose(State(shared): State<Shared>, body: Body<NewSearch>) -> Response {
    act(shared, body, |bench, NewSearch { auto }| {
        let shown = bench.study().on_show().map(|s| s.id);
        let shown = shown.ok_or_else(|| Error::new("there is no model to search beside"))?;
        bench.auto.store(auto, std::sync::atomic::Ordering::SeqCst);
        scan::start(bench, shown)?;
        done()
    })
    .await
}

/// Stops whatever runs.
pub(super) async fn stop(State(shared): State<Shared>, body: Body<Nothing>) -> Response {
    if let Err(e) = body {
        return e.into_response();
    }
    shared.bench.stop();
    reply::document(&json!({"version": shared.bench.version()}))
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct NewText {
    text: String,
}

/// Another list of constraints.
pub(super) async fn constraints(State(shared): State<Shared>, body: Body<NewText>) -> Response {
    act(shared, body, |bench, NewText { text }| {
        let mut study = bench.study();
        let robot = study.robot().cloned();
        list::parse(&text, &study.folder, robot.as_deref()).map_err(|e| e.in_file("constraints.ron"))?;
        study.constraints = text;
        folder::save(&study)?;
        done()
    })
    .await
}

/// Retrieves link parameters for the model on show.
pub(super) async fn retrieve(State(shared): State<Shared>, body: Body<Order>) -> Response {
    act(shared, body, |bench, order| {
        order.written()?;
        if bench.study().on_show().is_none() {
            return Err(Error::new("there is no model to retrieve from").help("give a robot and a log first"));
        }
        bench.stop_search();
        bench.ask(Job::Retrieve(order));
        done()
    })
    .await
}

/// Says what a script means and what is wrong with it.
pub(super) async fn check_script(State(shared): State<Shared>, body: Body<Draft>) -> Response {
    match body {
        Ok(Object(draft)) => reply::apart(move || reply::of(scripts::check(&shared.bench, &draft))).await,
        Err(e) => e.into_response(),
    }
}

/// Keeps a script.
pub(super) async fn save_script(State(shared): State<Shared>, body: Body<Draft>) -> Response {
    let Object(draft) = match body {
        Ok(draft) => draft,
        Err(e) => return e.into_response(),
    };
    if shared.bench.is_retrieving() {
        return busy();
    }
    reply::apart(move || match scripts::save(&shared.bench, &draft) {
        Ok(Ok(file)) => {
            let version = shared.bench.changed();
            reply::document(&json!({"version": version, "file": file, "problems": []}))
        }
        Ok(Err(checked)) => {
            let first = checked["problems"][0].clone();
            let answer = json!({"error": first, "problems": checked["problems"]});
            reply::body(StatusCode::UNPROCESSABLE_ENTITY, &answer)
        }
        Err(error) => reply::failed(StatusCode::UNPROCESSABLE_ENTITY, &error),
    })
    .await
}
