//! What is looked up: the page and its modules, the state, pictures, files.

use axum::extract::rejection::QueryRejection;
use axum::extract::{Path, Query, State};
use axum::http::StatusCode;
use axum::http::header::{CONTENT_DISPOSITION, CONTENT_TYPE};
use axum::response::{IntoResponse, Response};
use serde::Deserialize;

use super::{Shared, reply};
use crate::error::Error;
use crate::report::page::modules;
use crate::workbench::page::FILES;
use crate::workbench::pictures::{Pair, Shown};
use crate::workbench::region::{self, Marked};
use crate::workbench::{files, state as view};

/// The page.
pub(super) async fn index() -> Response {
    own("bench.html")
}

/// A file of the page's own.
pub(super) async fn own_file(Path(name): Path<String>) -> Response {
    own(&name)
}

fn own(name: &str) -> Response {
    match FILES.iter().find(|(file, _, _)| *file == name) {
        Some((_, kind, text)) => ([(CONTENT_TYPE, *kind)], *text).into_response(),
        None => missing(),
    }
}

/// A module of the report's page, as it is.
pub(super) async fn report_file(Path(name): Path<String>) -> Response {
    let found = modules().find(|(file, _)| *file == name);
    match found {
        Some((file, text)) if file.ends_with(".css") => {
            ([(CONTENT_TYPE, "text/css; charset=utf-8")], text).into_response()
        }
        Some((_, text)) => ([(CONTENT_TYPE, "text/javascript; charset=utf-8")], text).into_response(),
        None => missing(),
    }
}

/// Whatever else is asked for.
pub(super) async fn nothing() -> Response {
    missing()
}

fn missing() -> Response {
    reply::failed(StatusCode::NOT_FOUND, &Error::new("there is no such thing here"))
}

/// The whole state.
pub(super) async fn state(State(shared): State<Shared>) -> Response {
    reply::apart(move || reply::document(&view::of(&shared.bench))).await
}

#[derive(Debug, Default, Deserialize)]
pub(super) struct PairQuery {
    step: Option<usize>,
    against: Option<usize>,
}

/// The data of the pictures.
pub(super) async fn page(
    State(shared): State<Shared>,
    query: Result<Query<PairQuery>, QueryRejection>,
) -> Response {
    let query = match query {
        Ok(Query(query)) => query,
        Err(e) => return reply::failed(StatusCode::BAD_REQUEST, &Error::new(e.body_text())),
    };
    reply::apart(move || {
        let pair = Pair { step: query.step, against: query.against };
        match Shown::of(&shared.bench, pair) {
            Ok(shown) => reply::of(shown.page()),
            Err(error) => reply::failed(StatusCode::NOT_FOUND, &error),
        }
    })
    .await
}

/// What is in a part of the data.
pub(super) async fn region(
    State(shared): State<Shared>,
    marked: Result<Query<Marked>, QueryRejection>,
) -> Response {
    match marked {
        Ok(Query(marked)) => reply::apart(move || reply::of(region::read(&shared.bench, &marked))).await,
        Err(e) => reply::failed(StatusCode::BAD_REQUEST, &Error::new(e.body_text())),
    }
}

/// A file to take away.
pub(super) async fn file(State(shared): State<Shared>, Path(name): Path<String>) -> Response {
    reply::apart(move || match files::take(&shared.bench, &name) {
        Ok((kind, content)) => {
            let attached = format!("attachment; filename=\"{name}\"");
            let headers = [(CONTENT_TYPE, kind.to_string()), (CONTENT_DISPOSITION, attached)];
            (headers, content).into_response()
        }
        Err(error) => reply::failed(StatusCode::NOT_FOUND, &error),
    })
    .await
}
