//! Answers as JSON.

use axum::http::StatusCode;
use axum::http::header::CONTENT_TYPE;
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};

use crate::error::{Error, Result};
use crate::workbench::state;

/// A JSON document.
pub(super) fn document(value: &Value) -> Response {
    body(StatusCode::OK, value)
}

/// An error, with what to do.
pub(super) fn failed(status: StatusCode, error: &Error) -> Response {
    body(status, &json!({"error": state::error(error)}))
}

/// The document, or an error of the user's.
pub(super) fn of(result: Result<Value>) -> Response {
    match result {
        Ok(value) => document(&value),
        Err(error) => failed(StatusCode::UNPROCESSABLE_ENTITY, &error),
    }
}

/// A document under another status.
pub(super) fn body(status: StatusCode, value: &Value) -> Response {
    (status, [(CONTENT_TYPE, "application/json")], value.to_string()).into_response()
}

/// Work that takes a while, away from the thread that serves.
pub(super) async fn apart(work: impl FnOnce() -> Response + Send + 'static) -> Response {
    tokio::task::spawn_blocking(work).await.unwrap_or_else(|_| {
        let error = Error::new("something in the program broke down").help("please report what you did");
        failed(StatusCode::INTERNAL_SERVER_ERROR, &error)
    })
}
