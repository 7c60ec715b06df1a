//! Whatever comes over the wire, and whoever goes away in the middle: the workbench answers the next one, and a model
//! file is whole.

use super::server::{Bench, imported};
use proptest::collection::vec;
use proptest::prelude::*;
use proptest::test_runner::{Config, TestRunner};
use serde_json::{Value, json};
use softdock_tests::process::scratch;
use std::fs;
use std::io::{Read, Write};
use std::net::{Shutdown, TcpStream};
use std::time::Duration;

/// Rounds of bytes that are no request.
const ROUNDS: u32 = 300;
/// More connections than the server takes at a time.
const CROWD: usize = 80;

fn selection() -> Value {
    json!({"model": "model.toml", "fit": ["train.mcap"], "test": ["test.mcap"]})
}

/// Says something and hangs up; what the answer is does not matter.
fn says(bench: &Bench, bytes: &[u8]) {
    let mut stream = TcpStream::connect(bench.host()).unwrap();
    stream
        .set_read_timeout(Some(Duration::from_millis(500)))
        .unwrap();
    // The server may hang up first.
    let _ = stream.write_all(bytes);
    let _ = stream.shutdown(Shutdown::Write);
    let _ = stream.read(&mut [0; 1024]);
}

fn answers(bench: &Bench) {
    assert_eq!(bench.get("/api/session").status, 200);
}

#[test]
fn bytes_that_are_no_request_hurt_nobody() {
    let bench = Bench::start(&scratch("workbench_bytes"));
    let host = format!("host: {}\r\n", bench.host());
    let long = "a".repeat(100_000);
    for text in [
        "\r\n\r\n".to_owned(),
        "GET".to_owned(),
        "GET / HTTP/9.9\r\n\r\n".to_owned(),
        format!("GET /{long} HTTP/1.1\r\n{host}\r\n"),
        format!("GET / HTTP/1.1\r\n{host}x: {long}\r\n\r\n"),
        format!("GET / HTTP/1.1\r\n{}\r\n", "a: b\r\n".repeat(10_000)),
        format!("GET /%00%ff%zz HTTP/1.1\r\n{host}\r\n"),
        format!("POST /api/compare HTTP/1.1\r\n{host}content-length: -1\r\n\r\n"),
        format!(
            "POST /api/compare HTTP/1.1\r\n{host}content-length: 99999999999999999999\r\n\r\n{{"
        ),
        format!(
            "POST /api/compare HTTP/1.1\r\n{host}content-length: 1\r\ncontent-length: 2\r\n\r\n{{}}"
        ),
        format!("POST /api/compare HTTP/1.1\r\n{host}transfer-encoding: chunked\r\n\r\nzz\r\n"),
        format!(
            "GET /api/jobs/1/events HTTP/1.1\r\n{host}last-event-id: 18446744073709551615\r\n\r\n"
        ),
    ] {
        says(&bench, text.as_bytes());
    }
    answers(&bench);
    let config = Config {
        failure_persistence: None,
        ..Config::with_cases(ROUNDS)
    };
    TestRunner::new(config)
        .run(&vec(any::<u8>(), 0..400), |bytes| {
            says(&bench, &bytes);
            Ok(())
        })
        .unwrap();
    answers(&bench);
}

#[test]
fn a_crowd_that_says_nothing_is_gone_when_it_hangs_up() {
    let bench = Bench::start(&scratch("workbench_crowd"));
    let crowd: Vec<TcpStream> = (0..CROWD)
        .map(|_| TcpStream::connect(bench.host()).unwrap())
        .collect();
    drop(crowd);
    answers(&bench);
}

/// The browser goes away in the middle of a diagnosis; another one hears the rest, and no more than that.
#[test]
fn a_job_outlives_the_browser_that_asked_for_it() {
    let folder = imported("workbench_gone", "guide_coulomb");
    let bench = Bench::start(&folder);
    let diagnose = json!({"kind": "diagnose", "args": selection()});
    let id = bench.post("/api/jobs", &diagnose).json()["id"].clone();
    let path = format!("/api/jobs/{id}/events");
    let heard = bench.hear(&path, |heard| heard.matches("\n\n").count() >= 3);
    let first = heard.lines().filter_map(|line| line.strip_prefix("id: "));
    assert_eq!(first.take(3).collect::<Vec<_>>(), ["1", "2", "3"]);
    let rest = |last: &str| {
        let request = format!(
            "GET {path} HTTP/1.1\r\nhost: {}\r\nconnection: close\r\nlast-event-id: {last}\r\n\r\n",
            bench.host()
        );
        String::from_utf8(bench.send(&request).body).unwrap()
    };
    let told = rest("3");
    assert!(
        told.contains("\nid: 4\n") || told.starts_with("id: 4\n") || told.contains("id: 4"),
        "{told}"
    );
    assert!(!told.contains("id: 3\n"), "{told}");
    assert!(told.contains("event: result"), "{told}");
    // Who has heard all of it, or claims to, hears the end.
    assert!(!rest("1000000").contains("event:"));
}

/// Killed while it writes: the model file says what it said, or what it was to say.
#[test]
#[cfg(unix)]
fn a_model_file_is_whole_whenever_the_workbench_is_killed() {
    let folder = imported("workbench_killed", "guide_coulomb");
    let path = folder.join("model.toml");
    let before = fs::read_to_string(&path).unwrap();
    let add = json!({"kind": "add", "args": {"selection": selection(), "effect": "guide_coulomb"}});
    for wait_us in [0, 300, 1000, 3000] {
        let bench = Bench::start(&folder);
        let found = bench.job(&add).pop().unwrap().1;
        let body = json!({"job": 1, "if_match": found["if_match"]}).to_string();
        let mut stream = TcpStream::connect(bench.host()).unwrap();
        let request = format!(
            "POST /api/models/model.toml/effects HTTP/1.1\r\nhost: {}\r\ncontent-type: application/json\r\n\
             x-softdock: {}\r\ncontent-length: {}\r\n\r\n{body}",
            bench.host(),
            bench.token,
            body.len()
        );
        stream.write_all(request.as_bytes()).unwrap();
        std::thread::sleep(Duration::from_micros(wait_us));
        bench.kill();
        let now = fs::read_to_string(&path).unwrap();
        let whole = now == before || now.contains("id = \"guide_coulomb\"");
        assert!(
            whole && softdock_physics::model::Model::from_toml(&now, "model.toml").is_ok(),
            "{now}"
        );
        let bench = Bench::start(&folder);
        let listed = bench.get("/api/models").json();
        assert_eq!(listed.as_array().unwrap().len(), 1, "{listed}");
        fs::write(&path, &before).unwrap();
    }
}
