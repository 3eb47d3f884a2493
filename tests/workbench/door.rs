//! Connections that only take up room, and bodies that are none.

use std::io::{Read, Write};
use std::net::TcpStream;
use std::time::{Duration, Instant};

use super::client::Bench;
use super::data::Files;

/// Whether the other side has closed the connection, or does so in time.
fn is_closed(mut stream: &TcpStream, within: Duration) -> bool {
    stream.set_read_timeout(Some(within)).expect("a time");
    match stream.read(&mut [0; 64]) {
        Ok(read) => read == 0,
        Err(e) => !matches!(e.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut),
    }
}

#[cfg(unix)]
#[test]
fn idle_connections_keep_nobody_out() {
    let files = Files::new();
    let bench = Bench::open_with_files(&files, 64);
    // One after the other: what comes in later pushes out what came first.
    let strangers: Vec<TcpStream> = (0..100).map(|_| bench.connect()).collect();
    let bench = bench.enter();
    let mut tab = bench.listen();
    assert!(tab.next("state").is_some(), "the page is told what there is");
    let more: Vec<TcpStream> = (0..100).map(|_| bench.connect()).collect();
    let begun: Vec<TcpStream> = (0..100)
        .map(|_| {
            let mut stream = bench.connect();
            // It may be closed by the time this is sent.
            let _ = stream.write_all(b"GET / HTTP/1.1\r\nHost: ");
            stream
        })
        .collect();
    for _ in 0..20 {
        assert_eq!(bench.get("/api/state").status, 200);
    }
    assert_eq!(bench.post("/api/columns", "{}").status, 200);
    assert!(tab.next("state").is_some(), "the tab that listens was not pushed out");
    let closed = |all: &[TcpStream]| all.iter().filter(|s| is_closed(s, Duration::from_millis(20))).count();
    assert_eq!((closed(&strangers), closed(&more)), (100, 100));
    assert!(closed(&begun) >= 80, "few strangers at once");
}

#[test]
fn whoever_does_not_show_the_cookie_is_not_waited_for() {
    let files = Files::new();
    let bench = Bench::open(&files, &[]).enter();
    let mut tab = bench.listen();
    assert!(tab.next("state").is_some());
    let idle = bench.connect();
    let mut slow = bench.connect();
    slow.write_all(b"GET /api/state HTTP/1.1\r\nHost: 127.0.0.1\r\nX: ").expect("sends");
    let mut refused = bench.connect();
    write!(refused, "GET /api/state HTTP/1.1\r\nHost: {}\r\n\r\n", bench.host()).expect("sends");
    let mut head = [0; 12];
    refused.read_exact(&mut head).expect("an answer");
    assert_eq!(&head, b"HTTP/1.1 403");
    let start = Instant::now();
    for (name, mut stream) in [("idle", idle), ("slow", slow), ("refused", refused)] {
        let mut rest = Vec::new();
        stream.set_read_timeout(Some(Duration::from_secs(20))).expect("a time");
        let end = stream.read_to_end(&mut rest);
        let waited = end.as_ref().err().is_some_and(|e| {
            matches!(e.kind(), std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut)
        });
        assert!(!waited, "{name}: still open after {:?}", start.elapsed());
    }
    assert!(start.elapsed() > Duration::from_secs(5), "strangers have some time");
    assert_eq!(bench.post("/api/columns", "{}").status, 200);
    assert!(tab.next("state").is_some(), "a tab that listens stays");
}

#[test]
fn a_list_is_no_object() {
    let files = Files::new();
    let bench = Bench::open(&files, &[]).enter();
    assert_eq!(bench.post("/api/columns", r#"{"shipped": "libfranka"}"#).status, 200);
    let before = bench.get("/api/state").json();
    let actions = [
        "remove",
        "role",
        "columns",
        "model",
        "add",
        "undo",
        "show",
        "diagnose",
        "stop",
        "constraints",
        "retrieve",
        "script/check",
        "script/save",
    ];
    for action in actions {
        for body in ["[]", "[0]", "[null, null]", " [] ", "null", "\"\"", "0", ""] {
            let answer = bench.post(&format!("/api/{action}"), body);
            assert_eq!(answer.status, 400, "{action} {body}: {}", answer.text());
            let error = &answer.json()["error"];
            let says = error["text"].as_str().unwrap_or_default();
            assert!(body.is_empty() || says.contains("not a JSON object"), "{action} {body}: {error}");
        }
    }
    assert_eq!(bench.get("/api/state").json()["columns"], before["columns"], "the column map stays");
    assert!(!before["columns"].is_null());
    let long = "x".repeat(4096);
    let answer = bench.post("/api/model", &format!(r#"{{"model": "{long}"}}"#));
    assert!(answer.text().len() < 500, "{}", answer.text());
    let answer = bench.post("/api/model", &format!(r#"{{"{long}": 1}}"#));
    assert!(answer.status == 400 && answer.text().len() < 500, "{}", answer.text());
}
