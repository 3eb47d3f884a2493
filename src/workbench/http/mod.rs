//! The page and its data over HTTP, for one browser on this machine.

mod actions;
mod body;
mod door;
mod events;
mod listen;
mod reply;
mod routes;
mod upload;

pub(super) use door::Door;

use std::net::TcpListener;
use std::sync::Arc;

use axum::Router;
use axum::extract::DefaultBodyLimit;
use axum::middleware::from_fn_with_state;
use axum::routing::{get, post};

use super::bench::Bench;
use crate::error::{Error, Result};

/// Largest body of a request that is no upload [bytes].
const LARGEST_BODY: usize = 1 << 20;

/// What every request is given.
#[derive(Clone)]
struct Shared {
    bench: Arc<Bench>,
    door: Arc<Door>,
    /// Tabs that listen.
    listeners: Arc<tokio::sync::Semaphore>,
}

/// Tabs that may listen at once.
const MOST_LISTENERS: usize = 32;

/// Serves the page until the process ends.
///
/// # Errors
/// When the system does not let it.
pub(super) fn serve(bench: Arc<Bench>, listener: TcpListener, door: Door) -> Result<()> {
    let trouble = |e: std::io::Error| Error::new(format!("cannot serve the page: {e}"));
    let listeners = Arc::new(tokio::sync::Semaphore::new(MOST_LISTENERS));
    let shared = Shared { bench, door: Arc::new(door), listeners };
    let runtime = tokio::runtime::Builder::new_current_thread().enable_all().build().map_err(trouble)?;
    listener.set_nonblocking(true).map_err(trouble)?;
    runtime.block_on(async {
        let listener = tokio::net::TcpListener::from_std(listener).map_err(trouble)?;
        listen::serve(listener, router(shared)).await;
        Ok(())
    })
}

fn router(shared: Shared) -> Router {
    let actions = Router::new()
        .route("/api/remove", post(actions::remove))
        .route("/api/role", post(actions::role))
        .route("/api/columns", post(actions::columns))
        .route("/api/model", post(actions::model))
        .route("/api/add", post(actions::add))
        .route("/api/undo", post(actions::undo))
        .route("/api/show", post(actions::show))
        .route("/api/diagnose", post(actions::diagnose))
        .route("/api/stop", post(actions::stop))
        .route("/api/constraints", post(actions::constraints))
        .route("/api/retrieve", post(actions::retrieve))
        .route("/api/script/check", post(actions::check_script))
        .route("/api/script/save", post(actions::save_script));
    Router::new()
        .route("/", get(routes::index))
        .route("/bench/{name}", get(routes::own_file))
        .route("/page/{name}", get(routes::report_file))
        .route("/api/state", get(routes::state))
        .route("/api/page", get(routes::page))
        .route("/api/region", get(routes::region))
        .route("/api/file/{name}", get(routes::file))
        .route("/api/events", get(events::stream))
        .route("/api/upload", post(upload::take).layer(DefaultBodyLimit::disable()))
        .merge(actions)
        .fallback(routes::nothing)
        .layer(DefaultBodyLimit::max(LARGEST_BODY))
        .layer(from_fn_with_state(shared.clone(), door::guard))
        .with_state(shared)
}
