//! A workbench as a process, its folder, and a client that says exactly what a test wants said.

use serde_json::Value;
use softdock_tests::process::{Running, done, scratch, softdock_binary};
use std::fs;
use std::io::{Read, Write};
use std::net::TcpStream;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

/// Longest wait for an answer. It only keeps a broken test from hanging.
const PATIENCE: Duration = Duration::from_secs(240);

/// A folder with a log of another rig that hides an effect, imported into `runs`.
pub fn imported(test: &str, effect: &str) -> PathBuf {
    let folder = scratch(test);
    let suite = softdock_hidden_effects::suite(1);
    let spec = suite.iter().find(|spec| spec.effects() == [effect]);
    let case = spec.expect("the suite has every effect").generate();
    let log = folder.join("log");
    fs::create_dir(&log).unwrap();
    fs::write(log.join("meta.json"), &case.meta_json).unwrap();
    fs::write(log.join("train.csv"), &case.train_csv).unwrap();
    fs::write(log.join("test.csv"), &case.test_csv).unwrap();
    done(&folder, &["import", "log", "-o", "runs"]);
    folder.join("runs")
}

/// A running workbench; it ends when the test drops it.
pub struct Bench {
    pub port: u16,
    pub token: String,
    process: Running,
}

/// An answer: status and body.
pub struct Answer {
    pub status: u16,
    pub body: Vec<u8>,
}

impl Answer {
    pub fn json(&self) -> Value {
        let text = String::from_utf8_lossy(&self.body);
        serde_json::from_str(&text).unwrap_or_else(|e| panic!("{} {e}: {text}", self.status))
    }
}

impl Bench {
    pub fn start(folder: &Path) -> Self {
        let mut bench = Self::listening(folder, &[]);
        let session = bench.get("/api/session").json();
        session["csrf"]
            .as_str()
            .unwrap()
            .clone_into(&mut bench.token);
        bench
    }

    /// With further arguments, and without having asked anything yet.
    pub fn listening(folder: &Path, arguments: &[&str]) -> Self {
        let mut command = Command::new(softdock_binary());
        command.arg("workbench").arg(folder).args(arguments);
        let mut process = Running::start("workbench", &mut command);
        let url = process.wait_for("http://127.0.0.1:");
        let port = url.split("http://127.0.0.1:").nth(1).unwrap();
        Self {
            port: port.split('/').next().unwrap().parse().unwrap(),
            token: String::new(),
            process,
        }
    }

    /// Ends it where it stands, as a power cut does.
    pub fn kill(self) {
        drop(self.process);
    }

    pub fn host(&self) -> String {
        format!("127.0.0.1:{}", self.port)
    }

    pub fn get(&self, path: &str) -> Answer {
        self.send(&format!(
            "GET {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\n\r\n",
            self.host()
        ))
    }

    /// As the page asks.
    pub fn ask(&self, method: &str, path: &str, body: &Value) -> Answer {
        let body = body.to_string();
        self.send(&format!(
            "{method} {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\ncontent-type: application/json\r\n\
             x-softdock: {}\r\ncontent-length: {}\r\n\r\n{body}",
            self.host(),
            self.token,
            body.len()
        ))
    }

    pub fn post(&self, path: &str, body: &Value) -> Answer {
        self.ask("POST", path, body)
    }

    /// Sends these bytes and waits until the server closes.
    pub fn send(&self, request: &str) -> Answer {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        stream.write_all(request.as_bytes()).unwrap();
        let mut bytes = Vec::new();
        // A server that refuses a body may close before it has come whole.
        let _ = stream.read_to_end(&mut bytes);
        let end = bytes.windows(4).position(|w| w == b"\r\n\r\n");
        let end = end.unwrap_or_else(|| panic!("no answer to {request}"));
        let head = String::from_utf8_lossy(&bytes[..end]).into_owned();
        let body = bytes[end + 4..].to_vec();
        Answer {
            status: head.split(' ').nth(1).unwrap().parse().unwrap(),
            body: if head.to_lowercase().contains("transfer-encoding: chunked") {
                unchunked(&body)
            } else {
                body
            },
        }
    }

    /// Listens to events until `enough` holds of all that has come.
    pub fn hear(&self, path: &str, enough: impl Fn(&str) -> bool) -> String {
        let mut stream = TcpStream::connect(self.host()).unwrap();
        stream.set_read_timeout(Some(PATIENCE)).unwrap();
        write!(
            stream,
            "GET {path} HTTP/1.1\r\nhost: {}\r\n\r\n",
            self.host()
        )
        .unwrap();
        let mut heard = String::new();
        let mut buffer = [0; 4096];
        while !enough(&heard) {
            let length = stream.read(&mut buffer).unwrap();
            assert!(length > 0, "the stream ended: {heard}");
            heard.push_str(&String::from_utf8_lossy(&buffer[..length]));
        }
        heard
    }

    /// Does a job to its end: kinds and values of what it told.
    pub fn job(&self, request: &Value) -> Vec<(String, Value)> {
        let started = self.post("/api/jobs", request);
        assert_eq!(started.status, 202, "{}", started.json());
        let id = started.json()["id"].as_u64().unwrap();
        let told = self.get(&format!("/api/jobs/{id}/events")).body;
        let told = String::from_utf8(told).unwrap();
        let events = told.split("\n\n").filter_map(|event| {
            let of = |key: &str| {
                event
                    .lines()
                    .find_map(|l| l.strip_prefix(key))
                    .map(str::trim)
            };
            let value = serde_json::from_str(of("data:")?).unwrap();
            Some((of("event:")?.to_owned(), value))
        });
        events.collect()
    }
}

/// A body that came in pieces.
fn unchunked(body: &[u8]) -> Vec<u8> {
    let mut whole = Vec::new();
    let mut rest = body;
    while let Some(end) = rest.windows(2).position(|w| w == b"\r\n") {
        let length = usize::from_str_radix(std::str::from_utf8(&rest[..end]).unwrap(), 16).unwrap();
        if length == 0 {
            break;
        }
        whole.extend(&rest[end + 2..end + 2 + length]);
        rest = &rest[end + 4 + length..];
    }
    whole
}
