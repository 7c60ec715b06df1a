//! The DevTools protocol: JSON messages, each ended by a zero byte, over two pipes.

use crate::process::PATIENCE;
use serde_json::{Value, json};
use std::fs::File;
use std::io::{BufRead, BufReader, Read, Write};
use std::path::Path;
use std::process::{Child, ChildStdin, Command, Stdio};
use std::sync::mpsc::{self, Receiver};
use std::thread;

/// Options for tests: without a window, without a network of its own, and without the sandbox, with which it does not run as
/// root.
const OPTIONS: [&str; 9] = [
    "--headless",
    "--no-sandbox",
    "--disable-gpu",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--remote-debugging-pipe",
];
/// Chromium reads commands from file 3 and answers on file 4.
const WITH_PIPES: &str = r#"exec "$0" "$@" 3<&0 4>&1 >&2"#;

/// A browser with one open tab. The process is killed on drop.
#[derive(Debug)]
pub(super) struct DevTools {
    child: Child,
    orders: ChildStdin,
    messages: Receiver<Value>,
    last_id: u64,
    session: Option<String>,
    events: Vec<Value>,
    /// Path of the browser's log, for messages.
    log: String,
}

impl DevTools {
    /// Starts `chromium` with its profile in `folder`, and opens a tab.
    pub(super) fn start(chromium: &Path, folder: &Path) -> Self {
        let log = folder.join("chromium.log");
        let complaints = File::create(&log).expect("a log can be made");
        let mut command = Command::new("sh");
        command.args(["-c", WITH_PIPES]).arg(chromium).args(OPTIONS);
        command
            .arg(format!(
                "--user-data-dir={}",
                folder.join("profile").display()
            ))
            .stdin(Stdio::piped())
            .stdout(Stdio::piped())
            .stderr(complaints);
        let mut child = command.spawn().expect("there is a shell");
        let orders = child.stdin.take().expect("standard input is piped");
        let answers = child.stdout.take().expect("standard output is piped");
        let mut tools = Self {
            child,
            orders,
            messages: messages(answers),
            last_id: 0,
            session: None,
            events: Vec::new(),
            log: log.display().to_string(),
        };
        let tab = tools.call("Target.createTarget", json!({"url": "about:blank"}));
        let attach = json!({"targetId": tab["targetId"], "flatten": true});
        let attached = tools.call("Target.attachToTarget", attach);
        tools.session = attached["sessionId"].as_str().map(ToOwned::to_owned);
        tools
    }

    /// Calls a method and waits for its result.
    pub(super) fn call(&mut self, method: &str, parameters: Value) -> Value {
        self.last_id += 1;
        let mut order = json!({"id": self.last_id, "method": method, "params": parameters});
        if let Some(session) = &self.session {
            order["sessionId"] = json!(session);
        }
        let mut bytes = order.to_string().into_bytes();
        bytes.push(0);
        if let Err(error) = self.orders.write_all(&bytes) {
            panic!(
                "{method}: Chromium does not listen ({error}); see {}",
                self.log
            );
        }
        loop {
            let message = self.next(method);
            if message["id"] == json!(self.last_id) {
                assert!(message["error"].is_null(), "{method}: {message}");
                return message["result"].clone();
            }
            self.events.push(message);
        }
    }

    /// Waits for an event, unless it has already come.
    pub(super) fn wait_for_event(&mut self, method: &str) {
        while !self.events.iter().any(|event| event["method"] == method) {
            let message = self.next(method);
            self.events.push(message);
        }
    }

    /// Events since [`Self::forget_events`].
    pub(super) fn events(&self) -> &[Value] {
        &self.events
    }

    /// Starts a new list of events.
    pub(super) fn forget_events(&mut self) {
        self.events.clear();
    }

    fn next(&self, waits_for: &str) -> Value {
        let message = self.messages.recv_timeout(PATIENCE);
        message.unwrap_or_else(|error| {
            panic!(
                "{waits_for}: Chromium says nothing ({error}); see {}",
                self.log
            )
        })
    }
}

impl Drop for DevTools {
    fn drop(&mut self) {
        // An error means that it has already ended.
        let _ = self.child.kill();
        let _ = self.child.wait();
    }
}

/// The messages of a stream, read by a thread that ends with the stream.
fn messages(stream: impl Read + Send + 'static) -> Receiver<Value> {
    let (sender, receiver) = mpsc::channel();
    thread::spawn(move || {
        for message in BufReader::new(stream).split(0).map_while(Result::ok) {
            let message = serde_json::from_slice(&message).unwrap_or(Value::Null);
            if sender.send(message).is_err() {
                break;
            }
        }
    });
    receiver
}
