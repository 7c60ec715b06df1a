//! Datagrams through a real socket.

use super::board::{Bench, Board, cycles, settings};
use softdock_app::telemetry::Datagram;
use softdock_io::telemetry::Listener;
use std::net::{SocketAddr, UdpSocket};
use std::time::Duration;

/// It only keeps a broken test from hanging.
const PATIENCE: Duration = Duration::from_secs(60);
/// A quarter of a second of cycles at once, as after a pause of the network.
const BURST: u64 = 64;

fn local() -> SocketAddr {
    "127.0.0.1:0".parse().unwrap()
}

fn send(socket: &UdpSocket, to: SocketAddr, datagrams: &[Datagram]) {
    for datagram in datagrams {
        socket.send_to(datagram, to).unwrap();
    }
}

#[test]
fn bursts_are_recorded_without_a_loss() {
    let (mut board, mut bench) = (Board::boot(7), Bench::new());
    let (listener, socket) = (
        Listener::bind(local()).unwrap(),
        UdpSocket::bind(local()).unwrap(),
    );
    send(
        &socket,
        listener.address(),
        &board.announces(settings(100.0)),
    );
    for burst in 0..20 {
        let datagrams = board.runs(burst * BURST..(burst + 1) * BURST);
        send(&socket, listener.address(), &datagrams);
        for _ in &datagrams {
            let (datagram, from) = listener.receive(PATIENCE).expect("nothing is lost");
            bench.recorder.accept(&datagram, from).unwrap();
        }
    }
    for (datagram, from) in listener.close() {
        bench.recorder.accept(&datagram, from).unwrap();
    }
    let (summary, recordings) = bench.finish();
    assert_eq!(cycles(&recordings[0]), (0..20 * BURST).collect::<Vec<_>>());
    assert_eq!(summary.recordings[0].lost_datagrams, 0);
}

#[test]
fn what_has_come_before_the_end_is_recorded() {
    let mut board = Board::boot(7);
    let (listener, socket) = (
        Listener::bind(local()).unwrap(),
        UdpSocket::bind(local()).unwrap(),
    );
    let sent = board.runs(0..40);
    send(&socket, listener.address(), &sent);
    assert_eq!(listener.close().count(), sent.len());
}

#[test]
fn a_datagram_that_is_too_long_shows_as_damaged() {
    let mut bench = Bench::new();
    let (listener, socket) = (
        Listener::bind(local()).unwrap(),
        UdpSocket::bind(local()).unwrap(),
    );
    let mut board = Board::boot(7);
    let mut long = board.announces(settings(100.0))[0].to_vec();
    long.resize(3000, 0);
    socket.send_to(&long, listener.address()).unwrap();
    let (datagram, from) = listener.receive(PATIENCE).unwrap();
    bench.recorder.accept(&datagram, from).unwrap();
    assert_eq!(bench.finish().0.damaged_datagrams, 1);
}

#[test]
fn an_address_in_use_is_an_error_that_says_so() {
    let first = Listener::bind(local()).unwrap();
    let error = Listener::bind(first.address()).unwrap_err().to_string();
    let expected = format!("UDP {}; is another recorder running", first.address());
    assert!(error.contains(&expected), "{error}");
}
