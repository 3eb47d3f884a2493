//! The workbench over a real socket: who is let in, what rubbish does, what is kept.

#[path = "workbench/client.rs"]
mod client;
#[path = "workbench/data.rs"]
mod data;
#[path = "workbench/door.rs"]
mod door;

#[path = "workbench/owned.rs"]
mod owned;
#[path = "workbench/stop.rs"]
mod stop;
#[path = "workbench/work.rs"]
mod work;

use client::Bench;
use data::Files;

#[test]
fn the_token_is_good_for_one_browser_once() {
    let files = Files::new();
    let bench = Bench::open(&files, &[]);
    let without = bench.raw("GET / HTTP/1.1", &[], b"");
    assert_eq!(without.status, 403);
    assert!(without.text().contains("lacuna workbench") && !without.text().contains("bench.js"));
    assert_eq!(bench.raw("GET /api/state HTTP/1.1", &[], b"").status, 403);
    assert_eq!(bench.raw(&format!("GET /?token={} HTTP/1.1", "0".repeat(64)), &[], b"").status, 403);

    let first = bench.raw(&format!("GET /?token={} HTTP/1.1", bench.token), &[], b"");
    assert_eq!((first.status, first.header("location")), (303, Some("/")));
    let cookie = first.header("set-cookie").expect("a cookie");
    for part in ["HttpOnly", "SameSite=Strict", "Path=/"] {
        assert!(cookie.contains(part), "{cookie}");
    }
    let again = bench.raw(&format!("GET /?token={} HTTP/1.1", bench.token), &[], b"");
    assert_eq!(again.status, 403, "a token that was seen over a shoulder is worth nothing");

    let value = cookie.split(';').next().expect("a pair");
    let page = bench.raw("GET / HTTP/1.1", &[("Cookie", value)], b"");
    assert_eq!(page.status, 200);
    let policy = page.header("content-security-policy").expect("a policy");
    for part in ["default-src 'none'", "script-src 'self'", "frame-ancestors 'none'", "form-action 'none'"] {
        assert!(policy.contains(part), "{policy}");
    }
    assert!(!policy.contains("unsafe"), "{policy}");
    assert_eq!(page.header("x-content-type-options"), Some("nosniff"));
    assert_eq!(page.header("cache-control"), Some("no-store"));
    assert_eq!(bench.raw("GET /api/state HTTP/1.1", &[("Cookie", value)], b"").status, 200);
    let wrong = format!("{value}0");
    assert_eq!(bench.raw("GET /api/state HTTP/1.1", &[("Cookie", &wrong)], b"").status, 403);
}

#[test]
fn foreign_pages_hosts_methods_and_media_types_stay_outside() {
    let files = Files::new();
    let bench = Bench::open(&files, &[]).enter();
    let own = bench.host();
    let ask = |headers: &[(&str, &str)]| bench.raw_to("GET /api/state HTTP/1.1", headers, b"").status;
    assert_eq!(ask(&[("Host", &own)]), 200);
    assert_eq!(ask(&[("Host", &own.replace("127.0.0.1", "localhost"))]), 200);
    assert_eq!(ask(&[("Host", "evil.example")]), 403, "DNS rebinding");
    assert_eq!(ask(&[("Host", "127.0.0.1:1")]), 403);
    assert_eq!(ask(&[("Host", &own), ("Origin", "http://evil.example")]), 403);
    assert_eq!(ask(&[("Host", &own), ("Origin", "null")]), 403);
    assert_eq!(ask(&[("Host", &own), ("Origin", &format!("http://{own}"))]), 200);
    assert_eq!(ask(&[("Host", &own), ("Sec-Fetch-Site", "cross-site")]), 403);
    assert_eq!(ask(&[("Host", &own), ("Sec-Fetch-Site", "same-site")]), 403, "another port of this machine");
    let post = |path: &str, kind: &str| {
        let head = format!("POST {path} HTTP/1.1");
        bench.raw_to(&head, &[("Host", &own), ("Content-Type", kind)], b"{}").status
    };
    assert_eq!(post("/api/stop", "application/json"), 200);
    for kind in ["text/plain", "application/x-www-form-urlencoded", "multipart/form-data; boundary=x", ""] {
        assert_eq!(post("/api/stop", kind), 415, "{kind}: what a form of another page can send");
    }
    assert_eq!(post("/api/upload?kind=log", "application/json"), 415);
    for method in ["PUT", "DELETE", "OPTIONS", "TRACE"] {
        let status = bench.raw_to(&format!("{method} /api/state HTTP/1.1"), &[("Host", &own)], b"").status;
        assert_eq!(status, 405, "{method}");
    }
    assert_eq!(bench.get("/api/nothing").status, 404);
    for path in
        ["/bench/../Cargo.toml", "/bench/%2e%2e%2fsteps.json", "/api/file/..%2f..%2fx", "/page/page.rs"]
    {
        assert_eq!(bench.get(path).status, 404, "{path}");
    }
}

#[test]
fn rubbish_is_refused_in_words_and_does_no_harm() {
    let files = Files::new();
    let bench = Bench::open(&files, &[]).enter();
    let upload = |kind: &str, body: &[u8]| bench.upload(kind, "rubbish", body);
    for (kind, body) in [
        ("robot", &b"\x00\x01\x02\xff"[..]),
        ("robot", b"<robot><link></robot>"),
        ("robot", b"(rows: [])"),
        ("map", b"(time: 3"),
        ("model", b"()"),
        ("log", b""),
    ] {
        let answer = upload(kind, body);
        assert_eq!(answer.status, 422, "{kind}: {}", answer.text());
        assert!(answer.json()["error"]["text"].as_str().is_some_and(|t| !t.is_empty()));
    }
    assert_eq!(upload("gadget", b"x").status, 400);
    assert_eq!(upload("robot", &vec![b' '; (4 << 20) + 1]).status, 413);
    for (path, body) in [
        ("/api/add", "{"),
        ("/api/add", "[]"),
        ("/api/add", r#"{"effect": 3}"#),
        ("/api/add", r#"{"effect": "payload", "more": 1}"#),
        ("/api/show", r#"{"step": -1}"#),
        ("/api/retrieve", r#"{"engines": "lmi"}"#),
        ("/api/script/check", r#"{"kind": "poem", "text": ""}"#),
    ] {
        assert_eq!(bench.post(path, body).status, 400, "{path} {body}");
    }
    for (path, body) in [
        ("/api/add", r#"{"effect": "payload"}"#),
        ("/api/show", r#"{"step": 99}"#),
        ("/api/undo", "{}"),
        ("/api/diagnose", "{}"),
        ("/api/retrieve", r#"{"engines": ["simplex"]}"#),
        ("/api/retrieve", r#"{"engines": []}"#),
        ("/api/columns", r#"{"text": "(delimiter: 7)"}"#),
        ("/api/columns", r#"{"shipped": "../../etc/passwd"}"#),
        ("/api/constraints", r#"{"text": "[{\"mass_rage\": ()}]"}"#),
        ("/api/model", r#"{"model": "best"}"#),
        ("/api/remove", r#"{"log": 7}"#),
    ] {
        let answer = bench.post(path, body);
        assert_eq!(answer.status, 422, "{path} {body}: {}", answer.text());
    }
    let big = format!(r#"{{"text": "{}"}}"#, "x".repeat(1 << 20));
    assert!([400, 413].contains(&bench.post("/api/constraints", &big).status));
    // A log that is none is listed with what is wrong with it.
    assert_eq!(upload("log", b"\x7fELF\x02\x01\x01 rubbish").status, 200);
    let state = bench.wait("the log is looked at", |s| s["logs"][0]["read"] == true);
    assert_eq!(state["logs"][0]["usable"], false);
    assert_eq!(files.half_done("study"), [""; 0], "nothing half-done stays");
    let left: Vec<String> = files.names("study");
    assert!(left.contains(&"log_1.csv".to_string()), "names are ours: {left:?}");
}

#[cfg(unix)]
#[test]
fn the_folder_is_nobody_elses() {
    use std::os::unix::fs::PermissionsExt;
    let files = Files::new();
    let _bench = Bench::open(&files, &[]);
    let mode = std::fs::metadata(files.path("study")).expect("a folder").permissions().mode();
    assert_eq!(mode & 0o777, 0o700);
}

#[test]
fn what_cannot_be_opened_is_said_on_the_command_line() {
    let files = Files::new();
    files.simulate();
    let refused = |args: &[&str], word: &str| {
        let (code, said) = files.fail(&[&["workbench"], args].concat());
        assert!(code == Some(2) && said.contains(word), "{args:?}: {code:?} {said}");
    };
    refused(&["nothing.ron"], "nothing.ron");
    refused(&["logs/fit.csv.gz"], "log");
    refused(&["--robot", "nothing.urdf"], "nothing.urdf");
    refused(&["--robot", "two_link.ron", "--data", "nothing.csv"], "nothing.csv");
    refused(&["plant.ron", "--robot", "two_link.ron"], "both");
    refused(&["--resume", "nowhere"], "nowhere");
    refused(&["--resume", "study", "--data", "logs/fit.csv.gz"], "--data");
    refused(&["--gravity", "down"], "--gravity");
    let bench = Bench::open(&files, &[]);
    refused(&["--out", "study"], "--resume");
    let port = bench.host();
    let port = port.split(':').next_back().expect("a port");
    refused(&["--out", "other", "--port", port], port);
}
