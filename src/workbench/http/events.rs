//! What tabs are told as it happens: server-sent events.

use std::convert::Infallible;
use std::time::Duration;

use axum::extract::State;
use axum::http::StatusCode;
use axum::response::sse::{Event, KeepAlive, Sse};
use axum::response::{IntoResponse, Response};
use serde_json::{Value, json};
use tokio_stream::StreamExt;
use tokio_stream::wrappers::WatchStream;

use super::{Shared, reply};
use crate::error::Error;

/// Time between two messages on the same matter at least.
const PAUSE: Duration = Duration::from_millis(80);

/// Tells of new states, of progress and of a retrieval's best.
pub(super) async fn stream(State(shared): State<Shared>) -> Response {
    let Ok(seat) = shared.listeners.clone().try_acquire_owned() else {
        let error = Error::new("too many tabs show this study").help("close some of them");
        return reply::failed(StatusCode::TOO_MANY_REQUESTS, &error);
    };
    let states = WatchStream::new(shared.bench.versions()).map(|v| event("state", &json!({"version": v})));
    let jobs = WatchStream::new(shared.bench.job_events()).map(|v| event("job", &v)).throttle(PAUSE);
    let retrievals =
        WatchStream::from_changes(shared.bench.retrieval_events()).map(|v| event("retrieval", &v));
    let all = states.throttle(PAUSE).merge(jobs).merge(retrievals);
    // The seat is given back when the tab goes away.
    let all = all.map(move |event| {
        let _held = &seat;
        event
    });
    Sse::new(all).keep_alive(KeepAlive::new().interval(Duration::from_secs(15))).into_response()
}

fn event(name: &'static str, value: &Value) -> Result<Event, Infallible> {
    Ok(Event::default().event(name).data(value.to_string()))
}
