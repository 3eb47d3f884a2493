//! Connections. One that has shown the cookie may stay; strangers are few and do not stay long, so that nothing
//! else on this machine can keep the browser out.

use std::collections::BTreeMap;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};
use std::time::{Duration, Instant};

use axum::{Extension, Router};
use hyper::server::conn::http1;
use hyper_util::rt::{TokioIo, TokioTimer};
use hyper_util::service::TowerToHyperService;
use tokio::net::{TcpListener, TcpStream};
use tokio::task::AbortHandle;

/// Connections at once that have not shown the cookie; one more closes the oldest.
const MOST_STRANGERS: usize = 16;
/// Time that a connection has to show the cookie.
const PATIENCE: Duration = Duration::from_secs(10);
/// Time between two looks for strangers that have had their time.
const LOOK: Duration = Duration::from_secs(1);
/// Time that a known browser has for the head of its next request.
const NEXT_HEAD: Duration = Duration::from_secs(60);
/// Pause where the system gives no connection.
const PAUSE: Duration = Duration::from_millis(50);

/// Connections that have not shown the cookie, by number: the oldest comes first.
#[derive(Default)]
struct Strangers {
    all: Mutex<(u64, BTreeMap<u64, Stranger>)>,
}

struct Stranger {
    since: Instant,
    connection: AbortHandle,
}

/// The connection that a request came by.
#[derive(Clone)]
pub(super) struct Guest {
    number: u64,
    strangers: Arc<Strangers>,
}

impl Guest {
    /// It has shown the cookie, and may stay.
    pub(super) fn is_known(&self) {
        self.strangers.lock().1.remove(&self.number);
    }
}

impl Strangers {
    fn lock(&self) -> MutexGuard<'_, (u64, BTreeMap<u64, Stranger>)> {
        self.all.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Serves a connection that has shown nothing yet.
    fn admit(self: &Arc<Self>, stream: TcpStream, router: &Router) {
        let mut all = self.lock();
        if all.1.len() >= MOST_STRANGERS {
            close_oldest(&mut all.1);
        }
        all.0 += 1;
        let guest = Guest { number: all.0, strangers: self.clone() };
        let number = guest.number;
        let connection = tokio::spawn(converse(stream, router.clone(), guest)).abort_handle();
        all.1.insert(number, Stranger { since: Instant::now(), connection });
    }

    /// Closes the connections that have had their time.
    fn close_late(&self) {
        self.lock().1.retain(|_, stranger| {
            let in_time = stranger.since.elapsed() < PATIENCE;
            if !in_time {
                stranger.connection.abort();
            }
            in_time
        });
    }
}

fn close_oldest(all: &mut BTreeMap<u64, Stranger>) {
    if let Some((_, oldest)) = all.pop_first() {
        oldest.connection.abort();
    }
}

/// Takes connections in as long as the process lives. No trouble of the system's ends that: where it has no
/// descriptors left, the oldest stranger gives its own.
pub(super) async fn serve(listener: TcpListener, router: Router) {
    let strangers = Arc::new(Strangers::default());
    let watched = strangers.clone();
    tokio::spawn(async move {
        loop {
            tokio::time::sleep(LOOK).await;
            watched.close_late();
        }
    });
    loop {
        match listener.accept().await {
            Ok((stream, _)) => {
                strangers.admit(stream, &router);
                // What it has sent already is read before the next one can close it.
                tokio::task::yield_now().await;
            }
            // The other side went away before it was taken in.
            Err(e) if of_connection(e.kind()) => {}
            Err(_) => {
                close_oldest(&mut strangers.lock().1);
                tokio::time::sleep(PAUSE).await;
            }
        }
    }
}

fn of_connection(kind: std::io::ErrorKind) -> bool {
    use std::io::ErrorKind::{ConnectionAborted, ConnectionRefused, ConnectionReset, Interrupted};
    matches!(kind, ConnectionAborted | ConnectionRefused | ConnectionReset | Interrupted)
}

/// Requests and answers of one connection, until either side ends it.
async fn converse(stream: TcpStream, router: Router, guest: Guest) {
    let gone = guest.clone();
    let service = TowerToHyperService::new(router.layer(Extension(guest)));
    let mut http = http1::Builder::new();
    http.timer(TokioTimer::new()).header_read_timeout(NEXT_HEAD);
    // How it ended is nobody's concern: whoever is gone cannot be told.
    let _ = http.serve_connection(TokioIo::new(stream), service).await;
    gone.is_known();
}
