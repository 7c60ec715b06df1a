//! The live view: a board's telemetry in the browser, and nothing back.

use super::server::Bench;
use crate::telemetry::board::{Board, IDENTITY, settings};
use serde_json::{Value, json};
use softdock_tests::browser::Browser;
use softdock_tests::process::scratch;
use std::net::UdpSocket;
use std::thread;
use std::time::Duration;

/// Follows a board; the address to which its telemetry has to go.
fn following(bench: &Bench) -> String {
    let started = bench.post("/api/live/start", &json!({"listen": "127.0.0.1:0"}));
    assert_eq!(started.status, 200, "{}", started.json());
    started.json()["listen"].as_str().unwrap().to_owned()
}

/// A board that sends some cycles again and again, until the test ends.
fn sends(address: String) {
    thread::spawn(move || {
        let socket = UdpSocket::bind("127.0.0.1:0").unwrap();
        let mut board = Board::boot(7);
        for round in 0..3000 {
            let mut datagrams = board.announces(settings(100.0));
            datagrams.extend(board.runs(round * 10..round * 10 + 10));
            for datagram in datagrams {
                let _ = socket.send_to(&datagram, &address);
            }
            thread::sleep(Duration::from_millis(40));
        }
    });
}

/// Its port is free at once, although no datagram came that would have woken it.
#[test]
fn a_view_that_is_stopped_can_be_started_again() {
    let bench = Bench::start(&scratch("workbench_live_again"));
    let address = following(&bench);
    for _ in 0..2 {
        let again = bench.post("/api/live/start", &json!({"listen": address}));
        assert_eq!(again.status, 200, "{}", again.json());
        assert_eq!(bench.post("/api/live/stop", &json!({})).status, 204);
    }
    assert!(UdpSocket::bind(&address).is_ok());
}

#[test]
fn what_a_board_sends_comes_as_frames() {
    let bench = Bench::start(&scratch("workbench_live"));
    sends(following(&bench));
    let heard = bench.hear("/api/live", |heard| {
        heard.matches("event: frame").count() > 10
    });
    let frames = heard.lines().filter_map(|line| line.strip_prefix("data: "));
    let frames: Vec<Value> = frames
        .filter_map(|data| serde_json::from_str(data).ok())
        .collect();
    let with_cycles = frames.iter().find(|frame| frame["time_s"][0].is_number());
    let frame = with_cycles.unwrap_or_else(|| panic!("{heard}"));
    assert_eq!(
        (&frame["mode"], &frame["losses"][2]),
        (&json!("Idle"), &json!(0))
    );
    assert!(
        frames.iter().any(|frame| frame["firmware"] == IDENTITY),
        "{heard}"
    );
    assert_eq!(
        bench.get("/api/session").json()["live"]
            .as_str()
            .map(|a| &a[..10]),
        Some("127.0.0.1:")
    );
    assert_eq!(bench.post("/api/live/stop", &json!({})).status, 204);
    assert_eq!(bench.get("/api/session").json()["live"], Value::Null);
}

#[test]
fn a_running_board_is_drawn() {
    let bench = Bench::start(&scratch("workbench_live_page"));
    sends(following(&bench));
    let mut browser = Browser::start("workbench_live_chromium");
    browser.visit(&format!("http://{}/", bench.host()));
    browser.until("document.querySelector('#live-state .mode')?.dataset.mode == 'Idle'");
    browser.until("document.querySelectorAll('#live-plots canvas').length == 2");
    browser.keep_pictures("workbench-live");
    assert_eq!(browser.look().console, Vec::<String>::new());
}
