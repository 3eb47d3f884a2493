//! The workbench over a real socket: who is let in, what rubbish does, what is kept.

#[path = "workbench/client.rs"]
mod client;
#[path = "workbench/data.rs"]
mod data;

use client::{Bench, json};
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
    let left: Vec<String> = files.names("study");
    assert!(left.iter().all(|f| !f.starts_with('.')), "nothing half-done stays: {left:?}");
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
fn a_study_from_dropped_files_to_a_smaller_error_and_back() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &[]).enter();
    assert_eq!(bench.upload("log", "arm one.csv", &files.bytes("logs/fit.csv.gz")).status, 200);
    let state = bench.wait("the log is looked at", |s| s["logs"][0]["read"] == true);
    assert_eq!(state["logs"][0]["name"], "arm one.csv");
    assert_eq!(state["logs"][0]["columns"][1]["meaning"], "position");
    assert!(state["shown"].is_null(), "no model without a robot");
    assert_eq!(
        bench.upload("robot", "r.ron", &std::fs::read("robots/two_link.ron").expect("reads")).status,
        200
    );

    let first = bench.wait("a fitted model", |s| !s["steps"][0]["held_out_percent"].is_null());
    assert_eq!(first["robot"]["joints"][0]["torque"], "N m");
    let page = bench.get("/api/page").json();
    assert_eq!(page["pictures"]["models"].as_array().map(Vec::len), Some(1));
    assert!(page["pictures"]["traces"][0]["rows"].as_u64() > Some(200));

    let full = bench.wait("a full search", |s| s["steps"][0]["scanned"] == true && s["job"].is_null());
    let before = full["steps"][0]["held_out_percent"].as_f64().expect("a number");
    assert_eq!(
        full["diagnosis"]["baseline"]["held_out_relative_error_percent"].as_f64(),
        Some(before),
        "the search starts from the very model on show"
    );
    let hidden = &full["candidates"][0];
    assert_eq!((hidden["rank"].as_str(), hidden["effect"].as_str()), (Some("missing"), Some("joint_spring")));

    assert_eq!(bench.post("/api/add", &hidden["add"].to_string()).status, 200);
    let added = bench.wait("another step", |s| s["steps"].as_array().is_some_and(|a| a.len() == 2));
    let after = added["steps"][1]["held_out_percent"].as_f64().expect("a number");
    assert!(after < 0.7 * before, "{before} to {after} %");
    assert_eq!((added["shown"].as_u64(), added["against"].as_u64()), (Some(1), Some(0)));
    assert_eq!(added["path"], json("[0, 1]"));
    let page = bench.get("/api/page").json();
    assert_eq!(page["pictures"]["models"].as_array().map(Vec::len), Some(2));
    let clean = bench.wait("the verdict on the new model", |s| s["steps"][1]["scanned"] == true);
    assert_eq!(clean["diagnosis"]["missing"], json("[]"), "{}", clean["verdict"]);

    let region = bench.get("/api/region?log=0&from=3&to=6&variable=dq1&low=0").json();
    assert!(
        region["rows"].as_u64() > Some(5) && region["joints"][1]["rms"].as_array().map(Vec::len) == Some(2)
    );
    assert_eq!(bench.get("/api/region?log=0&from=1e9").json()["rows"], 0);
    assert_eq!(bench.get("/api/region?log=5").status, 422);

    // The command line repeats it.
    let scenario = files.run(&["diagnose", "study/scenario.ron", "--json"]);
    let again = json(&scenario)["baseline"]["held_out_relative_error_percent"].as_f64().expect("a number");
    assert!((again - after).abs() < 1e-9 * after, "{again} and {after}");

    assert_eq!(bench.post("/api/undo", "{}").status, 200);
    let back = bench.wait("the first model", |s| s["shown"] == 0);
    assert_eq!(back["steps"].as_array().map(Vec::len), Some(2), "undone is not lost");
    assert_eq!(bench.post("/api/undo", "{}").status, 422);
    for file in ["scenario.ron", "model.ron", "report.html", "diagnosis.json"] {
        let taken = bench.get(&format!("/api/file/{file}"));
        assert_eq!(taken.status, 200, "{file}");
        assert!(taken.header("content-disposition").is_some_and(|d| d.starts_with("attachment")));
    }
}

#[test]
fn a_killed_process_loses_no_finished_step() {
    let files = Files::new();
    files.simulate();
    let args = ["--robot", "two_link.ron", "--data", "logs/fit.csv.gz", "--validate", "logs/check.csv.gz"];
    let mut bench = Bench::open(&files, &args).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    assert_eq!(bench.post("/api/add", r#"{"effect": "joint_spring", "joints": ["joint1"]}"#).status, 200);
    let before = bench.wait("a step", |s| s["steps"].as_array().is_some_and(|a| a.len() == 2));
    bench.kill();
    let bench = Bench::resume(&files).enter();
    let after = bench.wait("the models, fitted again", |s| {
        s["steps"].as_array().is_some_and(|a| a.len() == 2 && a.iter().all(|s| s["fitted"] == true))
    });
    for key in ["held_out_percent", "joints", "added", "validation_percent", "parameters"] {
        assert_eq!(before["steps"][1][key], after["steps"][1][key], "{key}");
    }
    assert!(after["steps"][1]["validation_percent"].as_f64().is_some());
    assert_eq!((&before["shown"], &before["against"]), (&after["shown"], &after["against"]));
}

#[test]
fn two_tabs_are_told_of_the_same_study() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    let (mut one, mut two) = (bench.listen(), bench.listen());
    assert!(one.next("state").is_some() && two.next("state").is_some(), "said at once");
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    let version =
        bench.post("/api/add", r#"{"effect": "joint_spring", "joints": ["joint1"]}"#).json()["version"]
            .as_u64()
            .expect("a version");
    for tab in [&mut one, &mut two] {
        let told = tab.until("state", |v| v["version"].as_u64() > Some(version));
        assert!(told, "each tab hears of the change");
    }
}

#[test]
fn a_retrieval_is_stopped_and_keeps_its_best() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    let order = r#"{"engines": ["lmi", "penalty"], "runs": 4000}"#;
    assert_eq!(bench.post("/api/retrieve", order).status, 200);
    bench.wait("progress", |s| s["retrieval"]["engine"] == "penalty" && !s["job"]["fraction"].is_null());
    assert_eq!(bench.post("/api/add", r#"{"effect": "payload"}"#).status, 409);
    assert_eq!(bench.post("/api/stop", "{}").status, 200);
    let state = bench.wait("the end", |s| s["retrieval"]["running"] == false);
    let retrieval = &state["retrieval"];
    assert_eq!(retrieval["stopped"], true, "{}", state["trouble"]);
    let results = retrieval["results"].as_array().expect("results");
    assert_eq!(results.len(), 2);
    assert!(results.iter().all(|r| r["feasible"] == true), "{results:?}");
    assert!(results[1]["runs"].as_u64() < Some(4000));
    assert!(results[1]["certified_gap_percent"].as_f64().is_some_and(|gap| gap >= 0.0));
    assert_eq!(bench.get("/api/file/robot.urdf").status, 200);
    assert!(bench.get("/api/page").json()["report"]["retrievals"].is_array());
}

/// The spring that the logs hide, as a user may write it.
const SPRING: &str = r#"// A spring.
fn about() {
    #{
        title: "spring", text: "A spring on the joint.", equation: "tau_j = k_j q_j",
        confused_with: "gravity",
        parameters: [#{ symbol: "k", unit: "N m/rad", meaning: "stiffness", min: 0.0 }],
    }
}
fn columns(joint, now, memory, with) {
    [ now.q ]
}
"#;

#[test]
fn scripts_are_checked_while_they_are_typed_and_used_at_once() {
    let files = Files::new();
    files.simulate();
    let bench = Bench::open(&files, &["--robot", "two_link.ron", "--data", "logs/fit.csv.gz"]).enter();
    bench.wait("a model", |s| !s["steps"][0]["held_out_percent"].is_null());
    let draft = |kind: &str, text: &str| serde_json::json!({"kind": kind, "text": text}).to_string();
    let good = SPRING;
    let broken = good.replacen("fn columns(", "fn columns((", 1);
    let answer = bench.post("/api/script/check", &draft("effect", &broken)).json();
    let line = 1 + broken[..broken.find("fn columns((").expect("there")].matches('\n').count() as u64;
    assert_eq!((answer["ok"].as_bool(), answer["problems"][0]["line"].as_u64()), (Some(false), Some(line)));
    assert!(answer["problems"][0]["column"].as_u64().is_some(), "{answer}");
    assert_eq!(bench.post("/api/script/save", &draft("effect", &broken)).status, 422);
    assert_eq!(bench.post("/api/script/save", &draft("constraint", good)).status, 422, "that is an effect");

    let answer = bench.post("/api/script/check", &draft("effect", good)).json();
    assert_eq!(answer["ok"], true, "{answer}");
    let saved = bench.post("/api/script/save", &draft("effect", good));
    assert_eq!((saved.status, saved.json()["file"].as_str()), (200, Some("effect_1.rhai")));
    let add = r#"{"effect": "effect_1.rhai", "joints": ["joint1"]}"#;
    assert_eq!(bench.post("/api/add", add).status, 200);
    let state = bench.wait("a step with it", |s| s["steps"].as_array().is_some_and(|a| a.len() == 2));
    assert!(state["steps"][1]["effects"].to_string().contains("effect_1.rhai"));
    let error = |step: usize| state["steps"][step]["held_out_percent"].as_f64().expect("a number");
    assert!(error(1) < 0.1 * error(0), "{} to {} %", error(0), error(1));

    let rule = std::fs::read_to_string("constraints/total_mass.rhai").expect("reads");
    let saved = bench.post("/api/script/save", &draft("constraint", &rule));
    assert_eq!(saved.json()["file"], "constraint_1.rhai", "{}", saved.text());
    let state = bench.get("/api/state").json();
    assert!(state["constraints"]["text"].as_str().is_some_and(|t| t.contains("constraint_1.rhai")));
    assert_eq!(state["constraints"]["problems"], json("[]"));
    let left = files.names("study");
    assert!(left.iter().all(|f| !f.starts_with('.')), "{left:?}");
}
