//! A workbench in a process of its own, and a browser as small as can be.

use std::io::{BufRead, BufReader, Read, Write};
use std::net::TcpStream;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

use serde_json::Value;

use super::data::Files;

/// Longest time to wait for anything.
const PATIENCE: Duration = Duration::from_secs(40);

/// Text as JSON.
pub fn json(text: &str) -> Value {
    serde_json::from_str(text).unwrap_or_else(|e| panic!("{e}: {text}"))
}

/// A running workbench; ended with the value.
pub struct Bench {
    child: Child,
    port: u16,
    pub token: String,
    cookie: Option<String>,
}

/// What came back.
pub struct Answer {
    pub status: u16,
    headers: Vec<(String, String)>,
    body: Vec<u8>,
}

impl Answer {
    pub fn header(&self, name: &str) -> Option<&str> {
        self.headers.iter().find(|(n, _)| n == name).map(|(_, v)| v.as_str())
    }

    pub fn text(&self) -> String {
        String::from_utf8_lossy(&self.body).into_owned()
    }

    pub fn json(&self) -> Value {
        json(&self.text())
    }
}

impl Bench {
    pub fn open(files: &Files, args: &[&str]) -> Self {
        Self::spawn(files, &[args, &["--out", "study"]].concat(), None)
    }

    /// On a disk that takes no file larger than this [KiB].
    #[cfg(unix)]
    pub fn open_within(files: &Files, args: &[&str], limit: u32) -> Self {
        Self::spawn(files, &[args, &["--out", "study"]].concat(), Some(limit))
    }

    pub fn resume(files: &Files) -> Self {
        Self::spawn(files, &["--resume", "study"], None)
    }

    /// With so many open files at most.
    #[cfg(unix)]
    pub fn open_with_files(files: &Files, most_open: usize) -> Self {
        let mut shell = Command::new("sh");
        let program = env!("CARGO_BIN_EXE_lacuna");
        shell.args(["-c", &format!("ulimit -n {most_open}; exec \"$@\""), "sh", program]);
        Self::start(shell, files, &["--out", "study"])
    }

    fn spawn(files: &Files, args: &[&str], limit: Option<u32>) -> Self {
        let program = env!("CARGO_BIN_EXE_lacuna");
        let mut command = Command::new(if limit.is_some() { "bash" } else { program });
        if let Some(limit) = limit {
            let script = format!("ulimit -f {limit}; trap '' XFSZ; exec \"$0\" \"$@\"");
            command.args(["-c", &script, program]);
        }
        Self::start(command, files, args)
    }

    fn start(mut command: Command, files: &Files, args: &[&str]) -> Self {
        command.current_dir(files.path(".")).arg("workbench").args(args).arg("--json");
        let mut child = command.stdout(Stdio::piped()).stderr(Stdio::null()).spawn().expect("starts");
        let mut lines = BufReader::new(child.stdout.take().expect("a pipe")).lines().map_while(Result::ok);
        let mut text = String::new();
        let address = loop {
            text += &lines.next().unwrap_or_else(|| panic!("ended: {text}"));
            if let Ok(said) = serde_json::from_str::<Value>(&text) {
                break said["address"].as_str().expect("an address").to_string();
            }
        };
        let rest = address.strip_prefix("http://127.0.0.1:").expect("this machine");
        let (port, token) = rest.split_once("/?token=").expect("a token");
        Self { child, port: port.parse().expect("a port"), token: token.to_string(), cookie: None }
    }

    /// Exchanges the token.
    pub fn enter(mut self) -> Self {
        let answer = self.raw(&format!("GET /?token={} HTTP/1.1", self.token), &[], b"");
        let cookie = answer.header("set-cookie").unwrap_or_else(|| panic!("{}", answer.text()));
        self.cookie = cookie.split(';').next().map(str::to_string);
        self
    }

    pub fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    pub fn id(&self) -> u32 {
        self.child.id()
    }

    pub fn kill(&mut self) {
        self.child.kill().expect("ends");
        self.child.wait().expect("ended");
    }

    pub fn get(&self, path: &str) -> Answer {
        self.raw(&format!("GET {path} HTTP/1.1"), &[], b"")
    }

    pub fn post(&self, path: &str, body: &str) -> Answer {
        let kind = [("Content-Type", "application/json")];
        self.raw(&format!("POST {path} HTTP/1.1"), &kind, body.as_bytes())
    }

    pub fn upload(&self, kind: &str, name: &str, body: &[u8]) -> Answer {
        let head = format!("POST /api/upload?kind={kind}&name={} HTTP/1.1", name.replace(' ', "%20"));
        self.raw(&head, &[("Content-Type", "application/octet-stream")], body)
    }

    /// With our own `Host`.
    pub fn raw(&self, head: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let host = self.host();
        self.raw_to(head, &[&[("Host", host.as_str())], headers].concat(), body)
    }

    pub fn raw_to(&self, head: &str, headers: &[(&str, &str)], body: &[u8]) -> Answer {
        let mut stream = self.send(head, headers, body);
        let mut all = Vec::new();
        // A server that has refused may hang up before the body is through.
        let _ = stream.read_to_end(&mut all);
        answer(&all)
    }

    /// A connection that says nothing yet.
    pub fn connect(&self) -> TcpStream {
        let stream = TcpStream::connect(("127.0.0.1", self.port)).expect("listens");
        stream.set_read_timeout(Some(PATIENCE)).expect("a time");
        stream
    }

    fn send(&self, head: &str, headers: &[(&str, &str)], body: &[u8]) -> TcpStream {
        let mut stream = self.connect();
        let mut text = format!("{head}\r\nConnection: close\r\nContent-Length: {}\r\n", body.len());
        for (name, value) in headers {
            text += &format!("{name}: {value}\r\n");
        }
        let named = headers.iter().any(|(name, _)| *name == "Cookie");
        if let Some(cookie) = self.cookie.as_ref().filter(|_| !named) {
            text += &format!("Cookie: {cookie}\r\n");
        }
        text += "\r\n";
        stream.write_all(text.as_bytes()).expect("sends");
        let _ = stream.write_all(body);
        stream
    }

    /// Waits until the state is as wanted.
    pub fn wait(&self, what: &str, wanted: impl Fn(&Value) -> bool) -> Value {
        let start = Instant::now();
        loop {
            let state = self.get("/api/state").json();
            check(&state);
            if wanted(&state) {
                return state;
            }
            let short = [&state["job"], &state["trouble"], &state["steps"], &state["retrieval"]];
            assert!(start.elapsed() < PATIENCE, "no sign of {what}: {short:?}");
            std::thread::sleep(Duration::from_millis(50));
        }
    }

    /// Another tab.
    pub fn listen(&self) -> Tab {
        let host = self.host();
        let stream = self.send("GET /api/events HTTP/1.1", &[("Host", host.as_str())], b"");
        Tab { lines: BufReader::new(stream) }
    }
}

/// Whatever happens: the models on show are among the steps, and so is every step on the way to them.
fn check(state: &Value) {
    let steps = state["steps"].as_array().expect("a list");
    let named = [&state["shown"], &state["against"]].into_iter().filter(|id| !id.is_null());
    for id in named.chain(state["path"].as_array().expect("a list")) {
        let step = steps.iter().find(|step| step["id"] == *id);
        let step = step.unwrap_or_else(|| panic!("step {id} is on show but is none of {steps:?}"));
        assert!(step["held_out_percent"].is_f64(), "{step:?}");
    }
}

impl Drop for Bench {
    fn drop(&mut self) {
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// A tab that listens.
pub struct Tab {
    lines: BufReader<TcpStream>,
}

impl Tab {
    /// The next message of a kind.
    pub fn next(&mut self, kind: &str) -> Option<Value> {
        let mut is_kind = false;
        let mut line = String::new();
        loop {
            line.clear();
            if self.lines.read_line(&mut line).ok()? == 0 {
                return None;
            }
            match line.trim_end().split_once(": ") {
                Some(("event", name)) => is_kind = name == kind,
                Some(("data", data)) if is_kind => return serde_json::from_str(data).ok(),
                _ => {}
            }
        }
    }

    /// Whether a message of a kind comes that is as wanted.
    pub fn until(&mut self, kind: &str, wanted: impl Fn(&Value) -> bool) -> bool {
        while let Some(said) = self.next(kind) {
            if wanted(&said) {
                return true;
            }
        }
        false
    }
}

fn answer(all: &[u8]) -> Answer {
    let end = all.windows(4).position(|w| w == b"\r\n\r\n").unwrap_or(all.len());
    let head = String::from_utf8_lossy(&all[..end]).into_owned();
    let mut lines = head.lines();
    let status = lines.next().and_then(|l| l.split(' ').nth(1)).and_then(|s| s.parse().ok()).unwrap_or(0);
    let pair = |line: &str| line.split_once(": ").map(|(n, v)| (n.to_lowercase(), v.to_string()));
    let headers: Vec<(String, String)> = lines.filter_map(pair).collect();
    let body = all.get(end + 4..).unwrap_or_default();
    let chunked = headers.iter().any(|(n, v)| n == "transfer-encoding" && v == "chunked");
    Answer { status, headers, body: if chunked { joined(body) } else { body.to_vec() } }
}

/// A body that came in chunks.
fn joined(mut rest: &[u8]) -> Vec<u8> {
    let mut all = Vec::new();
    while let Some(end) = rest.windows(2).position(|w| w == b"\r\n") {
        let size = usize::from_str_radix(&String::from_utf8_lossy(&rest[..end]), 16).unwrap_or(0);
        if size == 0 {
            break;
        }
        all.extend_from_slice(&rest[end + 2..end + 2 + size]);
        rest = &rest[end + 4 + size..];
    }
    all
}
